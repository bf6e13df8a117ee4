// A measurement is predicted, weighed, and taken in; where the path begins, and where it begins
// anew.

#pragma once

#include "bend.h"
#include "timeline.h"

namespace motorcade::filter {

template <std::size_t N> void Timeline<N>::measure(Event &event) {
    Innovation<N> innovation;
    Gain<N> gain;
    if (event.doubt) make_room(event, *event.doubt);
    event.factor = 0.0;
    event.bent = false;
    event.nis = std::nan("");
    event.linear.reset();
    const bool predicted = predict(event, innovation) && weigh(p_, innovation, 1.0, gain);
    event.size = static_cast<std::uint8_t>(innovation.size);
    if (!predicted) return;
    tells(event, innovation);
    event.nis = gain.nis;
    event.factor = event.given;
    if (event.given == undecided) {
        const bool within = gain.nis <= settings_.gate[innovation.size];
        if (!within) weigh(p_, innovation, settings_.most_noise, gain);
        event.factor = factor_of(event.nis, gain.nis, innovation.size);
    }
    if (event.factor != 1.0) weigh(p_, innovation, std::max(1.0, event.factor), gain);
    event.bent = innovation.bent;
    if (thorough_) keep_linear(event, innovation, gain);
    if (event.factor > 0.0) apply(innovation, gain);
}

template <std::size_t N> bool Timeline<N>::predict(const Event &event, Innovation<N> &made) const {
    const Reading read = reading(time_ns_);
    if (!Prediction<N>(now_, read).of(event, made)) return false;
    allow_for_bend(now_, read, event, p_, made);
    return true;
}

// From three numbers on that depend on the position, and on no earlier one.
template <std::size_t N> void Timeline<N>::tells(Event &event, const Innovation<N> &innovation) {
    std::size_t rows = 0;
    event.relative = false;
    for (std::size_t a = 0; a < innovation.size; ++a) {
        const double *effect = innovation.effect[a];
        const auto any = [effect](std::size_t from, std::size_t to) {
            return std::any_of(effect + from, effect + to, [](double x) { return x != 0.0; });
        };
        rows += any(position, velocity);
        if constexpr (N > earlier) event.relative |= any(earlier, N);
    }
    event.placed = rows >= 3 && !event.relative;
}

template <std::size_t N>
void Timeline<N>::apply(const Innovation<N> &innovation, const Gain<N> &gain) {
    const std::size_t m = innovation.size;
    double error[N] = {};
    for (std::size_t a = 0; a < m; ++a) filter::add<N>(error, innovation.residual[a], gain.gain[a]);
    update(p_, innovation, gain);
    correct<N>(now_, error);
    if (innovation.bent) rebase(p_, error);
}

// Of a start that no single pose may decide: so wide that any measurement outweighs it, and narrow
// enough for float64 to tell what is left after one.
constexpr double wide_rad = 1.0, wide_m = 10.0;
// A map that is relocated leaves the sensor's biases alone. What gave the prediction up may have
// been they, though: a tenth of what was unknown of them at the start comes back.
constexpr double bias_share = 0.1;

// The first pose as a state: at rest, biases zero, with room for both to be wrong. Or where a state
// is known already: that, with room for all of it to be wrong.
template <std::size_t N> void Timeline<N>::start(Event &event) {
    seek(event.time_ns);
    started_ = true;
    if (!begun_) {
        from_pose(event);
        lean();
        event.placed = true;
        event.factor = 1.0;
        event.nis = std::nan("");
        return;
    }
    begin_wide([&] { now_ = *begun_; });
    measure(event);
}

template <std::size_t N> template <class Do> void Timeline<N>::begin_wide(Do &&state) {
    state();
    p_ = Matrix<N>();
    for (std::size_t k = 0; k < 6; ++k)
        p_.row[k][k] = k < 3 ? wide_rad * wide_rad : wide_m * wide_m;
    unknown_at_start();
}

// Everything from an event on is done anew, as if nothing had been measured before.
template <std::size_t N> void Timeline<N>::begin_at(std::size_t index) {
    for (Event &event : events_) event.doubt.reset(), event.given = undecided, event.apart = false;
    candidates_.clear(), former_.reset(), begun_.reset();
    explained_ = own_hits_ = denied_ = 0;
    started_ = false;
    begin_ = own_birth_ = next_ = index;
    catch_up();
}

template <std::size_t N> void Timeline<N>::from_pose(const Event &event) {
    static constexpr double one[8] = {1.0};
    double spread[36];
    now_ = first_;
    p_ = Matrix<N>();
    const double *imu_T_camera = event.kind == Kind::camera_pose ? first_.imu_T_camera : one;
    motorcade_start(event.data, imu_T_camera, now_.pose, spread);
    for (std::size_t i = 0; i < 6; ++i)
        for (std::size_t j = 0; j < 6; ++j)
            for (std::size_t a = 0; a < 6; ++a)
                for (std::size_t b = 0; b < 6; ++b)
                    p_.row[i][j] += spread[6 * i + a] * event.noise[6 * a + b] * spread[6 * j + b];
    symmetrise(p_);
    unknown_at_start();
}

// Adds what is unknown of everything but the pose.
template <std::size_t N> void Timeline<N>::unknown_at_start() {
    for (std::size_t k = 0; k < N; ++k) {
        const double sigma = start_sigma(k);
        p_.row[k][k] += sigma * sigma;
    }
}

template <std::size_t N> double Timeline<N>::start_sigma(std::size_t k) const {
    if (k < tilt) return settings_.start_sigma[k / 3];
    if (k >= earlier) return 0.0;
    return settings_.known_sigma[k < extrinsics ? 0 : k < extrinsics + 3 ? 1 : k < delay ? 2 : 3];
}

// A start that is wrong on purpose: turned about the world's x, with room for that in its tilt.
template <std::size_t N> void Timeline<N>::lean() {
    const double angle = settings_.start_tilt_rad;
    double axes[9], error[9] = {}, pose[8], speed[3];
    if (angle == 0.0) return;
    motorcade_velocity_effect(now_.pose, axes);
    for (std::size_t i = 0; i < 3; ++i) error[i] = angle * axes[i];
    motorcade_corrected(now_.pose, now_.velocity, error, pose, speed);
    std::copy_n(pose, 8, now_.pose);
    motorcade_velocity_effect(now_.pose, axes);
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = 0; j < 3; ++j)
            p_.row[i][j] += angle * angle * (axes[i] * axes[j] + axes[3 + i] * axes[3 + j]);
}

