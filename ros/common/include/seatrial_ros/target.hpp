// SPDX-License-Identifier: MIT
// The target pose and velocity, from reference or goal messages: the newest of a stream of
// references, or a goal to hold.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>

#include "seatrial/control/tracking.hpp"
#include "seatrial/model/frames.hpp"

namespace seatrial::ros {

/// A pose with or without velocity, forward-left-up: Odometry, PoseWithCovarianceStamped,
/// PoseStamped.
struct MotionMessage {
  std::int64_t stamp = 0;                 // [ns] of its header; 0: none
  std::string frame;                      // frame_id of the pose; empty: the message has none
  double eta[kAxes] = {};                 // x, y [m], psi [rad]
  double nu[kAxes] = {};                  // [m/s, m/s, rad/s] body-fixed
  double nu_variance[kAxes] = {};         // of it; 0: not known
  bool has_covariance = false;            // and that is known
  double covariance[kAxes * kAxes] = {};  // of x, y, psi

  bool is_finite() const {
    double sum = 0.0;
    for (int i = 0; i < kAxes; ++i) sum += eta[i] + nu[i];
    return std::isfinite(sum);
  }
};

class Target {
 public:
  // [s] between references that are differentiated; nearer ones would give rounding or jitter as
  // acceleration (that of 50 Hz stays above)
  static constexpr double kNearest = 0.015;
  static constexpr double kFarthest = 0.5;

  /// The next of a stream; its acceleration is by the difference to one before, body-fixed, so
  /// that a steady turn is known exactly.
  void follow(const MotionMessage& in) {
    const double apart = static_cast<double>(in.stamp - before_.stamp) * 1e-9;
    const bool apart_too_far = !streams_ || apart < 0.0 || apart > kFarthest;
    if (apart_too_far || apart >= kNearest) {
      for (int i = 0; i < kAxes; ++i) {
        nu_dot_[i] = apart_too_far ? 0.0 : (in.nu[i] - before_.nu[i]) / apart;
      }
      before_ = in;
    }
    set(in, true);
  }

  /// A goal, for as long as nothing else comes.
  void hold(const MotionMessage& in) {
    set(in, false);
    std::fill(newest_.nu, newest_.nu + kAxes, 0.0);
    std::fill(nu_dot_, nu_dot_ + kAxes, 0.0);
  }

  bool known() const { return known_; }
  const std::string& frame() const { return newest_.frame; }

  /// How far the newest reference is from `now` [ns]; a goal never ages.
  double age(std::int64_t now) const {
    return streams_ ? std::abs(static_cast<double>(now - newest_.stamp)) * 1e-9 : 0.0;
  }

  /// At a time [ns], with the newest reference's body-fixed acceleration kept.
  Reference at(std::int64_t time) const {
    Reference r;
    const double dt = static_cast<double>(time - newest_.stamp) * 1e-9;
    double mean[kAxes];  // velocity on the way
    double nu[kAxes];    // and at its end
    for (int i = 0; i < kAxes; ++i) {
      mean[i] = newest_.nu[i] + 0.5 * dt * nu_dot_[i];
      nu[i] = newest_.nu[i] + dt * nu_dot_[i];
    }
    body_to_earth(newest_.eta[2] + 0.5 * dt * newest_.nu[2], mean, r.rate);
    for (int i = 0; i < kAxes; ++i) r.eta[i] = newest_.eta[i] + dt * r.rate[i];
    body_to_earth(r.eta[2], nu, r.rate);
    // eta_ddot = R (nu_dot + r S nu)
    const double turned[kAxes] = {nu_dot_[0] - nu[2] * nu[1], nu_dot_[1] + nu[2] * nu[0],
                                  nu_dot_[2]};
    body_to_earth(r.eta[2], turned, r.acceleration);
    return r;
  }

 private:
  void set(const MotionMessage& in, bool streams) {
    newest_ = in;
    streams_ = streams;
    known_ = true;
  }

  MotionMessage newest_;
  MotionMessage before_;  // of the stream, that the next one is differentiated by
  double nu_dot_[kAxes] = {};
  bool streams_ = false;
  bool known_ = false;
};

}  // namespace seatrial::ros
