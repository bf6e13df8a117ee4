#include "reprojection.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "blocks.h"
#include "support.h"
#include "versors.h"

namespace motorcade::adjusting {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

Image through_pinhole(const Lens &lens, const Three &point) {
    const double inverse = 1.0 / point[2], x = point[0] * inverse, y = point[1] * inverse;
    return {{lens.fx * x + lens.cx, lens.fy * y + lens.cy},
            {{lens.fx * inverse, 0.0, -lens.fx * x * inverse},
             {0.0, lens.fy * inverse, -lens.fy * y * inverse}}};
}

// Brown 1966, in OpenCV's rational form.
Image through_radtan(const Lens &lens, const Three &point) {
    const auto &[k1, k2, p1, p2, k3, k4, k5, k6] = lens.k;
    const double inverse = 1.0 / point[2], x = point[0] * inverse, y = point[1] * inverse;
    const double r2 = x * x + y * y, below = 1.0 + r2 * (k4 + r2 * (k5 + r2 * k6));
    const double radial = (1.0 + r2 * (k1 + r2 * (k2 + r2 * k3))) / below;
    const double slope =
        2.0 *
        (k1 + r2 * (2.0 * k2 + r2 * 3.0 * k3) - radial * (k4 + r2 * (2.0 * k5 + r2 * 3.0 * k6))) /
        below;
    const double xx = radial + slope * x * x + 2.0 * p1 * y + 6.0 * p2 * x;
    const double yy = radial + slope * y * y + 6.0 * p1 * y + 2.0 * p2 * x;
    const double xy = slope * x * y + 2.0 * p1 * x + 2.0 * p2 * y;
    const double u = x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x);
    const double v = y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y;
    const double fx = lens.fx * inverse, fy = lens.fy * inverse;
    return {
        {lens.fx * u + lens.cx, lens.fy * v + lens.cy},
        {{fx * xx, fx * xy, -fx * (xx * x + xy * y)}, {fy * xy, fy * yy, -fy * (xy * x + yy * y)}}};
}

// The angle a from the axis is drawn at a (1 + k1 a² + ...) from the middle.
Image through_equidistant(const Lens &lens, const Three &point) {
    const auto &k = lens.k;
    const double x = point[0], y = point[1], z = point[2], radius = std::hypot(x, y);
    if (radius == 0.0) return through_pinhole(lens, point);
    const double angle = std::atan2(radius, z), a2 = angle * angle;
    const double drawn = angle * (1.0 + a2 * (k[0] + a2 * (k[1] + a2 * (k[2] + a2 * k[3]))));
    const double slope =
        1.0 + a2 * (3.0 * k[0] + a2 * (5.0 * k[1] + a2 * (7.0 * k[2] + a2 * 9.0 * k[3])));
    const double scale = drawn / radius, distance2 = radius * radius + z * z;
    const double by_radius = (slope * z / distance2 - scale) / (radius * radius);
    const double by_depth = -slope / distance2;
    return {{lens.fx * x * scale + lens.cx, lens.fy * y * scale + lens.cy},
            {{lens.fx * (scale + by_radius * x * x), lens.fx * by_radius * x * y,
              lens.fx * x * by_depth},
             {lens.fy * by_radius * x * y, lens.fy * (scale + by_radius * y * y),
              lens.fy * y * by_depth}}};
}

// A point in the camera's frame, kept where the lens sees.
struct Placed {
    Three point;
    bool seen;
};

Placed placed(const Lens &lens, const Pose &pose, const double *world, double nearest) {
    Three point = pose.apply(world);
    const bool seen = lens.sees(point);
    if (!seen || !lens.sees_behind()) point[2] = std::max(point[2], nearest);
    return {point, seen};
}

double huber(double size, double limit) {
    const double inside = std::min(size, limit);
    return inside * (size - 0.5 * inside);
}

// A residual of the depth, as disparity; none where no depth was measured.
double along(const Observations &seen, std::size_t k, double z) {
    const double depth = seen.depth[k];
    const double apart = seen.disparity / z - seen.disparity / depth;
    return std::isfinite(apart) ? apart : 0.0;
}

}  // namespace

