// Binds the scans to Python. Arrays come checked and C-ordered; see
// motorcade.fusion.smoothing.causal. The interpreter lock is released for whole paths, not for
// single poses.

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/unique_ptr.h>

#include "scan.h"

namespace nb = nanobind;
using namespace nb::literals;
using namespace motorcade::smooth;
using motorcade::Vector;

namespace {

using Rows = nb::ndarray<const double, nb::ndim<2>, nb::c_contig, nb::device::cpu>;
using Made = nb::ndarray<double, nb::ndim<2>, nb::c_contig, nb::device::cpu>;
using MadeCubes = nb::ndarray<double, nb::ndim<3>, nb::c_contig, nb::device::cpu>;
using Stamps = nb::ndarray<const std::int64_t, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using Owner = std::unique_ptr<Scan>;

// A buffer of one row, held while it is read or written; faster than nanobind's ndarray.
class Row {
public:
    Row(nb::handle given, std::size_t size, int flags) {
        if (PyObject_GetBuffer(given.ptr(), &view_, PyBUF_STRIDES | PyBUF_FORMAT | flags) != 0)
            throw nb::python_error();
        if (view_.ndim == 1 && view_.shape[0] == static_cast<Py_ssize_t>(size)) return;
        PyBuffer_Release(&view_);
        throw std::invalid_argument("pose: expected one pose of " + std::to_string(size) +
                                    " coefficients");
    }
    Row(const Row &) = delete;
    Row &operator=(const Row &) = delete;
    ~Row() { PyBuffer_Release(&view_); }

