// From a versor's method straight to its kernel: one value or a short batch, by NumPy's own memory.
//
// A fast path stands in the class in the method's stead and reads like it, apart from calls. Where
// all arguments are exactly what the kernel takes, of one precision and one batch, finite, and what
// comes out passes, nothing in Python runs. Everything else, what is to be converted, broadcast or
// refused, goes to the method itself, so that both have one meaning.

#include <nanobind/nanobind.h>
#include <structmember.h>

#define NPY_NO_DEPRECATED_API NPY_2_0_API_VERSION
#include <numpy/arrayobject.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>

#include "dispatch.h"
#include "transpose.h"

namespace nb = nanobind;

namespace {

constexpr std::size_t LANES = MOTORCADE_LANES;
constexpr npy_intp SHORT = 512;  // rows: more are worth threads and a place of their own in memory
constexpr std::size_t WIDEST = 16;  // numbers that a list may hold
constexpr char SEQUENCE = 'e',
               FRAME = 'o';  // of Euler angles: the last argument, which has a default

// The types of versors, by the number of their coefficients.
struct Kind {
    const char *prefix;
    std::size_t size;
    PyTypeObject *type;
};
Kind kinds[] = {{"rotor_", 4, nullptr}, {"", 8, nullptr}, {"similarity_", 12, nullptr}};
constexpr std::size_t KINDS = std::size(kinds);

PyObject *coefficients_name = nullptr, *method_type = nullptr, *usual_sequence = nullptr;

struct FastPath {
    PyObject_HEAD vectorcallfunc call;
    PyObject *method;
    const motorcade_kernel *kernels[KINDS];
    char operands[MOTORCADE_OPERANDS + 2], result;
    double above, within;  // bounds of the number that follows the result, infinite where none does
};

// What a kernel is called with, and the batch: -1 for a single value.
struct Inputs {
    motorcade::Rows rows[MOTORCADE_OPERANDS];
    nb::object held[MOTORCADE_OPERANDS];
    double numbers[MOTORCADE_OPERANDS][WIDEST];
    bool listed[MOTORCADE_OPERANDS] = {};
    int count = 0;
    int precision = NPY_NOTYPE;
    npy_intp batch = -1;

    bool agree(int type, npy_intp length) {
        if (precision == NPY_NOTYPE) precision = type;
        if (length >= 0 && batch < 0) batch = length;
        return precision == type && (length < 0 || (batch == length && 0 < length)) &&
               batch < SHORT;
    }

    // An array with `trailing` dimensions, two of them a square matrix, and at most one of batch.
    bool take_array(PyObject *given, int trailing, std::size_t width) {
        auto *array = reinterpret_cast<PyArrayObject *>(given);
        if (!PyArray_CheckExact(given)) return false;
        const int type = PyArray_TYPE(array), kept = PyArray_NDIM(array) - trailing;
        if ((type != NPY_DOUBLE && type != NPY_FLOAT) || !PyArray_ISBEHAVED_RO(array) || kept < 0 ||
            kept > 1)
            return false;
        const npy_intp *shape = PyArray_DIMS(array) + kept,
                       *strides = PyArray_STRIDES(array) + kept;
        npy_intp numbers = 1, step = PyArray_ITEMSIZE(array);
        if (trailing > 0) {
            numbers = shape[trailing - 1];
            step = strides[trailing - 1];
        }
        if (trailing == 2) {
            if (shape[0] != numbers || strides[0] != numbers * step) return false;
            numbers *= numbers;
        }
        if (numbers != static_cast<npy_intp>(width)) return false;
        const npy_intp length = kept ? PyArray_DIM(array, 0) : -1;
        const auto rows_given = static_cast<std::size_t>(kept ? length : 1);
        rows[count] = {PyArray_BYTES(array), rows_given,
                       kept ? PyArray_STRIDE(array, 0) : PyArray_ITEMSIZE(array), step, rows_given};
        return agree(type, length);
    }

    bool take_number(PyObject *given, double &number) {
        if (!PyFloat_CheckExact(given) && !PyLong_CheckExact(given)) return false;
        number = PyFloat_AsDouble(given);
        if (number != -1.0 || !PyErr_Occurred()) return true;
        PyErr_Clear();
        return false;
    }

