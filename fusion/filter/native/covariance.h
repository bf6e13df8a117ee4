// Covariances of the filter's error and how they move. An error has N numbers: turn, position,
// velocity, gyroscope bias, accelerometer bias (three each) and, where N is 24, tilt of gravity (2),
// error of the camera's pose on the IMU (6) and time offset (1). Matrices are symmetric; only a
// history packs them. The transition over one interval of inertial data is sparse, and only its
// blocks are multiplied: two thirds of a dense product fall away.

#pragma once

#include <cmath>
#include <cstddef>
#include <vector>

namespace motorcade::filter {

constexpr std::size_t turn = 0, position = 3, velocity = 6, gyro = 9, accel = 12;
constexpr std::size_t tilt = 15, mounting = 17, delay = 23;
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

template <std::size_t W> inline void add(double *__restrict to, double factor, const double *__restrict from) {
    for (std::size_t c = 0; c < W; ++c) to[c] += factor * from[c];
}

// P becomes F P F' + Q; symmetric to the last bit where it was so.
void propagate(Matrix<15> &p, const Transition &f, const Densities &q);
void propagate(Matrix<24> &p, const Transition &f, const Densities &q);

// Λ becomes F' Λ F and λ becomes F' λ.
void propagate_back(Matrix<15> &curvature, double *gradient, const Transition &f);
void propagate_back(Matrix<24> &curvature, double *gradient, const Transition &f);

template <std::size_t N> inline void transpose(const double (*from)[Matrix<N>::width], double (*to)[Matrix<N>::width]) {
    for (std::size_t i = 0; i < N; ++i)
        for (std::size_t j = 0; j < N; ++j) to[j][i] = from[i][j];
    for (std::size_t i = 0; i < N; ++i)
        for (std::size_t j = N; j < Matrix<N>::width; ++j) to[i][j] = 0.0;
}

template <std::size_t N> inline void symmetrise(Matrix<N> &p) {
    for (std::size_t i = 0; i < N; ++i)
        for (std::size_t j = 0; j < i; ++j) p.row[i][j] = p.row[j][i] = 0.5 * (p.row[i][j] + p.row[j][i]);
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

// What a measurement of m numbers says: measured less predicted, its derivative by the error, its noise.
template <std::size_t N> struct Innovation {
    std::size_t size = 0;
    double residual[widest] = {};
    double effect[widest][N] = {};
    double noise[widest][widest] = {};
};

// A step of Kalman's: gain N x m, inverse of the innovation's covariance, normalised square.
template <std::size_t N> struct Gain {
    double gain[N][widest] = {};
    double inverse[widest][widest] = {};
    double nis = 0.0;
};

// Inverse of a symmetric positive definite matrix by Cholesky; false where it is not one.
inline bool invert(std::size_t m, const double (*given)[widest], double (*made)[widest]) {
    double lower[widest][widest] = {}, right[widest][widest] = {};
    for (std::size_t i = 0; i < m; ++i)
        for (std::size_t j = 0; j <= i; ++j) {
            double sum = given[i][j];
            for (std::size_t k = 0; k < j; ++k) sum -= lower[i][k] * lower[j][k];
            if (i == j && !(sum > 0.0)) return false;
            lower[i][j] = i == j ? std::sqrt(sum) : sum / lower[j][j];
        }
    for (std::size_t j = 0; j < m; ++j)
        for (std::size_t i = j; i < m; ++i) {
            double sum = i == j ? 1.0 : 0.0;
            for (std::size_t k = j; k < i; ++k) sum -= lower[i][k] * right[k][j];
            right[i][j] = sum / lower[i][i];
        }
    for (std::size_t i = 0; i < m; ++i)
        for (std::size_t j = 0; j < m; ++j) {
            double sum = 0.0;
            for (std::size_t k = i > j ? i : j; k < m; ++k) sum += right[k][i] * right[k][j];
            made[i][j] = sum;
        }
    return true;
}

// The gain for noise that is `factor` times what the measurement states.
template <std::size_t N>
inline bool weigh(const Matrix<N> &p, const Innovation<N> &given, double factor, Gain<N> &made) {
    const std::size_t m = given.size;
    double spread[N][widest] = {}, total[widest][widest];
    for (std::size_t a = 0; a < m; ++a)
        for (std::size_t k = 0; k < N; ++k)
            if (given.effect[a][k] != 0.0)
                for (std::size_t i = 0; i < N; ++i) spread[i][a] += p.row[k][i] * given.effect[a][k];
    for (std::size_t a = 0; a < m; ++a)
        for (std::size_t b = 0; b < m; ++b) {
            double sum = factor * given.noise[a][b];
            for (std::size_t k = 0; k < N; ++k) sum += given.effect[a][k] * spread[k][b];
            total[a][b] = sum;
        }
    if (!invert(m, total, made.inverse)) return false;
    made.nis = 0.0;
    for (std::size_t a = 0; a < m; ++a)
        for (std::size_t b = 0; b < m; ++b) made.nis += given.residual[a] * made.inverse[a][b] * given.residual[b];
    for (std::size_t i = 0; i < N; ++i)
        for (std::size_t b = 0; b < m; ++b) {
            double sum = 0.0;
            for (std::size_t a = 0; a < m; ++a) sum += spread[i][a] * made.inverse[a][b];
            made.gain[i][b] = sum;
        }
    return true;
}

// (1 - K H) X.
template <std::size_t N>
inline void reduced(const Matrix<N> &x, const Innovation<N> &given, const Gain<N> &by, Matrix<N> &made) {
    constexpr std::size_t W = Matrix<N>::width;
    made = x;
    for (std::size_t a = 0; a < given.size; ++a) {
        double seen[W] = {};
        for (std::size_t k = 0; k < N; ++k)
            if (given.effect[a][k] != 0.0) add<W>(seen, given.effect[a][k], x.row[k]);
        for (std::size_t i = 0; i < N; ++i) add<W>(made.row[i], -by.gain[i][a], seen);
    }
}

// The covariance after a measurement, in Joseph's form.
template <std::size_t N>
inline void update(Matrix<N> &p, const Innovation<N> &given, double factor, const Gain<N> &by) {
    Matrix<N> once, across;
    reduced(p, given, by, once);
    transpose<N>(once.row, across.row);
    reduced(across, given, by, p);
    for (std::size_t a = 0; a < given.size; ++a) {
        double noisy[Matrix<N>::width] = {};
        for (std::size_t b = 0; b < given.size; ++b)
            for (std::size_t j = 0; j < N; ++j) noisy[j] += factor * given.noise[a][b] * by.gain[j][b];
        for (std::size_t i = 0; i < N; ++i) add<Matrix<N>::width>(p.row[i], by.gain[i][a], noisy);
    }
    symmetrise(p);
}

}  // namespace motorcade::filter
