// Binds the motor kernels to NumPy arrays: float64, C order, rows of coefficients. An input has as
// many rows as the output, or one row that serves them all. Nothing is copied and the interpreter
// lock is released while a kernel runs. Broadcasting and allocation are done in Python.

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <stdexcept>

#include "motor_kernels.h"

namespace nb = nanobind;
using namespace nb::literals;

namespace {

template <int Width>
using In = nb::ndarray<const double, nb::shape<-1, Width>, nb::c_contig, nb::device::cpu>;
template <int Width>
using Out = nb::ndarray<double, nb::shape<-1, Width>, nb::c_contig, nb::device::cpu>;

template <int Width>
motorcade::Rows rows(const In<Width>& array, std::size_t count) {
    if (array.shape(0) == count) return {array.data(), Width};
    if (array.shape(0) == 1) return {array.data(), 0};
    throw std::invalid_argument("expected inputs with one row or as many rows as the output");
}

void compose_rows(const In<8>& a, const In<8>& b, const Out<8>& out) {
    const std::size_t count = out.shape(0);
    motorcade::compose(rows<8>(a, count), rows<8>(b, count), out.data(), count);
}

void inverse_rows(const In<8>& motor, const Out<8>& out) {
    const std::size_t count = out.shape(0);
    motorcade::inverse(rows<8>(motor, count), out.data(), count);
}

void exp_rows(const In<6>& bivector, const Out<8>& out) {
    const std::size_t count = out.shape(0);
    motorcade::exp(rows<6>(bivector, count), out.data(), count);
}

void log_rows(const In<8>& motor, const Out<6>& out, bool short_way) {
    const std::size_t count = out.shape(0);
    motorcade::log(rows<8>(motor, count), out.data(), count, short_way);
}

void interpolate_rows(const In<8>& a, const In<8>& b, const In<1>& fraction, const Out<8>& out,
                 bool short_way) {
    const std::size_t count = out.shape(0);
    motorcade::interpolate(rows<8>(a, count), rows<8>(b, count), rows<1>(fraction, count),
                           out.data(), count, short_way);
}

}  // namespace

NB_MODULE(_compiled, module) {
    using Unlocked = nb::call_guard<nb::gil_scoped_release>;
    module.doc() = "Motor kernels over rows of coefficients; see motorcade.ga.kernels.";
    module.def("compose", &compose_rows, "a"_a.noconvert(), "b"_a.noconvert(), "out"_a.noconvert(),
               Unlocked());
    module.def("inverse", &inverse_rows, "motor"_a.noconvert(), "out"_a.noconvert(), Unlocked());
    module.def("exp", &exp_rows, "bivector"_a.noconvert(), "out"_a.noconvert(), Unlocked());
    module.def("log", &log_rows, "motor"_a.noconvert(), "out"_a.noconvert(), "short_way"_a, Unlocked());
    module.def("interpolate", &interpolate_rows, "a"_a.noconvert(), "b"_a.noconvert(),
               "fraction"_a.noconvert(), "out"_a.noconvert(), "short_way"_a, Unlocked());
}
