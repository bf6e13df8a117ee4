// Sampling, blending and posing by the generated kernels; see rig.h.

#include "rig.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <stdexcept>

#include "rows.h"

namespace motorcade::animation {
namespace {

constexpr std::size_t LANES = MOTORCADE_LANES;
constexpr std::size_t MOTOR = 8, MATRIX = 12;

using Kernel = void (*)(MOTORCADE_ARGUMENTS(float));

// Numbers below a picometre are noise, and their squares would be too small for normal floats,
// which processors add up a hundred times slower.
float stored(double value) { return std::abs(value) < 1e-12 ? 0.0F : static_cast<float>(value); }

// A kernel of motors and one number a joint.
void run(Kernel kernel, const float *a, const float *b, const float *number, float *out,
         std::size_t padded) {
    const auto step = static_cast<std::ptrdiff_t>(padded);
    const float *const inputs[3] = {a, b, number};
    const std::ptrdiff_t steps[3] = {step, step, step};
    kernel(inputs, steps, &out, &step, padded / LANES);
}

void run(Kernel kernel, const float *m, float *out, std::size_t padded) {
    const auto step = static_cast<std::ptrdiff_t>(padded);
    kernel(&m, &step, &out, &step, padded / LANES);
}

}  // namespace

Rig::Rig(const std::int64_t *parents, const double *inverse_rest, std::size_t joints)
    : joints_(joints), padded_((joints + LANES - 1) / LANES * LANES),
      parents_(parents, parents + joints), inverse_motors_(MOTOR * joints),
      inverse_matrices_(MATRIX * padded_), blended_(MOTOR * padded_), total_(MOTOR * padded_),
      fractions_(padded_), matrices_(MATRIX * padded_), rows_(MATRIX * padded_),
      model_(MATRIX * padded_) {
    Pose apart(MOTOR * padded_);
    for (std::size_t j = 0; j < joints; ++j)
        for (std::size_t k = 0; k < MOTOR; ++k)
            apart[k * padded_ + j] = inverse_motors_[MOTOR * j + k] =
                stored(inverse_rest[MOTOR * j + k]);
    for (std::size_t j = joints; j < padded_; ++j) apart[j] = 1.0F;
    blended_ = apart;
    run(motorcade_matrix34_f32, apart.data(), matrices_.data(), padded_);
    join(matrices_.data(), padded_, joints_, MATRIX, inverse_matrices_.data());
}

std::size_t Rig::add(std::span<const double> time_s, const double *poses, bool looped) {
    Keys keys{{time_s.begin(), time_s.end()},
              std::vector<float>(time_s.size() * MOTOR * padded_, 0.0F),
              looped};
    for (std::size_t f = 0; f < time_s.size(); ++f) {
        float *key = keys.poses.data() + f * MOTOR * padded_;
        for (std::size_t j = 0; j < joints_; ++j)
            for (std::size_t k = 0; k < MOTOR; ++k)
                key[k * padded_ + j] = stored(poses[(f * joints_ + j) * MOTOR + k]);
        for (std::size_t j = joints_; j < padded_; ++j) key[j] = 1.0F;
    }
    clips_.push_back(std::move(keys));
    return clips_.size() - 1;
}

void Rig::sample(const Layer &layer, Pose &out) {
    const Keys &keys = clips_.at(static_cast<std::size_t>(layer.clip));
    const std::vector<double> &times = keys.time_s;
    const double first = times.front(), last = times.back();
    double clock = std::clamp(layer.time_s, first, last);
    if (keys.looped) {
        const double passed = std::fmod(layer.time_s - first, last - first);
        clock = passed < 0.0 ? last + passed : first + passed;
    }
    const auto after = std::upper_bound(times.begin() + 1, times.end() - (times.size() > 1), clock);
    const std::size_t before = static_cast<std::size_t>(after - times.begin()) - 1;
    const float *a = keys.poses.data() + before * MOTOR * padded_;
    if (times.size() == 1) return void(std::copy_n(a, MOTOR * padded_, out.begin()));
    const double fraction = (clock - times[before]) / (times[before + 1] - times[before]);
    std::fill(fractions_.begin(), fractions_.end(), static_cast<float>(fraction));
    run(motorcade_screw_blend_f32, a, a + MOTOR * padded_, fractions_.data(), out.data(), padded_);
}

void Rig::mix(const Pose &a, const Pose &b, float fraction, bool by_screw, Pose &out) {
    std::fill(fractions_.begin(), fractions_.end(), fraction);
    run(by_screw ? motorcade_screw_blend_f32 : motorcade_blend_f32, a.data(), b.data(),
        fractions_.data(), out.data(), padded_);
}

void Rig::sum(std::span<const Layer> layers, float total) {
    const Pose &pivot = samples_[0];
    std::fill(total_.begin(), total_.end(), 0.0F);
    const auto step = static_cast<std::ptrdiff_t>(padded_);
    const std::ptrdiff_t steps[4] = {step, step, step, step};
    for (std::size_t k = 0; k < layers.size(); ++k) {
        std::fill(fractions_.begin(), fractions_.end(), layers[k].weight / total);
        const float *const inputs[4] = {total_.data(), pivot.data(), samples_[k].data(),
                                        fractions_.data()};
        float *out = blended_.data();
        motorcade_accumulate_f32(inputs, steps, &out, &step, padded_ / LANES);
        total_.swap(blended_);
    }
    run(motorcade_normalize_f32, total_.data(), blended_.data(), padded_);
}

float Rig::checked_total(std::span<const Layer> layers) const {
    float total = 0.0F;
    for (std::size_t k = 0; k < layers.size(); ++k) {
        const auto &[clip, time_s, weight] = layers[k];
        const bool known = clip >= 0 && static_cast<std::size_t>(clip) < clips_.size();
        if (!known || !std::isfinite(time_s) || !(weight >= 0.0F && std::isfinite(weight)))
            refuse(layers[k], k);
        total += weight;
    }
    if (!(total > 0.0F && std::isfinite(total)))
        throw std::invalid_argument("layers: expected weights with a finite sum above 0, got " +
                                    std::to_string(total));
    return total;
}

// Apart from the check: a stream costs as much as a blend.
void Rig::refuse(const Layer &layer, std::size_t number) const {
    std::ostringstream wrong;
    wrong << "layers: expected of layer " << number << " the ";
    if (layer.clip < 0 || static_cast<std::size_t>(layer.clip) >= clips_.size())
        wrong << "number of a clip to be from 0 to " << std::ptrdiff_t(clips_.size()) - 1
              << ", got " << layer.clip;
    else if (!std::isfinite(layer.time_s))
        wrong << "time_s to be finite, got " << layer.time_s;
    else
        wrong << "weight to be 0 or more and finite in float32, got " << layer.weight;
    throw std::invalid_argument(wrong.str());
}

void Rig::blend(std::span<const Layer> layers, bool by_screw) {
    if (layers.empty() || (by_screw && layers.size() > 2))
        throw std::invalid_argument(
            "layers: expected one or more, of a blend by the screw two at most, got " +
            std::to_string(layers.size()));
    const float total = checked_total(layers);
    layers_.clear();
    for (const Layer &layer : layers)
        if (layer.weight > 0.0F) layers_.push_back(layer);
    while (samples_.size() < layers_.size()) samples_.emplace_back(MOTOR * padded_);
    if (layers_.size() == 1) return sample(layers_[0], blended_);
    for (std::size_t k = 0; k < layers_.size(); ++k) sample(layers_[k], samples_[k]);
    if (layers_.size() == 2)
        mix(samples_[0], samples_[1], layers_[1].weight / total, by_screw, blended_);
    else
        sum(layers_, total);
}

void Rig::palette_matrices(float *out) {
    run(motorcade_matrix34_f32, blended_.data(), matrices_.data(), padded_);
    join(matrices_.data(), padded_, joints_, MATRIX, rows_.data());
    model_matrices(rows_.data(), parents_.data(), joints_, model_.data());
    multiply_matrices(model_.data(), inverse_matrices_.data(), joints_, out);
}

void Rig::palette_motors(float *out) {
    join(blended_.data(), padded_, joints_, MOTOR, rows_.data());
    model_motors(rows_.data(), parents_.data(), joints_, model_.data());
    multiply_motors(model_.data(), inverse_motors_.data(), joints_, out);
}

void Rig::local(float *out) {
    join(blended_.data(), padded_, joints_, MOTOR, rows_.data());
    std::copy_n(rows_.data(), MOTOR * joints_, out);
}

}  // namespace motorcade::animation
