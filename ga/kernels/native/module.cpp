// Binds the generated kernels to Python: each is a function of its inputs and an output that is
// written into, Blocks or arrays, without copies. The interpreter lock is released for all but the
// smallest batches. Broadcasting and allocation are done in Python.

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/string.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "dispatch.h"

namespace motorcade {
void add_fast_paths(nanobind::module_ &module);  // see fast_path.cpp
}

namespace nb = nanobind;
using namespace nb::literals;

namespace {

constexpr std::size_t LANES = MOTORCADE_LANES;
constexpr std::size_t LINE = 64;
constexpr std::size_t HOLD_LOCK_BELOW = 512;  // rows: shorter than handing the lock over and back

std::atomic<unsigned> thread_count{1};

struct alignas(LINE) Line {
    char bytes[LINE];
};

// Structure-of-arrays storage: one contiguous array a component, padded to whole blocks.
class Block {
public:
    Block(std::size_t width, std::size_t count, bool single)
        : width_(width), count_(count), size_(single ? sizeof(float) : sizeof(double)) {
        if (width == 0 || width > 64 || count > (std::size_t{1} << 40))
            throw std::invalid_argument(
                "Block: expected a width from 1 to 64 and a count that fits in memory");
        // An odd number of cache lines keeps the components apart in the cache.
        std::size_t lines =
            std::max<std::size_t>(1, (count + LANES - 1) / LANES) * LANES * size_ / LINE;
        if (count > 1024) lines |= 1;
        padded_ = lines * LINE / size_;
        memory_ = std::make_unique<Line[]>(width * lines);
    }

    std::size_t width() const { return width_; }
    std::size_t count() const { return count_; }
    bool single() const { return size_ == sizeof(float); }
    motorcade::Rows rows() const {
        return {reinterpret_cast<char *>(memory_.get()), count_, static_cast<std::ptrdiff_t>(size_),
                static_cast<std::ptrdiff_t>(padded_ * size_), padded_};
    }
    std::size_t padded() const { return padded_; }
    void *data() const { return memory_.get(); }

private:
    std::size_t width_, count_, size_, padded_ = 0;
    std::unique_ptr<Line[]> memory_;
};

PyTypeObject *block_type = nullptr;

// What a Python argument is to a kernel; holds on to the array's buffer while it is in use.
class Operand {
public:
    Operand() = default;
    Operand(const Operand &) = delete;
    Operand &operator=(const Operand &) = delete;
    ~Operand() {
        if (held_) PyBuffer_Release(&view_);
    }

    // False with a Python error set where the argument does not fit.
    bool take(PyObject *given, std::size_t width, bool written) {
        if (Py_TYPE(given) == block_type) {
            const Block &block = *nb::inst_ptr<Block>(nb::handle(given));
            rows = block.rows();
            single = block.single();
            if (block.width() == width) return true;
            PyErr_Format(PyExc_ValueError, "expected a Block of %zu components, got one of %zu",
                         width, block.width());
            return false;
        }
        if (PyFloat_CheckExact(given) && width == 1 && !written) {
            number_ = PyFloat_AsDouble(given);
            any = true;
            rows = {nullptr, 1, 0, 0, 1};
            return true;
        }
        const int flags = PyBUF_STRIDES | PyBUF_FORMAT | (written ? PyBUF_WRITABLE : 0);
        if (PyObject_GetBuffer(given, &view_, flags) != 0) return false;
        held_ = true;
        return read_view(width);
    }

    // A plain number takes the type of the others.
    void settle(bool as_single) {
        if (!any) return;
        small_ = static_cast<float>(number_);
        rows.first =
            as_single ? reinterpret_cast<char *>(&small_) : reinterpret_cast<char *>(&number_);
    }

    motorcade::Rows rows{};
    bool single = false;
    bool any = false;

private:
    bool read_view(std::size_t width) {
        const std::string format = view_.format ? view_.format : "B";
        if (format != "f" && format != "d") {
            PyErr_SetString(PyExc_TypeError, "expected arrays of float32 or float64");
            return false;
        }
        single = format == "f";
        // Of numbers, one a row, the dimension of components may be left out.
        const bool spread = width > 1;
        const int batch = view_.ndim - (spread ? 1 : 0);
        if (batch < 0 || (spread && static_cast<std::size_t>(view_.shape[batch]) != width)) {
            PyErr_Format(PyExc_ValueError, "expected arrays (*, %zu)", width);
            return false;
        }
        rows = {static_cast<char *>(view_.buf), 1, view_.itemsize,
                spread ? view_.strides[batch] : view_.itemsize, 0};
        for (int k = batch - 1; k >= 0; --k) {
            const std::size_t length = static_cast<std::size_t>(view_.shape[k]);
            if (length == 1) continue;
            if (rows.count == 1)
                rows.row_stride = view_.strides[k];
            else if (view_.strides[k] != rows.row_stride * static_cast<Py_ssize_t>(rows.count)) {
                PyErr_SetString(PyExc_ValueError,
                                "expected batch dimensions that follow each other at one stride");
                return false;
            }
            rows.count *= length;
        }
        rows.readable = rows.count;
        return true;
    }

