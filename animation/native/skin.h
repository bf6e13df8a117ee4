// Skinning: vertices and normals carried by the weighted sums of their joints' palette entries.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace motorcade::animation {

enum class Skinning { matrix, dual_quaternion, motor, similarity };

// Numbers of one palette entry.
std::size_t palette_width(Skinning method);

// A mesh in its rest pose, laid out for the kernels: coordinates apart, padded to whole blocks.
class Mesh {
public:
    // `joints` and `weights` have `width` entries a vertex, four or more, the heaviest first;
    // positions and normals have three numbers.
    Mesh(const double *positions, const double *normals, const std::int64_t *joints,
         const double *weights, std::size_t count, std::size_t width);

    // Another rest pose; what pulls at the vertices stays.
    void reshape(const double *positions, const double *normals);

    std::size_t count() const { return count_; }
    // The highest joint number plus one.
    std::size_t joints() const { return joint_count_; }

    // Writes rows of three for every vertex. The work is shared among `threads` threads.
    void skin(Skinning method, const float *palette, float *positions, float *normals,
              unsigned threads) const;

private:
    void skin_range(Skinning method, const float *palette, float *positions, float *normals,
                    std::size_t start, std::size_t end) const;

    // What follows more than four joints: the fifth and further ones, by rising vertices.
    struct Further {
        std::size_t vertex;
        std::uint16_t joint;
        float weight;
    };

    void add_further(Skinning method, const float *palette, std::size_t from, std::size_t rows,
                     float *sums) const;

    std::size_t count_, padded_, joint_count_ = 0;
    std::vector<float> rest_;  // x, y, z of the positions, then of the normals, apart
    std::vector<std::uint16_t> joints_;
    std::vector<float> weights_;
    std::vector<std::uint8_t> few_;  // of every four vertices: none follows more than two joints
    std::vector<Further> further_;
};

}  // namespace motorcade::animation