    template <class T> T *at(std::size_t k) const {
        return reinterpret_cast<T *>(static_cast<char *>(view_.buf) +
                                     view_.strides[0] * static_cast<Py_ssize_t>(k));
    }
    bool holds(char type) const { return view_.format[0] == type && view_.format[1] == '\0'; }

private:
    Py_buffer view_{};
};

std::int64_t stamp(nb::handle given) {
    if (!PyIndex_Check(given.ptr())) {
        const std::string type = nb::cast<std::string>(nb::type_name(given.type()));
        throw std::invalid_argument("time_ns: expected integer nanoseconds, got " + type);
    }
    const nb::object number = nb::steal(PyNumber_Index(given.ptr()));
    const std::int64_t made = PyLong_AsLongLong(number.ptr());
    if (made == -1 && PyErr_Occurred()) throw nb::python_error();
    return made;
}

// One pose, of float64 or float32 at any stride, to one of contiguous float64.
void update(Scan &scan, nb::handle pose, nb::handle time_ns, nb::handle out) {
    const std::size_t size = scan.pose_size();
    const Row given(pose, size, 0), made(out, size, PyBUF_WRITABLE);
    if (!made.holds('d') || !(given.holds('d') || given.holds('f')))
        throw std::invalid_argument("pose: expected float64 or float32");
    std::array<double, 12> read;
    for (std::size_t k = 0; k < size; ++k)
        read[k] = given.holds('d') ? *given.at<double>(k) : *given.at<float>(k);
    scan.update(read.data(), stamp(time_ns), made.at<double>(0));
}

void expect(bool holds, const char *what) {
    if (!holds) throw std::invalid_argument(what);
}

NoiseRows noise_rows(const Rows &noise, std::size_t count) {
    expect(noise.shape(1) == 3 && (noise.shape(0) == 1 || noise.shape(0) == count),
           "noise: expected an array (1, 3) or (N, 3)");
    return {noise.data(), noise.shape(0) == 1 ? 0U : 3U};
}

// Feeds a whole path; without rows of noise the filter keeps its own.
void run(Scan &scan, const Rows &poses, const Stamps &time_ns, const Made &out,
         const std::optional<Rows> &noise) {
    const std::size_t count = poses.shape(0), size = scan.pose_size();
    expect(poses.shape(1) == size && time_ns.shape(0) == count && out.shape(0) == count &&
               out.shape(1) == size,
           "scan: expected poses, stamps and output of equal length");
    const NoiseRows rows = noise ? noise_rows(*noise, count) : NoiseRows{};
    nb::gil_scoped_release unlocked;
    for (std::size_t k = 0; k < count; ++k) {
        if (noise) scan.measured_with(rows.row(k));
        scan.update(poses.data() + k * size, time_ns.data()[k], out.data() + k * size);
    }
}

Owner exponential(const std::string &name, bool scale, double cutoff_hz) {
    return with_representation(name, scale, [&]<class R>() -> Owner {
        return std::make_unique<StreamOf<R, Exponential<R>>>(Exponential<R>(cutoff_hz));
    });
}

Owner double_exponential(const std::string &name, bool scale, double cutoff_hz,
                         double trend_cutoff_hz) {
    return with_representation(name, scale, [&]<class R>() -> Owner {
        using Method = DoubleExponential<R>;
        return std::make_unique<StreamOf<R, Method>>(Method(cutoff_hz, trend_cutoff_hz));
    });
}

Owner one_euro(const std::string &name, bool scale, double min_cutoff_hz, const BlockValues &slopes,
               double derivative_cutoff_hz) {
    return with_representation(name, scale, [&]<class R>() -> Owner {
        using Method = OneEuro<R>;
        return std::make_unique<StreamOf<R, Method>>(
            Method({min_cutoff_hz, slopes, derivative_cutoff_hz}));
    });
}

Owner kalman(const std::string &name, bool scale, int order, const BlockValues &densities,
             const BlockValues &deviations) {
    expect(order == 1 || order == 2, "order: expected 1 or 2");
    return with_representation(name, scale, [&]<class R>() -> Owner {
        if (order == 1)
            return std::make_unique<StreamOf<R, Kalman<R, 1>>>(Kalman<R, 1>(densities, deviations));
        return std::make_unique<StreamOf<R, Kalman<R, 2>>>(Kalman<R, 2>(densities, deviations));
    });
}

double rts(const std::string &name, bool scale, int order, const Rows &poses, const Stamps &time_ns,
           const Rows &noise, const BlockValues &densities, const Made &out,
           const std::optional<std::pair<MadeCubes, MadeCubes>> &states) {
    const std::size_t count = poses.shape(0);
    expect(order == 1 || order == 2, "order: expected 1 or 2");
    return with_representation(name, scale, [&]<class R>() {
        expect(count > 0 && time_ns.shape(0) == count && poses.shape(1) == R::pose_size &&
                   out.shape(0) == count && out.shape(1) == R::pose_size,
               "rts: expected poses, stamps and output of equal length");
        Smoothed made{out.data(), nullptr, nullptr};
        if (states) {
            const auto &[rates, deviations] = *states;
            const auto derivatives = static_cast<std::size_t>(order);
            expect(rates.shape(0) == count && rates.shape(1) == derivatives &&
                       rates.shape(2) == R::freedom,
                   "states: expected rates (N, order, d)");
            expect(deviations.shape(0) == count && deviations.shape(1) == R::ends.size() &&
                       deviations.shape(2) == derivatives + 1,
                   "states: expected deviations (N, blocks, order + 1)");
            made.rates = rates.data();
            made.deviations = deviations.data();
        }
        const NoiseRows rows = noise_rows(noise, count);
        nb::gil_scoped_release unlocked;
        return order == 1
                   ? smooth<R, 1>(poses.data(), time_ns.data(), count, rows, densities, made)
                   : smooth<R, 2>(poses.data(), time_ns.data(), count, rows, densities, made);
    });
}

// Where the blocks of a local vector end, their units, and how many components are coupled.
nb::tuple layout(const std::string &name, bool scale) {
    return with_representation(
        name, scale, []<class R>() { return nb::make_tuple(R::ends, R::units, R::coupled); });
}

// The verbs of a representation, row by row: what the scans are made of.
template <std::size_t N> Vector<N> row_of(const Rows &rows, std::size_t k) {
    expect(rows.shape(1) == N, "coordinates: expected rows of the representation's size");
    Vector<N> made;
    std::copy_n(rows.data() + k * N, N, made.begin());
    return made;
}

template <std::size_t N> nb::object array_of(std::size_t count, auto &&row) {
    auto *memory = new double[std::max<std::size_t>(1, count * N)];
    nb::capsule owner(memory, [](void *data) noexcept { delete[] static_cast<double *>(data); });
    for (std::size_t k = 0; k < count; ++k) {
        const Vector<N> made = row(k);
        std::copy(made.begin(), made.end(), memory + k * N);
    }
    const std::size_t shape[2] = {count, N};
    return nb::cast(nb::ndarray<nb::numpy, double>(memory, 2, shape, owner));
}

nb::object coordinates(const std::string &name, bool scale, const Rows &poses) {
    return with_representation(name, scale, [&]<class R>() {
        Vector<R::size> last;
        return array_of<R::size>(poses.shape(0), [&](std::size_t k) {
            const auto read = R::read(row_of<R::pose_size>(poses, k));
            return last = k == 0 ? read : R::continued(read, last);
        });
    });
}

nb::object poses(const std::string &name, bool scale, const Rows &given) {
    return with_representation(name, scale, [&]<class R>() {
        return array_of<R::pose_size>(
            given.shape(0), [&](std::size_t k) { return R::write(row_of<R::size>(given, k)); });
    });
}

nb::object local(const std::string &name, bool scale, const Rows &given, const Rows &base) {
    expect(given.shape(0) == base.shape(0), "local: expected as many bases as coordinates");
    return with_representation(name, scale, [&]<class R>() {
        return array_of<R::freedom>(given.shape(0), [&](std::size_t k) {
            return R::local(row_of<R::size>(given, k), row_of<R::size>(base, k));
        });
    });
}

nb::object retract(const std::string &name, bool scale, const Rows &base, const Rows &vectors) {
    expect(vectors.shape(0) == base.shape(0), "retract: expected as many vectors as bases");
    return with_representation(name, scale, [&]<class R>() {
        return array_of<R::size>(base.shape(0), [&](std::size_t k) {
            return R::retract(row_of<R::size>(base, k), row_of<R::freedom>(vectors, k));
        });
    });
}

}  // namespace

