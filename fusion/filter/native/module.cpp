// Binds the filter to Python. Arrays come checked and C-ordered; see motorcade.fusion.filter.

#include <nanobind/nanobind.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/unique_ptr.h>

#if defined(__GLIBC__)
#include <malloc.h>
#endif

#include <memory>
#include <optional>

#include "increments.h"
#include "python_source.h"
#include "rest.h"
#include "window.h"

namespace nb = nanobind;
using namespace nb::literals;
using namespace motorcade::filter;

namespace {

// A row of three doubles, held while it is read; faster than nanobind's ndarray.
class Three {
public:
    Three(nb::handle given, const char *name) {
        if (PyObject_GetBuffer(given.ptr(), &view_, PyBUF_STRIDES | PyBUF_FORMAT) != 0)
            throw nb::python_error();
        if (view_.ndim == 1 && view_.shape[0] == 3 && view_.format[0] == 'd' &&
            view_.format[1] == '\0')
            return;
        PyBuffer_Release(&view_);
        throw std::invalid_argument(std::string(name) + ": expected three numbers of float64");
    }
    Three(const Three &) = delete;
    Three &operator=(const Three &) = delete;
    ~Three() { PyBuffer_Release(&view_); }
    void read(double *to) const {
        for (Py_ssize_t k = 0; k < 3; ++k)
            to[k] = *reinterpret_cast<const double *>(static_cast<const char *>(view_.buf) +
                                                      view_.strides[0] * k);
    }

private:
    Py_buffer view_{};
};

constexpr std::size_t many_events = 10'000;  // some megabytes

// The filter with or without the states that most runs know. Python frees it by this class, so that
// it must have the alignment of the matrices inside.
class alignas(64) Engine {
public:
    // What many events held lies in small pieces, which the C library keeps unless it is asked.
    virtual ~Engine() {
#if defined(__GLIBC__)
        if (many_) malloc_trim(0);
#endif
    }
    virtual void imu(std::int64_t time_ns, nb::handle rate, nb::handle force) = 0;
    virtual void samples(const Stamps &time_ns, const Rows &rate, const Rows &force) = 0;
    virtual void hold(const Stamps &time_ns, const Rows &rate, const Rows &force) = 0;
    virtual void play() = 0;
    virtual void add(int kind, std::int64_t time_ns, std::size_t number, const Flat &data,
                     const nb::object &predict, std::int64_t source) = 0;
    virtual void schedule(int kind, const Stamps &time_ns, const Rows &data,
                          const std::optional<Rows> &noise, const std::optional<Stamps> &numbers,
                          const nb::object &predict, std::int64_t source) = 0;
    virtual void outputs(const Stamps &time_ns, const Made &pose, const Made &velocity,
                         const Made &bias, const MadeCubes &covariance, const Made &others,
                         const std::optional<MadeCubes> &whole, bool final) = 0;
    virtual void smooth() = 0;
    virtual nb::object state() const = 0;
    virtual nb::object state_at(std::int64_t time_ns) = 0;
    virtual nb::object judged() const = 0;
    virtual nb::tuple held() const = 0;
    virtual nb::tuple doubted() const = 0;

protected:
    bool many_ = false;
};

template <std::size_t N> class EngineOf final : public Engine {
public:
    EngineOf(const Settings &settings, const State &first, const Rest &rest)
        : filter_(settings, first), rest_(rest), gravity_(settings.gravity_m_s2) {}

    void imu(std::int64_t time_ns, nb::handle rate, nb::handle force) override {
        const Three given_rate(rate, "gyro"), given_force(force, "accel");
        Sample sample;
        sample.time_ns = time_ns;
        given_rate.read(sample.read.rate);
        given_force.read(sample.read.force);
        one(sample);
    }

    void samples(const Stamps &time_ns, const Rows &rate, const Rows &force) override {
        expect_columns(time_ns, rate, force);
        nb::gil_scoped_release unlocked;
        for (std::size_t k = 0; k < time_ns.shape(0); ++k) {
            Sample sample;
            sample.time_ns = time_ns.data()[k];
            std::copy_n(rate.data() + 3 * k, 3, sample.read.rate);
            std::copy_n(force.data() + 3 * k, 3, sample.read.force);
            one(sample);
        }
    }

    void hold(const Stamps &time_ns, const Rows &rate, const Rows &force) override {
        expect_columns(time_ns, rate, force);
        expect(time_ns.shape(0) > 0, "imu: expected at least one sample");
        held_time_ = time_ns, held_rate_ = rate, held_force_ = force;
        filter_.hold(time_ns.data(), rate.data(), force.data(), time_ns.shape(0));
    }

    void play() override {
        nb::gil_scoped_release unlocked;
        while (filter_.play(rest_.wanted()))
            if (rest_.wanted()) rest(filter_.samples().back());
    }

    void add(int kind, std::int64_t time_ns, std::size_t number, const Flat &data,
             const nb::object &predict, std::int64_t source) override {
        Event event;
        if (!predict.is_none()) event.source = std::make_shared<Python>(predict, source);
        event.kind = static_cast<Kind>(kind);
        event.stamp_ns = time_ns;
        event.number = number;
        event.take(data.data(), data.shape(0));
        filter_.add(std::move(event));
    }

    void schedule(int kind, const Stamps &time_ns, const Rows &data,
                  const std::optional<Rows> &noise, const std::optional<Stamps> &numbers,
                  const nb::object &predict, std::int64_t number) override {
        const std::size_t count = time_ns.shape(0);
        expect(data.shape(0) == count && (!noise || noise->shape(0) == count) &&
                   (!numbers || numbers->shape(0) == count),
               "schedule: expected a row a stamp");
        std::shared_ptr<const Source> source;
        if (!predict.is_none()) source = std::make_shared<Python>(predict, number);
        many_ |= count >= many_events;
        held_data_.push_back(data);
        if (noise) held_data_.push_back(*noise);
        filter_.schedule(count, [&](std::size_t k) {
            Event event;
            event.kind = static_cast<Kind>(kind);
            event.stamp_ns = time_ns.data()[k];
            event.number = numbers ? static_cast<std::size_t>(numbers->data()[k]) : k;
            event.source = source;
            event.data = data.data() + k * data.shape(1);
            event.count = static_cast<std::uint32_t>(data.shape(1));
            if (noise) event.noise = noise->data() + k * noise->shape(1);
            return event;
        });
    }

    void outputs(const Stamps &time_ns, const Made &pose, const Made &velocity, const Made &bias,
                 const MadeCubes &covariance, const Made &others,
                 const std::optional<MadeCubes> &whole, bool final) override {
        const std::size_t count = time_ns.shape(0);
        expect(pose.shape(0) == count && pose.shape(1) == 8 && velocity.shape(0) == count &&
                   velocity.shape(1) == 3 && bias.shape(0) == count && bias.shape(1) == 6 &&
                   covariance.shape(0) == count && covariance.shape(1) == 6 &&
                   covariance.shape(2) == 6 && others.shape(0) == count && others.shape(1) == 13 &&
                   (!whole || (whole->shape(0) == count && whole->shape(1) <= N &&
                               whole->shape(2) == whole->shape(1))),
               "outputs: expected arrays of one row a stamp");
        filter_.sink = {pose.data(),
                        velocity.data(),
                        bias.data(),
                        covariance.data(),
                        others.data(),
                        whole ? whole->data() : nullptr,
                        whole ? whole->shape(1) : 0,
                        final};
        filter_.schedule(count, [&](std::size_t k) {
            Event event;
            event.kind = Kind::output;
            event.stamp_ns = time_ns.data()[k];
            event.number = k;
            return event;
        });
    }

    void smooth() override {
        nb::gil_scoped_release unlocked;
        filter_.smooth();
    }

    nb::object state() const override {
        if (!filter_.started()) return nb::none();
        return told(filter_.time_ns(), filter_.state(), filter_.covariance());
    }

    nb::object state_at(std::int64_t time_ns) override {
        if (!filter_.started() || time_ns > filter_.time_ns()) return nb::none();
        const auto found = filter_.at(time_ns);
        return found ? told(found->time_ns, found->at, found->covariance) : nb::none();
    }

    nb::object judged() const override {
        std::vector<std::int64_t> whole;
        std::vector<double> real;
        const auto told = [](const Event &event) { return event.measures() && event.judged; };
        const std::deque<Event> &all = filter_.events();
        const auto each = static_cast<std::size_t>(std::count_if(all.begin(), all.end(), told));
        whole.reserve(5 * each), real.reserve(4 * each);
        for (const Event &event : all) {
            if (!told(event)) continue;
            whole.insert(whole.end(), {event.stamp_ns, static_cast<std::int64_t>(event.number),
                                       static_cast<std::int64_t>(event.kind),
                                       static_cast<std::int64_t>(event.size),
                                       event.source ? event.source->number : -1});
            real.insert(real.end(), {event.nis, event.factor, event.live_nis, event.live_factor});
        }
        const std::size_t count = whole.size() / 5;
        return nb::make_tuple(array(whole, {count, 5}), array(real, {count, 4}));
    }

    nb::tuple held() const override {
        return nb::make_tuple(filter_.samples().size(), filter_.events().size());
    }

    nb::tuple doubted() const override {
        std::vector<std::int64_t> spans;
        for (const auto &span : filter_.given_up())
            spans.insert(spans.end(), span.begin(), span.end());
        const auto since = filter_.contradicted_since();
        return nb::make_tuple(array(spans, {spans.size() / 2, 2}),
                              since ? nb::cast(*since) : nb::none());
    }

private:
    static nb::object told(std::int64_t time_ns, const State &at, const Matrix<N> &spread) {
        std::vector<double> covariance;
        for (std::size_t i = 0; i < N; ++i)
            covariance.insert(covariance.end(), spread.row[i], spread.row[i] + N);
        const auto of = [](const double *given, std::size_t n) {
            return array(std::vector<double>(given, given + n), {n});
        };
        return nb::make_tuple(time_ns, of(at.pose, 8), of(at.velocity, 3), of(at.bias, 6),
                              of(at.gravity_rotor, 4), of(at.imu_T_camera, 8), at.delay_s,
                              array(covariance, {N, N}));
    }

    static void expect_columns(const Stamps &time_ns, const Rows &rate, const Rows &force) {
        expect(rate.shape(1) == 3 && force.shape(1) == 3 && rate.shape(0) == time_ns.shape(0) &&
                   force.shape(0) == time_ns.shape(0),
               "imu: expected stamps (N,), rates and forces (N, 3)");
    }

    void one(const Sample &sample) {
        filter_.imu(sample);
        rest(sample);
    }

    // Where the sensor rests, that is a measurement.
    void rest(const Sample &sample) {
        if (!rest_.wanted() || !filter_.started()) return;
        if (!rest_.found(sample, filter_.state(), gravity_)) return;
        Event still;
        still.kind = Kind::velocity;
        still.stamp_ns = sample.time_ns;
        still.number = Rest::number;
        still.take(rest_.measurement().data(), 12);
        filter_.add(std::move(still));
    }

    Filter<N> filter_;
    Rest rest_;
    double gravity_;
    Stamps held_time_;
    Rows held_rate_, held_force_;
    std::vector<Rows> held_data_;  // of what is scheduled
};

std::unique_ptr<Engine>
engine(const std::array<double, 5> &model, const std::array<double, 6> &start,
       const std::array<double, 4> &known, const std::array<double, widest + 1> &gate,
       const std::array<double, widest + 1> &middle, double most_noise,
       const std::array<double, 3> &gap, double history_s, double lag_s, std::size_t check_every,
       const std::array<double, 8> &imu_T_camera, double delay_s, const std::array<double, 5> &rest,
       bool keeps_earlier) {
    const auto square = [](double x) { return x * x; };
    Settings made;
    made.gravity_m_s2 = model[0];
    made.noise = {square(model[1]), square(model[3]), square(model[2]), square(model[4])};
    std::copy_n(start.begin(), 5, made.start_sigma.begin());
    made.start_tilt_rad = start[5];
    made.known_sigma = known;
    made.gate = gate;
    made.middle = middle;
    made.most_noise = most_noise;
    made.gap_ns = static_cast<std::int64_t>(gap[0] * 1e9);
    made.gap_rate = gap[1];
    made.gap_force = gap[2];
    made.history_ns = history_s < 1e9 ? static_cast<std::int64_t>(history_s * 1e9) : INT64_MAX / 2;
    made.lag_ns = lag_s < 1e9 ? static_cast<std::int64_t>(lag_s * 1e9) : INT64_MAX / 2;
    made.check_every = check_every;
    State first;
    std::copy(imu_T_camera.begin(), imu_T_camera.end(), first.imu_T_camera);
    first.delay_s = delay_s;
    if (keeps_earlier) return std::make_unique<EngineOf<30>>(made, first, Rest(rest));
    const bool more = known[0] > 0.0 || known[1] > 0.0 || known[2] > 0.0 || known[3] > 0.0;
    if (more) return std::make_unique<EngineOf<24>>(made, first, Rest(rest));
    return std::make_unique<EngineOf<15>>(made, first, Rest(rest));
}

using Squares =
    std::array<double, 4>;  // of the densities of rate and force and of their biases' walks

// Sums of steps that follow each other within intervals; `first` has the first step of each.
template <bool held>
void increments(const Stamps &first, const Flat &dt_s, const Rows &rate, const Rows &force,
                const Rows &bias, const Squares &squares, const Made &pose, const Made &velocity,
                const MadeCubes &transition, const MadeCubes &covariance) {
    const std::size_t steps = dt_s.shape(0), count = first.shape(0);
    const auto wide = [&](const auto &given, std::size_t rows, std::size_t width) {
        return given.shape(0) == rows && given.shape(1) == width;
    };
    expect(wide(rate, steps, 3) && wide(force, steps, 3) && wide(bias, steps, 6) &&
               wide(pose, count, 8) && wide(velocity, count, 3) && wide(transition, count, 15) &&
               transition.shape(2) == 15 && wide(covariance, count, 15) &&
               covariance.shape(2) == 15,
           "increments: expected arrays of one row a step, and of one row an interval");
    const Densities noise{squares[0], squares[1], squares[2], squares[3]};
    nb::gil_scoped_release unlocked;
    for (std::size_t k = 0; k < count; ++k) {
        Increment sum;
        const auto begin = static_cast<std::size_t>(first.data()[k]);
        const auto end = k + 1 < count ? static_cast<std::size_t>(first.data()[k + 1]) : steps;
        for (std::size_t step = begin; step < end && step < steps; ++step) {
            Reading read;
            std::copy_n(rate.data() + 3 * step, 3, read.rate);
            std::copy_n(force.data() + 3 * step, 3, read.force);
            extend<held>(sum, read, bias.data() + 6 * step, dt_s.data()[step], noise);
        }
        std::copy_n(sum.state.pose, 8, pose.data() + 8 * k);
        std::copy_n(sum.state.velocity, 3, velocity.data() + 3 * k);
        for (std::size_t i = 0; i < 15; ++i) {
            std::copy_n(sum.transition.row[i], 15, transition.data() + 225 * k + 15 * i);
            std::copy_n(sum.covariance.row[i], 15, covariance.data() + 225 * k + 15 * i);
        }
    }
}

void noises(const Flat &dt_s, const Squares &squares, const MadeCubes &made) {
    expect(made.shape(0) == dt_s.shape(0) && made.shape(1) == 15 && made.shape(2) == 15,
           "process_noise: expected a matrix (15, 15) an interval");
    const Densities noise{squares[0], squares[1], squares[2], squares[3]};
    for (std::size_t k = 0; k < dt_s.shape(0); ++k)
        process_noise(noise, dt_s.data()[k], made.data() + 225 * k);
}

}  // namespace