Image image_of(const Lens &lens, const Three &point) {
    switch (lens.model) {
    case Model::equidistant:
        return through_equidistant(lens, point);
    case Model::radtan:
        return through_radtan(lens, point);
    default:
        return through_pinhole(lens, point);
    }
}

MOTORCADE_SIMD
double evaluate(const Observations &seen, double *error_px) {
    double of_pixels = 0.0, of_depths = 0.0;
    for (std::size_t k = 0; k < seen.count; ++k) {
        const Pose pose = pose_of(seen.poses + 16 * seen.pose_of[k]);
        const Placed at = placed(seen.lens, pose, seen.points + 3 * seen.point_of[k], seen.nearest);
        const Image image = image_of(seen.lens, at.point);
        const double size =
            std::hypot(image.pixel[0] - seen.px[2 * k], image.pixel[1] - seen.px[2 * k + 1]);
        of_pixels += huber(size, seen.huber);
        of_depths += huber(std::fabs(along(seen, k, at.point[2])), seen.huber);
        error_px[k] = at.seen ? size : infinity;
    }
    return of_pixels + of_depths;
}

MOTORCADE_SIMD
void linearise(const Observations &seen, double *information, double *gradient, double *blocks,
               double *block_gradient, double *coupling) {
    for (std::size_t k = 0; k < seen.count; ++k) {
        const Pose pose = pose_of(seen.poses + 16 * seen.pose_of[k]);
        const Placed at = placed(seen.lens, pose, seen.points + 3 * seen.point_of[k], seen.nearest);
        const Image image = image_of(seen.lens, at.point);
        const double z = at.point[2], apart = along(seen, k, z);
        const double residual[3] = {image.pixel[0] - seen.px[2 * k],
                                    image.pixel[1] - seen.px[2 * k + 1], apart};
        const double size = std::hypot(residual[0], residual[1]);
        const double pixel_weight = seen.huber / std::max(size, seen.huber);
        const double depth_weight = seen.huber / std::max(std::fabs(apart), seen.huber);
        const double weight[3] = {pixel_weight, pixel_weight, depth_weight};
        const double slope = std::isfinite(seen.depth[k]) ? -seen.disparity / (z * z) : 0.0;
        const double by_depth[3] = {0.0, 0.0, slope};
        const double *by_camera[3] = {image.by_point[0], image.by_point[1], by_depth};
        double *block = blocks + 9 * seen.point_of[k];
        double *pull = block_gradient + 3 * seen.point_of[k];
        const std::int64_t slot = seen.slot[seen.pose_of[k]];
        for (std::size_t row = 0; row < 3; ++row) {
            double by_point[3];
            for (std::size_t j = 0; j < 3; ++j)
                by_point[j] = by_camera[row][0] * pose.turn[0][j] +
                              by_camera[row][1] * pose.turn[1][j] +
                              by_camera[row][2] * pose.turn[2][j];
            for (std::size_t i = 0; i < 3; ++i) {
                const double weighed = weight[row] * by_point[i];
                pull[i] += weighed * residual[row];
                for (std::size_t j = 0; j < 3; ++j) block[3 * i + j] += weighed * by_point[j];
            }
            if (slot < 0) continue;
            const std::array<double, 6> turned = by_twist(at.point, by_camera[row]);
            double *own = information + 36 * slot;
            for (std::size_t i = 0; i < 6; ++i) {
                const double weighed = weight[row] * turned[i];
                gradient[6 * slot + static_cast<std::int64_t>(i)] += weighed * residual[row];
                for (std::size_t j = 0; j < 6; ++j) own[6 * i + j] += weighed * turned[j];
            }
            for (std::size_t i = 0; i < 3; ++i)
                for (std::size_t j = 0; j < 6; ++j)
                    coupling[6 * i + j] += weight[row] * by_point[i] * turned[j];
        }
        if (slot >= 0) coupling += 18;
    }
}

