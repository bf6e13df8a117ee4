// Binds the equations of reprojection, and blocks that are eliminated, to Python; see
// motorcade.tracking.optimise and motorcade.tracking.slam.

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <stdexcept>
#include <string>
#include <vector>

#include "blocks.h"
#include "reprojection.h"

namespace nb = nanobind;
using namespace nb::literals;
using namespace motorcade::adjusting;

namespace {

template <class... Shape>
using Given = nb::ndarray<const double, Shape..., nb::c_contig, nb::device::cpu>;
using Row = Given<nb::ndim<1>>;
using Rows = Given<nb::ndim<2>>;
using Cubes = Given<nb::ndim<3>>;
using Pixels = Given<nb::shape<-1, 2>>;
using Points = Given<nb::shape<-1, 3>>;
using Matrix = Given<nb::shape<4, 4>>;
using Matrices = Given<nb::shape<-1, 4, 4>>;
using Owners = nb::ndarray<const std::int64_t, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using Made = nb::ndarray<nb::numpy, double>;

// Zeros of a shape, which Python owns.
struct Zeros {
    double *data;
    Made array;

    explicit Zeros(std::vector<std::size_t> shape) {
        std::size_t count = 1;
        for (const std::size_t n : shape) count *= n;
        data = new double[count]();
        nb::capsule owner(data, [](void *made) noexcept { delete[] static_cast<double *>(made); });
        array = Made(data, shape.size(), shape.data(), owner);
    }
};

void check(bool right, const char *otherwise) {
    if (!right) throw std::invalid_argument(otherwise);
}

void check_owners(const Owners &owners, std::size_t length, std::size_t count, const char *name) {
    const bool right = owners.shape(0) == length &&
                       std::all_of(owners.data(), owners.data() + length, [count](auto owner) {
                           return owner >= 0 && static_cast<std::size_t>(owner) < count;
                       });
    if (!right)
        throw std::invalid_argument(std::string(name) + ": expected a row that is there for each");
}

Lens lens_of(const std::string &model, double fx, double fy, double cx, double cy,
             const std::vector<double> &distortion) {
    check(distortion.size() <= 8, "distortion: expected up to 8 numbers");
    Lens lens{Model::pinhole, fx, fy, cx, cy, {}};
    if (model == "radtan")
        lens.model = Model::radtan;
    else if (model == "equidistant")
        lens.model = Model::equidistant;
    else
        check(model == "pinhole", "model: expected pinhole, radtan or equidistant");
    std::copy(distortion.begin(), distortion.end(), lens.k.begin());
    return lens;
}

// All that stays while poses and points move.
struct Sight {
    Lens lens;
    Owners pose_of, point_of, slot;
    Pixels px;
    Row depth;
    double disparity, huber, nearest;

    Observations at(const Matrices &poses, const Points &points) const {
        const std::size_t count = px.shape(0);
        check(depth.shape(0) == count, "depth: expected one for each pixel");
        check(slot.shape(0) == poses.shape(0), "slot: expected one for each pose");
        check_owners(pose_of, count, poses.shape(0), "pose_of");
        check_owners(point_of, count, points.shape(0), "point_of");
        return {lens,        poses.data(), points.data(), pose_of.data(), point_of.data(),
                slot.data(), px.data(),    depth.data(),  count,          disparity,
                huber,       nearest};
    }
};

nb::tuple evaluate_sight(const Sight &sight, Matrices poses, Points points) {
    const Observations seen = sight.at(poses, points);
    const Zeros error_px({seen.count});
    double cost = 0.0;
    {
        nb::gil_scoped_release unlocked;
        cost = evaluate(seen, error_px.data);
    }
    return nb::make_tuple(cost, error_px.array);
}

nb::tuple linearise_sight(const Sight &sight, Matrices poses, Points points) {
    const Observations seen = sight.at(poses, points);
    const std::int64_t *slots = sight.slot.data();
    std::int64_t free = 0;
    for (std::size_t k = 0; k < poses.shape(0); ++k) {
        check(slots[k] == -1 || slots[k] == free, "slot: expected -1, or numbers from 0 on");
        free += slots[k] >= 0;
    }
    std::size_t coupled = 0;
    for (std::size_t k = 0; k < seen.count; ++k) coupled += slots[seen.pose_of[k]] >= 0;
    const std::size_t kept = static_cast<std::size_t>(free), count = points.shape(0);
    const Zeros information({kept, 6, 6}), gradient({kept, 6}), blocks({count, 3, 3}),
        block_gradient({count, 3}), coupling({coupled, 3, 6});
    {
        nb::gil_scoped_release unlocked;
        linearise(seen, information.data, gradient.data, blocks.data, block_gradient.data,
                  coupling.data);
    }
    return nb::make_tuple(information.array, gradient.array, blocks.array, block_gradient.array,
                          coupling.array);
}

// Points and pixels of one pose.
struct View {
    Lens lens;
    Points points;
    Pixels px;
    double huber, outlier;

