// SPDX-License-Identifier: MIT
// Fixed thrusters: their geometry to T and T+, as `seatrial/allocation.py` has it.
#pragma once
#include "seatrial/model/dynamics.hpp"
#include "seatrial/model/frames.hpp"
#include "seatrial_ros/model_value.hpp"

namespace seatrial::ros {

/// Position and direction of push in forward-left-up body axes.
struct Thruster {
  double x = 0.0;      // [m]
  double y = 0.0;      // [m]
  double angle = 0.0;  // [rad] from forward, towards left
};

namespace detail {

inline constexpr double kNothing = 1e-12;  // of a cosine or a lever: rounding

inline double without_rounding(double x) { return std::abs(x) < kNothing ? 0.0 : x; }

}  // namespace detail

/// T (3 x n) in command units: the rows (cos a; sin a; x sin a - y cos a), each over its norm.
inline void thruster_matrix(const std::vector<Thruster>& thrusters, const Value& where,
                            double (*mix)[kMaxActuators]) {
  for (std::size_t k = 0; k < thrusters.size(); ++k) {
    const Thruster& t = thrusters[k];
    mix[0][k] = detail::without_rounding(std::cos(t.angle));
    mix[1][k] = detail::without_rounding(std::sin(t.angle));
    mix[2][k] = detail::without_rounding(t.x * std::sin(t.angle) - t.y * std::cos(t.angle));
  }
  for (int j = 0; j < kAxes; ++j) {
    double square = 0.0;
    for (std::size_t k = 0; k < thrusters.size(); ++k) square += mix[j][k] * mix[j][k];
    if (!(square > 0.0)) where.refuse("no thruster pushes in one of surge, sway and yaw");
    for (std::size_t k = 0; k < thrusters.size(); ++k) mix[j][k] /= std::sqrt(square);
  }
}

/// T+ = T' (T T')^-1 (n x 3).
inline void pseudo_inverse(const double (*mix)[kMaxActuators], int n, const Value& where,
                           double (*inverse)[kMaxCommands]) {
  double less[kAxes][kAxes];  // I - T T'
  double solve[kAxes][kAxes];
  for (int i = 0; i < kAxes; ++i) {
    for (int j = 0; j < kAxes; ++j) {
      less[i][j] = i == j ? 1.0 : 0.0;
      for (int k = 0; k < n; ++k) less[i][j] -= mix[i][k] * mix[j][k];
    }
  }
  if (!invert_identity_minus(less, solve)) {
    where.refuse("these " + std::to_string(n) +
                 " can't push in surge, sway and yaw independently; check positions and angles");
  }
  for (int k = 0; k < n; ++k) {
    for (int j = 0; j < kAxes; ++j) {
      double sum = 0.0;
      for (int i = 0; i < kAxes; ++i) sum += mix[i][k] * solve[i][j];
      inverse[k][j] = detail::without_rounding(sum);
    }
  }
}

/// Whether T max(0, +-2 T+_j) is +-e_j, and nothing pushes when all thrusters run alike.
inline bool runs_always_forward(const double (*mix)[kMaxActuators], int n,
                                const double (*inverse)[kMaxCommands]) {
  constexpr double kNear = 1e-9;
  for (int i = 0; i < kAxes; ++i) {
    double alike = 0.0;
    for (int k = 0; k < n; ++k) alike += mix[i][k];
    if (!(std::abs(alike) < kNear)) return false;
    for (int j = 0; j < kAxes; ++j) {
      for (const double sign : {1.0, -1.0}) {
        double given = 0.0;
        for (int k = 0; k < n; ++k) given += mix[i][k] * std::max(0.0, 2.0 * sign * inverse[k][j]);
        if (!(std::abs(given - (i == j ? sign : 0.0)) < kNear)) return false;
      }
    }
  }
  return true;
}

}  // namespace seatrial::ros
