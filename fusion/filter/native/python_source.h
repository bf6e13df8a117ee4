// Measurements that Python predicts, and how arrays go to Python and back.

#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include "timeline.h"

namespace motorcade::filter {

namespace nb = nanobind;

using Flat = nb::ndarray<const double, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using Rows = nb::ndarray<const double, nb::ndim<2>, nb::c_contig, nb::device::cpu>;
using Stamps = nb::ndarray<const std::int64_t, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using Made = nb::ndarray<double, nb::ndim<2>, nb::c_contig, nb::device::cpu>;
using MadeCubes = nb::ndarray<double, nb::ndim<3>, nb::c_contig, nb::device::cpu>;

template <class T>
nb::object array(const std::vector<T> &values, std::initializer_list<std::size_t> shape) {
    auto *memory = new T[std::max<std::size_t>(1, values.size())];
    std::copy(values.begin(), values.end(), memory);
    nb::capsule owner(memory, [](void *data) noexcept { delete[] static_cast<T *>(data); });
    return nb::cast(nb::ndarray<nb::numpy, T>(memory, shape.size(), shape.begin(), owner));
}

inline void expect(bool holds, const char *what) {
    if (!holds) refuse(what);
}

// Measurements that Python predicts; see motorcade.fusion.measurements.
class Python final : public Source {
public:
    Python(const nb::object &predict, std::int64_t number) : Source(number), predict_(predict) {}
    Python(const Python &) = delete;
    Python &operator=(const Python &) = delete;
    ~Python() override {
        const nb::gil_scoped_acquire locked;
        predict_.reset();
    }

    void predict(std::size_t row, std::size_t size, const State &state, const Reading &read,
                 double *residual, double *jacobian) const override {
        const nb::gil_scoped_acquire locked;
        std::vector<double> known;
        for (const double *pose : {state.pose, state.earlier}) {
            static constexpr double origin[3] = {};
            double axes[9], place[3], unused[18];
            motorcade_velocity_effect(pose, axes);
            motorcade_point(pose, origin, place, unused);
            known.insert(known.end(), axes, axes + 9);
            known.insert(known.end(), place, place + 3);
        }
        known.insert(known.end(), state.velocity, state.velocity + 3);
        for (int i = 0; i < 3; ++i) known.push_back(read.rate[i] - state.bias[i]);
        known.insert(known.end(), state.bias, state.bias + 6);
        double upright[8] = {}, fall[9];
        std::copy_n(state.gravity_rotor, 4, upright);
        motorcade_velocity_effect(upright, fall);
        known.insert(known.end(), fall, fall + 9);
        known.insert(known.end(), state.imu_T_camera, state.imu_T_camera + 8);
        known.push_back(state.delay_s);
        const std::size_t count = known.size();
        const auto made = nb::cast<Rows>(predict_(row, array(known, {count})));
        expect(made.shape(0) == size && made.shape(1) == 1 + most,
               "predict: expected a row a number of the measurement");
        for (std::size_t a = 0; a < size; ++a) {
            residual[a] = made.data()[(1 + most) * a];
            std::copy_n(made.data() + (1 + most) * a + 1, most, jacobian + most * a);
        }
    }

private:
    nb::object predict_;
};

}  // namespace motorcade::filter
