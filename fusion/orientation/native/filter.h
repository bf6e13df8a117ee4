// Orientation from a gyroscope and an accelerometer: a rotor propagated by every sample, corrected
// once an interval by an error-state Kalman filter. Specific force is averaged over the interval in
// the axes of the world, where gravity stands still while the sensor turns (so do Laidig and Seel,
// "VQF: Highly accurate IMU orientation estimation with bias estimation and magnetic disturbance
// rejection", Information Fusion 91, 2023).
//
// The errors are eleven: a turn of the world's axes (rad), gyro bias (rad/s), horizontal velocity
// (m/s), scale of the gyro. Gravity is told from acceleration by the velocity, which stays bounded:
// an Ornstein-Uhlenbeck process v' = -v / T + w. Its step over an interval, which the accelerometer
// gives but for the tilt, must come from -v / T and w; how large w is, the readings tell (speed.h).
// At rest velocity is 0 and the rate is bias.

#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "speed.h"
#include "vectors.h"
#include "versors.h"

namespace motorcade::orientation {

enum : std::size_t { TURN = 0, BIAS = 3, VELOCITY = 6, SCALE = 8, ERRORS = 11 };
using State = std::array<double, ERRORS>;
using Square = std::array<State, ERRORS>;
using Rows = std::array<Three, 3>;

struct Settings {
    double gyro_density, gyro_walk, accel_density;  // rad/s/√Hz, rad/s²/√Hz, m/s²/√Hz
    double gyro_scale, gyro_wander;  // deviation of the scale; error per turned √(rad rad/s)
    double first_bias, first_tilt;   // deviations, rad/s and rad
    double speed, speed_time;        // least deviation (m/s) and T (s) of the velocity
    double gravity, interval;        // m/s²; s from correction to correction
    double rest_rate, rest_force, rest_after;  // rad/s, m/s², s
    bool averaged;                             // readings are means over the interval before them
};

// Samples farther apart leave a gap: nothing tells how the sensor moved within it.
inline constexpr double GAP_S = 0.25;
// Rate that is taken for possible within a gap, besides the one before it.
inline constexpr double GAP_RATE = 0.5;
// The deviation of velocity at rest: a hand trembles, a table shakes.
inline constexpr double REST_SPEED = 0.01;
// Time over which rest compares readings with their average.
inline constexpr double REST_AVERAGE_S = 0.5;
// A mean rate in rest beyond this many deviations of the bias, of its own scatter and of what may
// still turn at rest (0.1°/s) is a slow turn; a single rate may lie somewhat farther out by chance.
inline constexpr double REST_GATE = 4.0, REST_GATE_ONCE = 6.0, REST_RATE = 1.75e-3;

// Which error a measurement reads. Two of acceleration while moving; at rest two of velocity, three
// of bias.
enum class Kind : std::uint8_t { acceleration, velocity, bias };

struct Measured {
    Kind kind;
    std::uint8_t axis;
    double innovation, variance;
    State gain;
};

// One interval and its correction, as the pass backwards wants them.
struct Node {
    std::size_t end = 0;  // the sample after which it corrects
    bool gap = false;     // the interval began with a gap
    double before = 0.0;  // seconds of the interval before
    double lasted = 0.0;
    Rows turned{}, wound{};
    std::size_t count = 0;
    std::array<Measured, 5> measured{};
    State added{};
    std::array<double, ERRORS *(ERRORS + 1) / 2>
        covariance{};  // lower triangle, after the correction
};

class Filter {
public:
    explicit Filter(const Settings &settings)
        : set_(settings), speed_(settings.speed, settings.speed_time, settings.gravity) {
        for (std::size_t i = 0; i < 2; ++i)
            covariance_[TURN + i][TURN + i] = square(set_.first_tilt);
        for (std::size_t i = 0; i < 2; ++i)
            covariance_[VELOCITY + i][VELOCITY + i] = square(set_.speed);
        for (std::size_t i = 0; i < 3; ++i)
            covariance_[BIAS + i][BIAS + i] = square(set_.first_bias);
        for (std::size_t i = 0; i < 3; ++i)
            covariance_[SCALE + i][SCALE + i] = square(set_.gyro_scale);
    }

