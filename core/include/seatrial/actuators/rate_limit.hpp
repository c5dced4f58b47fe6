// SPDX-License-Identifier: MIT
// A first-order lag with a rate limit: e' = -clip(e / lag, +-rate) of the distance e to a constant
// target, in closed form. Steering gears: Fossen, Handbook of Marine Craft, 2nd ed., section 9.
#pragma once
#include <algorithm>
#include <cmath>

namespace seatrial {

inline constexpr double kShortestLag = 1e-6;  // [s] a smaller one counts as none

/// A distance to the target after some time, and its derivatives.
struct Distance {
  double left = 0.0;
  double dstart = 0.0;  // to the distance at the begin
  double drate = 0.0;   // to the rate limit
  double dlag = 0.0;
  double dtime = 0.0;
};

/// The distance that is left of `start` after h [s]: it shrinks at the rate limit (> 0, per second)
/// down to rate * lag, then exponentially; without a lag down to 0.
inline Distance rate_limited(double start, double rate, double lag, double h) {
  const double size = std::abs(start);
  const double sign = start < 0.0 ? -1.0 : 1.0;
  const bool lags = lag > kShortestLag;
  const double knee = lags ? rate * lag : 0.0;
  if (size <= knee) {
    const double left = lags ? std::exp(-h / lag) : 0.0;
    return {start * left, left, 0.0, lags ? start * left * h / (lag * lag) : 0.0,
            lags ? -start * left / lag : 0.0};
  }
  if (h <= (size - knee) / rate)
    return {start - sign * rate * h, 1.0, -sign * h, 0.0, -sign * rate};
  if (!lags) return {};
  const double after = h - size / rate;  // [s] -lag at the knee
  const double left = knee * std::exp(-1.0 - after / lag);
  return {sign * left, left / knee, sign * left * (1.0 - size / knee) / rate,
          sign * left * (1.0 + after / lag) / lag, -sign * left / lag};
}

}  // namespace seatrial
