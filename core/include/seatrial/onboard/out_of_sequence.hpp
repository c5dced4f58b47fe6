// SPDX-License-Identifier: MIT
// Out-of-sequence measurements on board: the inputs of the last half second, sorted by stamp, and
// the states that follow from them. No heap, no exceptions.
//
// The state at any time is a function of the inputs in the order of their stamps, not of their
// arrival, to the last bit: integration breaks where an input takes effect, at poses and at
// multiples of kGrid, whatever the queries. Checkpoints keep the state at poses and on the grid. A
// late input is inserted, and all checkpoints after it are computed again from the one before.
#pragma once
#include "seatrial/onboard/history.hpp"
#include "seatrial/onboard/predictor_state.hpp"

namespace seatrial {

/// kCheckpoints: states that are kept. kRows: commands that are kept, and as many scales.
template <int kCheckpoints, int kRows>
class OutOfSequenceBuffer {
 public:
  static constexpr double kGrid = 0.125;  // [s] a power of two: its multiples are exact

  explicit OutOfSequenceBuffer(const OnboardModel& model)
      : m_(model),
        commands_(model.chain.allocation.n_commands, model.command_timeout),
        scales_(model.chain.n_scales) {
    list_latencies();
  }

  const OnboardModel& model() const { return m_; }
  bool begun() const { return checkpoints_ > 0; }
  double newest() const { return newest_; }  // [s] the present at the earliest
  double oldest() const { return checkpoint(0).time; }
  double last() const { return checkpoint(checkpoints_ - 1).time; }
  double shortest() const { return shortest_; }  // [s] latency
  /// Oldest effect of an input [s]; a negative latency and a delay of poses reach back further.
  double window() const {
    const double delay = std::max({0.0, m_.position_delay, m_.heading_delay});
    return m_.window * (1.0 + 1e-9) - std::min(0.0, shortest_) + delay;
  }

  /// Resets to the start.
  void forget() {
    checkpoints_ = 0;
    tip_valid_ = false;
    commands_.clear();
    scales_.clear();
  }

  /// The first checkpoint, well before t [s]: thrusters settled at the commands in force, else
  /// unknown.
  void begin(double t) {
    checkpoints_ = 1;
    newest_ = t;
    tip_valid_ = false;
    PredictorState& now = state(0);
    now = PredictorState{};
    now.time = std::floor((t - 2.0 * window()) / kGrid) * kGrid;
    detail::reset_to_unknown(m_, now.state);
    for (int g = 0; g < groups_; ++g) aim(g, now);
    rescale(now);
    std::copy(now.thrust.target, now.thrust.target + kMaxActuators, now.thrust.level);
    for (Loadings& away : now.thrust_errors.away) std::fill(away, away + kMostConsidered, 0.0);
    checkpoint(0) = Checkpoint{now.time, false, {}};
  }

  /// The present is t [s] or later: checkpoints on the grid up to it. Those that no input can reach
  /// any more are dropped.
  void extend(double t) {
    newest_ = std::max(newest_, t);
    double next = grid_after(last());
    while (next <= newest_) {
      if (checkpoints_ == kCheckpoints) drop();
      PredictorState now = latest(next);
      run(now, next, false);
      checkpoint(checkpoints_) = Checkpoint{next, false, {}};
      state(checkpoints_) = now;
      ++checkpoints_;
      while (checkpoints_ > 1 && checkpoint(1).time <= newest_ - window()) drop();
      next += kGrid;
    }
  }

  /// Commands to all inputs, stamped t [s]. False: no room.
  bool put_command(double t, const double* values) {
    commands_.forget(oldest(), longest_);
    return commands_.insert(t, values) && changed(t + shortest_);
  }

  /// Scale signals, stamped t [s]. False: no room.
  bool put_scale(double t, const double* values) {
    scales_.forget(oldest(), 0.0);
    return scales_.insert(t, values) && changed(t);
  }

