// One pose on its way to goals: where its joints are, what is left, and steps that leave less.
#pragma once

#include <vector>

#include "ik.h"

namespace motorcade::animation::ik {

// What a motor's matrix does to a vector, and to the origin.
inline Vector turned(const std::array<double, 12> &m, const Vector &v) {
    return {m[0] * v[0] + m[1] * v[1] + m[2] * v[2], m[4] * v[0] + m[5] * v[1] + m[6] * v[2],
            m[8] * v[0] + m[9] * v[1] + m[10] * v[2]};
}
inline Vector position(const std::array<double, 12> &m) { return {m[3], m[7], m[11]}; }

class Attempt {
public:
    Attempt(const Solver &solver, const double *local, const std::vector<Goal> &goals,
            const std::vector<Target> &targets);

    // Steps until nothing is left, nothing gets less, or so many rounds are over; returns those.
    // Ends also where a cost of `worth` will not be reached at the pace of the last step.
    std::size_t descend(std::size_t rounds, double tolerance, double worth);
    // Whether second derivatives tell that no pose around costs less; false where they are unknown.
    bool settled();
    void place(std::vector<Turn> turns);
    void report(Solved &solved);
    void write(double *out) const;
    bool reached(double tolerance) const;

    double cost() const { return cost_; }
    // Whether bones are too short for some goal.
    bool out_of_reach() const { return least_cost_ > 0.0; }
    // Whether a pose could be worth a search that leaves a share of the cost at most.
    bool could_leave(double share) const;
    const std::vector<Turn> &turns() const { return turns_; }
    // The given pose, brought within the limits.
    const std::vector<Turn> &start() const { return start_; }

private:
    // A direction in which one joint may be moved.
    struct Column {
        std::size_t joint;
        double along[6];
        Vector axis;  // in character space, of turns or shifts
        bool shifts;
    };

    void find_path();
    void find_least_cost();
    double pose(const std::vector<Turn> &turns);
    Vector residual(std::size_t goal) const;
    void differentiate();
    void add_columns(std::size_t joint);
    void differentiate_goal(std::size_t goal, const Vector &axis, const Vector &at, bool shifts,
                            double *column) const;
    void choose_directions();
    bool take(std::vector<double> &steps);
    bool step_for(double damping, bool curved, std::vector<double> &steps);
    void add_curvature();
    void add_curvature_of_ball(std::size_t first, std::size_t end);
    void changing_gradients(std::size_t joint, double (*changes)[3]) const;
    Vector torque(std::size_t joint) const;
    double largest_square() const;

    const Solver &solver_;
    const std::vector<Goal> &goals_;
    const std::vector<Target> &targets_;
    std::vector<Motor> local_;       // of all the skeleton's joints
    std::vector<std::size_t> path_;  // joints above goals, parents first
    std::vector<std::size_t> used_;  // of the joints that turn, those above goals
    std::vector<char> above_;        // (goals, joints that turn)
    std::vector<Vector> shifts_;     // of the local poses
    std::vector<Turn> start_, turns_;
    std::vector<Motor> world_;
    std::vector<std::array<double, 12>> matrices_;
    std::vector<double> left_;         // weighted residuals, three numbers a goal
    std::vector<double> all_columns_;  // (6 joints, 3 goals): the derivative by each coordinate
    std::vector<double> gradient_;     // by each coordinate
    std::vector<Vector> axes_;         // of each coordinate, in character space
    std::vector<double> presses_;      // (joints, 2)
    std::vector<Column> columns_;
    std::vector<double> jacobian_;  // (columns, 3 goals)
    std::vector<double> square_, solution_, column_;
    std::vector<Vector> arms_;  // of a goal by columns: speed, pull across, speed of turns alone
    std::vector<Turn> tried_;
    double cost_ = 0.0;
    double least_cost_ = 0.0;  // for which bones are too short, whatever the limits
    bool all_out_ = true;      // of reach: every goal, for want of bones
};

}  // namespace motorcade::animation::ik
