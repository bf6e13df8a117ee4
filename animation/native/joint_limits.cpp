// Coordinates and limits of joints; see joint_limits.h.

#include "joint_limits.h"

#include <algorithm>
#include <cmath>

namespace motorcade::animation::ik {
namespace {

constexpr double PI = 3.14159265358979323846;
constexpr double TURN = 2.0 * PI;
// How near to the edge of its ellipse a swing counts as being on it.
constexpr double ON_EDGE = 1e-12;

bool swings_freely(const Joint &joint) { return std::isinf(joint.swing[0]); }

// An ellipse with a width of 0 is a segment, whose ends bound a coordinate.
bool is_ellipse(const Joint &joint) {
    return !swings_freely(joint) && joint.swing[0] > 0.0 && joint.swing[1] > 0.0;
}

// The point of an ellipse nearest to one outside it. Newton's method on a convex function, from
// the side where it cannot overshoot (Eberly, "Distance from a point to an ellipse", 2013).
void bring_into_ellipse(const double *half, double &x, double &y) {
    const double u = x / half[0], v = y / half[1];
    const double size = u * u + v * v;
    if (size <= 1.0) return;
    if (half[0] != half[1]) {
        const double a2 = half[0] * half[0], b2 = half[1] * half[1];
        const double ax = half[0] * std::abs(x), by = half[1] * std::abs(y);
        double t = std::max(ax - a2, by - b2);
        for (int round = 0; round < 40; ++round) {
            const double p = ax / (t + a2), q = by / (t + b2);
            const double excess = p * p + q * q - 1.0;
            const double slope = 2.0 * (p * p / (t + a2) + q * q / (t + b2));
            const double moved = excess / slope;
            t += moved;
            if (!(moved > 1e-15 * (t + a2 + b2))) break;
        }
        x *= a2 / (t + a2);
        y *= b2 / (t + b2);
    }
    const double scale = 1.0 / std::hypot(x / half[0], y / half[1]);
    x *= scale;
    y *= scale;
}

void bring_swing_back(const Joint &joint, double &x, double &y) {
    if (swings_freely(joint)) {
        // Swings by s and by s - 2 pi about one axis are the same rotation.
        const double size = std::hypot(x, y);
        if (size > PI) {
            const double scale = (size - TURN * std::round(size / TURN)) / size;
            x *= scale;
            y *= scale;
        }
    } else if (is_ellipse(joint)) {
        bring_into_ellipse(joint.swing, x, y);
    } else {
        x = std::clamp(x, -joint.swing[0], joint.swing[0]);
        y = std::clamp(y, -joint.swing[1], joint.swing[1]);
    }
}

// The angle that is the same up to whole turns and lies nearest to an interval, brought into it.
double brought_between(double angle, double low, double high) {
    if (std::isinf(low) || std::isinf(high)) return std::clamp(angle, low, high);
    const double middle = 0.5 * (low + high);
    const double near = angle - TURN * std::round((angle - middle) / TURN);
    return std::clamp(near, low, high);
}

double angle_about(const Rotor &rotor, const Vector &axis) {
    const double along = -(rotor[1] * axis[0] + rotor[2] * axis[1] + rotor[3] * axis[2]);
    if (along == 0.0 && rotor[0] == 0.0) return 0.0;
    const double angle = 2.0 * std::atan2(along, rotor[0]);
    return angle - TURN * std::round(angle / TURN);
}

Vector swing_vector(const Joint &joint, const Turn &turn) {
    return turn.at[0] * joint.across + turn.at[1] * joint.aside;
}

// Moves a swing along a direction of x and y alone, or a twist alone.
void add(double (*directions)[6], std::size_t &count, double x, double y, double t) {
    double *made = directions[count++];
    std::fill(made, made + 6, 0.0);
    made[0] = x;
    made[1] = y;
    made[2] = t;
}

// A coordinate between two ends: how hard it is pressed on one of them, with that end's sign.
double pressed(double at, double low, double high, double gradient) {
    if (low == high) return -gradient;
    return (at <= low && gradient > 0.0) || (at >= high && gradient < 0.0) ? -gradient : 0.0;
}

bool moves(double at, double low, double high, double gradient) {
    return low < high && pressed(at, low, high, gradient) == 0.0;
}

// Directions of the swing of a ball.
double free_swings(const Joint &joint, const Turn &turn, const double *gradient,
                   double (*directions)[6], std::size_t &count) {
    const double x = turn.at[0], y = turn.at[1];
    const double *half = joint.swing;
    if (is_ellipse(joint)) {
        const double u = x / half[0], v = y / half[1];
        double nx = u / half[0], ny = v / half[1];
        const double size = std::hypot(nx, ny);
        nx /= size;
        ny /= size;
        const double outward = -(gradient[0] * nx + gradient[1] * ny);
        if (u * u + v * v >= 1.0 - ON_EDGE && outward > 0.0) {
            add(directions, count, -ny, nx, 0.0);
            return outward;
        }
    } else if (!swings_freely(joint)) {
        if (moves(x, -half[0], half[0], gradient[0])) add(directions, count, 1.0, 0.0, 0.0);
        if (moves(y, -half[1], half[1], gradient[1])) add(directions, count, 0.0, 1.0, 0.0);
        return std::hypot(pressed(x, -half[0], half[0], gradient[0]),
                          pressed(y, -half[1], half[1], gradient[1]));
    }
    add(directions, count, 1.0, 0.0, 0.0);
    add(directions, count, 0.0, 1.0, 0.0);
    return 0.0;
}

}  // namespace

Rotor rotor_of(const Vector &vector_rad) { return versors::exp(-0.5 * vector_rad); }

Vector rotation_vector(const Rotor &rotor) {
    const bool long_way = rotor[0] < 0.0;
    const Rotor shorter = long_way ? Rotor{-rotor[0], -rotor[1], -rotor[2], -rotor[3]} : rotor;
    return -2.0 * versors::log(shorter);
}

std::size_t coordinates(Kind kind) {
    if (kind == Kind::hinge) return 1;
    return kind == Kind::floating ? 6 : 3;
}

Turn turn_of(const Joint &joint, const Rotor &rotor, const Vector &shift) {
    Turn made;
    if (joint.kind == Kind::free_ball || joint.kind == Kind::floating) {
        made.rotor = rotor;
        made.shift = shift;
        return made;
    }
    const double angle = angle_about(rotor, joint.axis);
    made.at[2] = brought_between(angle, joint.low, joint.high);
    if (joint.kind == Kind::ball) {
        const Vector swing =
            rotation_vector(versors::compose(rotor, rotor_of(-angle * joint.axis)));
        made.at[0] = dot(swing, joint.across);
        made.at[1] = dot(swing, joint.aside);
        bring_swing_back(joint, made.at[0], made.at[1]);
    }
    return made;
}

Turn stepped(const Joint &joint, const Turn &turn, const double *step) {
    Turn made = turn;
    if (joint.kind == Kind::free_ball || joint.kind == Kind::floating) {
        made.rotor = versors::renormalize(
            versors::compose(rotor_of({step[0], step[1], step[2]}), turn.rotor));
        if (joint.kind == Kind::floating)
            made.shift = turn.shift + Vector{step[3], step[4], step[5]};
        return made;
    }
    if (joint.kind == Kind::hinge) {
        made.at[2] = std::clamp(turn.at[2] + step[0], joint.low, joint.high);
        return made;
    }
    made.at[0] += step[0];
    made.at[1] += step[1];
    bring_swing_back(joint, made.at[0], made.at[1]);
    made.at[2] = std::clamp(turn.at[2] + step[2], joint.low, joint.high);
    return made;
}

Turn scattered(const Joint &joint, const Turn &turn, const double *shares) {
    const auto between = [](double low, double high, double at, double share) {
        if (std::isinf(low) || std::isinf(high)) return std::clamp(at + PI * share, low, high);
        return 0.5 * (low + high) + 0.5 * (high - low) * share;
    };
    double step[6];
    if (joint.kind == Kind::hinge) {
        step[0] = between(joint.low, joint.high, turn.at[2], shares[0]) - turn.at[2];
    } else if (joint.kind == Kind::ball) {
        for (std::size_t k = 0; k < 2; ++k)
            step[k] = between(-joint.swing[k], joint.swing[k], turn.at[k], shares[k]) - turn.at[k];
        step[2] = between(joint.low, joint.high, turn.at[2], shares[2]) - turn.at[2];
    } else {
        for (std::size_t k = 0; k < 3; ++k) step[k] = 0.5 * PI * shares[k];
        for (std::size_t k = 3; k < 6; ++k) step[k] = 0.5 * shares[k];
    }
    return stepped(joint, turn, step);
}

Rotor rotor_at(const Joint &joint, const Turn &turn) {
    switch (joint.kind) {
    case Kind::hinge:
        return rotor_of(turn.at[2] * joint.axis);
    case Kind::ball:
        return versors::compose(rotor_of(swing_vector(joint, turn)),
                                rotor_of(turn.at[2] * joint.axis));
    default:
        return turn.rotor;
    }
}

void turning_axes(const Joint &joint, const Turn &turn, Vector *axes) {
    if (joint.kind == Kind::hinge) {
        axes[0] = joint.axis;
        return;
    }
    if (joint.kind != Kind::ball) {
        axes[0] = {1.0, 0.0, 0.0};
        axes[1] = {0.0, 1.0, 0.0};
        axes[2] = {0.0, 0.0, 1.0};
        return;
    }
    // The left Jacobian of rotations, on both directions of the swing; then the turned axis.
    const Vector s = swing_vector(joint, turn);
    const double size2 = dot(s, s), size = std::sqrt(size2);
    const bool small = size < 1e-4;
    const double first = small ? 0.5 - size2 / 24.0 : (1.0 - std::cos(size)) / size2;
    const double second =
        small ? 1.0 / 6.0 - size2 / 120.0 : (size - std::sin(size)) / (size2 * size);
    const Vector *along[2] = {&joint.across, &joint.aside};
    for (std::size_t k = 0; k < 2; ++k) {
        const Vector once = cross(s, *along[k]);
        axes[k] = *along[k] + first * once + second * cross(s, once);
    }
    const double sine = small ? 1.0 - size2 / 6.0 : std::sin(size) / size;
    const Vector once = cross(s, joint.axis);
    axes[2] = joint.axis + sine * once + first * cross(s, once);
}

double edge_curvature(const Joint &joint, const Turn &turn) {
    if (joint.kind != Kind::ball || !is_ellipse(joint)) return 0.0;
    const double a2 = joint.swing[0] * joint.swing[0], b2 = joint.swing[1] * joint.swing[1];
    const double x = turn.at[0] / a2, y = turn.at[1] / b2;
    const double slope = std::hypot(x, y);
    return slope > 0.0 ? 1.0 / (a2 * b2 * slope * slope * slope) : 0.0;
}

std::size_t free_directions(const Joint &joint, const Turn &turn, const double *gradient,
                            double (*directions)[6], double *presses) {
    std::size_t count = 0;
    presses[0] = presses[1] = 0.0;
    if (joint.kind == Kind::hinge) {
        presses[1] = pressed(turn.at[2], joint.low, joint.high, gradient[0]);
        if (moves(turn.at[2], joint.low, joint.high, gradient[0]))
            add(directions, count, 1.0, 0.0, 0.0);
        return count;
    }
    if (joint.kind == Kind::ball) {
        presses[0] = free_swings(joint, turn, gradient, directions, count);
        presses[1] = pressed(turn.at[2], joint.low, joint.high, gradient[2]);
        if (moves(turn.at[2], joint.low, joint.high, gradient[2]))
            add(directions, count, 0.0, 0.0, 1.0);
        return count;
    }
    for (; count < coordinates(joint.kind); ++count)
        for (std::size_t k = 0; k < 6; ++k) directions[count][k] = k == count ? 1.0 : 0.0;
    return count;
}

}  // namespace motorcade::animation::ik