    Py_buffer view_{};
    bool held_ = false;
    double number_ = 0.0;
    float small_ = 0.0F;
};

// Where an operand's numbers lie: from its lowest byte on, in `outer` runs of `run` bytes that are
// `step` apart.
struct Extent {
    const char *low;
    std::ptrdiff_t step, run, whole;
};

// With one row a run, or with one component a run.
Extent extent(const motorcade::Rows &rows, std::size_t width, std::ptrdiff_t size, bool by_rows) {
    const std::ptrdiff_t steps[2] = {rows.count > 1 ? rows.row_stride : 0,
                                     width > 1 ? rows.component_stride : 0};
    const std::ptrdiff_t spans[2] = {steps[0] * static_cast<std::ptrdiff_t>(rows.count - 1),
                                     steps[1] * static_cast<std::ptrdiff_t>(width - 1)};
    const std::ptrdiff_t low =
        std::min<std::ptrdiff_t>(spans[0], 0) + std::min<std::ptrdiff_t>(spans[1], 0);
    const int outer = by_rows ? 0 : 1;
    return {rows.first + low, std::abs(steps[outer]), std::abs(spans[1 - outer]) + size,
            std::abs(spans[0]) + std::abs(spans[1]) + size};
}

// Whether two operands may share memory; runs that lie between each other's do not.
bool overlap(const motorcade::Rows &a, std::size_t a_width, const motorcade::Rows &b,
             std::size_t b_width, std::ptrdiff_t size) {
    if (a.count == 0 || b.count == 0) return false;
    for (const bool by_rows : {true, false}) {
        const Extent one = extent(a, a_width, size, by_rows);
        const Extent other = extent(b, b_width, size, by_rows);
        if (one.low + one.whole <= other.low || other.low + other.whole <= one.low) return false;
        if (one.step != other.step || one.step == 0) continue;
        const std::ptrdiff_t from = (other.low - one.low) % one.step;
        const std::ptrdiff_t apart = from < 0 ? from + one.step : from;
        if (one.run <= apart && apart + other.run <= one.step) return false;
    }
    return true;
}

bool check_alike(const motorcade_kernel &kernel, const Operand *operands, bool &single) {
    const int inputs = kernel.inputs, all = inputs + kernel.outputs;
    const Operand &out = operands[inputs];
    single = out.single;
    const std::ptrdiff_t size = single ? sizeof(float) : sizeof(double);
    for (int k = 0; k < all; ++k) {
        if (!operands[k].any && operands[k].single != single) {
            PyErr_SetString(PyExc_TypeError,
                            "expected one precision, got float32 and float64; convert one of them");
            return false;
        }
        const std::size_t count = operands[k].rows.count;
        if (count != out.rows.count && (k >= inputs || count != 1)) {
            PyErr_Format(
                PyExc_ValueError,
                "expected inputs with one row or as many rows as the output (%zu), got %zu",
                out.rows.count, count);
            return false;
        }
        for (int made = inputs; made < all && k < inputs && !operands[k].any; ++made) {
            if (overlap(operands[k].rows, static_cast<std::size_t>(kernel.widths[k]),
                        operands[made].rows, static_cast<std::size_t>(kernel.widths[made]), size)) {
                PyErr_SetString(PyExc_ValueError,
                                "expected an output apart from the inputs: they overlap");
                return false;
            }
        }
    }
    return true;
}

// A kernel with its operands, checked.
struct Call {
    Operand operands[MOTORCADE_OPERANDS];
    motorcade::Rows rows[MOTORCADE_OPERANDS];
    bool single = false;

