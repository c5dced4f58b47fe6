// SPDX-License-Identifier: MIT
// A boat and states of its filter, for the tests of steps and corrections.
#pragma once
#include <algorithm>

#include "boats.hpp"
#include "onboard.hpp"

namespace filters {

using namespace seatrial;  // NOLINT(google-build-using-namespace)
using boats::Random;

inline constexpr int kSizes[] = {kFilterStates, kColouredStates, kOscillatingStates};

/// A moving boat with a covariance in which all n states are correlated.
inline StateEstimate under_way(std::uint64_t seed, int n = kFilterStates) {
  Random random(seed);
  StateEstimate b;
  b.n = n;
  const double x[kOscillatingStates] = {0.3,  -0.2,  0.7,   0.25, -0.15, 0.5,   0.02, -0.03,
                                        0.05, 0.004, -0.01, 0.02, 0.01,  -0.02, 0.03};
  std::copy(x, x + n, b.x);
  double root[kOscillatingStates][kOscillatingStates];
  for (auto& row : root) random.fill(row, n, -0.1, 0.1);
  for (int i = 0; i < n; ++i) root[i][i] += 0.2;
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      for (int k = 0; k < n; ++k) b.p[i][j] += root[i][k] * root[j][k];
    }
  }
  return b;
}

/// Whether what is not among its states is left alone.
inline bool rest_is_untouched(const StateEstimate& b) {
  for (int i = b.n; i < kOscillatingStates; ++i) {
    if (b.x[i] != 0.0) return false;
    for (int j = 0; j < kOscillatingStates; ++j) {
      if (b.p[i][j] != 0.0 || b.p[j][i] != 0.0) return false;
    }
  }
  return true;
}

inline constexpr double kForce[3][kMaxForces] = {
    {0.5, -0.3, 0.4}, {0.52, -0.2, 0.3}, {0.53, -0.1, 0.2}};
inline constexpr double kStep = 0.02;  // [s]

inline OnboardBoat boat(DisturbanceFrame frame) {
  OnboardBoat b = onboard::model().boat;
  b.frame = frame;
  b.current[0] = 0.05;
  b.current[1] = -0.02;
  return b;
}

}  // namespace filters
