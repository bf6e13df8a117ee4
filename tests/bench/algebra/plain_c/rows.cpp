// Loops over packed and padded arrays, one call a row: our generated C beside what others write.
//
// KERNELS is the file of our functions in the type REAL; peers are measured whose headers are
// found, and each is held against ours before it is timed. Prints a line of JSON.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#define restrict __restrict
#define _Bool bool
extern "C" {
#include KERNELS
}

#if __has_include(<glm/gtc/quaternion.hpp>)
#define GLM_ENABLE_EXPERIMENTAL
#include <glm/glm.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/gtx/dual_quaternion.hpp>
#define HAS_GLM 1
#endif
#if __has_include(<Eigen/Geometry>)
#include <Eigen/Geometry>
#define HAS_EIGEN 1
#endif
#if __has_include(<klein/klein.hpp>) && defined(SINGLE)
#include <klein/klein.hpp>
#define HAS_KLEIN 1
#endif
#if __has_include(<vsr/space/vsr_cga3D_types.h>)
#include <vsr/space/vsr_cga3D_op.h>
#include <vsr/space/vsr_cga3D_types.h>
#define HAS_VERSOR 1
#endif
#ifdef GAALOP
extern "C" {
#include GAALOP
}
#endif

enum { COUNT = 1000, REPEATS = 200, CALLS = 5 };
REAL stored_a[COUNT * 8], stored_b[COUNT * 8], stored_out[COUNT * 8];
static bool first = true;

static double now_ns() {
    timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return 1e9 * double(t.tv_sec) + double(t.tv_nsec);
}

// The least of many runs: what others on the machine take is no part of it.
template <class Loop> static double least_ns(Loop loop) {
    double least = 1e30;
    for (int k = 0; k < REPEATS; ++k) {
        const double start = now_ns();
        for (int j = 0; j < CALLS; ++j) {
            loop();
            asm volatile("" ::: "memory");
        }
        const double spent = (now_ns() - start) / (COUNT * CALLS);
        least = spent < least ? spent : least;
    }
    return least;
}

static void say(const char *row, const char *who, double ns) {
    std::printf("%s\n  [\"%s\", \"%s\", %.3f]", first ? "" : ",", row, who, ns);
    first = false;
}

static double random_number() { return 2.0 * drand48() - 1.0; }

// Unit motors on 1, e23, e31, e12, e1i, e2i, e3i, e123i.
static void fill_motors(REAL *rows) {
    for (int i = 0; i < COUNT; ++i) {
        double q[4], t[3], size = 0;
        for (double &x : q) size += (x = random_number()) * x;
        for (double &x : q) x /= std::sqrt(size);
        for (double &x : t) x = 0.5 * random_number();
        REAL *m = rows + 8 * i;
        for (int k = 0; k < 4; ++k) m[k] = REAL(q[k]);
        // T R with T = 1 - t/2 einf
        m[4] = REAL(-(t[0] * q[0] + t[1] * q[3] - t[2] * q[2]));
        m[5] = REAL(-(t[1] * q[0] + t[2] * q[1] - t[0] * q[3]));
        m[6] = REAL(-(t[2] * q[0] + t[0] * q[2] - t[1] * q[1]));
        m[7] = REAL(-(t[0] * q[1] + t[1] * q[2] + t[2] * q[3]));
    }
}

#define A8(a) a[0], a[1], a[2], a[3], a[4], a[5], a[6], a[7]
#define A6(a) a[0], a[1], a[2], a[3], a[4], a[5]
#define A4(a) a[0], a[1], a[2], a[3]
#define A3(a) a[0], a[1], a[2]
#define LOOP(STRIDE_A, STRIDE_B, STRIDE_OUT, CALL)                                                 \
    [] {                                                                                           \
        for (int i = 0; i < COUNT; ++i) {                                                          \
            const REAL *a = stored_a + (STRIDE_A)*i;                                               \
            const REAL *b = stored_b + (STRIDE_B)*i;                                               \
            REAL *out = stored_out + (STRIDE_OUT)*i;                                               \
            (void)a, (void)b;                                                                      \
            CALL;                                                                                  \
        }                                                                                          \
    }

