// SPDX-License-Identifier: MIT
// Thrust allocation on board, for any geometry: requested wrench to thruster commands, through the
// identified curves, outside their dead zones, within their limits. No heap, no exceptions.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>

#include "seatrial/control/allocator_setup.hpp"

namespace seatrial {

class Allocator {
 public:
  explicit Allocator(const AllocatorSetup& setup) : setup_(setup) {
    fault_ = prepare();
    reset();
  }

  AllocatorFault fault() const { return fault_; }
  const AllocatorSetup& setup() const { return setup_; }
  const Idle& idle() const { return idle_; }

  /// Dead-zone edge of thruster k on a side, in command units.
  double edge(int k, Side side) const { return curve_[k].edge(side); }

  /// Thrusters that switch wait on their forward side again.
  void reset() {
    for (int k = 0; k < kMaxActuators; ++k) {
      side_[k] = idle_.side[k] == Side::kOff ? Side::kForward : idle_.side[k];
    }
    keep_sides();
  }

  /// Commands (n) for a wrench (3) in command units. Only with fault() == kOk.
  Allotment allocate(const double* wrench, double* command) {
    Allotment out;
    const int n = setup_.effectiveness.n;
    for (int j = 0; j < kWrenchAxes; ++j) {
      if (std::isfinite(wrench[j])) continue;
      std::fill(command, command + n, 0.0);
      std::fill(out.share, out.share + kWrenchAxes, 0.0);
      out.number = false;
      return out;
    }
    double asked[kWrenchAxes];
    for (int j = 0; j < kWrenchAxes; ++j) {
      asked[j] = idle_axis_[j] ? 0.0 : wrench[j];
      if (asked[j] == wrench[j]) continue;
      out.share[j] = 0.0;
      out.limited = true;
    }
    double y[kMaxActuators];
    if (setup_.scheme == AllocatorScheme::kAlwaysForward) {
      always_forward(asked, out, y);
    } else {
      double within[kWrenchAxes];
      limit(asked, out, within);
      least_effort(within, out, y);
    }
    for (int k = 0; k < n; ++k) y[k] = std::abs(y[k]) < kRounding ? 0.0 : y[k];
    const bool waits = setup_.scheme != AllocatorScheme::kMoorePenrose;
    for (int k = 0; k < n; ++k) {
      const double c = curve_[k].command(setup_.chain, y[k], waits ? side_[k] : Side::kOff);
      command[k] = std::min(std::max(c, -setup_.limit[k]), setup_.limit[k]);
    }
    return out;
  }

  /// The command that gives a thrust of thruster k; for no thrust the edge of the side on which it
  /// waits.
  double command(int k, double thrust) const {
    return curve_[k].command(setup_.chain, thrust, side_[k]);
  }

  /// Thrust of thruster k at a command, once lags have settled.
  double thrust(int k, double command) const {
    return curve_[k].thrust(setup_.chain, setup_.q, command);
  }

  /// The wrench (3) that commands (n) give once lags have settled.
  void wrench(const double* command, double* out) const {
    double y[kMaxActuators];
    for (int k = 0; k < setup_.effectiveness.n; ++k) {
      y[k] = curve_[k].thrust(setup_.chain, setup_.q, command[k]);
    }
    setup_.effectiveness.wrench(y, out);
  }

  /// Power of commands (n); 1: one thruster at full command.
  double power(const double* command) const {
    double sum = 0.0;
    for (int k = 0; k < setup_.effectiveness.n; ++k) {
      sum += range_.power(k, curve_[k].thrust(setup_.chain, setup_.q, command[k]));
    }
    return sum;
  }

  /// The largest multiple of a wrench (3), up to `most`, that is given with all axes alike.
  double reach(const double* wrench, double most) const {
    for (int j = 0; j < kWrenchAxes; ++j) {
      if (idle_axis_[j] && wrench[j] != 0.0) return 0.0;
    }
    if (setup_.scheme == AllocatorScheme::kAlwaysForward) {
      double y[kMaxActuators];
      start_forward(y);
      return forward_share(wrench, most, y);
    }
    const double still[kWrenchAxes] = {};
    return reach_.along(still, wrench, most);
  }

 private:
  AllocatorFault prepare() {
    const Effectiveness& t = setup_.effectiveness;
    const int axes = t.driven();
    if (t.n < axes || t.n > kMaxActuators) return AllocatorFault::kSize;
    if (axes < kWrenchAxes - 1) return AllocatorFault::kRank;
    for (int j = 0; j < kWrenchAxes; ++j) idle_axis_[j] = t.idle(j);
    if (!pseudo_inverse(t, inverse_)) return AllocatorFault::kRank;
    for (int k = 0; k < t.n; ++k) {
      if (setup_.inverted && setup_.chain.actuators[k].partner >= 0) return AllocatorFault::kCurve;
      curve_[k] = ThrusterCurve(setup_.chain, setup_.q, k, setup_.inverted);
      if (!curve_[k].invertible(setup_.chain)) return AllocatorFault::kCurve;
      if (!range_of(k)) return AllocatorFault::kDeadZone;
    }
    return choose_sides();
  }

