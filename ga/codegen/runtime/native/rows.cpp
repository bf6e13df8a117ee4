// Programs want each component contiguous, in whole blocks of rows. What lies so is used in place;
// everything else is gathered into a buffer that stays in the cache, tile by tile, as are the rows
// that are left over at the end.

#include "rows.h"

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <cstring>
#include <thread>

namespace motorcade {
namespace {

constexpr std::size_t BUFFER = 4608;        // numbers; no more than the first-level cache holds
constexpr std::size_t LONGEST_TILE = 1024;  // rows
constexpr std::size_t PER_THREAD = 24576;   // rows that are worth a thread

// Dimensions that all sources step through as through one become one; those of length one go.
void join_dimensions(Shape &shape, std::vector<Source> &sources) {
    int kept = 0;
    for (int d = 0; d < shape.dimensions; ++d) {
        const std::size_t length = shape.lengths[d];
        if (length == 1) continue;
        bool joined = kept > 0;
        for (const Source &source : sources)
            joined = joined &&
                     (!source.first || source.strides[kept - 1] ==
                                           source.strides[d] * static_cast<std::ptrdiff_t>(length));
        if (!joined) ++kept;
        shape.lengths[kept - 1] = joined ? shape.lengths[kept - 1] * length : length;
        for (Source &source : sources) source.strides[kept - 1] = source.strides[d];
    }
    shape.dimensions = kept;
}

bool constant(const Source &source, const Shape &shape) {
    return !source.first ||
           std::all_of(source.strides.begin(), source.strides.begin() + shape.dimensions,
                       [](std::ptrdiff_t stride) { return stride == 0; });
}

template <typename Real> Real first_of(const Source &source) {
    double value = source.number;
    if (source.first && source.single) value = *reinterpret_cast<const float *>(source.first);
    if (source.first && !source.single) value = *reinterpret_cast<const double *>(source.first);
    return static_cast<Real>(source.negative ? -value : value);
}

template <typename From, typename Real>
void copy_line(const char *at, std::ptrdiff_t stride, std::size_t count, Real sign, Real *to) {
    if (stride == sizeof(From)) {
        const From *from = reinterpret_cast<const From *>(at);
        for (std::size_t i = 0; i < count; ++i) to[i] = sign * static_cast<Real>(from[i]);
        return;
    }
    for (std::size_t i = 0; i < count; ++i, at += stride)
        to[i] = sign * static_cast<Real>(*reinterpret_cast<const From *>(at));
}

// Copies rows of one component, wherever they lie; the rest of the last block repeats the first.
template <typename Real>
void gather(const Source &source, const Shape &shape, std::size_t start, std::size_t count,
            Real *to) {
    const int last = shape.dimensions - 1;
    std::array<std::size_t, MOST_DIMENSIONS> at{};
    std::size_t rest = start;
    std::ptrdiff_t offset = 0;
    for (int d = last; d >= 0; --d) {
        at[d] = rest % shape.lengths[d];
        rest /= shape.lengths[d];
        offset += static_cast<std::ptrdiff_t>(at[d]) * source.strides[d];
    }
    const Real sign = source.negative ? -1 : 1;
    for (std::size_t made = 0; made < count;) {
        const std::size_t line = std::min(count - made, shape.lengths[last] - at[last]);
        const char *from = source.first + offset;
        if (source.single)
            copy_line<float>(from, source.strides[last], line, sign, to + made);
        else
            copy_line<double>(from, source.strides[last], line, sign, to + made);
        made += line;
        // On to the next line.
        at[last] += line;
        offset += static_cast<std::ptrdiff_t>(line) * source.strides[last];
        for (int d = last; d > 0 && at[d] == shape.lengths[d]; --d) {
            offset += source.strides[d - 1] -
                      static_cast<std::ptrdiff_t>(shape.lengths[d]) * source.strides[d];
            at[d] = 0;
            ++at[d - 1];
        }
    }
    for (std::size_t i = count; i % BLOCK; ++i) to[i] = to[0];
}

// Copies rows whose components lie beside each other, row by row; to as many columns.
template <typename From, typename Real>
void gather_rows(const char *at, std::ptrdiff_t stride, std::size_t count, std::size_t width,
                 Real *to, std::size_t step) {
    for (std::size_t i = 0; i < count; ++i, at += stride) {
        const From *row = reinterpret_cast<const From *>(at);
        for (std::size_t k = 0; k < width; ++k) to[k * step + i] = static_cast<Real>(row[k]);
    }
    for (std::size_t i = count; i % BLOCK; ++i)
        for (std::size_t k = 0; k < width; ++k) to[k * step + i] = to[k * step];
}

// Adding one to an exponent of ones, as infinity and NaN have it, sets the bit of the sign.
bool all_finite(const float *values, std::size_t count) {
    std::uint32_t lost = 0;
    for (std::size_t i = 0; i < count; ++i) {
        std::uint32_t bits;
        std::memcpy(&bits, values + i, sizeof bits);
        lost |= (bits & 0x7f800000U) + 0x00800000U;
    }
    return !(lost >> 31);
}

bool all_finite(const double *values, std::size_t count) {
    std::uint64_t lost = 0;
    for (std::size_t i = 0; i < count; ++i) {
        std::uint64_t bits;
        std::memcpy(&bits, values + i, sizeof bits);
        lost |= (bits & 0x7ff0000000000000U) + 0x0010000000000000U;
    }
    return !(lost >> 63);
}

// Some of the rows, computed by one thread.
template <typename Real> class Segment {
public:
    Segment(Entry<Real> entry, const Shape &shape, const std::vector<Source> &sources,
            const std::vector<Target> &targets, bool finite)
        : entry_(entry), shape_(shape), sources_(sources), targets_(targets), finite_(finite),
          in_(sources.size()), out_(targets.size()) {}

    // The output component that is not finite somewhere, or -1.
    int run(std::size_t start, std::size_t end) {
        const std::size_t all = std::max<std::size_t>(1, sources_.size() + targets_.size());
        const std::size_t padded = (end - start + BLOCK - 1) / BLOCK * BLOCK;
        const std::size_t most = std::max(BUFFER / all / BLOCK, std::size_t{1}) * BLOCK;
        tile_ = std::min({padded, most, LONGEST_TILE});
        Real *buffer = memory_;
        if (all * tile_ > BUFFER) {
            heap_.resize(all * tile_);
            buffer = heap_.data();
        }
        spare_.resize(all);
        for (std::size_t k = 0; k < all; ++k) spare_[k] = buffer + k * tile_;
        for (std::size_t k = 0; k < sources_.size(); ++k)
            if (constant(sources_[k], shape_))
                std::fill_n(spare_[k], tile_, first_of<Real>(sources_[k]));
        int lost = -1;
        for (std::size_t from = start; from < end && lost < 0;) {
            const std::size_t left = end - from;
            // A last, partial block is computed apart from the whole ones.
            const std::size_t count = left >= BLOCK ? std::min(tile_, left / BLOCK * BLOCK) : left;
            lost = one_tile(from, count);
            from += count;
        }
        return lost;
    }

private:
    int one_tile(std::size_t from, std::size_t count) {
        const bool whole = count % BLOCK == 0;
        for (std::size_t k = 0; k < sources_.size(); ++k) {
            const Source &source = sources_[k];
            in_[k] = spare_[k];
            if (constant(source, shape_)) continue;
            const bool alike = source.single == (sizeof(Real) == sizeof(float));
            if (whole && alike && !source.negative && shape_.dimensions == 1 &&
                source.strides[0] == sizeof(Real))
                in_[k] = reinterpret_cast<const Real *>(source.first) + from;
            else if (const std::size_t width = beside(k); width > 1) {
                const char *at =
                    source.first + static_cast<std::ptrdiff_t>(from) * source.strides[0];
                if (source.single)
                    gather_rows<float>(at, source.strides[0], count, width, spare_[k], tile_);
                else
                    gather_rows<double>(at, source.strides[0], count, width, spare_[k], tile_);
                for (std::size_t i = 1; i < width; ++i) in_[k + i] = spare_[k + i];
                k += width - 1;
            } else
                gather(source, shape_, from, count, spare_[k]);
        }
        for (std::size_t k = 0; k < targets_.size(); ++k) {
            const Target &target = targets_[k];
            out_[k] = whole && target.stride == sizeof(Real)
                          ? reinterpret_cast<Real *>(target.first) + from
                          : spare_[sources_.size() + k];
        }
        entry_(in_.data(), out_.data(), (count + BLOCK - 1) / BLOCK);
        int lost = -1;
        for (std::size_t k = 0; k < targets_.size(); ++k) {
            if (finite_ && !all_finite(out_[k], count)) lost = static_cast<int>(k);
            if (out_[k] == spare_[sources_.size() + k]) scatter(out_[k], targets_[k], from, count);
        }
        return lost;
    }

    // How many sources from one on are components of the same rows, beside each other.
    std::size_t beside(std::size_t k) const {
        const Source &one = sources_[k];
        if (shape_.dimensions != 1 || one.negative) return 1;
        const std::ptrdiff_t size = one.single ? sizeof(float) : sizeof(double);
        std::size_t width = 1;
        for (; k + width < sources_.size(); ++width) {
            const Source &other = sources_[k + width];
            if (other.first != one.first + static_cast<std::ptrdiff_t>(width) * size ||
                other.strides[0] != one.strides[0] || other.single != one.single || other.negative)
                break;
        }
        return width;
    }

    static void scatter(const Real *values, const Target &to, std::size_t from, std::size_t count) {
        char *at = to.first + static_cast<std::ptrdiff_t>(from) * to.stride;
        for (std::size_t i = 0; i < count; ++i, at += to.stride)
            *reinterpret_cast<Real *>(at) = values[i];
    }

    Entry<Real> entry_;
    const Shape &shape_;
    const std::vector<Source> &sources_;
    const std::vector<Target> &targets_;
    bool finite_;
    std::size_t tile_ = 0;
    std::vector<const Real *> in_;
    std::vector<Real *> out_, spare_;
    std::vector<Real> heap_;
    alignas(64) Real memory_[BUFFER];
};

}  // namespace

template <typename Real>
int run_rows(Entry<Real> entry, Shape shape, std::vector<Source> &sources,
             const std::vector<Target> &targets, unsigned threads, bool finite) {
    const std::size_t count = shape.rows();
    if (count == 0) return -1;
    join_dimensions(shape, sources);
    std::atomic<int> lost{-1};
    const auto some = [&](std::size_t start, std::size_t end) {
        Segment<Real> segment(entry, shape, sources, targets, finite);
        const int found = segment.run(start, end);
        if (found >= 0) lost = found;
    };
    const std::size_t shares = std::min<std::size_t>(threads, count / PER_THREAD);
    if (shares < 2) {
        some(0, count);
        return lost;
    }
    const std::size_t share = (count / shares + BLOCK) / BLOCK * BLOCK;
    std::vector<std::thread> others;
    for (std::size_t start = share; start < count; start += share)
        others.emplace_back(some, start, std::min(start + share, count));
    some(0, std::min(share, count));
    for (std::thread &other : others) other.join();
    return lost;
}

template int run_rows<float>(Entry<float>, Shape, std::vector<Source> &,
                             const std::vector<Target> &, unsigned, bool);
template int run_rows<double>(Entry<double>, Shape, std::vector<Source> &,
                              const std::vector<Target> &, unsigned, bool);

}  // namespace motorcade