static void measure_ours(const char *who) {
    say("composition", who, least_ns(LOOP(8, 8, 8, compose(A8(a), A8(b), out))));
    say("inversion", who, least_ns(LOOP(8, 8, 8, inverse(A8(a), out))));
    say("point", who, least_ns(LOOP(8, 3, 3, point(A8(a), A3(b), out))));
    say("plane", who, least_ns(LOOP(8, 4, 4, plane(A8(a), A4(b), out))));
    say("line", who, least_ns(LOOP(8, 6, 6, line(A8(a), A6(b), out))));
    say("line, padded", who, least_ns(LOOP(8, 8, 8, line(A8(a), A6(b), out))));
    say("line through two points", who, least_ns(LOOP(8, 6, 6, join(A8(a), A6(b), out))));
    say("line through two points, padded", who, least_ns(LOOP(8, 8, 8, join(A8(a), A6(b), out))));
    say("log", who, least_ns(LOOP(8, 8, 6, logarithm(A8(a), out))));
    say("exp", who, least_ns(LOOP(6, 8, 8, exponential(A6(a), out))));
    say("log/exp interpolation", who,
        least_ns(LOOP(8, 8, 8, interpolate(A8(a), A8(b), REAL(0.3), out))));
    say("linear blend", who, least_ns(LOOP(8, 8, 8, blend(A8(a), A8(b), REAL(0.3), out))));
}

#ifdef GAALOP
#define GAALOP_ROW(ROW, LOOP_) say(ROW, "Gaalop", least_ns(LOOP_))
static void measure_gaalop() {
    GAALOP_ROW("composition", LOOP(8, 8, 8, gaalop_compose(A8(a), A8(b), out)));
    GAALOP_ROW("plane", LOOP(8, 4, 4, gaalop_plane(A8(a), A4(b), out)));
}
#endif

#ifdef HAS_GLM
using Quaternion = glm::qua<REAL>;
using Dual = glm::tdualquat<REAL>;
using Vector = glm::vec<3, REAL>;
using Matrix = glm::mat<4, 4, REAL>;
Dual dual_a[COUNT], dual_b[COUNT], dual_out[COUNT];
Matrix matrix_a[COUNT], matrix_b[COUNT], matrix_out[COUNT];
Vector vector_b[COUNT], vector_out[COUNT];
static void measure_glm() {
    for (int i = 0; i < COUNT; ++i) {
        const REAL *rows[2] = {stored_a + 8 * i, stored_b + 8 * i};
        for (int k = 0; k < 2; ++k) {
            const Quaternion q(rows[k][0], rows[k][1], rows[k][2], rows[k][3]);
            const Vector t(rows[k][4], rows[k][5], rows[k][6]);
            (k ? dual_b : dual_a)[i] = Dual(q, t);
            (k ? matrix_b : matrix_a)[i] = glm::translate(Matrix(1), t) * glm::mat4_cast(q);
        }
        vector_b[i] = Vector(rows[1][0], rows[1][1], rows[1][2]);
    }
    say("composition", "GLM, dual quaternions", least_ns([] {
            for (int i = 0; i < COUNT; ++i) dual_out[i] = dual_a[i] * dual_b[i];
        }));
    say("composition", "GLM, matrices", least_ns([] {
            for (int i = 0; i < COUNT; ++i) matrix_out[i] = matrix_a[i] * matrix_b[i];
        }));
    say("inversion", "GLM, dual quaternions", least_ns([] {
            for (int i = 0; i < COUNT; ++i) dual_out[i] = glm::inverse(dual_a[i]);
        }));
    say("point", "GLM, dual quaternions", least_ns([] {
            for (int i = 0; i < COUNT; ++i) vector_out[i] = dual_a[i] * vector_b[i];
        }));
    say("linear blend", "GLM, dual quaternions", least_ns([] {
            for (int i = 0; i < COUNT; ++i)
                dual_out[i] = glm::normalize(glm::lerp(dual_a[i], dual_b[i], REAL(0.3)));
        }));
    say("log/exp interpolation", "GLM, slerp and mix", least_ns([] {
            for (int i = 0; i < COUNT; ++i) {
                dual_out[i].real = glm::slerp(dual_a[i].real, dual_b[i].real, REAL(0.3));
                vector_out[i] = glm::mix(vector_b[i], vector_out[i], REAL(0.3));
            }
        }));
}
#endif

#ifdef HAS_EIGEN
using Isometry = Eigen::Transform<REAL, 3, Eigen::Isometry>;
Isometry isometry_a[COUNT], isometry_b[COUNT], isometry_out[COUNT];
Eigen::Matrix<REAL, 3, 1> place_b[COUNT], place_out[COUNT];
static void measure_eigen() {
    for (int i = 0; i < COUNT; ++i) {
        const REAL *rows[2] = {stored_a + 8 * i, stored_b + 8 * i};
        for (int k = 0; k < 2; ++k) {
            Isometry &pose = (k ? isometry_b : isometry_a)[i];
            pose = Eigen::Translation<REAL, 3>(rows[k][4], rows[k][5], rows[k][6]) *
                   Eigen::Quaternion<REAL>(rows[k][0], rows[k][1], rows[k][2], rows[k][3]);
        }
        place_b[i] << rows[1][0], rows[1][1], rows[1][2];
    }
    say("composition", "Eigen", least_ns([] {
            for (int i = 0; i < COUNT; ++i) isometry_out[i] = isometry_a[i] * isometry_b[i];
        }));
    say("inversion", "Eigen", least_ns([] {
            for (int i = 0; i < COUNT; ++i) isometry_out[i] = isometry_a[i].inverse();
        }));
    say("point", "Eigen", least_ns([] {
            for (int i = 0; i < COUNT; ++i) place_out[i] = isometry_a[i] * place_b[i];
        }));
}
#endif