    Fit fit() const {
        check(points.shape(0) == px.shape(0), "px: expected one for each point");
        return {lens, points.data(), px.data(), px.shape(0), huber, outlier};
    }
};

nb::tuple evaluate_view(const View &view, Matrix camera_T_world) {
    const Fit fit = view.fit();
    const Zeros error_px({fit.count});
    const double cost = evaluate(fit, pose_of(camera_T_world.data()), error_px.data);
    return nb::make_tuple(cost, error_px.array);
}

nb::tuple refine_view(const View &view, Given<nb::shape<8>> world_T_camera, int steps, double gain,
                      double damping, double most_damping) {
    const Fit fit = view.fit();
    const Zeros error_px({fit.count}), made({8});
    Motor start;
    std::copy_n(world_T_camera.data(), 8, start.data());
    {
        nb::gil_scoped_release unlocked;
        const Stop stop{steps, gain, damping, most_damping};
        const Motor found = refine(fit, start, stop, error_px.data);
        std::copy(found.begin(), found.end(), made.data);
    }
    return nb::make_tuple(made.array, error_px.array);
}

nb::tuple linearise_view(const View &view, Matrix camera_T_world, double most_px) {
    const Zeros information({6, 6}), gradient({6});
    linearise(view.fit(), pose_of(camera_T_world.data()), most_px, information.data, gradient.data);
    return nb::make_tuple(information.array, gradient.array);
}

Blocks blocks_of(const Cubes &inverted, const Rows &gradient, const Owners &block_of,
                 const Owners &group_of, const Cubes &coupling, std::size_t kept) {
    const std::size_t count = inverted.shape(0), size = inverted.shape(1);
    const std::size_t couplings = coupling.shape(0), width = coupling.shape(2);
    check(inverted.shape(2) == size && gradient.shape(0) == count && gradient.shape(1) == size &&
              (couplings == 0 || coupling.shape(1) == size),
          "blocks: expected gradients and couplings of their number and size");
    check_owners(block_of, couplings, count, "block_of");
    check_owners(group_of, couplings, width == 0 ? 0 : kept / width, "group_of");
    return {count,           size,
            width,           couplings,
            inverted.data(), gradient.data(),
            coupling.data(), block_of.data(),
            group_of.data()};
}

// Of symmetric matrices; None where one has no inverse.
nb::object invert_blocks(Cubes blocks) {
    check(blocks.shape(1) == blocks.shape(2), "blocks: expected square ones");
    const Zeros made({blocks.shape(0), blocks.shape(1), blocks.shape(1)});
    std::copy_n(blocks.data(), blocks.size(), made.data);
    if (!invert(made.data, blocks.shape(0), blocks.shape(1))) return nb::none();
    return nb::cast(made.array);
}

nb::tuple eliminate_blocks(Cubes inverted, Rows gradient, Owners block_of, Owners group_of,
                           Cubes coupling, Rows information, Row right) {
    const std::size_t kept = right.shape(0);
    check(information.shape(0) == kept && information.shape(1) == kept,
          "information: expected a square of the gradient's size");
    const Blocks blocks = blocks_of(inverted, gradient, block_of, group_of, coupling, kept);
    const Zeros matrix({kept, kept}), left({kept});
    std::copy_n(information.data(), kept * kept, matrix.data);
    std::copy_n(right.data(), kept, left.data);
    {
        nb::gil_scoped_release unlocked;
        eliminate(blocks, matrix.data, kept, left.data);
    }
    return nb::make_tuple(matrix.array, left.array);
}

Made substitute_blocks(Cubes inverted, Rows gradient, Owners block_of, Owners group_of,
                       Cubes coupling, Row kept) {
    const Blocks blocks =
        blocks_of(inverted, gradient, block_of, group_of, coupling, kept.shape(0));
    const Zeros step({blocks.count, blocks.size});
    substitute(blocks, kept.data(), step.data);
    return step.array;
}

}  // namespace

NB_MODULE(_least_squares, module) {
    module.doc() = "Equations of reprojection; see motorcade.tracking.optimise.";
    nb::class_<Lens>(module, "Lens")
        .def(
            "__init__",
            [](Lens *made, const std::string &model, double fx, double fy, double cx, double cy,
               const std::vector<double> &distortion) {
                new (made) Lens(lens_of(model, fx, fy, cx, cy, distortion));
            },
            "model"_a, "fx"_a, "fy"_a, "cx"_a, "cy"_a, "distortion"_a);
    nb::class_<Sight>(module, "Sight")
        .def(
            "__init__",
            [](Sight *made, const Lens &lens, Owners pose_of, Owners point_of, Owners slot,
               Pixels px, Row depth, double disparity, double huber, double nearest) {
                new (made)
                    Sight{lens, pose_of, point_of, slot, px, depth, disparity, huber, nearest};
            },
            "lens"_a, "pose_of"_a, "point_of"_a, "slot"_a, "px"_a, "depth"_a, "disparity"_a,
            "huber"_a, "nearest"_a)
        .def("evaluate", &evaluate_sight, "camera_T_world"_a, "points"_a)
        .def("linearise", &linearise_sight, "camera_T_world"_a, "points"_a);
    nb::class_<View>(module, "View")
        .def(
            "__init__",
            [](View *made, const Lens &lens, Points points, Pixels px, double huber,
               double outlier) {
                new (made) View{lens, points, px, huber, outlier};
            },
            "lens"_a, "points"_a, "px"_a, "huber"_a, "outlier"_a)
        .def("evaluate", &evaluate_view, "camera_T_world"_a)
        .def("refine", &refine_view, "world_T_camera"_a, "steps"_a, "gain"_a, "damping"_a,
             "most_damping"_a)
        .def("linearise", &linearise_view, "camera_T_world"_a, "most_px"_a);
    module.def("invert", &invert_blocks, "blocks"_a);
    module.def("eliminate", &eliminate_blocks, "inverted"_a, "gradient"_a, "block_of"_a,
               "group_of"_a, "coupling"_a, "information"_a, "right"_a);
    module.def("substitute", &substitute_blocks, "inverted"_a, "gradient"_a, "block_of"_a,
               "group_of"_a, "coupling"_a, "kept"_a);
}
