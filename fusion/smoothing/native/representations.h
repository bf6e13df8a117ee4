// The representations of motorcade.fusion.smoothing.representations, one pose at a time. Each reads
// a pose into coordinates, writes it back, and offers the two verbs that scans are made of: `local`
// and its mirror `retract`. Components of a local vector lie in blocks: rotation, translation and,
// where poses have one, scale; `units` are components for a radian, a metre, and a unit of scale.
// Errors of the first `coupled` components mix as they are propagated along a motion exp(v): by
// `adjoint_of_inverse(v)`, the matrix of Ad(exp(-v)).

#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <utility>

#include "covariance.h"
#include "versors.h"

namespace motorcade::smooth {

template <class R>
concept Representation = requires(Vector<R::pose_size> pose, Vector<R::size> x,
                                  Vector<R::freedom> v) {
    { R::name } -> std::convertible_to<const char *>;
    { R::ends.size() } -> std::convertible_to<std::size_t>;
    { R::units.size() } -> std::convertible_to<std::size_t>;
    requires R::coupled <= R::freedom;
    { R::read(pose) } -> std::same_as<decltype(x)>;
    { R::write(x) } -> std::same_as<decltype(pose)>;
    { R::local(x, x) } -> std::same_as<decltype(v)>;
    { R::retract(x, v) } -> std::same_as<decltype(x)>;
    { R::continued(x, x) } -> std::same_as<decltype(x)>;
};

using Motor = Vector<8>;
using Similarity = Vector<12>;

template <std::size_t N> Square<N> rows_of(const Vector<N * N> &numbers) {
    Square<N> made;
    for (std::size_t i = 0; i < N; ++i) std::copy_n(&numbers[i * N], N, made[i].begin());
    return made;
}

// A similarity's rigid motion and its scale.
inline std::pair<Motor, double> parts_of(const Similarity &s) {
    const Vector<8> parts = versors::rotor_translation_scale(s);
    return {versors::motor_of(Four{parts[0], parts[1], parts[2], parts[3]},
                              Three{parts[4], parts[5], parts[6]}),
            parts[7]};
}

// Twists in the base's body frame: one screw.
struct Motors {
    static constexpr const char *name = "motor";
    static constexpr std::size_t pose_size = 8, size = 8, freedom = 6, coupled = 6;
    static constexpr std::array<std::size_t, 2> ends{3, 6};
    static constexpr std::array<double, 2> units{1.0, 1.0};

    static Motor read(const Motor &pose) { return versors::normalize(pose); }
    static Motor write(const Motor &x) { return x; }
    static Vector<6> local(const Motor &x, const Motor &base) { return versors::local(base, x); }
    static Motor retract(const Motor &base, const Vector<6> &v) {
        return versors::normalize(versors::retract(base, v));
    }
    static Motor continued(const Motor &x, const Motor &) { return x; }
    static Square<6> adjoint_of_inverse(const Vector<6> &v) {
        return rows_of<6>(versors::adjoint(versors::exp(scaled(0.5, v))));
    }
};

// The rotation vector in the base's body beside the translation in the world.
struct Rotors {
    static constexpr const char *name = "rotor";
    static constexpr std::size_t pose_size = 8, size = 7, freedom = 6, coupled = 3;
    static constexpr std::array<std::size_t, 2> ends{3, 6};
    static constexpr std::array<double, 2> units{1.0, 1.0};
    using X = Vector<7>;

    static Four rotor(const X &x) { return {x[0], x[1], x[2], x[3]}; }
    static X read(const Motor &given) {
        const Motor pose = versors::normalize(given);
        const Three t = versors::translation(pose);
        return {pose[0], pose[1], pose[2], pose[3], t[0], t[1], t[2]};
    }
    static Motor write(const X &x) { return versors::motor_of(rotor(x), Three{x[4], x[5], x[6]}); }
    static Vector<6> local(const X &x, const X &base) {
        const Three turn = versors::local(rotor(base), rotor(x));
        return {turn[0], turn[1], turn[2], x[4] - base[4], x[5] - base[5], x[6] - base[6]};
    }
    static X retract(const X &base, const Vector<6> &v) {
        const Four turned =
            versors::renormalize(versors::retract(rotor(base), Three{v[0], v[1], v[2]}));
        return {turned[0],      turned[1],      turned[2],     turned[3],
                base[4] + v[3], base[5] + v[4], base[6] + v[5]};
    }
    static X continued(const X &x, const X &) { return x; }
    static Square<3> adjoint_of_inverse(const Vector<6> &v) {
        return rows_of<3>(versors::adjoint(versors::exp(scaled(0.5, Three{v[0], v[1], v[2]}))));
    }
};

// What is subtracted and added component by component, as practitioners do it.
template <std::size_t N> struct Linear {
    static constexpr std::size_t size = N, freedom = N, coupled = 0;
    using X = Vector<N>;

    static X local(const X &x, const X &base) { return sum(x, scaled(-1.0, base)); }
    static X unprojected(const X &base, const X &v) { return sum(base, v); }
};

inline double checked_length(const Four &q, const char *name) {
    const double length = std::sqrt(dot(q, q));
    if (!(length > 0.0))
        throw std::invalid_argument(std::string(name) +
                                    ": expected averages of non-zero length, got 0");
    return length;
}

// Quaternion wxyz whose sign follows its predecessor's, renormalised; translation apart.
struct Quaternions : Linear<7> {
    static constexpr const char *name = "quaternion";
    static constexpr std::size_t pose_size = 8;
    static constexpr std::array<std::size_t, 2> ends{4, 7};
    static constexpr std::array<double, 2> units{0.5, 1.0};