    // Numbers in a list, which have the precision of the arrays beside them.
    bool take_list(PyObject *given, std::size_t width) {
        const bool list = PyList_CheckExact(given);
        if ((!list && !PyTuple_CheckExact(given)) || width > WIDEST) return false;
        if (PySequence_Size(given) != static_cast<Py_ssize_t>(width)) return false;
        for (std::size_t k = 0; k < width; ++k) {
            const auto at = static_cast<Py_ssize_t>(k);
            PyObject *item = list ? PyList_GetItem(given, at) : PyTuple_GetItem(given, at);
            if (!take_number(item, numbers[count][k])) return false;
        }
        return listed[count] = true;
    }

    // The letters of intrinsic Euler angles, as the kernels take them: three unit vectors, or with
    // `frame` the first, second and remaining axis and their handedness, of three different axes.
    bool take_sequence(PyObject *given, bool frame) {
        Py_ssize_t length = 0;
        const char *letters =
            PyUnicode_CheckExact(given) ? PyUnicode_AsUTF8AndSize(given, &length) : nullptr;
        if (length != 3) return PyErr_Clear(), false;
        int axes[3];
        for (int k = 0; k < 3; ++k) {
            axes[k] = letters[k] - 'x';
            if (axes[k] < 0 || axes[k] > 2 || (k > 0 && axes[k] == axes[k - 1])) return false;
        }
        if (frame && axes[0] == axes[2]) return false;
        std::fill_n(numbers[count], WIDEST, 0.0);
        for (int k = 0; k < 3; ++k) numbers[count][3 * k + axes[k]] = 1.0;
        if (frame) numbers[count][9] = (axes[1] - axes[0] + 3) % 3 == 1 ? 1.0 : -1.0;
        return listed[count] = true;
    }

    bool take(PyObject *given, char operand, std::size_t width, const Kind &own) {
        if (operand == SEQUENCE || operand == FRAME) return take_sequence(given, operand == FRAME);
        if (operand == 'v' || operand == 'r' || operand == 'm') {
            const Kind &kind = operand == 'v' ? own : kinds[operand == 'r' ? 0 : 1];
            if (Py_TYPE(given) != kind.type) return false;
            held[count] = nb::steal(PyObject_GetAttr(given, coefficients_name));
            return held[count].is_valid() && take_array(held[count].ptr(), 1, width);
        }
        if (operand == 'x') return take_array(given, 1, width) || take_list(given, width);
        if (operand == 's') return take_array(given, 2, width);
        if (!take_number(given, numbers[count][0]))
            return operand != 'p' && take_array(given, 0, width);
        return listed[count] = operand != 'p' || numbers[count][0] > 0.0;
    }

    void settle() {
        if (precision == NPY_NOTYPE) precision = NPY_DOUBLE;
        for (int k = 0; k < count; ++k) {
            if (!listed[k]) continue;
            auto *small = reinterpret_cast<float *>(numbers[k]);
            for (std::size_t j = 0; precision == NPY_FLOAT && j < WIDEST; ++j)
                small[j] = static_cast<float>(numbers[k][j]);
            const std::ptrdiff_t size = precision == NPY_FLOAT ? sizeof(float) : sizeof(double);
            rows[k] = {reinterpret_cast<char *>(numbers[k]), 1, size, size, 1};
        }
    }
};

// Where results of `width` numbers go: by rows, or one component after the other from a block on.
struct Output {
    int type;
    npy_intp batch;
    std::size_t width, count, padded;
    motorcade::Rows rows{};
    nb::object memory;  // what holds the numbers
    nb::object array;   // what is given, where that is not a view

    Output(int type_, npy_intp batch_, std::size_t width_)
        : type(type_), batch(batch_), width(width_),
          count(static_cast<std::size_t>(batch_ < 0 ? 1 : batch_)),
          padded(count < LANES ? 0 : (count + LANES - 1) / LANES * LANES) {}

    npy_intp size() const { return type == NPY_FLOAT ? sizeof(float) : sizeof(double); }
    npy_intp row_step() const { return padded ? size() : size() * static_cast<npy_intp>(width); }
    npy_intp step() const { return padded ? size() * static_cast<npy_intp>(padded) : size(); }

    bool allocate(bool sealed) {
        const npy_intp numbers = static_cast<npy_intp>(width * (padded ? padded : count));
        memory = nb::steal(sealed ? PyBytes_FromStringAndSize(nullptr, numbers * size())
                                  : PyArray_SimpleNew(1, &numbers, type));
        if (!memory.is_valid()) return false;
        char *first = sealed ? PyBytes_AsString(memory.ptr())
                             : PyArray_BYTES(reinterpret_cast<PyArrayObject *>(memory.ptr()));
        rows = {first, count, row_step(), step(), padded ? padded : count};
        return true;
    }

