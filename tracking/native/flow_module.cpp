// Binds the flow of corners to Python; see motorcade.tracking.pictures.

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/pair.h>

#include <cmath>
#include <memory>
#include <stdexcept>

#include "flow.h"

namespace nb = nanobind;
using namespace nb::literals;
using namespace motorcade::flow;

namespace {

using Grey = nb::ndarray<const std::uint8_t, nb::ndim<2>, nb::c_contig, nb::device::cpu>;
using Pixels = nb::ndarray<const double, nb::shape<-1, 2>, nb::c_contig, nb::device::cpu>;
using Places = nb::ndarray<nb::numpy, double, nb::shape<-1, 2>>;
using Flags = nb::ndarray<nb::numpy, bool, nb::shape<-1>>;

constexpr std::size_t most_pixels = 32767;

Picture picture(const Grey &image) {
    if (image.shape(0) < 1 || image.shape(1) < 1 || image.shape(0) > most_pixels ||
        image.shape(1) > most_pixels)
        throw std::invalid_argument("image: expected 1 to 32767 pixels a side");
    return {image.data(), static_cast<int>(image.shape(1)), static_cast<int>(image.shape(0))};
}

template <typename Kept, typename Array>
Array owned(std::unique_ptr<Kept[]> values, std::initializer_list<std::size_t> shape) {
    Kept *data = values.release();
    nb::capsule owner(data, [](void *made) noexcept { delete[] static_cast<Kept *>(made); });
    return Array(data, shape, owner);
}

// Forward from the coarsest level, then back in the finest alone, since it begins where it should
// end: found is what comes back.
std::pair<Places, Flags> follow_corners(const Pyramid &before, const Pyramid &after, Pixels from,
                                        Pixels guess, double return_px) {
    const std::size_t count = from.shape(0);
    if (guess.shape(0) != count)
        throw std::invalid_argument("guess: expected one for each of the corners");
    auto places = std::make_unique<double[]>(2 * count);
    auto found = std::make_unique<bool[]>(count);
    {
        nb::gil_scoped_release unlocked;
        for (std::size_t k = 0; k < count; ++k) {
            const Place start = {from.data()[2 * k], from.data()[2 * k + 1]};
            Place there = {guess.data()[2 * k], guess.data()[2 * k + 1]}, back = start;
            found[k] = follow(before, after, coarsest, start, there) &&
                       follow(after, before, 0, there, back) &&
                       std::hypot(back.x - start.x, back.y - start.y) < return_px;
            places[2 * k] = there.x;
            places[2 * k + 1] = there.y;
        }
    }
    return {owned<double, Places>(std::move(places), {count, 2}),
            owned<bool, Flags>(std::move(found), {count})};
}

}  // namespace

NB_MODULE(_flow, module) {
    module.doc() = "Corners of one picture found in another; see motorcade.tracking.pictures.";
    nb::class_<Pyramid>(module, "Pyramid")
        .def(
            "__init__",
            [](Pyramid *made, Grey image) {
                const Picture given = picture(image);
                nb::gil_scoped_release unlocked;
                new (made) Pyramid(given);
            },
            "image"_a)
        .def_prop_ro("width", [](const Pyramid &of) { return of[0].width; })
        .def_prop_ro("height", [](const Pyramid &of) { return of[0].height; });
    module.def("follow_corners", &follow_corners, "before"_a, "after"_a, "px"_a, "guess"_a,
               "return_px"_a);
}