    const Settings &settings() const { return set_; }
    const Four &rotor() const { return rotor_; }
    const Three &bias() const { return bias_; }
    bool at_rest() const { return still_ >= set_.rest_after; }
    double tilt_deviation() const { return std::sqrt(covariance_[0][0] + covariance_[1][1]); }

    // The first sample: stands upright what it feels.
    void begin(const Three &rate, const Three &force) {
        rotor_ = upright(force);
        last_rate_ = rate;
        last_force_ = force;
    }

    // Whether there is anything to correct by.
    bool gathered() const { return elapsed_ > 0.0; }

    // Whether a sample dt after the last must find the interval closed.
    bool leaves_gap(double dt) const { return dt > GAP_S && gathered(); }

    // Propagates the rotor over dt, with the mean of the readings at both ends or, where they are
    // means themselves, with the last; true where the interval is full and wants correction.
    bool propagate(const Three &rate, const Three &force, double dt) {
        const double past = set_.averaged ? 0.0 : 0.5;
        Three half, felt, net;
        for (std::size_t i = 0; i < 3; ++i) {
            net[i] = (rate[i] + past * (last_rate_[i] - rate[i]) - bias_[i]) * (1.0 - scale_[i]);
            felt[i] = force[i] + past * (last_force_[i] - force[i]);
            half[i] = -0.25 * dt * net[i];
        }
        const Four step = versors::exp(half), halfway = versors::compose(rotor_, step);
        const Rows rows = matrix(halfway);
        rotor_ = versors::renormalize(versors::compose(halfway, step));
        const double pace = dot(net, net);
        if (dt > GAP_S) {
            gap_ = true;
            lost_ += square(dt) * (pace + square(GAP_RATE));
        }
        for (std::size_t i = 0; i < 3; ++i) {
            for (std::size_t j = 0; j < 3; ++j) {
                turned_[i][j] += dt * rows[i][j];
                wound_[i][j] += dt * rows[i][j] * net[j];
            }
            if (dt > GAP_S) continue;
            impulse_[i] += dt * dot(rows[i], felt);
            swept_[i] += dt * (net[i] + bias_[i]);
            pushed_[i] += dt * felt[i];
        }
        if (dt <= GAP_S) {
            wandered_ += dt * pace;
            elapsed_ += dt;
        }
        last_rate_ = rate;
        last_force_ = force;
        return elapsed_ >= set_.interval;
    }

    // Corrects by what the interval gathered, and begins the next. Nothing gathered, nothing done.
    void correct(Node *node) {
        if (!gathered()) return;
        if (node) {
            node->gap = gap_;
            node->before = before_;
            node->lasted = elapsed_;
            node->turned = turned_;
            node->wound = wound_;
        }
        watch_rest();
        predict();
        speed_.watch(impulse_, elapsed_, gap_, covariance_[0][0] + covariance_[1][1]);
        State added{};
        at_rest() ? measure_rest(added, node) : measure_motion(added, node);
        if (node) {
            node->added = added;
            std::size_t at = 0;
            for (std::size_t i = 0; i < ERRORS; ++i)
                for (std::size_t j = 0; j <= i; ++j) node->covariance[at++] = covariance_[i][j];
        }
        apply(added);
        restart();
    }

    // H of a measurement, by its kind.
    static State slope(Kind kind, std::size_t axis, double lasted, const Settings &set) {
        State made{};
        if (kind == Kind::bias) {
            made[BIAS + axis] = 1.0;
        } else if (kind == Kind::velocity) {
            made[VELOCITY + axis] = 1.0;
        } else {
            // A turn t of the axes tilts gravity by t × g: (t_y, -t_x) g.
            made[TURN + 1 - axis] = (axis == 0 ? 1.0 : -1.0) * set.gravity * lasted;
            made[VELOCITY + axis] = -std::expm1(-lasted / set.speed_time);
        }
        return made;
    }

