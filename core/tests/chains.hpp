// SPDX-License-Identifier: MIT
// Chains of actuators that the tests share.
#pragma once
#include <algorithm>
#include <cstdint>
#include <vector>

#include "seatrial/actuators/chain.hpp"

namespace boats {

using namespace seatrial;  // NOLINT(google-build-using-namespace)

/// Signs of Table I: rows F_u, F_v, F_r; columns thrusters 1 to 4.
inline constexpr double kSigns[3][4] = {{-1, -1, 1, 1}, {1, -1, 1, -1}, {1, -1, -1, 1}};

/// T = S/2 and T+ = S^T/2, without any stage.
inline Chain plain_chain(Scheme scheme) {
  Chain c;
  c.allocation.scheme = scheme;
  c.allocation.n_commands = 3;
  c.allocation.n_actuators = 4;
  c.allocation.offset = scheme == Scheme::kAlwaysForward ? 0.12 : 0.0;
  c.n_forces = 3;
  for (int k = 0; k < 4; ++k) {
    for (int j = 0; j < 3; ++j) {
      c.mix[j][k] = 0.5 * kSigns[j][k];
      c.allocation.inverse[k][j] = 0.5 * kSigns[j][k];
    }
  }
  return c;
}

/// Constants of full_chain.
enum Constant {
  kLatencyA,  // thrusters 1 and 3
  kLatencyB,  // thrusters 2 and 4
  kEdgeForward,
  kEdgeReverse,
  kReverseRatio,
  kPower,
  kLag,
  kScalePower,
  kGain0,
  kConstants = kGain0 + 4
};

/// Every stage. Without `lag` its constant stands in q but moves nothing.
inline Chain full_chain(Scheme scheme, bool lag = true) {
  Chain c = plain_chain(scheme);
  c.n_constants = kConstants;
  c.n_scales = 1;
  c.scale_reference[0] = 12.0;  // [V]
  for (int k = 0; k < 4; ++k) {
    Actuator& a = c.actuators[k];
    a.latency = k % 2 == 0 ? kLatencyA : kLatencyB;
    a.edge_forward = kEdgeForward;
    a.edge_reverse = kEdgeReverse;
    a.reverse_ratio = kReverseRatio;
    a.power = kPower;
    a.lag = lag ? std::int8_t{kLag} : std::int8_t{-1};
    a.scale_power = kScalePower;
    a.gain = static_cast<std::int8_t>(kGain0 + k);
    a.scale = 0;
  }
  return c;
}

inline std::vector<double> full_constants() {
  return {0.0831, 0.1273, 0.08, 0.11, 0.7, 1.3, 0.08, 1.7, 1.05, 0.95, 1.1, 0.9};
}

/// Five actuators that are commanded one by one: two stern, one bow tunnel, two of them alike;
/// latency for some only, a table for one.
inline Chain direct_chain() {
  Chain c;
  c.allocation.scheme = Scheme::kDirect;
  c.allocation.n_commands = 5;
  c.allocation.n_actuators = 5;
  c.allocation.limit = 0.8;
  c.n_forces = 3;
  c.n_constants = 6;  // latency, edge, reverse ratio, lag of 0-1, lag of 2-4, gain of 4
  const double mix[3][5] = {
      {0.5, 0.5, 0.0, 0.1, 0.2}, {0.0, 0.1, 1.0, 0.3, 0.4}, {-0.3, 0.3, 0.6, 0.0, -0.2}};
  for (int j = 0; j < 3; ++j) std::copy(mix[j], mix[j] + 5, c.mix[j]);
  for (int k = 0; k < 5; ++k) {
    Actuator& a = c.actuators[k];
    a.latency = k < 2 ? std::int8_t{0} : std::int8_t{-1};
    a.edge_forward = 1;
    a.edge_reverse = 1;
    a.reverse_ratio = 2;
    a.lag = k < 2 ? std::int8_t{3} : std::int8_t{4};
  }
  c.actuators[4].gain = 5;
  c.actuators[3].tabulated = true;
  c.n_table = 4;
  const double command[4] = {-1.0, -0.2, 0.3, 1.0};
  const double thrust[4] = {-0.6, 0.0, 0.0, 1.0};
  std::copy(command, command + 4, c.table_command);
  std::copy(thrust, thrust + 4, c.table_thrust);
  return c;
}

inline std::vector<double> direct_constants() { return {0.1137, 0.05, 0.6, 0.09, 0.21, 1.2}; }

/// Two propellers by components, 0 and 1, and mirrored 2 and 3; each component has its latency.
enum PairConstant {
  kAlongLatency,
  kAcrossLatency,
  kAlong,
  kAcross,
  kDead,
  kPairLag,
  kPairGain,  // of actuator 1
  kPairConstants
};

inline Chain paired_chain() {
  Chain c;
  c.allocation.n_commands = 4;
  c.allocation.n_actuators = 4;
  c.n_forces = 3;
  c.n_constants = kPairConstants;
  const double mix[3][4] = {{0.5, 0.0, 0.5, 0.0}, {0.0, 0.5, 0.0, 0.5}, {-0.1, -0.4, 0.1, -0.4}};
  for (int j = 0; j < 3; ++j) std::copy(mix[j], mix[j] + 4, c.mix[j]);
  for (int k = 0; k < 4; ++k) {
    Actuator& a = c.actuators[k];
    a.latency = k % 2 == 0 ? kAlongLatency : kAcrossLatency;
    a.lag = kPairLag;
    a.offset_along = kAlong;
    a.offset_across = kAcross;
    a.pair_dead_zone = kDead;
    a.partner = static_cast<std::int8_t>(k % 2 == 0 ? k + 1 : k - 1);
    a.across = k % 2 == 1;
  }
  c.actuators[3].mirrored = true;
  c.actuators[1].gain = kPairGain;
  return c;
}

inline std::vector<double> paired_constants() { return {0.31, 0.17, -0.05, 0.15, 0.2, 0.07, 1.1}; }

/// A propeller with a rudder (0, 1), which works in the flow too, and an azimuth thruster (2, 3).
enum SteeredConstant {
  kThrustLatency,
  kAngleLatency,
  kThrustEdge,
  kThrustLag,
  kAngleLag,  // of the azimuth thruster
  kRudderAngle,
  kRudderTrim,
  kRudderRate,
  kRudderZone,
  kAzimuthAngle,
  kAzimuthRate,
  kThrustRate,  // of the azimuth thruster
  kSteeredConstants
};

inline Chain steered_chain() {
  Chain c;
  c.allocation.n_commands = 4;
  c.allocation.n_actuators = 4;
  c.n_forces = 3;
  c.n_constants = kSteeredConstants;
  // places (-0.6, 0.1) and (0.5, -0.2) m
  const double mix[3][4] = {{1.0, 0.0, 0.7, 0.0}, {0.0, 1.0, 0.0, 0.7}, {-0.1, -0.6, 0.14, 0.35}};
  for (int j = 0; j < 3; ++j) std::copy(mix[j], mix[j] + 4, c.mix[j]);
  c.deflection[1][1] = 0.4;
  c.deflection[2][1] = -0.24;
  for (int k = 0; k < 4; ++k) {
    const bool angle = k % 2 == 1;
    Actuator& a = c.actuators[k];
    a.latency = angle ? kAngleLatency : kThrustLatency;
    a.lag = angle ? std::int8_t{-1} : std::int8_t{kThrustLag};
    a.edge_forward = a.edge_reverse = angle ? std::int8_t{-1} : std::int8_t{kThrustEdge};
    if (angle) a.steers = static_cast<std::int8_t>(k - 1);
  }
  Actuator& rudder = c.actuators[1];
  rudder.full_angle = kRudderAngle;
  rudder.angle_offset = kRudderTrim;
  rudder.slew_rate = kRudderRate;
  rudder.edge_forward = rudder.edge_reverse = kRudderZone;
  Actuator& azimuth = c.actuators[3];
  azimuth.full_angle = kAzimuthAngle;
  azimuth.slew_rate = kAzimuthRate;
  azimuth.lag = kAngleLag;
  c.actuators[2].slew_rate = kThrustRate;
  return c;
}

inline std::vector<double> steered_constants() {
  return {0.13, 0.07, 0.06, 0.21, 0.09, 35.0, -4.0, 61.0, 0.05, 150.0, 95.0, 3.7};
}

}  // namespace boats
