// SPDX-License-Identifier: MIT
// Settings of a thrust allocator, its faults and its result.
#pragma once
#include <cstdint>

#include "seatrial/control/allocator_idle.hpp"

namespace seatrial {

enum class AllocatorScheme : std::uint8_t {
  kMoorePenrose,   // least thrust; dead zones are jumped over
  kAlwaysForward,  // Table I and Eq. (11): every thruster forward, axis by axis
  kNullSpace,      // every thruster keeps to one side, by a bias in the null space of T
  kSignPattern,    // sides change, with hysteresis; nothing idles
  kAutomatic       // null space, and hysteresis for the fewest thrusters that need it
};

enum class AllocatorFault : std::uint8_t {
  kOk,
  kSize,           // fewer thrusters than axes with thrust, or more than 8
  kRank,           // the axes with thrust, two at least, can't be had independently
  kCurve,          // a curve that does not rise outside its dead zone, or a propeller's pair
  kDeadZone,       // no room between dead zone, or idle command, and limit
  kAlwaysForward,  // forward thrusts do not cancel: Table I is for MallARD's kind of geometry
  kNullSpace       // some thruster can't be kept out of its dead zone
};

/// All that an allocator is made of. Commands in command units.
struct AllocatorSetup {
  AllocatorScheme scheme = AllocatorScheme::kAutomatic;
  Chain chain;  // for its curves
  double q[kMaxConstants] = {};
  Effectiveness effectiveness;                 // T, axes in the order surge, sway, yaw
  bool inverted = true;                        // false: commands are taken for thrust
  double limit[kMaxActuators] = {};            // |command| never above it
  double idle_forward[kMaxActuators] = {};     // command to idle at, >= the dead zone's edge
  double idle_reverse[kMaxActuators] = {};     // the same for running astern, > 0
  double hysteresis = 0.0;                     // [command units] of wrench, before sides change
  std::uint8_t rank[kWrenchAxes] = {0, 0, 0};  // of surge, sway, yaw at the limits: 0 is served
                                               // first; axes of a rank keep their direction
};

/// Result: share * (requested wrench) is given, unless a thruster was held.
struct Allotment {
  bool number = true;    // false: the wrench is not a number, all commands are 0
  bool limited = false;  // some share is below 1
  bool held = false;     // within the hysteresis of it, so that no side had to change
  double share[kWrenchAxes] = {1.0, 1.0, 1.0};  // of each axis that the limits leave
};

}  // namespace seatrial
