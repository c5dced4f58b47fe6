// SPDX-License-Identifier: MIT
// Inputs that can't be right: absurd numbers, stray stamps, and clocks that were set. No heap, no
// exceptions.
#pragma once
#include <cmath>

namespace seatrial {

inline constexpr double kStrongest = 1e3;  // largest command or scale
inline constexpr double kFarthest = 1e8;   // [m] largest coordinate of a pose
inline constexpr double kLatest = 4e9;     // [s] largest stamp: 127 years, to half a microsecond
inline constexpr double kReach = 60.0;     // [s] of prediction; after a longer gap it starts again
inline constexpr double kLeap = 5.0;       // [s] a stamp so far ahead of all others needs a second
inline constexpr int kStaleRun = 10;       // old stamps near each other: the clock was set back

/// Whether all n values are numbers of a size up to `most`.
inline bool all_within(const double* values, int n, double most) {
  for (int i = 0; i < n; ++i) {
    if (!(std::abs(values[i]) <= most)) return false;
  }
  return true;
}

/// Stamps that are out of place: single ones are strays, several that agree mean that the clock was
/// set.
class StampCheck {
 public:
  /// A stamp t [s] more than kLeap ahead of all others. True where the one before agrees.
  bool agrees_ahead(double t) {
    const bool near = ahead_known_ && std::abs(t - ahead_) <= kLeap;
    ahead_known_ = !near;
    ahead_ = t;
    return near;
  }

  /// A stamp t [s] that is too old. True for the last of kStaleRun in a row near each other.
  bool agrees_behind(double t) {
    const bool near = run_ > 0 && std::abs(t - behind_) < kLeap;
    run_ = near ? run_ + 1 : 1;
    behind_ = t;
    return run_ >= kStaleRun;
  }

  /// A stamp in its place: those before it were strays.
  void in_place() {
    ahead_known_ = false;
    run_ = 0;
  }

 private:
  bool ahead_known_ = false;
  double ahead_ = 0.0;   // [s]
  double behind_ = 0.0;  // [s]
  int run_ = 0;          // stamps near each other that are too old
};

}  // namespace seatrial
