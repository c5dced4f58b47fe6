// SPDX-License-Identifier: MIT
// Guidance of a boat without sway thrust: which way to point, so that surge and yaw are enough.
// Line of sight with drift compensation along a reference that moves; about one that rests, the
// same law with the bow turned into the drift. No heap, no exceptions.
#pragma once
#include <algorithm>
#include <cmath>

#include "seatrial/model/dynamics.hpp"
#include "seatrial/model/frames.hpp"

namespace seatrial {

/// Where the boat is to be, earth-fixed.
struct Reference {
  double eta[kAxes] = {};           // x, y [m], psi [rad]
  double rate[kAxes] = {};          // [m/s, m/s, rad/s]
  double acceleration[kAxes] = {};  // [m/s^2, m/s^2, rad/s^2]
};

/// By `seatrial tune`, docs/tune.md.
struct GuidanceSettings {
  double time = 0.0;      // [s] look-ahead distance over speed; 0: no guidance, the boat has sway
  double radius = 0.0;    // [m] least look-ahead distance, and the circle of station keeping
  double slowest = 0.0;   // [m/s] a reference below it rests
  double fastest = 0.0;   // [m/s] of approach
  double approach = 0.0;  // [s] position error over the speed that the surge gains make of it

  bool on() const { return time > 0.0; }
};

/// What the surge and yaw controllers get, in body axes; sway is free.
struct Guided {
  double error[kAxes] = {};   // reference - pose [m, m, rad]; 0 in sway
  double rate[kAxes] = {};    // wanted velocity over ground [m/s, m/s, rad/s]
  double nu[kAxes] = {};      // motion of the feed-forward, with the turn's sway [m/s, m/s, rad/s]
  double nu_dot[kAxes] = {};  // [m/s^2, m/s^2, rad/s^2]
  bool near = true;           // the surge error is not limited, and may be integrated
};

class Guidance {
 public:
  explicit Guidance(const GuidanceSettings& settings) : s_(settings) {}

  /// dt [s] since the last call. `sway`: the sway acceleration at a motion without thrust.
  template <class Sway>
  Guided guide(double dt, const double* eta, const double* nu, const Reference& now,
               const Reference& ahead, const Sway& sway) {
    const bool rests = speed_of(now) < s_.slowest;
    Guided out;
    free_sway(dt, rests ? PathMotion{} : motion_of(ahead), sway, out);
    if (rests) {
      keep_station(dt, eta, nu, now, out);
    } else {
      feed_forward(follow(dt, eta, nu, now, out), ahead, out);
    }
    return out;
  }

  void forget() { *this = Guidance(s_); }

  const GuidanceSettings& settings() const { return s_; }
  /// Drift velocity that is compensated, earth-fixed [m/s].
  const double* drift() const { return drift_; }
  /// Direction [rad] that station keeping points along, or the course last followed.
  double direction() const { return direction_; }
  /// For where the commands are limited: nothing is learned in the next call.
  void hold(bool limited) { limited_ = limited; }

 private:
  static constexpr double kLongestStep = 0.5;     // [s] that is integrated at once
  static constexpr double kStraightEnough = 0.5;  // [rad] of turn in the time: drift is learned
  static constexpr double kFar = 2.0;             // [radii] from which the bow points at the goal
  static constexpr double kMostSlip = 0.7;        // of sway over speed in the turn's slip

  /// Motion of the reference along its path.
  struct PathMotion {
    double speed = 0.0;         // [m/s]
    double acceleration = 0.0;  // [m/s^2] along the path
    double course_rate = 0.0;   // [rad/s]
  };

  /// The line to follow, and the boat's place beside its reference point.
  struct Line {
    double course = 0.0;  // [rad]
    double along = 0.0;   // [m]
    double across = 0.0;  // [m] to the left
    bool far = false;     // the bow points at the goal
  };

  static double speed_of(const Reference& r) { return std::hypot(r.rate[0], r.rate[1]); }

