// FABRIK: a chain of points brought to a target by passes up and down; steps by meets of a line and
// a sphere (the generated `reach`).
//
// Where limits or a stretched chain make the passes creep, the solver of ik.h goes on from there.
// Source: Aristidou and Lasenby, "FABRIK: a fast, iterative solver for the inverse kinematics
// problem" (2011), and "Inverse kinematics solutions using conformal geometric algebra" (2011).
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "joint_limits.h"

namespace motorcade::animation::ik {

// Chains of one number of points and one set of limits. Works in buffers of its own.
class Fabrik {
public:
    // `limits` has the largest angle of each bone to the one before it, of the first to the base's
    // direction; `tolerance` is a share of the chain's length.
    Fabrik(std::span<const double> limits, double tolerance);

    // Solves one chain in place, whose base stays. `direction` is a unit vector or none (zero).
    // Returns how far its end is from the target; adds to `rounds`. False: a chain of no length.
    bool solve(double *points, const Vector &target, const Vector &direction, double &error,
               std::size_t &rounds);

private:
    void stretch();
    void up();
    void down();
    Vector placed(const Vector &fixed, const Vector &moving, double bone, const Vector &before,
                  double limit) const;
    bool keep();
    void squares(const Vector &direction, std::size_t &rounds);

    std::vector<double> limits_, bones_;
    double tolerance_, total_ = 0.0, error_ = 0.0;
    Vector target_{}, direction_{};
    std::vector<Vector> points_, best_;
};

}  // namespace motorcade::animation::ik
