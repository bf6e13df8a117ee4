// Rotors, motors and similarities of one pose, in scalar arithmetic: products, exponentials and
// logarithms. Conventions are those of motorcade.ga: a rotor is (w, v) on 1, e23, e31, e12; a motor
// A + J B with J = e123∞ is stored as (A, -B[1:], B[0]); twists are rotation vector, then
// translational part, and -2 times the logarithm. Versors are taken for unit.

#pragma once

#include <array>
#include <cmath>
#include <cstddef>

namespace motorcade::smooth {

template <std::size_t N> using Vector = std::array<double, N>;
using Three = Vector<3>;
using Four = Vector<4>;
using Motor = Vector<8>;

inline double dot(const Three &a, const Three &b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

inline double dot(const Four &a, const Four &b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
}

inline Three cross(const Three &a, const Three &b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

inline Three vector_of(const Four &a) { return {a[1], a[2], a[3]}; }

inline Four product(const Four &a, const Four &b) {
    return {a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
            a[0] * b[1] + a[1] * b[0] - a[2] * b[3] + a[3] * b[2],
            a[0] * b[2] + a[2] * b[0] - a[3] * b[1] + a[1] * b[3],
            a[0] * b[3] + a[3] * b[0] - a[1] * b[2] + a[2] * b[1]};
}

inline Four reverse(const Four &a) { return {a[0], -a[1], -a[2], -a[3]}; }

template <std::size_t N> inline Vector<N> sum(const Vector<N> &a, const Vector<N> &b) {
    Vector<N> made;
    for (std::size_t k = 0; k < N; ++k) made[k] = a[k] + b[k];
    return made;
}

template <std::size_t N> inline Vector<N> scaled(double factor, const Vector<N> &a) {
    Vector<N> made;
    for (std::size_t k = 0; k < N; ++k) made[k] = factor * a[k];
    return made;
}

// Coefficients of x^0, x^1, ... by Horner's rule.
template <std::size_t N> inline double polynomial(double x, const double (&c)[N]) {
    double total = c[N - 1];
    for (std::size_t k = N - 1; k-- > 0;) total = total * x + c[k];
    return total;
}

// Below this square of a sine or of half an angle the series below are exact to the last bit.
inline constexpr double SERIES_BELOW = 1e-2;

struct Turn {
    double cosine, sinc, coupling;  // cos h, sin h / h, (cos h - sinc h) / h²
};

inline Turn turn_by(double square) {
    if (square < SERIES_BELOW)
        return {polynomial(square, {1.0, -1.0 / 2, 1.0 / 24, -1.0 / 720, 1.0 / 40320, -1.0 / 3628800}),
                polynomial(square, {1.0, -1.0 / 6, 1.0 / 120, -1.0 / 5040, 1.0 / 362880, -1.0 / 39916800}),
                polynomial(square, {-1.0 / 3, 1.0 / 30, -1.0 / 840, 1.0 / 45360, -1.0 / 3991680,
                                    1.0 / 518918400})};
    const double h = std::sqrt(square);
    const double cosine = std::cos(h), sinc = std::sin(h) / h;
    return {cosine, sinc, (cosine - sinc) / square};
}

struct Arc {
    double ratio, coupling;  // h / s, (1 - h w / s) / s² for s = sin h, w = cos h >= 0
};

inline Arc arc_of(double square, double w) {
    if (square < SERIES_BELOW)
        return {polynomial(square, {1.0, 1.0 / 6, 3.0 / 40, 5.0 / 112, 35.0 / 1152, 63.0 / 2816,
                                    231.0 / 13312, 143.0 / 10240}),
                polynomial(square, {1.0 / 3, 2.0 / 15, 8.0 / 105, 16.0 / 315, 128.0 / 3465, 256.0 / 9009,
                                    1024.0 / 45045, 2048.0 / 109395})};
    const double s = std::sqrt(square);
    const double ratio = std::atan2(s, w) / s;
    return {ratio, (1.0 - ratio * w) / square};
}

// Rotation vector of a rotor, at most π long: the short way round.
inline Three rotor_log(const Four &rotor) {
    const double sign = rotor[0] < 0.0 ? -1.0 : 1.0;
    const Three v = vector_of(rotor);
    return scaled(-2.0 * sign * arc_of(dot(v, v), sign * rotor[0]).ratio, v);
}

inline Four rotor_exp(const Three &rotation) {
    const Turn turn = turn_by(0.25 * dot(rotation, rotation));
    const double factor = -0.5 * turn.sinc;
    return {turn.cosine, factor * rotation[0], factor * rotation[1], factor * rotation[2]};
}

// One Newton step towards unit length, which rounding leaves by little.
inline Four rescaled(const Four &rotor) { return scaled(1.5 - 0.5 * dot(rotor, rotor), rotor); }

inline Four rotor_of(const Motor &m) { return {m[0], m[1], m[2], m[3]}; }

inline Four moving_part(const Motor &m) { return {m[7], -m[4], -m[5], -m[6]}; }

inline Motor motor_of(const Four &a, const Four &b) {
    return {a[0], a[1], a[2], a[3], -b[1], -b[2], -b[3], b[0]};
}

inline Motor product(const Motor &m, const Motor &n) {
    const Four a = rotor_of(m), b = rotor_of(n);
    return motor_of(product(a, b), sum(product(a, moving_part(n)), product(moving_part(m), b)));
}

inline Motor reverse(const Motor &m) { return {m[0], -m[1], -m[2], -m[3], -m[4], -m[5], -m[6], m[7]}; }

// Unit motor nearest to one that is almost unit.
inline Motor rescaled(const Motor &m) {
    Motor unit = scaled(1.0 / std::sqrt(dot(rotor_of(m), rotor_of(m))), m);
    const double excess = unit[0] * unit[7] - unit[1] * unit[4] - unit[2] * unit[5] - unit[3] * unit[6];
    for (std::size_t k = 1; k < 4; ++k) unit[3 + k] += excess * unit[k];
    unit[7] -= excess * unit[0];
    return unit;
}

inline Vector<6> motor_log(const Motor &given) {
    const Motor m = scaled(given[0] < 0.0 ? -1.0 : 1.0, given);
    const Three v{m[1], m[2], m[3]};
    const Arc arc = arc_of(dot(v, v), m[0]);
    const double across = 2.0 * arc.coupling * m[7];
    return {-2.0 * arc.ratio * v[0], -2.0 * arc.ratio * v[1], -2.0 * arc.ratio * v[2],
            -2.0 * arc.ratio * m[4] - across * v[0], -2.0 * arc.ratio * m[5] - across * v[1],
            -2.0 * arc.ratio * m[6] - across * v[2]};
}

inline Motor motor_exp(const Vector<6> &twist) {
    const Three a{-0.5 * twist[0], -0.5 * twist[1], -0.5 * twist[2]};
    const Three b{0.5 * twist[3], 0.5 * twist[4], 0.5 * twist[5]};
    const Turn turn = turn_by(dot(a, a));
    const double along = dot(a, b);
    const double slide = along * turn.coupling;
    return {turn.cosine, turn.sinc * a[0], turn.sinc * a[1], turn.sinc * a[2],
            -turn.sinc * b[0] - slide * a[0], -turn.sinc * b[1] - slide * a[1],
            -turn.sinc * b[2] - slide * a[2], -turn.sinc * along};
}

inline Three translation_of(const Motor &m) {
    const Three v{m[1], m[2], m[3]}, n{m[4], m[5], m[6]};
    const Three turned = cross(n, v);
    Three made;
    for (std::size_t k = 0; k < 3; ++k) made[k] = -2.0 * (m[7] * v[k] + m[0] * n[k] + turned[k]);
    return made;
}

inline Motor motor_from(const Four &rotor, const Three &translation) {
    const Three v = vector_of(rotor), turned = cross(v, translation);
    Motor made{rotor[0], rotor[1], rotor[2], rotor[3]};
    for (std::size_t k = 0; k < 3; ++k) made[4 + k] = -0.5 * (rotor[0] * translation[k] + turned[k]);
    made[7] = -0.5 * dot(v, translation);
    return made;
}

}  // namespace motorcade::smooth