    // The rotor of a small rotation vector of the world's axes.
    static Four turn_of(const State &error) {
        return versors::exp(Three{-0.5 * error[0], -0.5 * error[1], -0.5 * error[2]});
    }

private:
    // The shortest turn that stands a force upright; any half turn where it points straight down.
    static Four upright(const Three &force) {
        const double size = std::sqrt(dot(force, force));
        if (!(size > 0.0)) return {1.0, 0.0, 0.0, 0.0};
        const double w = std::sqrt(std::max(0.0, 0.5 * (1.0 + force[2] / size)));
        if (w < 1e-8) return {0.0, 1.0, 0.0, 0.0};
        return {w, -0.5 * force[1] / (size * w), 0.5 * force[0] / (size * w), 0.0};
    }

    static Rows matrix(const Four &rotor) {
        const auto m = versors::adjoint(rotor);
        return {{{m[0], m[1], m[2]}, {m[3], m[4], m[5]}, {m[6], m[7], m[8]}}};
    }

    // Rest: readings keep to their average, and its rate is one that the bias may have.
    void watch_rest() {
        const double blend = watched_ && !gap_ ? -std::expm1(-elapsed_ / REST_AVERAGE_S) : 1.0;
        watched_ = true;
        double rates = 0.0, forces = 0.0, beyond = 0.0;
        for (std::size_t i = 0; i < 3; ++i) {
            const double rate = swept_[i] / elapsed_, force = pushed_[i] / elapsed_;
            mean_rate_[i] += blend * (rate - mean_rate_[i]);
            mean_force_[i] += blend * (force - mean_force_[i]);
            rates += square(rate - mean_rate_[i]);
            forces += square(force - mean_force_[i]);
            const double known = covariance_[BIAS + i][BIAS + i] + square(REST_RATE);
            beyond = std::max(beyond, square((rate - bias_[i]) * REST_GATE / REST_GATE_ONCE) /
                                          (known + scatter_[i]));
            // By differences of neighbours, in which a turn that begins counts once.
            scatter_[i] =
                blend == 1.0
                    ? 0.0
                    : scatter_[i] + blend * (0.5 * square(rate - before_rate_[i]) - scatter_[i]);
            before_rate_[i] = rate;
            beyond = std::max(beyond, square(mean_rate_[i] - bias_[i]) / (known + scatter_[i]));
        }
        const bool quiet = !gap_ && rates < square(set_.rest_rate) &&
                           forces < square(set_.rest_force) && beyond < square(REST_GATE);
        still_ = quiet ? still_ + elapsed_ : 0.0;
    }

    // Covariance over the interval: velocity by the tilt before it, then the turn by bias and
    // scale.
    void predict() {
        Square &p = covariance_;
        const double lean = set_.gravity * before_;
        for (std::size_t j = 0; j < ERRORS; ++j) {
            p[VELOCITY][j] = gap_ ? 0.0 : p[VELOCITY][j] + lean * p[1][j];
            p[VELOCITY + 1][j] = gap_ ? 0.0 : p[VELOCITY + 1][j] - lean * p[0][j];
        }
        for (State &row : p) {
            row[VELOCITY] = gap_ ? 0.0 : row[VELOCITY] + lean * row[1];
            row[VELOCITY + 1] = gap_ ? 0.0 : row[VELOCITY + 1] - lean * row[0];
        }
        for (std::size_t j = 0; j < ERRORS; ++j) {
            for (std::size_t i = 0; i < 3; ++i) {
                const Three &t = turned_[i], &w = wound_[i];
                p[i][j] -= t[0] * p[BIAS][j] + t[1] * p[BIAS + 1][j] + t[2] * p[BIAS + 2][j] +
                           w[0] * p[SCALE][j] + w[1] * p[SCALE + 1][j] + w[2] * p[SCALE + 2][j];
            }
        }
        for (State &row : p) {
            for (std::size_t i = 0; i < 3; ++i) {
                const Three &t = turned_[i], &w = wound_[i];
                row[i] -= t[0] * row[BIAS] + t[1] * row[BIAS + 1] + t[2] * row[BIAS + 2] +
                          w[0] * row[SCALE] + w[1] * row[SCALE + 1] + w[2] * row[SCALE + 2];
            }
        }
        const double turn =
            square(set_.gyro_density) * elapsed_ + square(set_.gyro_wander) * wandered_ + lost_;
        for (std::size_t i = 0; i < 3; ++i) {
            p[TURN + i][TURN + i] += turn;
            p[BIAS + i][BIAS + i] += square(set_.gyro_walk) * elapsed_;
        }
        const double velocity = gap_ ? speed_.variance() : square(set_.accel_density) * elapsed_;
        for (std::size_t i = 0; i < 2; ++i) p[VELOCITY + i][VELOCITY + i] += velocity;
        if (gap_) velocity_ = {};
    }

