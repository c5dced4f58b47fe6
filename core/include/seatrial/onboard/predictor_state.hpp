// SPDX-License-Identifier: MIT
// One instant of the on-board predictor: thrusters, state, and the second state that poses are
// held against which the first one does not believe. No heap, no exceptions.
#pragma once
#include "seatrial/onboard/health.hpp"
#include "seatrial/onboard/onboard_filter.hpp"

namespace seatrial {

inline constexpr double kLongAgo = -1e300;  // [s]

/// All that the predictor is told beforehand.
struct OnboardModel {
  OnboardBoat boat;
  Chain chain;
  double q[kMaxConstants] = {};
  Envelope envelope;
  double command_timeout = std::numeric_limits<double>::infinity();  // [s] then none is in force

  double window = 0.5;  // [s] that an input may be late
  double gate = 25.0;   // of e' S^-1 e, three degrees of freedom: one in 65 000 by chance
  double always_accepted[2] = {
      0.02, 0.05};         // [m], [rad] a pose so near to its prediction is no false match
  double outlier = 4.0;    // [sigma] from where on a pose's error counts linearly
  int votes = 10;          // agreeing poses that overrule the filter ...
  double votes_for = 0.5;  // [s] ... and at least so long
  double velocity_spread[kAxes] = {0.5, 0.3, 0.6};  // [m/s, m/s, rad/s] at the first pose
  double alternative_velocity_spread[kAxes] = {
      0.1, 0.1, 0.2};                 // [m/s, m/s, rad/s] where the filter was wrong
  double overruled_within = 60.0;     // [s] overruled twice within these ...
  double cautious_for = 600.0;        // [s] ... it is wary of the model for so long
  double flag_for = 1.0;              // [s] that a flag stays
  double dead_reckoning_after = 0.5;  // [s] without a used pose after which it is dead reckoning
};

/// A pose as it is used, with the covariance of its white error.
struct PoseSample {
  double eta[kPose] = {};
  double noise[kPose][kPose] = {};
};

/// The predictor at one instant.
struct PredictorState {
  double time = 0.0;
  Thrust thrust;
  ThrustErrors thrust_errors;
  StateEstimate state;
  StateEstimate alternative;  // begun at a pose that was rejected; counts while votes > 0
  int votes = 0;
  double alternative_since = 0.0;  // [s]
  int rejected = 0;                // poses in a row
  bool initialised = false;        // a pose was used, and the model has not run away since
  double last_pose = kLongAgo;
  double reinitialised = kLongAgo;
  double overruled = kLongAgo;  // by poses
  double doubted = kLongAgo;    // overruled again
  double diverged = kLongAgo;
};

namespace detail {

inline constexpr double kFirstSpread = 3.0;        // of a first pose, in standard deviations of one
inline constexpr double kUnknownPosition = 100.0;  // [m]
inline constexpr double kUnknownHeading = 3.0;     // [rad]
inline constexpr double kLostHeading = 1.0;        // [rad] from where on nothing is linear

/// Begins the correlated errors of the poses anew: as large as they ever are.
inline void reset_coloured_noise(const NoiseParameters& n, StateEstimate& b) {
  if (!b.coloured()) return;
  for (int c = kFilterStates; c < b.n; ++c) {
    b.x[c] = 0.0;
    for (int j = 0; j < b.n; ++j) b.p[c][j] = b.p[j][c] = 0.0;
    std::fill(b.d[c], b.d[c] + kMostConsidered, 0.0);
    b.p[c][c] = n.colour_variance((c - kFilterStates) % kPose);
  }
}

/// Pose out of nothing but the sample; what else is believed stays, its links to the pose do not.
inline void reset_pose(const NoiseParameters& n, const PoseSample& pose, StateEstimate& b) {
  for (int i = 0; i < kPose; ++i) {
    b.x[i] = pose.eta[i];
    for (int j = 0; j < b.n; ++j) b.p[i][j] = b.p[j][i] = 0.0;
    std::fill(b.d[i], b.d[i] + kMostConsidered, 0.0);
  }
  reset_coloured_noise(n, b);
  for (int i = 0; i < kPose; ++i) {
    for (int j = 0; j < kPose; ++j) {
      b.p[i][j] = kFirstSpread * kFirstSpread * pose.noise[i][j];
    }
    if (!b.coloured()) continue;
    const double colour = n.colour_variance(i);  // the pose is eta less it
    b.p[i][i] += kFirstSpread * kFirstSpread * colour;
    b.p[i][kFilterStates + i] = b.p[kFilterStates + i][i] = -colour;
  }
}

/// A pose's own covariance is of all its error: its white part is what the correlated errors
/// leave of it, no less than the model's white noise, or all of it where it is smaller
/// than that. Correlations stay.
inline void keep_white_part(const NoiseParameters& n, double noise[kPose][kPose]) {
  if (!n.coloured()) return;
  double share[kPose];
  for (int i = 0; i < kPose; ++i) {
    const double all = noise[i][i];
    const double least = std::min(all, n.white_variance(i));
    share[i] = std::sqrt(std::max(all - n.colour_variance(i), least) / all);
  }
  for (int i = 0; i < kPose; ++i) {
    for (int j = 0; j < kPose; ++j) noise[i][j] *= share[i] * share[j];
  }
}

/// Nothing known but that a boat is slow.
inline void reset_to_unknown(const OnboardModel& m, StateEstimate& b) {
  const NoiseParameters& n = m.boat.noise;
  const double spread[kFilterStates] = {
      kUnknownPosition,     kUnknownPosition,     kUnknownHeading,
      m.velocity_spread[0], m.velocity_spread[1], m.velocity_spread[2],
      n.disturbance_linear, n.disturbance_linear, n.disturbance_yaw};
  b = StateEstimate{};
  b.n = n.oscillating() ? kOscillatingStates : n.coloured() ? kColouredStates : kFilterStates;
  for (int i = 0; i < kFilterStates; ++i) b.p[i][i] = spread[i] * spread[i];
  reset_coloured_noise(n, b);
}

/// Whether a pose may be of this boat.
inline bool passes_gate(const OnboardModel& m, const Innovation& found) {
  if (!std::isfinite(found.nis)) return false;
  const bool near = std::hypot(found.e[0], found.e[1]) <= m.always_accepted[0] &&
                    std::abs(found.e[2]) <= m.always_accepted[1];
  return near || found.nis <= m.gate;
}

/// A second state: at the pose, with the first one's velocity, which may be wrong.
inline void begin_alternative(const OnboardModel& m, const PoseSample& pose, PredictorState& now) {
  now.alternative = now.state;
  reset_pose(m.boat.noise, pose, now.alternative);
  for (int a = 0; a < kAxes; ++a)
    now.alternative.p[3 + a][3 + a] +=
        m.alternative_velocity_spread[a] * m.alternative_velocity_spread[a];
  now.votes = 1;
  now.alternative_since = now.time;
}

/// Poses that the filter rejects vote for the second state, or against it: the majority of them,
/// by Boyer and Moore. True once it has won.
inline bool alternative_wins(const OnboardModel& m, const PoseSample& pose, PredictorState& now) {
  if (now.votes == 0) {
    begin_alternative(m, pose, now);
    return false;
  }
  const Innovation found = innovation(now.alternative, pose.eta, pose.noise, m.outlier);
  if (!passes_gate(m, found)) {
    if (--now.votes == 0) begin_alternative(m, pose, now);
    return false;
  }
  update(found, pose.noise, now.alternative);
  return ++now.votes >= m.votes && now.time - now.alternative_since >= m.votes_for;
}

}  // namespace detail

/// The model ran away: its pose is the last one, and nothing is known until the next.
inline void reset_diverged(const OnboardModel& m, const StateEstimate& last, PredictorState& now) {
  const double pose[kPose] = {last.x[0], last.x[1], last.x[2]};
  detail::reset_to_unknown(m, now.state);
  std::copy(pose, pose + kPose, now.state.x);
  now.initialised = false;
  now.votes = now.rejected = 0;
  now.diverged = now.time;
}

/// Gate, correction and recovery at the time of a pose.
inline void update_by_pose(const OnboardModel& m, const PoseSample& pose, PredictorState& now) {
  const double heading = now.state.p[2][2];
  const bool lost = now.initialised && heading > detail::kLostHeading * detail::kLostHeading;
  const StateEstimate before = now.state;
  bool used = true;
  if (!now.initialised || lost) {
    detail::reset_pose(m.boat.noise, pose, now.state);
    now.initialised = true;
    if (lost) now.reinitialised = now.time;
  } else {
    const Innovation found = innovation(now.state, pose.eta, pose.noise, m.outlier);
    used = detail::passes_gate(m, found);
    if (used) {
      update(found, pose.noise, now.state);
    } else if (detail::alternative_wins(m, pose, now)) {
      now.state = now.alternative;
      now.reinitialised = now.time;
      if (now.time - now.overruled <= m.overruled_within) now.doubted = now.time;
      now.overruled = now.time;
      used = true;
    }
  }
  if (!used) {
    ++now.rejected;
    return;
  }
  now.votes = now.rejected = 0;
  now.last_pose = now.time;
  if (!plausible(now.state)) reset_diverged(m, before, now);
}

/// Over `length` [s] without a break of the input; does not move the time.
inline void propagate(const OnboardModel& m, double length, PredictorState& now) {
  const Chain& c = m.chain;
  Thrust& f = now.thrust;
  const int n = steps_for(length, m.boat.longest_step);
  const double h = length / n;
  LagDecay decays[kMaxActuators];
  ErrorDecay errors[kMaxActuators];
  double force[3][kMaxForces];
  Loadings force_error[kMaxForces] = {};
  const PrincipalErrors& considered = m.boat.considered;
  const bool doubted = now.time - now.doubted <= m.cautious_for;
  const NoiseParameters noise = doubted ? with_default_process_noise(m.boat.noise) : m.boat.noise;
  if (considered.n > 0) {
    error_decays(c, m.q, h, decays, errors);
  } else {
    lag_decays(c, m.q, h, decays);
  }
  for (int i = 0; i < n; ++i) {
    if (considered.n > 0) {
      force_errors(c, considered, decays, errors, f, now.thrust_errors, force_error);
    }
    step_forces(c, decays, f, force);
    if (!now.initialised) continue;
    const StateEstimate before = now.state;
    if (!predict(m.boat, noise, h, force, force_error, now.state)) {
      reset_diverged(m, before, now);
    } else if (now.votes > 0 && !predict(m.boat, noise, h, force, force_error, now.alternative)) {
      now.votes = 0;
    }
  }
}

/// What is published.
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

/// Velocity over ground: that in the water plus R' c. Its covariance with what the heading makes.
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

/// The estimate of an instant, with the flags that it knows of itself.
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
