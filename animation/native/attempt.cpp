// Poses and residuals of inverse kinematics; see attempt.h. Steps stand in steps.cpp.

#include "attempt.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace motorcade::animation::ik {
namespace {

// Where all goals are out of reach, what may be won at most, in lengths of the size, for which no
// other pose is sought.
constexpr double HARDLY = 0.1;

// The rotation vector that takes one direction to another; about any axis where they are opposite.
Vector turn_between(const Vector &from, const Vector &to) {
    const Vector across = cross(from, to);
    const double sine = std::sqrt(dot(across, across)), cosine = dot(from, to);
    const double angle = std::atan2(sine, cosine);
    if (sine > 0.0) return (angle / sine) * across;
    if (cosine >= 0.0) return {};
    const Vector other = std::abs(from[0]) < 0.7 ? Vector{1.0, 0.0, 0.0} : Vector{0.0, 1.0, 0.0};
    const Vector axis = cross(from, other);
    return (angle / std::sqrt(dot(axis, axis))) * axis;
}

}  // namespace

Attempt::Attempt(const Solver &solver, const double *local, const std::vector<Goal> &goals,
                 const std::vector<Target> &targets)
    : solver_(solver), goals_(goals), targets_(targets), local_(solver.skeleton_size()),
      shifts_(solver.skeleton_size()), world_(solver.skeleton_size()),
      matrices_(solver.skeleton_size()), left_(3 * goals.size()) {
    for (std::size_t j = 0; j < local_.size(); ++j) {
        std::copy_n(local + 8 * j, 8, local_[j].begin());
        shifts_[j] = versors::translation(local_[j]);
    }
    for (const Joint &joint : solver.joints()) {
        const Motor &at = local_[joint.number];
        const Rotor rotor{at[0], at[1], at[2], at[3]};
        const Rotor rest = versors::inverse(solver.rest_rotors_[joint.number]);
        turns_.push_back(turn_of(joint, versors::compose(rest, rotor), {}));
    }
    find_path();
    start_ = turns_;
    tried_ = turns_;
    place(start_);
    find_least_cost();
}

// By how much targets are farther than the bones from the first joint that turns are long together.
void Attempt::find_least_cost() {
    for (std::size_t g = 0; g < goals_.size(); ++g) {
        const Goal &goal = goals_[g];
        if (goal.aim != Aim::position) {
            all_out_ = false;
            continue;
        }
        double bones = std::sqrt(dot(goal.point, goal.point)), reach = 0.0;
        Vector base{};
        for (auto j = static_cast<std::ptrdiff_t>(goal.joint); j >= 0;) {
            const auto number = static_cast<std::size_t>(j);
            if (const std::ptrdiff_t k = solver_.joint_of_[number]; k >= 0) {
                const Kind kind = solver_.joints()[static_cast<std::size_t>(k)].kind;
                reach = kind == Kind::floating ? std::numeric_limits<double>::infinity() : bones;
                base = position(matrices_[number]);
            }
            bones += std::sqrt(dot(shifts_[number], shifts_[number]));
            j = std::isinf(reach) ? -1 : solver_.parents_[number];
        }
        const Vector away = targets_[g].point - base;
        const double lacks = std::sqrt(dot(away, away)) - reach;
        all_out_ = all_out_ && lacks > 0.0;
        const double share = goal.weight * std::max(lacks, 0.0) / solver_.size_m();
        least_cost_ += 0.5 * share * share;
    }
}

bool Attempt::could_leave(double share) const {
    if (share * cost_ <= least_cost_) return false;
    return !all_out_ || std::sqrt(2.0 * cost_) > std::sqrt(2.0 * least_cost_) + HARDLY;
}

