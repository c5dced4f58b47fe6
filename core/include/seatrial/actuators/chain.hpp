// SPDX-License-Identifier: MIT
// The actuator chain: command -> latency -> static curve, of the actuator alone or of two together
// (a pair) -> first-order lag -> scale -> F = T f. An actuator may be the angle that turns another
// one's thrust (rudder, outboard, azimuth thruster).
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "seatrial/actuators/allocation.hpp"
#include "seatrial/actuators/rate_limit.hpp"
#include "seatrial/model/structure.hpp"

namespace seatrial {

inline constexpr int kMaxConstants = 32;  // chain constants q of all actuators together
inline constexpr int kMaxScales = 4;      // known scale signals (propeller speed, voltage)
inline constexpr int kMaxTable = 256;     // points of a tabulated curve
inline constexpr double kDegree = 3.14159265358979323846 / 180.0;  // [rad]

/// Where the constants of one actuator stand in q; -1: stage absent (its neutral value).
struct Actuator {
  std::int8_t latency = -1;        // [s] transport delay plus clock offset; may be negative
  std::int8_t edge_forward = -1;   // [-] dead-zone edge at positive commands, >= 0
  std::int8_t edge_reverse = -1;   // [-] dead-zone edge at negative commands, >= 0
  std::int8_t reverse_ratio = -1;  // [-] full reverse over full forward thrust
  std::int8_t power = -1;          // [-] exponent of the curve past its edge
  std::int8_t lag = -1;            // [s] time constant
  std::int8_t scale_power = -1;    // [-] exponent of (scale / reference)
  std::int8_t gain = -1;           // [-] of this actuator; the gains have mean 1
  // of a pair, whose two commands are the components of one vector; the same for both of them
  std::int8_t offset_along = -1;    // [-] added to the first component
  std::int8_t offset_across = -1;   // [-] added to the second
  std::int8_t pair_dead_zone = -1;  // [-] of the vector's length, >= 0
  // of an angle, whose level is in rad
  std::int8_t full_angle = -1;    // [deg] at full command
  std::int8_t angle_offset = -1;  // [deg] at no command (trim)
  std::int8_t angle_rate = -1;    // [deg/s] rate limit, > 0
  std::int8_t scale = -1;         // which scale signal; -1: none
  bool tabulated = false;         // the table instead of edges and power
  std::int8_t partner = -1;       // the pair's other actuator; -1: no pair
  bool across = false;            // the pair's second component
  bool mirrored = false;          // its command counts with the other sign in the vector
  std::int8_t steers = -1;        // the actuator whose thrust this angle turns; -1: no angle
};

/// Structure of the chain; its constants q are kept apart, so that they can be estimated.
struct Chain {
  Allocation allocation;
  int n_forces = 0;
  int n_scales = 0;
  int n_constants = 0;
  double mix[kMaxForces][kMaxActuators] = {};         // T: F = T f
  double deflection[kMaxForces][kMaxActuators] = {};  // F += D sin(angle): a rudder in the flow
  double scale_reference[kMaxScales] = {1.0, 1.0, 1.0, 1.0};
  Actuator actuators[kMaxActuators];
  int n_table = 0;
  double table_command[kMaxTable] = {};
  double table_thrust[kMaxTable] = {};

