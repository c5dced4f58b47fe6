// SPDX-License-Identifier: MIT
// The way since the start, by the filtered velocity: the pose in REP-105's `odom`. No heap, no
// exceptions.
#pragma once
#include <algorithm>
#include <cmath>

#include "seatrial/filter/filter_state.hpp"
#include "seatrial/filter/matrix3.hpp"

namespace seatrial {

/// a followed by b, both x, y [m], psi [rad].
inline void compose(const double* a, const double* b, double* out) {
  double way[kPose];
  body_to_earth(a[2], b, way);
  for (int i = 0; i < 2; ++i) out[i] = a[i] + way[i];
  out[2] = wrap(a[2] + b[2]);
}

/// a backwards: a followed by it leads nowhere.
inline void inverse(const double* a, double* out) {
  const double back[kPose] = {-a[0], -a[1], 0.0};
  earth_to_body(a[2], back, out);
  out[2] = wrap(-a[2]);
}

/// x, y [m], psi [rad] since the start, and how far that may be off.
///
/// Errors of a filtered velocity are correlated. They are taken as L w: L the root of the
/// velocity's covariance of the moment, w of unit covariance, each component forgetting with a time
/// constant. Kept are the covariance P of the way and D = cov(way, w); as one matrix with I they
/// stay positive semidefinite whatever L does.
class Way {
 public:
  const double* pose() const { return pose_; }
  const double (&covariance() const)[kPose][kPose] { return p_; }

  /// h [s] further at the body velocity nu [m/s, m/s, rad/s] of covariance `spread`, whose errors
  /// last `memory` [s, each].
  void advance(double h, const double* nu, const double spread[kAxes][kAxes],
               const double* memory) {
    const double psi = pose_[2] + 0.5 * h * nu[2];  // halfway
    double rate[kPose];
    body_to_earth(psi, nu, rate);
    const double moved[2] = {h * rate[0], h * rate[1]};
    double push[kPose][kAxes];  // h R L
    if (!root_of_step(psi, h, spread, push)) return;
    for (int i = 0; i < 2; ++i) pose_[i] += moved[i];
    pose_[2] = wrap(pose_[2] + h * nu[2]);
    turn(moved, d_);
    turn(moved, p_);
    for (auto& row : p_) turn_row(moved, row);
    add(push);
    forget(h, memory, push);
  }

 private:
  /// False where the covariance has no root.
  static bool root_of_step(double psi, double h, const double spread[kAxes][kAxes],
                           double push[kPose][kAxes]) {
    double l[kAxes][kAxes] = {};
    if (!detail::lower_root(spread, l)) return false;
    for (int j = 0; j < kAxes; ++j) {
      const double column[kAxes] = {h * l[0][j], h * l[1][j], h * l[2][j]};
      double turned[kPose];
      body_to_earth(psi, column, turned);
      for (int i = 0; i < kPose; ++i) push[i][j] = turned[i];
    }
    return true;
  }

  /// An error of heading turns what is moved from now on.
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

  /// P + D B' + B D' + B B' with the push B.
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

  /// D + B, of which less stays the shorter the memory.
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
