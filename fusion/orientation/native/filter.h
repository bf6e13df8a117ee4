// Orientation from a gyroscope, an accelerometer and, where there is one, a magnetometer: a rotor
// propagated by every sample, corrected once an interval by an error-state Kalman filter. Specific
// force is averaged over the interval in the axes of the world, where gravity stands still while
// the sensor turns (so do Laidig and Seel, "VQF: Highly accurate IMU orientation estimation with
// bias estimation and magnetic disturbance rejection", Information Fusion 91, 2023).
//
// The errors are seventeen: a turn of the world's axes (rad), gyro bias (rad/s), horizontal
// velocity (m/s), and the gyro's matrix of scale and cross-axis errors. Gravity is told from
// acceleration by the velocity, which stays bounded: an Ornstein-Uhlenbeck process v' = -v / T + w.
// Its step over an interval, which the accelerometer gives but for the tilt, must come from -v / T
// and w; how large w is, the readings tell (speed.h). At rest velocity is 0 and the rate is bias
// (rest.h). The direction of the magnetic field in the axes of the world is north (field.h).

#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "field.h"
#include "model.h"
#include "rest.h"
#include "speed.h"
#include "vectors.h"
#include "versors.h"

namespace motorcade::orientation {

// Samples farther apart leave a gap: nothing tells how the sensor moved within it.
inline constexpr double GAP_S = 0.25;
// Rate that is taken for possible within a gap, besides the one before it.
inline constexpr double GAP_RATE = 0.5;
// The deviation of velocity at rest: a hand trembles, a table shakes.
inline constexpr double REST_SPEED = 0.01;
// A sensor turns beyond this rate (20°/s): a field that then stays is not the sensor's own.
inline constexpr double TURNING_RATE = 0.35;

class Filter {
public:
    explicit Filter(const Settings &settings)
        : set_(settings), speed_(settings.speed, settings.speed_time, settings.gravity),
          rest_(settings.rest_rate, settings.rest_force, settings.rest_after),
          field_(settings.disturbance, settings.disturbance_time) {
        for (std::size_t i = 0; i < 2; ++i)
            covariance_[TURN + i][TURN + i] = square(set_.first_tilt);
        for (std::size_t i = 0; i < 2; ++i)
            covariance_[VELOCITY + i][VELOCITY + i] = square(set_.speed);
        for (std::size_t i = 0; i < 3; ++i)
            covariance_[BIAS + i][BIAS + i] = square(set_.first_bias);
        for (std::size_t i = 0; i < 9; ++i)
            covariance_[MATRIX + i][MATRIX + i] = square(set_.gyro_matrix);
    }

    const Four &rotor() const { return rotor_; }
    const Three &bias() const { return bias_; }
    const Field &field() const { return field_; }
    bool at_rest() const { return rest_.found(); }
    double tilt_deviation() const { return std::sqrt(covariance_[0][0] + covariance_[1][1]); }
    double heading_deviation() const { return std::sqrt(covariance_[2][2]); }

    // By how much the axes of the world must turn about the vertical for a field to point north.
    double north_of(const Three &magnetic) const {
        const Rows rows = matrix(rotor_);
        return std::atan2(dot(rows[0], magnetic), dot(rows[1], magnetic));
    }

    // Turns the axes of the world about the vertical, before anything was gathered in them.
    void face(double angle) {
        State turn{};
        turn[TURN + 2] = angle;
        rotor_ = versors::compose(turn_of(turn), rotor_);
    }

    // There will be a magnetometer: until it reads, north is unknown.
    void expect_field() {
        faces_ = Faces::unknown;
        covariance_[2][2] = square(HALF_TURN);
    }

    // Starts from the magnetic reference that another filter found.
    void take_reference(const Field &other) { field_.take_reference(other); }

    // The first sample: stands upright what it feels, and faces north by the field, if there is
    // one.
    void begin(const Three &rate, const Three &force, const Three *magnetic) {
        rotor_ = upright(force);
        if (magnetic) {
            face(north_of(*magnetic));
            expect_field();
        }
        last_rate_ = rate;
        last_force_ = force;
    }

    // Whether there is anything to correct by.
    bool gathered() const { return elapsed_ > 0.0; }

    // Whether a sample dt after the last must find the interval closed.
    bool leaves_gap(double dt) const { return dt > GAP_S && gathered(); }

