// SPDX-License-Identifier: MIT
// Odometry: the filtered velocity integrated into the pose in REP-105's `odom`. No heap, no
// exceptions.
#pragma once
#include <algorithm>
#include <cmath>

#include "seatrial/filter/filter_state.hpp"
#include "seatrial/filter/matrix3.hpp"

namespace seatrial {

/// Composition of two poses: a, then b; x, y [m], psi [rad].
inline void compose(const double* a, const double* b, double* out) {
  double moved[kPose];
  body_to_earth(a[2], b, moved);
  for (int i = 0; i < 2; ++i) out[i] = a[i] + moved[i];
  out[2] = wrap(a[2] + b[2]);
}

/// Inverse pose: compose(a, inverse) is the origin.
inline void inverse(const double* a, double* out) {
  const double back[kPose] = {-a[0], -a[1], 0.0};
  earth_to_body(a[2], back, out);
  out[2] = wrap(-a[2]);
}

/// x, y [m], psi [rad] since the start, with covariance.
///
/// Errors of a filtered velocity are correlated in time. The model of them is L w: L is the root of
/// the current velocity covariance, w has unit covariance and each component of it is a
/// Gauss-Markov process. The state is the covariance P of the pose and D = cov(pose, w). With I
/// they form one matrix that stays positive semidefinite for every L.
class OdomIntegrator {
 public:
  const double* pose() const { return pose_; }
  const double (&covariance() const)[kPose][kPose] { return p_; }

  /// A step of h [s] at the body velocity nu [m/s, m/s, rad/s] of covariance `spread`, whose errors
  /// have the time constants `memory` [s]. A covariance without a root (singular, or rounding)
  /// adds nothing to the pose's.
  void advance(double h, const double* nu, const double spread[kAxes][kAxes],
               const double* memory) {
    const double psi = pose_[2] + 0.5 * h * nu[2];  // halfway
    double rate[kPose];
    body_to_earth(psi, nu, rate);
    const double moved[2] = {h * rate[0], h * rate[1]};
    double push[kPose][kAxes] = {};  // h R L
    root_of_step(psi, h, spread, push);
    for (int i = 0; i < 2; ++i) pose_[i] += moved[i];
    pose_[2] = wrap(pose_[2] + h * nu[2]);
    turn(moved, d_);
    turn(moved, p_);
    for (auto& row : p_) turn_row(moved, row);
    add(push);
    forget(h, memory, push);
  }

 private:
  /// Leaves `push` as it is where the covariance has no root.
  static void root_of_step(double psi, double h, const double spread[kAxes][kAxes],
                           double push[kPose][kAxes]) {
    double l[kAxes][kAxes] = {};
    if (!detail::lower_root(spread, l)) return;
    for (int j = 0; j < kAxes; ++j) {
      const double column[kAxes] = {h * l[0][j], h * l[1][j], h * l[2][j]};
      double turned[kPose];
      body_to_earth(psi, column, turned);
      for (int i = 0; i < kPose; ++i) push[i][j] = turned[i];
    }
  }

  /// An error of the heading turns this step's displacement.
  static void turn(const double* moved, double m[kPose][kAxes]) {
    for (int j = 0; j < kAxes; ++j) {
      m[0][j] -= moved[1] * m[2][j];
      m[1][j] += moved[0] * m[2][j];
    }
  }

  static void turn_row(const double* moved, double* row) {
    row[0] -= moved[1] * row[2];
    row[1] += moved[0] * row[2];
  }

  /// P + D B' + B D' + B B' of the step B.
  void add(const double b[kPose][kAxes]) {
    for (int i = 0; i < kPose; ++i) {
      for (int j = 0; j <= i; ++j) {
        for (int k = 0; k < kAxes; ++k) {
          p_[i][j] += d_[i][k] * b[j][k] + b[i][k] * d_[j][k] + b[i][k] * b[j][k];
        }
        p_[j][i] = p_[i][j];
      }
    }
  }

  /// D + B, decayed with the time constants.
  void forget(double h, const double* memory, const double b[kPose][kAxes]) {
    for (int k = 0; k < kAxes; ++k) {
      const double stays = std::exp(-h / memory[k]);
      for (int i = 0; i < kPose; ++i) d_[i][k] = stays * (d_[i][k] + b[i][k]);
    }
  }

  double pose_[kPose] = {};  // x, y [m], psi [rad]
  double p_[kPose][kPose] = {};
  double d_[kPose][kAxes] = {};
};

}  // namespace seatrial
