// SPDX-License-Identifier: MIT
// The tracking controller: a reference and the boat's motion in, commands out. Feed-forward through
// the model, PID on the remaining error; at the limits commands keep their direction, or follow an
// allocator's priorities. For a boat without sway thrust a guidance law turns the reference into
// one that surge and yaw can follow. No heap, no exceptions.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>

#include "seatrial/control/axis_commands.hpp"
#include "seatrial/control/guidance.hpp"
#include "seatrial/model/dynamics.hpp"
#include "seatrial/model/frames.hpp"

namespace seatrial {

/// By axis: surge, sway, yaw. An axis command of 1 is some input's full.
struct TrackingGains {
  double proportional[kAxes] = {};      // axis commands per m, m, rad
  double integral[kAxes] = {};          // per m s, m s, rad s
  double derivative[kAxes] = {};        // per m/s, m/s, rad/s
  double authority[kAxes] = {1, 1, 1};  // [m/s^2, m/s^2, rad/s^2] by an axis command of 1; 0: none
  AxisCommands::Mix mix = {};           // inputs by axis commands
  double limit = 1.0;                   // of each input, and of the command by the integral
  bool feed_forward = true;
  GuidanceSettings guidance;  // on: for a boat without sway thrust
};

/// Status of a call.
enum class Tracked : std::uint8_t {
  kFollowing,
  kLimited,   // more was asked for than the thrusters have
  kNotNumber  // an input is not a number: the command is zero, nothing is remembered
};

/// Its memory is the integral of the pose error, earth-fixed: what disturbs a boat for long
/// (current, wind, a tether) is, and in a turn an integral fixed to the body would be unstable.
class Tracker {
 public:
  static constexpr double kLongestStep = 0.5;  // [s] that is integrated at once

  Tracker(const Structure& structure, const double* coefficient, const Allocation& allocation,
          const TrackingGains& gains)
      : Tracker(structure, coefficient,
                AxisCommands(allocation, gains.mix, gains.limit, gains.guidance.on()), gains) {}

  /// For a boat whose inputs are its thrusters; within the allocator's limits.
  Tracker(const Structure& structure, const double* coefficient, const Allocator& allocator,
          const TrackingGains& gains)
      : Tracker(structure, coefficient, AxisCommands(allocator, gains.mix), gains) {}

  /// For one thruster with an angle, at limits of its own.
  Tracker(const Structure& structure, const double* coefficient, const Steering& steering,
          const TrackingGains& gains)
      : Tracker(structure, coefficient, AxisCommands(steering, gains.authority), gains) {}

  /// Commands to all inputs, dt [s] after the last call. eta: pose; nu: body velocity over ground.
  /// ahead: the reference as far ahead as the thrusters are late; feed-forward is taken from there.
  Tracked command(double dt, const double* eta, const double* nu, const Reference& now,
                  const Reference& ahead, double* values) {
    std::fill(values, values + commands_.size(), 0.0);
    if (!numbers(dt, eta, nu, now, ahead)) return Tracked::kNotNumber;
    const Guided go =
        gains_.guidance.on() ? guided(dt, eta, nu, now, ahead) : straight(eta, now, ahead);
    double off[kAxes];   // the error, earth-fixed
    double past[kAxes];  // its integral, in body axes
    body_to_earth(eta[2], go.error, off);
    earth_to_body(eta[2], integral_, past);
    double axis[kAxes] = {};
    if (gains_.feed_forward) held(go, axis);
    for (int i = 0; i < kAxes; ++i) {
      axis[i] += gains_.proportional[i] * go.error[i] + gains_.integral[i] * past[i] +
                 gains_.derivative[i] * (go.rate[i] - nu[i]);
    }
    const bool limited = !commands_.command(axis, nu, dt, values);
    integrate(std::clamp(dt, 0.0, kLongestStep), eta[2], off, go.error, limited ? axis : nullptr,
              go.near);
    guidance_.hold(limited);
    return limited ? Tracked::kLimited : Tracked::kFollowing;
  }

