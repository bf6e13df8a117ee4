// Binds rigs and meshes to Python. Arrays come checked and C-ordered; see motorcade.animation.skin
// and motorcade.animation.skin. The interpreter lock is released for meshes, not for poses,
// which take less time than handing it over.

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <chrono>
#include <stdexcept>
#include <tuple>

#include "rig.h"
#include "skin.h"

namespace nb = nanobind;
using namespace nb::literals;
using namespace motorcade::animation;

namespace {

template <class T, int dimensions>
using Array = nb::ndarray<T, nb::ndim<dimensions>, nb::c_contig, nb::device::cpu>;
using Layers = std::vector<std::tuple<nb::object, double, float>>;

void expect(bool holds, const char *what) {
    if (!holds) throw std::invalid_argument(what);
}

Mesh mesh_of(Array<const double, 2> positions, Array<const double, 2> normals,
             Array<const std::int64_t, 2> joints, Array<const double, 2> weights) {
    const std::size_t count = positions.shape(0);
    expect(positions.shape(1) == 3 && normals.shape(0) == count && normals.shape(1) == 3 &&
               joints.shape(0) == count && weights.shape(0) == count &&
               (joints.shape(1) == 4 || joints.shape(1) == 8) &&
               weights.shape(1) == joints.shape(1),
           "Mesh: expected positions and normals (V, 3), joints and weights (V, 4) or (V, 8)");
    return Mesh(positions.data(), normals.data(), joints.data(), weights.data(), count,
                joints.shape(1));
}

void reshape(Mesh &mesh, Array<const double, 2> positions, Array<const double, 2> normals) {
    expect(positions.shape(0) == mesh.count() && positions.shape(1) == 3 &&
               normals.shape(0) == mesh.count() && normals.shape(1) == 3,
           "Mesh.reshape: expected positions and normals (V, 3)");
    mesh.reshape(positions.data(), normals.data());
}

void skin(const Mesh &mesh, Skinning method, Array<const float, 2> palette,
          Array<float, 2> positions, Array<float, 2> normals, unsigned threads) {
    expect(palette.shape(1) == palette_width(method) && palette.shape(0) >= mesh.joints(),
           "palette: expected a row a joint, of 8 or 12 numbers as the method has them");
    expect(positions.shape(0) == mesh.count() && positions.shape(1) == 3 &&
               normals.shape(0) == mesh.count() && normals.shape(1) == 3,
           "positions, normals: expected (V, 3)");
    nb::gil_scoped_release unlocked;
    mesh.skin(method, palette.data(), positions.data(), normals.data(), threads);
}

[[noreturn]] void refuse(const std::string &wanted, nb::handle came) {
    throw std::invalid_argument("layers: expected " + wanted + ", got " + nb::repr(came).c_str());
}

// Which clip, by an integer of Python's or of an array's; the rig checks its range.
std::ptrdiff_t number_of(nb::handle clip) {
    const std::string wanted = "an integer as the number of a clip";
    if (!PyIndex_Check(clip.ptr()) || PyBool_Check(clip.ptr())) refuse(wanted, clip);
    const Py_ssize_t number = PyNumber_AsSsize_t(clip.ptr(), nullptr);
    if (number == -1 && PyErr_Occurred()) {
        PyErr_Clear();
        refuse(wanted, clip);
    }
    return number;
}

std::vector<Layer> layers_of(nb::handle given) {
    Layers tuples;
    if (!nb::try_cast<Layers>(given, tuples))
        refuse("(number of a clip, time_s, weight) for each layer", given);
    std::vector<Layer> layers;
    layers.reserve(tuples.size());
    for (const auto &[clip, time_s, weight] : tuples)
        layers.push_back({number_of(clip), time_s, weight});
    return layers;
}

void pose(Rig &rig, nb::handle layers, bool by_screw, const std::string &kind, nb::handle given) {
    const bool matrices = kind == "matrix";
    Array<float, 2> out;
    // Never converted: a copy would take the result.
    expect(nb::try_cast(given, out, false) && out.shape(0) == rig.joints() &&
               out.shape(1) == (matrices ? 12U : 8U),
           "out: expected a row a joint, of 12 numbers for matrices and 8 for motors, in writable "
           "float32 and C order");
    rig.blend(layers_of(layers), by_screw);
    if (matrices)
        rig.palette_matrices(out.data());
    else if (kind == "motor")
        rig.palette_motors(out.data());
    else
        rig.local(out.data());
}

// Seconds that `times` poses take without Python's share, for measurements.
double repeat(Rig &rig, nb::handle layers, bool by_screw, const std::string &kind,
              Array<float, 2> out, std::size_t times) {
    pose(rig, layers, by_screw, kind, out.cast());
    std::vector<Layer> moving = layers_of(layers);
    const auto start = std::chrono::steady_clock::now();
    for (std::size_t k = 0; k < times; ++k) {
        for (Layer &layer : moving) layer.time_s += 1.0 / 60.0;
        rig.blend(moving, by_screw);
        if (kind == "matrix")
            rig.palette_matrices(out.data());
        else if (kind == "motor")
            rig.palette_motors(out.data());
    }
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace

NB_MODULE(_runtime, module) {
    module.doc() = "Posing and skinning; see motorcade.animation.";
    nb::enum_<Skinning>(module, "Skinning")
        .value("matrix", Skinning::matrix)
        .value("dual_quaternion", Skinning::dual_quaternion)
        .value("motor", Skinning::motor)
        .value("similarity", Skinning::similarity);
    nb::class_<Mesh>(module, "Mesh")
        .def(nb::new_(&mesh_of), "positions"_a, "normals"_a, "joints"_a, "weights"_a)
        .def("reshape", &reshape, "positions"_a, "normals"_a)
        .def("skin", &skin, "method"_a, "palette"_a.noconvert(), "positions"_a.noconvert(),
             "normals"_a.noconvert(), "threads"_a);
    nb::class_<Rig>(module, "Rig")
        .def(
            "__init__",
            [](Rig *self, Array<const std::int64_t, 1> parents,
               Array<const double, 2> inverse_rest) {
                expect(inverse_rest.shape(0) == parents.shape(0) && inverse_rest.shape(1) == 8,
                       "inverse_rest: expected (J, 8)");
                new (self) Rig(parents.data(), inverse_rest.data(), parents.shape(0));
            },
            "parents"_a, "inverse_rest"_a)
        .def(
            "add",
            [](Rig &rig, Array<const double, 1> time_s, Array<const double, 3> poses, bool looped) {
                expect(poses.shape(0) == time_s.shape(0) && poses.shape(0) > 0 &&
                           poses.shape(1) == rig.joints() && poses.shape(2) == 8,
                       "poses: expected (F, J, 8)");
                return rig.add({time_s.data(), time_s.shape(0)}, poses.data(), looped);
            },
            "time_s"_a, "poses"_a, "looped"_a)
        .def("pose", &pose, "layers"_a.none(), "by_screw"_a, "kind"_a, "out"_a)
        .def("repeat", &repeat, "layers"_a.none(), "by_screw"_a, "kind"_a, "out"_a.noconvert(),
             "times"_a);
}
