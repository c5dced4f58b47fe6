// SPDX-License-Identifier: MIT
// Use of a pose by the on-board predictor: start, gate, update, and the alternative estimate that
// starts at a rejected pose. No heap, no exceptions.
#pragma once
#include "seatrial/onboard/health.hpp"
#include "seatrial/onboard/onboard_filter.hpp"

namespace seatrial {

inline constexpr double kLongAgo = -1e300;  // [s]

/// The model and the settings of the predictor.
struct OnboardModel {
  OnboardBoat boat;
  Chain chain;
  double q[kMaxConstants] = {};
  Envelope envelope;
  double command_timeout = std::numeric_limits<double>::infinity();  // [s] validity of a command

  double position_delay = 0.0;  // [s] by which the position of a pose is older than its stamp
  double heading_delay = 0.0;   // [s] by which its heading is

  double window = 0.5;  // [s] by which an input may be late
  double gate = 25.0;   // of the NIS, 3 degrees of freedom: false alarm rate 1 in 65 000
  double always_accepted[2] = {0.02, 0.05};  // [m], [rad] innovation that is no false match
  double outlier = 4.0;    // [sigma] innovation from which the cost grows linearly (Huber)
  int votes = 10;          // rejected poses that agree and reset the filter ...
  double votes_for = 0.5;  // [s] ... over at least this time
  double velocity_spread[kAxes] = {0.5, 0.3, 0.6};     // [m/s, m/s, rad/s] at the first pose
  double alternative_spread[kAxes] = {0.1, 0.1, 0.2};  // [m/s, m/s, rad/s] added where it starts
  double overruled_within = 60.0;                      // [s] after two resets within this time ...
  double cautious_for = 600.0;        // [s] ... process noise is increased for this time
  double flag_for = 1.0;              // [s] duration of a flag
  double dead_reckoning_after = 0.5;  // [s] without a used pose
};

/// A pose, or the position or heading of one, with the covariance of its white noise.
struct PoseSample {
  double eta[kPose] = {};
  double noise[kPose][kPose] = {};
  Parts parts = kWholePose;
  double lever[2] = {};  // [m] of a position alone: the measured point, forward and left
};

/// The predictor at one instant.
struct PredictorState {
  double time = 0.0;
  Thrust thrust;
  ThrustErrors thrust_errors;
  StateEstimate state;
  StateEstimate alternative;  // from a rejected pose on; valid while votes > 0
  int votes = 0;
  double alternative_since = 0.0;   // [s]
  int rejected = 0;                 // consecutive poses
  bool initialised = false;         // a pose was used, and no divergence since
  unsigned known = 0;               // parts of a pose that were used since then
  unsigned voted = 0;               // parts that are rejected
  double last_pose = kLongAgo;      // [s] stamp of the last used pose
  double reinitialised = kLongAgo;  // [s] of the last event, as what follows: reset to poses
  double overruled = kLongAgo;      // reset to poses that contradicted the filter
  double doubted = kLongAgo;        // the same again within overruled_within
  double diverged = kLongAgo;
};

namespace detail {

inline constexpr double kFirstSpread = 3.0;        // of a first pose, in standard deviations of one
inline constexpr double kUnknownPosition = 100.0;  // [m]
inline constexpr double kUnknownHeading = 3.0;     // [rad]
inline constexpr double kLostHeading =
    1.0;  // [rad] standard deviation beyond which the EKF is not linear enough

/// Coloured pose noise at its stationary variance, uncorrelated with all else.
inline void reset_coloured_noise(const NoiseParameters& n, StateEstimate& b,
                                 Parts parts = kWholePose) {
  if (!b.coloured()) return;
  for (int c = kFilterStates; c < b.n; ++c) {
    const int i = (c - kFilterStates) % kPose;
    if (!has(parts, i)) continue;
    b.x[c] = 0.0;
    for (int j = 0; j < b.n; ++j) b.p[c][j] = b.p[j][c] = 0.0;
    std::fill(b.d[c], b.d[c] + kMostConsidered, 0.0);
    b.p[c][c] = n.colour_variance(i);
  }
}

/// The sample as the filter measures it, at the heading of the estimate.
inline Measurement measured(const PoseSample& pose, const StateEstimate& b) {
  Measurement y = measured_pose(pose.eta, pose.noise);
  y.parts = pose.parts;
  if (pose.lever[0] == 0.0 && pose.lever[1] == 0.0) return y;
  plane_to_earth(std::cos(b.x[2]), std::sin(b.x[2]), pose.lever, y.offset);
  y.turn[0] = -y.offset[1];
  y.turn[1] = y.offset[0];
  return y;
}

/// The pose, or its measured part, from the sample alone. The other states stay; their correlations
/// with it go.
inline void reset_pose(const NoiseParameters& n, const PoseSample& pose, StateEstimate& b) {
  const Measurement y = measured(pose, b);
  for (int i = 0; i < kPose; ++i) {
    if (!has(pose.parts, i)) continue;
    b.x[i] = pose.eta[i] - y.offset[i];
    for (int j = 0; j < b.n; ++j) b.p[i][j] = b.p[j][i] = 0.0;
    std::fill(b.d[i], b.d[i] + kMostConsidered, 0.0);
  }
  reset_coloured_noise(n, b, pose.parts);
  for (int i = 0; i < kPose; ++i) {
    if (!has(pose.parts, i)) continue;
    for (int j = 0; j < kPose; ++j) {
      if (has(pose.parts, j)) b.p[i][j] = kFirstSpread * kFirstSpread * pose.noise[i][j];
    }
    if (!b.coloured()) continue;
    const double colour = n.colour_variance(i);  // the pose is eta less this noise
    b.p[i][i] += kFirstSpread * kFirstSpread * colour;
    b.p[i][kFilterStates + i] = b.p[kFilterStates + i][i] = -colour;
  }
}

/// A pose's own covariance is of its total noise. Its white part is what the coloured noise leaves,
/// at least the model's white noise, or all of it where it is smaller than that. Correlations stay.
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

/// Unknown pose, a slow boat.
inline void reset_to_unknown(const OnboardModel& m, StateEstimate& b) {
  const bool earth = m.boat.frame == DisturbanceFrame::kEarth;
  const NoiseParameters n = earth ? equal_in_plane(m.boat.noise) : m.boat.noise;
  const double spread[kFilterStates] = {
      kUnknownPosition,     kUnknownPosition,     kUnknownHeading,
      m.velocity_spread[0], m.velocity_spread[1], m.velocity_spread[2],
      n.disturbance(0),     n.disturbance(1),     n.disturbance(2)};
  b = StateEstimate{};
  b.n = states_for(n);
  for (int i = 0; i < kFilterStates; ++i) b.p[i][i] = spread[i] * spread[i];
  reset_coloured_noise(n, b);
}

/// The innovation gate.
inline bool passes_gate(const OnboardModel& m, const Innovation& found) {
  if (!std::isfinite(found.nis)) return false;
  const bool near = std::hypot(found.e[0], found.e[1]) <= m.always_accepted[0] &&
                    std::abs(found.e[2]) <= m.always_accepted[1];
  return near || found.nis <= m.gate;
}

/// The alternative: at the rejected pose, with the filter's velocity, which is less certain.
inline void begin_alternative(const OnboardModel& m, const PoseSample& pose, PredictorState& now) {
  now.alternative = now.state;
  reset_pose(m.boat.noise, pose, now.alternative);
  for (int a = 0; a < kAxes; ++a) {
    now.alternative.p[3 + a][3 + a] += m.alternative_spread[a] * m.alternative_spread[a];
  }
  now.votes = 1;
  now.voted = pose.parts;
  now.alternative_since = now.time;
}

/// A rejected pose votes for the alternative or against it (majority vote of Boyer and Moore). True
/// once the alternative has won.
inline bool alternative_wins(const OnboardModel& m, const PoseSample& pose, PredictorState& now) {
  if (now.votes == 0) {
    begin_alternative(m, pose, now);
    return false;
  }
  if ((pose.parts & ~now.voted) != 0) {  // so far only the other part was rejected
    reset_pose(m.boat.noise, pose, now.alternative);
    now.voted |= pose.parts;
    return false;
  }
  const Measurement y = measured(pose, now.alternative);
  const Innovation found = innovation(now.alternative, y, m.outlier);
  if (!passes_gate(m, found)) {
    if (--now.votes == 0) begin_alternative(m, pose, now);
    return false;
  }
  update(found, y, now.alternative);
  return ++now.votes >= m.votes && now.time - now.alternative_since >= m.votes_for;
}

/// A part of a pose that passes the gate while the other part is rejected: it says nothing about
/// the votes.
inline void update_alternative(const OnboardModel& m, const PoseSample& pose, PredictorState& now) {
  if (now.votes == 0) return;
  const Measurement y = measured(pose, now.alternative);
  const Innovation found = innovation(now.alternative, y, m.outlier);
  if (passes_gate(m, found)) update(found, y, now.alternative);
}

/// [s] from the time of a pose, or of its part, to its stamp.
inline double delay(const OnboardModel& m, Parts parts) {
  return has(parts, 0) ? m.position_delay : m.heading_delay;
}

}  // namespace detail

/// After a divergence: the last pose, all else unknown until the next pose.
inline void reset_diverged(const OnboardModel& m, const StateEstimate& last, PredictorState& now) {
  const double pose[kPose] = {last.x[0], last.x[1], last.x[2]};
  detail::reset_to_unknown(m, now.state);
  std::copy(pose, pose + kPose, now.state.x);
  now.initialised = false;
  now.votes = now.rejected = 0;
  now.known = now.voted = 0;
  now.diverged = now.time;
}

/// Use of a pose at its time: start, gate and update, or reset to what the poses agree on.
inline void update_by_pose(const OnboardModel& m, const PoseSample& pose, PredictorState& now) {
  const double heading = now.state.p[2][2];
  const bool lost = now.initialised && heading > detail::kLostHeading * detail::kLostHeading;
  const StateEstimate before = now.state;
  bool used = true;
  bool settles = true;             // what was rejected before
  if (!now.initialised || lost) {  // the first pose, or the heading is lost
    if (lost) now.known = 0;
    detail::reset_pose(m.boat.noise, pose, now.state);
    now.known |= pose.parts;
    now.initialised = now.known == kWholePose;
    if (lost) now.reinitialised = now.time;
  } else {
    const Measurement y = detail::measured(pose, now.state);
    const Innovation found = innovation(now.state, y, m.outlier);
    used = detail::passes_gate(m, found);
    if (used) {  // the usual case
      update(found, y, now.state);
      settles = now.rejected == 0 || (pose.parts & now.voted) != 0;
      if (!settles) detail::update_alternative(m, pose, now);
    } else if (detail::alternative_wins(m, pose, now)) {  // rejected poses agree with each other
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
  if (settles) now.votes = now.rejected = 0;
  now.last_pose = now.time + detail::delay(m, pose.parts);
  if (!plausible(now.state)) reset_diverged(m, before, now);
}

}  // namespace seatrial
