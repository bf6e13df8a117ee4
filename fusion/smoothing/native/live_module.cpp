// Binds the live smoother to Python; see motorcade.fusion.smoothing.live.

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <cmath>

#include "live.h"

namespace nb = nanobind;
using namespace nb::literals;
using namespace motorcade::smooth;
using motorcade::dot;
using motorcade::Four;
using motorcade::Three;

namespace {

// Numbers of a buffer of float64, or of anything that can be iterated over.
template <std::size_t N> std::array<double, N> numbers(nb::handle given, const char *name) {
    std::array<double, N> made;
    Py_buffer view;
    if (PyObject_CheckBuffer(given.ptr()) &&
        PyObject_GetBuffer(given.ptr(), &view, PyBUF_STRIDES | PyBUF_FORMAT) == 0) {
        const bool fits = view.ndim == 1 && view.shape[0] == static_cast<Py_ssize_t>(N) &&
                          view.format[0] == 'd' && view.format[1] == '\0';
        if (fits)
            for (std::size_t k = 0; k < N; ++k)
                made[k] =
                    *reinterpret_cast<const double *>(static_cast<const char *>(view.buf) +
                                                      static_cast<Py_ssize_t>(k) * view.strides[0]);
        PyBuffer_Release(&view);
        if (fits) return made;
    }
    PyErr_Clear();
    std::size_t count = 0;
    if (nb::isinstance<nb::iterable>(given))
        for (nb::handle one : nb::borrow<nb::iterable>(given)) {
            const double number = PyFloat_AsDouble(one.ptr());
            if (number == -1.0 && PyErr_Occurred()) {
                PyErr_Clear();
                break;
            }
            if (++count > N) break;
            made[count - 1] = number;
        }
    if (count != N)
        throw std::invalid_argument(std::string(name) + ": expected " + std::to_string(N) +
                                    " numbers");
    return made;
}

StampedPose checked_pose(double time_s, nb::handle position_m, nb::handle wxyz) {
    const Three position = numbers<3>(position_m, "position_m");
    Four q = numbers<4>(wxyz, "wxyz");
    if (!std::isfinite(time_s)) throw std::invalid_argument("time_s: expected a finite number");
    for (const double one : position)
        if (!(std::abs(one) < 1e150))
            throw std::invalid_argument("position_m: expected finite metres");
    const double length = std::sqrt(dot(q, q));
    if (!(length > 1e-150) || !std::isfinite(length))
        throw std::invalid_argument("wxyz: expected a quaternion of finite length above 0");
    return {time_s, position, {q[0] / length, -q[1] / length, -q[2] / length, -q[3] / length}};
}

nb::object array_of(const double *from, std::size_t count, const nb::object &empty) {
    nb::object made = empty(count);
    Py_buffer view;
    if (PyObject_GetBuffer(made.ptr(), &view, PyBUF_WRITABLE) != 0) throw nb::python_error();
    std::copy_n(from, count, static_cast<double *>(view.buf));
    PyBuffer_Release(&view);
    return made;
}

nb::object told(const StampedPose &pose) {
    static const nb::object empty = nb::module_::import_("numpy").attr("empty");
    const Four &r = pose.rotor;
    const Four wxyz{r[0], -r[1], -r[2], -r[3]};
    return nb::make_tuple(pose.time_s, array_of(pose.position.data(), 3, empty),
                          array_of(wxyz.data(), 4, empty));
}

// Poses farther apart are no path.
constexpr double SLOWEST_S = 1000.0;

nb::object update(Live &live, double time_s, nb::handle position_m, nb::handle wxyz) {
    if (live.interval_to(time_s) > SLOWEST_S)
        throw std::invalid_argument("time_s: expected seconds, got a stamp " +
                                    std::to_string(live.interval_to(time_s)) +
                                    " after the last; divide nanoseconds by 1e9, or reset() after "
                                    "so long a pause");
    return told(live.update(checked_pose(time_s, position_m, wxyz)));
}

using Rows = nb::ndarray<const double, nb::ndim<2>, nb::c_contig, nb::device::cpu>;
using Stamps = nb::ndarray<const double, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using Made = nb::ndarray<double, nb::ndim<2>, nb::c_contig, nb::device::cpu>;

// Poses of rows (N, 7), position before rotor, at N stamps; what comes out is laid out alike.
void smooth(double lag_s, double memory_s, const Stamps &time_s, const Rows &poses,
            const Made &out) {
    const std::size_t count = time_s.shape(0);
    if (count <= Live::OPENING || poses.shape(0) != count || out.shape(0) != count ||
        poses.shape(1) != 7 || out.shape(1) != 7)
        throw std::invalid_argument("poses: expected at least 5 rows of 7 numbers and as many "
                                    "stamps");
    const auto given = [&](std::size_t k) -> StampedPose {
        const double *row = poses.data() + 7 * k;
        return {time_s.data()[k], {row[0], row[1], row[2]}, {row[3], row[4], row[5], row[6]}};
    };
    double *row = out.data();
    const auto write = [&](const StampedPose &pose) {
        row = std::copy_n(pose.position.data(), 3, row);
        row = std::copy_n(pose.rotor.data(), 4, row);
    };
    nb::gil_scoped_release unlocked;
    Live(lag_s, memory_s).run(count, given, write);
}

nb::object predict(const Live &live, double time_s) { return told(live.ahead(time_s)); }

}  // namespace

NB_MODULE(_live, module) {
    module.doc() = "Smoothing as poses come; see motorcade.fusion.smoothing.live.";
    nb::class_<Live>(module, "Live")
        .def(nb::init<double, double>(), "lag_s"_a, "memory_s"_a)
        .def(nb::init<const Live &>(), "other"_a)
        .def_prop_ro("usual_interval_s", &Live::usual_interval_s)
        .def("update", &update, "time_s"_a, "position_m"_a, "wxyz"_a)
        .def("predict", &predict, "time_s"_a);
    module.def("smooth", &smooth, "lag_s"_a, "memory_s"_a, "time_s"_a, "poses"_a,
               "out"_a.noconvert());
}