  bool range_of(int k) {
    const ThrusterCurve& curve = curve_[k];
    const Chain& chain = setup_.chain;
    range_.most_forward[k] = curve.thrust(chain, setup_.q, setup_.limit[k]);
    range_.most_reverse[k] = -curve.thrust(chain, setup_.q, -setup_.limit[k]);
    range_.full_forward[k] = curve.thrust(chain, setup_.q, 1.0);
    range_.full_reverse[k] = -curve.thrust(chain, setup_.q, -1.0);
    range_.idle_forward[k] = curve.thrust(chain, setup_.q, setup_.idle_forward[k]);
    range_.idle_reverse[k] = -curve.thrust(chain, setup_.q, -setup_.idle_reverse[k]);
    return setup_.limit[k] > setup_.idle_forward[k] && setup_.limit[k] > setup_.idle_reverse[k] &&
           setup_.idle_forward[k] >= curve.edge(Side::kForward) &&
           setup_.idle_reverse[k] >= curve.edge(Side::kReverse) && range_.most_forward[k] > 0.0 &&
           range_.most_reverse[k] > 0.0;
  }

  AllocatorFault choose_sides() {
    const Effectiveness& t = setup_.effectiveness;
    const AllocatorScheme scheme = setup_.scheme;
    if (scheme == AllocatorScheme::kAlwaysForward) return all_forward();
    if (scheme == AllocatorScheme::kNullSpace || scheme == AllocatorScheme::kAutomatic) {
      idle_ = find_idle(t, range_, scheme == AllocatorScheme::kNullSpace ? 0 : t.n);
    } else {  // no sides, no idling; the least thrust
      for (int k = 0; k < t.n; ++k) detail::take_side(range_, k, Side::kOff, idle_);
      std::fill(idle_.softness, idle_.softness + t.n, 1.0);
      idle_.found = true;
    }
    if (!idle_.found) return AllocatorFault::kNullSpace;
    effort_ = LeastEffort(t, idle_.softness);
    reach_ = Reach(t, idle_.bounds);
    const double still[kWrenchAxes] = {};
    idle_.authority = reach_.depth(still);
    return AllocatorFault::kOk;
  }

  /// Table I wants forward idling, and twice the forward half of each column of T+, to give nothing
  /// but what is asked.
  AllocatorFault all_forward() {
    const Effectiveness& t = setup_.effectiveness;
    double given[kWrenchAxes];
    idle_.power = 0.0;
    for (int k = 0; k < t.n; ++k) {
      detail::take_side(range_, k, Side::kForward, idle_);
      idle_.thrust[k] = range_.idle_forward[k];
      idle_.power += range_.power(k, idle_.thrust[k]);
    }
    t.wrench(idle_.thrust, given);
    for (const double g : given) {
      if (std::abs(g) > kSame) return AllocatorFault::kAlwaysForward;
    }
    for (int j = 0; j < 2 * kWrenchAxes; ++j) {
      if (idle_axis_[j / 2]) continue;
      double axis[kWrenchAxes] = {};
      axis[j / 2] = j % 2 == 0 ? 1.0 : -1.0;
      double y[kMaxActuators] = {};
      add_forward(axis, 1.0, y);
      t.wrench(y, given);
      for (int i = 0; i < kWrenchAxes; ++i) {
        if (std::abs(given[i] - axis[i]) > kSame) return AllocatorFault::kAlwaysForward;
      }
    }
    idle_.found = true;
    return AllocatorFault::kOk;
  }

  void start_forward(double* y) const {
    std::copy(idle_.thrust, idle_.thrust + setup_.effectiveness.n, y);
  }

  /// y_k += alpha sum_j max(0, 2 T+_kj F_j), Eq. (11).
  void add_forward(const double* wrench, double alpha, double* y) const {
    for (int k = 0; k < setup_.effectiveness.n; ++k) {
      for (int j = 0; j < kWrenchAxes; ++j) {
        y[k] += alpha * std::max(0.0, 2.0 * inverse_[k][j] * wrench[j]);
      }
    }
  }

  /// How much of a wrench, up to `most`, has room on top of y.
  double forward_share(const double* wrench, double most, const double* y) const {
    double add[kMaxActuators] = {};
    add_forward(wrench, 1.0, add);
    double alpha = most;
    for (int k = 0; k < setup_.effectiveness.n; ++k) {
      const double room = std::max(0.0, range_.most_forward[k] - y[k]);
      if (alpha * add[k] > room) alpha = room / add[k];
    }
    return alpha;
  }

