// Passes of FABRIK; see fabrik.h.

#include "fabrik.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "ik.h"

namespace motorcade::animation::ik {
namespace {

constexpr double PI = 3.14159265358979323846;
// Passes that take more rounds than these creep.
constexpr std::size_t ROUNDS = 24;
// Other poses that are tried where a target is not reached.
constexpr std::size_t RESTARTS = 2;
// Distances below this share of a bone have no direction.
constexpr double NOTHING = 1e-9;

double length(const Vector &v) { return std::sqrt(dot(v, v)); }

Vector unit(const Vector &v, const Vector &otherwise) {
    const double size = length(v);
    return size > 0.0 ? (1.0 / size) * v : otherwise;
}

Vector perpendicular(const Vector &v) {
    const Vector other =
        std::abs(v[2]) > 0.9 * length(v) ? Vector{1.0, 0.0, 0.0} : Vector{0.0, 0.0, 1.0};
    return unit(cross(other, v), other);
}

// A direction within an angle of the one before it, turned back in their common plane.
Vector turned_back(const Vector &direction, const Vector &before, double limit) {
    const double cosine = dot(direction, before);
    if (cosine >= std::cos(limit)) return direction;
    Vector across = direction - cosine * before;
    across = length(across) > 1e-9 ? unit(across, across) : perpendicular(before);
    return std::cos(limit) * before + std::sin(limit) * across;
}

// The least rotor that turns one unit vector to another.
Rotor least_turn(const Vector &from, const Vector &to) {
    const Vector across = cross(from, to);
    const double sine = length(across), angle = std::atan2(sine, dot(from, to));
    return rotor_of(angle * (sine > 0.0 ? (1.0 / sine) * across : perpendicular(from)));
}

Vector turned(const Rotor &rotor, const Vector &v) {
    return versors::translation(versors::compose(versors::motor_of(rotor, Vector{}),
                                                 versors::motor_of(Rotor{1.0, 0.0, 0.0, 0.0}, v)));
}

}  // namespace

Fabrik::Fabrik(std::span<const double> limits, double tolerance)
    : limits_(limits.begin(), limits.end()), bones_(limits.size()), tolerance_(tolerance),
      points_(limits.size() + 1), best_(limits.size() + 1) {}

bool Fabrik::solve(double *points, const Vector &target, const Vector &direction, double &error,
                   std::size_t &rounds) {
    const std::size_t count = points_.size();
    for (std::size_t k = 0; k < count; ++k) std::copy_n(points + 3 * k, 3, points_[k].begin());
    total_ = 0.0;
    for (std::size_t k = 0; k + 1 < count; ++k)
        total_ += bones_[k] = length(points_[k + 1] - points_[k]);
    if (!(total_ > 0.0)) return false;
    target_ = target;
    direction_ = direction;
    error_ = std::numeric_limits<double>::infinity();
    const std::vector<Vector> start = points_;
    const bool far = length(target - points_[0]) >= total_;
    stretch();
    up();
    keep();
    points_ = start;
    up();
    keep();
    for (std::size_t k = 0; !far && k < ROUNDS && error_ > tolerance_ * total_; ++k, ++rounds) {
        down();
        up();
        keep();
    }
    // Out of reach a chain is straight, unless its base may not point there.
    const bool held = dot(direction, direction) > 0.0 && limits_.front() < PI;
    if (error_ > tolerance_ * total_ && (!far || held)) squares(direction, rounds);
    for (std::size_t k = 0; k < count; ++k) std::copy_n(best_[k].begin(), 3, points + 3 * k);
    error = error_;
    return true;
}

// Straight towards the target.
void Fabrik::stretch() {
    const Vector base = points_.front();
    const Vector ahead = unit(target_ - base, unit(points_.back() - base, {1.0, 0.0, 0.0}));
    for (std::size_t k = 0; k < bones_.size(); ++k) points_[k + 1] = points_[k] + bones_[k] * ahead;
}

// From the base to the end; limits hold when it is done.
void Fabrik::up() {
    Vector before = direction_;
    for (std::size_t k = 0; k < bones_.size(); ++k) {
        points_[k + 1] = placed(points_[k], points_[k + 1], bones_[k], before, limits_[k]);
        before = unit(points_[k + 1] - points_[k], before);
    }
}

// From the target to the base, which is left.
void Fabrik::down() {
    const Vector base = points_.front();
    Vector before{};
    points_.back() = target_;
    for (std::size_t k = bones_.size(); k-- > 0;) {
        const double limit = k + 1 < bones_.size() ? limits_[k + 1] : PI;
        points_[k] = placed(points_[k + 1], points_[k], bones_[k], before, limit);
        before = unit(points_[k] - points_[k + 1], before);
    }
    points_.front() = base;
}

// The moving joint on the sphere around the fixed one, within the limit of its bones.
Vector Fabrik::placed(const Vector &fixed, const Vector &moving, double bone, const Vector &before,
                      double limit) const {
    const bool led = dot(before, before) > 0.0;
    const Vector away = moving - fixed;
    const double apart = length(away);
    Vector towards = led ? before : Vector{1.0, 0.0, 0.0};
    if (apart > NOTHING * (bone + 1e-30)) towards = (1.0 / apart) * away;
    if (led && limit < PI) towards = turned_back(towards, before, limit);
    return versors::reach(fixed, fixed + towards, bone);
}

// Keeps the chain where it ends nearer than all before it.
bool Fabrik::keep() {
    const double error = length(points_.back() - target_);
    if (!(error < error_)) return false;
    error_ = error;
    best_ = points_;
    return true;
}

// Goes on by least squares, on a chain of joints whose bones lie along z.
void Fabrik::squares(const Vector &direction, std::size_t &rounds) {
    const std::size_t count = points_.size();
    const Vector z{0.0, 0.0, 1.0}, base = best_.front();
    const Rotor none{1.0, 0.0, 0.0, 0.0};
    const Rotor frame = dot(direction, direction) > 0.0 ? least_turn(z, direction) : none;
    std::vector<std::int64_t> parents(count);
    std::vector<double> rest(8 * count), local(8 * count), made(8 * count);
    std::vector<Joint> joints;
    Rotor world = frame;
    for (std::size_t k = 0; k < count; ++k) {
        parents[k] = static_cast<std::int64_t>(k) - 1;
        const Vector shift = k == 0 ? Vector{} : bones_[k - 1] * z;
        Rotor turn = none;
        if (k + 1 < count) {
            const double limit = limits_[k];
            const double most = limit < PI ? limit : std::numeric_limits<double>::infinity();
            const Vector before = turned(world, z);
            const Rotor least = least_turn(before, unit(best_[k + 1] - best_[k], before));
            turn = versors::compose(versors::inverse(world), versors::compose(least, world));
            joints.push_back({limit < PI ? Kind::ball : Kind::free_ball,
                              k,
                              z,
                              {1.0, 0.0, 0.0},
                              {0.0, 1.0, 0.0},
                              {most, most},
                              0.0,
                              0.0});
        }
        world = versors::renormalize(versors::compose(world, turn));
        const Motor at = versors::motor_of(none, shift);
        const Motor posed = versors::motor_of(turn, shift);
        std::copy_n(at.begin(), 8, rest.begin() + static_cast<std::ptrdiff_t>(8 * k));
        std::copy_n(posed.begin(), 8, local.begin() + static_cast<std::ptrdiff_t>(8 * k));
    }
    const Solver solver(parents.data(), rest.data(), count, std::move(joints));
    const Vector away = turned(versors::inverse(frame), target_ - base);
    const std::vector<Goal> goals{{Aim::position, count - 1, {}, {}, 1.0}};
    const Solved solved = solver.solve(local.data(), goals, {{away, none}},
                                       {0.5 * tolerance_, RESTARTS}, made.data());
    rounds += solved.rounds;
    Motor pose = versors::motor_of(frame, base);
    points_.front() = base;
    for (std::size_t k = 0; k < count; ++k) {
        Motor step;
        std::copy_n(made.begin() + static_cast<std::ptrdiff_t>(8 * k), 8, step.begin());
        pose = versors::compose(pose, step);
        if (k > 0) points_[k] = versors::translation(pose);
    }
    keep();
}

}  // namespace motorcade::animation::ik