  /// ILOS (Borhaug et al. 2008; Fossen 2021, chapter 12): a = y / Delta + n . w / U is the
  /// tangent of the angle to point off the course. Returns by how much the heading is off it.
  double follow(double dt, const double* eta, const double* nu, const Reference& now, Guided& out) {
    const double speed = speed_of(now);
    const double turn = motion_of(now).course_rate;
    const Line line = path(eta, now);
    const double normal[2] = {-std::sin(line.course), std::cos(line.course)};
    const double drift = (normal[0] * drift_[0] + normal[1] * drift_[1]) / speed;
    const double along = (normal[1] * drift_[0] - normal[0] * drift_[1]) / speed;
    const double near = std::max(s_.radius, speed * s_.time);
    const double a = line.across / near + drift;
    double drift_rate = -turn * along;  // as the normal turns
    if (!limited_ && std::abs(turn) * s_.time <= kStraightEnough) {
      const double time = near / speed;
      const double rate = line.across / (1.0 + a * a) / (4.0 * time * time);
      drift_rate += rate / speed;
      learn(step(dt) * rate, speed, normal);
    }
    direction_ = wrap(line.course - std::atan(drift));
    point(eta, turn, a, across_rate(eta, nu, line) / near + drift_rate, line, out);
    out.rate[0] = std::max(0.0, speed * std::cos(eta[2] - line.course));
    surge(eta, 0.0, line, out);
    return wrap(eta[2] - line.course);
  }

  void keep_station(double dt, const double* eta, const double* nu, const Reference& now,
                    Guided& out) {
    const Line line = station(dt, eta, now);
    const double near = std::max(s_.radius, std::hypot(line.along, line.across));
    point(eta, 0.0, line.across / near, across_rate(eta, nu, line) / near, line, out);
    out.rate[0] = std::cos(eta[2]) * now.rate[0] + std::sin(eta[2]) * now.rate[1];
    surge(eta, line.far ? 0.0 : -s_.fastest, line, out);
  }

  /// Heading and its rate, from the tangent of the angle to the course and its rate.
  void point(const double* eta, double turn, double a, double a_rate, const Line& line,
             Guided& out) const {
    out.error[2] = wrap(line.course - slip_ - std::atan(a) - eta[2]);
    out.rate[2] = turn - slip_rate_ - a_rate / (1.0 + a * a);
  }

  /// `off`: of the heading from the course.
  void feed_forward(double off, const Reference& ahead, Guided& out) const {
    const PathMotion motion = motion_of(ahead);
    out.nu[0] = motion.speed * std::max(0.0, std::cos(off));
    out.nu_dot[0] = motion.acceleration;
    out.nu[2] = motion.course_rate - slip_rate_;
    out.nu_dot[2] = ahead.acceleration[2];
  }

  static double across_rate(const double* eta, const double* nu, const Line& line) {
    const double off = eta[2] - line.course;
    return nu[0] * std::sin(off) + nu[1] * std::cos(off);
  }

  /// Without acceleration and course rate where the reference rests.
  PathMotion motion_of(const Reference& r) const {
    PathMotion motion;
    motion.speed = speed_of(r);
    if (motion.speed < s_.slowest) return motion;
    const double* v = r.rate;
    const double* a = r.acceleration;
    motion.acceleration = (v[0] * a[0] + v[1] * a[1]) / motion.speed;
    motion.course_rate = (v[0] * a[1] - v[1] * a[0]) / (motion.speed * motion.speed);
    return motion;
  }

  /// Of the point of the reference's circle of curvature that is nearest to the boat: a boat that
  /// is behind its reference in a bend is not off its path.
  Line path(const double* eta, const Reference& now) {
    const PathMotion motion = motion_of(now);
    Line line;
    line.course = std::atan2(now.rate[1], now.rate[0]);
    place(eta, now, line);
    const double bend = motion.course_rate / motion.speed;
    const double p = 1.0 - bend * line.across;
    const double q = bend * line.along;
    const double angle = std::atan2(q, p);
    if (std::abs(bend) * s_.radius > kStraight && std::abs(angle) < kPi / 2.0) {
      line.across = (1.0 - std::hypot(p, q)) / bend;
      line.along = angle / bend;
      line.course = wrap(line.course + angle);
    }
    started_ = true;
    far_ = false;
    return line;
  }

