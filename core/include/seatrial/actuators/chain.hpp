// SPDX-License-Identifier: MIT
// The actuator chain: command -> latency -> static curve, of the actuator alone or of two together
// (a pair) -> first-order lag -> scale -> F = T f. An actuator may be the angle that turns another
// one's thrust (rudder, outboard, azimuth thruster).
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "seatrial/actuators/curve.hpp"
#include "seatrial/actuators/rate_limit.hpp"

namespace seatrial {

/// Whether every pair is one: two actuators, each other's partner, with the same constants of the
/// pair and none of the single curve.
inline bool pairs_are_whole(const Chain& c) {
  for (int k = 0; k < c.n_actuators(); ++k) {
    const Actuator& a = c.actuators[k];
    if (a.partner < 0) {
      if (a.offset_along >= 0 || a.offset_across >= 0 || a.pair_dead_zone >= 0) return false;
      continue;
    }
    if (a.partner >= c.n_actuators() || a.partner == k) return false;
    const Actuator& b = c.actuators[a.partner];
    const bool alike = a.offset_along == b.offset_along && a.offset_across == b.offset_across &&
                       a.pair_dead_zone == b.pair_dead_zone;
    const bool curved =
        a.edge_forward >= 0 || a.edge_reverse >= 0 || a.reverse_ratio >= 0 || a.power >= 0;
    if (b.partner != k || a.across == b.across || !alike || curved || a.tabulated) return false;
  }
  return true;
}

/// Whether every angle turns another actuator's thrust, at most one does each, and none has a stage
/// of thrust; stages of angles belong to angles.
inline bool angles_are_whole(const Chain& c) {
  bool turned[kMaxActuators] = {};
  for (int k = 0; k < c.n_actuators(); ++k) {
    const Actuator& a = c.actuators[k];
    if (a.steers < 0) {
      if (a.full_angle >= 0 || a.angle_offset >= 0) return false;
      continue;
    }
    const bool another = a.steers < c.n_actuators() && a.steers != k;
    const bool thrusts = a.partner >= 0 || a.gain >= 0 || a.scale >= 0;
    if (!another || thrusts || a.full_angle < 0 || turned[a.steers]) return false;
    if (c.actuators[a.steers].steers >= 0 || c.actuators[a.steers].partner >= 0) return false;
    turned[a.steers] = true;
  }
  return true;
}

/// Multiplier (s / s_ref)^p of actuator k; 1 without a scale signal.
inline double multiplier(const Chain& c, const double* q, int k, const double* scale,
                         double* slope) {
  const Actuator& a = c.actuators[k];
  if (a.scale < 0) return 1.0;
  const double ratio = scale[a.scale] / c.scale_reference[a.scale];
  if (!(ratio > 0.0)) return 0.0;
  const double m = std::pow(ratio, detail::constant(q, a.scale_power, 1.0));
  if (slope != nullptr && a.scale_power >= 0) slope[a.scale_power] += m * std::log(ratio);
  return m;
}

/// exp(-h / lag), 0 without a lag: what is left of the distance to the target after h [s].
inline double decay(const Chain& c, const double* q, int k, double h) {
  const double lag = detail::constant(q, c.actuators[k].lag, 0.0);
  return lag > kShortestLag ? std::exp(-h / lag) : 0.0;
}

/// A level's unit in that of its rate limit: the thrust's is itself, an angle's [rad] is in
/// degrees.
inline double slew_unit(const Actuator& a) { return a.steers >= 0 ? kDegree : 1.0; }

/// Rate limit of actuator k's level [1/s]; 0: none.
inline double rate_limit(const Chain& c, const double* q, int k) {
  const Actuator& a = c.actuators[k];
  return slew_unit(a) * detail::constant(q, a.slew_rate, 0.0);
}

/// Whether actuator k's level jumps to its target: neither lag nor rate limit.
inline bool follows_at_once(const Chain& c, const double* q, int k) {
  return !(detail::constant(q, c.actuators[k].lag, 0.0) > kShortestLag) &&
         c.actuators[k].slew_rate < 0;
}

/// Remaining fraction of (level - target) of a first-order lag at the three Runge-Kutta nodes of a
/// step of h [s], chosen so that the step integrates a lagged force exactly into velocity and into
/// position. x = h / lag.
struct LagDecay {
  double end = 0.0;     // exp(-x)
  double middle = 0.0;  // tends to exp(-x / 2) for small x
  double begin = 0.0;   // tends to 1 for small x
  // an actuator with a rate limit has these instead
  double rate = 0.0;  // [1/s] of its level; 0: none
  double lag = 0.0;   // [s]
  double step = 0.0;  // [s]
};

namespace detail {

/// Mean over the step of exp(-x s), s in (0, 1), and of (1 - s) exp(-x s); derivatives to x.
struct Left {
  double mean, moment;
  double dmean, dmoment;
};

inline Left left_of(double x, double end) {
  if (x < 1e-2) {  // series: differences of nearly equal numbers otherwise
    return {1.0 - x * (0.5 - x * (1.0 / 6.0 - x * (1.0 / 24.0 - x * (1.0 / 120.0 - x / 720.0)))),
            0.5 - x * (1.0 / 6.0 -
                       x * (1.0 / 24.0 - x * (1.0 / 120.0 - x * (1.0 / 720.0 - x / 5040.0)))),
            -0.5 + x * (1.0 / 3.0 - x * (0.125 - x * (1.0 / 30.0 - x / 144.0))),
            -1.0 / 6.0 + x * (1.0 / 12.0 - x * (0.025 - x * (1.0 / 180.0 - x / 1008.0)))};
  }
  const double mean = -std::expm1(-x) / x;
  const double moment = (1.0 - mean) / x;
  const double dmean = (end - mean) / x;
  return {mean, moment, dmean, -(dmean + moment) / x};
}

}  // namespace detail

/// The decay over x = h / lag, and its derivative to x. A Runge-Kutta step has h (f0 + 4 f1 +
/// f2) / 6 of a force in its velocity and h^2 (f0 + 2 f1) / 6 in its position. However short the
/// lag is beside the step both are exact: 1 and exp(-x / 2) would act like up to h / 6 of latency.
inline LagDecay lag_decay(double x, LagDecay* slope = nullptr) {
  const double end = std::exp(-x);
  const detail::Left l = detail::left_of(x, end);
  if (slope != nullptr) {
    slope->end = -end;
    slope->middle = 0.5 * (6.0 * l.dmean + end - 6.0 * l.dmoment);
    slope->begin = 12.0 * l.dmoment - 6.0 * l.dmean - end;
  }
  return {end, 0.5 * (6.0 * l.mean - end - 6.0 * l.moment), 12.0 * l.moment - 6.0 * l.mean + end};
}

/// Thrust at one instant: level, target and multiplier of each actuator.
struct Thrust {
  double level[kMaxActuators] = {};       // after the lag and the rate limit; [rad] of an angle
  double target[kMaxActuators] = {};      // what the level tends to
  double multiplier[kMaxActuators] = {};  // of the known scale signal
};

inline constexpr double kArrived =
    1e-9;  // of the level, beyond the end of the rate limit: rounding

/// [s] until actuator k's rate limit no longer holds it back; infinite where it does not now.
inline double time_limited(const Chain& c, const double* q, const Thrust& f, int k) {
  const double rate = rate_limit(c, q, k);
  if (!(rate > 0.0)) return std::numeric_limits<double>::infinity();
  const double lag = detail::constant(q, c.actuators[k].lag, 0.0);
  const double past = std::abs(f.level[k] - f.target[k]) - (lag > kShortestLag ? rate * lag : 0.0);
  return past > kArrived ? past / rate : std::numeric_limits<double>::infinity();
}

/// Of `length` [s] from here the part in which no actuator reaches the end of its rate limit: the
/// thrust is smooth over it.
inline double smooth_part(const Chain& c, const double* q, const Thrust& f, double length) {
  for (int k = 0; k < c.n_actuators(); ++k) length = std::min(length, time_limited(c, q, f, k));
  return length;
}

/// Level of actuator k after h [s] with a constant target: exact.
inline double level_after(const Chain& c, const double* q, const Thrust& f, int k, double h) {
  const double away = f.level[k] - f.target[k];
  const double rate = rate_limit(c, q, k);
  if (rate > 0.0) {
    const double lag = detail::constant(q, c.actuators[k].lag, 0.0);
    return f.target[k] + rate_limited(away, rate, lag, h).left;
  }
  return f.target[k] + away * decay(c, q, k, h);
}

/// Sine and cosine of the angle that actuator k is.
struct Turn {
  double cos, sin;
};

inline Turn turn_of(const double* f, int k) { return {std::cos(f[k]), std::sin(f[k])}; }

/// F = T f + D sin(angle), with f_k = multiplier_k level_k. A thrust f that an angle turns is
/// f cos(angle) in its own place and f sin(angle) in the angle's.
inline void mix_forces(const Chain& c, const double* f, double* force) {
  double output[kMaxActuators];
  double sine[kMaxActuators] = {};
  for (int k = 0; k < c.n_actuators(); ++k) output[k] = f[k];
  for (int k = 0; k < c.n_actuators(); ++k) {
    const int turned = c.actuators[k].steers;
    if (turned < 0) continue;
    const Turn t = turn_of(f, k);
    output[turned] = f[turned] * t.cos;
    output[k] = f[turned] * t.sin;
    sine[k] = t.sin;
  }
  for (int j = 0; j < c.n_forces; ++j) {
    double sum = 0.0;
    for (int k = 0; k < c.n_actuators(); ++k) {
      sum += c.mix[j][k] * output[k] + c.deflection[j][k] * sine[k];
    }
    force[j] = sum;
  }
}

/// Derivatives of `mix_forces` at f by those of f, for n parameters: df[k] and dforce[j] are rows.
template <class Rows, class Forces>
inline void mix_slopes(const Chain& c, const double* f, const Rows& df, int n, Forces& dforce) {
  bool turned[kMaxActuators] = {};
  for (int k = 0; k < c.n_actuators(); ++k) {
    if (c.actuators[k].steers >= 0) turned[c.actuators[k].steers] = true;
  }
  for (int j = 0; j < c.n_forces; ++j) {
    for (int p = 0; p < n; ++p) dforce[j][p] = 0.0;
    for (int k = 0; k < c.n_actuators(); ++k) {
      const int own = c.actuators[k].steers;
      if (turned[k]) continue;  // with its angle
      if (own < 0) {
        for (int p = 0; p < n; ++p) dforce[j][p] += c.mix[j][k] * df[k][p];
        continue;
      }
      const Turn t = turn_of(f, k);
      const double to_thrust = c.mix[j][own] * t.cos + c.mix[j][k] * t.sin;
      const double to_angle =
          f[own] * (c.mix[j][k] * t.cos - c.mix[j][own] * t.sin) + c.deflection[j][k] * t.cos;
      for (int p = 0; p < n; ++p) dforce[j][p] += to_thrust * df[own][p] + to_angle * df[k][p];
    }
  }
}

/// Generalised forces F after h [s] with constant targets.
inline void forces_after(const Chain& c, const double* q, const Thrust& f, double h,
                         double* force) {
  double output[kMaxActuators];
  for (int k = 0; k < c.n_actuators(); ++k) {
    output[k] = f.multiplier[k] * level_after(c, q, f, k, h);
  }
  mix_forces(c, output, force);
}

}  // namespace seatrial
