// SPDX-License-Identifier: MIT
// A controller's axis commands to commands of all inputs, within limits: by shares that are fixed,
// for a boat that allocates by itself, by an allocator, where the inputs are the thrusters, or by
// the inverse of a steered thruster. No heap, no exceptions.
#pragma once
#include <algorithm>
#include <cmath>
#include <optional>

#include "seatrial/actuators/allocation.hpp"
#include "seatrial/control/allocator.hpp"
#include "seatrial/control/steering.hpp"
#include "seatrial/model/frames.hpp"

namespace seatrial {

/// An axis command of 1 is some input's full.
class AxisCommands {
 public:
  using Mix = double[kMaxCommands][kAxes];  // inputs by axis commands

  /// `limit`: of each input. `yaw_first`: at the limits yaw is served first, not all axes alike.
  AxisCommands(const Allocation& allocation, const Mix& mix, double limit, bool yaw_first = false)
      : allocation_(allocation), limit_(std::min(limit, allocation.limit)), yaw_first_(yaw_first) {
    std::copy(&mix[0][0], &mix[0][0] + sizeof(Mix) / sizeof(double), &mix_[0][0]);
  }

  /// The allocator's limits count. Its fault() must be kOk.
  AxisCommands(const Allocator& allocator, const Mix& mix) : AxisCommands(Allocation{}, mix, 0.0) {
    allocator_ = allocator;
    const Effectiveness& t = allocator.setup().effectiveness;
    for (int axis = 0; axis < kAxes; ++axis) {
      double thrust[kMaxActuators];  // as the gains take it: along the curve's chord
      double wrench[kWrenchAxes];
      for (int k = 0; k < t.n; ++k) thrust[k] = allocator.thrust(k, 1.0) * mix[k][axis];
      t.wrench(thrust, wrench);
      for (int i = 0; i < kWrenchAxes; ++i) wrench_[i][axis] = wrench[i];
    }
  }

  /// For a thruster with an angle, whose fault() must be kOk. `authority`: accelerations by axis
  /// commands of 1.
  AxisCommands(const Steering& steering, const double* authority)
      : AxisCommands(Allocation{}, Mix{}, 0.0) {
    steering_ = steering;
    std::copy(authority, authority + kAxes, authority_);
    allocation_.n_commands = 2;
  }

  int size() const {
    return allocator_ ? allocator_->setup().effectiveness.n : allocation_.n_commands;
  }

  /// Commands to all inputs at the motion nu, dt [s] after the last; false where they
  /// give less than the axes command.
  bool command(const double* axis, const double* nu, double dt, double* values) {
    if (steering_) {
      return steering_->command(axis[0] * authority_[0], axis[2] * authority_[2], nu, dt, values);
    }
    if (allocator_) {
      double wrench[kWrenchAxes] = {};
      for (int i = 0; i < kWrenchAxes; ++i) wrench[i] = detail::dot3(wrench_[i], axis);
      const Allotment given = allocator_->allocate(wrench, values);
      return given.number && !given.limited;
    }
    const double share = yaw_first_ ? beside_yaw(axis) : 1.0;
    const double given[kAxes] = {share * axis[0], share * axis[1], axis[2]};
    for (int k = 0; k < size(); ++k) values[k] = detail::dot3(mix_[k], given);
    return limit(values) && share >= 1.0;
  }

  /// Zero commands were sent for a while.
  void forget() {
    if (steering_) steering_->forget();
  }

 private:
  /// The share of surge and sway within the limits once yaw is served in full.
  double beside_yaw(const double* axis) const {
    double share = 1.0;
    for (int k = 0; k < size(); ++k) {
      const double turn = mix_[k][2] * axis[2];
      const double rest = mix_[k][0] * axis[0] + mix_[k][1] * axis[1];
      const double room = std::max(0.0, rest > 0.0 ? limit_ - turn : limit_ + turn);
      if (std::abs(rest) > room) share = std::min(share, room / std::abs(rest));
    }
    return share;
  }

  /// Scales commands to what inputs and thrusters can; false where that was needed.
  bool limit(double* values) const {
    const int n = size();
    double largest = 0.0;
    for (int k = 0; k < n; ++k) largest = std::max(largest, std::abs(values[k]));
    double share = largest > limit_ ? limit_ / largest : 1.0;
    for (int k = 0; k < n; ++k) values[k] *= share;
    double thruster[kMaxActuators];
    const double given = allocate(allocation_, values, thruster);
    for (int k = 0; k < n; ++k) values[k] *= given;
    share *= given;
    return share >= 1.0;
  }

  Allocation allocation_;
  double limit_ = 1.0;
  bool yaw_first_ = false;
  Mix mix_ = {};
  std::optional<Allocator> allocator_;
  std::optional<Steering> steering_;
  double authority_[kAxes] = {};
  double wrench_[kWrenchAxes][kAxes] = {};  // by axis commands, in command units
};

}  // namespace seatrial
