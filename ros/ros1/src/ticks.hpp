// SPDX-License-Identifier: MIT
// Instants at a fixed rate, for a loop that waits by itself: ros::Timer keeps a thread that wakes
// the spinning one each time.
#pragma once
#include <ros/time.h>

namespace seatrial::ros {

/// Time: ros::Time (which may be simulated), ros::WallTime or ros::SteadyTime.
template <class Time, class Duration>
class Ticks {
 public:
  explicit Ticks(double rate) : period_(1.0 / rate) {}  // [Hz]

  /// Is one due? Those that were missed are left out; a clock that was set back begins anew.
  bool due(Time now) {
    if (next_.isZero() || now + period_ < next_) next_ = now;
    if (now < next_) return false;
    next_ += period_;
    if (next_ <= now) next_ = now + period_;
    return true;
  }

  /// Until the next one [s].
  double wait(Time now) const { return next_.isZero() ? 0.0 : (next_ - now).toSec(); }

 private:
  Duration period_;
  Time next_;
};

}  // namespace seatrial::ros
