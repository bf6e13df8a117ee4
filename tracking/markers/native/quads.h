// Quads in a grey image: loops of pixels where black meets white, cut into four straight sides.
//
// Olson 2011 and Wang & Olson 2016 (AprilTag 2): local threshold, regions, the loops between
// pairs of regions, four lines. Here a loop's points lie where the brightness crosses the threshold
// between two pixels, not on pixels, so that short sides are straight too.

#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace motorcade::quads {

struct Image {
    const std::uint8_t *levels;
    std::ptrdiff_t stride;
    int width, height;

    const std::uint8_t *row(int y) const { return levels + y * stride; }
};

// What separates black from white at each pixel, and which of the two it is.
enum Colour : std::uint8_t { Black = 0, White = 1, Neither = 2 };

struct Binary {
    int width, height;
    std::vector<std::uint8_t> colour, threshold;
};

// A place between two pixels where black meets white, and the step of brightness across it.
struct EdgePoint {
    float x, y, step_x, step_y;
};

// Points grouped by the pair of regions that they separate: group k is points[first[k],
// first[k+1]).
struct Edges {
    std::vector<EdgePoint> points;
    std::vector<std::uint32_t> first;
};

struct Quad {
    std::array<float, 8> corners;  // x, y; clockwise as seen
};

// Halfway between the darkest and the brightest of a tile of 4 x 4 pixels and its eight neighbours.
Binary threshold_tiles(const Image &image);
// The mean of the square of 2 reach + 1 pixels round each pixel.
Binary threshold_mean(const Image &image, int reach);

// Only of loops that could be convex and as large as a square of this side, pixels.
Edges find_edges(const Image &image, const Binary &binary, float least_side);

// Appends the quads whose inside is black, or white. A marker has `least_side` cells along its
// side.
void fit_quads(const Edges &edges, bool white_inside, float least_side, std::vector<Quad> &found);

}  // namespace motorcade::quads
