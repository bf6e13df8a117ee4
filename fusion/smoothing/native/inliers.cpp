// Binds the longest smooth chain of poses to Python. Arrays come checked and C-ordered; see
// motorcade.fusion.smoothing.batch.inliers. The interpreter lock is released.

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/pair.h>

#include <stdexcept>
#include <utility>

#include "inliers.h"

namespace nb = nanobind;
using namespace nb::literals;
using namespace motorcade::smooth;

namespace {

using Numbers = nb::ndarray<const double, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using Rows = nb::ndarray<const double, nb::ndim<2>, nb::c_contig, nb::device::cpu>;
using Marks = nb::ndarray<bool, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
// Noise and density of white acceleration.
using Pair = std::pair<double, double>;

void chain(const Numbers &time_s, const Rows &poses, const Pair &rotation, const Pair &translation,
           const Marks &kept) {
    const std::size_t count = time_s.shape(0);
    if (count < 3 || poses.shape(0) != count || poses.shape(1) != 8 || kept.shape(0) != count)
        throw std::invalid_argument("poses: expected three or more, with a stamp and a mark each");
    nb::gil_scoped_release unlocked;
    InlierChain(
        {time_s.data(), poses.data(), count},
        {Sizes{rotation.first, rotation.second}, Sizes{translation.first, translation.second}})
        .mark(kept.data());
}

}  // namespace

NB_MODULE(_inliers, module) {
    module.doc() = "The longest smooth chain; see motorcade.fusion.smoothing.batch.inliers.";
    module.def("chain", &chain, "time_s"_a, "poses"_a, "rotation"_a, "translation"_a, "kept"_a);
}
