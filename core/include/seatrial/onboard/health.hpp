// SPDX-License-Identifier: MIT
// How the on-board predictor is doing, and where its model was identified. No heap, no exceptions.
#pragma once
#include <algorithm>
#include <cstdint>
#include <limits>

#include "seatrial/model/structure.hpp"

namespace seatrial {

/// Flags of an estimate.
enum Health : std::uint32_t {
  kNoPose = 1U << 0,           // no pose was used yet, or none since it diverged: nothing is known
  kDeadReckoning = 1U << 1,    // no pose was used lately
  kGateRejecting = 1U << 2,    // the last pose was taken for a false match
  kReinitialised = 1U << 3,    // lately the poses were right and the filter was not
  kCommandSilence = 1U << 4,   // no command is in force
  kOutsideSpeeds = 1U << 5,    // faster than the model was identified
  kOutsideCommands = 1U << 6,  // more thrust than the model was identified with
  kBadInput = 1U << 7,         // lately an input was refused: not a number, stale or no room for it
  kDiverged = 1U << 8,         // lately the model ran away, or stamps leapt: it began anew
  kBeyondReach = 1U << 9,      // the time asked for is too far away: the estimate is of another
  kModelDoubted = 1U << 10  // poses overruled the filter again and again: it is wary of the model
};

/// A flag in words.
struct HealthWords {
  Health flag;
  const char* name;
  const char* advice;
};

inline constexpr HealthWords kHealthWords[] = {
    {kNoPose, "no pose", "no pose yet: pose and velocity are not known; check that poses arrive"},
    {kDeadReckoning, "dead reckoning", "no pose was used lately: trust the covariance, it grows"},
    {kGateRejecting, "gate rejecting",
     "the last pose was far from its prediction and was not used"},
    {kReinitialised, "reinitialised",
     "poses agreed with each other and not with the filter: it follows them now"},
    {kCommandSilence, "command silence", "no command in force: the thrusters are taken to be off"},
    {kOutsideSpeeds, "outside speeds",
     "faster than the model was identified: record and identify there"},
    {kOutsideCommands, "outside commands",
     "more thrust than the model was identified with: record and identify there"},
    {kBadInput, "bad input",
     "an input was refused: not a number, too late, or its stamp is far off"},
    {kDiverged, "diverged", "the model ran away, or stamps leapt: it began anew at the next pose"},
    {kBeyondReach, "beyond reach",
     "the time asked for is not kept any more, or too far ahead: the estimate is of its own time"},
    {kModelDoubted, "model doubted",
     "poses overruled the model more than once: a current, wind, another payload, or a SLAM that "
     "jumps? It counts with disturbances now; if it was the boat, identify again"}};

/// What became of an input.
enum class Taken : std::uint8_t {
  kUsed,       // or will be, at its stamp; a pose, if it passes the gate
  kNotNumber,  // NaN, infinite or absurdly large, or no covariance
  kStale,      // older than what is kept
  kAhead,      // its stamp leaps ahead: used when the next one does, too
  kTwice,      // the same pose once more
  kNoRoom      // more within the window than there is room for
};

/// In words, in the same order.
inline constexpr const char* kTakenWords[] = {"used",  "not a number", "stale",
                                              "ahead", "twice",        "no room"};

/// Ranges that the model was identified in.
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
