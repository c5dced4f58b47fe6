// SPDX-License-Identifier: MIT
// Health of the on-board predictor: flags with advice, results of inputs, and the range in which
// the model was identified. No heap, no exceptions.
#pragma once
#include <algorithm>
#include <cstdint>
#include <limits>

#include "seatrial/model/structure.hpp"

namespace seatrial {

/// Flags of an estimate.
enum Health : std::uint32_t {
  kNoPose = 1U << 0,           // no pose used yet, or none since a divergence: state unknown
  kDeadReckoning = 1U << 1,    // no recent pose
  kGateRejecting = 1U << 2,    // the last pose failed the gate
  kReinitialised = 1U << 3,    // reset recently to poses that contradicted the filter
  kCommandSilence = 1U << 4,   // no command is in force
  kOutsideSpeeds = 1U << 5,    // outside the speeds of identification
  kOutsideCommands = 1U << 6,  // outside the thrust of identification
  kBadInput = 1U << 7,         // an input was refused recently: not a number, stale, or no room
  kDiverged = 1U << 8,         // reset recently after a divergence or a jump of the stamps
  kBeyondReach = 1U << 9,      // the requested time is outside the buffer: `time` differs from it
  kModelDoubted = 1U << 10  // poses contradicted the model repeatedly: process noise is increased
};

/// Name of a flag and advice to the user.
struct HealthWords {
  Health flag;
  const char* name;
  const char* advice;
};

inline constexpr HealthWords kHealthWords[] = {
    {kNoPose, "no pose",
     "no pose received yet: pose and velocity are unknown. Check that poses arrive"},
    {kDeadReckoning, "dead reckoning",
     "no recent pose: dead reckoning by the model. The covariance grows accordingly"},
    {kGateRejecting, "gate rejecting",
     "the last pose failed the innovation gate and was not used. Check it for false matches"},
    {kReinitialised, "reinitialised",
     "consecutive poses agreed with each other, not with the filter. The filter was reset to them"},
    {kCommandSilence, "command silence",
     "no valid command: thrust is assumed zero. Check that commands arrive"},
    {kOutsideSpeeds, "outside speeds",
     "speed is outside the range of identification. Record data there and identify again"},
    {kOutsideCommands, "outside commands",
     "thrust is outside the range of identification. Record data there and identify again"},
    {kBadInput, "bad input",
     "an input was refused: not a number, too late, or its stamp is implausible. Check the clocks"},
    {kDiverged, "diverged",
     "the estimate diverged, or stamps jumped. The filter restarts at the next pose"},
    {kBeyondReach, "beyond reach",
     "the requested time is outside the buffer. The estimate is for the time in its stamp"},
    {kModelDoubted, "model doubted",
     "poses contradicted the model repeatedly, so process noise is increased. Check for current, "
     "wind, payload and SLAM jumps. If the boat changed, identify again"}};

/// Result of an input.
enum class Taken : std::uint8_t {
  kUsed,       // or will be, at its stamp; a pose, if it passes the gate
  kNotNumber,  // NaN, infinite or absurdly large, or no covariance
  kStale,      // older than the buffer
  kAhead,      // its stamp is far ahead: used once a second one agrees
  kTwice,      // a duplicate of a pose
  kNoRoom      // the window holds as many inputs as fit
};

/// Their names, in the same order.
inline constexpr const char* kTakenWords[] = {"used",  "not a number", "stale",
                                              "ahead", "twice",        "no room"};

/// Ranges of the data that the model was identified from.
struct Envelope {
  double speed[kAxes][2];                 // [m/s, m/s, rad/s] least, most
  double force[kMaxForces][2];            // generalised forces, after the actuator chain
  static constexpr double kSlack = 0.05;  // of a range, beyond it

  Envelope() {
    for (auto& range : speed) forget(range);
    for (auto& range : force) forget(range);
  }

  static bool outside(const double* value, const double (*range)[2], int n) {
    for (int i = 0; i < n; ++i) {
      const double slack = kSlack * (range[i][1] - range[i][0]);
      if (value[i] < range[i][0] - slack || value[i] > range[i][1] + slack) return true;
    }
    return false;
  }

 private:
  static void forget(double* range) {
    range[0] = -std::numeric_limits<double>::max() / 4.0;
    range[1] = std::numeric_limits<double>::max() / 4.0;
  }
};

}  // namespace seatrial
