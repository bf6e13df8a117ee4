// Binds the splines of columns and the longest smooth chain of poses to Python. Arrays come checked
// and C-ordered; see motorcade.fusion.smoothing.batch.columns and .inliers. The interpreter lock is
// released.

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <stdexcept>
#include <utility>
#include <vector>

#include "columns.h"
#include "inliers.h"

namespace nb = nanobind;
using namespace nb::literals;
using namespace motorcade::smooth;

namespace {

using Numbers = nb::ndarray<const double, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using Places = nb::ndarray<const std::int64_t, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using Rows = nb::ndarray<const double, nb::ndim<2>, nb::c_contig, nb::device::cpu>;
using Made = nb::ndarray<double, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using MadeRows = nb::ndarray<double, nb::ndim<2>, nb::c_contig, nb::device::cpu>;
using MadeShocks = nb::ndarray<double, nb::ndim<3>, nb::c_contig, nb::device::cpu>;
using Marks = nb::ndarray<bool, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
// Noise and density of white acceleration.
using Pair = std::pair<double, double>;
using Out = std::tuple<MadeRows, MadeRows, Made, Made>;

void expect(bool holds, const char *what) {
    if (!holds) throw std::invalid_argument(what);
}

// Calls `action.template operator()<N>()` for that of the sizes which is given, if there is one.
template <std::size_t... Sizes, class Action>
bool with_size(std::index_sequence<Sizes...>, std::size_t given, Action &&action) {
    return ((Sizes == given && (action.template operator()<Sizes>(), true)) || ...);
}

nb::tuple spline(const Numbers &time_s, const Rows &values, const Numbers &weights,
                 const Places &jumps, int order, double density, double memory_s,
                 const std::optional<Out> &out, const std::optional<MadeShocks> &shocks) {
    const std::size_t count = time_s.shape(0), columns = values.shape(1);
    expect(values.shape(0) == count && weights.shape(0) == count,
           "columns: expected stamps, values and weights of equal length");
    const std::size_t used = static_cast<std::size_t>(std::count_if(
        weights.data(), weights.data() + count, [](double one) { return one > 0.0; }));
    expect(order >= 0 && order <= 3, "order: expected 0 to 3");
    expect(used > static_cast<std::size_t>(order),
           "weights: expected more values than derivatives");
    std::optional<Spline> made;
    if (out) {
        const auto &[smoothed, left_out, variance, spread] = *out;
        expect(smoothed.shape(0) == count && smoothed.shape(1) == columns &&
                   variance.shape(0) == count && left_out.shape(0) == count &&
                   left_out.shape(1) == columns && spread.shape(0) == count,
               "out: expected arrays as large as the values");
        expect(!shocks || (shocks->shape(0) == count && shocks->shape(1) == columns &&
                           shocks->shape(2) == 2),
               "shocks: expected two numbers a value");
        made = Spline{smoothed.data(), left_out.data(), variance.data(), spread.data(),
                      shocks ? shocks->data() : nullptr};
    }
    const Column given{time_s.data(), values.data(), weights.data(),
                       count,         jumps.data(),  jumps.shape(0)};
    double rows = 0.0, logarithms = 0.0;
    std::vector<double> squares;
    // Innovations of as many columns as there are; their number is one of the program's own.
    const auto run = [&]<std::size_t Order, std::size_t D>() {
        const auto of_noise = [&]<bool COLOURED>() {
            Columns<Order, D, COLOURED> splines(given, density, memory_s);
            return made ? splines.smooth(*made) : splines.filter();
        };
        const auto found = memory_s > 0.0 ? of_noise.template operator()<true>()
                                          : of_noise.template operator()<false>();
        rows = found.rows, logarithms = found.logarithms;
        squares.assign(found.squares.begin(), found.squares.end());
    };
    {
        nb::gil_scoped_release unlocked;
        with_size(std::index_sequence<0, 1, 2, 3>{}, order, [&]<std::size_t Order>() {
            expect(with_size(std::index_sequence<1, 6, 7, 8, 9>{}, columns,
                             [&]<std::size_t D>() { run.template operator()<Order, D>(); }),
                   "values: expected 1, or 6 to 9 columns");
        });
    }
    return nb::make_tuple(rows, squares, logarithms);
}

void chain(const Numbers &time_s, const Rows &poses, const Pair &rotation, const Pair &translation,
           const Marks &kept) {
    const std::size_t count = time_s.shape(0);
    expect(count > 2 && poses.shape(0) == count && poses.shape(1) == 8 && kept.shape(0) == count,
           "poses: expected three or more, with a stamp and a mark each");
    nb::gil_scoped_release unlocked;
    InlierChain(
        {time_s.data(), poses.data(), count},
        {Sizes{rotation.first, rotation.second}, Sizes{translation.first, translation.second}})
        .mark(kept.data());
}

}  // namespace

NB_MODULE(_columns, module) {
    module.doc() = "Smoothing splines of columns; see motorcade.fusion.smoothing.batch.";
    module.def("spline", &spline, "time_s"_a, "values"_a, "weights"_a, "jumps"_a, "order"_a,
               "density"_a, "memory_s"_a, "out"_a = nb::none(), "shocks"_a = nb::none());
    module.def("chain", &chain, "time_s"_a, "poses"_a, "rotation"_a, "translation"_a, "kept"_a);
}
