// SPDX-License-Identifier: MIT
// A boat's sensors, simulated: a SLAM's pose and an inertial unit. Host only.
#pragma once
#include <algorithm>
#include <cmath>

#include "seatrial/model/frames.hpp"
#include "seatrial/simulation/random.hpp"

namespace seatrial {

/// SLAM as a sensor. The settings are those of a plan's pose sensor (docs/simulate.md).
struct PoseSensor {
  double rate = 15.0;              // [Hz]
  double position_noise = 0.0007;  // [m] standard deviation
  double heading_noise = 0.003;    // [rad]
  double noise_correlation = 0.0;  // [s] time constant of the noise; 0: white
  double stamp_jitter = 0.0005;    // [s]
  double delay = 0.05;             // [s] from the stamp to the arrival
  double drop_outs = 0.0;          // a minute
  double drop_out_shortest = 0.3;  // [s]
  double drop_out_longest = 2.0;   // [s]
  double jumps = 0.0;              // false matches a minute
  double jump_shortest = 0.1;      // [m]
  double jump_longest = 0.5;       // [m]
  int jump_samples = 3;            // poses in a row at most
  double lever[2] = {0.0, 0.0};    // [m] of the measured point: forward, left of the origin
  double position_delay = 0.0;     // [s] by which the position is older than its stamp
  double heading_delay = 0.0;      // [s] by which the heading is

  /// [s] by which the stamp is later than the reading: 0, or less where a part is stamped late.
  double stamp_offset() const { return std::min({0.0, position_delay, heading_delay}); }
};

/// Yaw rate and the specific force along the hull's axes at its origin, as means over a period.
struct Imu {
  double rate = 100.0;               // [Hz]
  double yaw_rate_noise = 0.002;     // [rad/s] standard deviation
  double yaw_rate_bias = 0.002;      // [rad/s] standard deviation of a constant drawn once
  double acceleration_noise = 0.02;  // [m/s^2]
  double acceleration_bias = 0.02;   // [m/s^2]
};

/// Why a sensor is refused, in one line; null: it is not.
inline const char* fault(const PoseSensor& s) {
  if (!(s.rate > 0.0 && s.rate <= 1000.0)) return "pose: rate: expected up to 1000 Hz";
  if (!(s.position_noise >= 0.0 && s.heading_noise >= 0.0 && s.stamp_jitter >= 0.0)) {
    return "pose: noise and jitter: expected 0 or more";
  }
  if (!(s.noise_correlation >= 0.0 && s.delay >= 0.0)) {
    return "pose: noise_correlation and delay: expected 0 s or more";
  }
  if (!(std::abs(s.position_delay) <= 1.0 && std::abs(s.heading_delay) <= 1.0)) {
    return "pose: position_delay and heading_delay: expected at most 1 s";
  }
  if (!(s.drop_outs >= 0.0 && s.jumps >= 0.0)) {
    return "pose: drop_outs and jumps: expected 0 or more a minute";
  }
  const bool ordered = s.drop_out_shortest >= 0.0 && s.drop_out_longest >= s.drop_out_shortest &&
                       s.jump_shortest >= 0.0 && s.jump_longest >= s.jump_shortest;
  if (!ordered) return "pose: shortest: expected from 0 to longest";
  return s.jump_samples >= 1 ? nullptr : "pose: jump_samples: expected 1 or more";
}

inline const char* fault(const Imu& s) {
  if (!(s.rate > 0.0 && s.rate <= 1000.0)) return "imu: rate: expected up to 1000 Hz";
  const bool sound = s.yaw_rate_noise >= 0.0 && s.yaw_rate_bias >= 0.0 &&
                     s.acceleration_noise >= 0.0 && s.acceleration_bias >= 0.0;
  return sound ? nullptr : "imu: noise and bias: expected 0 or more";
}

/// The pose sensor with its state: what is left of old noise, drop-outs and false matches.
class PoseReader {
 public:
  PoseReader(const PoseSensor& sensor, Random random)
      : sensor_(sensor), random_(random), next_drop_out_(random_.wait(sensor.drop_outs)) {
    stays_ = sensor.noise_correlation > 0.0
                 ? std::exp(-1.0 / (sensor.rate * sensor.noise_correlation))
                 : 0.0;
    for (double& e : error_) e = random_.normal();
  }