  /// A pose, or a part of one, of time t [s].
  Taken put_pose(double t, const PoseSample& pose) {
    // its place among the checkpoints; a duplicate is not used twice
    int i = checkpoints_;
    while (i > 0 && checkpoint(i - 1).time > t) --i;
    while (i > 1 && checkpoint(i - 1).time == t && follows(checkpoint(i - 1), pose.parts)) --i;
    for (int k = i - 1; k >= 0 && checkpoint(k).time == t; --k) {
      if (checkpoint(k).posed && same(checkpoint(k).pose, pose)) return Taken::kTwice;
    }
    // where all places are taken the oldest checkpoint goes
    if (checkpoints_ == kCheckpoints && i > 1) {
      drop();
      --i;
    }
    if (i < 1 || checkpoints_ == kCheckpoints) return i < 1 ? Taken::kStale : Taken::kNoRoom;
    // the checkpoint, and all after it again
    const PredictorState from = i == checkpoints_ ? latest(t) : state(i - 1);
    for (int k = checkpoints_++; k > i; --k) checkpoint(k) = checkpoint(k - 1);
    checkpoint(i) = Checkpoint{t, true, pose};
    if (tip_valid_ && tip_.time >= t) tip_valid_ = false;
    renew(i, from);
    for (int k = i + 1; k < checkpoints_; ++k) renew(k, state(k - 1));
    return Taken::kUsed;
  }

  /// The state at t >= oldest() [s].
  PredictorState at(double t) {
    PredictorState now = latest(t);
    run(now, t, true);
    return now;
  }

  /// Whether some actuator has no command in force at t [s].
  bool silent(double t) const {
    return std::any_of(latency_, latency_ + groups_, [this, t](double latency) {
      return commands_.values(t, latency) == nullptr;
    });
  }

 private:
  /// A time at which the state is kept: after the pose, if there is one.
  struct Checkpoint {
    double time = 0.0;
    bool posed = false;
    PoseSample pose;
  };

  static bool same(const PoseSample& a, const PoseSample& b) {
    return a.parts == b.parts && std::equal(a.eta, a.eta + kPose, b.eta) &&
           std::equal(&a.noise[0][0], &a.noise[0][0] + std::ptrdiff_t{kPose} * kPose,
                      &b.noise[0][0]);
  }

  /// Whether a checkpoint of the same time comes after a part: positions come before headings.
  static bool follows(const Checkpoint& c, Parts parts) {
    return parts != kWholePose && (!c.posed || c.pose.parts > parts);
  }

  static double grid_after(double t) { return (std::floor(t / kGrid) + 1.0) * kGrid; }

  void drop() {
    first_ = (first_ + 1) % kCheckpoints;
    --checkpoints_;
  }

  /// An input changed the state from t [s] on.
  bool changed(double t) {
    if (tip_valid_ && tip_.time >= t) tip_valid_ = false;
    int i = checkpoints_;
    while (i > 1 && checkpoint(i - 1).time >= t) --i;
    for (; i < checkpoints_; ++i) renew(i, state(i - 1));
    return true;
  }

  /// The state of checkpoint i again, from one before it.
  void renew(int i, const PredictorState& from) {
    PredictorState& to = state(i);
    to = from;
    run(to, checkpoint(i).time, false);
    if (checkpoint(i).posed) update_by_pose(m_, checkpoint(i).pose, to);
  }

  /// The latest known state at or before t.
  const PredictorState& latest(double t) const {
    int i = checkpoints_ - 1;
    while (i > 0 && checkpoint(i).time > t) --i;
    const bool tip =
        tip_valid_ && i == checkpoints_ - 1 && tip_.time <= t && tip_.time > checkpoint(i).time;
    return tip ? tip_ : state(i);
  }