// The prediction is given up here.
template <std::size_t N> void Timeline<N>::make_room(const Event &event, const Doubt &doubt) {
    if (doubt.anew)
        return begin_wide([&] {
            if (doubt.turned) return relocate(now_, event, true);
            from_pose(event);
        });
    if (doubt.relocated) relocate(now_, event, false);
    for (std::size_t k = 0; k < 15; ++k) p_.row[k][k] += doubt.added[k / 3];
}

// On a relocated map the pose is the measured one, and the velocity turns along: errors, which
// stand on the right, know nothing of that. And so may gravity.
template <std::size_t N> void Timeline<N>::relocate(State &state, const Event &event, bool turned) {
    static constexpr double one[8] = {1.0};
    const double *imu_T_camera = event.kind == Kind::camera_pose ? state.imu_T_camera : one;
    double spread[36], pose[8], from[9], to[9], own[3] = {};
    motorcade_start(event.data, imu_T_camera, pose, spread);
    motorcade_velocity_effect(state.pose, from);
    motorcade_velocity_effect(pose, to);
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t k = 0; k < 3; ++k) own[i] += from[3 * k + i] * state.velocity[k];
    for (std::size_t k = 0; k < 3; ++k) {
        state.velocity[k] = 0.0;
        for (std::size_t i = 0; i < 3; ++i) state.velocity[k] += to[3 * k + i] * own[i];
    }
    if (turned) {
        double back[8] = {state.gravity_rotor[0]}, map[8], gravity[8];
        for (std::size_t i = 1; i < 4; ++i) back[i] = -state.gravity_rotor[i];
        motorcade_start(pose, state.pose, map, spread);
        motorcade_start(map, back, gravity, spread);
        std::copy_n(gravity, 4, state.gravity_rotor);
    }
    std::copy_n(pose, 8, state.pose);
}

}  // namespace motorcade::filter
