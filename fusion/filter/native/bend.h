// What a measurement is predicted to be is no straight function of a state that is hardly known:
// where the turn is off, what is unknown of place and speed points elsewhere. Taken for straight,
// an altitude that follows a single pose would tell the horizontal speed, which it does not. So
// what bends is added: its mean to the prediction, its covariance to the noise (A. H. Jazwinski,
// Stochastic Processes and Filtering Theory, 1970, section 9.3). Everything is straight in place,
// speed and biases; only the turn bends it. And what is known after such a measurement is told in
// the coordinates of the state that it made, so that what it did not tell is not told by the next.

#pragma once

#include "measurement.h"

namespace motorcade::filter {

// Variances that are less than this share of the noise change no estimate that anybody would see:
// half a percent of a deviation.
constexpr double seen_share = 0.01;
constexpr double step_rad = 1e-4;  // of differences; their error is of its square

// For every number of a measurement how its derivative changes with the turn.
template <std::size_t N> using Bend = std::array<std::array<std::array<double, N>, 3>, widest>;

// Whether what bends may be seen, at most: by sizes of the derivative's parts and of what is
// unknown.
template <std::size_t N> bool may_bend(const Matrix<N> &p, const Innovation<N> &given) {
    double unknown[3] = {};
    for (std::size_t k = 0; k < gyro; ++k) unknown[k / 3] += p.row[k][k];
    for (std::size_t a = 0; a < given.size; ++a) {
        double most = 0.0;
        for (std::size_t part = 0; part < 3; ++part) {
            const double *effect = given.effect[a] + 3 * part;
            const double square =
                effect[0] * effect[0] + effect[1] * effect[1] + effect[2] * effect[2];
            most += std::sqrt(square * unknown[part]);
        }
        if (most * most * unknown[0] > seen_share * given.noise[a][a]) return true;
    }
    return false;
}

// Second derivatives by the turn and the whole error, in the state's exponential coordinates: those
// of the derivative, which stands at the turned state, less half of what turning does to it.
template <std::size_t N>
bool bend_of(const State &state, const Reading &read, const Event &event,
             const Innovation<N> &given, Bend<N> &made) {
    for (std::size_t j = 0; j < 3; ++j) {
        Innovation<N> ahead, back;
        double error[N] = {};
        for (Innovation<N> *to : {&ahead, &back}) {
            State turned = state;
            error[j] = to == &ahead ? step_rad : -step_rad;
            correct<N>(turned, error);
            if (!Prediction<N>(turned, read).of(event, *to)) return false;
        }
        const std::size_t u = (j + 1) % 3, v = (j + 2) % 3;  // e_j × e_u = e_v, e_j × e_v = -e_u
        for (std::size_t a = 0; a < given.size; ++a) {
            for (std::size_t k = 0; k < N; ++k)
                made[a][j][k] = (ahead.effect[a][k] - back.effect[a][k]) / (2.0 * step_rad);
            for (std::size_t part = 0; part < gyro; part += 3) {
                made[a][j][part + u] -= 0.5 * given.effect[a][part + v];
                made[a][j][part + v] += 0.5 * given.effect[a][part + u];
            }
        }
    }
    for (std::size_t a = 0; a < given.size; ++a)
        for (std::size_t j = 0; j < 3; ++j)
            for (std::size_t k = 0; k < j; ++k)
                made[a][j][k] = made[a][k][j] = 0.5 * (made[a][j][k] + made[a][k][j]);
    return true;
}

// Of a pose nothing bends: its residual is told in the same coordinates.
template <std::size_t N>
void allow_for_bend(const State &state, const Reading &read, const Event &event, const Matrix<N> &p,
                    Innovation<N> &given) {
    Bend<N> bend;
    if (event.from_pose() || !may_bend(p, given) || !bend_of(state, read, event, given, bend))
        return;
    given.bent = true;
    // M P of each number's symmetric M, which has the three rows of the bend, and their columns.
    std::array<std::array<std::array<double, N>, N>, widest> spread = {};
    for (std::size_t a = 0; a < given.size; ++a)
        for (std::size_t j = 0; j < 3; ++j)
            for (std::size_t k = 0; k < N; ++k) {
                filter::add<N>(spread[a][j].data(), bend[a][j][k], p.row[k]);
                if (k > 2) filter::add<N>(spread[a][k].data(), bend[a][j][k], p.row[j]);
            }
    for (std::size_t a = 0; a < given.size; ++a) {
        for (std::size_t k = 0; k < N; ++k) given.residual[a] -= 0.5 * spread[a][k][k];
        for (std::size_t b = 0; b <= a; ++b) {
            double sum = 0.0;
            for (std::size_t i = 0; i < N; ++i)
                for (std::size_t k = 0; k < N; ++k) sum += spread[a][i][k] * spread[b][k][i];
            given.noise[a][b] += 0.5 * sum;
            if (b < a) given.noise[b][a] += 0.5 * sum;
        }
    }
}

// Errors of turn, position and velocity about a state, as errors about the state that a step led
// to: the group's right Jacobian, Σ (-ad)ᵏ / (k + 1)!, of which so many terms are enough for π.
constexpr int jacobian_terms = 24;
using Rebased = std::array<std::array<double, gyro>, gyro>;

inline Rebased rebased_by(const double *step) {
    Rebased ad = {}, power = {}, made = {};
    for (std::size_t row = 0; row < gyro; row += 3)
        for (const std::size_t column : {std::size_t{0}, row}) {
            const double *x = step + row - column;
            for (std::size_t i = 0; i < 3; ++i) {
                const std::size_t u = (i + 1) % 3, v = (i + 2) % 3;
                ad[row + u][column + v] = -x[i];
                ad[row + v][column + u] = x[i];
            }
        }
    for (std::size_t i = 0; i < gyro; ++i) power[i][i] = made[i][i] = 1.0;
    for (int k = 1; k < jacobian_terms; ++k) {
        Rebased next = {};
        for (std::size_t i = 0; i < gyro; ++i)
            for (std::size_t m = 0; m < gyro; ++m)
                for (std::size_t j = 0; j < gyro; ++j)
                    next[i][j] -= power[i][m] * ad[m][j] / (k + 1);
        power = next;
        for (std::size_t i = 0; i < gyro; ++i)
            for (std::size_t j = 0; j < gyro; ++j) made[i][j] += power[i][j];
    }
    return made;
}

// P becomes G P G'; with a transposed G what is said of the errors after the step, a curvature, is
// said of those before it.
template <std::size_t N> void congruent(Matrix<N> &p, const Rebased &by) {
    Matrix<N> half = p;
    for (std::size_t i = 0; i < gyro; ++i) {
        std::fill_n(half.row[i], N, 0.0);
        for (std::size_t m = 0; m < gyro; ++m) filter::add<N>(half.row[i], by[i][m], p.row[m]);
    }
    p = half;
    for (std::size_t i = 0; i < N; ++i)
        for (std::size_t j = 0; j < gyro; ++j) {
            p.row[i][j] = 0.0;
            for (std::size_t m = 0; m < gyro; ++m) p.row[i][j] += half.row[i][m] * by[j][m];
        }
    symmetrise(p);
}

template <std::size_t N> void rebase(Matrix<N> &p, const double *step) {
    congruent(p, rebased_by(step));
}

template <std::size_t N>
void rebase_back(Matrix<N> &curvature, double *gradient, const double *step) {
    const Rebased by = rebased_by(step);
    Rebased transposed;
    double before[gyro] = {};
    for (std::size_t i = 0; i < gyro; ++i)
        for (std::size_t j = 0; j < gyro; ++j) {
            transposed[j][i] = by[i][j];
            before[j] += by[i][j] * gradient[i];
        }
    std::copy_n(before, gyro, gradient);
    congruent(curvature, transposed);
}

}  // namespace motorcade::filter
