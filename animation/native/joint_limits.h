// How joints of inverse kinematics may turn: coordinates of each kind, and their limits.
//
// A joint's turn R is measured from its rest pose, in the joint's own frame. A hinge turns about an
// axis by t. A ball turns by S T: a twist t about its axis first, then a swing about an axis across
// it, by the rotation vector x across + y aside. Swings lie in an ellipse, twists in an interval.
#pragma once

#include <array>
#include <cstddef>

#include "versors.h"

namespace motorcade::animation::ik {

using Vector = std::array<double, 3>;
using Rotor = std::array<double, 4>;
using Motor = std::array<double, 8>;

inline Vector operator+(const Vector &a, const Vector &b) {
    return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}
inline Vector operator-(const Vector &a, const Vector &b) {
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
inline Vector operator*(double s, const Vector &a) { return {s * a[0], s * a[1], s * a[2]}; }
inline double dot(const Vector &a, const Vector &b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
inline Vector cross(const Vector &a, const Vector &b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

// The rotor of a rotation vector, and back by the short way.
Rotor rotor_of(const Vector &vector_rad);
Vector rotation_vector(const Rotor &rotor);

enum class Kind : int { hinge, ball, free_ball, floating };

struct Joint {
    Kind kind;
    std::size_t number;          // in the skeleton
    Vector axis, across, aside;  // right-handed and orthonormal: of hinge or twist, of swings
    double swing[2];             // largest turns about across and aside; infinite where none
    double low, high;            // of hinge or twist
};

// Where a joint is: coordinates x, y, t of hinge and ball; the rotor of a free ball, and of a
// floating joint the shift besides.
struct Turn {
    std::array<double, 3> at{};
    Rotor rotor{1.0, 0.0, 0.0, 0.0};
    Vector shift{};
};

// How many coordinates a joint has.
std::size_t coordinates(Kind kind);

// The turn nearest to a rotor and shift that is within the limits.
Turn turn_of(const Joint &joint, const Rotor &rotor, const Vector &shift);
// Steps each coordinate and brings the result back within the limits.
Turn stepped(const Joint &joint, const Turn &turn, const double *step);
// Some turn within the limits, by numbers from -1 to 1, one a coordinate; coordinates without
// limits go as far as half a turn, shifts as half the size.
Turn scattered(const Joint &joint, const Turn &turn, const double *shares);
// The rotor of `turn`.
Rotor rotor_at(const Joint &joint, const Turn &turn);
// Angular velocities in the rest frame, one a coordinate that turns.
void turning_axes(const Joint &joint, const Turn &turn, Vector *axes);

// How the edge of a ball's swings curves where they are; 0 where they have no such edge.
double edge_curvature(const Joint &joint, const Turn &turn);

// The directions in coordinates in which a joint may be moved downhill, given the gradient there,
// and how hard the gradient presses on each limit: of swing, and of hinge or twist with the sign of
// the end that holds it. Directions come as rows of six; returns their number.
std::size_t free_directions(const Joint &joint, const Turn &turn, const double *gradient,
                            double (*directions)[6], double *presses);

}  // namespace motorcade::animation::ik
