// From grey levels to points between regions of black and white; see quads.h.

#include "quads.h"

#include <algorithm>

namespace motorcade::quads {

namespace {

constexpr int TILE = 4;
constexpr int LEAST_CONTRAST = 5;    // grey levels; less is noise on a plain surface
constexpr int LEAST_REGION_PX = 25;  // fewer pixels are noise
constexpr int LEAST_POINTS = 24;     // two for each line that is tried
// A convex loop meets each row and each column of its bounds twice. Some of it may be hidden, and
// noise makes it ragged; outlines of texture are far longer.
constexpr float LEAST_LENGTH = 0.6F, MOST_LENGTH = 1.7F;

using Bytes = std::vector<std::uint8_t>;

// The extreme of each tile and its eight neighbours, from those of single tiles.
template <class Extreme> Bytes spread(const Bytes &tiles, int across, int down, Extreme extreme) {
    Bytes rows(tiles.size()), made(tiles.size());
    for (int y = 0; y < down; ++y) {
        const std::uint8_t *from = &tiles[std::size_t(y) * across];
        std::uint8_t *to = &rows[std::size_t(y) * across];
        for (int x = 0; x < across; ++x)
            to[x] = extreme(from[x],
                            extreme(from[std::max(x - 1, 0)], from[std::min(x + 1, across - 1)]));
    }
    for (int y = 0; y < down; ++y) {
        const std::uint8_t *above = &rows[std::size_t(std::max(y - 1, 0)) * across];
        const std::uint8_t *same = &rows[std::size_t(y) * across];
        const std::uint8_t *below = &rows[std::size_t(std::min(y + 1, down - 1)) * across];
        std::uint8_t *to = &made[std::size_t(y) * across];
        for (int x = 0; x < across; ++x) to[x] = extreme(above[x], extreme(same[x], below[x]));
    }
    return made;
}

void tile_extremes(const Image &image, int across, int down, Bytes &least, Bytes &most) {
    const int whole = image.width / TILE;
    Bytes low(image.width), high(image.width);
    for (int y = 0; y < down; ++y) {
        const int first = y * TILE, last = std::min(first + TILE, image.height);
        std::copy_n(image.row(first), image.width, low.data());
        high = low;
        for (int row = first + 1; row < last; ++row) {
            const std::uint8_t *levels = image.row(row);
            for (int x = 0; x < image.width; ++x) {
                low[x] = std::min(low[x], levels[x]);
                high[x] = std::max(high[x], levels[x]);
            }
        }
        for (int x = 0; x < across; ++x) {
            const int begin = x * TILE, end = x < whole ? begin + TILE : image.width;
            least[std::size_t(y) * across + x] = *std::min_element(&low[begin], low.data() + end);
            most[std::size_t(y) * across + x] = *std::max_element(&high[begin], high.data() + end);
        }
    }
}

Binary empty_like(const Image &image) {
    const std::size_t pixels = std::size_t(image.width) * image.height;
    return {image.width, image.height, Bytes(pixels), Bytes(pixels)};
}

struct Run {
    int begin, end;
    std::uint8_t colour;
};

// Runs of equal colour row by row, joined into regions; pixels that are neither have none.
class Regions {
public:
    explicit Regions(const Binary &binary) {
        row_.reserve(binary.height + 1);
        for (int y = 0; y < binary.height; ++y) {
            row_.push_back(static_cast<int>(runs_.size()));
            find_runs(&binary.colour[std::size_t(y) * binary.width], binary.width);
            if (y > 0) join(row_[y - 1], row_[y], static_cast<int>(runs_.size()));
        }
        row_.push_back(static_cast<int>(runs_.size()));
        std::vector<int> size(runs_.size(), 0);
        for (std::size_t k = 0; k < runs_.size(); ++k)
            size[root(static_cast<int>(k))] += runs_[k].end - runs_[k].begin;
        for (std::size_t k = 0; k < runs_.size(); ++k) parent_[k] = root(static_cast<int>(k));
        region_.resize(runs_.size());
        for (std::size_t k = 0; k < runs_.size(); ++k)
            region_[k] = size[parent_[k]] >= LEAST_REGION_PX ? parent_[k] : -1;
    }

