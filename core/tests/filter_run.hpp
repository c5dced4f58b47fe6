// SPDX-License-Identifier: MIT
// A recording for the tests of the estimator's filter.
#pragma once
#include <cmath>
#include <utility>
#include <vector>

#include "problem.hpp"
#include "seatrial/filter/noise_derivatives.hpp"

namespace problems {

/// White errors of the poses.
inline constexpr NoiseParameters kWhite{2e-3, 4e-3, 5e-3, 2e-2, 3e-3, 1e-2,
                                        2.0,  0.0,  0.0,  0.3,  0.0};
/// With correlated errors of the poses.
inline constexpr NoiseParameters kColoured{2e-3, 4e-3, 5e-3, 2e-2, 3e-3, 1e-2,
                                           2.0,  3e-3, 2e-3, 0.3,  0.0};
/// And swing.
inline constexpr NoiseParameters kOscillating{2e-3, 4e-3, 5e-3, 2e-2, 3e-3, 1e-2,
                                              2.0,  3e-3, 2e-3, 1.5,  4.0};

/// The three disturbances that the filter adds, as the last coefficients.
inline Structure disturbed(Structure s) {
  const int first = s.n_coefficients;
  for (int axis = 0; axis < kAxes; ++axis) boats::add(s, axis, first + axis, 1.0, {});
  return s;
}

inline constexpr double kNever = 1e9;  // [sigma] from where on a pose is an outlier: none is

/// A problem with noisy poses of its boat, every 17th of them not measured.
struct Run {
  Problem problem;
  std::vector<double> eta;
  std::vector<signed char> use;
  FilterStart start{};

  explicit Run(Problem p) : problem(std::move(p)) {
    std::vector<double> states = simulated(problem, nullptr);
    boats::Random random(7);
    for (std::size_t i = 0; i < problem.time.size(); ++i) {
      for (std::size_t j = 0; j < kPose; ++j) {
        eta.push_back(states[i * kStates + j] + random(-3e-3, 3e-3));
      }
      use.push_back(i % 17 == 16 ? 0 : 1);
    }
    std::copy(problem.x0.begin(), problem.x0.end(), start.state);
    std::fill(start.velocity, start.velocity + kAxes, 0.05);
  }

  PoseSeries poses() const {
    return {static_cast<int>(problem.time.size()), problem.time.data(), eta.data(), use.data()};
  }

  FilterRun pass(const NoiseParameters& noise, double outlier = kNever) const {
    return innovations(problem.boat, problem.trace(), poses(), noise, outlier, start);
  }
};

/// The boat of this structure on the rich recording.
inline Run run_of(const Structure& s, std::vector<double> coefficients) {
  coefficients.resize(coefficients.size() + kAxes, 0.0);
  return Run(driven(disturbed(s), coefficients, Scheme::kMoorePenrose, true));
}

inline Run mallard_run() { return run_of(boats::mallard(), boats::mallard_coefficients()); }

/// Steps of the logarithm of every noise parameter; short ones of the frequency, as a resonance is
/// sharp.
inline std::vector<NoiseDirection> logarithmic_directions(const NoiseParameters& noise) {
  constexpr double kStep = 0.05;
  std::vector<NoiseDirection> all;
  for (int i = 0; i < kNoiseParameters; ++i) {
    const bool turn = i == kTurnParameter;
    const double step = turn ? kStep / (1.0 + noise.colour_turn * noise.colour_memory) : kStep;
    all.push_back({noise, step});
    all.back().noise.parameter(i) *= std::exp(step);
  }
  return all;
}

}  // namespace problems
