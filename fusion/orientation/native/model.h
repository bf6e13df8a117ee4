// State, settings and measurements of the orientation filter, shared by its passes forwards and
// backwards.

#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "vectors.h"

namespace motorcade::orientation {

enum : std::size_t { TURN = 0, BIAS = 3, VELOCITY = 6, MATRIX = 8, ERRORS = 17 };
using State = std::array<double, ERRORS>;
using Square = std::array<State, ERRORS>;
using Rows = std::array<Three, 3>;
using Nine = std::array<double, 9>;

struct Settings {
    double gyro_density, gyro_walk, accel_density;  // rad/s/√Hz, rad/s²/√Hz, m/s²/√Hz
    double gyro_matrix, gyro_wander;  // deviation of an element; error per turned √(rad rad/s)
    double first_bias, first_tilt;    // deviations, rad/s and rad
    double speed, speed_time;         // least deviation (m/s) and T (s) of the velocity
    double gravity, interval;         // m/s²; s from correction to correction
    double rest_rate, rest_force, rest_after;  // rad/s, m/s², s
    double disturbance, disturbance_time;      // of the magnetic field's direction (rad), s
    bool averaged;                             // readings are means over the interval before them
};

// Which error a measurement reads. Two of acceleration while moving; at rest two of velocity, three
// of bias; one of heading.
enum class Kind : std::uint8_t { acceleration, velocity, bias, heading };

struct Measured {
    Kind kind = Kind::acceleration;
    std::uint8_t axis = 0;
    double innovation = 0.0, variance = 0.0;
    State gain{};
    std::array<double, 2> lean{};  // what a tilt about each axis does to the heading
};

// One interval and its correction, as the pass backwards wants them.
struct Node {
    std::size_t end = 0;  // the sample after which it corrects
    bool gap = false;     // the interval began with a gap
    double before = 0.0;  // seconds of the interval before
    double lasted = 0.0;
    Rows turned{};
    std::array<Nine, 3> wound{};
    std::size_t count = 0;
    std::array<Measured, 6> measured{};
    State added{};
    std::array<double, ERRORS *(ERRORS + 1) / 2>
        covariance{};  // lower triangle, after the correction
};

inline void transpose(Square &matrix) {
    for (std::size_t i = 0; i < ERRORS; ++i)
        for (std::size_t j = 0; j < i; ++j) std::swap(matrix[i][j], matrix[j][i]);
}

// H of a measurement, by its kind.
inline State slope(const Measured &of, double lasted, const Settings &set) {
    State made{};
    if (of.kind == Kind::heading) {
        made[TURN] = of.lean[0];
        made[TURN + 1] = of.lean[1];
        made[TURN + 2] = -1.0;
    } else if (of.kind == Kind::bias) {
        made[BIAS + of.axis] = 1.0;
    } else if (of.kind == Kind::velocity) {
        made[VELOCITY + of.axis] = 1.0;
    } else {
        // A turn t of the axes tilts gravity by t × g: (t_y, -t_x) g.
        made[TURN + 1 - of.axis] = (of.axis == 0 ? 1.0 : -1.0) * set.gravity * lasted;
        made[VELOCITY + of.axis] = -std::expm1(-lasted / set.speed_time);
    }
    return made;
}

}  // namespace motorcade::orientation