void Attempt::find_path() {
    const std::size_t count = solver_.joints().size();
    std::vector<char> on_path(local_.size(), 0);
    above_.assign(goals_.size() * count, 0);
    for (std::size_t g = 0; g < goals_.size(); ++g)
        for (auto j = static_cast<std::ptrdiff_t>(goals_[g].joint); j >= 0;
             j = solver_.parents_[static_cast<std::size_t>(j)]) {
            const auto number = static_cast<std::size_t>(j);
            on_path[number] = 1;
            if (solver_.joint_of_[number] >= 0)
                above_[g * count + static_cast<std::size_t>(solver_.joint_of_[number])] = 1;
        }
    for (std::size_t j = 0; j < on_path.size(); ++j)
        if (on_path[j]) {
            path_.push_back(j);
            if (solver_.joint_of_[j] >= 0)
                used_.push_back(static_cast<std::size_t>(solver_.joint_of_[j]));
        }
    all_columns_.resize(18 * count * goals_.size());
    gradient_.resize(6 * count);
    axes_.resize(6 * count);
    presses_.resize(2 * count);
}

void Attempt::place(std::vector<Turn> turns) {
    turns_ = std::move(turns);
    cost_ = pose(turns_);
}

// Poses the joints above goals, and leaves residuals; returns half the sum of their squares.
double Attempt::pose(const std::vector<Turn> &turns) {
    for (const std::size_t k : used_) {
        const Joint &joint = solver_.joints()[k];
        const std::size_t j = joint.number;
        const Rotor rotor = versors::compose(solver_.rest_rotors_[j], rotor_at(joint, turns[k]));
        local_[j] = versors::motor_of(versors::renormalize(rotor),
                                      shifts_[j] + solver_.size_m() * turns[k].shift);
    }
    for (const std::size_t j : path_) {
        const std::ptrdiff_t parent = solver_.parents_[j];
        world_[j] = parent < 0
                        ? local_[j]
                        : versors::compose(world_[static_cast<std::size_t>(parent)], local_[j]);
        matrices_[j] = versors::matrix34(world_[j]);
    }
    double cost = 0.0;
    for (std::size_t g = 0; g < goals_.size(); ++g) {
        const double scale = goals_[g].aim == Aim::position ? 1.0 / solver_.size_m() : 1.0;
        const Vector found = (goals_[g].weight * scale) * residual(g);
        std::copy(found.begin(), found.end(), left_.begin() + static_cast<std::ptrdiff_t>(3 * g));
        cost += 0.5 * dot(found, found);
    }
    return cost;
}

Vector Attempt::residual(std::size_t goal) const {
    const Goal &wanted = goals_[goal];
    const Target &target = targets_[goal];
    const auto &matrix = matrices_[wanted.joint];
    if (wanted.aim == Aim::orientation) {
        const Motor &at = world_[wanted.joint];
        return rotation_vector(
            versors::compose(Rotor{at[0], at[1], at[2], at[3]}, versors::inverse(target.rotor)));
    }
    const Vector point = position(matrix) + turned(matrix, wanted.point);
    if (wanted.aim == Aim::position) return point - target.point;
    const Vector away = target.point - point;
    const double distance = std::sqrt(dot(away, away));
    if (!(distance > 0.0)) return {};
    return turn_between((1.0 / distance) * away, turned(matrix, wanted.axis));
}

// How a goal's residual changes as its joint is turned about an axis through a point, or moved
// along it. Of turns by a whole residual this is the exact gradient, and the exact derivative
// where none is left.
void Attempt::differentiate_goal(std::size_t goal, const Vector &axis, const Vector &at,
                                 bool shifts, double *column) const {
    const Goal &wanted = goals_[goal];
    const auto &matrix = matrices_[wanted.joint];
    const Vector point = position(matrix) + turned(matrix, wanted.point);
    const Vector speed = shifts ? solver_.size_m() * axis : cross(axis, point - at);
    Vector made{};
    if (wanted.aim == Aim::position) {
        made = (1.0 / solver_.size_m()) * speed;
    } else if (wanted.aim == Aim::orientation) {
        if (!shifts) made = axis;
    } else {
        const Vector away = targets_[goal].point - point;
        const double square = dot(away, away);
        const Vector pointing = turned(matrix, wanted.axis);
        if (!shifts) made = axis - dot(axis, pointing) * pointing;
        if (square > 0.0) made = made + (1.0 / square) * cross(away, speed);
    }
    for (std::size_t k = 0; k < 3; ++k) column[k] = wanted.weight * made[k];
}

