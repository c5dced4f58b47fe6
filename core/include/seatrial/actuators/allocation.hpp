// SPDX-License-Identifier: MIT
// Thrust allocation: wrench command F to thruster commands f.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

namespace seatrial {

inline constexpr int kMaxActuators = 8;
inline constexpr int kMaxCommands = 8;

enum class Scheme : std::uint8_t {
  kDirect,        // f = F: the commands are the actuators' own
  kMoorePenrose,  // f = T+ F, Eq. (10)
  kAlwaysForward  // f = F_os + sum_j max(0, 2 T+_kj F_j), Table I and Eq. (11)
};

/// A scheme with its numbers. All fields are in command units (+-1 at the joypad's stop).
struct Allocation {
  Scheme scheme = Scheme::kDirect;
  int n_commands = 0;
  int n_actuators = 0;
  double inverse[kMaxActuators][kMaxCommands] = {};        // T+
  double offset = 0.0;                                     // F_os
  double limit = std::numeric_limits<double>::infinity();  // |f_k| never above it
};

/// Thruster commands f for the wrench command F. Returns alpha in [0, 1]: the wrench that is
/// really given is alpha F. Limits scale F and never a single f, so that the direction is kept.
/// A command that is NaN stays NaN (hence the order inside min and max).
inline double allocate(const Allocation& a, const double* wrench, double* thruster) {
  double alpha = 1.0;
  const double offset = a.scheme == Scheme::kAlwaysForward ? a.offset : 0.0;
  for (int k = 0; k < a.n_actuators; ++k) {
    double sum = 0.0;
    for (int j = 0; j < a.n_commands; ++j) {
      const double share = a.inverse[k][j] * wrench[j];
      sum += a.scheme == Scheme::kAlwaysForward ? std::max(2.0 * share, 0.0) : share;
    }
    if (a.scheme == Scheme::kDirect) sum = wrench[k];
    thruster[k] = sum;
    if (std::abs(sum) > a.limit - offset) {
      alpha = std::min(alpha, std::max(0.0, a.limit - offset) / std::abs(sum));
    }
  }
  for (int k = 0; k < a.n_actuators; ++k) {
    if (a.scheme == Scheme::kDirect) {
      thruster[k] = std::min(std::max(thruster[k], -a.limit), a.limit);
    } else {
      thruster[k] = offset + alpha * thruster[k];
    }
  }
  return a.scheme == Scheme::kDirect ? 1.0 : alpha;
}

}  // namespace seatrial
