// SPDX-License-Identifier: MIT
// The on-board predictor between two poses: thrusters and both state estimates go on, and what is
// known now. No heap, no exceptions.
#pragma once
#include "seatrial/onboard/pose_use.hpp"

namespace seatrial {

namespace detail {

/// Prediction over `length` [s] in which the thrust is smooth.
inline void propagate_smooth(const OnboardModel& m, double length, PredictorState& now) {
  const Chain& c = m.chain;
  const PrincipalErrors& considered = m.boat.considered;
  // after repeated resets the process noise is larger
  const bool doubted = now.time - now.doubted <= m.cautious_for;
  const NoiseParameters noise = doubted ? with_default_process_noise(m.boat.noise) : m.boat.noise;
  // equal steps, each with the same decay of the lags
  const int n = steps_for(length, m.boat.longest_step);
  const double h = length / n;
  LagDecay decays[kMaxActuators];
  ErrorDecay error_decay[kMaxActuators];
  if (considered.n > 0) {
    error_decays(c, m.q, h, decays, error_decay);
  } else {
    lag_decays(c, m.q, h, decays);
  }
  double force[3][kMaxForces];
  Loadings force_error[kMaxForces] = {};
  for (int i = 0; i < n; ++i) {
    // thrusters and their errors
    if (considered.n > 0) {
      force_errors(c, considered, decays, error_decay, now.thrust, now.thrust_errors, force_error);
    }
    step_forces(c, decays, now.thrust, force);
    // boat, in both estimates
    if (now.known == 0) continue;
    const StateEstimate before = now.state;
    if (!predict(m.boat, noise, h, force, force_error, now.state)) {
      reset_diverged(m, before, now);
    } else if (now.votes > 0 && !predict(m.boat, noise, h, force, force_error, now.alternative)) {
      now.votes = 0;
    }
  }
}

}  // namespace detail

/// Prediction over `length` [s] in which no input changes. It leaves `time` to the caller.
inline void propagate(const OnboardModel& m, double length, PredictorState& now) {
  double part = smooth_part(m.chain, m.q, now.thrust, length);
  while (part < length) {
    detail::propagate_smooth(m, part, now);
    length -= part;
    part = smooth_part(m.chain, m.q, now.thrust, length);
  }
  detail::propagate_smooth(m, length, now);
}

/// An estimate as it is published.
struct Estimate {
  double time = 0.0;                         // [s]
  double pose[kPose] = {};                   // x, y [m], psi [rad] in (-pi, pi], earth-fixed
  double velocity[kAxes] = {};               // over ground, body-fixed [m/s, m/s, rad/s]
  double covariance[kStates][kStates] = {};  // of both
  double disturbance[kAxes] = {};            // [m/s^2, m/s^2, rad/s^2]
  double last_pose = kLongAgo;               // [s] stamp of the last pose that was used
  std::uint32_t health = 0;
};

namespace detail {

/// Velocity over ground: that through the water plus R' c; with the heading's share of covariance.
inline void add_current(const OnboardBoat& boat, Estimate& out) {
  const double* w = boat.current;
  if (w[0] == 0.0 && w[1] == 0.0) return;
  double body[2];
  plane_to_body(std::cos(out.pose[2]), std::sin(out.pose[2]), w, body);
  const double slope[2] = {body[1], -body[0]};  // d / d psi
  double(&p)[kStates][kStates] = out.covariance;
  for (int i = 0; i < 2; ++i) {
    out.velocity[i] += body[i];
    for (int j = 0; j < kStates; ++j) p[3 + i][j] += slope[i] * p[2][j];
  }
  for (double(&row)[kStates] : p) {  // columns after rows
    for (int i = 0; i < 2; ++i) row[3 + i] += slope[i] * row[2];
  }
  for (int i = 0; i < kStates; ++i) {
    for (int j = 0; j < i; ++j) p[i][j] = p[j][i];
  }
}

}  // namespace detail

/// The estimate of a predictor state, with the flags that follow from it.
inline Estimate estimate(const OnboardModel& m, const PredictorState& now) {
  Estimate out;
  out.time = now.time;
  const StateEstimate& b = now.state;
  std::copy(b.x, b.x + 2, out.pose);
  out.pose[2] = wrap(b.x[2]);
  std::copy(b.x + 3, b.x + kStates, out.velocity);
  std::copy(b.x + kStates, b.x + kFilterStates, out.disturbance);
  for (int i = 0; i < kStates; ++i) std::copy(b.p[i], b.p[i] + kStates, out.covariance[i]);
  out.last_pose = now.last_pose;
  double force[kMaxForces];
  forces_after(m.chain, m.q, now.thrust, 0.0, force);
  const Envelope& e = m.envelope;
  const auto flag = [&out](bool raised, Health which) { out.health |= raised ? which : 0U; };
  flag(!now.initialised, kNoPose);
  flag(now.initialised && now.time - now.last_pose > m.dead_reckoning_after, kDeadReckoning);
  flag(now.rejected > 0, kGateRejecting);
  flag(now.time - now.reinitialised <= m.flag_for, kReinitialised);
  flag(now.time - now.doubted <= m.cautious_for, kModelDoubted);
  flag(now.time - now.diverged <= m.flag_for, kDiverged);
  flag(Envelope::outside(out.velocity, e.speed, kAxes), kOutsideSpeeds);
  flag(Envelope::outside(force, e.force, m.chain.n_forces), kOutsideCommands);
  detail::add_current(m.boat, out);
  return out;
}

}  // namespace seatrial
