// The generated motion, compiled here. A step and its transition have most of their terms in
// common: inlined into one function these are computed once.

#include "generated/motion.c"

#include <algorithm>

#include "clones.h"
#include "state.h"

namespace motorcade::filter {

namespace {

// Copies, so that nothing written may be something read: else nothing would be in common.
template <auto transition, auto step>
MOTORCADE_INLINE void go_on(State &state, const Reading &read, double dt, const double *fall,
                            Transition &made) {
    double pose[8], velocity[3], bias[6], gravity[3], next[8], faster[3];
    const Reading own = read;
    std::copy_n(state.pose, 8, pose);
    std::copy_n(state.velocity, 3, velocity);
    std::copy_n(state.bias, 6, bias);
    std::copy_n(fall, 3, gravity);
    made.dt = dt;
    transition(bias, own.rate, own.force, dt, made.turn_turn, made.position_turn,
               made.velocity_turn, made.turn_gyro, made.position_gyro, made.velocity_gyro,
               made.position_accel, made.velocity_accel);
    step(pose, velocity, bias, own.rate, own.force, dt, gravity, next, faster);
    std::copy_n(next, 8, state.pose);
    std::copy_n(faster, 3, state.velocity);
}

}  // namespace

MOTORCADE_CLONES MOTORCADE_FLAT void moved(State &state, const Reading &read, double dt,
                                           const double *fall, Transition &made) {
    go_on<motorcade_transition, motorcade_step>(state, read, dt, fall, made);
}

MOTORCADE_CLONES MOTORCADE_FLAT void moved_held(State &state, const Reading &read, double dt,
                                                const double *fall, Transition &made) {
    go_on<motorcade_held_transition, motorcade_held_step>(state, read, dt, fall, made);
}

}  // namespace motorcade::filter
