// SPDX-License-Identifier: MIT
// Allocation for one thruster whose thrust an angle turns (outboard, azimuth thruster), or with a
// rudder: accelerations in surge and yaw to the commands of thrust and angle. Both curves are
// inverted, and the rudder's gain follows the speed. No heap, no exceptions.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>

#include "seatrial/actuators/chain.hpp"
#include "seatrial/control/allocator_curve.hpp"
#include "seatrial/model/dynamics.hpp"
#include "seatrial/model/frames.hpp"

namespace seatrial {

/// What forbids the allocation.
enum class SteeringFault : std::uint8_t {
  kOk,
  kOther,   // not one thruster and one angle, each with an input of its own
  kCurve,   // a curve without an inverse
  kNoSurge  // the thrust gives no surge ahead
};

/// Accelerations at one motion, by thrust f and angle a: surge = along f cos a,
/// yaw = turn f cos a + (across f + flow) sin a, sway likewise without `turn`.
struct SteeredEffect {
  double along = 0.0;
  double turn = 0.0;
  double across = 0.0;
  double flow = 0.0;
  double sway_across = 0.0;
  double sway_flow = 0.0;

  double yaw_per_sine(double thrust) const { return across * thrust + flow; }
};

class Steering {
 public:
  /// `limit`: of both commands.
  Steering(const Structure& structure, const double* coefficient, const Chain& chain,
           const double* q, double limit = 1.0)
      : structure_(structure), chain_(chain) {
    std::copy(coefficient, coefficient + structure.n_coefficients, coefficient_);
    fault_ = find(q);
    if (fault_ != SteeringFault::kOk) return;
    thrust_curve_ = ThrusterCurve(chain_, q, thrust_, true);
    angle_curve_ = ThrusterCurve(chain_, q, angle_, true);
    const bool curves = thrust_curve_.invertible(chain_) && angle_curve_.invertible(chain_);
    fault_ = curves ? SteeringFault::kOk : SteeringFault::kCurve;
    limits(q, limit);
    if (fault_ == SteeringFault::kOk) fault_ = effects_fault();
    forget();
  }

  SteeringFault fault() const { return fault_; }
  int thrust() const { return thrust_; }  // its actuator, which is its input
  int angle() const { return angle_; }
  double trim() const { return trim_; }             // [rad] angle at no command
  double full_angle() const { return full_; }       // [rad] from there at full command
  double angle_rate() const { return rate_; }       // [rad/s]; 0: no limit
  double full_thrust() const { return ahead_; }     // at the limit ahead
  double astern_thrust() const { return astern_; }  // at the limit astern, below 0
  double least_sine() const { return least_; }
  double most_sine() const { return most_; }

  SteeredEffect effect(const double* nu) const {
    double thrust[kMaxForces] = {};
    double angle[kMaxForces] = {};
    double sine[kMaxForces] = {};
    for (int j = 0; j < chain_.n_forces; ++j) {
      thrust[j] = chain_.mix[j][thrust_];
      angle[j] = chain_.mix[j][angle_];
      sine[j] = chain_.deflection[j][angle_];
    }
    double by_thrust[kAxes];
    double by_angle[kAxes];
    double by_sine[kAxes];
    forced(nu, thrust, by_thrust);
    forced(nu, angle, by_angle);
    forced(nu, sine, by_sine);
    return {by_thrust[0], by_thrust[2], by_angle[2], by_sine[2], by_angle[1], by_sine[1]};
  }

  /// Surge and yaw acceleration by full commands at a speed ahead [m/s]; yaw: to its weaker side.
  void authority(double speed, double* surge, double* yaw) const {
    const double nu[kAxes] = {speed, 0.0, 0.0};
    const SteeredEffect e = effect(nu);
    *surge = e.along * ahead_;
    *yaw = std::abs(e.yaw_per_sine(ahead_)) * std::min(most_, -least_);
  }

  /// 1, or -1 where a positive command turns the bow to starboard.
  double side(double speed) const {
    const double nu[kAxes] = {speed, 0.0, 0.0};
    return effect(nu).yaw_per_sine(ahead_) < 0.0 ? -1.0 : 1.0;
  }

  /// Commands (thrust, angle) for a surge and a yaw acceleration at the motion nu, dt [s] after the
  /// last ones. Yaw is served first: thrust ahead rises to what the angle's end needs. False where
  /// they give less, also by the angle's rate.
  bool command(double surge, double yaw, const double* nu, double dt, double* values) {
    const SteeredEffect e = effect(nu);
    const double along = surge / e.along;
    const double turn = yaw - e.turn * along;
    const double f = thrust_for(e, along, turn);
    const double asked = sine(e, f, turn);
    const double s = std::clamp(asked, least_, most_);
    const double wanted = std::asin(s);
    const double most = rate_ > 0.0 ? rate_ * std::max(dt, 0.0) : kPi;
    const double step = std::clamp(wanted - at_, -most, most);
    at_ += step;
    commands(f, at_, values);
    const double given = f * std::sqrt(1.0 - s * s);
    return s == asked && wanted - at_ == 0.0 && std::abs(given - along) <= kSame * ahead_;
  }