NB_MODULE(_scans, module) {
    module.doc() = "Sequential scans over poses; see motorcade.fusion.smoothing.causal.";
    nb::class_<Scan>(module, "Scan")
        .def("update", &update, "pose"_a, "time_ns"_a, "out"_a)
        .def("run", &run, "poses"_a, "time_ns"_a, "out"_a, "noise"_a = nb::none())
        .def("measured_with", &Scan::measured_with, "deviations"_a)
        .def_prop_ro("log_likelihood", &Scan::log_likelihood);
    module.def("exponential", &exponential, "representation"_a, "scale"_a, "cutoff_hz"_a);
    module.def("double_exponential", &double_exponential, "representation"_a, "scale"_a,
               "cutoff_hz"_a, "trend_cutoff_hz"_a);
    module.def("one_euro", &one_euro, "representation"_a, "scale"_a, "min_cutoff_hz"_a, "slopes"_a,
               "derivative_cutoff_hz"_a);
    module.def("kalman", &kalman, "representation"_a, "scale"_a, "order"_a, "densities"_a,
               "deviations"_a);
    module.def("rts", &rts, "representation"_a, "scale"_a, "order"_a, "poses"_a, "time_ns"_a,
               "noise"_a, "densities"_a, "out"_a, "states"_a = nb::none());
    module.def("layout", &layout, "representation"_a, "scale"_a);
    module.def("coordinates", &coordinates, "representation"_a, "scale"_a, "poses"_a);
    module.def("poses", &poses, "representation"_a, "scale"_a, "coordinates"_a);
    module.def("local", &local, "representation"_a, "scale"_a, "coordinates"_a, "base"_a);
    module.def("retract", &retract, "representation"_a, "scale"_a, "base"_a, "vectors"_a);
}
