// What can happen at a moment: measurements, of the kinds known here or predicted by their source,
// a pose to be kept for later ones that refer to it, and moments at which the path is asked for.

#pragma once

#include <array>
#include <limits>
#include <memory>
#include <vector>

#include "state.h"

namespace motorcade::filter {

// At one moment they follow each other in this order; those up to corners as they came.
enum class Kind : std::uint8_t {
    camera_pose = 1,
    imu_pose,
    velocity,
    corners,
    sourced,
    keep,
    check,
    output
};

constexpr std::size_t corner_numbers =
    3 + 2 + 3;  // world point, x/z and y/z, xx xy yy of their covariance
constexpr double nearest_depth_m = 1e-3;
constexpr double undecided = -1.0;  // a factor that the filter shall find by itself
constexpr double nan_d = std::numeric_limits<double>::quiet_NaN();

// Measurements whose prediction is written elsewhere, row by row.
class Source {
public:
    explicit Source(std::int64_t number) : number(number) {}
    virtual ~Source() = default;
    // The residual (size) at a state and its derivative (size, most) by the state's error.
    virtual void predict(std::size_t row, std::size_t size, const State &state, const Reading &read,
                         double *residual, double *jacobian) const = 0;
    const std::int64_t number;
};

// What was known after a moment, its covariance packed.
struct Known {
    State after;
    std::vector<double> covariance;
};

// Where a prediction was given up: whether the pose is taken from what was measured there, as on a
// map that was relocated, and variances added (turn, position, velocity, both biases). Where all is
// begun anew, nothing of what was known before holds, but that the map may be turned by so much.
struct Doubt {
    bool relocated = false, anew = false, turned = false;
    double added[5] = {};
};

struct Event {
    std::int64_t time_ns = 0;   // on the IMU's clock, as far as that was known
    std::int64_t stamp_ns = 0;  // as given
    std::size_t number = 0;     // of the measurement, its source's row, or of the output
    // What was measured: the event's own, or where the caller holds it. Of a sourced one, the
    // noise (m, m).
    const double *data = nullptr;
    const double *noise = nullptr;  // covariance of a pose or a velocity
    std::unique_ptr<double[]> own;
    std::shared_ptr<const Source> source;

    // What became of it. Long recordings have many: what can be made again is kept of few.
    double nis = 0.0, factor = 0.0;            // a factor of 0: left out
    double live_nis = 0.0, live_factor = 0.0;  // as judged first, before anything later was known
    double given = undecided;  // the factor that it must have, by what is known of others
    // After a backward pass, of its residual from what all others say: normalised squares by its
    // own noise and by the most that it may have.
    std::array<double, 2> left_out = {nan_d, nan_d};
    std::unique_ptr<Doubt> doubt;
    std::unique_ptr<Known> known;
    // For a backward pass residual (m), effect (m, N), gain (m, N), inverse and noise (m, m).
    std::unique_ptr<double[]> linear;
    std::uint32_t count = 0;  // of the data
    Kind kind = Kind::check;
    std::uint8_t size = 0;  // of the residual
    bool judged = false;
    bool by_later = false;  // weighed as later ones made it in a window; see window.h
    bool placed = false;    // it tells where the sensor is: its position, or more
    bool relative = false;  // it refers to the earlier pose
    bool apart = false;     // wrong together with others, whatever it says alone
    bool bent = false;      // its prediction was no straight function of what was unknown

    // Takes numbers over: of a pose or a velocity, its covariance behind it.
    void take(const double *given, std::size_t n) {
        own = std::make_unique<double[]>(n);
        std::copy_n(given, n, own.get());
        data = own.get(), count = static_cast<std::uint32_t>(n);
        noise = data + (kind == Kind::velocity ? 3 : 8);
    }

