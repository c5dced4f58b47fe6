// SPDX-License-Identifier: MIT
// The on-board predictor's last half second: inputs put in their place by stamp, and what follows
// from them done again. No heap, no exceptions.
//
// The state at any time is a function of the inputs in the order of their stamps, not of how they
// arrived, to the last bit: integration breaks where an input takes effect, at poses and at
// multiples of kGrid, whoever asks for what and when. Instants are kept at poses and on the grid;
// what comes late is put in, and all after it is done again from the instant before.
#pragma once
#include "seatrial/onboard/history.hpp"
#include "seatrial/onboard/predictor_state.hpp"

namespace seatrial {

/// kMarks: instants that are kept. kRows: commands that are kept, and as many scales.
template <int kMarks, int kRows>
class Timeline {
 public:
  static constexpr double kGrid = 0.125;  // [s] a power of two: its multiples are exact

  explicit Timeline(const OnboardModel& model)
      : m_(model),
        commands_(model.chain.allocation.n_commands, model.command_timeout),
        scales_(model.chain.n_scales) {
    list_latencies();
  }

  const OnboardModel& model() const { return m_; }
  bool begun() const { return marks_ > 0; }
  double newest() const { return newest_; }  // [s] what time it is at least
  double oldest() const { return mark(0).time; }
  double last() const { return mark(marks_ - 1).time; }
  double shortest() const { return shortest_; }  // [s] latency
  /// How old an effect may be [s]; a latency below zero reaches back further.
  double window() const { return m_.window * (1.0 + 1e-9) - std::min(0.0, shortest_); }

  /// As at the start.
  void forget() {
    marks_ = 0;
    tip_valid_ = false;
    commands_.clear();
    scales_.clear();
  }

  /// The first instant, well before t [s]: thrusters settled at what is in force, else nothing
  /// known.
  void begin(double t) {
    marks_ = 1;
    newest_ = t;
    tip_valid_ = false;
    Instant& now = instant(0);
    now = Instant{};
    now.time = std::floor((t - 2.0 * window()) / kGrid) * kGrid;
    detail::know_nothing(m_, now.belief);
    for (int g = 0; g < groups_; ++g) aim(g, now);
    rescale(now);
    std::copy(now.thrust.target, now.thrust.target + kMaxActuators, now.thrust.level);
    for (Causes& away : now.thrust_errors.away) std::fill(away, away + kMostConsidered, 0.0);
    mark(0) = Mark{now.time, false, {}};
  }

