// From the points of a loop to the four lines that fit it best; see quads.h.

#include "quads.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace motorcade::quads {

namespace {

constexpr int MOST_REACH = 10;          // points to either side in which a corner is looked for
constexpr int MOST_CORNERS = 10;        // candidates kept
constexpr double MOST_SPREAD_PX2 = 10;  // mean squared distance from a side, of any length
// The same for short sides, as a share of a cell: bits half a cell off cannot be read.
constexpr double MOST_SPREAD_CELLS = 0.4, LEAST_SPREAD_PX = 0.5;
constexpr double MOST_COSINE = 0.985;  // sides meet at 10 degrees at least

struct Sums {
    double x = 0, y = 0, xx = 0, xy = 0, yy = 0, weight = 0;

    Sums &operator+=(const Sums &more) {
        x += more.x, y += more.y, xx += more.xx, xy += more.xy, yy += more.yy;
        weight += more.weight;
        return *this;
    }
    Sums operator-(const Sums &less) const {
        return {x - less.x,   y - less.y,   xx - less.xx,
                xy - less.xy, yy - less.yy, weight - less.weight};
    }
};

struct Line {
    double x, y, normal_x, normal_y, spread;  // spread: mean squared distance, pixels squared
    int points;

    double error() const { return spread * points; }
};

// A loop's points in order, ready for lines through any segment of them.
class Loop {
public:
    explicit Loop(const std::vector<EdgePoint> &points)
        : size_(static_cast<int>(points.size())), sums_(points.size() + 1) {
        for (int k = 0; k < size_; ++k) {
            const double x = points[k].x, y = points[k].y;
            const double weight = 1.0 + std::abs(points[k].step_x) + std::abs(points[k].step_y);
            sums_[k + 1] = sums_[k];
            sums_[k + 1] +=
                {weight * x, weight * y, weight * x * x, weight * x * y, weight * y * y, weight};
        }
    }

    int size() const { return size_; }