    int begin(int y) const { return row_[y]; }
    int end(int y) const { return row_[y + 1]; }
    const Run &run(int k) const { return runs_[k]; }
    int region(int k) const { return region_[k]; }  // -1: too small
    bool meet(int one, int other) const {
        return region_[one] >= 0 && region_[other] >= 0 && runs_[one].colour != runs_[other].colour;
    }

private:
    void find_runs(const std::uint8_t *colour, int width) {
        for (int x = 0; x < width;) {
            const int begin = x;
            const std::uint8_t same = colour[x];
            while (x < width && colour[x] == same) ++x;
            if (same == Neither) continue;
            parent_.push_back(static_cast<int>(runs_.size()));
            runs_.push_back({begin, x, same});
        }
    }

    // White joins over corners too, black over sides only, so that loops between them are closed.
    void join(int above, int begin, int end) {
        for (int k = begin, j = above; k < end; ++k) {
            const Run &run = runs_[k];
            const int reach = run.colour == White ? 1 : 0;
            while (j > above && runs_[j - 1].end + 1 > run.begin) --j;
            while (j < begin && runs_[j].end + 1 <= run.begin) ++j;
            for (int i = j; i < begin && runs_[i].begin < run.end + 1; ++i)
                if (runs_[i].colour == run.colour && runs_[i].begin < run.end + reach &&
                    runs_[i].end + reach > run.begin)
                    unite(i, k);
        }
    }

    int root(int k) {
        while (parent_[k] != k) k = parent_[k] = parent_[parent_[k]];
        return k;
    }

    void unite(int one, int other) {
        const int a = root(one), b = root(other);
        if (a < b) parent_[b] = a;
        if (b < a) parent_[a] = b;
    }

    std::vector<Run> runs_;
    std::vector<int> row_, parent_, region_;
};

// A place where two regions meet: columns begin to end of row y and the row below, or, where `end`
// is not above `begin`, columns begin - 1 and begin of row y.
struct Meeting {
    std::uint32_t pair;
    int begin, end, y;
};

// How many points two regions have between them, and their bounds.
struct Extent {
    int points = 0, left = 1 << 30, right = -1, top = 1 << 30, bottom = -1;

    void add(const Meeting &at) {
        points += std::max(at.end - at.begin, 1);
        left = std::min(left, at.begin);
        right = std::max(right, std::max(at.begin, at.end - 1));
        top = std::min(top, at.y);
        bottom = std::max(bottom, at.y);
    }
    bool looped(float least_side) const {
        const float width = static_cast<float>(right - left),
                    height = static_cast<float>(bottom - top);
        const float length = static_cast<float>(points) / (2.0F * (width + height) + 1e-3F);
        return points >= LEAST_POINTS && width * height >= least_side * least_side &&
               length >= LEAST_LENGTH && length <= MOST_LENGTH;
    }
};

// Where regions of black and white meet, by pairs of regions as they come.
class Meetings {
public:
    Meetings(const Regions &regions, int height) {
        for (int y = 0; y < height; ++y) {
            for (int k = regions.begin(y); k + 1 < regions.end(y); ++k) {
                const int x = regions.run(k).end;
                if (regions.run(k + 1).begin == x && regions.meet(k, k + 1))
                    add(regions.region(k), regions.region(k + 1), x, x, y);
            }
            if (y + 1 == height) break;
            for (int k = regions.begin(y), j = regions.begin(y + 1);
                 k < regions.end(y) && j < regions.end(y + 1);) {
                const Run &one = regions.run(k), &other = regions.run(j);
                const int begin = std::max(one.begin, other.begin);
                const int end = std::min(one.end, other.end);
                if (begin < end && regions.meet(k, j))
                    add(regions.region(k), regions.region(j), begin, end, y);
                one.end <= other.end ? ++k : ++j;
            }
        }
    }

