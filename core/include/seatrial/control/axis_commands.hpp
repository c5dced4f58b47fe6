// SPDX-License-Identifier: MIT
// A controller's axis commands to commands of all inputs, within limits: by shares that are fixed,
// for a boat that allocates by itself, or by an allocator, where the inputs are the thrusters. No
// heap, no exceptions.
#pragma once
#include <algorithm>
#include <cmath>
#include <optional>

#include "seatrial/actuators/allocation.hpp"
#include "seatrial/control/allocator.hpp"
#include "seatrial/model/frames.hpp"

namespace seatrial {

/// An axis command of 1 is some input's full.
class AxisCommands {
 public:
  using Mix = double[kMaxCommands][kAxes];  // inputs by axis commands

  /// `limit`: of each input.
  AxisCommands(const Allocation& allocation, const Mix& mix, double limit)
      : allocation_(allocation), limit_(std::min(limit, allocation.limit)) {
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

  int size() const {
    return allocator_ ? allocator_->setup().effectiveness.n : allocation_.n_commands;
  }

  /// Commands to all inputs; false where less is given than was asked.
  bool command(const double* axis, double* values) {
    if (allocator_) {
      double wrench[kWrenchAxes] = {};
      for (int i = 0; i < kWrenchAxes; ++i) wrench[i] = detail::dot3(wrench_[i], axis);
      const Allotment given = allocator_->allocate(wrench, values);
      return given.number && !given.limited;
    }
    for (int k = 0; k < size(); ++k) values[k] = detail::dot3(mix_[k], axis);
    return limit(values);
  }

 private:
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
  Mix mix_ = {};
  std::optional<Allocator> allocator_;
  double wrench_[kWrenchAxes][kAxes] = {};  // by axis commands, in command units
};

}  // namespace seatrial
