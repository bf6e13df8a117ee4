// Binds the orientation filter to Python; see motorcade.fusion.orientation. Settings come checked.
// The interpreter lock is released for whole streams, not for single samples.

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/optional.h>

#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "backward.h"
#include "filter.h"

namespace nb = nanobind;
using namespace nb::literals;
using namespace motorcade::orientation;
using motorcade::Four;
using motorcade::Three;

namespace {

using Triple = nb::ndarray<const double, nb::shape<3>, nb::device::cpu>;
using Vectors = nb::ndarray<const double, nb::shape<-1, 3>, nb::c_contig, nb::device::cpu>;
using Stamps = nb::ndarray<const std::int64_t, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using MadeRotor = nb::ndarray<double, nb::shape<4>, nb::c_contig, nb::device::cpu>;
using MadeRotors = nb::ndarray<double, nb::shape<-1, 4>, nb::c_contig, nb::device::cpu>;
using MadeVectors = nb::ndarray<double, nb::shape<-1, 3>, nb::c_contig, nb::device::cpu>;
using MadeNumbers = nb::ndarray<double, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using MadePairs = nb::ndarray<double, nb::shape<-1, 2>, nb::c_contig, nb::device::cpu>;
using MadeFlags = nb::ndarray<bool, nb::ndim<1>, nb::c_contig, nb::device::cpu>;

Three finite(const Triple &given, const char *name) {
    Three made;
    for (std::size_t i = 0; i < 3; ++i) {
        made[i] = given(i);
        if (!std::isfinite(made[i]))
            throw std::invalid_argument(std::string(name) + ": expected finite numbers");
    }
    return made;
}

// A filter fed sample by sample.
class Stream {
public:
    explicit Stream(const Settings &settings) : filter_(settings) {}

    void update(std::int64_t time_ns, const Triple &rate, const Triple &force,
                const std::optional<Triple> &magnetic, const MadeRotor &out) {
        const Three turned = finite(rate, "angular_rate_rad_s"),
                    felt = finite(force, "specific_force_m_s2");
        const Three field = magnetic ? finite(*magnetic, "magnetic_field") : Three{};
        const Three *north = magnetic ? &field : nullptr;
        if (!begun_) {
            filter_.begin(turned, felt, north);
            begun_ = true;
        } else {
            if (time_ns <= last_ns_)
                throw std::invalid_argument("time_ns: expected a stamp after " +
                                            std::to_string(last_ns_) + ", got " +
                                            std::to_string(time_ns));
            const double dt = 1e-9 * static_cast<double>(time_ns - last_ns_);
            if (filter_.leaves_gap(dt)) filter_.correct(nullptr);
            if (filter_.propagate(turned, felt, north, dt)) filter_.correct(nullptr);
        }
        last_ns_ = time_ns;
        std::copy(filter_.rotor().begin(), filter_.rotor().end(), out.data());
    }

    const Three &bias() const { return filter_.bias(); }
    bool at_rest() const { return filter_.at_rest(); }
    double tilt_deviation() const { return filter_.tilt_deviation(); }
    double heading_deviation() const { return filter_.heading_deviation(); }
    double field_deviation() const { return filter_.field().deviation(); }

private:
    Filter filter_;
    bool begun_ = false;
    std::int64_t last_ns_ = 0;
};

struct Readings {
    const Three *rates, *forces, *fields;  // fields where there is a magnetometer
    const std::int64_t *time_ns;
    std::size_t count;

    // The field of a sample; none where the magnetometer did not read then.
    const Three *field(std::size_t k) const {
        if (!fields || std::isnan(fields[k][0])) return nullptr;
        return fields + k;
    }
};

struct Made {
    double *rotors, *biases, *deviations, *disturbances;
    bool *rest;

    void put(std::size_t k, const Four &rotor, const Three &bias) const {
        std::copy(rotor.begin(), rotor.end(), rotors + 4 * k);
        std::copy(bias.begin(), bias.end(), biases + 3 * k);
    }

