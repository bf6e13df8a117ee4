// What can happen at a moment: measurements of five kinds, and moments at which the path is asked
// for.

#pragma once

#include <memory>
#include <vector>

#include "state.h"

namespace motorcade::filter {

enum class Kind : int { check = 0, camera_pose, imu_pose, position, velocity, corners, output };

constexpr std::size_t pose_numbers = 8 + 36, position_numbers = 3 + 3 + 9, velocity_numbers = 3 + 9;
constexpr std::size_t corner_numbers =
    3 + 2 + 3;  // world point, x/z and y/z, xx xy yy of their covariance
constexpr double nearest_depth_m = 1e-3;

// What was known after a moment, its covariance packed.
struct Known {
    State after;
    std::vector<double> covariance;
};

// Where a prediction was given up: variances added then (turn, position, velocity, both biases),
// and where a start was wrong the twist to what was measured next.
struct Doubt {
    double added[5] = {};
    double restart[6] = {};
};

struct Event {
    std::int64_t time_ns = 0;   // on the IMU's clock, as far as that was known
    std::int64_t stamp_ns = 0;  // as given
    Kind kind = Kind::check;
    bool judged = false;
    std::size_t number = 0;  // of the measurement, or of the output
    double shift_s = 0.0;    // what was added to the stamp
    std::vector<double> data;

    // What became of it. Long recordings have many: what can be made again is kept of few.
    double nis = 0.0, factor = 0.0;            // a factor of 0: left out
    double live_nis = 0.0, live_factor = 0.0;  // as judged first, before anything later was known
    std::unique_ptr<Doubt> doubt;
    std::unique_ptr<Known> known;
    // Of one left out its residual (m); for a backward pass residual, effect (m, N), gain (m, N)
    // and inverse (m, m).
    std::size_t size = 0;
    std::vector<double> linear;

    bool measures() const { return kind != Kind::check && kind != Kind::output; }
    // At one moment: what is measured before what is asked for.
    bool before(const Event &other) const {
        return time_ns != other.time_ns ? time_ns < other.time_ns : rank() < other.rank();
    }

private:
    int rank() const { return kind == Kind::output ? 2 : kind == Kind::check ? 1 : 0; }
};

// The innovation of a measurement; false where it cannot be predicted (a corner behind the camera).
template <std::size_t N> class Prediction {
public:
    Prediction(const State &state, const Reading &read) : state_(state) {
        // How the pose and the velocity go on from here, in the IMU's axes.
        for (int i = 0; i < 3; ++i) going_[i] = read.rate[i] - state.bias[i];
        double effect[9];
        motorcade_velocity_effect(state.pose, effect);
        for (int i = 0; i < 3; ++i) {
            going_[3 + i] = 0.0;
            for (int k = 0; k < 3; ++k) going_[3 + i] += effect[3 * k + i] * state.velocity[k];
        }
    }

    bool of(const Event &event, Innovation<N> &made) const {
        const double *data = event.data.data();
        switch (event.kind) {
        case Kind::camera_pose:
            pose(event, data, made);
            return true;
        case Kind::imu_pose:
            pose(event, data, made);
            return true;
        case Kind::position:
            at_arm(data, made);
            return true;
        case Kind::velocity:
            moving(data, made);
            return true;
        case Kind::corners:
            return corners(event, data, made);
        default:
            return false;
        }
    }

private:
    // The pose at the camera's stamp, by the time offset known now.
    void at_stamp(const Event &event, double *pose) const {
        std::copy_n(state_.pose, 8, pose);
        if (N == 15 || state_.delay_s == event.shift_s) return;
        double ahead[6];
        for (int i = 0; i < 6; ++i) ahead[i] = (state_.delay_s - event.shift_s) * going_[i];
        motorcade_retract(state_.pose, ahead, pose);
    }

    void delayed(Innovation<N> &made, std::size_t row) const {
        if constexpr (N > 15)
            for (int k = 0; k < 6; ++k) made.effect[row][delay] += made.effect[row][k] * going_[k];
    }

    void pose(const Event &event, const double *data, Innovation<N> &made) const {
        static constexpr double one[8] = {1.0};
        const bool camera = event.kind == Kind::camera_pose;
        const double *imu_T_camera = camera ? state_.imu_T_camera : one;
        double predicted[8], effect[36];
        if (camera)
            at_stamp(event, predicted);
        else
            std::copy_n(state_.pose, 8, predicted);
        made.size = 6;
        motorcade_pose_residual(predicted, imu_T_camera, data, made.residual);
        motorcade_pose_effect(imu_T_camera, effect);
        for (std::size_t a = 0; a < 6; ++a) {
            std::copy_n(effect + 6 * a, 6, made.effect[a]);
            std::copy_n(data + 8 + 6 * a, 6, made.noise[a]);
            if constexpr (N > 15)
                if (camera) made.effect[a][extrinsics + a] = 1.0;
            if (camera) delayed(made, a);
        }
    }

    void at_arm(const double *data, Innovation<N> &made) const {
        double at[3], effect[18];
        motorcade_point(state_.pose, data + 3, at, effect);
        made.size = 3;
        for (std::size_t a = 0; a < 3; ++a) {
            made.residual[a] = data[a] - at[a];
            std::copy_n(effect + 6 * a, 6, made.effect[a]);
            std::copy_n(data + 6 + 3 * a, 3, made.noise[a]);
        }
    }

    void moving(const double *data, Innovation<N> &made) const {
        double effect[9];
        motorcade_velocity_effect(state_.pose, effect);
        made.size = 3;
        for (std::size_t a = 0; a < 3; ++a) {
            made.residual[a] = data[a] - state_.velocity[a];
            std::copy_n(effect + 3 * a, 3, made.effect[a] + velocity);
            std::copy_n(data + 3 + 3 * a, 3, made.noise[a]);
        }
    }

    bool corners(const Event &event, const double *data, Innovation<N> &made) const {
        double pose[8], seen[2], depth[1], by_pose[12], by_extrinsics[12];
        at_stamp(event, pose);
        const std::size_t count = event.data.size() / corner_numbers;
        made.size = 2 * count;
        for (std::size_t c = 0; c < count; ++c) {
            const double *corner = data + c * corner_numbers;
            motorcade_corner(pose, state_.imu_T_camera, corner, seen, depth, by_pose,
                             by_extrinsics);
            if (!(depth[0] > nearest_depth_m)) return false;
            for (std::size_t a = 0; a < 2; ++a) {
                const std::size_t row = 2 * c + a;
                made.residual[row] = corner[3 + a] - seen[a];
                std::copy_n(by_pose + 6 * a, 6, made.effect[row]);
                if constexpr (N > 15)
                    std::copy_n(by_extrinsics + 6 * a, 6, made.effect[row] + extrinsics);
                for (std::size_t b = 0; b < 2; ++b) made.noise[row][2 * c + b] = corner[5 + a + b];
                delayed(made, row);
            }
        }
        return true;
    }

    const State &state_;
    double going_[6];
};

}  // namespace motorcade::filter
