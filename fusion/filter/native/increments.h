// What inertial samples add up to over an interval, from the identity, at rest and without gravity:
// the filter's own step, transition and covariance, for those that look at intervals as a whole.

#pragma once

#include <climits>

#include "state.h"

namespace motorcade::filter {

struct Increment {
    State state;
    Matrix<15> transition, covariance;

    Increment() {
        for (std::size_t i = 0; i < 15; ++i) transition.row[i][i] = 1.0;
    }
};

// Adds the covariance of white noise that acts as a bias of this one step.
inline void add_white(Matrix<15> &p, const Transition &f, const Densities &noise) {
    double effect[9][6] = {};
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = 0; j < 3; ++j) {
            effect[turn + i][j] = f.turn_gyro[3 * i + j];
            effect[position + i][j] = f.position_gyro[3 * i + j];
            effect[velocity + i][j] = f.velocity_gyro[3 * i + j];
            effect[position + i][3 + j] = f.position_accel[3 * i + j];
            effect[velocity + i][3 + j] = f.velocity_accel[3 * i + j];
        }
    const double rate = noise.rate / f.dt, force = noise.force / f.dt;
    for (std::size_t i = 0; i < 9; ++i)
        for (std::size_t j = 0; j <= i; ++j) {
            double sum = 0.0;
            for (std::size_t k = 0; k < 3; ++k)
                sum += rate * effect[i][k] * effect[j][k] +
                       force * effect[i][3 + k] * effect[j][3 + k];
            p.row[i][j] += sum;
            if (j < i) p.row[j][i] += sum;
        }
}

// Goes on by a step of constant readings.
template <bool held>
inline void extend(Increment &sum, const Reading &read, const double *bias, double dt,
                   const Densities &noise) {
    const double fall[3] = {};
    const Densities walks{0.0, 0.0, noise.gyro_walk, noise.accel_walk};
    std::copy_n(bias, 6, sum.state.bias);
    const int parts = Motion::parts(sum.state, read, dt, INT_MAX);
    for (int part = 0; part < parts; ++part) {
        Transition f;
        Motion(0.0).step<15, held>(sum.state, read, dt / parts, fall, f);
        transform(sum.transition, f);
        propagate(sum.covariance, f, walks);
        add_white(sum.covariance, f, noise);
    }
}

// The covariance that white noise and bias walks, acting all the time, add in an interval.
inline void process_noise(const Densities &noise, double dt, double *made) {
    Matrix<15> p;
    Transition f{};
    f.dt = dt;
    propagate(p, f, noise);
    for (std::size_t i = 0; i < 15; ++i) std::copy_n(p.row[i], 15, made + 15 * i);
}

}  // namespace motorcade::filter
