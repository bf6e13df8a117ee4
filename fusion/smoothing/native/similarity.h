// Similarities of one pose: the closed forms of motorcade.ga.versors.similarity_kernels in scalar
// arithmetic. S = A + B E + d J for three rotor-like quadruples; P = A + B = √ρ R and
// N = A - B = R / √ρ multiply by themselves. Stored as A, B, -d[1:], d[0].

#pragma once

#include "rotors.h"

namespace motorcade::smooth {

using Similarity = Vector<12>;

struct Quadruples {
    Four a, b, d;
};

struct Parts {
    Four rotor;
    double log_scale;
    Three translation;
};

inline Four difference_of(const Four &a, const Four &b) { return sum(a, scaled(-1.0, b)); }

inline Quadruples quadruples(const Similarity &s) {
    return {{s[0], s[1], s[2], s[3]}, {s[4], s[5], s[6], s[7]}, {s[11], -s[8], -s[9], -s[10]}};
}

inline Similarity joined(const Four &a, const Four &b, const Four &d) {
    return {a[0], a[1], a[2], a[3], b[0], b[1], b[2], b[3], -d[1], -d[2], -d[3], d[0]};
}

inline Similarity product(const Similarity &s, const Similarity &t) {
    const Quadruples m = quadruples(s), n = quadruples(t);
    return joined(sum(product(m.a, n.a), product(m.b, n.b)), sum(product(m.a, n.b), product(m.b, n.a)),
                  sum(product(sum(m.a, m.b), n.d), product(m.d, difference_of(n.a, n.b))));
}

inline Similarity reverse(const Similarity &s) {
    return {s[0], -s[1], -s[2], -s[3], -s[4], s[5], s[6], s[7], -s[8], -s[9], -s[10], s[11]};
}

inline Parts parts_of(const Similarity &s) {
    const Quadruples m = quadruples(s);
    const Four rotor = scaled(1.0 / std::sqrt(dot(m.a, m.a)), m.a);
    const double half = std::asinh(dot(m.b, rotor));
    const Four moved = product(m.d, reverse(rotor));
    return {rotor, 2.0 * half, scaled(2.0 * std::exp(half), vector_of(moved))};
}

inline Similarity similarity_from(const Parts &parts) {
    const double half = 0.5 * parts.log_scale;
    const Three &t = parts.translation;
    const Four moved = product(Four{0.0, 0.5 * t[0], 0.5 * t[1], 0.5 * t[2]}, parts.rotor);
    return joined(scaled(std::cosh(half), parts.rotor), scaled(std::sinh(half), parts.rotor),
                  scaled(std::exp(-half), moved));
}

// A factor along the axis of the turn, and a complex one across it with i = axis ×.
struct Spread {
    double along, real, imaginary;

    Three apply(const Three &axis, const Three &vector) const {
        const Three turned = cross(axis, vector);
        const double slide = (along - real) * dot(axis, vector);
        Three made;
        for (std::size_t k = 0; k < 3; ++k)
            made[k] = real * vector[k] + slide * axis[k] + imaginary * turned[k];
        return made;
    }
};

// (e^z - 1) / z for z = λ + iθ: how a steady push spreads while the body turns and grows.
inline Spread growth(double log_scale, double angle) {
    const double along = log_scale == 0.0 ? 1.0 : std::expm1(log_scale) / log_scale;
    const double square = log_scale * log_scale + angle * angle;
    if (square < 1e-8) {
        const double z2 = log_scale * log_scale - angle * angle;
        return {along, 1.0 + log_scale / 2 + z2 / 6 + log_scale * (z2 - 2.0 * angle * angle) / 24,
                angle * (0.5 + log_scale / 3 + (z2 + 2.0 * log_scale * log_scale) / 24)};
    }
    const double sine = std::sin(0.5 * angle);
    const double x = std::expm1(log_scale) * std::cos(angle) - 2.0 * sine * sine;
    const double y = std::exp(log_scale) * std::sin(angle);
    return {along, (x * log_scale + y * angle) / square, (y * log_scale - x * angle) / square};
}

// z / (e^z - 1), safe for |θ| <= π.
inline Spread shrinkage(double log_scale, double angle) {
    const double along = log_scale == 0.0 ? 1.0 : log_scale / std::expm1(log_scale);
    if (log_scale * log_scale + angle * angle < 1e-8)
        return {along, 1.0 - log_scale / 2 + (log_scale * log_scale - angle * angle) / 12,
                angle * (log_scale / 6 - 0.5)};
    const double sine = std::sin(0.5 * angle);
    const double x = std::expm1(log_scale) * std::cos(angle) - 2.0 * sine * sine;
    const double y = std::exp(log_scale) * std::sin(angle);
    const double square = x * x + y * y;
    return {along, (log_scale * x + angle * y) / square, (angle * x - log_scale * y) / square};
}

// Rotation vector, translational part, logarithm of the scale.
inline Vector<7> similarity_log(const Similarity &s) {
    const Parts parts = parts_of(s);
    const Three rotation = rotor_log(parts.rotor);
    const double angle = std::sqrt(dot(rotation, rotation));
    const Three axis = scaled(angle > 0.0 ? 1.0 / angle : 0.0, rotation);
    const Three push = shrinkage(parts.log_scale, angle).apply(axis, parts.translation);
    return {rotation[0], rotation[1], rotation[2], push[0], push[1], push[2], parts.log_scale};
}

inline Similarity similarity_exp(const Vector<7> &twist) {
    const Three rotation{twist[0], twist[1], twist[2]};
    const double angle = std::sqrt(dot(rotation, rotation));
    const Three axis = scaled(angle > 0.0 ? 1.0 / angle : 0.0, rotation);
    const Three push{twist[3], twist[4], twist[5]};
    return similarity_from({rotor_exp(rotation), twist[6], growth(twist[6], angle).apply(axis, push)});
}

}  // namespace motorcade::smooth
