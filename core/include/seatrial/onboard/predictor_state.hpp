// SPDX-License-Identifier: MIT
// One instant of the on-board predictor: thrusters, belief, and the second belief that poses are
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

  double window = 0.5;            // [s] that an input may be late
  double gate = 25.0;             // of e' S^-1 e, three degrees of freedom: one in 65 000 by chance
  double near[2] = {0.02, 0.05};  // [m], [rad] a pose so near to its prediction is no false match
  double outlier = 4.0;           // [sigma] from where on a pose's error counts linearly
  int votes = 10;                 // agreeing poses that overrule the filter ...
  double agreement = 0.5;         // [s] ... and at least so long
  double velocity_spread[kAxes] = {0.5, 0.3, 0.6};  // [m/s, m/s, rad/s] at the first pose
  double doubt[kAxes] = {0.1, 0.1, 0.2};            // [m/s, m/s, rad/s] where the filter was wrong
  double again = 60.0;                              // [s] overruled twice within these ...
  double wary = 600.0;                              // [s] ... it is wary of the model for so long
  double lately = 1.0;                              // [s] that a flag stays
  double patience = 0.5;  // [s] without a used pose after which it is dead reckoning
};

/// A pose as it is used, with the covariance of its white error.
struct PoseSample {
  double eta[kPose] = {};
  double noise[kPose][kPose] = {};
};