    void put_deviations(std::size_t k, double tilt, double heading) const {
        deviations[2 * k] = tilt;
        deviations[2 * k + 1] = heading;
    }
};

// A whole stream forwards. With nodes it keeps them for the pass backwards, and what it puts out is
// then each sample before the correction that it may bring. The first heading is turned by an
// angle.
void forward(Filter &filter, const Readings &given, const Made &made, std::vector<Node> *nodes,
             double heading = 0.0) {
    const auto correct = [&](std::size_t end) {
        if (nodes) nodes->emplace_back().end = end;
        filter.correct(nodes ? &nodes->back() : nullptr);
    };
    for (std::size_t k = 0; k < given.count; ++k) {
        if (k == 0) {
            filter.begin(given.rates[0], given.forces[0], given.field(0));
            filter.face(heading);
            made.put(0, filter.rotor(), filter.bias());
        } else {
            const double dt = 1e-9 * static_cast<double>(given.time_ns[k] - given.time_ns[k - 1]);
            if (filter.leaves_gap(dt)) correct(k - 1);
            const bool full = filter.propagate(given.rates[k], given.forces[k], given.field(k), dt);
            if (nodes) made.put(k, filter.rotor(), filter.bias());
            if (full || (nodes && k + 1 == given.count && filter.gathered())) correct(k);
            if (!nodes) made.put(k, filter.rotor(), filter.bias());
        }
        made.put_deviations(k, filter.tilt_deviation(), filter.heading_deviation());
        made.disturbances[k] = filter.field().deviation();
        made.rest[k] = filter.at_rest();
    }
}

// Adds to every sample what all later measurements say, along a line from node to node.
void add_corrections(const Made &made, const std::vector<Node> &nodes, const Settings &settings) {
    std::vector<Later> later(nodes.size());
    Backward backward(settings);
    for (std::size_t m = nodes.size(); m-- > 0;) later[m] = backward.pass(nodes[m]);
    std::size_t k = 0;
    for (std::size_t m = 0; m < nodes.size(); ++m) {
        const Node &node = nodes[m];
        const std::size_t first = k;
        for (; k <= node.end; ++k) {
            const double place =
                static_cast<double>(k + 1 - first) / static_cast<double>(node.end + 1 - first);
            State error;
            for (std::size_t i = 0; i < ERRORS; ++i) {
                const double end = node.added[i] + later[m].error[i];
                const double start = m == 0 ? end : later[m - 1].error[i];
                error[i] = start + place * (end - start);
            }
            Four rotor;
            std::copy_n(made.rotors + 4 * k, 4, rotor.begin());
            Three bias;
            for (std::size_t i = 0; i < 3; ++i) bias[i] = made.biases[3 * k + i] + error[BIAS + i];
            made.put(k, motorcade::versors::compose(Filter::turn_of(error), rotor), bias);
            made.put_deviations(k, later[m].tilt, later[m].heading);
        }
    }
}

// The heading to start from, where the magnetometer reads later than the IMU: north, by the gyro
// until then.
double first_heading(const Settings &settings, Readings given, const Made &made) {
    std::size_t first = 0;
    while (first < given.count && !given.field(first)) ++first;
    if (!given.fields || first == 0 || first == given.count) return 0.0;
    const Three field = *given.field(first);
    given.fields = nullptr;
    given.count = first + 1;
    Filter filter(settings);
    forward(filter, given, made, nullptr);
    return filter.north_of(field);
}

// Gives the lag of the magnetometer, s.
double run(const Settings &settings, const Vectors &rates, const Vectors &forces,
           const std::optional<Vectors> &fields, const Stamps &time_ns, bool backward,
           const MadeRotors &rotors, const MadeVectors &biases, const MadePairs &deviations,
           const MadeNumbers &disturbances, const MadeFlags &rest) {
    const std::size_t count = time_ns.shape(0);
    for (const std::size_t rows :
         {rates.shape(0), forces.shape(0), fields ? fields->shape(0) : count, rotors.shape(0),
          biases.shape(0), deviations.shape(0), disturbances.shape(0), rest.shape(0)})
        if (rows != count || count == 0)
            throw std::invalid_argument("run: expected arrays of equal length");
    const Made made{rotors.data(), biases.data(), deviations.data(), disturbances.data(),
                    rest.data()};
    const Readings given{reinterpret_cast<const Three *>(rates.data()),
                         reinterpret_cast<const Three *>(forces.data()),
                         fields ? reinterpret_cast<const Three *>(fields->data()) : nullptr,
                         time_ns.data(), count};
    nb::gil_scoped_release unlocked;
    Filter filter(settings);
    std::vector<Node> nodes;
    const double heading = backward ? first_heading(settings, given, made) : 0.0;
    if (backward && given.fields) filter.expect_field();
    forward(filter, given, made, backward ? &nodes : nullptr, heading);
    if (!backward) return filter.field().lag();
    if (filter.field().recovered()) {  // it began in a disturbed place: once more, knowing that
        Filter again(settings);
        again.expect_field();
        again.take_reference(filter.field());
        nodes.clear();
        forward(again, given, made, &nodes, heading);
    }
    add_corrections(made, nodes, settings);
    return filter.field().lag();
}

}  // namespace

NB_MODULE(_orientation, module) {
    module.doc() = "Orientation from inertial readings; see motorcade.fusion.orientation.";
    nb::class_<Settings>(module, "Settings")
        .def(
            "__init__",
            [](Settings *made, double gyro_density, double gyro_walk, double accel_density,
               double gyro_matrix, double gyro_wander, double first_bias, double first_tilt,
               double speed, double speed_time, double gravity, double interval, double rest_rate,
               double rest_force, double rest_after, double disturbance, double disturbance_time,
               bool averaged) {
                new (made)
                    Settings{gyro_density,     gyro_walk,  accel_density, gyro_matrix, gyro_wander,
                             first_bias,       first_tilt, speed,         speed_time,  gravity,
                             interval,         rest_rate,  rest_force,    rest_after,  disturbance,
                             disturbance_time, averaged};
            },
            nb::kw_only(), "gyro_density"_a, "gyro_walk"_a, "accel_density"_a, "gyro_matrix"_a,
            "gyro_wander"_a, "first_bias"_a, "first_tilt"_a, "speed"_a, "speed_time"_a, "gravity"_a,
            "interval"_a, "rest_rate"_a, "rest_force"_a, "rest_after"_a, "disturbance"_a,
            "disturbance_time"_a, "averaged"_a);
    nb::class_<Stream>(module, "Stream")
        .def(nb::init<const Settings &>(), "settings"_a)
        .def("update", &Stream::update, "time_ns"_a, "rate"_a, "force"_a, "field"_a.none(), "out"_a)
        .def_prop_ro("bias", &Stream::bias)
        .def_prop_ro("at_rest", &Stream::at_rest)
        .def_prop_ro("tilt_deviation", &Stream::tilt_deviation)
        .def_prop_ro("heading_deviation", &Stream::heading_deviation)
        .def_prop_ro("field_deviation", &Stream::field_deviation);
    module.def("run", &run, "settings"_a, "rates"_a, "forces"_a, "fields"_a.none(), "time_ns"_a,
               "backward"_a, "rotors"_a, "biases"_a, "deviations"_a, "disturbances"_a, "rest"_a);
}