    const std::vector<Meeting> &all() const { return all_; }
    const std::vector<Extent> &extents() const { return extents_; }

private:
    static constexpr std::uint64_t NONE = ~0ULL;

    void add(int one, int other, int begin, int end, int y) {
        all_.push_back({number(one, other), begin, end, y});
        extents_[all_.back().pair].add(all_.back());
    }

    // Open addressing; neighbours often share a pair.
    std::uint32_t number(int one, int other) {
        const std::uint64_t low = std::min(one, other), high = std::max(one, other);
        const std::uint64_t key = high << 32 | low;
        if (key == last_key_) return last_;
        if (2 * (extents_.size() + 1) > keys_.size()) grow();
        const std::size_t slot = place(key);
        if (keys_[slot] == NONE) {
            keys_[slot] = key;
            numbers_[slot] = static_cast<std::uint32_t>(extents_.size());
            extents_.emplace_back();
        }
        last_key_ = key;
        return last_ = numbers_[slot];
    }

    std::size_t place(std::uint64_t key) const {
        std::size_t slot = (key * 0x9E3779B97F4A7C15ULL >> 32) & (keys_.size() - 1);
        while (keys_[slot] != NONE && keys_[slot] != key) slot = (slot + 1) & (keys_.size() - 1);
        return slot;
    }

    void grow() {
        std::vector<std::uint64_t> keys(2 * keys_.size(), NONE);
        std::vector<std::uint32_t> numbers(keys.size());
        keys.swap(keys_);
        numbers.swap(numbers_);
        for (std::size_t k = 0; k < keys.size(); ++k) {
            if (keys[k] == NONE) continue;
            const std::size_t slot = place(keys[k]);
            keys_[slot] = keys[k];
            numbers_[slot] = numbers[k];
        }
    }

