#include "operands.h"

#include <cstring>
#include <utility>

namespace motorcade {
namespace {

// Whether a buffer's format is of real numbers, whole ones included.
bool is_real(const char *format) {
    if (std::strchr("@=<>!^", *format)) ++format;
    return *format && std::strchr("bBhHiIlLqQefdg", *format) && format[1] == '\0';
}

}  // namespace

Argument::Argument(Argument &&other) noexcept
    : view_(other.view_), number_(other.number_), held_(std::exchange(other.held_, false)),
      spread_(other.spread_), single_(other.single_), typed_(other.typed_) {}

Argument::~Argument() {
    if (held_) PyBuffer_Release(&view_);
}

bool Argument::view(PyObject *given) {
    if (PyObject_GetBuffer(given, &view_, PyBUF_STRIDES | PyBUF_FORMAT) != 0) return false;
    held_ = true;
    return true;
}

bool Argument::take(PyObject *given, const char *program, const Operand &operand) {
    const bool exact = PyFloat_CheckExact(given);
    if ((exact || PyLong_CheckExact(given) || PyFloat_Check(given)) && operand.scalar) {
        number_ = PyFloat_AsDouble(given);
        typed_ = !exact && !PyLong_CheckExact(given);  // numpy.float64 is a float of its own type
        return !(number_ == -1.0 && PyErr_Occurred());
    }
    if (!PyObject_CheckBuffer(given) || !view(given)) {
        PyErr_Clear();
        PyErr_Format(PyExc_TypeError, "%s: %s: expected %s, got %s", program, operand.name.c_str(),
                     operand.scalar ? "a number or an array of real numbers"
                                    : "an array of real numbers",
                     Py_TYPE(given)->tp_name);
        return false;
    }
    const char *format = view_.format ? view_.format : "B";
    single_ = std::strcmp(format, "f") == 0;
    typed_ = true;
    if (!single_ && std::strcmp(format, "d") != 0 && !convert(given, program, operand))
        return false;
    spread_ = !operand.scalar;
    const int batch = view_.ndim - (spread_ ? 1 : 0);
    if (batch < 0 || (spread_ && static_cast<std::size_t>(view_.shape[batch]) != operand.width)) {
        nanobind::object shape = nanobind::steal(PyObject_GetAttrString(given, "shape"));
        if (!shape) PyErr_Clear();
        PyErr_Format(PyExc_ValueError, "%s: %s: expected an array (*, %zu), got one of shape %S",
                     program, operand.name.c_str(), operand.width, shape ? shape.ptr() : Py_None);
        return false;
    }
    if (batch > MOST_DIMENSIONS) {
        PyErr_Format(PyExc_ValueError, "%s: %s: expected at most %d batch dimensions, got %d",
                     program, operand.name.c_str(), MOST_DIMENSIONS, batch);
        return false;
    }
    return true;
}

// Real numbers of another kind become float64.
bool Argument::convert(PyObject *given, const char *program, const Operand &operand) {
    if (!is_real(view_.format ? view_.format : "B")) {
        PyErr_Format(PyExc_TypeError, "%s: %s: expected real numbers, got the format '%s'", program,
                     operand.name.c_str(), view_.format);
        return false;
    }
    nanobind::object numpy = nanobind::steal(PyImport_ImportModule("numpy"));
    if (!numpy) return false;
    nanobind::object made =
        nanobind::steal(PyObject_CallMethod(numpy.ptr(), "array", "Os", given, "float64"));
    if (!made) return false;
    PyBuffer_Release(&view_);
    held_ = false;
    return view(made.ptr());
}

Source Argument::component(std::size_t k, const Shape &shape) const {
    Source made;
    made.number = number_;
    if (!is_array()) return made;
    const int own = dimensions();
    made.single = single_;
    made.first = static_cast<const char *>(view_.buf);
    if (spread_) made.first += static_cast<std::ptrdiff_t>(k) * view_.strides[own];
    for (int d = 0; d < own; ++d) {
        const int at = shape.dimensions - own + d;
        made.strides[at] = view_.shape[d] == 1 ? 0 : view_.strides[d];
    }
    return made;
}

bool broadcast(const std::vector<Argument> &arguments, const char *program, Shape &shape) {
    for (const Argument &one : arguments)
        shape.dimensions = std::max(shape.dimensions, one.dimensions());
    for (int d = 0; d < shape.dimensions; ++d) shape.lengths[d] = 1;
    for (const Argument &one : arguments) {
        const int own = one.dimensions();
        for (int d = 0; d < own; ++d) {
            std::size_t &length = shape.lengths[shape.dimensions - own + d];
            if (one.length(d) == length || one.length(d) == 1) continue;
            if (length != 1) {
                PyErr_Format(PyExc_ValueError,
                             "%s: expected batches that broadcast together, got lengths %zu and "
                             "%zu in one dimension",
                             program, length, one.length(d));
                return false;
            }
            length = one.length(d);
        }
    }
    return true;
}

}  // namespace motorcade
