// Binds inverse kinematics to Python. Arrays come checked and C-ordered; see
// motorcade.animation.ik. The interpreter lock is released for batches, not for one pose, which
// takes about as long as handing it over.

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <algorithm>
#include <stdexcept>

#include "fabrik.h"
#include "ik.h"

namespace nb = nanobind;
using namespace nb::literals;
using namespace motorcade::animation::ik;

namespace {

template <class T, int dimensions>
using Array = nb::ndarray<T, nb::ndim<dimensions>, nb::c_contig, nb::device::cpu>;

void expect(bool holds, const char *what) {
    if (!holds) throw std::invalid_argument(what);
}

Vector vector_at(const double *from) { return {from[0], from[1], from[2]}; }

Solver solver_of(Array<const std::int64_t, 1> parents, Array<const double, 2> rest,
                 Array<const std::int64_t, 1> kinds, Array<const std::int64_t, 1> numbers,
                 Array<const double, 3> axes, Array<const double, 2> limits) {
    const std::size_t count = kinds.shape(0), joints = parents.shape(0);
    expect(rest.shape(0) == joints && rest.shape(1) == 8, "rest: expected (J, 8)");
    expect(numbers.shape(0) == count && axes.shape(0) == count && axes.shape(1) == 3 &&
               axes.shape(2) == 3 && limits.shape(0) == count && limits.shape(1) == 4,
           "kinds, numbers, axes, limits: expected (D,), (D,), (D, 3, 3), (D, 4)");
    std::vector<Joint> made;
    for (std::size_t k = 0; k < count; ++k) {
        const double *axis = axes.data() + 9 * k, *limit = limits.data() + 4 * k;
        const std::int64_t number = numbers.data()[k];
        expect(number >= 0 && static_cast<std::size_t>(number) < joints &&
                   (k == 0 || number > numbers.data()[k - 1]),
               "numbers: expected rising numbers of the skeleton's joints");
        expect(kinds.data()[k] >= 0 && kinds.data()[k] < 4, "kinds: expected 0 to 3");
        made.push_back({static_cast<Kind>(kinds.data()[k]),
                        static_cast<std::size_t>(number),
                        vector_at(axis),
                        vector_at(axis + 3),
                        vector_at(axis + 6),
                        {limit[0], limit[1]},
                        limit[2],
                        limit[3]});
    }
    for (std::size_t j = 0; j < joints; ++j)
        expect(parents.data()[j] >= -1 && parents.data()[j] < static_cast<std::int64_t>(j),
               "parents: expected -1 or the number of an earlier joint");
    return Solver(parents.data(), rest.data(), joints, std::move(made));
}

std::vector<Goal> goals_of(const Solver &solver, Array<const std::int64_t, 2> aims,
                           Array<const double, 2> marks) {
    const std::size_t count = aims.shape(0);
    expect(aims.shape(1) == 2 && marks.shape(0) == count && marks.shape(1) == 7,
           "aims, marks: expected (G, 2) and (G, 7)");
    std::vector<Goal> made;
    for (std::size_t g = 0; g < count; ++g) {
        const std::int64_t *aim = aims.data() + 2 * g;
        const double *mark = marks.data() + 7 * g;
        expect(aim[0] >= 0 && aim[0] < 3 && aim[1] >= 0 &&
                   static_cast<std::size_t>(aim[1]) < solver.skeleton_size(),
               "aims: expected a kind from 0 to 2 and a joint of the skeleton");
        made.push_back({static_cast<Aim>(aim[0]), static_cast<std::size_t>(aim[1]), vector_at(mark),
                        vector_at(mark + 3), mark[6]});
    }
    return made;
}

// Poses (B, J, 8) and targets (B, G, 7), points and rotors, into poses, residuals (B, G, 3), and
// how hard goals press on limits (B, G, D, 2). Returns the rounds that all took together.
std::size_t solve(const Solver &solver, Array<const double, 3> local,
                  Array<const std::int64_t, 2> aims, Array<const double, 2> marks,
                  Array<const double, 3> targets, double tolerance, std::size_t restarts,
                  Array<double, 3> poses, Array<double, 3> residuals, Array<double, 4> presses) {
    const std::vector<Goal> goals = goals_of(solver, aims, marks);
    const std::size_t batch = local.shape(0), size = solver.skeleton_size(), count = goals.size();
    const std::size_t turning = solver.joints().size();
    expect(local.shape(1) == size && local.shape(2) == 8 && poses.shape(0) == batch &&
               poses.shape(1) == size && poses.shape(2) == 8,
           "local, poses: expected (B, J, 8)");
    expect(targets.shape(0) == batch && targets.shape(1) == count && targets.shape(2) == 7 &&
               residuals.shape(0) == batch && residuals.shape(1) == count &&
               residuals.shape(2) == 3 && presses.shape(0) == batch && presses.shape(1) == count &&
               presses.shape(2) == turning && presses.shape(3) == 2,
           "targets, residuals, presses: expected (B, G, 7), (B, G, 3), (B, G, D, 2)");
    std::size_t rounds = 0;
    std::vector<Target> wanted(count);
    const auto all = [&] {
        for (std::size_t b = 0; b < batch; ++b) {
            const double *from = targets.data() + 7 * count * b;
            for (std::size_t g = 0; g < count; ++g, from += 7)
                wanted[g] = {vector_at(from), {from[3], from[4], from[5], from[6]}};
            const Solved found = solver.solve(local.data() + 8 * size * b, goals, wanted,
                                              {tolerance, restarts}, poses.data() + 8 * size * b);
            for (std::size_t g = 0; g < count; ++g)
                std::copy_n(found.residuals[g].begin(), 3, residuals.data() + 3 * (b * count + g));
            std::copy(found.presses.begin(), found.presses.end(),
                      presses.data() + 2 * turning * count * b);
            rounds += found.rounds;
        }
    };
    if (batch == 1) {
        all();
    } else {
        nb::gil_scoped_release unlocked;
        all();
    }
    return rounds;
}

// Chains (B, N, 3) solved in place; errors (B,) are written. Returns the most rounds of one.
std::size_t fabrik(Array<double, 3> points, Array<const double, 2> targets,
                   Array<const double, 2> directions, Array<const double, 1> limits,
                   double tolerance, Array<double, 1> errors) {
    const std::size_t batch = points.shape(0), count = points.shape(1);
    expect(count >= 2 && points.shape(2) == 3 && limits.shape(0) + 1 == count,
           "points, limits: expected (B, N, 3) and (N - 1,), N at least 2");
    expect(targets.shape(0) == batch && targets.shape(1) == 3 && directions.shape(0) == batch &&
               directions.shape(1) == 3 && errors.shape(0) == batch,
           "targets, directions, errors: expected (B, 3), (B, 3), (B,)");
    std::size_t most = 0;
    bool long_enough = true;
    const auto all = [&] {
        Fabrik solver({limits.data(), limits.shape(0)}, tolerance);
        for (std::size_t b = 0; b < batch && long_enough; ++b) {
            std::size_t rounds = 0;
            long_enough =
                solver.solve(points.data() + 3 * count * b, vector_at(targets.data() + 3 * b),
                             vector_at(directions.data() + 3 * b), errors.data()[b], rounds);
            most = std::max(most, rounds);
        }
    };
    if (batch == 1) {
        all();
    } else {
        nb::gil_scoped_release unlocked;
        all();
    }
    expect(long_enough, "fabrik(points): expected chains longer than 0");
    return most;
}

}  // namespace

NB_MODULE(_ik, module) {
    module.doc() = "Inverse kinematics; see motorcade.animation.ik.";
    nb::class_<Solver>(module, "Solver")
        .def(nb::new_(&solver_of), "parents"_a, "rest"_a, "kinds"_a, "numbers"_a, "axes"_a,
             "limits"_a)
        .def_prop_ro("size_m", &Solver::size_m)
        .def("solve", &solve, "local"_a, "aims"_a, "marks"_a, "targets"_a, "tolerance"_a,
             "restarts"_a, "poses"_a.noconvert(), "residuals"_a.noconvert(),
             "presses"_a.noconvert());
    module.def("fabrik", &fabrik, "points"_a.noconvert(), "targets"_a, "directions"_a, "limits"_a,
               "tolerance"_a, "errors"_a.noconvert());
}