void Attempt::add_columns(std::size_t k) {
    const std::size_t count = solver_.joints().size(), rows = left_.size();
    const Joint &joint = solver_.joints()[k];
    const std::ptrdiff_t parent = solver_.parents_[joint.number];
    const std::array<double, 12> identity{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    const auto &above = parent < 0 ? identity : matrices_[static_cast<std::size_t>(parent)];
    const Vector at = position(matrices_[joint.number]);
    Vector axes[6];
    turning_axes(joint, turns_[k], axes);
    const std::size_t turning = std::min<std::size_t>(coordinates(joint.kind), 3);
    const Rotor &rest = solver_.rest_rotors_[joint.number];
    const auto matrix = versors::matrix34(versors::motor_of(rest, Vector{}));
    for (std::size_t c = 0; c < turning; ++c) axes[c] = turned(above, turned(matrix, axes[c]));
    for (std::size_t c = turning; c < coordinates(joint.kind); ++c)
        axes[c] = {above[c - 3], above[c + 1], above[c + 5]};
    std::copy_n(axes, 6, axes_.begin() + static_cast<std::ptrdiff_t>(6 * k));
    for (std::size_t c = 0; c < coordinates(joint.kind); ++c) {
        double *column = all_columns_.data() + (6 * k + c) * rows;
        std::fill_n(column, rows, 0.0);
        for (std::size_t g = 0; g < goals_.size(); ++g)
            if (above_[g * count + k])
                differentiate_goal(g, axes[c], at, c >= turning, column + 3 * g);
        double sum = 0.0;
        for (std::size_t r = 0; r < rows; ++r) sum += column[r] * left_[r];
        gradient_[6 * k + c] = sum;
    }
}

void Attempt::differentiate() {
    for (const std::size_t k : used_) add_columns(k);
}

bool Attempt::reached(double tolerance) const {
    for (std::size_t g = 0; g < goals_.size(); ++g) {
        const double limit = tolerance * goals_[g].weight;
        double square = 0.0;
        for (std::size_t k = 0; k < 3; ++k) square += left_[3 * g + k] * left_[3 * g + k];
        if (square > limit * limit) return false;
    }
    return true;
}

// What each goal leaves, and which limits it presses on.
void Attempt::report(Solved &solved) {
    const std::size_t count = solver_.joints().size(), rows = left_.size();
    differentiate();
    solved.presses.assign(2 * count * goals_.size(), 0.0);
    for (std::size_t g = 0; g < goals_.size(); ++g) {
        solved.residuals.push_back(residual(g));
        for (const std::size_t k : used_) {
            double gradient[6] = {}, directions[6][6];
            for (std::size_t c = 0; c < coordinates(solver_.joints()[k].kind); ++c)
                for (std::size_t r = 3 * g; r < 3 * g + 3; ++r)
                    gradient[c] += all_columns_[(6 * k + c) * rows + r] * left_[r];
            free_directions(solver_.joints()[k], turns_[k], gradient, directions,
                            solved.presses.data() + 2 * (g * count + k));
        }
    }
}

void Attempt::write(double *out) const {
    for (std::size_t j = 0; j < local_.size(); ++j) {
        Motor made = local_[j];
        const std::ptrdiff_t k = solver_.joint_of_[j];
        if (k >= 0) {
            const auto number = static_cast<std::size_t>(k);
            const Rotor turn = rotor_at(solver_.joints()[number], turns_[number]);
            const Rotor rotor = versors::compose(solver_.rest_rotors_[j], turn);
            made = versors::motor_of(versors::renormalize(rotor),
                                     shifts_[j] + solver_.size_m() * turns_[number].shift);
        }
        std::copy_n(made.begin(), 8, out + 8 * j);
    }
}

}  // namespace motorcade::animation::ik
