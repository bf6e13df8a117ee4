// Calls programs that were compiled at run time: `bind` makes two Python functions of one, which
// broadcast what they are given and allocate what they give. The interpreter lock is released for
// all but the smallest batches.

#include <nanobind/nanobind.h>
#include <nanobind/stl/string.h>

#include <dlfcn.h>

#include <array>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "operands.h"
#include "rows.h"

namespace nb = nanobind;
using namespace nb::literals;
using motorcade::Argument;
using motorcade::BLOCK;
using motorcade::Operand;
using motorcade::Shape;
using motorcade::Source;
using motorcade::Target;

namespace {

constexpr std::size_t HOLD_LOCK_BELOW = 512;  // rows: shorter than handing the lock over and back
constexpr std::size_t LINE = 64;
constexpr std::size_t TOGETHER = 4096;  // rows

// Objects of Python that every call needs; they live as long as the module.
struct Names {
    PyObject *empty, *ndarray, *single, *real, *single_type, *real_type;
} names;

struct Close {
    void operator()(void *library) const { dlclose(library); }
};

// A program: its operands, and the functions of the libraries that are there.
struct Program {
    std::string name;
    std::vector<Operand> inputs, outputs;
    std::vector<Operand> scalars;  // a scalar for each component of an input
    std::size_t components = 0;    // of all outputs
    bool bare = false;             // one output, given without a tuple around it
    nb::callable threads;
    std::unique_ptr<void, Close> libraries[2];
    motorcade::Entry<float> single = nullptr;
    motorcade::Entry<double> real = nullptr;
};

const Program &program_of(PyObject *self) {
    return *static_cast<const Program *>(PyCapsule_GetPointer(self, nullptr));
}

void destroy(PyObject *self) { delete static_cast<Program *>(PyCapsule_GetPointer(self, nullptr)); }

// What one call works on.
struct Call {
    const Program &program;
    std::vector<Argument> arguments;
    Shape shape;
    bool single = false, any_array = false;

    bool take(const std::vector<Operand> &operands, PyObject *const *given, Py_ssize_t count) {
        if (static_cast<std::size_t>(count) != operands.size()) {
            PyErr_Format(PyExc_ValueError, "%s: expected %zu arguments, got %zd",
                         program.name.c_str(), operands.size(), count);
            return false;
        }
        arguments.reserve(operands.size());
        bool wide = false;
        for (std::size_t k = 0; k < operands.size(); ++k) {
            Argument &one = arguments.emplace_back();
            if (!one.take(given[k], program.name.c_str(), operands[k])) return false;
            single = single || one.is_single();
            wide = wide || (one.typed() && !one.is_single());
            any_array = any_array || one.is_array();
        }
        single = single && !wide;
        return motorcade::broadcast(arguments, program.name.c_str(), shape);
    }

    bool compiled() const { return single ? program.single != nullptr : program.real != nullptr; }
    std::size_t size() const { return single ? sizeof(float) : sizeof(double); }
    PyObject *type() const { return single ? names.single : names.real; }

