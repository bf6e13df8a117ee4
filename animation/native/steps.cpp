// Steps of inverse kinematics: Levenberg and Marquardt's, and Newton's where they are slow.

#include <algorithm>
#include <cmath>

#include "attempt.h"
#include "support.h"

namespace motorcade::animation::ik {
namespace {

// Where a step changes the cost by less than this share, it has gone as far as it goes.
constexpr double STILL = 1e-13;
constexpr double LEAST_DAMPING = 1e-12, MOST_DAMPING = 1e6;

// In radians.
constexpr double LONGEST_STEP = 0.6;
// Of more columns second derivatives cost more than the slow steps that they save.
constexpr std::size_t MOST_CURVED = 400;
// Torques whose square is below this share of the cost turn nothing that matters.
constexpr double SMALL_TORQUE = 1e-8;
// A step that takes less than this share off the cost is slow.
constexpr double SLOW = 0.3;
// After so many slow steps in a row, the dearer ones of Newton are taken.
constexpr int SLOW_ROUNDS = 2;
// So much more damping is tried where the second derivatives lead uphill.
constexpr double MORE_CURVED = 4.0;
// A step that leaves more is shortened to this share, until so many are tried.
constexpr double SHORTER = 0.3;
constexpr int TRIES = 4;
// Steps whose gains get less hardly gain more together than so many like the last.
constexpr double PACE = 10.0;
// Curvatures above this share of the largest are told from rounding.
constexpr double CERTAIN = 1e-9;

// Solves A x = b in place for a symmetric A above 0, by Cholesky's factors; false where it is not.
// Of A the lower half is read; `column` has room for n numbers. What is left of A is updated by one
// column after another, as sums that go on side by side.
MOTORCADE_SIMD
bool solve_symmetric(double *__restrict__ a, double *__restrict__ b, double *__restrict__ column,
                     std::size_t n) {
    for (std::size_t j = 0; j < n; ++j) {
        const double square = a[j * n + j];
        if (!(square > 0.0)) return false;
        const double inverse = 1.0 / std::sqrt(square);
        a[j * n + j] = inverse;
        b[j] *= inverse;
        for (std::size_t i = j + 1; i < n; ++i) {
            double *__restrict__ row = a + i * n;
            const double factor = column[i] = row[j] *= inverse;
            b[i] -= factor * b[j];
            for (std::size_t k = j + 1; k <= i; ++k) row[k] -= factor * column[k];
        }
    }
    for (std::size_t i = n; i-- > 0;) {
        const double found = b[i] *= a[i * n + i];
        for (std::size_t k = 0; k < i; ++k) b[k] -= a[i * n + k] * found;
    }
    return true;
}

// Steps that turn a joint farther leave what the derivatives know, and are shortened as a whole.
// Shifts, the last three of a joint's six, are known however far they go.
void shorten(std::vector<double> &steps) {
    double most = 0.0;
    for (std::size_t k = 0; k < steps.size(); ++k)
        if (k % 6 < 3) most = std::max(most, std::abs(steps[k]));
    if (most > LONGEST_STEP)
        for (double &step : steps) step *= LONGEST_STEP / most;
}

}  // namespace

void Attempt::choose_directions() {
    const std::size_t rows = left_.size();
    columns_.clear();
    jacobian_.clear();
    for (const std::size_t k : used_) {
        const Joint &joint = solver_.joints()[k];
        double directions[6][6];
        const std::size_t found = free_directions(joint, turns_[k], gradient_.data() + 6 * k,
                                                  directions, presses_.data() + 2 * k);
        for (std::size_t d = 0; d < found; ++d) {
            Column column{k, {}, {}, joint.kind == Kind::floating && d >= 3};
            std::copy_n(directions[d], 6, column.along);
            for (std::size_t c = 0; c < coordinates(joint.kind); ++c)
                column.axis = column.axis + column.along[c] * axes_[6 * k + c];
            columns_.push_back(column);
            for (std::size_t r = 0; r < rows; ++r) {
                double sum = 0.0;
                for (std::size_t c = 0; c < coordinates(joint.kind); ++c)
                    sum += column.along[c] * all_columns_[(6 * k + c) * rows + r];
                jacobian_.push_back(sum);
            }
        }
    }
}

double Attempt::largest_square() const {
    const std::size_t rows = left_.size();
    double most = 0.0;
    for (std::size_t c = 0; c < columns_.size(); ++c) {
        double sum = 0.0;
        for (std::size_t r = 0; r < rows; ++r)
            sum += jacobian_[c * rows + r] * jacobian_[c * rows + r];
        most = std::max(most, sum);
    }
    return most;
}

// The damped step of every free direction: of Newton, or of Gauss and Newton by the smaller of the
// two square systems.
bool Attempt::step_for(double damping, bool curved, std::vector<double> &steps) {
    const std::size_t rows = left_.size(), count = columns_.size();
    const double *j = jacobian_.data();
    const bool by_rows = !curved && rows <= count;
    const std::size_t n = by_rows ? rows : count;
    square_.assign(n * n, 0.0);
    solution_.assign(n, 0.0);
    column_.resize(n);
    if (by_rows) {
        for (std::size_t c = 0; c < count; ++c)
            for (std::size_t r = 0; r < rows; ++r)
                for (std::size_t s = 0; s <= r; ++s)
                    square_[r * n + s] += j[c * rows + r] * j[c * rows + s];
        solution_ = left_;
    } else {
        for (std::size_t c = 0; c < count; ++c) {
            for (std::size_t d = 0; d <= c; ++d) {
                double sum = 0.0;
                for (std::size_t r = 0; r < rows; ++r) sum += j[c * rows + r] * j[d * rows + r];
                square_[c * n + d] = sum;
            }
            for (std::size_t r = 0; r < rows; ++r) solution_[c] += j[c * rows + r] * left_[r];
        }
    }
    if (curved) add_curvature();
    for (std::size_t k = 0; k < n; ++k) square_[k * n + k] += damping;
    if (!solve_symmetric(square_.data(), solution_.data(), column_.data(), n)) return false;
    steps.assign(6 * solver_.joints().size(), 0.0);
    for (std::size_t c = 0; c < count; ++c) {
        double size = by_rows ? 0.0 : -solution_[c];
        if (by_rows)
            for (std::size_t r = 0; r < rows; ++r) size -= j[c * rows + r] * solution_[r];
        for (std::size_t k = 0; k < 6; ++k)
            steps[6 * columns_[c].joint + k] += size * columns_[c].along[k];
    }
    return true;
}

// What of the second derivatives the squares of the first leave out: how the places of goals curve
// as joints turn, times what is left. It matters where much is left: far from a target out of
// reach.
void Attempt::add_curvature() {
    const std::size_t count = columns_.size(), joints = solver_.joints().size();
    for (std::size_t g = 0; g < goals_.size(); ++g) {
        const Goal &goal = goals_[g];
        if (goal.aim != Aim::position) continue;
        const auto &matrix = matrices_[goal.joint];
        const Vector point = position(matrix) + turned(matrix, goal.point);
        const Vector pull = (goal.weight / solver_.size_m()) *
                            Vector{left_[3 * g], left_[3 * g + 1], left_[3 * g + 2]};
        arms_.assign(3 * count, Vector{});
        for (std::size_t c = 0; c < count; ++c) {
            const Column &low = columns_[c];
            if (!above_[g * joints + low.joint]) continue;
            const Vector arm = point - position(matrices_[solver_.joints()[low.joint].number]);
            Vector *made = arms_.data() + 3 * c;
            made[0] = low.shifts ? solver_.size_m() * low.axis : cross(low.axis, arm);
            made[1] = low.shifts ? Vector{} : cross(pull, low.axis);
            made[2] = low.shifts ? Vector{} : made[0];
            for (std::size_t d = 0; d <= c; ++d) {
                const std::size_t high = columns_[d].joint;
                const Vector *other = arms_.data() + 3 * d;
                if (high == low.joint)
                    square_[c * count + d] +=
                        0.5 * (dot(other[1], made[2]) + dot(made[1], other[2]));
                else if (solver_.is_above(high, low.joint))
                    square_[c * count + d] += dot(other[1], made[0]);
            }
        }
    }
    for (std::size_t c = 0; c < count;) {
        std::size_t end = c;
        while (end < count && columns_[end].joint == columns_[c].joint) ++end;
        if (solver_.joints()[columns_[c].joint].kind == Kind::ball) add_curvature_of_ball(c, end);
        c = end;
    }
}

// How the axes of a ball's coordinates turn with them, times the torque on it; and how the edge of
// its swings curves, times how hard it is pressed.
void Attempt::add_curvature_of_ball(std::size_t first, std::size_t end) {
    const std::size_t count = columns_.size(), k = columns_[first].joint;
    const Joint &joint = solver_.joints()[k];
    double changes[3][3];
    changing_gradients(k, changes);
    for (std::size_t c = first; c < end; ++c)
        for (std::size_t d = first; d <= c; ++d)
            for (std::size_t a = 0; a < 3; ++a)
                for (std::size_t b = 0; b < 3; ++b)
                    square_[c * count + d] += 0.5 * columns_[c].along[a] * columns_[d].along[b] *
                                              (changes[a][b] + changes[b][a]);
    if (presses_[2 * k] > 0.0 && columns_[first].along[2] == 0.0)
        square_[first * count + first] += presses_[2 * k] * edge_curvature(joint, turns_[k]);
}

// How the gradient by each coordinate changes as another turns its axis alone.
void Attempt::changing_gradients(std::size_t k, double (*changes)[3]) const {
    constexpr double STEP = 1e-5;
    const Joint &joint = solver_.joints()[k];
    const Vector pull = torque(k);
    std::fill_n(&changes[0][0], 9, 0.0);
    if (dot(pull, pull) < SMALL_TORQUE * cost_) return;
    const Rotor &rest = solver_.rest_rotors_[joint.number];
    const std::ptrdiff_t parent = solver_.parents_[joint.number];
    Rotor frame = rest;
    if (parent >= 0) {
        const Motor &above = world_[static_cast<std::size_t>(parent)];
        frame = versors::compose(Rotor{above[0], above[1], above[2], above[3]}, rest);
    }
    const auto matrix = versors::matrix34(versors::motor_of(frame, Vector{}));
    Vector before[3], after[3];
    for (std::size_t a = 0; a < 3; ++a) {
        Turn low = turns_[k], high = turns_[k];
        low.at[a] -= STEP;
        high.at[a] += STEP;
        turning_axes(joint, low, before);
        turning_axes(joint, high, after);
        for (std::size_t b = 0; b < 3; ++b)
            changes[a][b] = 0.5 / STEP * dot(turned(matrix, after[b] - before[b]), pull);
    }
}

// What the goals' residuals press a joint to turn about.
Vector Attempt::torque(std::size_t k) const {
    const std::size_t joints = solver_.joints().size();
    Vector sum{};
    for (std::size_t g = 0; g < goals_.size(); ++g) {
        if (!above_[g * joints + k]) continue;
        const Goal &goal = goals_[g];
        const Vector left = goal.weight * Vector{left_[3 * g], left_[3 * g + 1], left_[3 * g + 2]};
        if (goal.aim != Aim::position) {
            sum = sum + left;
            continue;
        }
        const auto &matrix = matrices_[goal.joint];
        const Vector arm = position(matrix) + turned(matrix, goal.point) -
                           position(matrices_[solver_.joints()[k].number]);
        sum = sum + (1.0 / solver_.size_m()) * cross(arm, left);
    }
    return sum;
}

bool Attempt::settled() {
    for (const Goal &goal : goals_)
        if (goal.aim != Aim::position) return false;
    differentiate();
    choose_directions();
    const double most = largest_square();
    std::vector<double> steps;
    return most > 0.0 && columns_.size() <= MOST_CURVED && step_for(CERTAIN * most, true, steps);
}

// Takes a step, or as much of it as leaves less.
bool Attempt::take(std::vector<double> &steps) {
    shorten(steps);
    for (int tries = 0; tries < TRIES; ++tries) {
        for (const std::size_t k : used_)
            tried_[k] = stepped(solver_.joints()[k], turns_[k], steps.data() + 6 * k);
        const double cost = pose(tried_);
        if (cost < cost_) {
            turns_ = tried_;
            cost_ = cost;
            return true;
        }
        for (double &step : steps) step *= SHORTER;
    }
    return false;
}

std::size_t Attempt::descend(std::size_t rounds, double tolerance, double worth) {
    double share = 1e-3, growth = 2.0;
    bool curved = least_cost_ > 0.0;
    int slow = 0;
    std::vector<double> steps;
    for (std::size_t round = 0; round < rounds; ++round) {
        if (reached(tolerance)) return round;
        differentiate();
        choose_directions();
        const double most = largest_square(), before = cost_;
        if (!(most > 0.0)) return round;
        // Where second derivatives lead uphill, steps are damped until they do not: those of the
        // first alone would throw a chain whose target is out of reach into a heap.
        const bool second = curved && columns_.size() <= MOST_CURVED;
        for (;; share *= growth) {
            if (share > MOST_DAMPING) {
                cost_ = pose(turns_);
                return round;
            }
            if (!step_for(share * most, second, steps)) {
                growth = MORE_CURVED;
                continue;
            }
            if (take(steps)) break;
            growth *= 2.0;
        }
        share = std::max(0.2 * share, LEAST_DAMPING);
        growth = 2.0;
        const double gained = before - cost_;
        if (gained <= STILL * cost_) return round + 1;
        if (cost_ - PACE * gained > worth) return round + 1;
        slow = gained < SLOW * before ? slow + 1 : 0;
        curved = curved || slow == SLOW_ROUNDS;
    }
    return rounds;
}

}  // namespace motorcade::animation::ik
