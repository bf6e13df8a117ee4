// Binds the splines of columns to Python. Arrays come checked and C-ordered; see
// motorcade.fusion.smoothing.batch.columns. The interpreter lock is released.

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/tuple.h>

#include <algorithm>
#include <stdexcept>

#include "columns.h"

namespace nb = nanobind;
using namespace nb::literals;
using namespace motorcade::smooth;

namespace {

using Numbers = nb::ndarray<const double, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using Rows = nb::ndarray<const double, nb::ndim<2>, nb::c_contig, nb::device::cpu>;
using Made = nb::ndarray<double, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using MadeRows = nb::ndarray<double, nb::ndim<2>, nb::c_contig, nb::device::cpu>;
using Out = std::tuple<MadeRows, MadeRows, Made>;

void expect(bool holds, const char *what) {
    if (!holds) throw std::invalid_argument(what);
}

template <std::size_t Order, std::size_t D>
Innovations run(const Column &given, double density, const std::optional<Spline> &out) {
    Columns<Order, D> columns(given, density);
    return out ? columns.smooth(*out) : columns.filter();
}

template <std::size_t Order>
Innovations run(std::size_t columns, const Column &given, double density,
                const std::optional<Spline> &out) {
    switch (columns) {
    case 1:
        return run<Order, 1>(given, density, out);
    case 3:
        return run<Order, 3>(given, density, out);
    case 4:
        return run<Order, 4>(given, density, out);
    default:
        throw std::invalid_argument("values: expected 1, 3 or 4 columns");
    }
}

nb::tuple spline(const Numbers &time_s, const Rows &values, const Numbers &weights, int order,
                 double density, const std::optional<Out> &out) {
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
        const auto &[smoothed, left_out, variance] = *out;
        expect(smoothed.shape(0) == count && smoothed.shape(1) == columns &&
                   variance.shape(0) == count && left_out.shape(0) == count &&
                   left_out.shape(1) == columns,
               "out: expected arrays as large as the values");
        made = Spline{smoothed.data(), left_out.data(), variance.data()};
    }
    const Column given{time_s.data(), values.data(), weights.data(), count};
    Innovations found;
    {
        nb::gil_scoped_release unlocked;
        switch (order) {
        case 0:
            found = run<0>(columns, given, density, made);
            break;
        case 1:
            found = run<1>(columns, given, density, made);
            break;
        case 2:
            found = run<2>(columns, given, density, made);
            break;
        default:
            found = run<3>(columns, given, density, made);
            break;
        }
    }
    return nb::make_tuple(found.rows, found.squares, found.logarithms);
}

}  // namespace

NB_MODULE(_columns, module) {
    module.doc() = "Smoothing splines of columns; see motorcade.fusion.smoothing.batch.columns.";
    module.def("spline", &spline, "time_s"_a, "values"_a, "weights"_a, "order"_a, "density"_a,
               "out"_a = nb::none());
}
