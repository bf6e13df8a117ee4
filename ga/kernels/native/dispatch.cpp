// Kernels want each component contiguous, in whole blocks of rows. Operands that lie so are used in
// place; others are gathered into a buffer that stays in the cache, tile by tile. The rows that are
// left over at the end of a batch go through the buffer too, so every row is computed by the same
// instructions wherever it stands.

#include "dispatch.h"

#include <algorithm>
#include <atomic>
#include <thread>
#include <vector>

#include "transpose.h"

namespace motorcade {
namespace {

constexpr std::size_t LANES = MOTORCADE_LANES;
constexpr std::size_t BUFFER = 4608;       // numbers; no more than the first-level cache holds
constexpr std::size_t PER_THREAD = 32768;  // rows that are worth a thread
constexpr std::size_t CHECKED = 512;       // rows that are still in the cache when they are used

template <typename Real> using Entry = void (*)(MOTORCADE_ARGUMENTS(Real));

template <typename Real> Entry<Real> entry(const motorcade_kernel &kernel);
template <> Entry<float> entry<float>(const motorcade_kernel &kernel) { return kernel.single; }
template <> Entry<double> entry<double>(const motorcade_kernel &kernel) { return kernel.real; }

// Whether all rows are finite, true where that is not asked.
template <typename Real>
bool gather(const Rows &from, std::size_t start, std::size_t count, std::size_t width, Real *to,
            std::size_t step, bool checked) {
    const char *row = from.first + static_cast<std::ptrdiff_t>(start) * from.row_stride;
    constexpr std::ptrdiff_t size = sizeof(Real);
    const bool by_rows = from.component_stride == size && from.row_stride % size == 0;
    bool finite = true;
    if (by_rows)
        finite = split_rows(reinterpret_cast<const Real *>(row), from.row_stride / size, count,
                            width, to, step, checked);
    for (std::size_t j = 0; j < width; ++j) {
        const char *at = row + static_cast<std::ptrdiff_t>(j) * from.component_stride;
        for (std::size_t i = 0; i < count && !by_rows; ++i, at += from.row_stride)
            to[j * step + i] = *reinterpret_cast<const Real *>(at);
        if (checked && !by_rows) finite &= all_finite(to + j * step, count);
        // The rest of the last block repeats a number that is harmless to compute with.
        for (std::size_t i = count; i % LANES; ++i) to[j * step + i] = to[j * step];
    }
    return finite;
}

template <typename Real>
void scatter(const Real *from, std::size_t step, const Rows &to, std::size_t start,
             std::size_t count, std::size_t width) {
    char *row = to.first + static_cast<std::ptrdiff_t>(start) * to.row_stride;
    for (std::size_t j = 0; j < width; ++j) {
        char *at = row + static_cast<std::ptrdiff_t>(j) * to.component_stride;
        for (std::size_t i = 0; i < count; ++i, at += to.row_stride)
            *reinterpret_cast<Real *>(at) = from[j * step + i];
    }
}

// One segment of rows, of which all operands marked direct are used in place.
template <typename Real> struct Segment {
    const motorcade_kernel &kernel;
    const Rows *operands;
    bool checked;
    bool direct[MOTORCADE_OPERANDS];

    std::size_t width(int k) const { return static_cast<std::size_t>(kernel.widths[k]); }

    // Whether all inputs were finite, true where that is not asked.
    bool run(std::size_t start, std::size_t end) const {
        alignas(64) Real buffer[BUFFER];
        const int inputs = kernel.inputs, all = inputs + kernel.outputs;
        std::size_t buffered = 0;
        for (int k = 0; k < all; ++k) buffered += direct[k] ? 0 : width(k);
        std::size_t most = buffered ? BUFFER / buffered / LANES * LANES : end - start;
        if (checked) most = std::min(most, CHECKED);
        const std::size_t tile = std::min(most, (end - start + LANES - 1) / LANES * LANES);
        Real *at[MOTORCADE_OPERANDS];
        std::ptrdiff_t steps[MOTORCADE_OPERANDS];
        Real *next = buffer;
        bool finite = true;
        for (int k = 0; k < all; ++k) {
            if (direct[k]) {
                steps[k] = operands[k].component_stride / static_cast<std::ptrdiff_t>(sizeof(Real));
                continue;
            }
            at[k] = next;
            steps[k] = static_cast<std::ptrdiff_t>(tile);
            next += width(k) * tile;
            if (k < inputs && operands[k].count == 1) finite &= repeat(k, at[k], tile);
        }
        for (std::size_t from = start; from < end; from += tile)
            finite &= one_tile(from, std::min(tile, end - from), tile, at, steps);
        return finite;
    }

    bool repeat(int k, Real *to, std::size_t tile) const {
        bool finite = true;
        for (std::size_t j = 0; j < width(k); ++j) {
            const Real number = *reinterpret_cast<const Real *>(
                operands[k].first + static_cast<std::ptrdiff_t>(j) * operands[k].component_stride);
            std::fill_n(to + j * tile, tile, number);
            finite = finite && Real(0) * number == Real(0);
        }
        return finite;
    }

    bool one_tile(std::size_t from, std::size_t count, std::size_t tile, Real **at,
                  const std::ptrdiff_t *steps) const {
        const int inputs = kernel.inputs, all = inputs + kernel.outputs;
        bool finite = true;
        for (int k = 0; k < all; ++k) {
            const bool one_for_all = k < inputs && operands[k].count == 1;
            if (!direct[k]) {
                if (k < inputs && !one_for_all)
                    finite &= gather(operands[k], from, count, width(k), at[k], tile, checked);
                continue;
            }
            at[k] = reinterpret_cast<Real *>(operands[k].first) + from;
            for (std::size_t j = 0; checked && k < inputs && j < width(k); ++j)
                finite &= all_finite(at[k] + static_cast<std::ptrdiff_t>(j) * steps[k], count);
        }
        entry<Real>(kernel)(at, steps, at + inputs, steps + inputs, (count + LANES - 1) / LANES);
        for (int k = inputs; k < all; ++k)
            if (!direct[k]) scatter(at[k], tile, operands[k], from, count, width(k));
        return finite;
    }
};

template <typename Real>
bool run_range(const motorcade_kernel &kernel, const Rows *operands, bool checked,
               std::size_t start, std::size_t end) {
    Segment<Real> whole{kernel, operands, checked, {}}, rest{kernel, operands, checked, {}};
    const std::size_t padded = (end + LANES - 1) / LANES * LANES;
    bool all_padded = true;
    for (int k = 0; k < kernel.inputs + kernel.outputs; ++k) {
        const bool contiguous = operands[k].row_stride == sizeof(Real) &&
                                operands[k].component_stride % sizeof(Real) == 0;
        const bool one_for_all = k < kernel.inputs && operands[k].count == 1;
        whole.direct[k] = contiguous && !one_for_all;
        rest.direct[k] = whole.direct[k] && operands[k].readable >= padded;
        all_padded = all_padded && (rest.direct[k] || !whole.direct[k]);
    }
    const std::size_t middle = all_padded ? end : start + (end - start) / LANES * LANES;
    bool finite = true;
    if (middle > start) finite &= whole.run(start, middle);
    if (end > middle) finite &= rest.run(middle, end);
    return finite;
}

template <typename Real>
bool run_all(const motorcade_kernel &kernel, const Rows *operands, bool checked, unsigned threads) {
    const std::size_t count = operands[kernel.inputs].count;
    const std::size_t shares = std::min<std::size_t>(threads, count / PER_THREAD);
    if (shares < 2) return run_range<Real>(kernel, operands, checked, 0, count);
    const std::size_t share = (count / shares + LANES) / LANES * LANES;
    std::atomic<bool> finite{true};
    const auto part = [&](std::size_t start, std::size_t end) {
        if (!run_range<Real>(kernel, operands, checked, start, end)) finite = false;
    };
    std::vector<std::thread> others;
    for (std::size_t start = share; start < count; start += share)
        others.emplace_back(part, start, std::min(start + share, count));
    part(0, std::min(share, count));
    for (std::thread &other : others) other.join();
    return finite;
}

}  // namespace

bool run(const motorcade_kernel &kernel, const Rows *operands, bool single, bool checked,
         unsigned threads) {
    if (operands[kernel.inputs].count == 0) return true;
    return single ? run_all<float>(kernel, operands, checked, threads)
                  : run_all<double>(kernel, operands, checked, threads);
}

}  // namespace motorcade
