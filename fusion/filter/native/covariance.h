// Covariances of the filter's error and how they move. An error has N numbers: turn, position,
// velocity, gyroscope bias, accelerometer bias (three each) and, where N is 24, tilt of gravity
// (2), error of the camera's pose on the IMU (6) and time offset (1); where it is 30, also the pose
// of an earlier moment (6), which relative measurements refer to. Matrices are symmetric; only a
// history packs them. The transition over one interval of inertial data is sparse, and only its
// blocks are multiplied: two thirds of a dense product fall away.

#pragma once

#include <cmath>
#include <cstddef>
#include <vector>

// A clone's loops are only as wide as the clone where they are part of it.
#if defined(__GNUC__)
#define MOTORCADE_INLINE inline __attribute__((always_inline))
#else
#define MOTORCADE_INLINE inline
#endif

namespace motorcade::filter {

constexpr std::size_t turn = 0, position = 3, velocity = 6, gyro = 9, accel = 12;
constexpr std::size_t tilt = 15, extrinsics = 17, delay = 23, earlier = 24;
constexpr std::size_t most = 30;   // numbers in an error
constexpr std::size_t widest = 8;  // numbers in one measurement

// Blocks of 3x3 by rows, named as the generated `motorcade_transition` names them.
struct Transition {
    double turn_turn[9], position_turn[9], velocity_turn[9], turn_gyro[9], position_gyro[9];
    double velocity_gyro[9], position_accel[9], velocity_accel[9], velocity_tilt[6];
    double dt;
};

// Variances a second: of turn, velocity and both biases.
struct Densities {
    double rate, force, gyro_walk, accel_walk;
};

constexpr std::size_t padded(std::size_t n) { return (n + 7) / 8 * 8; }

template <std::size_t N> struct Matrix {
    static constexpr std::size_t width = padded(N);
    alignas(64) double row[N][width] = {};
};

template <std::size_t W>
MOTORCADE_INLINE void add(double *__restrict to, double factor, const double *__restrict from) {
    for (std::size_t c = 0; c < W; ++c) to[c] += factor * from[c];
}

// P becomes F P F' + Q; symmetric to the last bit where it was so.
void propagate(Matrix<15> &p, const Transition &f, const Densities &q);
void propagate(Matrix<24> &p, const Transition &f, const Densities &q);
void propagate(Matrix<30> &p, const Transition &f, const Densities &q);

// X becomes F X.
void transform(Matrix<15> &x, const Transition &f);

// Λ becomes F' Λ F and λ becomes F' λ.
void propagate_back(Matrix<15> &curvature, double *gradient, const Transition &f);
void propagate_back(Matrix<24> &curvature, double *gradient, const Transition &f);
void propagate_back(Matrix<30> &curvature, double *gradient, const Transition &f);

template <std::size_t N>
MOTORCADE_INLINE void transpose(const double (*from)[Matrix<N>::width],
                                double (*to)[Matrix<N>::width]) {
    for (std::size_t i = 0; i < N; ++i)
        for (std::size_t j = 0; j < N; ++j) to[j][i] = from[i][j];
    for (std::size_t i = 0; i < N; ++i)
        for (std::size_t j = N; j < Matrix<N>::width; ++j) to[i][j] = 0.0;
}

template <std::size_t N> MOTORCADE_INLINE void symmetrise(Matrix<N> &p) {
    for (std::size_t i = 0; i < N; ++i)
        for (std::size_t j = 0; j < i; ++j)
            p.row[i][j] = p.row[j][i] = 0.5 * (p.row[i][j] + p.row[j][i]);
}

template <std::size_t N> std::vector<double> packed(const Matrix<N> &p) {
    std::vector<double> made;
    made.reserve(N * (N + 1) / 2);
    for (std::size_t i = 0; i < N; ++i) made.insert(made.end(), p.row[i], p.row[i] + i + 1);
    return made;
}

template <std::size_t N> void unpack(const std::vector<double> &given, Matrix<N> &p) {
    std::size_t k = 0;
    for (std::size_t i = 0; i < N; ++i)
        for (std::size_t j = 0; j <= i; ++j) p.row[i][j] = p.row[j][i] = given[k++];
}

// What a measurement of m numbers says: measured less predicted, its derivative by the error, its
// noise.
template <std::size_t N> struct Innovation {
    std::size_t size = 0;
    bool bent = false;  // see bend.h
    double residual[widest] = {};
    double effect[widest][N] = {};
    double noise[widest][widest] = {};
};

// A step of Kalman's, a row a number of the measurement: what the covariance P makes of its
// derivative (H P), the gain, the innovation's covariance with its inverse, and the normalised
// square.
template <std::size_t N> struct Gain {
    alignas(64) double spread[widest][Matrix<N>::width];
    alignas(64) double gain[widest][Matrix<N>::width];
    double total[widest][widest];
    double inverse[widest][widest];
    double nis = 0.0;
};

// Inverse of a symmetric positive definite matrix; false where it is not one.
bool inverse_of(std::size_t m, const double (*given)[widest], double (*made)[widest]);

// The gain for noise that is `factor` times what the measurement states; false where the
// innovation's covariance is not positive definite.
bool weigh(const Matrix<15> &p, const Innovation<15> &given, double factor, Gain<15> &made);
bool weigh(const Matrix<24> &p, const Innovation<24> &given, double factor, Gain<24> &made);
bool weigh(const Matrix<30> &p, const Innovation<30> &given, double factor, Gain<30> &made);

// The covariance after a measurement, in Joseph's form.
void update(Matrix<15> &p, const Innovation<15> &given, const Gain<15> &by);
void update(Matrix<24> &p, const Innovation<24> &given, const Gain<24> &by);
void update(Matrix<30> &p, const Innovation<30> &given, const Gain<30> &by);

// Λ becomes (1 - K H)' Λ (1 - K H) + H' S⁻¹ H.
void update_back(Matrix<15> &curvature, const Innovation<15> &given, const Gain<15> &by);
void update_back(Matrix<24> &curvature, const Innovation<24> &given, const Gain<24> &by);
void update_back(Matrix<30> &curvature, const Innovation<30> &given, const Gain<30> &by);

// P becomes P - P Λ P.
void shrink(Matrix<15> &p, const Matrix<15> &curvature);
void shrink(Matrix<24> &p, const Matrix<24> &curvature);
void shrink(Matrix<30> &p, const Matrix<30> &curvature);

}  // namespace motorcade::filter