NB_MODULE(_filter, module) {
    module.doc() = "The pose filter; see motorcade.fusion.filter.";
    nb::class_<Engine>(module, "Engine")
        .def("imu", &Engine::imu, "time_ns"_a, "gyro"_a, "accel"_a)
        .def("samples", &Engine::samples, "time_ns"_a, "gyro"_a, "accel"_a)
        .def("hold", &Engine::hold, "time_ns"_a, "gyro"_a, "accel"_a)
        .def("play", &Engine::play)
        .def("add", &Engine::add, "kind"_a, "time_ns"_a, "number"_a, "data"_a, "predict"_a.none(),
             "source"_a)
        .def("schedule", &Engine::schedule, "kind"_a, "time_ns"_a, "data"_a, "noise"_a.none(),
             "numbers"_a.none(), "predict"_a.none(), "source"_a)
        .def("outputs", &Engine::outputs, "time_ns"_a, "pose"_a, "velocity"_a, "bias"_a,
             "covariance"_a, "others"_a, "whole"_a.none(), "final"_a)
        .def("smooth", &Engine::smooth)
        .def("state", &Engine::state)
        .def("state_at", &Engine::state_at, "time_ns"_a)
        .def("judged", &Engine::judged)
        .def("doubted", &Engine::doubted)
        .def("held", &Engine::held);
    module.def("engine", &engine, "model"_a, "start"_a, "known"_a, "gate"_a, "middle"_a,
               "most_noise"_a, "gap"_a, "history_s"_a, "lag_s"_a, "check_every"_a, "imu_T_camera"_a,
               "delay_s"_a, "rest"_a, "keeps_earlier"_a);
    module.def("increments", &increments<false>, "first"_a, "dt_s"_a, "rate"_a, "force"_a, "bias"_a,
               "squares"_a, "pose"_a, "velocity"_a, "transition"_a, "covariance"_a);
    module.def("held_increments", &increments<true>, "first"_a, "dt_s"_a, "rate"_a, "force"_a,
               "bias"_a, "squares"_a, "pose"_a, "velocity"_a, "transition"_a, "covariance"_a);
    module.def("process_noise", &noises, "dt_s"_a, "squares"_a, "made"_a);
}
