// SPDX-License-Identifier: MIT
// Random numbers that are the same on every machine: the standard fixes the generator and its
// seeding, but not its distributions. Host only.
#pragma once
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>

#include "seatrial/model/frames.hpp"

namespace seatrial {

class Random {
 public:
  /// One stream for each seed, boat and sensor.
  Random(std::uint64_t seed, std::uint32_t boat, std::uint32_t sensor) {
    std::seed_seq words{static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32U),
                        boat, sensor};
    generator_.seed(words);
  }

  /// In [0, 1).
  double uniform() { return static_cast<double>(generator_() >> 11U) * 0x1p-53; }

  double uniform(double low, double high) { return low + (high - low) * uniform(); }

  /// Standard normal, by Box and Muller.
  double normal() {
    if (has_spare_) {
      has_spare_ = false;
      return spare_;
    }
    const double radius = std::sqrt(-2.0 * std::log1p(-uniform()));
    const double angle = 2.0 * kPi * uniform();
    spare_ = radius * std::sin(angle);
    has_spare_ = true;
    return radius * std::cos(angle);
  }

  /// Waiting time of a Poisson process of so many a minute [s]; infinite at 0.
  double wait(double per_minute) {
    return per_minute > 0.0 ? -std::log1p(-uniform()) * 60.0 / per_minute
                            : std::numeric_limits<double>::infinity();
  }

 private:
  std::mt19937_64 generator_;
  double spare_ = 0.0;
  bool has_spare_ = false;
};

}  // namespace seatrial
