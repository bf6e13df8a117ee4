// The longest smooth chain of a path's poses, by dynamic programming over its pieces without leaps;
// see motorcade.fusion.smoothing.batch.inliers for what a leap and a joint are.

#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include "vectors.h"
#include "versors.h"

namespace motorcade::smooth {

// Deviation of a measured pose, and density of its white acceleration, of rotation or translation.
struct Sizes {
    double noise, acceleration;
};

struct PoseRows {
    const double *time_s, *poses;  // (N), (N, 8)
    std::size_t count;             // three at least
};

// Of the numbers of an array, whose order is lost.
inline double median_of(double *values, std::size_t count) {
    double *middle = values + count / 2;
    std::nth_element(values, middle, values + count);
    return count % 2 ? *middle : 0.5 * (*middle + *std::max_element(values, middle));
}

class InlierChain {
public:
    using Twist = Vector<6>;

    InlierChain(const PoseRows &given, const std::array<Sizes, 2> &sizes)
        : given_(given), sizes_(sizes) {}

    // Writes which of the poses belong to it, (N).
    void mark(bool *kept) {
        find_rates();
        find_pieces();
        std::fill_n(kept, given_.count, false);
        for (std::ptrdiff_t piece = best_end(); piece >= 0;
             piece = pieces_[static_cast<std::size_t>(piece)].before) {
            const Piece &one = pieces_[static_cast<std::size_t>(piece)];
            std::fill(kept + one.first, kept + one.last + 1, true);
        }
    }

private:
    // Poses that one joint may cost at most, and pieces that may be left out between two.
    static constexpr double DEAREST_JOINT = 20.0;
    static constexpr std::size_t PIECES_BACK = 48;
    static constexpr double LEAP_DEVIATIONS = 5.0, LEAP_MEDIANS = 6.0;
    static constexpr std::size_t NEIGHBOURS = 3, END_STEPS = 6;
    // Deviation of the speed at an end, times the span that it is taken from, in a pose's.
    static constexpr double SPEED_ERROR = 2.0;

    struct End {
        Twist rate{};  // a second; 0 of a pose that stands alone, whose span is infinite
        double span_s = std::numeric_limits<double>::infinity();
    };

    struct Piece {
        std::size_t first, last;
        End start, end;
        double score;
        std::ptrdiff_t before;  // piece of the best chain that ends here; -1 is none
    };

    double interval_s(std::size_t step) const {
        return given_.time_s[step + 1] - given_.time_s[step];
    }

    Twist between(std::size_t from, std::size_t to) const {
        Vector<8> poses[2];
        std::copy_n(given_.poses + 8 * from, 8, poses[0].begin());
        std::copy_n(given_.poses + 8 * to, 8, poses[1].begin());
        return versors::local(poses[0], poses[1]);
    }

    void find_rates() {
        rates_.resize(given_.count - 1);
        for (std::size_t k = 0; k < rates_.size(); ++k) {
            rates_[k] = between(k, k + 1);
            for (double &one : rates_[k]) one /= interval_s(k);
        }
    }

    // Medians of components over some steps.
    template <class Index> Twist usual(std::size_t count, Index &&step) const {
        Twist made;
        std::array<double, 2 * NEIGHBOURS + 1> values;
        for (std::size_t c = 0; c < 6; ++c) {
            for (std::size_t i = 0; i < count; ++i) values[i] = rates_[step(i)][c];
            made[c] = median_of(values.data(), count);
        }
        return made;
    }

    // The step at a place beyond the ends too: mirrored there, or the last of few.
    std::size_t mirrored(std::ptrdiff_t place) const {
        const auto last = static_cast<std::ptrdiff_t>(rates_.size()) - 1;
        if (last < static_cast<std::ptrdiff_t>(NEIGHBOURS))
            return static_cast<std::size_t>(std::clamp(place, std::ptrdiff_t{0}, last));
        return static_cast<std::size_t>(place < 0      ? -place
                                        : place > last ? 2 * last - place
                                                       : place);
    }

