// A skeleton and its clips as a runtime holds them: motors apart, in float32, padded to blocks.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace motorcade::animation {

// Coefficients of motors apart: eight arrays of `padded` numbers each.
using Pose = std::vector<float>;

// One clip: keys of every joint at common times.
struct Keys {
    std::vector<double> time_s;
    std::vector<float> poses;  // for every key eight arrays of `padded` numbers
    bool looped;
};

// What a layer of a blend samples, where, and with how much weight.
struct Layer {
    std::ptrdiff_t clip;
    double time_s;
    float weight;
};

// Poses one skeleton. Not for two threads at once: it works in buffers of its own.
class Rig {
public:
    // `rest` holds the inverse rest poses joint_T_character, eight numbers a joint.
    Rig(const std::int64_t *parents, const double *inverse_rest, std::size_t joints);

    // `poses` has eight numbers a joint, joints a key. Returns the clip's number.
    std::size_t add(std::span<const double> time_s, const double *poses, bool looped);

    std::size_t joints() const { return joints_; }
    std::size_t clips() const { return clips_.size(); }

    // Local poses of a blend; by the screw (two layers at most) or linear. Layers without weight
    // are left out. Throws std::invalid_argument that says which layer is wrong and why.
    void blend(std::span<const Layer> layers, bool by_screw);
    // Palette of the last blend: 3x4 matrices by rows, or motors.
    void palette_matrices(float *out);
    void palette_motors(float *out);
    // Local poses of the last blend, eight numbers a joint.
    void local(float *out);

private:
    void sample(const Layer &layer, Pose &out);
    void mix(const Pose &a, const Pose &b, float fraction, bool by_screw, Pose &out);
    void sum(std::span<const Layer> layers, float total);
    float checked_total(std::span<const Layer> layers) const;
    [[noreturn]] void refuse(const Layer &layer, std::size_t number) const;

    std::size_t joints_, padded_;
    std::vector<std::int32_t> parents_;
    std::vector<float> inverse_motors_, inverse_matrices_;
    std::vector<Keys> clips_;
    std::vector<Layer> layers_;  // of the last blend, those with weight
    std::vector<Pose> samples_;
    Pose blended_, total_, fractions_, matrices_;
    std::vector<float> rows_, model_;
};

}  // namespace motorcade::animation