    void measure_motion(State &added, Node *node) {
        const double kept = std::exp(-elapsed_ / set_.speed_time);
        const double noise =
            square(set_.accel_density) * elapsed_ + speed_.variance() * (1.0 - kept * kept);
        for (std::uint8_t axis = 0; axis < 2; ++axis)
            measure(Kind::acceleration, axis, -((1.0 - kept) * velocity_[axis] + impulse_[axis]),
                    noise, added, node);
    }

    void measure_rest(State &added, Node *node) {
        for (std::uint8_t axis = 0; axis < 2; ++axis)
            measure(Kind::velocity, axis, -velocity_[axis], square(REST_SPEED), added, node);
        const double noise = square(set_.gyro_density) / elapsed_ + square(REST_RATE);
        for (std::uint8_t axis = 0; axis < 3; ++axis)
            measure(Kind::bias, axis, swept_[axis] / elapsed_ - bias_[axis], noise + scatter_[axis],
                    added, node);
    }

    // One number at a time: residual = slope · error + noise; earlier ones of the instant count.
    void measure(Kind kind, std::uint8_t axis, double residual, double noise, State &added,
                 Node *node) {
        const State h = slope(kind, axis, elapsed_, set_);
        State spread{};
        double variance = noise, innovation = residual;
        for (std::size_t j = 0; j < ERRORS; ++j) {
            if (h[j] == 0.0) continue;
            for (std::size_t i = 0; i < ERRORS; ++i) spread[i] += covariance_[j][i] * h[j];
            innovation -= h[j] * added[j];
        }
        for (std::size_t j = 0; j < ERRORS; ++j) variance += h[j] * spread[j];
        State gain;
        for (std::size_t i = 0; i < ERRORS; ++i) gain[i] = spread[i] / variance;
        for (std::size_t i = 0; i < ERRORS; ++i) {
            added[i] += gain[i] * innovation;
            for (std::size_t j = 0; j <= i; ++j)
                covariance_[i][j] = covariance_[j][i] = covariance_[i][j] - gain[i] * spread[j];
        }
        if (node) node->measured[node->count++] = {kind, axis, innovation, variance, gain};
    }

    // Moves the estimate by the errors found, and velocity on by what the accelerometer then says.
    void apply(const State &added) {
        rotor_ = versors::renormalize(versors::compose(turn_of(added), rotor_));
        for (std::size_t i = 0; i < 3; ++i) {
            bias_[i] += added[BIAS + i];
            scale_[i] += added[SCALE + i];
        }
        const double lean = set_.gravity * elapsed_;
        velocity_[0] += added[VELOCITY] + impulse_[0] + lean * added[1];
        velocity_[1] += added[VELOCITY + 1] + impulse_[1] - lean * added[0];
    }

    void restart() {
        before_ = elapsed_;
        impulse_ = swept_ = pushed_ = {};
        turned_ = wound_ = {};
        elapsed_ = wandered_ = lost_ = 0.0;
        gap_ = false;
    }

    Settings set_;
    Speed speed_;
    Four rotor_{1.0, 0.0, 0.0, 0.0};
    Three bias_{}, scale_{};
    std::array<double, 2> velocity_{};
    Square covariance_{};
    // gathered since the last correction
    Three last_rate_{}, last_force_{}, impulse_{}, swept_{}, pushed_{};
    Rows turned_{}, wound_{};
    double elapsed_ = 0.0, wandered_ = 0.0, lost_ = 0.0, before_ = 0.0;
    bool gap_ = false;
    // rest
    bool watched_ = false;
    Three mean_rate_{}, mean_force_{}, scatter_{}, before_rate_{};
    double still_ = 0.0;
};

}  // namespace motorcade::orientation
