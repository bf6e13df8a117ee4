// The transitions' products, compiled for the processors that x86 has; the loader picks.

#include "covariance.h"

#if defined(__GNUC__) && !defined(__clang__) && defined(__x86_64__) && defined(__gnu_linux__)
#define MOTORCADE_CLONES __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#else
#define MOTORCADE_CLONES
#endif

// A clone's loops are only as wide as the clone where they are part of it.
#if defined(__GNUC__)
#define MOTORCADE_INLINE inline __attribute__((always_inline))
#else
#define MOTORCADE_INLINE inline
#endif

namespace motorcade::filter {

namespace {

// Four numbers of a row at once, whatever the processor makes of them.
typedef double Quad __attribute__((vector_size(32), may_alias));

MOTORCADE_INLINE Quad quad(const double *row, std::size_t q) { return *reinterpret_cast<const Quad *>(row + 4 * q); }
MOTORCADE_INLINE void put(double *row, std::size_t q, Quad value) { *reinterpret_cast<Quad *>(row + 4 * q) = value; }

// A row, or a column, of a block times three rows.
MOTORCADE_INLINE Quad row_of(const double *block, std::size_t i, const Quad *x) {
    return block[3 * i] * x[0] + block[3 * i + 1] * x[1] + block[3 * i + 2] * x[2];
}
MOTORCADE_INLINE Quad column_of(const double *block, std::size_t i, const Quad *x) {
    return block[i] * x[0] + block[3 + i] * x[1] + block[6 + i] * x[2];
}

// The first nine rows of F X; the others are those of X.
template <bool tilted, std::size_t W>
MOTORCADE_INLINE void carried(const Transition &f, const double (*x)[W], double (*made)[W]) {
    for (std::size_t q = 0; q < W / 4; ++q) {
        Quad turned[3], moved[3], faster[3], by_gyro[3], by_accel[3];
        for (std::size_t i = 0; i < 3; ++i) {
            turned[i] = quad(x[turn + i], q);
            faster[i] = quad(x[velocity + i], q);
            moved[i] = quad(x[position + i], q) + f.dt * faster[i];
            by_gyro[i] = quad(x[gyro + i], q);
            by_accel[i] = quad(x[accel + i], q);
        }
        for (std::size_t i = 0; i < 3; ++i) {
            put(made[turn + i], q, row_of(f.turn_turn, i, turned) + row_of(f.turn_gyro, i, by_gyro));
            Quad place = row_of(f.position_turn, i, turned) + row_of(f.turn_turn, i, moved) +
                         row_of(f.position_gyro, i, by_gyro) + row_of(f.position_accel, i, by_accel);
            Quad speed = row_of(f.velocity_turn, i, turned) + row_of(f.turn_turn, i, faster) +
                         row_of(f.velocity_gyro, i, by_gyro) + row_of(f.velocity_accel, i, by_accel);
            if constexpr (tilted) {
                const double *leaning = f.velocity_tilt + 2 * i;
                const Quad fall = leaning[0] * quad(x[tilt], q) + leaning[1] * quad(x[tilt + 1], q);
                place += 0.5 * f.dt * fall;
                speed += fall;
            }
            put(made[position + i], q, place);
            put(made[velocity + i], q, speed);
        }
    }
}

// F' X.
template <std::size_t N, std::size_t W>
MOTORCADE_INLINE void carried_back(const Transition &f, const double (*x)[W], double (*made)[W]) {
    for (std::size_t q = 0; q < W / 4; ++q) {
        Quad turned[3], moved[3], faster[3];
        for (std::size_t i = 0; i < 3; ++i) {
            turned[i] = quad(x[turn + i], q);
            moved[i] = quad(x[position + i], q);
            faster[i] = quad(x[velocity + i], q);
        }
        for (std::size_t i = 0; i < 3; ++i) {
            const Quad place = column_of(f.turn_turn, i, moved);
            put(made[turn + i], q, column_of(f.turn_turn, i, turned) + column_of(f.position_turn, i, moved) +
                                       column_of(f.velocity_turn, i, faster));
            put(made[position + i], q, place);
            put(made[velocity + i], q, column_of(f.turn_turn, i, faster) + f.dt * place);
            put(made[gyro + i], q, quad(x[gyro + i], q) + column_of(f.turn_gyro, i, turned) +
                                       column_of(f.position_gyro, i, moved) + column_of(f.velocity_gyro, i, faster));
            put(made[accel + i], q, quad(x[accel + i], q) + column_of(f.position_accel, i, moved) +
                                        column_of(f.velocity_accel, i, faster));
        }
        for (std::size_t k = 15; k < N; ++k) put(made[k], q, quad(x[k], q));
        if constexpr (N > 15)
            for (std::size_t k = 0; k < 2; ++k) {
                Quad sum = quad(x[tilt + k], q);
                for (std::size_t i = 0; i < 3; ++i)
                    sum += f.velocity_tilt[2 * i + k] * (faster[i] + 0.5 * f.dt * moved[i]);
                put(made[tilt + k], q, sum);
            }
    }
}

// P becomes F P F' + Q.
template <std::size_t N> MOTORCADE_INLINE void propagated(Matrix<N> &p, const Transition &f, const Densities &q) {
    constexpr std::size_t W = Matrix<N>::width, half = 12;
    constexpr bool tilted = N > 15;
    alignas(64) double top[9][W];
    alignas(64) double across[N][half];
    alignas(64) double corner[9][half];
    carried<tilted, W>(f, p.row, top);
    for (std::size_t k = 0; k < N; ++k) {
        for (std::size_t i = 0; i < 9; ++i) across[k][i] = top[i][k];
        for (std::size_t i = 9; i < half; ++i) across[k][i] = 0.0;
    }
    carried<tilted, half>(f, across, corner);
    for (std::size_t i = 0; i < 9; ++i) {
        for (std::size_t j = 0; j <= i; ++j) p.row[i][j] = p.row[j][i] = corner[i][j];
        for (std::size_t j = 9; j < N; ++j) p.row[i][j] = p.row[j][i] = top[i][j];
    }
    const double dt = f.dt;
    for (std::size_t i = 0; i < 3; ++i) {
        p.row[turn + i][turn + i] += q.rate * dt;
        p.row[velocity + i][velocity + i] += q.force * dt;
        p.row[position + i][position + i] += q.force * dt * dt * dt / 3.0;
        p.row[position + i][velocity + i] += q.force * dt * dt / 2.0;
        p.row[velocity + i][position + i] += q.force * dt * dt / 2.0;
        p.row[gyro + i][gyro + i] += q.gyro_walk * dt;
        p.row[accel + i][accel + i] += q.accel_walk * dt;
    }
}

template <std::size_t N>
MOTORCADE_INLINE void propagated_back(Matrix<N> &curvature, double *gradient, const Transition &f) {
    Matrix<N> once, across;
    alignas(64) double row[N][4] = {}, moved[N][4];
    carried_back<N, Matrix<N>::width>(f, curvature.row, once.row);
    transpose<N>(once.row, across.row);
    carried_back<N, Matrix<N>::width>(f, across.row, curvature.row);
    for (std::size_t i = 0; i < N; ++i) row[i][0] = gradient[i];
    carried_back<N, 4>(f, row, moved);
    for (std::size_t i = 0; i < N; ++i) gradient[i] = moved[i][0];
}

}  // namespace

MOTORCADE_CLONES void propagate(Matrix<15> &p, const Transition &f, const Densities &q) { propagated<15>(p, f, q); }
MOTORCADE_CLONES void propagate(Matrix<24> &p, const Transition &f, const Densities &q) { propagated<24>(p, f, q); }
MOTORCADE_CLONES void propagate_back(Matrix<15> &curvature, double *gradient, const Transition &f) {
    propagated_back<15>(curvature, gradient, f);
}
MOTORCADE_CLONES void propagate_back(Matrix<24> &curvature, double *gradient, const Transition &f) {
    propagated_back<24>(curvature, gradient, f);
}

}  // namespace motorcade::filter
