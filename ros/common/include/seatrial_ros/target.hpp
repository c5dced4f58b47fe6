// SPDX-License-Identifier: MIT
// Where the boat is to be, out of messages: the newest of a stream of references, or a goal to
// hold.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>

#include "seatrial/frames.hpp"
#include "seatrial/tracking.hpp"

namespace seatrial::ros {

/// A pose with or without velocity, forward-left-up: Odometry, PoseWithCovarianceStamped,
/// PoseStamped.
struct MotionMessage {
  std::int64_t stamp = 0;                 // [ns] of its header; 0: none
  std::string frame;                      // of the pose; empty: not said
  double eta[kAxes] = {};                 // x, y [m], psi [rad]
  double nu[kAxes] = {};                  // [m/s, m/s, rad/s] body-fixed
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
  static constexpr double kFarthestApart = 0.5;  // [s] between references that are differentiated

  /// The next of a stream; its acceleration is by the difference to the one before.
  void follow(const MotionMessage& in) {
    Reference next;
    std::copy(in.eta, in.eta + kAxes, next.eta);
    body_to_earth(in.eta[2], in.nu, next.rate);
    const double apart = static_cast<double>(in.stamp - stamp_) * 1e-9;
    if (streams_ && apart > 0.0 && apart <= kFarthestApart) {
      for (int i = 0; i < kAxes; ++i) {
        next.acceleration[i] = (next.rate[i] - newest_.rate[i]) / apart;
      }
    }
    set(next, in, true);
  }

  /// A goal, for as long as nothing else comes.
  void hold(const MotionMessage& in) {
    Reference still;
    std::copy(in.eta, in.eta + kAxes, still.eta);
    set(still, in, false);
  }

  bool known() const { return known_; }
  const std::string& frame() const { return frame_; }

  /// How far the newest reference is from `now` [ns]; a goal never ages.
  double age(std::int64_t now) const {
    return streams_ ? std::abs(static_cast<double>(now - stamp_)) * 1e-9 : 0.0;
  }

  /// At a time [ns], with the newest reference's acceleration kept.
  Reference at(std::int64_t time) const {
    Reference r = newest_;
    if (!streams_) return r;
    const double dt = static_cast<double>(time - stamp_) * 1e-9;
    for (int i = 0; i < kAxes; ++i) {
      r.eta[i] += dt * (r.rate[i] + 0.5 * dt * r.acceleration[i]);
      r.rate[i] += dt * r.acceleration[i];
    }
    return r;
  }

 private:
  void set(const Reference& next, const MotionMessage& in, bool streams) {
    newest_ = next;
    stamp_ = in.stamp;
    frame_ = in.frame;
    streams_ = streams;
    known_ = true;
  }

  Reference newest_;
  std::int64_t stamp_ = 0;  // [ns]
  std::string frame_;
  bool streams_ = false;
  bool known_ = false;
};

}  // namespace seatrial::ros