  int n_actuators() const { return allocation.n_actuators; }
};

namespace detail {

inline double constant(const double* q, std::int8_t index, double neutral) {
  return index >= 0 ? q[index] : neutral;
}

/// Piecewise linear, held constant outside the table; NaN stays NaN.
inline double interpolate(const Chain& c, double x) {
  if (std::isnan(x)) return x;
  const double* begin = c.table_command;
  const double* end = begin + c.n_table;
  const double* above = std::upper_bound(begin, end, x);
  if (above == begin) return c.table_thrust[0];
  if (above == end) return c.table_thrust[c.n_table - 1];
  const auto i = above - begin;
  const double share = (x - begin[i - 1]) / (begin[i] - begin[i - 1]);
  return c.table_thrust[i - 1] + share * (c.table_thrust[i] - c.table_thrust[i - 1]);
}

}  // namespace detail

namespace detail {

/// Edges and power: g(1) = 1, g = 0 between the edges. slope[i] += share d g / d q_i.
inline double edges_and_power(const Actuator& a, const double* q, double command, double share,
                              double* slope) {
  const bool forward = command >= 0.0;
  const std::int8_t edge_at = forward ? a.edge_forward : a.edge_reverse;
  const double edge = constant(q, edge_at, 0.0);
  const double power = constant(q, a.power, 1.0);
  const double full = forward ? 1.0 : -constant(q, a.reverse_ratio, 1.0);
  const double past = std::abs(command) - edge;
  if (past <= 0.0) return 0.0;
  const double w = past / (1.0 - edge);
  const double shape = a.power >= 0 ? std::pow(w, power) : w;
  const double g = full * shape;
  if (slope != nullptr) {
    const double dshape = a.power >= 0 ? power * shape / w : 1.0;  // d shape / d w
    const double dw = (w - 1.0) / (1.0 - edge);                    // d w / d edge
    if (edge_at >= 0) slope[edge_at] += share * full * dshape * dw;
    if (a.power >= 0) slope[a.power] += share * g * std::log(w);
    if (!forward && a.reverse_ratio >= 0) slope[a.reverse_ratio] += -share * shape;
  }
  return g;
}

/// A component of the pair's vector P.
inline double component(const Actuator& a, const double* q, double command) {
  const double offset = constant(q, a.across ? a.offset_across : a.offset_along, 0.0);
  return (a.mirrored ? -command : command) + offset;
}

/// Own component of P / |P| (min(|P|, 1) - d) / (1 - d), mirrored back; 0 where |P| <= d.
/// slope[i] += share d / d q_i.
inline double of_pair(const Chain& c, const double* q, int k, const double* thruster, double share,
                      double* slope) {
  const Actuator& a = c.actuators[k];
  const double own = component(a, q, thruster[k]);
  const double other = component(c.actuators[a.partner], q, thruster[a.partner]);
  const double dead = constant(q, a.pair_dead_zone, 0.0);
  const double length = std::hypot(own, other);
  if (length <= dead) return 0.0;
  const double sign = a.mirrored ? -1.0 : 1.0;
  const bool limited = length >= 1.0;
  const double left = limited ? 1.0 : (length - dead) / (1.0 - dead);
  const double ratio = left / length;
  if (slope != nullptr) {
    const double dleft = limited ? 0.0 : 1.0 / (1.0 - dead);            // d left / d length
    const double bend = share * sign * own * (dleft - ratio) / length;  // share d out / d length
    const std::int8_t own_at = a.across ? a.offset_across : a.offset_along;
    const std::int8_t other_at = a.across ? a.offset_along : a.offset_across;
    if (own_at >= 0) slope[own_at] += bend * own / length + share * sign * ratio;
    if (other_at >= 0) slope[other_at] += bend * other / length;
    if (a.pair_dead_zone >= 0 && !limited) {
      slope[a.pair_dead_zone] += share * sign * own / length * (left - 1.0) / (1.0 - dead);
    }
  }
  return sign * own * ratio;
}

/// Angle [rad]: the single curve of its command times the full angle, and the offset.
/// slope[i] += d / d q_i.
inline double of_angle(const Chain& c, const double* q, int k, double command, double* slope) {
  const Actuator& a = c.actuators[k];
  const double full = kDegree * constant(q, a.full_angle, 0.0);
  const double g =
      a.tabulated ? interpolate(c, command) : edges_and_power(a, q, command, full, slope);
  if (slope != nullptr) {
    if (a.full_angle >= 0) slope[a.full_angle] += kDegree * g;
    if (a.angle_offset >= 0) slope[a.angle_offset] += kDegree;
  }
  return full * g + kDegree * constant(q, a.angle_offset, 0.0);
}

}  // namespace detail

/// Static curve of actuator k with its gain, for one row of commands to all actuators.
/// Where `slope` is given, slope[i] += d target / d q_i (n_constants entries).
inline double curve(const Chain& c, const double* q, int k, const double* thruster, double* slope) {
  const Actuator& a = c.actuators[k];
  if (a.steers >= 0) return detail::of_angle(c, q, k, thruster[k], slope);
  const double gain = detail::constant(q, a.gain, 1.0);
  double g = 0.0;
  if (a.partner >= 0) {
    g = detail::of_pair(c, q, k, thruster, gain, slope);
  } else if (a.tabulated) {
    g = detail::interpolate(c, thruster[k]);
  } else {
    g = detail::edges_and_power(a, q, thruster[k], gain, slope);
  }
  if (slope != nullptr && a.gain >= 0) slope[a.gain] += g;
  return gain * g;
}

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
      if (a.full_angle >= 0 || a.angle_offset >= 0 || a.angle_rate >= 0) return false;
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

/// Rate limit of actuator k's level [1/s]; 0: none.
inline double rate_limit(const Chain& c, const double* q, int k) {
  return kDegree * detail::constant(q, c.actuators[k].angle_rate, 0.0);
}

/// Whether actuator k's level jumps to its target: neither lag nor rate limit.
inline bool follows_at_once(const Chain& c, const double* q, int k) {
  return !(detail::constant(q, c.actuators[k].lag, 0.0) > kShortestLag) &&
         c.actuators[k].angle_rate < 0;
}

/// What a lag leaves, over one step, of an actuator's distance to its target, by the nodes of the
/// step: such that its velocity and its position both have the exact integrals of what is left.
struct LagDecay {
  double end = 0.0;     // as it is there
  double middle = 0.0;  // like exp(-x / 2) where the lag is long beside the step
  double begin = 0.0;   // like 1
  // of an actuator with a rate limit, which has these instead
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

inline constexpr double kArrived = 1e-9;  // [rad] beyond the end of the rate limit: rounding

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