  /// Commands whose steady thrust and angle [rad] these are; dead bands are jumped over.
  void commands(double thrust, double angle, double* values) const {
    values[thrust_] = thrust_curve_.command(chain_, thrust, Side::kOff);
    values[angle_] = angle_curve_.command(chain_, (angle - trim_) / full_, Side::kOff);
  }

  /// The angle is at its trim, as by zero commands.
  void forget() { at_ = trim_; }

 private:
  static constexpr int kHalvings = 40;
  static constexpr double kSame = 1e-9;  // of full thrust

  SteeringFault find(const double* q) {
    if (chain_.n_actuators() != 2 || chain_.allocation.n_commands != 2 ||
        chain_.allocation.scheme != Scheme::kDirect) {
      return SteeringFault::kOther;
    }
    angle_ = chain_.actuators[0].steers >= 0 ? 0 : 1;
    thrust_ = 1 - angle_;
    const Actuator& a = chain_.actuators[angle_];
    if (a.steers != thrust_) return SteeringFault::kOther;
    full_ = kDegree * detail::constant(q, a.full_angle, 0.0);
    trim_ = kDegree * detail::constant(q, a.angle_offset, 0.0);
    rate_ = kDegree * detail::constant(q, a.slew_rate, 0.0);
    return full_ > 0.0 ? SteeringFault::kOk : SteeringFault::kCurve;
  }

  void limits(const double* q, double limit) {
    ahead_ = thrust_curve_.thrust(chain_, q, limit);
    astern_ = thrust_curve_.thrust(chain_, q, -limit);
    const double to = full_ * angle_curve_.thrust(chain_, q, limit);
    const double from = full_ * angle_curve_.thrust(chain_, q, -limit);
    most_ = std::sin(std::min(trim_ + to, 0.5 * kPi));
    least_ = std::sin(std::max(trim_ + from, -0.5 * kPi));
  }

  SteeringFault effects_fault() const {
    const double rest[kAxes] = {};
    const SteeredEffect e = effect(rest);
    return e.along > 0.0 ? SteeringFault::kOk : SteeringFault::kNoSurge;
  }

  /// The acceleration by a force.
  void forced(const double* nu, const double* force, double* by) const {
    const double none[kMaxForces] = {};
    double free[kAxes];
    acceleration(structure_, coefficient_, nu, force, by);
    acceleration(structure_, coefficient_, nu, none, free);
    for (int i = 0; i < kAxes; ++i) by[i] -= free[i];
  }

  double sine(const SteeredEffect& e, double thrust, double turn) const {
    const double per = e.yaw_per_sine(thrust);
    if (per == 0.0) return turn == 0.0 ? std::sin(trim_) : std::copysign(2.0, turn);
    return turn / per;
  }

  bool within(double sine) const { return sine >= least_ && sine <= most_; }

  /// Astern where that gives the yaw, too; else ahead.
  double thrust_for(const SteeredEffect& e, double along, double turn) const {
    const double astern = std::max(along, astern_);
    if (along < 0.0 && within(sine(e, astern, turn))) return astern;
    return ahead(e, std::max(along, 0.0), turn);
  }

  /// The thrust ahead with f cos a = along, or above it as much as yaw needs: f cos a rises with f.
  double ahead(const SteeredEffect& e, double along, double turn) const {
    double low = 0.0;
    double high = ahead_;
    for (int i = 0; i < kHalvings; ++i) {
      const double f = 0.5 * (low + high);
      const double s = sine(e, f, turn);
      const bool enough = within(s) && f * std::sqrt(1.0 - s * s) >= along;
      (enough ? high : low) = f;
    }
    return high;
  }

  Structure structure_;
  Chain chain_;
  double coefficient_[kMaxCoefficients] = {};
  SteeringFault fault_ = SteeringFault::kOk;
  int thrust_ = 0;
  int angle_ = 1;
  ThrusterCurve thrust_curve_;
  ThrusterCurve angle_curve_;
  double full_ = 0.0;
  double trim_ = 0.0;
  double rate_ = 0.0;
  double ahead_ = 0.0;
  double astern_ = 0.0;
  double least_ = 0.0;
  double most_ = 0.0;
  double at_ = 0.0;  // [rad] angle commanded last
};

}  // namespace seatrial
