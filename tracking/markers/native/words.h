// The words of a family, found again though some of their bits were read wrong.

#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace motorcade::quads {

struct Match {
    std::int64_t id;  // -1: none
    int wrong;        // bits; above what was allowed where there is none
};

// Words are cut into three parts. Of a word with two wrong bits at least one part is right, so only
// words that share a part are compared. A table of all misreadings, as the AprilTag library keeps
// it, takes gigabytes for the largest families.
class Words {
public:
    static constexpr int MOST_WRONG = 2;

    // `bits` is 3 to 64.
    Words(const std::uint64_t *words, std::size_t count, int bits) : words_(words, words + count) {
        for (int k = 0, shift = 0; k < PARTS; ++k) {
            Part &part = parts_[k];
            const int size = (bits + k) / PARTS;
            part.shift = shift;
            part.mask = (1ULL << size) - 1;
            part.first.assign((std::size_t(1) << size) + 1, 0);
            part.ids.resize(count);
            for (const std::uint64_t word : words_) ++part.first[part.of(word) + 1];
            for (std::size_t j = 1; j < part.first.size(); ++j) part.first[j] += part.first[j - 1];
            std::vector<std::uint32_t> next(part.first.begin(), part.first.end() - 1);
            for (std::size_t id = 0; id < count; ++id)
                part.ids[next[part.of(words_[id])]++] = static_cast<std::uint32_t>(id);
            shift += size;
        }
    }

    // The word with the fewest bits that differ, `most_wrong` (at most 2) of them.
    Match nearest(std::uint64_t word, int most_wrong) const {
        Match best{-1, most_wrong + 1};
        for (const Part &part : parts_) {
            const std::size_t at = part.of(word);
            for (std::uint32_t k = part.first[at]; k < part.first[at + 1]; ++k) {
                const int wrong = std::popcount(words_[part.ids[k]] ^ word);
                if (wrong < best.wrong) best = {part.ids[k], wrong};
            }
        }
        return best;
    }

private:
    static constexpr int PARTS = MOST_WRONG + 1;

    struct Part {
        int shift;
        std::uint64_t mask;
        std::vector<std::uint32_t> first, ids;

        std::size_t of(std::uint64_t word) const { return (word >> shift) & mask; }
    };

    std::vector<std::uint64_t> words_;
    std::array<Part, PARTS> parts_;
};

}  // namespace motorcade::quads