    static X read(const Motor &given) {
        const Motor pose = versors::normalize(given);
        const Three t = versors::translation(pose);
        return {pose[0], -pose[1], -pose[2], -pose[3], t[0], t[1], t[2]};
    }
    static Motor write(const X &x) {
        return versors::motor_of(Four{x[0], -x[1], -x[2], -x[3]}, Three{x[4], x[5], x[6]});
    }
    static X retract(const X &base, const X &v) {
        X x = sum(base, v);
        const double length = checked_length({x[0], x[1], x[2], x[3]}, name);
        for (std::size_t k = 0; k < 4; ++k) x[k] /= length;
        return x;
    }
    static X continued(const X &x, const X &previous) {
        X made = x;
        if (dot(Four{x[0], x[1], x[2], x[3]},
                {previous[0], previous[1], previous[2], previous[3]}) < 0.0)
            for (std::size_t k = 0; k < 4; ++k) made[k] = -x[k];
        return made;
    }
};

// The eight components of Hamilton dual quaternions, projected onto unit ones.
struct DualQuaternions : Linear<8> {
    static constexpr const char *name = "dual_quaternion";
    static constexpr std::size_t pose_size = 8;
    static constexpr std::array<std::size_t, 2> ends{4, 8};
    static constexpr std::array<double, 2> units{0.5, 0.5};

    static X from(const Motor &m) {
        return {m[0], -m[1], -m[2], -m[3], -m[7], -m[4], -m[5], -m[6]};
    }
    static X read(const Motor &pose) { return from(versors::normalize(pose)); }
    static Motor write(const X &x) {
        return {x[0], -x[1], -x[2], -x[3], -x[5], -x[6], -x[7], -x[4]};
    }
    static X retract(const X &base, const X &v) {
        const X x = sum(base, v);
        checked_length({x[0], x[1], x[2], x[3]}, name);
        return from(versors::normalize(write(x)));
    }
    static X continued(const X &x, const X &previous) {
        const Four a{x[0], x[1], x[2], x[3]}, b{previous[0], previous[1], previous[2], previous[3]};
        return dot(a, b) < 0.0 ? scaled(-1.0, x) : x;
    }
};

// Intrinsic x-y′-z″ angles as they come, which leap at ±π; translation apart.
struct EulerAngles : Linear<6> {
    static constexpr const char *name = "euler";
    static constexpr std::size_t pose_size = 8;
    static constexpr std::array<std::size_t, 2> ends{3, 6};
    static constexpr std::array<double, 2> units{1.0, 1.0};

    static X read(const Motor &given) {
        const Motor pose = versors::normalize(given);
        const double w = pose[0], x = -pose[1], y = -pose[2], z = -pose[3];
        // Columns 0, 1, 2 of the lower rows of the rotation matrix, and its upper right corner.
        const double row1[3] = {2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)};
        const double row2[3] = {2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)};
        const double lever = std::hypot(row1[2], row2[2]);
        // At gimbal lock the first angle is noise and set to 0, as in motorcade.ga.
        const double first = lever > 4e-15 ? std::atan2(-row1[2], row2[2]) : 0.0;
        const double cosine = std::cos(first), sine = std::sin(first);
        const double third =
            std::atan2(cosine * row1[0] + sine * row2[0], cosine * row1[1] + sine * row2[1]);
        const Three t = versors::translation(pose);
        return {first, std::atan2(2 * (x * z + w * y), lever), third, t[0], t[1], t[2]};
    }
    static Motor write(const X &x) {
        const Four first = versors::exp(Three{-0.5 * x[0], 0.0, 0.0});
        const Four second = versors::retract(first, Three{0.0, x[1], 0.0});
        const Four turned = versors::retract(second, Three{0.0, 0.0, x[2]});
        return versors::motor_of(versors::renormalize(turned), Three{x[3], x[4], x[5]});
    }
    static X retract(const X &base, const X &v) { return sum(base, v); }
    static X continued(const X &x, const X &) { return x; }
};