  /// From far away to the radius the bow points at the goal. Within, the direction turns until the
  /// drift is met by surge alone: a pendulum that hangs from a point ahead (Fossen and Strand
  /// 2001).
  Line station(double dt, const double* eta, const Reference& now) {
    Line line;
    const double x = now.eta[0] - eta[0];
    const double y = now.eta[1] - eta[1];
    far_ = std::hypot(x, y) > (far_ ? s_.radius : kFar * s_.radius);
    line.far = far_;
    if (line.far) {
      direction_ = std::atan2(y, x);
    } else if (!started_) {
      direction_ = now.eta[2];
    }
    started_ = true;
    line.course = direction_;
    place(eta, now, line);
    if (!line.far) {
      const double rate = s_.slowest / (4.0 * s_.radius * s_.radius);
      direction_ = wrap(direction_ - step(dt) * rate * line.across);
    }
    return line;
  }

  static void place(const double* eta, const Reference& now, Line& line) {
    const double c = std::cos(line.course);
    const double s = std::sin(line.course);
    const double x = eta[0] - now.eta[0];
    const double y = eta[1] - now.eta[1];
    line.along = c * x + s * y;
    line.across = c * y - s * x;
  }

  /// Sway by the model, as it follows from the reference's speed and turn; slip: of the course
  /// from the heading.
  template <class Sway>
  void free_sway(double dt, const PathMotion& motion, const Sway& sway, Guided& out) {
    slip_ = slip_rate_ = 0.0;
    if (motion.speed < s_.slowest) {
      sway_ = 0.0;
      return;
    }
    const double nu[kAxes] = {motion.speed, sway_, motion.course_rate};
    const double rate = sway(nu);
    const double most = kMostSlip * motion.speed;
    sway_ = std::clamp(sway_ + step(dt) * rate, -most, most);
    if (!std::isfinite(sway_)) sway_ = 0.0;
    slip_ = std::asin(sway_ / motion.speed);
    slip_rate_ = std::abs(sway_) < most ? rate / (motion.speed * std::cos(slip_)) : 0.0;
    out.nu[1] = sway_;
  }

  /// Adds to the drift, no faster than the reference moves.
  void learn(double more, double speed, const double* normal) {
    for (int i = 0; i < 2; ++i) drift_[i] += more * normal[i];
    const double size = std::hypot(drift_[0], drift_[1]);
    if (size > speed) {
      for (double& d : drift_) d *= speed / size;
    }
  }

  /// Position error along the bow. With the wanted velocity it asks for no speed beyond the
  /// fastest, and none below `astern`.
  void surge(const double* eta, double astern, const Line& line, Guided& out) const {
    const double off = eta[2] - line.course;
    const double error = -(std::cos(off) * line.along + std::sin(off) * line.across);
    out.error[0] = std::clamp(error, s_.approach * std::min(0.0, astern - out.rate[0]),
                              s_.approach * std::max(0.0, s_.fastest - out.rate[0]));
    out.near = !line.far && out.error[0] == error;
  }

  static double step(double dt) { return std::clamp(dt, 0.0, kLongestStep); }

  static constexpr double kStraight = 1e-6;  // bend times radius that counts as a straight line

  GuidanceSettings s_;
  double drift_[2] = {};
  double sway_ = 0.0;  // [m/s] of the feed-forward
  double slip_ = 0.0;
  double slip_rate_ = 0.0;
  double direction_ = 0.0;
  bool far_ = false;
  bool started_ = false;
  bool limited_ = false;
};

}  // namespace seatrial