/// The predictor at one instant.
struct Instant {
  double time = 0.0;
  Thrust thrust;
  ThrustErrors thrust_errors;
  StateEstimate belief;
  StateEstimate rival;  // begun at a pose that was rejected; counts while votes > 0
  int votes = 0;
  double rival_since = 0.0;  // [s]
  int rejected = 0;          // poses in a row
  bool alive = false;        // a pose was used, and the model has not run away since
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
inline void begin_colour(const NoiseParameters& n, StateEstimate& b) {
  if (!b.coloured()) return;
  for (int c = kFilterStates; c < b.n; ++c) {
    b.x[c] = 0.0;
    for (int j = 0; j < b.n; ++j) b.p[c][j] = b.p[j][c] = 0.0;
    std::fill(b.d[c], b.d[c] + kMostConsidered, 0.0);
    b.p[c][c] = n.colour_variance((c - kFilterStates) % kPose);
  }
}

/// Pose out of nothing but the sample; what else is believed stays, its links to the pose do not.
inline void place(const NoiseParameters& n, const PoseSample& pose, StateEstimate& b) {
  for (int i = 0; i < kPose; ++i) {
    b.x[i] = pose.eta[i];
    for (int j = 0; j < b.n; ++j) b.p[i][j] = b.p[j][i] = 0.0;
    std::fill(b.d[i], b.d[i] + kMostConsidered, 0.0);
  }
  begin_colour(n, b);
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
inline void leave_white(const NoiseParameters& n, double noise[kPose][kPose]) {
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
inline void know_nothing(const OnboardModel& m, StateEstimate& b) {
  const NoiseParameters& n = m.boat.noise;
  const double spread[kFilterStates] = {
      kUnknownPosition,     kUnknownPosition,     kUnknownHeading,
      m.velocity_spread[0], m.velocity_spread[1], m.velocity_spread[2],
      n.disturbance_linear, n.disturbance_linear, n.disturbance_yaw};
  b = StateEstimate{};
  b.n = n.oscillating() ? kOscillatingStates : n.coloured() ? kColouredStates : kFilterStates;
  for (int i = 0; i < kFilterStates; ++i) b.p[i][i] = spread[i] * spread[i];
  begin_colour(n, b);
}

/// Whether a pose may be of this boat.
inline bool passes(const OnboardModel& m, const Innovation& found) {
  if (!std::isfinite(found.nis)) return false;
  const bool near =
      std::hypot(found.e[0], found.e[1]) <= m.near[0] && std::abs(found.e[2]) <= m.near[1];
  return near || found.nis <= m.gate;
}

/// A second belief: at the pose, with the first one's velocity, which may be wrong.
inline void begin_rival(const OnboardModel& m, const PoseSample& pose, Instant& now) {
  now.rival = now.belief;
  place(m.boat.noise, pose, now.rival);
  for (int a = 0; a < kAxes; ++a) now.rival.p[3 + a][3 + a] += m.doubt[a] * m.doubt[a];
  now.votes = 1;
  now.rival_since = now.time;
}

/// Poses that the filter rejects vote for the second belief, or against it: the majority of them,
/// by Boyer and Moore. True once it has won.
inline bool overruled(const OnboardModel& m, const PoseSample& pose, Instant& now) {
  if (now.votes == 0) {
    begin_rival(m, pose, now);
    return false;
  }
  const Innovation found = innovation(now.rival, pose.eta, pose.noise, m.outlier);
  if (!passes(m, found)) {
    if (--now.votes == 0) begin_rival(m, pose, now);
    return false;
  }
  update(found, pose.noise, now.rival);
  return ++now.votes >= m.votes && now.time - now.rival_since >= m.agreement;
}

}  // namespace detail

/// The model ran away: its pose is the last one, and nothing is known until the next.
inline void give_up(const OnboardModel& m, const StateEstimate& last, Instant& now) {
  const double pose[kPose] = {last.x[0], last.x[1], last.x[2]};
  detail::know_nothing(m, now.belief);
  std::copy(pose, pose + kPose, now.belief.x);
  now.alive = false;
  now.votes = now.rejected = 0;
  now.diverged = now.time;
}

/// Gate, correction and recovery at the time of a pose.
inline void use_pose(const OnboardModel& m, const PoseSample& pose, Instant& now) {
  const double heading = now.belief.p[2][2];
  const bool lost = now.alive && heading > detail::kLostHeading * detail::kLostHeading;
  const StateEstimate before = now.belief;
  bool used = true;
  if (!now.alive || lost) {
    detail::place(m.boat.noise, pose, now.belief);
    now.alive = true;
    if (lost) now.reinitialised = now.time;
  } else {
    const Innovation found = innovation(now.belief, pose.eta, pose.noise, m.outlier);
    used = detail::passes(m, found);
    if (used) {
      update(found, pose.noise, now.belief);
    } else if (detail::overruled(m, pose, now)) {
      now.belief = now.rival;
      now.reinitialised = now.time;
      if (now.time - now.overruled <= m.again) now.doubted = now.time;
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
  if (!plausible(now.belief)) give_up(m, before, now);
}

/// Over `length` [s] without a break of the input; does not move the time.
inline void drift(const OnboardModel& m, double length, Instant& now) {
  const Chain& c = m.chain;
  Thrust& f = now.thrust;
  const int n = steps_for(length, m.boat.longest_step);
  const double h = length / n;
  Fade fading[kMaxActuators];
  ErrorFade errors[kMaxActuators];
  double force[3][kMaxForces];
  Causes force_error[kMaxForces] = {};
  const Considered& considered = m.boat.considered;
  const bool doubted = now.time - now.doubted <= m.wary;
  const NoiseParameters noise = doubted ? with_default_process_noise(m.boat.noise) : m.boat.noise;
  if (considered.n > 0) {
    error_fades(c, m.q, h, fading, errors);
  } else {
    fades(c, m.q, h, fading);
  }
  for (int i = 0; i < n; ++i) {
    if (considered.n > 0) {
      force_errors(c, considered, fading, errors, f, now.thrust_errors, force_error);
    }
    step_forces(c, fading, f, force);
    if (!now.alive) continue;
    const StateEstimate before = now.belief;
    if (!predict(m.boat, noise, h, force, force_error, now.belief)) {
      give_up(m, before, now);
    } else if (now.votes > 0 && !predict(m.boat, noise, h, force, force_error, now.rival)) {
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
inline Estimate estimate(const OnboardModel& m, const Instant& now) {
  Estimate out;
  out.time = now.time;
  const StateEstimate& b = now.belief;
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
  flag(!now.alive, kNoPose);
  flag(now.alive && now.time - now.last_pose > m.patience, kDeadReckoning);
  flag(now.rejected > 0, kGateRejecting);
  flag(now.time - now.reinitialised <= m.lately, kReinitialised);
  flag(now.time - now.doubted <= m.wary, kModelDoubted);
  flag(now.time - now.diverged <= m.lately, kDiverged);
  flag(Envelope::outside(out.velocity, e.speed, kAxes), kOutsideSpeeds);
  flag(Envelope::outside(force, e.force, m.chain.n_forces), kOutsideCommands);
  detail::add_current(m.boat, out);
  return out;
}

}  // namespace seatrial