// The same angles, each on the branch nearest to the one before.
struct UnwrappedEulerAngles : EulerAngles {
    static constexpr const char *name = "euler_unwrapped";

    static X continued(const X &x, const X &previous) {
        constexpr double turn = 6.283185307179586;
        X made = x;
        for (std::size_t k = 0; k < 3; ++k)
            made[k] += turn * std::nearbyint((previous[k] - x[k]) / turn);
        return made;
    }
};

// The same angles, each triple the nearest to the one before of all that are its rotation: see
// motorcade.ga.classical.nearest_euler. Other orders are these angles in other frames.
struct FollowedEulerAngles : EulerAngles {
    static constexpr const char *name = "euler_xyz";

    static X continued(const X &x, const X &previous) {
        constexpr double half_turn = 3.141592653589793;
        X made = UnwrappedEulerAngles::continued(x, previous);
        const X twin = UnwrappedEulerAngles::continued(
            {x[0] + half_turn, half_turn - x[1], x[2] + half_turn, x[3], x[4], x[5]}, previous);
        if (apart(twin, previous) < apart(made, previous)) made = twin;
        if (std::abs(std::cos(made[1])) <= 8e-15) {
            // Gimbal lock: only the sum or the difference is known, and both go half of the way.
            const double way = std::sin(made[1]) > 0.0 ? 1.0 : -1.0;
            const double half =
                0.5 * std::remainder(made[0] - previous[0] + way * (made[2] - previous[2]),
                                     2.0 * half_turn);
            made[0] = previous[0] + half;
            made[2] = previous[2] + way * half;
        }
        return made;
    }

private:
    static double apart(const X &a, const X &b) {
        const Three d{a[0] - b[0], a[1] - b[1], a[2] - b[2]};
        return dot(d, d);
    }
};

// Twists with the logarithm of the scale, of poses that have a scale.
struct Similarities {
    static constexpr const char *name = "similarity";
    static constexpr std::size_t pose_size = 12, size = 12, freedom = 7, coupled = 7;
    static constexpr std::array<std::size_t, 3> ends{3, 6, 7};
    static constexpr std::array<double, 3> units{1.0, 1.0, 1.0};

    static Similarity read(const Similarity &pose) { return pose; }
    static Similarity write(const Similarity &x) { return x; }
    static Vector<7> local(const Similarity &x, const Similarity &base) {
        return versors::local(base, x);
    }
    static Similarity retract(const Similarity &base, const Vector<7> &v) {
        return versors::retract(base, v);
    }
    static Similarity continued(const Similarity &x, const Similarity &) { return x; }
    static Square<7> adjoint_of_inverse(const Vector<7> &v) {
        const Similarity origin{1.0};
        return rows_of<7>(versors::adjoint(versors::retract(origin, scaled(-1.0, v))));
    }
};

// The same of rigid poses, whose scale is and stays 1.
struct RigidSimilarities : Similarities {
    static constexpr std::size_t pose_size = 8;

    static Similarity read(const Motor &given) {
        return versors::similarity_of(versors::normalize(given), 1.0);
    }
    static Motor write(const Similarity &x) { return parts_of(x).first; }
};

// A rigid representation with the scale beside it as one more number.
template <Representation R> struct WithScale {
    static constexpr const char *name = R::name;
    static constexpr std::size_t pose_size = 12, size = R::size + 1, freedom = R::freedom + 1,
                                 coupled = R::coupled;
    static constexpr std::array<std::size_t, 3> ends{R::ends[0], R::ends[1], R::freedom + 1};
    static constexpr std::array<double, 3> units{R::units[0], R::units[1], 1.0};
    using X = Vector<size>;
    using V = Vector<freedom>;

    static Vector<R::size> rigid(const X &x) { return first<R::size>(x); }
    static X read(const Similarity &pose) {
        const auto [rigid, scale] = parts_of(pose);
        return with(R::read(rigid), scale);
    }
    static Similarity write(const X &x) {
        if (!(x.back() > 0.0))
            throw std::invalid_argument("scale: expected a positive number, got " +
                                        std::to_string(x.back()));
        return versors::similarity_of(R::write(rigid(x)), x.back());
    }
    static V local(const X &x, const X &base) {
        return with(R::local(rigid(x), rigid(base)), x.back() - base.back());
    }
    static X retract(const X &base, const V &v) {
        return with(R::retract(rigid(base), first<R::freedom>(v)), base.back() + v.back());
    }
    static X unprojected(const X &base, const V &v) requires
        requires(Vector<R::size> x, Vector<R::freedom> u) {
        R::unprojected(x, u);
    }
    { return with(R::unprojected(rigid(base), first<R::freedom>(v)), base.back() + v.back()); }
    static X continued(const X &x, const X &previous) {
        return with(R::continued(rigid(x), rigid(previous)), x.back());
    }
    static Square<coupled> adjoint_of_inverse(const V &v) {
        return R::adjoint_of_inverse(first<R::freedom>(v));
    }

private:
    template <std::size_t N, std::size_t M> static Vector<N> first(const Vector<M> &from) {
        Vector<N> made;
        for (std::size_t k = 0; k < N; ++k) made[k] = from[k];
        return made;
    }
    template <std::size_t N> static Vector<N + 1> with(const Vector<N> &from, double last) {
        Vector<N + 1> made;
        for (std::size_t k = 0; k < N; ++k) made[k] = from[k];
        made[N] = last;
        return made;
    }
};