    // By how far each step is off its neighbours' rates, in rotation and translation.
    std::array<std::vector<double>, 2> steps_off() const {
        std::array<std::vector<double>, 2> off;
        for (auto &one : off) one.resize(rates_.size());
        for (std::size_t k = 0; k < rates_.size(); ++k) {
            const Twist around = usual(2 * NEIGHBOURS + 1, [&](std::size_t i) {
                return mirrored(static_cast<std::ptrdiff_t>(k + i) -
                                static_cast<std::ptrdiff_t>(NEIGHBOURS));
            });
            for (std::size_t b = 0; b < 2; ++b) {
                double square = 0.0;
                for (std::size_t c = 3 * b; c < 3 * b + 3; ++c)
                    square += (rates_[k][c] - around[c]) * (rates_[k][c] - around[c]);
                off[b][k] = std::sqrt(square) * interval_s(k);
            }
        }
        return off;
    }

    void find_pieces() {
        const auto off = steps_off();
        std::array<double, 2> least;
        for (std::size_t b = 0; b < 2; ++b) {
            auto sorted = off[b];
            least[b] = LEAP_MEDIANS * median_of(sorted.data(), sorted.size());
        }
        std::size_t first = 0;
        for (std::size_t k = 0; k < rates_.size(); ++k) {
            bool leaps = false;
            for (std::size_t b = 0; b < 2; ++b)
                leaps |= off[b][k] >
                         std::max(LEAP_DEVIATIONS * std::sqrt(allowed(b, interval_s(k))), least[b]);
            if (!leaps) continue;
            add_piece(first, k);
            first = k + 1;
        }
        add_piece(first, given_.count - 1);
    }

    // Variance of a step, of two measured poses and the process between.
    double allowed(std::size_t block, double dt) const {
        const auto [noise, acceleration] = sizes_[block];
        return 2.0 * noise * noise + acceleration * acceleration * dt * dt * dt;
    }

    void add_piece(std::size_t first, std::size_t last) {
        Piece made{first, last, {}, {}, static_cast<double>(last - first + 1), -1};
        if (last > first) {
            const std::size_t steps = std::min(last - first, END_STEPS), tail = last - steps;
            const auto at = [&](std::size_t from) {
                return End{usual(steps, [&](std::size_t i) { return from + i; }),
                           given_.time_s[from + steps] - given_.time_s[from]};
            };
            made.start = at(first), made.end = at(tail);
        }
        pieces_.push_back(made);
    }

    // Fills in the best chains; the piece that the longest of them ends with.
    std::ptrdiff_t best_end() {
        std::size_t longest = 0;
        for (std::size_t k = 0; k < pieces_.size(); ++k) {
            double best = 0.0;
            for (std::size_t j = k; j-- > (k > PIECES_BACK ? k - PIECES_BACK : 0);) {
                // A joint costs nothing at best.
                if (pieces_[j].score < best) continue;
                const double joined = pieces_[j].score - joint_cost(pieces_[j], pieces_[k]);
                if (joined < best || joined <= 0.0) continue;
                best = joined;
                pieces_[k].before = static_cast<std::ptrdiff_t>(j);
            }
            pieces_[k].score += best;
            if (pieces_[k].score > pieces_[longest].score) longest = k;
        }
        return static_cast<std::ptrdiff_t>(longest);
    }

    // Poses that it costs to go on from one piece to a later one.
    double joint_cost(const Piece &from, const Piece &to) const {
        const double gap_s = given_.time_s[to.first] - given_.time_s[from.last];
        // A pose alone has no speed of its own: that of the other side is taken for both.
        double known = 0.0, spread = 0.0;
        for (const double span_s : {from.end.span_s, to.start.span_s}) {
            known += std::isfinite(span_s) ? 1.0 : 0.0;
            spread += (gap_s / span_s) * (gap_s / span_s);
        }
        known = std::max(known, 1.0);
        spread *= SPEED_ERROR * SPEED_ERROR / (known * known);
        const Twist step = between(from.last, to.first);
        double cost = 0.0;
        for (std::size_t b = 0; b < 2; ++b) {
            double square = 0.0;
            for (std::size_t c = 3 * b; c < 3 * b + 3; ++c) {
                const double off = step[c] - (from.end.rate[c] + to.start.rate[c]) / known * gap_s;
                square += off * off;
            }
            const double noise = sizes_[b].noise;
            cost += 0.5 * square / (allowed(b, gap_s) + noise * noise * spread);
        }
        return std::min(cost, DEAREST_JOINT);
    }

    PoseRows given_;
    std::array<Sizes, 2> sizes_;
    std::vector<Twist> rates_;
    std::vector<Piece> pieces_;
};

}  // namespace motorcade::smooth
