// What Python arguments are to a compiled program.
#pragma once

#include <nanobind/nanobind.h>

#include <string>
#include <vector>

#include "rows.h"

namespace motorcade {

// An operand's name, and how many components it has: (*, width), or (*) of a scalar.
struct Operand {
    std::string name;
    std::size_t width;
    bool scalar;
    bool negative = false;
};

// A number or an array; holds on to the array's buffer while it is in use.
class Argument {
public:
    Argument() = default;
    Argument(Argument &&other) noexcept;
    Argument(const Argument &) = delete;
    Argument &operator=(const Argument &) = delete;
    ~Argument();

    // False with a Python error set where it does not fit; `place` names the argument for it.
    bool take(PyObject *given, const char *program, const Operand &operand);

    // The batch, without the dimension of components.
    int dimensions() const { return view_.buf ? view_.ndim - (spread_ ? 1 : 0) : 0; }
    std::size_t length(int dimension) const {
        return static_cast<std::size_t>(view_.shape[dimension]);
    }
    bool is_array() const { return view_.buf != nullptr; }
    bool is_single() const { return single_; }
    // Whether it decides about the type computed in, as Python's own numbers do not.
    bool typed() const { return typed_; }

    // One component in a batch of `shape`, which this broadcasts to.
    Source component(std::size_t k, const Shape &shape) const;

private:
    bool convert(PyObject *given, const char *program, const Operand &operand);
    bool view(PyObject *given);

    Py_buffer view_{};
    double number_ = 0.0;
    bool held_ = false, spread_ = false, single_ = false, typed_ = false;
};

// The batch that all arguments broadcast to; false with a Python error set where they do not.
bool broadcast(const std::vector<Argument> &arguments, const char *program, Shape &shape);

}  // namespace motorcade