    bool take(const motorcade_kernel &kernel, PyObject *const *given, Py_ssize_t count) {
        const int all = kernel.inputs + kernel.outputs;
        if (count != all) {
            PyErr_Format(PyExc_TypeError, "%s: expected %d arguments, inputs and output, got %zd",
                         kernel.name, all, count);
            return false;
        }
        for (int k = 0; k < all; ++k)
            if (!operands[k].take(given[k], static_cast<std::size_t>(kernel.widths[k]),
                                  k >= kernel.inputs))
                return false;
        if (!check_alike(kernel, operands, single)) return false;
        for (int k = 0; k < all; ++k) {
            operands[k].settle(single);
            rows[k] = operands[k].rows;
        }
        return true;
    }
};

// None, or with `checked` whether all inputs were finite.
template <bool checked> PyObject *call(PyObject *self, PyObject *const *given, Py_ssize_t count) {
    const auto &kernel =
        *static_cast<const motorcade_kernel *>(PyCapsule_GetPointer(self, nullptr));
    Call one;
    if (!one.take(kernel, given, count)) return nullptr;
    bool finite = true;
    if (one.rows[kernel.inputs].count < HOLD_LOCK_BELOW) {
        finite = motorcade::run(kernel, one.rows, one.single, checked, 1);
    } else {
        nb::gil_scoped_release unlocked;
        finite = motorcade::run(kernel, one.rows, one.single, checked, thread_count.load());
    }
    return checked ? PyBool_FromLong(finite) : Py_NewRef(Py_None);
}

// Seconds that `times` calls take without Python's share, for measurements.
double repeat(const std::string &name, std::size_t times, nb::args given) {
    const auto end = motorcade_kernels + motorcade_kernel_count;
    const auto kernel =
        std::find_if(motorcade_kernels, end, [&](const auto &k) { return name == k.name; });
    if (kernel == end)
        throw std::invalid_argument("repeat: expected the name of a kernel, got " + name);
    std::vector<PyObject *> operands;
    for (nb::handle one : given) operands.push_back(one.ptr());
    Call all;
    if (!all.take(*kernel, operands.data(), static_cast<Py_ssize_t>(operands.size())))
        throw nb::python_error();
    nb::gil_scoped_release unlocked;
    const auto start = std::chrono::steady_clock::now();
    for (std::size_t k = 0; k < times; ++k)
        motorcade::run(*kernel, all.rows, all.single, false, thread_count.load());
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

nb::object array_of(nb::handle self) {
    const Block &block = nb::cast<const Block &>(self);
    const std::size_t shape[2] = {block.count(), block.width()};
    const std::int64_t strides[2] = {1, static_cast<std::int64_t>(block.padded())};
    const nb::dlpack::dtype type = block.single() ? nb::dtype<float>() : nb::dtype<double>();
    return nb::cast(nb::ndarray<nb::numpy>(block.data(), 2, shape, self, strides, type));
}

}  // namespace

NB_MODULE(_compiled, module) {
    module.doc() = "The generated kernels; see motorcade.ga.kernels.";
    block_type = reinterpret_cast<PyTypeObject *>(
        nb::class_<Block>(module, "Block")
            .def(
                "__init__",
                [](Block *self, std::size_t width, std::size_t count, const std::string &dtype) {
                    if (dtype != "float32" && dtype != "float64")
                        throw std::invalid_argument(
                            "Block: expected dtype 'float32' or 'float64', got '" + dtype + "'");
                    new (self) Block(width, count, dtype == "float32");
                },
                "width"_a, "count"_a, "dtype"_a = "float64")
            .def("__len__", &Block::count)
            .def_prop_ro("width", &Block::width)
            .def_prop_ro("array", &array_of)
            .release()
            .ptr());
    module.def(
        "set_threads", [](unsigned threads) { thread_count = std::max(1U, threads); }, "threads"_a);
    module.def("repeat", &repeat);
    module.def("threads", [] { return thread_count.load(); });
    static std::vector<PyMethodDef> methods(2 * motorcade_kernel_count);
    nb::dict checked;
    for (std::size_t k = 0; k < motorcade_kernel_count; ++k) {
        const motorcade_kernel &kernel = motorcade_kernels[k];
        nb::object self =
            nb::steal(PyCapsule_New(const_cast<motorcade_kernel *>(&kernel), nullptr, nullptr));
        const auto function = [&](PyMethodDef &method, auto *called) {
            method = {kernel.name,
                      reinterpret_cast<PyCFunction>(reinterpret_cast<void (*)()>(called)),
                      METH_FASTCALL, nullptr};
            return nb::steal(PyCFunction_NewEx(&method, self.ptr(), nullptr));
        };
        module.attr(kernel.name) = function(methods[2 * k], &call<false>);
        checked[kernel.name] = function(methods[2 * k + 1], &call<true>);
    }
    module.attr("checked") = checked;
    motorcade::add_fast_paths(module);
}
