// SPDX-License-Identifier: MIT
// What a model's covariance amounts to on board. Its coefficients' errors are constant, but what
// they do changes as the boat is driven: like a disturbance with some memory. Errors of latency and
// lag leave a kick behind at every change of a command: like a random walk. No heap, no exceptions.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>

#include "seatrial/belief.hpp"

namespace seatrial {

inline constexpr int kMaxParameters = kMaxCoefficients + kMaxConstants;

/// A model, with what is known of its errors and where it was identified.
struct UncertainModel {
  Structure structure;
  double coefficient[kMaxCoefficients] = {};
  Chain chain;
  double q[kMaxConstants] = {};
  double speed[kAxes][2] = {};                             // [m/s, m/s, rad/s] least, most
  double covariance[kMaxParameters][kMaxParameters] = {};  // coefficients, then constants

  int n_parameters() const { return structure.n_coefficients + chain.n_constants; }
};

/// What its errors do.
struct Doubt {
  double disturbance[kAxes] = {};  // [m/s^2, m/s^2, rad/s^2] standard deviations
  double walk[kAxes] = {};         // [m/s, m/s, rad/s per sqrt(s)]
};

namespace detail {

inline constexpr int kDoubtSamples = 200;       // speeds and commands that it is averaged over
inline constexpr double kCommandChanges = 1.0;  // [1/s] each to any other
inline constexpr double kDoubtMemory = 2.0;     // [s] a stretch of driving in one way

/// Less is not believed, so that the covariance keeps its digits.
inline constexpr MotionNoise kLeastNoise{1e-4, 1e-4, 1e-6, 1e-6, 1e-5, 1e-5, 0.3, 1e-5, 1e-5, 0.02};

/// Splitmix64: the same numbers on every machine.
class Dice {
 public:
  double operator()(double low, double high) {
    std::uint64_t z = state_ += 0x9e3779b97f4a7c15U;
    z = (z ^ (z >> 30U)) * 0xbf58476d1ce4e5b9U;
    z = (z ^ (z >> 27U)) * 0x94d049bb133111ebU;
    z ^= z >> 31U;
    return low + (high - low) * std::ldexp(static_cast<double>(z >> 11U), -53);
  }

 private:
  std::uint64_t state_ = 0;
};

/// Slopes of the three accelerations to every parameter.
struct Slopes {
  double row[kAxes][kMaxParameters] = {};
};

/// Forces of thrusters settled at a command; d output_k / d q where asked for.
inline void settled_forces(const UncertainModel& m, const double* command,
                           double (*slope)[kMaxConstants], double* output, double* force) {
  double thruster[kMaxActuators];
  allocate(m.chain.allocation, command, thruster);
  for (int k = 0; k < m.chain.n_actuators(); ++k) {
    output[k] = curve(m.chain, m.q, k, thruster, slope == nullptr ? nullptr : slope[k]);
  }
  mix_forces(m.chain, output, force);
}

/// To coefficients and to the constants of the curves, at nu and settled at a command.
inline void acceleration_slopes(const UncertainModel& m, const double* nu, const double* command,
                                Slopes& out) {
  double dcurve[kMaxActuators][kMaxConstants] = {};
  double output[kMaxActuators];
  double force[kMaxForces];
  double nu_dot[kAxes];
  AccelerationJacobian j;
  settled_forces(m, command, dcurve, output, force);
  if (!acceleration_with_jacobian(m.structure, m.coefficient, nu, force, nu_dot, j)) return;
  for (int a = 0; a < kAxes; ++a) {
    std::copy(j.coefficient[a], j.coefficient[a] + m.structure.n_coefficients, out.row[a]);
    double* constants = out.row[a] + m.structure.n_coefficients;
    for (int k = 0; k < m.chain.n_actuators(); ++k) {
      double by_thrust = 0.0;
      for (int f = 0; f < m.chain.n_forces; ++f) by_thrust += j.force[a][f] * m.chain.mix[f][k];
      for (int i = 0; i < m.chain.n_constants; ++i) constants[i] += by_thrust * dcurve[k][i];
    }
  }
}

/// To latencies and lags: a change of the acceleration by a that comes so much too late leaves a
/// times that of velocity behind.
inline void kick_slopes(const UncertainModel& m, const double* nu, const double* before,
                        const double* after, Slopes& out) {
  double old_output[kMaxActuators];
  double new_output[kMaxActuators];
  double force[kMaxForces];
  double start[kAxes];
  double end[kAxes];
  settled_forces(m, after, nullptr, new_output, force);
  settled_forces(m, before, nullptr, old_output, force);
  if (!acceleration(m.structure, m.coefficient, nu, force, start)) return;
  for (int i = 0; i < m.chain.n_constants; ++i) {
    double output[kMaxActuators];
    bool used = false;
    for (int k = 0; k < m.chain.n_actuators(); ++k) {
      const bool own = m.chain.actuators[k].latency == i || m.chain.actuators[k].lag == i;
      output[k] = own ? new_output[k] : old_output[k];
      used = used || own;
    }
    if (!used) continue;
    mix_forces(m.chain, output, force);
    acceleration(m.structure, m.coefficient, nu, force, end);
    for (int a = 0; a < kAxes; ++a) {
      out.row[a][m.structure.n_coefficients + i] = end[a] - start[a];
    }
  }
}

/// sum[a] += the variance that the errors give, by slopes.
inline void add_variance(const UncertainModel& m, const Slopes& by, double* sum) {
  const int n = m.n_parameters();
  for (int a = 0; a < kAxes; ++a) {
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j < n; ++j) sum[a] += by.row[a][i] * m.covariance[i][j] * by.row[a][j];
    }
  }
}

}  // namespace detail