    // False with a Python error set.
    bool run(const std::vector<Operand> &operands, const std::vector<Target> &targets,
             bool finite) {
        const std::size_t rows = shape.rows();
        std::vector<Source> sources;
        for (std::size_t k = 0; k < operands.size(); ++k)
            for (std::size_t i = 0; i < operands[k].width; ++i) {
                sources.push_back(arguments[k].component(i, shape));
                sources.back().negative = operands[k].negative;
            }
        int lost = -1;
        if (rows < HOLD_LOCK_BELOW) {
            lost = compute(sources, targets, 1, finite);
        } else {
            const unsigned threads = nb::cast<unsigned>(program.threads());
            nb::gil_scoped_release unlocked;
            lost = compute(sources, targets, threads, finite);
        }
        if (lost < 0) return true;
        std::size_t last = 0;
        for (const Operand &output : program.outputs) {
            last += output.width;
            if (static_cast<std::size_t>(lost) < last) {
                PyErr_Format(PyExc_ValueError,
                             "%s: expected finite numbers in %s, got NaN or infinite ones",
                             program.name.c_str(), output.name.c_str());
                break;
            }
        }
        return false;
    }

private:
    int compute(std::vector<Source> &sources, const std::vector<Target> &targets, unsigned threads,
                bool finite) const {
        if (single)
            return motorcade::run_rows(program.single, shape, sources, targets, threads, finite);
        return motorcade::run_rows(program.real, shape, sources, targets, threads, finite);
    }
};

nb::object lengths_of(const Shape &shape, bool width, std::size_t components) {
    nb::object made = nb::steal(PyTuple_New(shape.dimensions + (width ? 1 : 0)));
    for (int d = 0; d < shape.dimensions; ++d)
        PyTuple_SET_ITEM(made.ptr(), d, PyLong_FromSize_t(shape.lengths[d]));
    if (width) PyTuple_SET_ITEM(made.ptr(), shape.dimensions, PyLong_FromSize_t(components));
    return made;
}

nb::object empty(const nb::object &shape, PyObject *type) {
    PyObject *const given[] = {shape.ptr(), type};
    nb::object made = nb::steal(PyObject_Vectorcall(names.empty, given, 2, nullptr));
    if (!made) throw nb::python_error();
    return made;
}

char *data_of(const nb::object &array) {
    Py_buffer view;
    if (PyObject_GetBuffer(array.ptr(), &view, PyBUF_STRIDES | PyBUF_WRITABLE) != 0)
        throw nb::python_error();
    char *first = static_cast<char *>(view.buf);
    PyBuffer_Release(&view);  // the array keeps its memory
    return first;
}

// How many bytes components are apart in a block: an odd number of cache lines, which keeps them
// apart in the cache.
std::size_t apart(std::size_t rows, std::size_t size) {
    const std::size_t lines = (rows * size + LINE - 1) / LINE;
    return (rows > 1024 ? lines | 1 : lines) * LINE;
}

// How many bytes the next line of the cache is away, where there are vectors to store in lines.
std::size_t to_line(const char *first) {
    return (LINE - reinterpret_cast<std::uintptr_t>(first) % LINE) % LINE;
}

nb::object strides_of(const Call &call, bool width, std::size_t step) {
    const int dimensions = call.shape.dimensions;
    nb::object made = nb::steal(PyTuple_New(dimensions + (width ? 1 : 0)));
    std::size_t stride = call.size();
    for (int d = dimensions - 1; d >= 0; --d) {
        PyTuple_SET_ITEM(made.ptr(), d, PyLong_FromSize_t(stride));
        stride *= call.shape.lengths[d];
    }
    if (width) PyTuple_SET_ITEM(made.ptr(), dimensions, PyLong_FromSize_t(step));
    return made;
}

// An array onto a part of a block.
nb::object view(const Call &call, const nb::object &block, std::size_t offset,
                const nb::object &shape, const nb::object &strides) {
    const nb::object start = nb::steal(PyLong_FromSize_t(offset));
    PyObject *const given[] = {shape.ptr(), call.type(), block.ptr(), start.ptr(), strides.ptr()};
    nb::object made = nb::steal(PyObject_Vectorcall(names.ndarray, given, 5, nullptr));
    if (!made) throw nb::python_error();
    return made;
}

// An array (*, width) whose components lie one after the other where there are rows to gain by it.
nb::object output_array(const Call &call, const Operand &operand, std::vector<Target> &targets) {
    const std::size_t rows = call.shape.rows(), size = call.size(), width = operand.width;
    if (operand.scalar || rows < BLOCK || width < 2) {
        nb::object made = empty(lengths_of(call.shape, !operand.scalar, width), call.type());
        char *first = rows && width ? data_of(made) : nullptr;
        for (std::size_t k = 0; k < width; ++k)
            targets.push_back({first + k * size, static_cast<std::ptrdiff_t>(width * size)});
        return made;
    }
    const std::size_t step = apart(rows, size);
    nb::object block =
        empty(nb::steal(PyLong_FromSize_t((width * step + LINE) / size)), call.type());
    char *first = data_of(block);
    const std::size_t start = to_line(first);
    for (std::size_t k = 0; k < width; ++k)
        targets.push_back({first + start + k * step, static_cast<std::ptrdiff_t>(size)});
    return view(call, block, start, lengths_of(call.shape, true, width),
                strides_of(call, true, step));
}

// One array a component in a batch, all in one block where they are long: several blocks of that
// size would go back to the system each time.
void output_components(const Call &call, std::size_t count, const nb::object &made,
                       std::vector<Target> &targets) {
    const std::size_t rows = call.shape.rows(), size = call.size(), step = apart(rows, size);
    const nb::object lengths = lengths_of(call.shape, false, 0);
    const bool together = rows >= TOGETHER && count > 0;
    nb::object block, strides;
    std::size_t start = 0;
    if (together) {
        block = empty(nb::steal(PyLong_FromSize_t((count * step + LINE) / size)), call.type());
        start = to_line(data_of(block));
        strides = strides_of(call, false, 0);
    }
    for (std::size_t k = 0; k < count; ++k) {
        nb::object array = together ? view(call, block, start + k * step, lengths, strides)
                                    : empty(lengths, call.type());
        targets.push_back({rows ? data_of(array) : nullptr, static_cast<std::ptrdiff_t>(size)});
        PyTuple_SET_ITEM(made.ptr(), static_cast<Py_ssize_t>(k), array.release().ptr());
    }
}

// Arrays in, arrays out; NotImplemented where the precision is not compiled.
PyObject *call_arrays(PyObject *self, PyObject *const *given, Py_ssize_t count) {
    try {
        const Program &program = program_of(self);
        Call call{program, {}, {}};
        if (!call.take(program.inputs, given, count)) return nullptr;
        if (!call.compiled()) Py_RETURN_NOTIMPLEMENTED;
        std::vector<Target> targets;
        nb::object made = nb::steal(PyTuple_New(static_cast<Py_ssize_t>(program.outputs.size())));
        for (std::size_t k = 0; k < program.outputs.size(); ++k)
            PyTuple_SET_ITEM(made.ptr(), static_cast<Py_ssize_t>(k),
                             output_array(call, program.outputs[k], targets).release().ptr());
        if (!call.run(program.inputs, targets, false)) return nullptr;
        if (program.bare) return nb::borrow(PyTuple_GET_ITEM(made.ptr(), 0)).release().ptr();
        return made.release().ptr();
    } catch (nb::python_error &error) {
        error.restore();
    } catch (const std::exception &error) {
        PyErr_SetString(PyExc_RuntimeError, error.what());
    }
    return nullptr;
}

// A number that is neither a Python float's equal nor an array: of the type computed in.
PyObject *number(const Call &call, double value) {
    PyObject *plain = PyFloat_FromDouble(value);
    if (!call.any_array || !plain) return plain;
    PyObject *made = PyObject_CallOneArg(call.single ? names.single_type : names.real_type, plain);
    Py_DECREF(plain);
    return made;
}

// The coefficients of multivectors in, those of the results out; they must be finite.
PyObject *call_components(PyObject *self, PyObject *const *given, Py_ssize_t count) {
    try {
        const Program &program = program_of(self);
        Call call{program, {}, {}};
        if (!call.take(program.scalars, given, count)) return nullptr;
        if (!call.compiled()) Py_RETURN_NOTIMPLEMENTED;
        const bool batch = call.shape.dimensions > 0;
        std::vector<Target> targets;
        std::vector<double> one(batch ? 0 : program.components);
        nb::object made = nb::steal(PyTuple_New(static_cast<Py_ssize_t>(program.components)));
        if (batch) output_components(call, program.components, made, targets);
        for (double &value : one) targets.push_back({reinterpret_cast<char *>(&value), 0});
        if (!call.run(program.scalars, targets, true)) return nullptr;
        for (std::size_t k = 0; k < one.size(); ++k) {
            const double value = call.single ? *reinterpret_cast<float *>(&one[k]) : one[k];
            PyObject *item = number(call, value);
            if (!item) return nullptr;
            PyTuple_SET_ITEM(made.ptr(), static_cast<Py_ssize_t>(k), item);
        }
        return made.release().ptr();
    } catch (nb::python_error &error) {
        error.restore();
    } catch (const std::exception &error) {
        PyErr_SetString(PyExc_RuntimeError, error.what());
    }
    return nullptr;
}

// The function of a library that was compiled for a program.
void *load(Program &program, int place, const nb::object &path, const std::string &symbol) {
    if (path.is_none()) return nullptr;
    void *library = dlopen(nb::cast<std::string>(path).c_str(), RTLD_NOW | RTLD_LOCAL);
    if (!library) throw std::runtime_error(std::string("dlopen: ") + dlerror());
    program.libraries[place].reset(library);
    void *found = dlsym(library, symbol.c_str());
    if (!found) throw std::runtime_error("dlsym: no function " + symbol);
    return found;
}

std::vector<Operand> operands(const nb::list &given) {
    std::vector<Operand> made;
    for (nb::handle one : given) {
        const auto pair = nb::cast<nb::tuple>(one);
        const long width = nb::cast<long>(pair[1]);
        made.push_back({nb::cast<std::string>(pair[0]),
                        static_cast<std::size_t>(width < 0 ? 1 : width), width < 0});
    }
    return made;
}

PyMethodDef methods[] = {
    {"arrays", reinterpret_cast<PyCFunction>(reinterpret_cast<void (*)()>(call_arrays)),
     METH_FASTCALL, nullptr},
    {"components", reinterpret_cast<PyCFunction>(reinterpret_cast<void (*)()>(call_components)),
     METH_FASTCALL, nullptr},
};

nb::tuple bind(const std::string &name, const nb::list &inputs, const nb::list &outputs,
               const nb::list &negative, bool bare, const nb::object &single,
               const nb::object &real, const std::string &symbol, const nb::callable &threads) {
    auto program = std::make_unique<Program>();
    program->name = name;
    program->inputs = operands(inputs);
    program->outputs = operands(outputs);
    program->bare = bare;
    program->threads = threads;
    for (const Operand &input : program->inputs)
        for (std::size_t k = 0; k < input.width; ++k)
            program->scalars.push_back(
                {input.name, 1, true, nb::cast<bool>(negative[program->scalars.size()])});
    for (const Operand &output : program->outputs) program->components += output.width;
    program->single = reinterpret_cast<motorcade::Entry<float>>(load(*program, 0, single, symbol));
    program->real = reinterpret_cast<motorcade::Entry<double>>(load(*program, 1, real, symbol));
    nb::object self = nb::steal(PyCapsule_New(program.get(), nullptr, destroy));
    if (!self) throw nb::python_error();
    program.release();
    return nb::make_tuple(nb::steal(PyCFunction_NewEx(&methods[0], self.ptr(), nullptr)),
                          nb::steal(PyCFunction_NewEx(&methods[1], self.ptr(), nullptr)));
}

// The x86-64 level that the processor runs, 1 to 4; 0 on other processors.
int processor_level() {
#if defined(__x86_64__) && defined(__GNUC__)
    __builtin_cpu_init();
    const bool third = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") &&
                       __builtin_cpu_supports("bmi2");
    const bool fourth = third && __builtin_cpu_supports("avx512f") &&
                        __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512cd") &&
                        __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl");
    return fourth ? 4 : third ? 3 : __builtin_cpu_supports("sse4.2") ? 2 : 1;
#else
    return 0;
#endif
}

}  // namespace

NB_MODULE(_trampoline, module) {
    module.doc() = "Calls programs compiled at run time; see motorcade.ga.codegen.runtime.";
    const nb::module_ numpy = nb::module_::import_("numpy");
    names.empty = nb::object(numpy.attr("empty")).release().ptr();
    names.ndarray = nb::object(numpy.attr("ndarray")).release().ptr();
    names.single = nb::object(numpy.attr("dtype")("float32")).release().ptr();
    names.real = nb::object(numpy.attr("dtype")("float64")).release().ptr();
    names.single_type = nb::object(numpy.attr("float32")).release().ptr();
    names.real_type = nb::object(numpy.attr("float64")).release().ptr();
    module.def("bind", &bind, "name"_a, "inputs"_a, "outputs"_a, "negative"_a, "bare"_a,
               "single"_a.none(), "real"_a.none(), "symbol"_a, "threads"_a);
    module.def("processor_level", &processor_level);
}