  /// What it makes at t [s] of the position (2) and heading that it sees, which were true before by
  /// their delays; swing: the heading of the position's time. False where nothing comes.
  bool read(double t, const double* eta, double swing, double* stamp, double* pose) {
    advance_noise();
    const bool away = dropped(t);
    advance_jump();
    *stamp = t + sensor_.stamp_offset() + sensor_.stamp_jitter * random_.normal();
    const double lever[3] = {sensor_.lever[0], sensor_.lever[1], 0.0};
    double arm[3];
    body_to_earth(swing, lever, arm);
    const double size[3] = {sensor_.position_noise, sensor_.position_noise, sensor_.heading_noise};
    for (int i = 0; i < 3; ++i) pose[i] = eta[i] + arm[i] + size[i] * error_[i] + jump_[i];
    pose[2] = wrap(pose[2]);
    return !away;
  }

 private:
  void advance_noise() {
    const double fresh = std::sqrt(1.0 - stays_ * stays_);
    for (double& e : error_) e = stays_ * e + fresh * random_.normal();
  }

  bool dropped(double t) {
    while (t >= next_drop_out_) {
      back_ = next_drop_out_ + random_.uniform(sensor_.drop_out_shortest, sensor_.drop_out_longest);
      next_drop_out_ = back_ + random_.wait(sensor_.drop_outs);
    }
    return t < back_;
  }

  void advance_jump() {
    if (left_ > 0 && --left_ == 0) std::fill(jump_, jump_ + 3, 0.0);
    if (left_ > 0 || !(random_.uniform() < sensor_.jumps / (60.0 * sensor_.rate))) return;
    left_ = 1 + static_cast<int>(random_.uniform() * sensor_.jump_samples);
    const double size = random_.uniform(sensor_.jump_shortest, sensor_.jump_longest);
    const double angle = random_.uniform(-kPi, kPi);
    jump_[0] = size * std::cos(angle);
    jump_[1] = size * std::sin(angle);
    jump_[2] = size * random_.uniform(-1.0, 1.0);  // [rad]
  }

  PoseSensor sensor_;
  Random random_;
  double stays_ = 0.0;    // of the noise from one pose to the next
  double error_[3] = {};  // unit variance
  double next_drop_out_;  // [s]
  double back_ = -1.0;    // [s] end of the last drop-out
  double jump_[3] = {};   // of the present false match
  int left_ = 0;          // poses of it still to come, this one too
};

/// The inertial unit with its biases, and the velocity at the last reading.
class ImuReader {
 public:
  ImuReader(const Imu& sensor, Random random) : sensor_(sensor), random_(random) {
    bias_[0] = sensor.yaw_rate_bias * random_.normal();
    for (int i = 1; i < 3; ++i) bias_[i] = sensor.acceleration_bias * random_.normal();
  }

  /// Yaw rate, forward and left acceleration, means since the last reading: of the heading psi
  /// [rad] (unwrapped) and the velocity over ground (2), earth-fixed, `period` [s] later.
  void read(double period, double psi, const double* velocity, double* out) {
    const double turned = psi - psi_;
    const double gained[3] = {(velocity[0] - velocity_[0]) / period,
                              (velocity[1] - velocity_[1]) / period, 0.0};
    double body[3];
    earth_to_body(psi - 0.5 * turned, gained, body);
    const double mean[3] = {turned / period, body[0], body[1]};
    const double noise[3] = {sensor_.yaw_rate_noise, sensor_.acceleration_noise,
                             sensor_.acceleration_noise};
    for (int i = 0; i < 3; ++i) out[i] = mean[i] + bias_[i] + noise[i] * random_.normal();
    begin(psi, velocity);
  }

  /// The state that the next reading starts from.
  void begin(double psi, const double* velocity) {
    psi_ = psi;
    std::copy(velocity, velocity + 2, velocity_);
  }

 private:
  Imu sensor_;
  Random random_;
  double bias_[3] = {};
  double psi_ = 0.0;         // [rad]
  double velocity_[2] = {};  // [m/s]
};

}  // namespace seatrial