#ifdef HAS_KLEIN
kln::motor klein_a[COUNT], klein_b[COUNT], klein_out[COUNT];
kln::point klein_points[COUNT], klein_moved[COUNT];
kln::plane klein_planes[COUNT], klein_turned[COUNT];
kln::line klein_lines[COUNT], klein_carried[COUNT];
static void measure_klein() {
    for (int i = 0; i < COUNT; ++i) {
        float rows[2][8];
        for (int k = 0; k < 8; ++k)
            rows[0][k] = stored_a[8 * i + k], rows[1][k] = stored_b[8 * i + k];
        const float *a = rows[0];
        const float *b = rows[1];
        klein_a[i] = kln::motor(A8(a));
        klein_b[i] = kln::motor(A8(b));
        klein_a[i].normalize();
        klein_b[i].normalize();
        klein_points[i] = kln::point(A3(b));
        klein_planes[i] = kln::plane(A4(b));
        klein_lines[i] = kln::line(A6(b));
    }
#define KLEIN(ROW, STATEMENT)                                                                      \
    say(ROW, "klein", least_ns([] {                                                                \
            for (int i = 0; i < COUNT; ++i) STATEMENT;                                             \
        }))
    KLEIN("composition", klein_out[i] = klein_a[i] * klein_b[i]);
    KLEIN("inversion", (klein_out[i] = klein_a[i], klein_out[i].invert()));
    KLEIN("point", klein_moved[i] = klein_a[i](klein_points[i]));
    KLEIN("plane", klein_turned[i] = klein_a[i](klein_planes[i]));
    KLEIN("line", klein_carried[i] = klein_a[i](klein_lines[i]));
    KLEIN("line, padded", klein_carried[i] = klein_a[i](klein_lines[i]));
    KLEIN("log", klein_carried[i] = kln::log(klein_a[i]));
    KLEIN("exp", klein_out[i] = kln::exp(klein_lines[i]));
    KLEIN("log/exp interpolation",
          klein_out[i] = klein_a[i] * kln::exp(0.3f * kln::log(~klein_a[i] * klein_b[i])));
}
#endif

#ifdef HAS_VERSOR
using namespace vsr::cga;
Mot versor_a[COUNT], versor_b[COUNT], versor_out[COUNT];
Pnt versor_points[COUNT], versor_moved[COUNT];
Dlp versor_planes[COUNT], versor_turned[COUNT];
Dll versor_lines[COUNT], versor_carried[COUNT];
static void measure_versor() {
    for (int i = 0; i < COUNT; ++i) {
        for (int k = 0; k < 8; ++k) {
            versor_a[i][k] = stored_a[8 * i + k];
            versor_b[i][k] = stored_b[8 * i + k];
        }
        const REAL *b = stored_b + 8 * i;
        versor_points[i] = vsr::nga::Round::null(b[0], b[1], b[2]);
        for (int k = 0; k < 4; ++k) versor_planes[i][k] = b[k];
        for (int k = 0; k < 6; ++k) versor_lines[i][k] = b[k];
    }
#define VERSOR(ROW, STATEMENT)                                                                     \
    say(ROW, "libvsr", least_ns([] {                                                               \
            for (int i = 0; i < COUNT; ++i) STATEMENT;                                             \
        }))
    VERSOR("composition", versor_out[i] = versor_a[i] * versor_b[i]);
    VERSOR("point", versor_moved[i] = versor_points[i].spin(versor_a[i]));
    VERSOR("plane", versor_turned[i] = versor_planes[i].spin(versor_a[i]));
    VERSOR("line", versor_carried[i] = versor_lines[i].spin(versor_a[i]));
    VERSOR("line, padded", versor_carried[i] = versor_lines[i].spin(versor_a[i]));
}
#endif

int main() {
    fill_motors(stored_a);
    fill_motors(stored_b);
    std::printf("[");
    measure_ours("ours");
#ifdef GAALOP
    measure_gaalop();
#endif
#ifdef HAS_GLM
    fill_motors(stored_a);
    fill_motors(stored_b);
    measure_glm();
#endif
#ifdef HAS_EIGEN
    measure_eigen();
#endif
#ifdef HAS_KLEIN
    measure_klein();
#endif
#ifdef HAS_VERSOR
    measure_versor();
#endif
    measure_ours("ours, again");
    std::printf("\n]\n");
}
