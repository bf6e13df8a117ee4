// The filter's state, and how inertial data and corrections move it: the generated model, called.

#pragma once

#include <algorithm>
#include <cstdint>

#include "covariance.h"
#include "generated/model.h"

namespace motorcade::filter {

struct State {
    double pose[8] = {1.0};           // world_T_imu
    double velocity[3] = {};          // in the world
    double bias[6] = {};              // gyroscope, accelerometer
    double gravity_rotor[4] = {1.0};  // turns -z of the world to where gravity points
    double imu_T_camera[8] = {1.0};   // imu_T_camera
    double delay_s = 0.0;             // a camera's stamp plus this is the IMU's time
    double earlier[8] = {1.0};        // world_T_imu at the moment kept last for what refers to it
};

struct Reading {
    double rate[3], force[3];
};

constexpr double largest_turn_rad = 3.0;  // of one step of the generated model
constexpr int most_parts = 32;            // of one interval: beyond, a bias has run away

template <std::size_t N> inline void correct(State &state, const double *error) {
    State next = state;
    motorcade_corrected(state.pose, state.velocity, error, next.pose, next.velocity);
    for (std::size_t i = 0; i < 6; ++i) next.bias[i] += error[gyro + i];
    if constexpr (N > 15) {
        const double leaning[6] = {error[tilt], error[tilt + 1], 0.0, 0.0, 0.0, 0.0};
        const double upright[8] = {state.gravity_rotor[0], state.gravity_rotor[1],
                                   state.gravity_rotor[2], state.gravity_rotor[3]};
        double turned[8];
        motorcade_retract(upright, leaning, turned);
        std::copy_n(turned, 4, next.gravity_rotor);
        motorcade_retract(state.imu_T_camera, error + extrinsics, next.imu_T_camera);
        next.delay_s += error[delay];
    }
    if constexpr (N > earlier) motorcade_retract(state.earlier, error + earlier, next.earlier);
    state = next;
}

// The state and the error's transition over one interval of constant readings; see motion.cpp. In
// `moved_held` the force keeps the axes that it had at the interval's start.
void moved(State &state, const Reading &read, double dt, const double *fall, Transition &made);
void moved_held(State &state, const Reading &read, double dt, const double *fall, Transition &made);

// Gravity, and over one interval of constant readings the state and the error's transition.
class Motion {
public:
    explicit Motion(double gravity_m_s2) : size_(gravity_m_s2) {}

    void gravity(const State &state, double *made) const {
        motorcade_gravity(state.gravity_rotor, size_, made);
    }

    // How many equal parts an interval must have for the generated model to hold.
    static int parts(const State &state, const Reading &read, double dt, int most = most_parts) {
        double square = 0.0;
        for (int i = 0; i < 3; ++i)
            square += (read.rate[i] - state.bias[i]) * (read.rate[i] - state.bias[i]);
        const double widest = largest_turn_rad / dt;
        if (square < widest * widest) return 1;
        const double parts = std::floor(std::sqrt(square) * dt / largest_turn_rad) + 1.0;
        return parts < most ? static_cast<int>(parts) : most;
    }

    // `held`: the force keeps the axes that it had at the interval's start.
    template <std::size_t N, bool held = false>
    void step(State &state, const Reading &read, double dt, const double *fall,
              Transition &made) const {
        if constexpr (held)
            moved_held(state, read, dt, fall, made);
        else
            moved(state, read, dt, fall, made);
        if constexpr (N > 15)
            motorcade_gravity_effect(state.pose, state.gravity_rotor, size_, dt,
                                     made.velocity_tilt);
    }

private:
    double size_;
};

}  // namespace motorcade::filter
