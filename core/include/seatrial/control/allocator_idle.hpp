// SPDX-License-Identifier: MIT
// How thrusters idle outside their dead zones: which way each runs, and the null-space bias of
// least power. Done once, when an allocator is made.
#pragma once
#include <algorithm>
#include <cmath>

#include "seatrial/control/allocator_curve.hpp"
#include "seatrial/control/allocator_effort.hpp"

namespace seatrial {

/// What each thruster can do, all as thrust >= 0.
struct ThrustRange {
  double idle_forward[kMaxActuators] = {};  // just past the dead zone
  double idle_reverse[kMaxActuators] = {};
  double most_forward[kMaxActuators] = {};  // at the limit
  double most_reverse[kMaxActuators] = {};
  double full_forward[kMaxActuators] = {};  // at command 1, where the power is 1
  double full_reverse[kMaxActuators] = {};

  /// Share of a thruster's full power: thrust to the power 3/2 (momentum theory, open water).
  double power(int k, double thrust) const {
    const double full = thrust >= 0.0 ? full_forward[k] : full_reverse[k];
    return full > 0.0 ? std::pow(std::abs(thrust) / full, 1.5) : 0.0;
  }
};

/// The sides that thrusters keep to, and how they run when no wrench is asked.
struct Idle {
  bool found = false;
  Side side[kMaxActuators] = {};        // kOff: both sides, through its dead zone
  Bounds bounds;                        // of thrust, with these sides
  double thrust[kMaxActuators] = {};    // T thrust = 0
  double softness[kMaxActuators] = {};  // makes the least effort at rest that of least power
  double power = 0.0;                   // sum over thrusters; 1: one at full command
  double authority = 0.0;               // the largest wrench that is given in every direction
  int n_switching = 0;

  int n_forward() const {
    int n = 0;
    for (const Side s : side) n += s == Side::kForward ? 1 : 0;
    return n;
  }

  bool better_than(const Idle& other) const {
    if (!other.found) return true;
    const double gained = authority - other.authority;
    if (std::abs(gained) > kSameAuthority * other.authority) return gained > 0.0;
    return n_forward() > other.n_forward();
  }

 private:
  static constexpr double kSameAuthority = 0.01;
};

namespace detail {

inline constexpr double kLeastAuthority = 0.05;  // [command units] less is none
inline constexpr double kLeastShare = 1e-4;      // of full thrust: power's slope is taken from here
inline constexpr double kHardlyMore = 1.05;  // times the least power: accepted for more authority
inline constexpr int kReweightings = 60;

inline void take_side(const ThrustRange& r, int k, Side side, Idle& idle) {
  idle.side[k] = side;
  idle.n_switching += side == Side::kOff ? 1 : 0;
  idle.bounds.low[k] = side == Side::kForward ? r.idle_forward[k] : -r.most_reverse[k];
  idle.bounds.high[k] = side == Side::kReverse ? -r.idle_reverse[k] : r.most_forward[k];
}

/// Thrust at rest of least power sum |y / full|^(3/2), by least squares whose weights are those of
/// the power's slope (iteratively reweighted; the exponent is below 2, so that it converges).
inline void rest(const Effectiveness& t, const ThrustRange& r, Idle& idle) {
  const double still[kWrenchAxes] = {};
  std::fill(idle.softness, idle.softness + t.n, 1.0);
  for (int round = 0; round < kReweightings; ++round) {
    LeastEffort(t, idle.softness).solve(idle.bounds, still, idle.thrust);
    double mean = 0.0;
    double next[kMaxActuators];
    for (int k = 0; k < t.n; ++k) {
      const bool ahead = idle.thrust[k] >= 0.0;
      const double full = ahead ? r.full_forward[k] : r.full_reverse[k];
      const double share = std::max(std::abs(idle.thrust[k]) / full, kLeastShare);
      next[k] = full * full * std::sqrt(share);
      mean += next[k] / t.n;
    }
    double change = 0.0;
    for (int k = 0; k < t.n; ++k) {
      change = std::max(change, std::abs(next[k] / mean - idle.softness[k]));
      idle.softness[k] = next[k] / mean;
    }
    if (change < 1e-12) break;
  }
  idle.power = 0.0;
  for (int k = 0; k < t.n; ++k) idle.power += r.power(k, idle.thrust[k]);
}

/// Side of thruster k: digit k of `code`, written to base 2 (forward, astern) or 3 (also off).
inline Side side_of(int code, int k, int base) {
  for (int i = 0; i < k; ++i) code /= base;
  const int digit = code % base;
  return digit == 0 ? Side::kForward : digit == 1 ? Side::kReverse : Side::kOff;
}

}  // namespace detail

/// One of the ways to run with exactly `n_switching` thrusters that keep to no side; not `found`
/// where it is another number, or leaves no authority.
inline Idle idle_of(const Effectiveness& t, const ThrustRange& r, int code, int base,
                    int n_switching) {
  Idle idle;
  for (int k = 0; k < t.n; ++k) detail::take_side(r, k, detail::side_of(code, k, base), idle);
  if (idle.n_switching != n_switching) return idle;
  const double still[kWrenchAxes] = {};
  idle.authority = Reach(t, idle.bounds).depth(still);
  if (idle.authority < detail::kLeastAuthority) return idle;
  idle.found = true;
  detail::rest(t, r, idle);
  return idle;
}

/// The best of these: the least power at rest; of those that take hardly more, the one with the
/// most authority, and then with the most thrusters forward.
inline Idle idle_with(const Effectiveness& t, const ThrustRange& r, int n_switching) {
  const int base = n_switching == 0 ? 2 : 3;
  int codes = 1;
  for (int k = 0; k < t.n; ++k) codes *= base;
  double least = std::numeric_limits<double>::infinity();
  for (int code = 0; code < codes; ++code) {
    const Idle idle = idle_of(t, r, code, base, n_switching);
    if (idle.found) least = std::min(least, idle.power);
  }
  Idle best;
  for (int code = 0; code < codes && std::isfinite(least); ++code) {
    const Idle idle = idle_of(t, r, code, base, n_switching);
    if (!idle.found || idle.power > detail::kHardlyMore * least) continue;
    if (idle.better_than(best)) best = idle;
  }
  return best;
}

/// With as few switching thrusters as the geometry and the limits allow, `most` at most.
inline Idle find_idle(const Effectiveness& t, const ThrustRange& r, int most) {
  Idle idle;
  for (int n = 0; n <= most && !idle.found; ++n) idle = idle_with(t, r, n);
  return idle;
}

}  // namespace seatrial