    // What was added to the stamp.
    double shift_s() const { return 1e-9 * static_cast<double>(time_ns - stamp_ns); }
    bool from_pose() const { return kind == Kind::camera_pose || kind == Kind::imu_pose; }
    bool measures() const { return kind < Kind::keep; }
    bool before(const Event &other) const {
        if (time_ns != other.time_ns) return time_ns < other.time_ns;
        if (rank() != other.rank()) return rank() < other.rank();
        return source && other.source && source->number < other.source->number;
    }

private:
    int rank() const { return kind <= Kind::corners ? 0 : static_cast<int>(kind); }
};

// The innovation of a measurement; false where it cannot be predicted (a corner behind the camera).
template <std::size_t N> class Prediction {
public:
    Prediction(const State &state, const Reading &read) : state_(state), read_(read) {
        // How the pose and the velocity go on from here, in the IMU's axes.
        for (int i = 0; i < 3; ++i) going_[i] = read.rate[i] - state.bias[i];
        double effect[9];
        motorcade_velocity_effect(state.pose, effect);
        for (int i = 0; i < 3; ++i) {
            going_[3 + i] = 0.0;
            for (int k = 0; k < 3; ++k) going_[3 + i] += effect[3 * k + i] * state.velocity[k];
        }
    }

    bool of(const Event &event, Innovation<N> &made) const {
        const double *data = event.data;
        switch (event.kind) {
        case Kind::camera_pose:
            pose(event, data, made);
            return true;
        case Kind::imu_pose:
            pose(event, data, made);
            return true;
        case Kind::velocity:
            moving(event, data, made);
            return true;
        case Kind::corners:
            return corners(event, data, made);
        case Kind::sourced:
            sourced(event, data, made);
            return true;
        default:
            return false;
        }
    }

private:
    // The pose at the camera's stamp, by the time offset known now.
    void at_stamp(const Event &event, double *pose) const {
        std::copy_n(state_.pose, 8, pose);
        if (N == 15 || state_.delay_s == event.shift_s()) return;
        double ahead[6];
        for (int i = 0; i < 6; ++i) ahead[i] = (state_.delay_s - event.shift_s()) * going_[i];
        motorcade_retract(state_.pose, ahead, pose);
    }

    void delayed(Innovation<N> &made, std::size_t row) const {
        if constexpr (N > 15)
            for (int k = 0; k < 6; ++k) made.effect[row][delay] += made.effect[row][k] * going_[k];
    }

    void pose(const Event &event, const double *data, Innovation<N> &made) const {
        static constexpr double one[8] = {1.0};
        const bool camera = event.kind == Kind::camera_pose;
        const double *imu_T_camera = camera ? state_.imu_T_camera : one;
        double predicted[8], effect[36];
        if (camera)
            at_stamp(event, predicted);
        else
            std::copy_n(state_.pose, 8, predicted);
        made.size = 6;
        motorcade_pose_residual(predicted, imu_T_camera, data, made.residual);
        motorcade_pose_effect(imu_T_camera, effect);
        for (std::size_t a = 0; a < 6; ++a) {
            std::copy_n(effect + 6 * a, 6, made.effect[a]);
            std::copy_n(event.noise + 6 * a, 6, made.noise[a]);
            if constexpr (N > 15)
                if (camera) made.effect[a][extrinsics + a] = 1.0;
            if (camera) delayed(made, a);
        }
    }

    void sourced(const Event &event, const double *data, Innovation<N> &made) const {
        double jacobian[widest * most];
        for (made.size = 1; made.size * made.size < event.count;) ++made.size;
        event.source->predict(event.number, made.size, state_, read_, made.residual, jacobian);
        for (std::size_t a = 0; a < made.size; ++a) {
            for (std::size_t k = 0; k < N; ++k) made.effect[a][k] = -jacobian[most * a + k];
            std::copy_n(data + made.size * a, made.size, made.noise[a]);
        }
    }

    void moving(const Event &event, const double *data, Innovation<N> &made) const {
        double effect[9];
        motorcade_velocity_effect(state_.pose, effect);
        made.size = 3;
        for (std::size_t a = 0; a < 3; ++a) {
            made.residual[a] = data[a] - state_.velocity[a];
            std::copy_n(effect + 3 * a, 3, made.effect[a] + velocity);
            std::copy_n(event.noise + 3 * a, 3, made.noise[a]);
        }
    }

    bool corners(const Event &event, const double *data, Innovation<N> &made) const {
        double pose[8], seen[2], depth[1], by_pose[12], by_extrinsics[12];
        at_stamp(event, pose);
        const std::size_t count = event.count / corner_numbers;
        made.size = 2 * count;
        for (std::size_t c = 0; c < count; ++c) {
            const double *corner = data + c * corner_numbers;
            motorcade_corner(pose, state_.imu_T_camera, corner, seen, depth, by_pose,
                             by_extrinsics);
            if (!(depth[0] > nearest_depth_m)) return false;
            for (std::size_t a = 0; a < 2; ++a) {
                const std::size_t row = 2 * c + a;
                made.residual[row] = corner[3 + a] - seen[a];
                std::copy_n(by_pose + 6 * a, 6, made.effect[row]);
                if constexpr (N > 15)
                    std::copy_n(by_extrinsics + 6 * a, 6, made.effect[row] + extrinsics);
                for (std::size_t b = 0; b < 2; ++b) made.noise[row][2 * c + b] = corner[5 + a + b];
                delayed(made, row);
            }
        }
        return true;
    }

    const State &state_;
    const Reading read_;
    double going_[6];
};

}  // namespace motorcade::filter