// Where the state of a linear filter goes. Components that are no pose until they are projected
// stay as the filter has them: projected at every step, they would no longer fit its rates.
template <class R, class X, class V> X unprojected(const X &base, const V &v) {
    if constexpr (requires { R::unprojected(base, v); })
        return R::unprojected(base, v);
    else
        return R::retract(base, v);
}

// The pose's coordinates of such a state.
template <Representation R> Vector<R::size> projected(const Vector<R::size> &x) {
    if constexpr (requires { R::unprojected(x, Vector<R::freedom>{}); })
        return R::retract(x, Vector<R::freedom>{});
    else
        return x;
}

// Poses of as many paths as there are lanes, each by itself.
template <Representation R> struct InLanes {
    static constexpr std::size_t pose_size = R::pose_size, size = R::size, freedom = R::freedom,
                                 coupled = R::coupled;
    static constexpr auto ends = R::ends;
    static constexpr auto units = R::units;
    using X = Vector<size, Lanes>;
    using V = Vector<freedom, Lanes>;

    static X read(const Vector<pose_size, Lanes> &pose) {
        return each<size>([](const auto &one) { return R::read(one); }, pose);
    }
    static V local(const X &x, const X &base) { return each<freedom>(R::local, x, base); }
    static X retract(const X &base, const V &v) { return each<size>(R::retract, base, v); }
    static X unprojected(const X &base, const V &v) {
        return each<size>(smooth::unprojected<R, Vector<size>, Vector<freedom>>, base, v);
    }
    static X continued(const X &x, const X &previous) {
        return each<size>(R::continued, x, previous);
    }
    static Square<coupled, Lanes> adjoint_of_inverse(const V &v) {
        Square<coupled, Lanes> made;
        for (std::size_t k = 0; k < Lanes::COUNT; ++k) {
            const Square<coupled> matrix = R::adjoint_of_inverse(one_of(v, k));
            for (std::size_t i = 0; i < coupled; ++i)
                for (std::size_t j = 0; j < coupled; ++j) made[i][j][k] = matrix[i][j];
        }
        return made;
    }

    template <std::size_t N> static Vector<N> one_of(const Vector<N, Lanes> &of, std::size_t k) {
        Vector<N> made;
        for (std::size_t i = 0; i < N; ++i) made[i] = of[i][k];
        return made;
    }

private:
    template <std::size_t N, class Verb, class... Given>
    static Vector<N, Lanes> each(Verb verb, const Given &...given) {
        Vector<N, Lanes> made;
        for (std::size_t k = 0; k < Lanes::COUNT; ++k) {
            const Vector<N> one = verb(one_of(given, k)...);
            for (std::size_t i = 0; i < N; ++i) made[i][k] = one[i];
        }
        return made;
    }
};

template <class R> struct NumbersOf { using type = double; };
template <class R> struct NumbersOf<InLanes<R>> { using type = Lanes; };

// Calls `action.template operator()<R>()` for the representation of that name, of those that have a
// scale beside them where poses have one.
template <Representation R, Representation... Others, class Action>
auto with_named(const std::string &name, bool scale, Action &&action) {
    if (name == R::name)
        return scale ? action.template operator()<WithScale<R>>() : action.template operator()<R>();
    if constexpr (sizeof...(Others) > 0)
        return with_named<Others...>(name, scale, action);
    else
        throw std::invalid_argument(
            "representation: expected one of motor, similarity, rotor, dual_quaternion, "
            "quaternion, euler_unwrapped, euler_xyz, euler, got '" +
            name + "'");
}

template <class Action>
auto with_representation(const std::string &name, bool scale, Action &&action) {
    if (name == Similarities::name)
        return scale ? action.template operator()<Similarities>()
                     : action.template operator()<RigidSimilarities>();
    return with_named<Motors, Rotors, Quaternions, DualQuaternions, EulerAngles,
                      UnwrappedEulerAngles, FollowedEulerAngles>(name, scale, action);
}

}  // namespace motorcade::smooth