  /// Without memory of errors.
  void forget() {
    std::fill(integral_, integral_ + kAxes, 0.0);
    guidance_.forget();
    commands_.forget();
  }

  /// Integral of the pose error, earth-fixed [m s, m s, rad s].
  const double* integral() const { return integral_; }
  const TrackingGains& gains() const { return gains_; }
  const Guidance& guidance() const { return guidance_; }

 private:
  Tracker(const Structure& structure, const double* coefficient, const AxisCommands& commands,
          const TrackingGains& gains)
      : structure_(structure), commands_(commands), gains_(gains), guidance_(gains.guidance) {
    std::copy(coefficient, coefficient + structure.n_coefficients, coefficient_);
  }

  static bool numbers(double dt, const double* eta, const double* nu, const Reference& now,
                      const Reference& ahead) {
    double sum = dt;
    for (int i = 0; i < kAxes; ++i) {
      sum += eta[i] + nu[i];
      for (const Reference* r : {&now, &ahead}) sum += r->eta[i] + r->rate[i] + r->acceleration[i];
    }
    return std::isfinite(sum);
  }

  /// A boat that can go sideways: the reference itself, and its motion ahead.
  static Guided straight(const double* eta, const Reference& now, const Reference& ahead) {
    Guided out;
    const double off[kAxes] = {now.eta[0] - eta[0], now.eta[1] - eta[1], wrap(now.eta[2] - eta[2])};
    earth_to_body(eta[2], off, out.error);
    earth_to_body(eta[2], now.rate, out.rate);
    const double psi = eta[2] + wrap(ahead.eta[2] - now.eta[2]);
    earth_to_body(psi, ahead.rate, out.nu);
    earth_to_body(psi, ahead.acceleration, out.nu_dot);
    out.nu_dot[0] += out.nu[2] * out.nu[1];  // nu_dot = R' eta_ddot - r S nu
    out.nu_dot[1] -= out.nu[2] * out.nu[0];
    return out;
  }

  Guided guided(double dt, const double* eta, const double* nu, const Reference& now,
                const Reference& ahead) {
    return guidance_.guide(dt, eta, nu, now, ahead, [this](const double* motion) {
      double free[kAxes] = {};
      if (gains_.feed_forward) unforced(motion, free);
      return free[1];
    });
  }

  void unforced(const double* nu, double* rate) const {
    const double none[kMaxForces] = {};
    acceleration(structure_, coefficient_, nu, none, rate);
  }

  /// The inverse of Eq. (12): axis commands under which the boat moves so.
  void held(const Guided& go, double* axis) const {
    double free[kAxes];
    unforced(go.nu, free);
    for (int i = 0; i < kAxes; ++i) {
      const double full = gains_.authority[i];
      axis[i] = full > 0.0 ? (go.nu_dot[i] - free[i]) / full : 0.0;
    }
  }

  /// Where commands are limited, only what takes back is integrated; the integral alone never asks
  /// for more than the limit.
  void integrate(double dt, double psi, const double* off, const double* error,
                 const double* limited, bool near) {
    const auto adds = [&](int i) { return gains_.integral[i] * error[i] * limited[i]; };
    const bool plane = near && (limited == nullptr || adds(0) + adds(1) <= 0.0);
    const bool turn = limited == nullptr || adds(2) <= 0.0;
    for (int i = 0; i < kAxes; ++i) integral_[i] += (i < 2 ? plane : turn) ? dt * off[i] : 0.0;
    double past[kAxes];
    earth_to_body(psi, integral_, past);
    double asked[kAxes];
    for (int i = 0; i < kAxes; ++i) asked[i] = std::abs(gains_.integral[i] * past[i]);
    const double along = std::max(asked[0], asked[1]);
    for (int i = 0; i < kAxes; ++i) {
      const double size = i < 2 ? along : asked[2];
      if (size > gains_.limit) integral_[i] *= gains_.limit / size;
    }
  }

  Structure structure_;
  AxisCommands commands_;
  TrackingGains gains_;
  Guidance guidance_;
  double coefficient_[kMaxCoefficients] = {};
  double integral_[kAxes] = {};
};

}  // namespace seatrial