    // Propagates the rotor over dt, with the mean of the readings at both ends or, where they are
    // means themselves, with the last; true where the interval is full and wants correction.
    bool propagate(const Three &rate, const Three &force, const Three *magnetic, double dt) {
        const double past = set_.averaged ? 0.0 : 0.5;
        Three half, felt, raw, net;
        for (std::size_t i = 0; i < 3; ++i) {
            raw[i] = rate[i] + past * (last_rate_[i] - rate[i]);
            felt[i] = force[i] + past * (last_force_[i] - force[i]);
        }
        const Three unbiased{raw[0] - bias_[0], raw[1] - bias_[1], raw[2] - bias_[2]};
        for (std::size_t i = 0; i < 3; ++i) {
            net[i] = unbiased[i];
            for (std::size_t j = 0; j < 3; ++j) net[i] -= matrix_[3 * i + j] * unbiased[j];
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
                for (std::size_t k = 0; k < 3; ++k)
                    wound_[i][3 * j + k] += dt * rows[i][j] * unbiased[k];
            }
            if (dt > GAP_S) continue;
            impulse_[i] += dt * dot(rows[i], felt);
            swept_[i] += dt * raw[i];
            pushed_[i] += dt * felt[i];
        }
        if (dt <= GAP_S) {
            if (magnetic) gather(rows, net, *magnetic, dt);
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
        if (!node && magnetic_s_ > 0.0 && faces_ == Faces::anywhere) turn_north();
        Three rate, force, variance;
        for (std::size_t i = 0; i < 3; ++i) {
            rate[i] = swept_[i] / elapsed_;
            force[i] = pushed_[i] / elapsed_;
            variance[i] = covariance_[BIAS + i][BIAS + i];
        }
        rest_.watch(rate, force, elapsed_, gap_, bias_, variance);
        predict();
        speed_.watch(impulse_, elapsed_, gap_, covariance_[0][0] + covariance_[1][1]);
        State added{};
        at_rest() ? measure_rest(added, node) : measure_motion(added, node);
        if (magnetic_s_ > 0.0) measure_heading(added, node);
        if (node) {
            node->added = added;
            std::size_t at = 0;
            for (std::size_t i = 0; i < ERRORS; ++i)
                for (std::size_t j = 0; j <= i; ++j) node->covariance[at++] = covariance_[i][j];
        }
        apply(added);
        restart();
    }

    // The rotor of a small rotation vector of the world's axes.
    static Four turn_of(const State &error) {
        return versors::exp(Three{-0.5 * error[0], -0.5 * error[1], -0.5 * error[2]});
    }

private:
    // Of the heading nothing is known as there is no magnetometer; is known to be unknown; all is.
    enum class Faces { anywhere, unknown, north };
    static constexpr double HALF_TURN = 3.141592653589793;

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

    // The first field comes late: turns all that stands in the axes of the world.
    void turn_north() {
        const double angle = std::atan2(felt_field_[0], felt_field_[1]);
        const double c = std::cos(angle), s = std::sin(angle);
        const auto turned = [c, s](auto &x, auto &y) {
            const auto before = x;
            x = c * x - s * y;
            y = s * before + c * y;
        };
        face(angle);
        expect_field();
        turned(velocity_[0], velocity_[1]);
        for (Three *vector : {&impulse_, &felt_field_, &per_lag_})
            turned((*vector)[0], (*vector)[1]);
        for (std::size_t j = 0; j < 3; ++j) turned(turned_[0][j], turned_[1][j]);
        for (std::size_t j = 0; j < 9; ++j) turned(wound_[0][j], wound_[1][j]);
        for (const std::size_t at : {TURN, VELOCITY}) {
            for (std::size_t j = 0; j < ERRORS; ++j)
                turned(covariance_[at][j], covariance_[at + 1][j]);
            for (State &row : covariance_) turned(row[at], row[at + 1]);
        }
    }

    // The field in the axes of the world, and what a lag of the magnetometer adds to it: ω × m.
    void gather(const Rows &rows, const Three &net, const Three &magnetic, double dt) {
        const Three turns{net[1] * magnetic[2] - net[2] * magnetic[1],
                          net[2] * magnetic[0] - net[0] * magnetic[2],
                          net[0] * magnetic[1] - net[1] * magnetic[0]};
        for (std::size_t i = 0; i < 3; ++i) {
            felt_field_[i] += dt * dot(rows[i], magnetic);
            per_lag_[i] += dt * dot(rows[i], turns);
        }
        magnetic_s_ += dt;
    }