  void always_forward(const double* wrench, Allotment& out, double* y) const {
    start_forward(y);
    for (int rank = 0; rank < kWrenchAxes; ++rank) {
      double part[kWrenchAxes];
      if (!part_of(wrench, rank, part)) continue;
      const double alpha = forward_share(part, 1.0, y);
      add_forward(part, alpha, y);
      note_share(rank, alpha, out);
    }
  }

  /// The wrench itself if it is within reach. Else the largest share of each rank in turn, with any
  /// share of later ranks; axes of one rank are scaled by one factor, so that their direction
  /// stays.
  void limit(const double* wrench, Allotment& out, double* within) const {
    std::copy(wrench, wrench + kWrenchAxes, within);
    if (reach_.depth(wrench) >= 0.0) return;
    std::fill(within, within + kWrenchAxes, 0.0);
    for (int rank = 0; rank < kWrenchAxes; ++rank) {
      double part[kWrenchAxes];
      if (!part_of(wrench, rank, part)) continue;
      double later[kWrenchAxes];
      for (int j = 0; j < kWrenchAxes; ++j) later[j] = setup_.rank[j] > rank ? wrench[j] : 0.0;
      double alpha = 0.0;
      double rest = 0.0;
      reach_.most(within, part, later, &alpha, &rest);
      alpha = std::min(std::max(alpha, 0.0), 1.0);
      for (int j = 0; j < kWrenchAxes; ++j) within[j] += alpha * part[j];
      note_share(rank, alpha, out);
    }
  }

  bool part_of(const double* wrench, int rank, double* part) const {
    bool any = false;
    for (int j = 0; j < kWrenchAxes; ++j) {
      part[j] = setup_.rank[j] == rank ? wrench[j] : 0.0;
      any = any || part[j] != 0.0;
    }
    return any;
  }

  void note_share(int rank, double alpha, Allotment& out) const {
    for (int j = 0; j < kWrenchAxes; ++j) {
      if (setup_.rank[j] == rank && !idle_axis_[j]) out.share[j] = alpha;
    }
    out.limited = out.limited || alpha < 1.0;
  }

  /// On the present sides if the error is within the hysteresis; else on those of the least effort.
  void least_effort(const double* wrench, Allotment& out, double* y) {
    const bool switches = setup_.scheme != AllocatorScheme::kMoorePenrose && idle_.n_switching > 0;
    if (switches && kept_reach_.depth(wrench) >= -setup_.hysteresis) {
      const double error = solve(kept_reach_, kept_, wrench, y);
      out.held = error > kSame && error <= setup_.hysteresis;
      if (out.held || error <= kSame) return;
    }
    solve(reach_, idle_.bounds, wrench, y);
    if (switches) take_sides(y);
  }

  double solve(const Reach& reach, Bounds bounds, const double* wrench, double* y) const {
    reach.pin(setup_.effectiveness, wrench, bounds);
    return effort_.solve(bounds, wrench, y).error;
  }

  void take_sides(const double* y) {
    bool changed = false;
    for (int k = 0; k < setup_.effectiveness.n; ++k) {
      const Side side = y[k] > kRounding    ? Side::kForward
                        : y[k] < -kRounding ? Side::kReverse
                                            : side_[k];
      changed = changed || side != side_[k];
      side_[k] = side;
    }
    if (changed) keep_sides();
  }

  /// Bounds within which no thruster changes its side.
  void keep_sides() {
    kept_ = idle_.bounds;
    for (int k = 0; k < setup_.effectiveness.n; ++k) {
      if (side_[k] == Side::kForward) kept_.low[k] = std::max(kept_.low[k], 0.0);
      if (side_[k] == Side::kReverse) kept_.high[k] = std::min(kept_.high[k], 0.0);
    }
    kept_reach_ = Reach(setup_.effectiveness, kept_);
  }

  static constexpr double kRounding = 1e-12;
  static constexpr double kSame = 1e-9;  // [command units]

  AllocatorSetup setup_;
  AllocatorFault fault_ = AllocatorFault::kOk;
  double inverse_[kMaxActuators][kWrenchAxes] = {};  // T+
  bool idle_axis_[kWrenchAxes] = {};                 // without thrust
  ThrusterCurve curve_[kMaxActuators];
  ThrustRange range_;
  Idle idle_;
  LeastEffort effort_;
  Reach reach_;
  Side side_[kMaxActuators] = {};  // present ones
  Bounds kept_;                    // with these
  Reach kept_reach_;
};

}  // namespace seatrial