    std::vector<Meeting> all_;
    std::vector<Extent> extents_;
    std::vector<std::uint64_t> keys_ = std::vector<std::uint64_t>(4096, NONE);
    std::vector<std::uint32_t> numbers_ = std::vector<std::uint32_t>(4096);
    std::uint64_t last_key_ = NONE;
    std::uint32_t last_ = 0;
};

// How far from the first of two neighbours the brightness crosses what separates them, 0 to 1.
// Equal ones are separated half way: by their thresholds, which differ.
float crossing(int before, int after, int low, int high) {
    if (before == after) return 0.5F;
    const float middle = 0.5F * static_cast<float>(low + high);
    const float share = (middle - static_cast<float>(before)) / static_cast<float>(after - before);
    return std::clamp(share, 0.0F, 1.0F);
}

}  // namespace

Binary threshold_tiles(const Image &image) {
    Binary made = empty_like(image);
    const int across = (image.width + TILE - 1) / TILE, down = (image.height + TILE - 1) / TILE;
    Bytes least(std::size_t(across) * down), most(least.size());
    tile_extremes(image, across, down, least, most);
    const auto smaller = [](std::uint8_t a, std::uint8_t b) { return std::min(a, b); };
    const auto larger = [](std::uint8_t a, std::uint8_t b) { return std::max(a, b); };
    least = spread(least, across, down, smaller);
    most = spread(most, across, down, larger);
    const int padded = across * TILE;
    Bytes middle(padded), flat(padded);
    for (int y = 0; y < image.height; ++y) {
        if (y % TILE == 0) {
            const std::size_t first = std::size_t(y / TILE) * across;
            for (int x = 0; x < across; ++x) {
                const int low = least[first + x], range = most[first + x] - low;
                std::fill_n(&middle[x * TILE], TILE, static_cast<std::uint8_t>(low + range / 2));
                std::fill_n(&flat[x * TILE], TILE, range < LEAST_CONTRAST ? 1 : 0);
            }
        }
        const std::uint8_t *levels = image.row(y);
        std::uint8_t *colour = &made.colour[std::size_t(y) * image.width];
        for (int x = 0; x < image.width; ++x)
            colour[x] = flat[x] ? std::uint8_t(Neither) : std::uint8_t(levels[x] > middle[x]);
        std::copy_n(middle.data(), image.width, &made.threshold[std::size_t(y) * image.width]);
    }
    return made;
}

Binary threshold_mean(const Image &image, int reach) {
    Binary made = empty_like(image);
    const int width = image.width, height = image.height;
    std::vector<int> columns(width, 0), sums(width + 1);
    for (int y = 0; y < std::min(reach, height); ++y)
        for (int x = 0; x < width; ++x) columns[x] += image.row(y)[x];
    for (int y = 0; y < height; ++y) {
        if (y + reach < height)
            for (int x = 0; x < width; ++x) columns[x] += image.row(y + reach)[x];
        if (y - reach - 1 >= 0)
            for (int x = 0; x < width; ++x) columns[x] -= image.row(y - reach - 1)[x];
        sums[0] = 0;
        for (int x = 0; x < width; ++x) sums[x + 1] = sums[x] + columns[x];
        const int rows = std::min(y + reach, height - 1) - std::max(y - reach, 0) + 1;
        const std::uint8_t *levels = image.row(y);
        std::uint8_t *colour = &made.colour[std::size_t(y) * width];
        std::uint8_t *threshold = &made.threshold[std::size_t(y) * width];
        for (int x = 0; x < width; ++x) {
            const int low = std::max(x - reach, 0), high = std::min(x + reach + 1, width);
            const float pixels = static_cast<float>(rows * (high - low));
            const float mean = static_cast<float>(sums[high] - sums[low]) / pixels;
            threshold[x] = static_cast<std::uint8_t>(std::max(mean - LEAST_CONTRAST, 0.0F));
            colour[x] = levels[x] > threshold[x] ? White : Black;
        }
    }
    return made;
}

Edges find_edges(const Image &image, const Binary &binary, float least_side) {
    const Regions regions(binary);
    const Meetings meetings(regions, image.height);
    const std::vector<Extent> &extents = meetings.extents();
    constexpr std::uint32_t NONE = ~0U;
    std::vector<std::uint32_t> next(extents.size(), NONE);
    Edges made{{}, {0}};
    for (std::size_t k = 0; k < extents.size(); ++k) {
        if (!extents[k].looped(least_side)) continue;
        next[k] = made.first.back();
        made.first.push_back(next[k] + static_cast<std::uint32_t>(extents[k].points));
    }
    made.points.resize(made.first.back());
    for (const Meeting &at : meetings.all()) {
        std::uint32_t &to = next[at.pair];
        if (to == NONE) continue;
        const std::uint8_t *levels = image.row(at.y);
        const std::uint8_t *limit = &binary.threshold[std::size_t(at.y) * image.width];
        const auto step = [](int before, int after) { return static_cast<float>(after - before); };
        if (at.end <= at.begin) {
            const int x = at.begin, before = levels[x - 1], after = levels[x];
            const float part = crossing(before, after, limit[x - 1], limit[x]);
            made.points[to++] = {static_cast<float>(x - 1) + part, static_cast<float>(at.y),
                                 step(before, after), 0.0F};
            continue;
        }
        const std::uint8_t *below = image.row(at.y + 1), *limit_below = limit + image.width;
        for (int x = at.begin; x < at.end; ++x) {
            const float part = crossing(levels[x], below[x], limit[x], limit_below[x]);
            made.points[to++] = {static_cast<float>(x), static_cast<float>(at.y) + part, 0.0F,
                                 step(levels[x], below[x])};
        }
    }
    return made;
}

}  // namespace motorcade::quads
