#include "flow.h"

#include <algorithm>

#include "support.h"

namespace motorcade::flow {

namespace {

// Binomial weights of five pixels down, then across; of every second pixel.
MOTORCADE_SIMD
void weigh_rows(const float *const *rows, float *to, int width) {
    const float *a = rows[0], *b = rows[1], *c = rows[2], *d = rows[3], *e = rows[4];
    for (int x = 0; x < width; ++x)
        to[x] = 0.0625f * (a[x] + e[x]) + 0.25f * (b[x] + d[x]) + 0.375f * c[x];
}

MOTORCADE_SIMD
void weigh_columns(const float *from, float *to, int width) {
    for (int x = 0; x < width; ++x) {
        const float *at = from + 2 * x;
        to[x] = 0.0625f * (at[0] + at[4]) + 0.25f * (at[1] + at[3]) + 0.375f * at[2];
    }
}

MOTORCADE_SIMD
void take_levels(const std::uint8_t *from, float *to, int width) {
    for (int x = 0; x < width; ++x) to[x] = from[x];
}

void repeat_edge(const Layer &layer) {
    const int border = Layer::border;
    const std::ptrdiff_t stride = layer.stride(), right = stride - layer.width - border;
    for (int y = 0; y < layer.height; ++y) {
        float *at = layer.row(y);
        std::fill_n(at - border, border, at[0]);
        std::fill_n(at + layer.width, right, at[layer.width - 1]);
    }
    for (int y = 1; y <= border; ++y) {
        std::copy_n(layer.row(0) - border, stride, layer.row(-y) - border);
        std::copy_n(layer.row(layer.height - 1) - border, stride,
                    layer.row(layer.height - 1 + y) - border);
    }
}

void fill(const Layer &layer, const Image &image) {
    for (int y = 0; y < image.height; ++y)
        take_levels(image.levels + static_cast<std::ptrdiff_t>(y) * image.width, layer.row(y),
                    image.width);
    repeat_edge(layer);
}

void halve(const Layer &whole, const Layer &half) {
    const int width = 2 * half.width + 4;
    std::vector<float> weighed(static_cast<std::size_t>(width));
    for (int y = 0; y < half.height; ++y) {
        const float *rows[5];
        for (int k = 0; k < 5; ++k) rows[k] = whole.row(2 * y + k - 2) - 2;
        weigh_rows(rows, weighed.data(), width);
        weigh_columns(weighed.data(), half.row(y), half.width);
    }
    repeat_edge(half);
}

}  // namespace

Pyramid::Pyramid(const Image &image) {
    int width = image.width, height = image.height;
    do {
        layers_.push_back({width, height, nullptr});
        width = (width + 1) / 2;
        height = (height + 1) / 2;
    } while (coarsest() < flow::coarsest && std::min(width, height) > window);
    std::ptrdiff_t size = 0;
    for (const Layer &layer : layers_) size += layer.size();
    levels_ = std::make_unique_for_overwrite<float[]>(static_cast<std::size_t>(size));
    float *next = levels_.get();
    for (Layer &layer : layers_) {
        layer.first = next;
        next += layer.size();
    }
    fill(layers_[0], image);
    for (std::size_t k = 1; k < layers_.size(); ++k) halve(layers_[k - 1], layers_[k]);
}

}  // namespace motorcade::flow