    template <typename Real> bool finite() const {
        const auto *first = reinterpret_cast<const Real *>(rows.first);
        if (!padded) return motorcade::all_finite(first, count * width);
        bool all = true;
        for (std::size_t k = 0; k < width; ++k)
            all = all && motorcade::all_finite(first + k * padded, count);
        return all;
    }

    // Whether the last number of all rows, which are of float64, lies between two.
    bool between(double above, double within) const {
        bool all = true;
        for (std::size_t row = 0; row < count; ++row) {
            const double last = *reinterpret_cast<const double *>(
                rows.first + static_cast<npy_intp>(row) * row_step() +
                static_cast<npy_intp>(width - 1) * step());
            all = all && above < last && last <= within;
        }
        return all;
    }

    // The first `kept` numbers of each row, as a square matrix where that is asked.
    PyObject *view(std::size_t kept, bool square, int flags) {
        const auto side = static_cast<npy_intp>(std::lround(std::sqrt(static_cast<double>(kept))));
        npy_intp shape[3] = {batch}, steps[3] = {row_step()};
        int dims = batch < 0 ? 0 : 1;
        if (square) {
            shape[dims] = side;
            steps[dims++] = side * step();
        }
        shape[dims] = square ? side : static_cast<npy_intp>(kept);
        steps[dims++] = step();
        PyObject *array = PyArray_New(&PyArray_Type, dims, shape, type, steps, rows.first, 0,
                                      flags | NPY_ARRAY_ALIGNED, nullptr);
        if (array &&
            PyArray_SetBaseObject(reinterpret_cast<PyArrayObject *>(array), memory.release().ptr()))
            Py_CLEAR(array);
        return array;
    }
};

const motorcade_kernel *find(const std::string &name) {
    const auto end = motorcade_kernels + motorcade_kernel_count;
    const auto at =
        std::find_if(motorcade_kernels, end, [&](const auto &k) { return name == k.name; });
    return at == end ? nullptr : at;
}

// With `into` an object that is being constructed, None.
PyObject *versor_of(PyTypeObject *type, PyObject *array, PyObject *into) {
    nb::object coefficients = nb::steal(array);
    if (!array) return nullptr;
    nb::object versor = into ? nb::borrow(into) : nb::steal(PyType_GenericAlloc(type, 0));
    if (!versor.is_valid() || PyObject_GenericSetAttr(versor.ptr(), coefficients_name, array) != 0)
        return nullptr;
    return into ? Py_NewRef(Py_None) : versor.release().ptr();
}

// Null without an error where the method is to be called.
PyObject *call_kernel(const FastPath &path, PyObject *const *given, std::size_t count) {
    const bool of_class = path.operands[0] == 'c';
    const auto *type = of_class ? reinterpret_cast<PyTypeObject *>(given[0]) : Py_TYPE(given[0]);
    const auto own =
        std::find_if(kinds, kinds + KINDS, [&](const Kind &k) { return k.type == type; });
    const motorcade_kernel *kernel = own == kinds + KINDS ? nullptr : path.kernels[own - kinds];
    if (!kernel) return nullptr;
    Inputs inputs;
    for (std::size_t k = 0; path.operands[k]; ++k) {
        if (path.operands[k] == 'c' || path.operands[k] == 'i') continue;
        const auto width = static_cast<std::size_t>(kernel->widths[inputs.count]);
        PyObject *argument = k < count ? given[k] : usual_sequence;
        if (!inputs.take(argument, path.operands[k], width, *own)) return nullptr;
        ++inputs.count;
    }
    inputs.settle();
    const bool single = inputs.precision == NPY_FLOAT,
               checked = std::isfinite(path.above) || std::isfinite(path.within);
    const bool versor = path.result == 'v' || path.result == 'i';
    if (checked && single) return nullptr;                        // whose tolerance is another
    if (path.result == 'i' && inputs.batch >= 0) return nullptr;  // which is kept in C order
    Output out(inputs.precision, inputs.batch,
               static_cast<std::size_t>(kernel->widths[kernel->inputs]));
    if (!out.allocate(versor)) return nullptr;
    inputs.rows[inputs.count] = out.rows;
    if (!motorcade::run(*kernel, inputs.rows, single, true, 1)) return nullptr;
    const std::size_t kept = out.width - (checked ? 1 : 0);
    if (checked && !out.between(path.above, path.within)) return nullptr;
    if (versor && !(single ? out.finite<float>() : out.finite<double>())) return nullptr;
    if (path.result == 'z')
        for (std::size_t k = 0; k < out.width * std::max(out.padded, out.count); ++k)
            single ? reinterpret_cast<float *>(out.rows.first)[k] += 0.0F
                   : reinterpret_cast<double *>(out.rows.first)[k] += 0.0;
    if (!versor && out.batch < 0 && path.result != 's') return out.memory.release().ptr();
    PyObject *array = out.view(kept, path.result == 's', versor ? 0 : NPY_ARRAY_WRITEABLE);
    return versor ? versor_of(own->type, array, path.result == 'i' ? given[0] : nullptr) : array;
}

PyObject *call(PyObject *self, PyObject *const *given, std::size_t flagged, PyObject *names) {
    const auto &path = *reinterpret_cast<FastPath *>(self);
    const auto count = static_cast<std::size_t>(PyVectorcall_NARGS(flagged)),
               most = std::strlen(path.operands);
    const char last = path.operands[most - 1];
    const bool shorter = count + 1 == most && (last == SEQUENCE || last == FRAME);
    if (!names && (count == most || shorter)) {
        PyObject *result = call_kernel(path, given, count);
        if (result || PyErr_Occurred()) return result;
    }
    return PyObject_Vectorcall(path.method, given, flagged, names);
}

PyObject *bind(PyObject *self, PyObject *object, PyObject *) {
    if (!object) return Py_NewRef(self);
    return PyObject_CallFunctionObjArgs(method_type, self, object, nullptr);
}

PyObject *attribute(PyObject *self, PyObject *name) {
    return PyObject_GetAttr(reinterpret_cast<FastPath *>(self)->method, name);
}

PyMemberDef members[] = {
    {"__vectorcalloffset__", T_PYSSIZET, offsetof(FastPath, call), READONLY, nullptr},
    {nullptr, 0, 0, 0, nullptr}};
PyType_Slot slots[] = {{Py_tp_call, reinterpret_cast<void *>(PyVectorcall_Call)},
                       {Py_tp_descr_get, reinterpret_cast<void *>(bind)},
                       {Py_tp_getattro, reinterpret_cast<void *>(attribute)},
                       {Py_tp_members, members},
                       {0, nullptr}};
PyType_Spec spec = {"motorcade.ga.kernels._compiled.FastPath", sizeof(FastPath), 0,
                    Py_TPFLAGS_DEFAULT | Py_TPFLAGS_HAVE_VECTORCALL | Py_TPFLAGS_METHOD_DESCRIPTOR,
                    slots};
PyTypeObject *fast_path_type = nullptr;

PyObject *make(PyObject *, PyObject *arguments) {
    PyObject *method = nullptr;
    const char *name = nullptr, *operands = nullptr, *result = nullptr;
    double above = 0.0, within = 0.0;
    if (!PyArg_ParseTuple(arguments, "Osssdd", &method, &name, &operands, &result, &above, &within))
        return nullptr;
    PyObject *made = PyType_GenericAlloc(fast_path_type, 0);
    if (!made) return nullptr;
    FastPath &path = *reinterpret_cast<FastPath *>(made);
    path.call = call;
    path.method = Py_NewRef(method);
    std::strncpy(path.operands, operands, sizeof path.operands - 1);
    path.result = result[0];
    path.above = above;
    path.within = within;
    for (std::size_t k = 0; k < KINDS; ++k) {
        path.kernels[k] = find(std::string(kinds[k].prefix) + name);
        if (!path.kernels[k]) path.kernels[k] = find(name);
    }
    return made;
}

}  // namespace

namespace motorcade {

void add_fast_paths(nb::module_ &module) {
    if (_import_array() < 0) throw nb::python_error();
    coefficients_name = PyUnicode_InternFromString("coefficients");
    usual_sequence = PyUnicode_InternFromString("xyz");
    method_type = nb::module_::import_("types").attr("MethodType").inc_ref().ptr();
    fast_path_type = reinterpret_cast<PyTypeObject *>(PyType_FromSpec(&spec));
    if (!fast_path_type) throw nb::python_error();
    module.def("register_versor", [](nb::type_object versor, std::size_t size) {
        for (Kind &kind : kinds)
            if (kind.size == size && !kind.type)
                kind.type = reinterpret_cast<PyTypeObject *>(versor.inc_ref().ptr());
    });
    static PyMethodDef made_by = {"fast_path", make, METH_VARARGS, nullptr};
    module.attr("fast_path") = nb::steal(PyCFunction_NewEx(&made_by, nullptr, nullptr));
}

}  // namespace motorcade
