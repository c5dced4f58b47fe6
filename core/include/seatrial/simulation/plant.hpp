// SPDX-License-Identifier: MIT
// A boat that is driven live: commands in as they come, state out. No heap, no exceptions.
#pragma once
#include <algorithm>
#include <limits>

#include "seatrial/integration/step.hpp"

namespace seatrial {

inline constexpr int kMaxPending = 1024;  // commands under way at once (latency x rate)

/// Model, chain and state. Latencies are >= 0 here: a plant can't know a command before it.
class Plant {
 public:
  Plant(const Structure& structure, const double* coefficient, const Chain& chain, const double* q,
        double longest_step)
      : structure_(structure), chain_(chain), longest_step_(longest_step) {
    std::copy(coefficient, coefficient + structure.n_coefficients, coefficient_);
    std::copy(q, q + chain.n_constants, q_);
    const double still[kMaxCommands] = {0.0};
    reset(0.0, still);
  }

  /// At rest at the origin at time t [s], the thrusters settled at `command`.
  void reset(double t, const double* command) {
    time_ = t;
    pending_ = 0;
    first_ = 0;
    silent_ = 0;
    std::fill(expires_, expires_ + kMaxActuators, kForever);
    std::fill(x_, x_ + kStates, 0.0);
    for (int k = 0; k < chain_.n_actuators(); ++k) {
      f_.multiplier[k] = multiplier(chain_, q_, k, chain_.scale_reference, nullptr);
      aim(command, k);
      f_.level[k] = f_.target[k];
    }
  }

  /// [s] for which a command holds; after that the thrusters are off until the next. Infinite, the
  /// default: it holds until the next.
  void set_timeout(double seconds) { timeout_ = seconds; }

  /// A command given at t >= time() [s], in whatever order: stamps decide. False where it comes too
  /// late, t is no time, or too many are under way.
  bool command(double t, const double* values) {
    if (!(t >= time_) || !std::isfinite(t) || pending_ >= kMaxPending) return false;
    int i = pending_++;
    for (; i > 0 && pending(i - 1).time > t; --i) pending(i) = pending(i - 1);
    Pending& p = pending(i);
    p.time = t;
    p.arrived = 0;
    std::copy(values, values + chain_.allocation.n_commands, p.values);
    return true;
  }

  /// No command is under way or in force: the thrusters are off until the next.
  void drop_commands() {
    pending_ = 0;
    for (int k = 0; k < chain_.n_actuators(); ++k) expire(k);
  }

  /// Whether some thruster is off because its command has expired.
  bool silent() const { return silent_ != 0U; }

  /// The clock was set: all times, of commands under way too, are later by `by` [s].
  void shift_clock(double by) {
    time_ += by;
    for (int i = 0; i < pending_; ++i) pending(i).time += by;
    for (double& expires : expires_) expires += by;
  }

  /// On to time t [s]; breaks where a delayed command arrives or expires. False where the boat
  /// diverged, or t is no time.
  bool advance_to(double t) {
    if (!std::isfinite(t)) return false;
    while (time_ < t) {
      const double next = std::max(time_, std::min(t, next_change()));
      if (!advance(structure_, coefficient_, chain_, q_, next - time_, longest_step_, f_, x_)) {
        return false;
      }
      // nothing depends on the place, so that this is exact
      for (int i = 0; i < 2; ++i) x_[i] += current_[i] * (next - time_);
      time_ = next;
      expire();
      arrive();
    }
    return true;
  }

  /// Of the water, earth-fixed [m/s]; the state's velocity is then that in the water.
  void set_current(double x, double y) {
    current_[0] = x;
    current_[1] = y;
  }

  double time() const { return time_; }
  const double* current() const { return current_; }
  const double* state() const { return x_; }
  double* state() { return x_; }

  /// Generalised forces F = T f now.
  void forces(double* force) const { forces_after(chain_, q_, f_, 0.0, force); }

  /// Time derivative of the state now (in the water); false where it can't be solved.
  bool rate(double* x_dot) const {
    double force[kMaxForces];
    forces(force);
    return state_rate(structure_, coefficient_, x_, force, x_dot);
  }

 private:
  static constexpr double kForever = std::numeric_limits<double>::infinity();

  struct Pending {
    double time = 0.0;
    unsigned arrived = 0;  // one bit for each actuator
    double values[kMaxCommands] = {};
  };

  /// The i-th of those under way.
  Pending& pending(int i) { return queue_[(first_ + i) % kMaxPending]; }
  const Pending& pending(int i) const { return queue_[(first_ + i) % kMaxPending]; }

  double latency(int k) const {
    return std::max(0.0, detail::constant(q_, chain_.actuators[k].latency, 0.0));
  }

  /// When a command next arrives at a thruster, or expires there [s].
  double next_change() const {
    double next = *std::min_element(expires_, expires_ + kMaxActuators);
    for (int i = 0; i < pending_; ++i) {
      const Pending& p = pending(i);
      for (int k = 0; k < chain_.n_actuators(); ++k) {
        if ((p.arrived >> k & 1U) == 0U) next = std::min(next, p.time + latency(k));
      }
      if (p.time > next) break;
    }
    return next;
  }

  void expire() {
    for (int k = 0; k < chain_.n_actuators(); ++k) {
      if (expires_[k] <= time_) expire(k);
    }
  }

  void expire(int k) {
    const double still[kMaxCommands] = {0.0};
    aim(still, k);
    silent_ |= 1U << k;
    expires_[k] = kForever;
  }

  void arrive() {
    const unsigned all = (1U << chain_.n_actuators()) - 1U;
    for (int i = 0; i < pending_; ++i) {
      Pending& p = pending(i);
      if (p.time > time_) break;
      for (int k = 0; k < chain_.n_actuators(); ++k) {
        if ((p.arrived >> k & 1U) == 0U && p.time + latency(k) <= time_) {
          aim(p.values, k);
          p.arrived |= 1U << k;
          silent_ &= ~(1U << k);
          expires_[k] = p.time + latency(k) + timeout_;
        }
      }
    }
    while (pending_ > 0 && queue_[first_].arrived == all) {
      first_ = (first_ + 1) % kMaxPending;
      --pending_;
    }
  }

  void aim(const double* command, int k) {
    double thruster[kMaxActuators];
    allocate(chain_.allocation, command, thruster);
    f_.target[k] = curve(chain_, q_, k, thruster, nullptr);
    if (follows_at_once(chain_, q_, k)) f_.level[k] = f_.target[k];
  }

  Structure structure_;
  Chain chain_;
  double coefficient_[kMaxCoefficients] = {};
  double q_[kMaxConstants] = {};
  double longest_step_;
  double time_ = 0.0;
  double x_[kStates] = {};
  double current_[2] = {0.0, 0.0};
  Thrust f_;
  double timeout_ = kForever;      // [s]
  double expires_[kMaxActuators];  // [s] when each thruster's command does
  unsigned silent_ = 0;            // one bit for each thruster whose command has expired
  int first_ = 0;
  int pending_ = 0;
  Pending queue_[kMaxPending];
};

}  // namespace seatrial
