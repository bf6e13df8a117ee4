// Corners of one image found in another: Lucas-Kanade flow on pyramids of the two.
//
// Lucas & Kanade 1981; Bouguet 2000 (pyramids, and gradients of the first image alone). Windows,
// gradients and limits are those of OpenCV's calcOpticalFlowPyrLK, so that either takes the other's
// place; grey levels are floats here, and those of coarse levels are not rounded.

#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace motorcade::flow {

struct Image {
    const std::uint8_t *levels;
    int width, height;
};

struct Place {
    double x, y;
};

// One size of an image, with a border round it that repeats its edge. It does not own its levels.
struct Layer {
    // Windows reach so far beyond an image, read in whole vectors.
    static constexpr int border = 40;
    int width, height;
    float *first;

    std::ptrdiff_t stride() const { return (width + 2 * border + 7) / 8 * 8; }
    std::ptrdiff_t size() const { return stride() * (height + 2 * border); }
    float *row(int y) const { return first + (y + border) * stride() + border; }
};

constexpr int window = 21;   // pixels a side
constexpr int coarsest = 3;  // level: an eighth of the image's size

// An image and its halves, quarters and eighths, those that hold a window.
class Pyramid {
public:
    explicit Pyramid(const Image &image);
    int coarsest() const { return static_cast<int>(layers_.size()) - 1; }
    const Layer &operator[](int level) const { return layers_[static_cast<std::size_t>(level)]; }

private:
    std::vector<Layer> layers_;
    std::unique_ptr<float[]> levels_;
};

// Follows a corner from its place in `before` to one near `there` in `after`, which is changed.
// False where it leaves the image, or where the window's gradients do not tell its motion.
// It begins at this level, or at the coarsest there is.
bool follow(const Pyramid &before, const Pyramid &after, int level, Place from, Place &there);

}  // namespace motorcade::flow
