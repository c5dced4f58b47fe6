// SPDX-License-Identifier: MIT
// Actuators written out from their definitions, without recursion: what the chain is held against.
#pragma once
#include <algorithm>
#include <cmath>
#include <vector>

#include "boats.hpp"

namespace boats {

/// Static curve times gain of actuator k, written from its definition.
inline double curve_by_hand(const Chain& c, const std::vector<double>& q, int k, double command) {
  const Actuator& a = c.actuators[k];
  const auto value = [&q](int i, double neutral) {
    return i < 0 ? neutral : q[static_cast<std::size_t>(i)];
  };
  const bool forward = command >= 0.0;
  const double edge = value(forward ? a.edge_forward : a.edge_reverse, 0.0);
  const double share = std::max(0.0, std::abs(command) - edge) / (1.0 - edge);
  const double full = forward ? 1.0 : -value(a.reverse_ratio, 1.0);
  return value(a.gain, 1.0) * full * (share > 0.0 ? std::pow(share, value(a.power, 1.0)) : 0.0);
}

/// The same for a row of commands: of a pair, a vector's direction and length.
inline double target_by_hand(const Chain& c, const std::vector<double>& q, int k,
                             const double* thruster) {
  const Actuator& a = c.actuators[k];
  if (a.partner < 0) return curve_by_hand(c, q, k, thruster[k]);
  const auto value = [&q](int i, double neutral) {
    return i < 0 ? neutral : q[static_cast<std::size_t>(i)];
  };
  const int first = a.across ? a.partner : k;
  const int second = a.across ? k : a.partner;
  const double mirror = c.actuators[second].mirrored ? -1.0 : 1.0;
  const double along = thruster[first] + value(a.offset_along, 0.0);
  const double across = mirror * thruster[second] + value(a.offset_across, 0.0);
  const double dead = value(a.pair_dead_zone, 0.0);
  const double size = std::clamp((std::hypot(along, across) - dead) / (1.0 - dead), 0.0, 1.0);
  const double angle = std::atan2(across, along);
  return value(a.gain, 1.0) * size * (a.across ? mirror * std::sin(angle) : std::cos(angle));
}

/// Output f_k(t) of the whole chain as a sum of step responses (the lag is linear): no recursion.
inline double output_by_hand(const Chain& c, const std::vector<double>& q, const Script& commands,
                             const Script& scales, int k, double t) {
  const Actuator& a = c.actuators[k];
  const double latency = a.latency < 0 ? 0.0 : q[static_cast<std::size_t>(a.latency)];
  const double lag = a.lag < 0 ? 0.0 : q[static_cast<std::size_t>(a.lag)];
  double thruster[kMaxActuators];
  allocate(c.allocation, commands.row(0), thruster);
  double before = target_by_hand(c, q, k, thruster);
  double level = before;
  for (int i = 1; i < commands.size(); ++i) {
    allocate(c.allocation, commands.row(i), thruster);
    const double target = target_by_hand(c, q, k, thruster);
    const double since = t - commands.time[static_cast<std::size_t>(i)] - latency;
    if (since >= 0.0) {
      level += (target - before) * (lag > 0.0 ? -std::expm1(-since / lag) : 1.0);
    }
    before = target;
  }
  if (a.scale < 0 || scales.size() == 0) return level;
  const double ratio = scales.holding(t)[a.scale] / c.scale_reference[a.scale];
  const double power = a.scale_power < 0 ? 1.0 : q[static_cast<std::size_t>(a.scale_power)];
  return level * std::pow(ratio, power);
}

/// F(t) by the same sum.
inline void forces_by_hand(const Chain& c, const std::vector<double>& q, const Script& commands,
                           const Script& scales, double t, double* force) {
  std::fill(force, force + c.n_forces, 0.0);
  for (int k = 0; k < c.n_actuators(); ++k) {
    const double output = output_by_hand(c, q, commands, scales, k, t);
    for (int j = 0; j < c.n_forces; ++j) force[j] += c.mix[j][k] * output;
  }
}
}  // namespace boats
