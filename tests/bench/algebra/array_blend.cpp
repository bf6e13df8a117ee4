// Blends poses as quaternions and translations, kept in arrays of one component each.
//
// usage: array_blend float|double COUNT SECONDS < poses
// Input and output as of glm_blend.cpp: the same methods as GLM's there, written for the layout
// that the motors' kernels have, so that nothing but the representation differs. Processor time.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <vector>

template <class T> struct Arrays {
    std::vector<T> numbers;
    size_t count;
    Arrays(size_t width, size_t joints) : numbers(width * joints), count(joints) {}
    T *at(size_t component) { return numbers.data() + component * count; }
};

// With SLERP the weights turn at constant speed; without, the blend is divided by its norm.
template <class T, bool SLERP>
__attribute__((noinline)) void blend(Arrays<T> &a, Arrays<T> &b, T f, Arrays<T> &out) {
    const T *__restrict aw = a.at(0), *__restrict ax = a.at(1), *__restrict ay = a.at(2),
                        *__restrict az = a.at(3), *__restrict atx = a.at(4),
                        *__restrict aty = a.at(5), *__restrict atz = a.at(6);
    const T *__restrict bw = b.at(0), *__restrict bx = b.at(1), *__restrict by = b.at(2),
                        *__restrict bz = b.at(3), *__restrict btx = b.at(4),
                        *__restrict bty = b.at(5), *__restrict btz = b.at(6);
    T *__restrict m = out.numbers.data();
    const size_t n = a.count;
#pragma GCC ivdep
    for (size_t i = 0; i < n; ++i) {
        const T cosine = aw[i] * bw[i] + ax[i] * bx[i] + ay[i] * by[i] + az[i] * bz[i];
        const T sign = cosine < T(0) ? T(-1) : T(1);
        T u = T(1) - f, v = f * sign;
        if (SLERP) {
            const T angle = std::acos(std::min(cosine * sign, T(1) - T(1e-6)));
            const T scale = T(1) / std::sin(angle);
            u = std::sin((T(1) - f) * angle) * scale;
            v = std::sin(f * angle) * scale * sign;
        }
        T w = u * aw[i] + v * bw[i], x = u * ax[i] + v * bx[i], y = u * ay[i] + v * by[i],
          z = u * az[i] + v * bz[i];
        const T scale = SLERP ? T(1) : T(1) / std::sqrt(w * w + x * x + y * y + z * z);
        w *= scale, x *= scale, y *= scale, z *= scale;
        m[i] = T(1) - T(2) * (y * y + z * z);
        m[n + i] = T(2) * (x * y - w * z);
        m[2 * n + i] = T(2) * (x * z + w * y);
        m[3 * n + i] = (T(1) - f) * atx[i] + f * btx[i];
        m[4 * n + i] = T(2) * (x * y + w * z);
        m[5 * n + i] = T(1) - T(2) * (x * x + z * z);
        m[6 * n + i] = T(2) * (y * z - w * x);
        m[7 * n + i] = (T(1) - f) * aty[i] + f * bty[i];
        m[8 * n + i] = T(2) * (x * z - w * y);
        m[9 * n + i] = T(2) * (y * z + w * x);
        m[10 * n + i] = T(1) - T(2) * (x * x + y * y);
        m[11 * n + i] = (T(1) - f) * atz[i] + f * btz[i];
    }
}

double processor_seconds() {
    timespec now;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return double(now.tv_sec) + 1e-9 * double(now.tv_nsec);
}

// Median nanoseconds a call over rounds that fill `seconds`.
template <class F> double median_ns(F &&call, double seconds) {
    call();
    double start = processor_seconds();
    call();
    const double single = processor_seconds() - start;
    const size_t inner = std::max<size_t>(1, size_t(seconds / 25.0 / std::max(single, 1e-9)));
    std::vector<double> rounds;
    for (int r = 0; r < 25; ++r) {
        start = processor_seconds();
        for (size_t i = 0; i < inner; ++i) call();
        rounds.push_back((processor_seconds() - start) / double(inner));
    }
    std::nth_element(rounds.begin(), rounds.begin() + 12, rounds.end());
    return rounds[12] * 1e9;
}

template <class T> double checksum(Arrays<T> &out) {
    double sum = 0;
    for (int k = 0; k < 12; ++k)
        for (size_t i = 0; k % 4 != 3 && i < out.count; ++i)
            sum += double(out.at(size_t(k))[i]) * double(1 + k);
    return sum;
}

template <class T> int run(size_t count, double seconds) {
    std::vector<double> raw(count * 14);
    if (std::fread(raw.data(), sizeof(double), raw.size(), stdin) != raw.size()) return 1;
    Arrays<T> a(7, count), b(7, count), out(12, count);
    for (size_t i = 0; i < count; ++i)
        for (size_t k = 0; k < 7; ++k) {
            a.at(k)[i] = T(raw[14 * i + k]);
            b.at(k)[i] = T(raw[14 * i + 7 + k]);
        }
    const T f = T(0.3);
    const double n = double(count);
    const double slerp = median_ns([&] { blend<T, true>(a, b, f, out); }, seconds);
    const double slerp_sum = checksum(out);
    const double nlerp = median_ns([&] { blend<T, false>(a, b, f, out); }, seconds);
    std::printf("{\"slerp_arrays\": {\"ns\": %.6g, \"checksum\": %.17g}, "
                "\"nlerp_arrays\": {\"ns\": %.6g, \"checksum\": %.17g}}\n",
                slerp / n, slerp_sum, nlerp / n, checksum(out));
    return 0;
}

int main(int argc, char **argv) {
    if (argc != 4) return 2;
    const size_t count = std::strtoul(argv[2], nullptr, 10);
    const double seconds = std::strtod(argv[3], nullptr);
    return std::strcmp(argv[1], "float") == 0 ? run<float>(count, seconds)
                                              : run<double>(count, seconds);
}