  /// It is now t [s], if not later: instants on the grid up to it; those that nothing can reach any
  /// more are forgotten.
  void extend(double t) {
    newest_ = std::max(newest_, t);
    double next = grid_after(last());
    while (next <= newest_) {
      if (marks_ == kMarks) drop();
      Instant now = latest(next);
      run(now, next, false);
      mark(marks_) = Mark{next, false, {}};
      instant(marks_) = now;
      ++marks_;
      while (marks_ > 1 && mark(1).time <= newest_ - window()) drop();
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

  /// A pose of time t [s].
  Taken put_pose(double t, const PoseSample& pose) {
    int i = marks_;
    while (i > 0 && mark(i - 1).time > t) --i;
    for (int k = i - 1; k >= 0 && mark(k).time == t; --k) {
      if (mark(k).posed && same(mark(k).pose, pose)) return Taken::kTwice;
    }
    if (marks_ == kMarks && i > 1) {
      drop();
      --i;
    }
    if (i < 1 || marks_ == kMarks) return i < 1 ? Taken::kStale : Taken::kNoRoom;
    const Instant from = i == marks_ ? latest(t) : instant(i - 1);
    for (int k = marks_++; k > i; --k) mark(k) = mark(k - 1);
    mark(i) = Mark{t, true, pose};
    if (tip_valid_ && tip_.time >= t) tip_valid_ = false;
    renew(i, from);
    for (int k = i + 1; k < marks_; ++k) renew(k, instant(k - 1));
    return Taken::kUsed;
  }

  /// The instant t >= oldest() [s].
  Instant look(double t) {
    Instant now = latest(t);
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
  /// A place where the state is kept: after the pose, if there is one.
  struct Mark {
    double time = 0.0;
    bool posed = false;
    PoseSample pose;
  };

  static bool same(const PoseSample& a, const PoseSample& b) {
    return std::equal(a.eta, a.eta + kPose, b.eta) &&
           std::equal(&a.noise[0][0], &a.noise[0][0] + std::ptrdiff_t{kPose} * kPose,
                      &b.noise[0][0]);
  }

  static double grid_after(double t) { return (std::floor(t / kGrid) + 1.0) * kGrid; }

  void drop() {
    first_ = (first_ + 1) % kMarks;
    --marks_;
  }

  /// From t [s] on all is different.
  bool changed(double t) {
    if (tip_valid_ && tip_.time >= t) tip_valid_ = false;
    int i = marks_;
    while (i > 1 && mark(i - 1).time >= t) --i;
    for (; i < marks_; ++i) renew(i, instant(i - 1));
    return true;
  }

  /// The i-th instant again, from one before it.
  void renew(int i, const Instant& from) {
    Instant& to = instant(i);
    to = from;
    run(to, mark(i).time, false);
    if (mark(i).posed) use_pose(m_, mark(i).pose, to);
  }

  /// The latest instant that is known at or before t.
  const Instant& latest(double t) const {
    int i = marks_ - 1;
    while (i > 0 && mark(i).time > t) --i;
    const bool tip = tip_valid_ && i == marks_ - 1 && tip_.time <= t && tip_.time > mark(i).time;
    return tip ? tip_ : instant(i);
  }

  /// To time t [s]. `keep`: the next look begins at the last break before it.
  void run(Instant& now, double t, bool keep) {
    while (now.time < t) {
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
      drift(m_, next - now.time, now);
      now.time = next;
      for (int g = 0; g < groups_; ++g) {
        if (changes[g] <= next) aim(g, now);
      }
      if (scaled <= next) rescale(now);
    }
  }

  /// Targets of a group's actuators by what is in force; nothing in force is zero.
  void aim(int g, Instant& now) const {
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
      const double lag = detail::constant(m_.q, m_.chain.actuators[k].lag, 0.0);
      if (lag <= kShortestLag) now.thrust.level[k] = now.thrust.target[k];
    }
  }

  void rescale(Instant& now) const {
    const double* values = scales_.values(now.time, 0.0);
    const double* known = values == nullptr ? m_.chain.scale_reference : values;
    for (int k = 0; k < m_.chain.n_actuators(); ++k) {
      double slope[kMaxConstants] = {};
      now.thrust.multiplier[k] = multiplier(m_.chain, m_.q, k, known, slope);
      Causes& error = now.thrust_errors.multiplier[k];
      std::fill(error, error + kMostConsidered, 0.0);
      detail::add_constants(considered(), slope, m_.chain.n_constants, error);
    }
  }

  const Considered& considered() const { return m_.boat.considered; }

  /// Actuators of one latency are aimed together.
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

  Mark& mark(int i) { return ring_[(first_ + i) % kMarks]; }
  const Mark& mark(int i) const { return ring_[(first_ + i) % kMarks]; }
  Instant& instant(int i) { return instants_[(first_ + i) % kMarks]; }
  const Instant& instant(int i) const { return instants_[(first_ + i) % kMarks]; }

  OnboardModel m_;
  History<kRows, kMaxCommands> commands_;
  History<kRows, kMaxScales> scales_;
  int groups_ = 0;
  int group_[kMaxActuators] = {};
  double latency_[kMaxActuators] = {};  // [s] of each group
  double shortest_ = 0.0;               // [s]
  double longest_ = 0.0;                // [s]
  double newest_ = 0.0;                 // [s]
  Instant tip_;                         // the last break that a look came to
  bool tip_valid_ = false;
  int first_ = 0;
  int marks_ = 0;
  Mark ring_[kMarks];
  Instant instants_[kMarks];
};

}  // namespace seatrial