  /// Prediction to t [s]. `keep`: the next query begins at the last break before it.
  void run(PredictorState& now, double t, bool keep) {
    while (now.time < t) {
      // the next break: the grid, a command that takes effect or expires, a scale
      double changes[kMaxActuators];
      const double scaled = scales_.next(now.time, 0.0);
      double next = std::min(grid_after(now.time), scaled);
      for (int g = 0; g < groups_; ++g) {
        changes[g] = commands_.next(now.time, latency_[g]);
        next = std::min(next, changes[g]);
      }
      if (next > t) {
        if (keep && now.time > last()) {
          tip_ = now;
          tip_valid_ = true;
        }
        next = t;
      }
      // the boat up to there, then the thrusters' new targets
      propagate(m_, next - now.time, now);
      now.time = next;
      for (int g = 0; g < groups_; ++g) {
        if (changes[g] <= next) aim(g, now);
      }
      if (scaled <= next) rescale(now);
    }
  }

  /// Targets of a group's actuators by the command in force; without one they are zero.
  void aim(int g, PredictorState& now) const {
    const double zero[kMaxCommands] = {};
    const double* values = commands_.values(now.time, latency_[g]);
    double thruster[kMaxActuators];
    allocate(m_.chain.allocation, values == nullptr ? zero : values, thruster);
    for (int k = 0; k < m_.chain.n_actuators(); ++k) {
      if (group_[k] != g) continue;
      const double before = now.thrust.target[k];
      double slope[kMaxConstants] = {};
      double* to = considered().n > 0 ? slope : nullptr;
      now.thrust.target[k] = curve(m_.chain, m_.q, k, thruster, to);
      if (to != nullptr) {
        retarget(m_.chain, m_.q, considered(), k, before, now.thrust.target[k], slope,
                 now.thrust_errors);
      }
      if (follows_at_once(m_.chain, m_.q, k)) now.thrust.level[k] = now.thrust.target[k];
    }
  }

  void rescale(PredictorState& now) const {
    const double* values = scales_.values(now.time, 0.0);
    const double* known = values == nullptr ? m_.chain.scale_reference : values;
    for (int k = 0; k < m_.chain.n_actuators(); ++k) {
      double slope[kMaxConstants] = {};
      now.thrust.multiplier[k] = multiplier(m_.chain, m_.q, k, known, slope);
      Loadings& error = now.thrust_errors.multiplier[k];
      std::fill(error, error + kMostConsidered, 0.0);
      detail::add_constants(considered(), slope, m_.chain.n_constants, error);
    }
  }

  const PrincipalErrors& considered() const { return m_.boat.considered; }

  /// Groups the actuators by latency.
  void list_latencies() {
    for (int k = 0; k < m_.chain.n_actuators(); ++k) {
      const double own = detail::constant(m_.q, m_.chain.actuators[k].latency, 0.0);
      group_[k] = static_cast<int>(std::find(latency_, latency_ + groups_, own) - latency_);
      if (group_[k] == groups_) latency_[groups_++] = own;
    }
    if (groups_ == 0) return;
    shortest_ = *std::min_element(latency_, latency_ + groups_);
    longest_ = *std::max_element(latency_, latency_ + groups_);
  }

  Checkpoint& checkpoint(int i) { return ring_[(first_ + i) % kCheckpoints]; }
  const Checkpoint& checkpoint(int i) const { return ring_[(first_ + i) % kCheckpoints]; }
  PredictorState& state(int i) { return states_[(first_ + i) % kCheckpoints]; }
  const PredictorState& state(int i) const { return states_[(first_ + i) % kCheckpoints]; }

  OnboardModel m_;
  History<kRows, kMaxCommands> commands_;
  History<kRows, kMaxScales> scales_;
  int groups_ = 0;
  int group_[kMaxActuators] = {};
  double latency_[kMaxActuators] = {};  // [s] of each group
  double shortest_ = 0.0;               // [s]
  double longest_ = 0.0;                // [s]
  double newest_ = 0.0;                 // [s]
  PredictorState tip_;                  // the state at the last break of a query
  bool tip_valid_ = false;
  int first_ = 0;
  int checkpoints_ = 0;
  Checkpoint ring_[kCheckpoints];
  PredictorState states_[kCheckpoints];
};

}  // namespace seatrial
