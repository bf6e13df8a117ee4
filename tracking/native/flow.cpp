#include "flow.h"

#include <algorithm>
#include <cmath>

#include "support.h"

#if defined(__GNUC__)
#define MOTORCADE_INLINE inline __attribute__((always_inline))
#else
#error "flow.cpp: expected a compiler with vector extensions, GCC or Clang"
#endif

namespace motorcade::flow {

namespace {

constexpr int half = window / 2;
constexpr int lanes = 8, parts = 3, wide = parts * lanes;  // a row of the window in whole vectors
constexpr int most_steps = 20;
constexpr double settled_px = 0.01;
// Mean square of the gradient along which it is least, grey levels a pixel: OpenCV's 1e-4.
constexpr double least_gradient = 0.1024;

typedef float Lanes __attribute__((vector_size(32), aligned(4), may_alias));

MOTORCADE_INLINE Lanes load(const float *from) { return *reinterpret_cast<const Lanes *>(from); }
MOTORCADE_INLINE void store(float *to, Lanes values) { *reinterpret_cast<Lanes *>(to) = values; }

MOTORCADE_INLINE double total(const Lanes *values) {
    const Lanes all = values[0] + values[1] + values[2];
    double sum = 0.0;
    for (int k = 0; k < lanes; ++k) sum += static_cast<double>(all[k]);
    return sum;
}

// The window's first pixel, and by how much it stands right of and below that.
struct Corner {
    int x, y;
    float right, below;

