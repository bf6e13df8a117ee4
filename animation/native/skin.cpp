// Skinning tile by tile: sums of palette entries into a buffer that stays in the cache, then the
// generated kernel of the method, then rows of the result. See skin.h.

#include "skin.h"

#include <algorithm>
#include <array>
#include <thread>

#include "rows.h"

namespace motorcade::animation {
namespace {

constexpr std::size_t LANES = MOTORCADE_LANES;
constexpr std::size_t TILE = 16 * LANES;
constexpr std::size_t PER_THREAD = 4096;  // vertices that are worth a thread

struct Method {
    std::size_t width;
    void (*sum)(const float *, const std::uint16_t *, const float *, const std::uint8_t *,
                std::size_t, float *, std::size_t);
    void (*carry)(MOTORCADE_ARGUMENTS(float));
};

const Method &of(Skinning method) {
    static const std::array<Method, 4> methods{{
        {12, sum_matrices, motorcade_carry_matrix_f32},
        {8, sum_versors, motorcade_carry_dual_quaternion_f32},
        {8, sum_versors, motorcade_carry_motor_f32},
        {12, sum_similarities, motorcade_carry_similarity_f32},
    }};
    return methods[static_cast<std::size_t>(method)];
}

}  // namespace

std::size_t palette_width(Skinning method) { return of(method).width; }

Mesh::Mesh(const double *positions, const double *normals, const std::int64_t *joints,
           const double *weights, std::size_t count, std::size_t width)
    : count_(count), padded_((count + LANES - 1) / LANES * LANES), rest_(6 * padded_, 0.0F),
      joints_(4 * padded_, 0), weights_(4 * padded_, 0.0F), few_(padded_ / 4, 1) {
    reshape(positions, normals);
    for (std::size_t i = 0; i < count; ++i) {
        // The first joint gives the sign; of the others those without weight go last.
        std::size_t used = 1;
        for (std::size_t k = 0; k < width; ++k) {
            const auto joint = static_cast<std::uint16_t>(joints[width * i + k]);
            const auto weight = static_cast<float>(weights[width * i + k]);
            joint_count_ = std::max<std::size_t>(joint_count_, joint + 1U);
            if (k > 0 && weight == 0.0F) continue;
            if (used == 4) {
                further_.push_back({i, joint, weight});
                continue;
            }
            const std::size_t at = 4 * i + (k > 0 ? used++ : 0);
            joints_[at] = joint;
            weights_[at] = weight;
        }
        few_[i / 4] = few_[i / 4] && used <= 2;
    }
    // The rest of the last block is carried by the first joint alone.
    for (std::size_t i = count; i < padded_; ++i) {
        weights_[4 * i] = 1.0F;
        rest_[3 * padded_ + i] = 1.0F;
    }
}

void Mesh::reshape(const double *positions, const double *normals) {
    for (std::size_t i = 0; i < count_; ++i)
        for (std::size_t k = 0; k < 3; ++k) {
            rest_[k * padded_ + i] = static_cast<float>(positions[3 * i + k]);
            rest_[(k + 3) * padded_ + i] = static_cast<float>(normals[3 * i + k]);
        }
}

void Mesh::add_further(Skinning method, const float *palette, std::size_t from, std::size_t rows,
                       float *sums) const {
    const std::size_t width = of(method).width;
    auto at = std::lower_bound(
        further_.begin(), further_.end(), from,
        [](const Further &one, std::size_t vertex) { return one.vertex < vertex; });
    for (; at != further_.end() && at->vertex < from + rows; ++at) {
        const float *const entry = palette + width * at->joint;
        const float *const first = palette + width * joints_[4 * at->vertex];
        float dot = 0.0F;
        for (std::size_t k = 0; k < 4; ++k) dot += entry[k] * first[k];
        const bool flips = method != Skinning::matrix && dot < 0.0F;
        const float weight = flips ? -at->weight : at->weight;
        for (std::size_t k = 0; k < width; ++k)
            sums[k * TILE + at->vertex - from] += weight * entry[k];
    }
}

void Mesh::skin_range(Skinning method, const float *palette, float *positions, float *normals,
                      std::size_t start, std::size_t end) const {
    alignas(64) float sums[12 * TILE];
    alignas(64) float skinned[6 * TILE];
    const Method &by = of(method);
    const std::ptrdiff_t tile = TILE, padded = static_cast<std::ptrdiff_t>(padded_);
    const std::ptrdiff_t input_steps[3] = {tile, padded, padded};
    float *const outputs[1] = {skinned};
    for (std::size_t from = start; from < end; from += TILE) {
        const std::size_t rows = std::min(TILE, end - from);
        const std::size_t blocks = (rows + LANES - 1) / LANES;
        by.sum(palette, joints_.data() + 4 * from, weights_.data() + 4 * from,
               few_.data() + from / 4, blocks * LANES, sums, TILE);
        add_further(method, palette, from, rows, sums);
        const float *const inputs[3] = {sums, rest_.data() + from,
                                        rest_.data() + 3 * padded_ + from};
        by.carry(inputs, input_steps, outputs, &tile, blocks);
        write_rows(skinned, TILE, rows, positions + 3 * from, normals + 3 * from);
    }
}

void Mesh::skin(Skinning method, const float *palette, float *positions, float *normals,
                unsigned threads) const {
    const std::size_t shares =
        std::clamp<std::size_t>(count_ / PER_THREAD, 1, std::max(threads, 1U));
    const std::size_t share = (count_ / shares + TILE) / TILE * TILE;
    std::vector<std::thread> others;
    for (std::size_t start = share; start < count_; start += share)
        others.emplace_back(&Mesh::skin_range, this, method, palette, positions, normals, start,
                            std::min(start + share, count_));
    skin_range(method, palette, positions, normals, 0, std::min(share, count_));
    for (std::thread &other : others) other.join();
}

}  // namespace motorcade::animation
