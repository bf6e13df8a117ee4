// Binds the flow of corners to Python; see motorcade.tracking.images.

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/pair.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <memory>
#include <stdexcept>
#include <thread>
#include <vector>

#include "flow.h"

namespace nb = nanobind;
using namespace nb::literals;
namespace flow = motorcade::flow;
using namespace motorcade::flow;

namespace {

using Grey = nb::ndarray<const std::uint8_t, nb::ndim<2>, nb::c_contig, nb::device::cpu>;
using Pixels = nb::ndarray<const double, nb::shape<-1, 2>, nb::c_contig, nb::device::cpu>;
using Places = nb::ndarray<nb::numpy, double, nb::shape<-1, 2>>;
using Flags = nb::ndarray<nb::numpy, bool, nb::shape<-1>>;

constexpr std::size_t most_pixels = 32767;

Image checked_image(const Grey &image) {
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

struct Corners {
    const Pyramid &before, &after;
    const double *from, *guess;
    double return_px, *there;
    bool *found;

    // Forward from the coarsest level, then back in the finest alone, since it begins where it
    // should end: found is what comes back.
    void follow(std::size_t first, std::size_t last) const {
        for (std::size_t k = first; k < last; ++k) {
            const Place start = {from[2 * k], from[2 * k + 1]};
            Place at = {guess[2 * k], guess[2 * k + 1]}, back = start;
            found[k] = flow::follow(before, after, coarsest, start, at) &&
                       flow::follow(after, before, 0, at, back) &&
                       std::hypot(back.x - start.x, back.y - start.y) < return_px;
            there[2 * k] = at.x;
            there[2 * k + 1] = at.y;
        }
    }
};

constexpr std::size_t per_thread = 64;  // corners that are worth a thread

void follow_all(const Corners &corners, std::size_t count, unsigned threads) {
    const std::size_t shares = std::clamp<std::size_t>(threads, 1, count / per_thread + 1);
    const std::size_t share = (count + shares - 1) / shares;
    std::vector<std::thread> others;
    others.reserve(shares);
    std::size_t left = share;
    try {
        for (; left < count; left += share)
            others.emplace_back(&Corners::follow, &corners, left, std::min(left + share, count));
    } catch (const std::exception &) {
        corners.follow(left, count);  // no more threads, or no memory for one: it is done here
    }
    corners.follow(0, std::min(share, count));
    for (std::thread &other : others) other.join();
}

std::pair<Places, Flags> follow_corners(const Pyramid &before, const Pyramid &after, Pixels from,
                                        Pixels guess, double return_px, unsigned threads) {
    const std::size_t count = from.shape(0);
    if (guess.shape(0) != count)
        throw std::invalid_argument("guess: expected one for each of the corners");
    auto places = std::make_unique<double[]>(2 * count);
    auto found = std::make_unique<bool[]>(count);
    {
        nb::gil_scoped_release unlocked;
        const Corners corners{before,    after,        from.data(), guess.data(),
                              return_px, places.get(), found.get()};
        follow_all(corners, count, threads);
    }
    return {owned<double, Places>(std::move(places), {count, 2}),
            owned<bool, Flags>(std::move(found), {count})};
}

}  // namespace

NB_MODULE(_flow, module) {
    module.doc() = "Corners of one image found in another; see motorcade.tracking.images.";
    nb::class_<Pyramid>(module, "Pyramid")
        .def(
            "__init__",
            [](Pyramid *made, Grey image) {
                const Image next = checked_image(image);
                nb::gil_scoped_release unlocked;
                new (made) Pyramid(next);
            },
            "image"_a)
        .def_prop_ro("width", [](const Pyramid &of) { return of[0].width; })
        .def_prop_ro("height", [](const Pyramid &of) { return of[0].height; });
    module.def("follow_corners", &follow_corners, "before"_a, "after"_a, "px"_a, "guess"_a,
               "return_px"_a, "threads"_a);
}