    // The line through points `first` to `last`, both included, past the end where last < first.
    Line line(int first, int last) const {
        Sums sums = sums_[last + 1] - sums_[first];
        int points = last - first + 1;
        if (last < first) {
            sums += sums_[size_];
            points += size_;
        }
        const double x = sums.x / sums.weight, y = sums.y / sums.weight;
        const double xx = sums.xx / sums.weight - x * x, yy = sums.yy / sums.weight - y * y;
        const double xy = sums.xy / sums.weight - x * y;
        const double root = std::sqrt((xx - yy) * (xx - yy) + 4.0 * xy * xy);
        const double spread = std::max(0.5 * (xx + yy - root), 0.0);
        // The normal is the eigenvector of the smaller value; two ways to it, the safer is taken.
        double normal_x = xx - yy - root, normal_y = 2.0 * xy;
        if (xx > yy) normal_x = 2.0 * xy, normal_y = yy - xx - root;
        const double length = std::sqrt(normal_x * normal_x + normal_y * normal_y);
        if (length > 0.0) normal_x /= length, normal_y /= length;
        return {x, y, normal_x, normal_y, spread, points};
    }

private:
    int size_;
    std::vector<Sums> sums_;
};

// Where a line through the points on both sides fits worst: candidates for corners, in order.
std::vector<int> find_corners(const Loop &loop) {
    const int size = loop.size(), reach = std::min(MOST_REACH, size / 12);
    std::vector<double> errors(size), smooth(size);
    for (int k = 0; k < size; ++k)
        errors[k] = loop.line((k + size - reach) % size, (k + reach) % size).error();
    constexpr std::array<double, 4> GAUSS{1.0, 0.60653, 0.13534, 0.01111};  // deviation of a point
    for (int k = 0; k < size; ++k) {
        smooth[k] = errors[k];
        for (int j = 1; j < 4; ++j)
            smooth[k] += GAUSS[j] * (errors[(k + j) % size] + errors[(k + size - j) % size]);
    }
    std::vector<int> peaks;
    for (int k = 0; k < size; ++k)
        if (smooth[k] >= smooth[(k + 1) % size] && smooth[k] > smooth[(k + size - 1) % size])
            peaks.push_back(k);
    if (peaks.size() > MOST_CORNERS) {
        std::nth_element(peaks.begin(), peaks.begin() + MOST_CORNERS, peaks.end(),
                         [&](int one, int other) { return smooth[one] > smooth[other]; });
        peaks.resize(MOST_CORNERS);
        std::sort(peaks.begin(), peaks.end());
    }
    return peaks;
}

using Sides = std::array<Line, 4>;

// The four corners whose sides are straightest; false where there are none.
bool find_sides(const Loop &loop, Sides &best) {
    const std::vector<int> peaks = find_corners(loop);
    const int count = static_cast<int>(peaks.size());
    if (count < 4) return false;
    std::array<std::array<Line, MOST_CORNERS>, MOST_CORNERS> lines;
    for (int i = 0; i < count; ++i)
        for (int j = 0; j < count; ++j)
            if (i != j) lines[i][j] = loop.line(peaks[i], peaks[j]);
    const auto straight = [](const Line &line) { return line.spread <= MOST_SPREAD_PX2; };
    const auto bent = [](const Line &one, const Line &other) {
        const double cosine = one.normal_x * other.normal_x + one.normal_y * other.normal_y;
        return std::abs(cosine) <= MOST_COSINE;
    };
    double least = std::numeric_limits<double>::infinity();
    for (int a = 0; a < count - 3; ++a)
        for (int b = a + 1; b < count - 2; ++b) {
            if (!straight(lines[a][b])) continue;
            for (int c = b + 1; c < count - 1; ++c) {
                if (!straight(lines[b][c]) || !bent(lines[a][b], lines[b][c])) continue;
                for (int d = c + 1; d < count; ++d) {
                    const Sides sides{lines[a][b], lines[b][c], lines[c][d], lines[d][a]};
                    double error = 0.0;
                    for (const Line &side : sides) error += side.error();
                    if (error >= least || !straight(sides[2]) || !straight(sides[3])) continue;
                    if (!bent(sides[1], sides[2]) || !bent(sides[2], sides[3])) continue;
                    least = error;
                    best = sides;
                }
            }
        }
    return std::isfinite(least);
}

bool cross(const Line &one, const Line &other, float *corner) {
    const double turn = one.normal_x * other.normal_y - one.normal_y * other.normal_x;
    if (std::abs(turn) < 1e-3) return false;
    const double a = one.normal_x * one.x + one.normal_y * one.y;
    const double b = other.normal_x * other.x + other.normal_y * other.y;
    corner[0] = static_cast<float>((a * other.normal_y - b * one.normal_y) / turn);
    corner[1] = static_cast<float>((b * one.normal_x - a * other.normal_x) / turn);
    return true;
}

// Whether the corners turn the same way, none by less or more than is looked for, round an area.
bool convex(const Quad &quad, float least_side) {
    double area = 0.0;
    for (int k = 0; k < 4; ++k) {
        const auto at = [&](int j, int axis) {
            return static_cast<double>(quad.corners[2 * (j % 4) + axis]);
        };
        const double x = at(k + 1, 0) - at(k, 0), y = at(k + 1, 1) - at(k, 1);
        const double u = at(k + 2, 0) - at(k + 1, 0), v = at(k + 2, 1) - at(k + 1, 1);
        const double lengths = std::sqrt((x * x + y * y) * (u * u + v * v));
        if (x * v - y * u <= 0.0 || std::abs(x * u + y * v) > MOST_COSINE * lengths) return false;
        area += 0.5 * (at(k, 0) * at(k + 1, 1) - at(k + 1, 0) * at(k, 1));
    }
    return area >= static_cast<double>(least_side) * least_side;
}

// Whether sides are straight enough for cells as small as theirs.
bool legible(const Sides &sides, const Quad &quad, float cells) {
    for (int k = 0; k < 4; ++k) {
        const auto &at = quad.corners;  // side k ends in corner k
        const int from = 2 * ((k + 3) % 4), to = 2 * k;
        const double x = at[to] - at[from], y = at[to + 1] - at[from + 1];
        const double cell = std::sqrt(x * x + y * y) / static_cast<double>(cells);
        const double most = std::max(LEAST_SPREAD_PX, MOST_SPREAD_CELLS * cell);
        if (sides[k].spread > most * most) return false;
    }
    return true;
}

// Sorts a loop's points clockwise round the middle of their bounds.
class Sorter {
public:
    // False where the inside is not of the colour.
    bool sort(const EdgePoint *points, int count, bool white_inside) {
        float left = points[0].x, right = left, top = points[0].y, bottom = top;
        for (int k = 1; k < count; ++k) {
            left = std::min(left, points[k].x), right = std::max(right, points[k].x);
            top = std::min(top, points[k].y), bottom = std::max(bottom, points[k].y);
        }
        const float x = 0.5F * (left + right), y = 0.5F * (top + bottom);
        float outward = 0.0F;
        for (int k = 0; k < count; ++k)
            outward += (points[k].x - x) * points[k].step_x + (points[k].y - y) * points[k].step_y;
        if ((outward < 0.0F) != white_inside) return false;
        keys_.resize(count);
        for (int k = 0; k < count; ++k) keys_[k] = {angle(points[k].x - x, points[k].y - y), k};
        std::sort(keys_.begin(), keys_.end());
        sorted.resize(count);
        for (int k = 0; k < count; ++k) sorted[k] = points[keys_[k].second];
        return true;
    }

    std::vector<EdgePoint> sorted;

private:
    // Rises with the angle, 0 to 4.
    static float angle(float x, float y) {
        const float share = y / std::max(std::abs(x) + std::abs(y), 1e-9F);
        return x < 0.0F ? 2.0F - share : share < 0.0F ? 4.0F + share : share;
    }

    std::vector<std::pair<float, int>> keys_;
};

}  // namespace

void fit_quads(const Edges &edges, bool white_inside, float least_side, std::vector<Quad> &found) {
    Sorter sorter;
    for (std::size_t k = 0; k + 1 < edges.first.size(); ++k) {
        const int count = static_cast<int>(edges.first[k + 1] - edges.first[k]);
        const EdgePoint *points = edges.points.data() + edges.first[k];
        if (!sorter.sort(points, count, white_inside)) continue;
        Sides sides;
        if (!find_sides(Loop(sorter.sorted), sides)) continue;
        Quad quad;
        bool good = true;
        for (int side = 0; side < 4 && good; ++side)
            good = cross(sides[side], sides[(side + 1) % 4], &quad.corners[2 * side]);
        if (good && convex(quad, least_side) && legible(sides, quad, least_side))
            found.push_back(quad);
    }
}

}  // namespace motorcade::quads
