// SPDX-License-Identifier: MIT
// Constants of the actuator chain, and the static curve from command to thrust: of the actuator
// alone, of two together (a pair), or of an angle that turns another one's thrust.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>

#include "seatrial/actuators/allocation.hpp"
#include "seatrial/model/frames.hpp"
#include "seatrial/model/structure.hpp"

namespace seatrial {

inline constexpr int kMaxConstants = 32;        // chain constants q of all actuators together
inline constexpr int kMaxScales = 4;            // known scale signals (propeller speed, voltage)
inline constexpr int kMaxTable = 256;           // points of a tabulated curve
inline constexpr double kDegree = kPi / 180.0;  // [rad]

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
  std::int8_t slew_rate = -1;     // [1/s] rate limit of the thrust, > 0; [deg/s] of an angle
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

/// Curve of actuator k that depends on its own command alone, without its gain: the table, or edges
/// and power. slope[i] += share d g / d q_i.
inline double single_curve(const Chain& c, const double* q, int k, double command, double share,
                           double* slope) {
  const Actuator& a = c.actuators[k];
  return a.tabulated ? interpolate(c, command) : edges_and_power(a, q, command, share, slope);
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
  const double g = single_curve(c, q, k, command, full, slope);
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
  const double g = a.partner >= 0 ? detail::of_pair(c, q, k, thruster, gain, slope)
                                  : detail::single_curve(c, q, k, thruster[k], gain, slope);
  if (slope != nullptr && a.gain >= 0) slope[a.gain] += g;
  return gain * g;
}

}  // namespace seatrial