    explicit Corner(Place middle) {
        const double left = std::floor(middle.x - half), top = std::floor(middle.y - half);
        x = static_cast<int>(left);
        y = static_cast<int>(top);
        right = static_cast<float>(middle.x - half - left);
        below = static_cast<float>(middle.y - half - top);
    }
};

// Also false of what is not finite.
MOTORCADE_INLINE bool is_near(const Layer &layer, Place middle) {
    const double x = middle.x - half, y = middle.y - half;
    return x >= -window && x < layer.width && y >= -window && y < layer.height;
}

// Grey levels and gradients of a window, and the sums of the gradients' products.
struct Patch {
    alignas(32) float level[window][wide], across[window][wide], down[window][wide];
    double xx, xy, yy;
};

// Grey levels from one pixel left of and above the window to one right of and below it.
MOTORCADE_INLINE void cut(const Layer &layer, const Corner &at, float (*grey)[wide + lanes]) {
    const std::ptrdiff_t stride = layer.stride();
    const float *from = layer.row(at.y - 1) + at.x - 1;
    for (int part = 0; part <= parts; ++part) {
        const float *row = from + part * lanes;
        Lanes above = load(row) + at.right * (load(row + 1) - load(row));
        for (int y = 0; y < window + 2; ++y) {
            row += stride;
            const Lanes next = load(row) + at.right * (load(row + 1) - load(row));
            store(grey[y] + part * lanes, above + at.below * (next - above));
            above = next;
        }
    }
}

// Scharr's gradients; none where the window has left the image.
MOTORCADE_INLINE void measure(const Layer &layer, Place middle, Patch &patch) {
    const Corner at(middle);
    alignas(32) float grey[window + 2][wide + lanes], used[wide];
    cut(layer, at, grey);
    for (int x = 0; x < wide; ++x)
        used[x] = x < window && at.x + x >= 0 && at.x + x < layer.width ? 1.0f / 32.0f : 0.0f;
    Lanes xx[parts] = {}, xy[parts] = {}, yy[parts] = {};
    for (int y = 0; y < window; ++y) {
        const float inside = at.y + y >= 0 && at.y + y < layer.height ? 1.0f : 0.0f;
        for (int part = 0; part < parts; ++part) {
            const int x = part * lanes;
            const float *a = grey[y] + x, *b = grey[y + 1] + x, *c = grey[y + 2] + x;
            const Lanes share = inside * load(used + x);
            const Lanes left = 3.0f * (load(a) + load(c)) + 10.0f * load(b);
            const Lanes right = 3.0f * (load(a + 2) + load(c + 2)) + 10.0f * load(b + 2);
            const Lanes above = 3.0f * (load(a) + load(a + 2)) + 10.0f * load(a + 1);
            const Lanes below = 3.0f * (load(c) + load(c + 2)) + 10.0f * load(c + 1);
            const Lanes across = share * (right - left), down = share * (below - above);
            store(patch.level[y] + x, load(b + 1));
            store(patch.across[y] + x, across);
            store(patch.down[y] + x, down);
            xx[part] += across * across;
            xy[part] += across * down;
            yy[part] += down * down;
        }
    }
    patch.xx = total(xx);
    patch.xy = total(xy);
    patch.yy = total(yy);
}

// Products of the gradients with what the other image shows too much.
MOTORCADE_INLINE Place mismatch(const Layer &layer, Place middle, const Patch &patch) {
    const Corner at(middle);
    const float *row = layer.row(at.y) + at.x;
    Lanes above[parts], x[parts] = {}, y[parts] = {};
    for (int part = 0; part < parts; ++part) {
        const float *from = row + part * lanes;
        above[part] = load(from) + at.right * (load(from + 1) - load(from));
    }
    const std::ptrdiff_t stride = layer.stride();
    for (int k = 0; k < window; ++k) {
        row += stride;
        for (int part = 0; part < parts; ++part) {
            const float *from = row + part * lanes;
            const Lanes next = load(from) + at.right * (load(from + 1) - load(from));
            const Lanes more =
                above[part] + at.below * (next - above[part]) - load(patch.level[k] + part * lanes);
            x[part] += more * load(patch.across[k] + part * lanes);
            y[part] += more * load(patch.down[k] + part * lanes);
            above[part] = next;
        }
    }
    return {total(x), total(y)};
}

// Gauss-Newton steps at one level. False where there is no telling.
MOTORCADE_INLINE bool settle(const Layer &before, const Layer &after, Place from, Place &there) {
    if (!is_near(before, from)) return false;
    Patch patch;
    measure(before, from, patch);
    const double xx = patch.xx, xy = patch.xy, yy = patch.yy;
    const double determinant = xx * yy - xy * xy;
    const double least = 0.5 * (xx + yy - std::sqrt((xx - yy) * (xx - yy) + 4.0 * xy * xy));
    if (least < least_gradient * window * window || determinant <= 0.0) return false;
    Place last = {0.0, 0.0};
    for (int k = 0; k < most_steps; ++k) {
        if (!is_near(after, there)) return false;
        const Place pull = mismatch(after, there, patch);
        const Place step = {(xy * pull.y - yy * pull.x) / determinant,
                            (xy * pull.x - xx * pull.y) / determinant};
        there = {there.x + step.x, there.y + step.y};
        if (step.x * step.x + step.y * step.y <= settled_px * settled_px) break;
        if (k > 0 && std::fabs(step.x + last.x) < settled_px &&
            std::fabs(step.y + last.y) < settled_px) {
            there = {there.x - 0.5 * step.x, there.y - 0.5 * step.y};  // to and fro
            break;
        }
        last = step;
    }
    return is_near(after, there);
}

}  // namespace

MOTORCADE_SIMD
bool settle_at(const Layer &before, const Layer &after, Place from, Place &there) {
    return settle(before, after, from, there);
}

bool follow(const Pyramid &before, const Pyramid &after, int level, Place from, Place &there) {
    bool told = false;
    for (level = std::min({level, before.coarsest(), after.coarsest()}); level >= 0; --level) {
        const double size = std::ldexp(1.0, -level);
        const Place start = {size * from.x, size * from.y};
        Place found = {size * there.x, size * there.y};
        told = settle_at(before[level], after[level], start, found);
        // What a coarse level cannot tell is left to the finer ones.
        if (told) there = {found.x / size, found.y / size};
    }
    return told;
}

}  // namespace motorcade::flow
