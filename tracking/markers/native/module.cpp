// Binds the search for quads to Python; see motorcade.tracking.markers.reading.

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/pair.h>

#include "quads.h"
#include "words.h"

namespace nb = nanobind;
using namespace nb::literals;
using namespace motorcade::quads;

namespace {

using Grey = nb::ndarray<const std::uint8_t, nb::ndim<2>, nb::c_contig, nb::device::cpu>;
using Codes = nb::ndarray<const std::uint64_t, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using Numbers = nb::ndarray<nb::numpy, std::int64_t, nb::ndim<1>>;
using Corners = nb::ndarray<nb::numpy, float, nb::shape<-1, 4, 2>>;

Corners find_quads(Grey image, bool white_inside, float least_side, int reach) {
    if (reach < 0) throw std::invalid_argument("find_quads: expected a reach from 0 on");
    if (image.shape(0) > 32767 || image.shape(1) > 32767)
        throw std::invalid_argument("image: expected at most 32767 pixels a side");
    const Image pixels{image.data(), static_cast<std::ptrdiff_t>(image.shape(1)),
                       static_cast<int>(image.shape(1)), static_cast<int>(image.shape(0))};
    auto *found = new std::vector<Quad>;
    nb::capsule owner(found,
                      [](void *made) noexcept { delete static_cast<std::vector<Quad> *>(made); });
    {
        nb::gil_scoped_release unlocked;
        const Binary binary = reach == 0 ? threshold_tiles(pixels) : threshold_mean(pixels, reach);
        fit_quads(find_edges(pixels, binary, least_side), white_inside, least_side, *found);
    }
    return Corners(found->data(), {found->size(), 4, 2}, owner);
}

Numbers numbers(std::vector<std::int64_t> values) {
    auto *kept = new std::vector<std::int64_t>(std::move(values));
    nb::capsule owner(
        kept, [](void *made) noexcept { delete static_cast<std::vector<std::int64_t> *>(made); });
    return Numbers(kept->data(), {kept->size()}, owner);
}

std::pair<Numbers, Numbers> match(const Words &words, Codes seen, int most_wrong) {
    if (most_wrong < 0 || most_wrong > Words::MOST_WRONG)
        throw std::invalid_argument("most_wrong: expected 0 to 2");
    std::vector<std::int64_t> ids(seen.size()), wrong(seen.size());
    {
        nb::gil_scoped_release unlocked;
        for (std::size_t k = 0; k < seen.size(); ++k) {
            const Match found = words.nearest(seen.data()[k], most_wrong);
            ids[k] = found.id;
            wrong[k] = found.wrong;
        }
    }
    return {numbers(std::move(ids)), numbers(std::move(wrong))};
}

}  // namespace

NB_MODULE(_quads, module) {
    module.doc() = "Quads in images; see motorcade.tracking.markers.reading.";
    module.def("find_quads", &find_quads, "image"_a, "white_inside"_a, "least_side"_a, "reach"_a);
    nb::class_<Words>(module, "Words")
        .def(
            "__init__",
            [](Words *made, Codes words, int bits) {
                if (bits < 3 || bits > 64) throw std::invalid_argument("bits: expected 3 to 64");
                new (made) Words(words.data(), words.size(), bits);
            },
            "words"_a, "bits"_a)
        .def("match", &match, "seen"_a, "most_wrong"_a);
}