/// The doubt about a model, over speeds and commands anywhere in its envelope.
inline Doubt doubt(const UncertainModel& m) {
  detail::Dice dice;
  double pushed[kAxes] = {};
  double kicked[kAxes] = {};
  for (int sample = 0; sample < detail::kDoubtSamples; ++sample) {
    double nu[kAxes];
    double command[2][kMaxCommands];
    for (int a = 0; a < kAxes; ++a) nu[a] = dice(m.speed[a][0], m.speed[a][1]);
    for (auto& row : command) {
      for (int j = 0; j < m.chain.allocation.n_commands; ++j) row[j] = dice(-1.0, 1.0);
    }
    detail::Slopes slopes;
    detail::Slopes kicks;
    detail::acceleration_slopes(m, nu, command[0], slopes);
    detail::kick_slopes(m, nu, command[0], command[1], kicks);
    detail::add_variance(m, slopes, pushed);
    detail::add_variance(m, kicks, kicked);
  }
  Doubt out;
  for (int a = 0; a < kAxes; ++a) {
    out.disturbance[a] = std::sqrt(std::max(pushed[a], 0.0) / detail::kDoubtSamples);
    out.walk[a] =
        std::sqrt(detail::kCommandChanges * std::max(kicked[a], 0.0) / detail::kDoubtSamples);
  }
  return out;
}

/// The noise that the on-board filter believes: the model's own, and in squares what its errors do.
/// Surge and sway share one number: the root mean square. The memory is in proportion.
inline MotionNoise believed_noise(const MotionNoise& own, const Doubt& d) {
  const auto linear = [](const double* axes) {
    return std::hypot(axes[0], axes[1]) / std::sqrt(2.0);
  };
  const MotionNoise& least = detail::kLeastNoise;
  MotionNoise n = own;
  n.walk_linear = std::hypot(own.walk_linear, linear(d.walk));
  n.walk_yaw = std::hypot(own.walk_yaw, d.walk[2]);
  n.disturbance_linear = std::hypot(own.disturbance_linear, linear(d.disturbance));
  n.disturbance_yaw = std::hypot(own.disturbance_yaw, d.disturbance[2]);
  const double share[2] = {
      linear(d.disturbance) / std::max(n.disturbance_linear, least.disturbance_linear),
      d.disturbance[2] / std::max(n.disturbance_yaw, least.disturbance_yaw)};
  const double doubted = 0.5 * (share[0] * share[0] + share[1] * share[1]);
  n.memory = (1.0 - doubted) * own.memory + doubted * detail::kDoubtMemory;
  n.position = std::max(n.position, least.position);
  n.heading = std::max(n.heading, least.heading);
  n.walk_linear = std::max(n.walk_linear, least.walk_linear);
  n.walk_yaw = std::max(n.walk_yaw, least.walk_yaw);
  n.disturbance_linear = std::max(n.disturbance_linear, least.disturbance_linear);
  n.disturbance_yaw = std::max(n.disturbance_yaw, least.disturbance_yaw);
  n.memory = std::max(n.memory, least.memory);
  if (!own.coloured()) return n;
  n.colour_position = std::max(n.colour_position, least.colour_position);
  n.colour_heading = std::max(n.colour_heading, least.colour_heading);
  n.colour_memory = std::max(n.colour_memory, least.colour_memory);
  return n;
}

}  // namespace seatrial
