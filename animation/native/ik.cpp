// Steps and restarts of inverse kinematics; see ik.h. Poses and residuals stand in attempt.cpp.

#include "ik.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "attempt.h"

namespace motorcade::animation::ik {
namespace {

constexpr std::size_t ROUNDS = 200, ROUNDS_OF_RESTART = 60;
// A restart is taken where it leaves this share of the cost at most.
constexpr double BETTER = 0.99;
constexpr double ANY = std::numeric_limits<double>::infinity();
// Costs that differ by less than this share are alike.
constexpr int AGREED = 1;
constexpr double ALIKE = 1e-6;
// How far a pose is moved off a saddle, in radians or lengths of the size.
constexpr double NUDGE = 1e-2;

// Evenly spread numbers from -1 to 1, the same on every machine (splitmix64).
class Spread {
public:
    double next() {
        std::uint64_t z = state_ += UINT64_C(0x9E3779B97F4A7C15);
        z = (z ^ (z >> 30)) * UINT64_C(0xBF58476D1CE4E5B9);
        z = (z ^ (z >> 27)) * UINT64_C(0x94D049BB133111EB);
        return static_cast<double>(static_cast<std::int64_t>(z ^ (z >> 31))) * 0x1p-63;
    }

private:
    std::uint64_t state_ = 20110000;
};

// All joints moved a little.
std::vector<Turn> nudged(const std::vector<Joint> &joints, const std::vector<Turn> &turns,
                         Spread &spread) {
    std::vector<Turn> made;
    for (std::size_t k = 0; k < joints.size(); ++k) {
        double step[6];
        for (double &x : step) x = NUDGE * spread.next();
        made.push_back(stepped(joints[k], turns[k], step));
    }
    return made;
}

// Joints anywhere within their limits; those without limits within half a turn of where they are.
std::vector<Turn> scattered(const std::vector<Joint> &joints, const std::vector<Turn> &turns,
                            Spread &spread) {
    std::vector<Turn> made;
    for (std::size_t k = 0; k < joints.size(); ++k) {
        double step[6];
        for (double &x : step) x = spread.next();
        made.push_back(scattered(joints[k], turns[k], step));
    }
    return made;
}

}  // namespace

Solver::Solver(const std::int64_t *parents, const double *rest, std::size_t count,
               std::vector<Joint> joints)
    : parents_(parents, parents + count), rest_rotors_(count), joints_(std::move(joints)),
      joint_of_(count, -1), size_m_(0.0) {
    std::vector<double> away(count, 0.0);
    for (std::size_t j = 0; j < count; ++j) {
        Motor local;
        std::copy_n(rest + 8 * j, 8, local.begin());
        std::copy_n(rest + 8 * j, 4, rest_rotors_[j].begin());
        const Vector bone = versors::translation(local);
        if (parents_[j] >= 0)
            away[j] = away[static_cast<std::size_t>(parents_[j])] + std::sqrt(dot(bone, bone));
        size_m_ = std::max(size_m_, away[j]);
    }
    if (!(size_m_ > 0.0)) size_m_ = 1.0;
    for (std::size_t k = 0; k < joints_.size(); ++k)
        joint_of_[joints_[k].number] = static_cast<std::ptrdiff_t>(k);
    above_.assign(joints_.size() * joints_.size(), 0);
    for (std::size_t k = 0; k < joints_.size(); ++k)
        for (auto j = static_cast<std::ptrdiff_t>(joints_[k].number); j >= 0;
             j = parents_[static_cast<std::size_t>(j)])
            if (const std::ptrdiff_t high = joint_of_[static_cast<std::size_t>(j)]; high >= 0)
                above_[static_cast<std::size_t>(high) * joints_.size() + k] = 1;
}

Solved Solver::solve(const double *local, const std::vector<Goal> &goals,
                     const std::vector<Target> &targets, const Options &options,
                     double *out) const {
    Attempt attempt(*this, local, goals, targets);
    std::size_t rounds = attempt.descend(ROUNDS, options.tolerance, ANY);
    std::vector<Turn> best = attempt.turns();
    double cost = attempt.cost();
    Spread spread;
    int agreed = 0;
    // Out of reach every search would go on to the end: one that promises nothing is given up, and
    // what it came to is told less exactly.
    const bool far = attempt.out_of_reach();
    const double alike = far ? 1.0 - BETTER : ALIKE;
    // A pose in which nothing pulls sideways, like a straight chain whose target is in line, is
    // left by a nudge. Where the pose was the nearest after all, it comes back and is kept.
    const std::vector<Turn> start = attempt.start();
    for (std::size_t k = 0; k <= options.restarts; ++k) {
        if (attempt.reached(options.tolerance) || !attempt.could_leave(BETTER)) break;
        if (k == 0 && attempt.settled()) continue;
        attempt.place(k == 0 ? nudged(joints_, best, spread) : scattered(joints_, start, spread));
        rounds += attempt.descend(ROUNDS_OF_RESTART, options.tolerance, far ? BETTER * cost : ANY);
        const double found = attempt.cost();
        // Poses apart that come to the same are no hint at a better one.
        agreed += k > 0 && std::abs(found - cost) <= alike * cost;
        if (found < BETTER * cost) {
            best = attempt.turns();
            cost = attempt.cost();
        } else {
            attempt.place(best);
        }
        if (agreed == AGREED) break;
    }
    attempt.place(best);
    Solved solved{best, {}, {}, rounds, attempt.reached(options.tolerance)};
    attempt.report(solved);
    attempt.write(out);
    return solved;
}

}  // namespace motorcade::animation::ik
