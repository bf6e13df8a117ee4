// Blends poses joint by joint with GLM, the way game engines do, and measures the machine's floors.
//
// usage: glm_blend float|double COUNT SECONDS < poses
// `poses` holds, for each of COUNT joints, two poses as w x y z tx ty tz in float64. Prints one
// JSON object: nanoseconds a joint (median over rounds) and a checksum of the rotation matrices for
// each method, and what copying and multiplying cost on this machine over the same amount of data.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <vector>

#define GLM_ENABLE_EXPERIMENTAL
#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/gtx/dual_quaternion.hpp>
#include <glm/gtx/norm.hpp>  // dual_quaternion.hpp uses it without including it

// The processor's clock: other work on the machine does not count.
struct Clock {
    using duration = std::chrono::nanoseconds;
    static std::chrono::time_point<Clock, duration> now() {
        timespec spent;
        clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &spent);
        return std::chrono::time_point<Clock, duration>(
            duration(1000000000LL * spent.tv_sec + spent.tv_nsec));
    }
};

template <class T> struct Joint {
    glm::qua<T> q;
    glm::vec<3, T> t;
};

template <class T> struct Matrix34 { T m[12]; };

// Row-major 3x4 from a rotation and a translation.
template <class T>
inline void store(Matrix34<T> &out, const glm::qua<T> &q, const glm::vec<3, T> &t) {
    const glm::mat<3, 3, T> r = glm::mat3_cast(q);
    for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 3; ++column) out.m[4 * row + column] = r[column][row];
        out.m[4 * row + 3] = t[row];
    }
}

template <class T>
void slerp_mix(const std::vector<Joint<T>> &a, const std::vector<Joint<T>> &b, T f,
               std::vector<Matrix34<T>> &out) {
    for (size_t i = 0; i < a.size(); ++i)
        store(out[i], glm::slerp(a[i].q, b[i].q, f), glm::mix(a[i].t, b[i].t, f));
}

template <class T>
void nlerp_mix(const std::vector<Joint<T>> &a, const std::vector<Joint<T>> &b, T f,
               std::vector<Matrix34<T>> &out) {
    for (size_t i = 0; i < a.size(); ++i) {
        const T sign = glm::dot(a[i].q, b[i].q) < T(0) ? T(-1) : T(1);
        const glm::qua<T> q = glm::normalize(a[i].q * (T(1) - f) + b[i].q * (f * sign));
        store(out[i], q, glm::mix(a[i].t, b[i].t, f));
    }
}

template <class T>
void dual_quaternion(const std::vector<glm::tdualquat<T>> &a,
                     const std::vector<glm::tdualquat<T>> &b, T f, std::vector<Matrix34<T>> &out) {
    for (size_t i = 0; i < a.size(); ++i) {
        const glm::tdualquat<T> d = glm::normalize(glm::lerp(a[i], b[i], f));
        const glm::mat<3, 4, T> m = glm::mat3x4_cast(d);
        for (int row = 0; row < 3; ++row)
            for (int column = 0; column < 4; ++column) out[i].m[4 * row + column] = m[row][column];
    }
}

// Reads two blocks and writes one, as much data as a blend of 8 + 8 into 12 numbers moves.
template <class T>
void move_memory(const std::vector<T> &a, const std::vector<T> &b, std::vector<T> &out) {
    const size_t count = a.size();
    const T *__restrict x = a.data();
    const T *__restrict y = b.data();
    T *__restrict z = out.data();
    for (size_t i = 0; i < count; ++i) z[i] = x[i] + y[i];
    for (size_t i = 0; i < count / 2; ++i) z[count + i] = x[i];
}

template <class T> T multiply_add(T seed, size_t steps) {
    T lane[128];
    for (int k = 0; k < 128; ++k) lane[k] = seed + T(k) * T(1e-3);
    for (size_t i = 0; i < steps; ++i)
        for (int k = 0; k < 128; ++k) lane[k] = lane[k] * T(0.999999) + T(1e-6);
    T sum = 0;
    for (int k = 0; k < 128; ++k) sum += lane[k];
    return sum;
}