MOTORCADE_SIMD
double evaluate(const Fit &fit, const Pose &pose, double *error_px) {
    double cost = 0.0;
    for (std::size_t k = 0; k < fit.count; ++k) {
        const Three point = pose.apply(fit.points + 3 * k);
        double size = infinity;
        if (fit.lens.sees(point)) {
            const Image image = image_of(fit.lens, point);
            size = std::hypot(image.pixel[0] - fit.px[2 * k], image.pixel[1] - fit.px[2 * k + 1]);
        }
        if (!std::isfinite(size)) size = infinity;
        error_px[k] = size;
        const double beyond = std::max(size - fit.outlier, 0.0) / fit.outlier;
        cost += huber(std::min(size, fit.outlier), fit.huber) +
                fit.huber * fit.outlier * std::atan(beyond);
    }
    return cost;
}

MOTORCADE_SIMD
void linearise(const Fit &fit, const Pose &pose, double most_px, double *information,
               double *gradient) {
    std::fill_n(information, 36, 0.0);
    std::fill_n(gradient, 6, 0.0);
    for (std::size_t k = 0; k < fit.count; ++k) {
        const Three point = pose.apply(fit.points + 3 * k);
        if (!fit.lens.sees(point)) continue;
        const Image image = image_of(fit.lens, point);
        const double residual[2] = {image.pixel[0] - fit.px[2 * k],
                                    image.pixel[1] - fit.px[2 * k + 1]};
        const double size = std::hypot(residual[0], residual[1]);
        if (!std::isfinite(size) || size > most_px) continue;
        double weight = 1.0;
        if (most_px == infinity) {
            const double beyond = std::max(size - fit.outlier, 0.0) / fit.outlier;
            weight = fit.huber / std::max(size, fit.huber) / (1.0 + beyond * beyond);
        }
        for (std::size_t row = 0; row < 2; ++row) {
            const std::array<double, 6> by = by_twist(point, image.by_point[row]);
            for (std::size_t i = 0; i < 6; ++i) {
                const double weighed = weight * by[i];
                gradient[i] += weighed * residual[row];
                for (std::size_t j = 0; j <= i; ++j) information[6 * i + j] += weighed * by[j];
            }
        }
    }
    for (std::size_t i = 0; i < 6; ++i)
        for (std::size_t j = 0; j < i; ++j) information[6 * j + i] = information[6 * i + j];
}

namespace {

constexpr double floor_of_diagonal = 1e-9, least_damping = 1e-12;

Pose seen_from(const Motor &world_T_camera) {
    const std::array<double, 12> rows = versors::matrix34(versors::inverse(world_T_camera));
    return pose_of(rows.data());
}

// False where the damped equations have no solution.
bool solve(const double *information, const double *gradient, double damping,
           std::array<double, 6> &step) {
    std::array<double, 36> damped;
    std::copy_n(information, 36, damped.data());
    for (std::size_t i = 0; i < 6; ++i)
        damped[7 * i] += damping * information[7 * i] + floor_of_diagonal;
    if (!invert(damped.data(), 1, 6)) return false;
    for (std::size_t i = 0; i < 6; ++i) {
        step[i] = 0.0;
        for (std::size_t j = 0; j < 6; ++j) step[i] -= damped[6 * i + j] * gradient[j];
    }
    return true;
}

}  // namespace

Motor refine(const Fit &fit, const Motor &world_T_camera, const Stop &stop, double *error_px) {
    Motor best = world_T_camera;
    double information[36], gradient[6], damping = stop.damping;
    double cost = evaluate(fit, seen_from(best), error_px);
    std::vector<double> tried_px(fit.count);
    bool formed = false;
    for (int k = 0; k < stop.steps; ++k) {
        if (!formed) linearise(fit, seen_from(best), infinity, information, gradient);
        formed = true;
        std::array<double, 6> step;
        Motor tried = best;
        double there = infinity;
        if (solve(information, gradient, damping, step)) {
            tried = versors::retract(best, step);
            there = evaluate(fit, seen_from(tried), tried_px.data());
        }
        if (!(there <= cost)) {
            damping *= 10.0;
            if (damping > stop.most_damping) break;
            continue;
        }
        const bool settled = cost - there <= stop.gain * cost;
        best = tried;
        cost = there;
        std::copy(tried_px.begin(), tried_px.end(), error_px);
        damping = std::max(0.1 * damping, least_damping);
        formed = false;
        if (settled) break;
    }
    return best;
}

}  // namespace motorcade::adjusting