    // Covariance over the interval: each row by the transition, and then each column.
    void predict() {
        Square &p = covariance_;
        for (int side = 0; side < 2; ++side) {
            for (State &row : p) propagate(row);
            transpose(p);
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

    // The transition of an error: velocity by the tilt before it, then the turn by bias and matrix.
    void propagate(State &error) const {
        const double lean = set_.gravity * before_;
        error[VELOCITY] = gap_ ? 0.0 : error[VELOCITY] + lean * error[TURN + 1];
        error[VELOCITY + 1] = gap_ ? 0.0 : error[VELOCITY + 1] - lean * error[TURN];
        for (std::size_t i = 0; i < 3; ++i) {
            double turn = 0.0;
            for (std::size_t k = 0; k < 3; ++k) turn += turned_[i][k] * error[BIAS + k];
            for (std::size_t k = 0; k < 9; ++k) turn += wound_[i][k] * error[MATRIX + k];
            error[TURN + i] -= turn;
        }
    }

    void measure_motion(State &added, Node *node) {
        const double kept = std::exp(-elapsed_ / set_.speed_time);
        const double noise =
            square(set_.accel_density) * elapsed_ + speed_.variance() * (1.0 - kept * kept);
        for (std::uint8_t axis = 0; axis < 2; ++axis)
            measure({Kind::acceleration, axis}, -((1.0 - kept) * velocity_[axis] + impulse_[axis]),
                    noise, added, node);
    }

    void measure_rest(State &added, Node *node) {
        for (std::uint8_t axis = 0; axis < 2; ++axis)
            measure({Kind::velocity, axis}, -velocity_[axis], square(REST_SPEED), added, node);
        const double noise = square(set_.gyro_density) / elapsed_ + square(REST_RATE);
        for (std::uint8_t axis = 0; axis < 3; ++axis)
            measure({Kind::bias, axis}, swept_[axis] / elapsed_ - bias_[axis],
                    noise + rest_.scatter()[axis], added, node);
    }

    void measure_heading(State &added, Node *node) {
        Three mean, per_lag;
        double rate = 0.0;
        for (std::size_t i = 0; i < 3; ++i) {
            mean[i] = felt_field_[i] / magnetic_s_;
            per_lag[i] = per_lag_[i] / magnetic_s_;
            rate += square(swept_[i] / elapsed_ - bias_[i]);
        }
        Heading heading = field_.watch(mean, per_lag, rate > square(TURNING_RATE),
                                       square(tilt_deviation()), elapsed_);
        if (!heading.known) return;
        Measured read{Kind::heading, 0, 0.0, 0.0, {}, heading.lean};
        if (faces_ != Faces::north) {  // an end of a record tells half as much as it scatters
            faces_ = Faces::north;
            heading.noise = 2.0 * heading.variance;
        }
        const double angle = std::remainder(heading.angle, 2.0 * HALF_TURN);
        const State h = slope(read, elapsed_, set_);
        double expected = heading.variance, residual = angle;
        for (std::size_t i = 0; i < 3; ++i) {
            residual -= h[i] * added[i];
            for (std::size_t j = 0; j < 3; ++j) expected += h[i] * covariance_[i][j] * h[j];
        }
        covariance_[2][2] += square(field_.astray(residual, expected, elapsed_));
        measure(read, angle, heading.noise, added, node);
    }

    // One number at a time: residual = slope · error + noise; earlier ones of the instant count.
    void measure(Measured read, double residual, double noise, State &added, Node *node) {
        const State h = slope(read, elapsed_, set_);
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
        read.innovation = innovation;
        read.variance = variance;
        read.gain = gain;
        if (node) node->measured[node->count++] = read;
    }

    // Moves the estimate by the errors found, and velocity on by what the accelerometer then says.
    void apply(const State &added) {
        rotor_ = versors::renormalize(versors::compose(turn_of(added), rotor_));
        for (std::size_t i = 0; i < 3; ++i) bias_[i] += added[BIAS + i];
        for (std::size_t i = 0; i < 9; ++i) matrix_[i] += added[MATRIX + i];
        const double lean = set_.gravity * elapsed_;
        velocity_[0] += added[VELOCITY] + impulse_[0] + lean * added[1];
        velocity_[1] += added[VELOCITY + 1] + impulse_[1] - lean * added[0];
    }

    void restart() {
        before_ = elapsed_;
        impulse_ = swept_ = pushed_ = {};
        felt_field_ = per_lag_ = {};
        turned_ = {};
        wound_ = {};
        elapsed_ = wandered_ = lost_ = magnetic_s_ = 0.0;
        gap_ = false;
    }

    Settings set_;
    Speed speed_;
    Rest rest_;
    Field field_;
    Faces faces_ = Faces::anywhere;
    Four rotor_{1.0, 0.0, 0.0, 0.0};
    Three bias_{};
    Nine matrix_{};
    std::array<double, 2> velocity_{};
    Square covariance_{};
    // gathered since the last correction
    Three last_rate_{}, last_force_{}, impulse_{}, swept_{}, pushed_{};
    Three felt_field_{}, per_lag_{};
    Rows turned_{};
    std::array<Nine, 3> wound_{};
    double magnetic_s_ = 0.0, elapsed_ = 0.0, wandered_ = 0.0, lost_ = 0.0, before_ = 0.0;
    bool gap_ = false;
};

}  // namespace motorcade::orientation
