// Points seen through a lens, against where they were seen: residuals, and what they say of poses
// and points.
//
// Triggs et al. 2000, section 6 (points in blocks); lenses as in motorcade.tracking.cameras.lenses.

#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace motorcade::adjusting {

using Three = std::array<double, 3>;

enum class Model { pinhole, radtan, equidistant };

// Coefficients in the order of `Camera.distortion`, and zeros behind them.
struct Lens {
    Model model;
    double fx, fy, cx, cy;
    std::array<double, 8> k;

    bool sees_behind() const { return model == Model::equidistant; }

    // A pinhole sees what is before it; an equidistant lens anything but what is straight behind,
    // which it would draw as a circle.
    bool sees(const Three &point) const {
        return point[2] > 0.0 || (sees_behind() && (point[0] != 0.0 || point[1] != 0.0));
    }
};

// A pixel and its derivative by the point in the camera's frame.
struct Image {
    double pixel[2], by_point[2][3];
};

// The lens sees the point.
Image image_of(const Lens &lens, const Three &point);

// Turns a point of the world into the camera's frame: rows of a rotation, and a translation.
struct Pose {
    double turn[3][3], shift[3];

    Three apply(const double *point) const {
        Three there;
        for (std::size_t i = 0; i < 3; ++i)
            there[i] =
                turn[i][0] * point[0] + turn[i][1] * point[1] + turn[i][2] * point[2] + shift[i];
        return there;
    }
};

// Of a matrix with four numbers a row.
inline Pose pose_of(const double *matrix) {
    Pose pose;
    for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t j = 0; j < 3; ++j) pose.turn[i][j] = matrix[4 * i + j];
        pose.shift[i] = matrix[4 * i + 3];
    }
    return pose;
}

// Derivative by the twist of the camera's pose, rotation before translation, of a number whose
// derivative by the point in its frame is given: the point moves by X x d(rotation) - d(place).
inline std::array<double, 6> by_twist(const Three &point, const double *by_point) {
    const double x = point[0], y = point[1], z = point[2];
    const double a = by_point[0], b = by_point[1], c = by_point[2];
    return {z * b - y * c, x * c - z * a, y * a - x * b, -a, -b, -c};
}

// What is adjusted. Poses are camera_T_world, 4 x 4; a slot is -1 where a pose stays as it is.
struct Observations {
    Lens lens;
    const double *poses, *points;
    const std::int64_t *pose_of, *point_of, *slot;
    const double *px, *depth;
    std::size_t count;
    double disparity, huber, nearest;
};

// Sizes of the pixels' residuals, infinite where the lens does not see; returns the sum of Huber's
// losses.
double evaluate(const Observations &seen, double *error_px);

// Sums into `information` (free, 6, 6) and `gradient` (free, 6) of the poses, `blocks` (points, 3,
// 3) and `block_gradient` (points, 3), which are zero before; and for each observation of a free
// pose, in their order, its `coupling` (3, 6).
void linearise(const Observations &seen, double *information, double *gradient, double *blocks,
               double *block_gradient, double *coupling);

// One pose alone. Huber's loss up to `outlier`, beyond it Cauchy's.
struct Fit {
    Lens lens;
    const double *points, *px;
    std::size_t count;
    double huber, outlier;
};

using Motor = std::array<double, 8>;

// When a minimisation ends; see motorcade.tracking.optimise.
struct Stop {
    int steps;
    double gain, damping, most_damping;
};

// The world_T_camera near another that the points agree with best, and the sizes of residuals
// there: Levenberg's and Marquardt's steps as `minimise` takes them.
Motor refine(const Fit &fit, const Motor &world_T_camera, const Stop &stop, double *error_px);

// Cost at a pose; sizes of residuals, infinite where the lens does not see.
double evaluate(const Fit &fit, const Pose &pose, double *error_px);
// By the loss's weights, or by those residuals alone that are not larger than `most_px`.
void linearise(const Fit &fit, const Pose &pose, double most_px, double *information,
               double *gradient);

}  // namespace motorcade::adjusting
