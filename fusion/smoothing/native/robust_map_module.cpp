// Binds the descent to the most probable path to Python. Arrays come checked and C-ordered; see
// motorcade.fusion.smoothing.batch.inliers. The interpreter lock is released.

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>

#include <stdexcept>

#include "robust_map.h"

namespace nb = nanobind;
using namespace nb::literals;
using namespace motorcade::smooth;

namespace {

template <class T, std::size_t Dimensions>
using Array = nb::ndarray<T, nb::ndim<Dimensions>, nb::c_contig, nb::device::cpu>;
using Numbers = Array<const double, 1>;
// Name of the representation, whether a scale stands beside it.
using Kind = std::pair<std::string, bool>;
// Intervals (N - 1), coordinates (N, D), which of them count (N), noise (d), density (d).
using Measured =
    std::tuple<Numbers, Array<const double, 2>, Array<const bool, 1>, Numbers, Numbers>;
using NamedLoss = std::pair<std::string, double>;
// Coordinates (N, D) and velocities (N, d).
using State = std::pair<Array<double, 2>, Array<double, 2>>;

void expect(bool holds, const char *what) {
    if (!holds) throw std::invalid_argument(what);
}

// Calls `action.template operator()<R>()` for how a representation's coordinates move: angles of
// any order, numbers that are added, all move alike.
template <class Action> auto with_moves(const Kind &kind, Action &&action) {
    const auto &[name, scale] = kind;
    if (name == Similarities::name) return action.template operator()<Similarities>();
    return with_named<Motors, Rotors, Quaternions, DualQuaternions, EulerAngles>(
        name.starts_with(EulerAngles::name) ? EulerAngles::name : name, scale, action);
}

RobustLoss loss_of(const NamedLoss &given) {
    const auto &[name, width] = given;
    if (name == "cauchy") return {Loss::cauchy, width};
    if (name == "huber") return {Loss::huber, width};
    expect(name == "squares", "loss: expected cauchy, huber or squares");
    return {Loss::squares, width};
}

template <Representation R> MeasuredPath path_of(const Measured &measured, const State &state) {
    const auto &[interval_s, coordinates, among, noise, density] = measured;
    const auto &[poses, velocity] = state;
    const std::size_t count = coordinates.shape(0);
    expect(count > 1 && interval_s.shape(0) + 1 == count && among.shape(0) == count &&
               poses.shape(0) == count && velocity.shape(0) == count,
           "path: expected intervals, poses and velocities of equal length");
    expect(coordinates.shape(1) == R::size && poses.shape(1) == R::size &&
               velocity.shape(1) == R::freedom && noise.shape(0) == R::freedom &&
               density.shape(0) == R::freedom,
           "path: expected rows of the representation's size");
    return {count,        interval_s.data(), coordinates.data(),
            among.data(), noise.data(),      density.data()};
}

// Lowers the cost of a state, in place, and writes what its poses are charged for; the cost.
double descend(const Kind &kind, const Measured &measured, const NamedLoss &loss,
               const State &state, int steps, double converged, const Array<double, 1> &squares) {
    return with_moves(kind, [&]<class R>() {
        const MeasuredPath path = path_of<R>(measured, state);
        expect(squares.shape(0) == path.count, "squares: expected one a pose");
        const RobustLoss charged = loss_of(loss);
        nb::gil_scoped_release unlocked;
        RobustDescent<R> descent(path, charged);
        descent.start(state.first.data(), state.second.data());
        descent.descend(steps, converged);
        descent.write(state.first.data(), state.second.data(), squares.data());
        return descent.cost();
    });
}

// Writes the whole step downhill (N, 2 d), and takes columns (N, 2 d, k) by the inverse of the
// normal equations at a state.
void step(const Kind &kind, const Measured &measured, const NamedLoss &loss, const State &state,
          const Array<double, 2> &downhill, const Array<double, 3> &columns) {
    with_moves(kind, [&]<class R>() {
        const MeasuredPath path = path_of<R>(measured, state);
        const std::size_t each = columns.shape(2), size = 2 * R::freedom;
        expect(downhill.shape(0) == path.count && downhill.shape(1) == size &&
                   columns.shape(0) == path.count && columns.shape(1) == size,
               "step: expected rows of 2 d numbers");
        const RobustLoss charged = loss_of(loss);
        nb::gil_scoped_release unlocked;
        RobustDescent<R> descent(path, charged);
        descent.start(state.first.data(), state.second.data());
        descent.factor(0.0, false);
        std::copy(descent.moves().begin(), descent.moves().end(), downhill.data());
        descent.solve(downhill.data(), 1);
        for (std::size_t k = 0; k < each; ++k) descent.solve(columns.data() + k, each);
    });
}

}  // namespace

NB_MODULE(_robust_map, module) {
    module.doc() = "The most probable path; see motorcade.fusion.smoothing.batch.robust_map.";
    module.def("descend", &descend, "kind"_a, "measured"_a, "loss"_a, "state"_a, "steps"_a,
               "converged"_a, "squares"_a);
    module.def("step", &step, "kind"_a, "measured"_a, "loss"_a, "state"_a, "downhill"_a,
               "columns"_a);
}