// Median nanoseconds a call over rounds that fill `seconds`.
template <class F> double median_ns(F &&call, double seconds) {
    call();
    auto start = Clock::now();
    call();
    const double once = std::chrono::duration<double>(Clock::now() - start).count();
    const size_t inner = std::max<size_t>(1, size_t(seconds / 25.0 / std::max(once, 1e-9)));
    std::vector<double> rounds;
    for (int r = 0; r < 25; ++r) {
        start = Clock::now();
        for (size_t i = 0; i < inner; ++i) call();
        rounds.push_back(std::chrono::duration<double>(Clock::now() - start).count() / inner);
    }
    std::nth_element(rounds.begin(), rounds.begin() + 12, rounds.end());
    return rounds[12] * 1e9;
}

template <class T> double checksum(const std::vector<Matrix34<T>> &out) {
    double sum = 0;
    for (size_t i = 0; i < out.size(); ++i)
        for (int k = 0; k < 12; ++k)
            if (k % 4 != 3) sum += double(out[i].m[k]) * double(1 + k);
    return sum;
}

template <class T> int run(size_t count, double seconds) {
    std::vector<double> raw(count * 14);
    if (std::fread(raw.data(), sizeof(double), raw.size(), stdin) != raw.size()) return 1;
    std::vector<Joint<T>> a(count), b(count);
    std::vector<glm::tdualquat<T>> da(count), db(count);
    for (size_t i = 0; i < count; ++i) {
        for (int side = 0; side < 2; ++side) {
            const double *p = raw.data() + 14 * i + 7 * side;
            Joint<T> &joint = side ? b[i] : a[i];
            joint.q = glm::qua<T>(T(p[0]), T(p[1]), T(p[2]), T(p[3]));
            joint.t = glm::vec<3, T>(T(p[4]), T(p[5]), T(p[6]));
            (side ? db[i] : da[i]) = glm::tdualquat<T>(joint.q, joint.t);
        }
    }
    std::vector<Matrix34<T>> out(count);
    const T f = T(0.3);
    const double slerp_ns = median_ns([&] { slerp_mix(a, b, f, out); }, seconds);
    const double slerp_sum = checksum(out);
    const double nlerp_ns = median_ns([&] { nlerp_mix(a, b, f, out); }, seconds);
    const double nlerp_sum = checksum(out);
    const double dual_ns = median_ns([&] { dual_quaternion(da, db, f, out); }, seconds);
    const double dual_sum = checksum(out);
    std::vector<T> x(count * 8, T(1)), y(count * 8, T(2)), z(count * 12);
    const double memory_ns = median_ns([&] { move_memory(x, y, z); }, seconds);
    volatile T sink = 0;
    const double arithmetic_ns =
        median_ns([&] { sink = multiply_add(T(1e-6) * sink, 1000); }, seconds);
    const double n = double(count);
    std::printf("{\"slerp_mix\": {\"ns\": %.6g, \"checksum\": %.17g}, "
                "\"nlerp_mix\": {\"ns\": %.6g, \"checksum\": %.17g}, "
                "\"dual_quaternion\": {\"ns\": %.6g, \"checksum\": %.17g}, "
                "\"memory_floor\": {\"ns\": %.6g}, \"gflops\": %.6g}\n",
                slerp_ns / n, slerp_sum, nlerp_ns / n, nlerp_sum, dual_ns / n, dual_sum,
                memory_ns / n, 2.0 * 128.0 * 1000.0 / arithmetic_ns);
    return 0;
}

int main(int argc, char **argv) {
    if (argc != 4) return 2;
    const size_t count = std::strtoul(argv[2], nullptr, 10);
    const double seconds = std::strtod(argv[3], nullptr);
    return std::strcmp(argv[1], "float") == 0 ? run<float>(count, seconds)
                                              : run<double>(count, seconds);
}
