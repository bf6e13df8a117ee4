// Inverse kinematics of a tree of joints: damped least squares within the joints' limits.
//
// Goals are residuals of three numbers each: where a point of a joint is, how a joint is turned, or
// where an axis of it points. Steps are those of Levenberg and Marquardt, in the coordinates of
// joint_limits.h without the directions that press on a limit; a step is brought back within the
// limits before it is judged, whole or in part (projected Levenberg-Marquardt; Kanzow, Yamashita
// and Fukushima 2004).
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "joint_limits.h"

namespace motorcade::animation::ik {

enum class Aim : int { position, orientation, direction };

// What is wanted of a joint, apart from the target.
struct Goal {
    Aim aim;
    std::size_t joint;  // in the skeleton
    Vector point;       // in the joint's frame: what shall be at the target, or looks at it
    Vector axis;        // in the joint's frame: what shall point at the target
    double weight;
};

// Targets of a goal: a point in character space, or a rotor.
struct Target {
    Vector point{};
    Rotor rotor{1.0, 0.0, 0.0, 0.0};
};

struct Options {
    double tolerance;      // of residuals: a share of the size, or radians
    std::size_t restarts;  // how many other poses are tried where goals stay unreached
};

// One solved pose.
struct Solved {
    std::vector<Turn> turns;        // of the joints that may turn
    std::vector<Vector> residuals;  // of the goals: metres or radians, target to joint
    std::vector<double> presses;    // (goals, joints, 2): how hard each goal presses on limits
    std::size_t rounds = 0;
    bool reached = false;
};

// A skeleton's joints that may turn. Const to its users: one may serve several threads.
class Solver {
public:
    // `rest` has eight numbers a joint; `joints` are in the skeleton's order.
    Solver(const std::int64_t *parents, const double *rest, std::size_t count,
           std::vector<Joint> joints);

    std::size_t skeleton_size() const { return parents_.size(); }
    const std::vector<Joint> &joints() const { return joints_; }
    // The length, in metres, that counts as much as one radian.
    double size_m() const { return size_m_; }
    // Whether a joint that may turn is another one, or leads to it.
    bool is_above(std::size_t high, std::size_t low) const {
        return above_[high * joints_.size() + low] != 0;
    }

    // Solves from a local pose, eight numbers a joint, and writes the local pose found.
    Solved solve(const double *local, const std::vector<Goal> &goals,
                 const std::vector<Target> &targets, const Options &options, double *out) const;

private:
    friend class Attempt;
    std::vector<std::ptrdiff_t> parents_;
    std::vector<Rotor> rest_rotors_;
    std::vector<Joint> joints_;
    std::vector<std::ptrdiff_t> joint_of_;  // of each of the skeleton's, or -1
    std::vector<char> above_;               // (joints, joints): itself, or above it
    double size_m_;
};

}  // namespace motorcade::animation::ik
