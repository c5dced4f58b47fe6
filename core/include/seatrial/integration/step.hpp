// SPDX-License-Identifier: MIT
// One step of the boat: the only integrator. Simulator, estimator, validation and on-board
// predictor all call these functions.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>

#include "seatrial/actuators/chain.hpp"
#include "seatrial/model/dynamics.hpp"
#include "seatrial/model/frames.hpp"

namespace seatrial {

inline constexpr int kStates = 6;  // x, y [m], psi [rad], u, v [m/s], r [rad/s]

enum class Integrator : std::uint8_t {
  kRungeKutta,   // classical fourth order between the breaks of the input
  kForwardEuler  // the paper's: one step per pose, input held from the step's start
};

/// x_dot of the whole state.
template <class T>
inline bool state_rate(const Structure& s, const T* coefficient, const T* x, const T* force,
                       T* x_dot) {
  body_to_earth(x[2], x + 3, x_dot);                             // Eq. (1)
  return acceleration(s, coefficient, x + 3, force, x_dot + 3);  // Eq. (12)
}

/// Forward Euler over h [s].
template <class T>
inline bool euler_step(const Structure& s, const T* coefficient, const T& h, const T* force, T* x) {
  T k[kStates];
  const bool solved = state_rate(s, coefficient, x, force, k);
  for (int i = 0; i < kStates; ++i) x[i] = x[i] + h * k[i];
  return solved;
}

/// Classical Runge-Kutta over h [s]; force[0..2] at the begin, the middle and the end.
template <class T>
inline bool runge_kutta_step(const Structure& s, const T* coefficient, const T& h,
                             const T force[3][kMaxForces], T* x) {
  T k[kStates] = {};
  T sum[kStates] = {};
  T at[kStates];
  static constexpr int kNode[4] = {0, 1, 1, 2};
  static constexpr double kShare[4] = {0.0, 0.5, 0.5, 1.0};
  static constexpr double kWeight[4] = {1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0};
  bool solved = true;
  for (int stage = 0; stage < 4; ++stage) {
    for (int i = 0; i < kStates; ++i) at[i] = x[i] + T(kShare[stage]) * h * k[i];
    solved = state_rate(s, coefficient, at, force[kNode[stage]], k) && solved;
    for (int i = 0; i < kStates; ++i) sum[i] = sum[i] + T(kWeight[stage]) * k[i];
  }
  for (int i = 0; i < kStates; ++i) x[i] = x[i] + h * sum[i];
  return solved;
}

/// Whether the state is bounded: false where it diverged.
inline bool bounded(const double* x) {
  return std::all_of(x, x + kStates, [](double value) { return std::abs(value) < 1e9; });
}

/// Number of equal steps of at most `longest` [s] that fill `length` [s].
inline int steps_for(double length, double longest) {
  return std::max(1, static_cast<int>(std::ceil(length / longest - 1e-9)));
}

/// Decay of each actuator's lag over a step of h [s]; at once where it has none.
inline void lag_decays(const Chain& c, const double* q, double h, LagDecay* decays) {
  for (int k = 0; k < c.n_actuators(); ++k) {
    const double lag = detail::constant(q, c.actuators[k].lag, 0.0);
    const double rate = rate_limit(c, q, k);
    if (rate > 0.0) {
      decays[k] = {0.0, 0.0, 0.0, rate, lag, h};
      continue;
    }
    const bool same =
        k > 0 && c.actuators[k].lag == c.actuators[k - 1].lag && decays[k - 1].rate == 0.0;
    decays[k] = same ? decays[k - 1] : (lag > kShortestLag ? lag_decay(h / lag) : LagDecay{});
  }
}

/// Distance to the target at begin, middle and end of a step: exact at these with a rate limit,
/// which bounds what Simpson's rule misses.
inline void distances(const LagDecay& d, double away, double left[3]) {
  if (d.rate > 0.0) {
    left[0] = away;
    left[1] = rate_limited(away, d.rate, d.lag, 0.5 * d.step).left;
    left[2] = rate_limited(away, d.rate, d.lag, d.step).left;
    return;
  }
  left[0] = away * d.begin;
  left[1] = away * d.middle;
  left[2] = away * d.end;
}

/// Forces at begin, middle and end of a step without a break; the levels move to its end.
inline void step_forces(const Chain& c, const LagDecay* decays, Thrust& f,
                        double force[3][kMaxForces]) {
  double output[3][kMaxActuators];
  for (int k = 0; k < c.n_actuators(); ++k) {
    double left[3];
    distances(decays[k], f.level[k] - f.target[k], left);
    for (int node = 0; node < 3; ++node) {
      output[node][k] = f.multiplier[k] * (f.target[k] + left[node]);
    }
    f.level[k] = f.target[k] + left[2];
  }
  for (int node = 0; node < 3; ++node) mix_forces(c, output[node], force[node]);
}

namespace detail {

/// Boat and thrusters over `length` [s] in which the thrust is smooth. False where it diverged.
inline bool advance_smooth(const Structure& s, const double* coefficient, const Chain& c,
                           const double* q, double length, double longest, Thrust& f, double* x) {
  const int n = steps_for(length, longest);
  const double h = length / n;
  LagDecay decays[kMaxActuators];
  double force[3][kMaxForces];
  lag_decays(c, q, h, decays);
  for (int i = 0; i < n; ++i) {
    step_forces(c, decays, f, force);
    if (!runge_kutta_step(s, coefficient, h, force, x)) return false;
  }
  return bounded(x);
}

}  // namespace detail

/// Boat and thrusters over `length` [s] without a break of the input. False where it diverged.
inline bool advance(const Structure& s, const double* coefficient, const Chain& c, const double* q,
                    double length, double longest, Thrust& f, double* x) {
  if (!(length > 0.0)) return true;
  // without a lag the level has jumped to its target
  for (int k = 0; k < c.n_actuators(); ++k) f.level[k] = level_after(c, q, f, k, 0.0);
  while (length > 0.0) {
    const double part = smooth_part(c, q, f, length);
    if (!detail::advance_smooth(s, coefficient, c, q, part, longest, f, x)) return false;
    length -= part;
  }
  return true;
}

}  // namespace seatrial
