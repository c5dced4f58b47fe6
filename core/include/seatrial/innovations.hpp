// SPDX-License-Identifier: MIT
// Passes of the filter along a recording: the likelihood that the estimator maximises, and its
// slopes. Host side: uses heap.
//
// Without process noise this is the simulation error of the whole record, with much of it every
// pose is a start of its own: the data choose between the two.
#pragma once
#include <algorithm>
#include <cmath>

#include "seatrial/filter.hpp"

namespace seatrial {

inline constexpr int kFilterChunk = 512;  // intervals that are scheduled at once

/// One pass over a recording. The boat's last three coefficients must be the disturbance: terms
/// that are nothing but themselves in surge, sway and yaw; the trace's columns hold the initial
/// state, the chosen coefficients with these three last, and the chosen constants. `slopes`: the
/// effects are parameters, too. `counts`: how often each pose counts (bootstrap), once where null.
inline FilterPass innovations(Boat boat, const Trace& trace, const PoseSeries& poses,
                              const FilterNoise& noise, const FilterStart& start,
                              const Effects& effects = {}, bool slopes = false,
                              const double* counts = nullptr) {
  detail::Filter filter(trace.columns(), noise, start, effects, slopes);
  const int p = filter.parameters();
  const auto n = static_cast<std::size_t>(poses.n);
  FilterPass pass;
  pass.parameters = p;
  pass.effects = effects;
  pass.information.assign(static_cast<std::size_t>(p) * static_cast<std::size_t>(p), 0.0);
  pass.gradient.assign(static_cast<std::size_t>(p), 0.0);
  pass.score.assign(n * static_cast<std::size_t>(p), 0.0);
  pass.innovation.assign(n * kPose, std::nan(""));
  pass.spread.assign(n * 6, std::nan(""));
  pass.state.assign(n * kFilterStates, std::nan(""));
  pass.deviation.assign(n * kFilterStates, std::nan(""));
  pass.weight.assign(n, 0.0);
  pass.way.reserve(n);
  for (int first = 0; first < poses.n; first += kFilterChunk) {
    const int last = std::min(poses.n - 1, first + kFilterChunk);
    const Schedule schedule(boat, trace, poses.time, first, last, true);
    for (int k = first; k < std::min(poses.n, first + kFilterChunk); ++k) {
      if (poses.use[k] == 2) filter.loosen(10.0, 3.0);
      if (poses.use[k] != 0) {
        filter.update(poses.eta + static_cast<std::ptrdiff_t>(k) * kPose, poses.time[k],
                      counts == nullptr ? 1.0 : counts[k], k, pass);
      }
      for (int i = 0; i < kFilterStates; ++i) {
        pass.state[static_cast<std::size_t>(k) * kFilterStates + static_cast<std::size_t>(i)] =
            filter.state()[i];
        pass.deviation[static_cast<std::size_t>(k) * kFilterStates + static_cast<std::size_t>(i)] =
            std::sqrt(std::max(0.0, filter.variance(i)));
      }
      if (k == poses.n - 1) break;
      pass.way.emplace_back();
      const double length = poses.time[k + 1] - poses.time[k];
      if (!filter.predict(schedule, k, boat, length, pass.way.back())) {
        pass.good = false;
        return pass;
      }
    }
  }
  for (int a = 0; a < p; ++a) {
    for (int b = 0; b < a; ++b) {
      pass.information[static_cast<std::size_t>(b * p + a)] =
          pass.information[static_cast<std::size_t>(a * p + b)];
    }
  }
  return pass;
}

/// The pass again with other noise, linearised about the first: cost, innovations and spread.
inline void repeated(const FilterPass& first, const PoseSeries& poses, const FilterNoise& noise,
                     const FilterStart& start, FilterPass& pass) {
  Columns none;
  none.n_initial = kStates;
  none.n_coefficients = kAxes;
  detail::Filter filter(none, noise, start, first.effects, false);
  const auto n = static_cast<std::size_t>(poses.n);
  pass.cost = 0.0;
  pass.innovation.assign(n * kPose, std::nan(""));
  pass.spread.assign(n * 6, std::nan(""));
  pass.weight.assign(n, 0.0);
  for (int k = 0; k < poses.n; ++k) {
    if (poses.use[k] == 2) filter.loosen(10.0, 3.0);
    if (poses.use[k] != 0) {
      filter.update(poses.eta + static_cast<std::ptrdiff_t>(k) * kPose, poses.time[k], 1.0, k,
                    pass);
    }
    if (k < poses.n - 1) filter.repeat(first.way[static_cast<std::size_t>(k)]);
  }
}

/// Half the cost's slope and expected curvature to the logarithms of the noise parameters.
struct NoisePass {
  double cost = 0.0;
  double gradient[kNoiseParameters] = {};
  double information[kNoiseParameters][kNoiseParameters] = {};
};

namespace detail {

inline void unpack_spread(const double* row, double s[kPose][kPose]) {
  s[0][0] = row[0];
  s[0][1] = s[1][0] = row[1];
  s[0][2] = s[2][0] = row[2];
  s[1][1] = row[3];
  s[1][2] = s[2][1] = row[4];
  s[2][2] = row[5];
}

/// S^-1 times the difference of two spreads.
inline void relative_change(const double inverse[kPose][kPose], const double a[kPose][kPose],
                            const double b[kPose][kPose], double step, double out[kPose][kPose]) {
  for (int i = 0; i < kPose; ++i) {
    for (int j = 0; j < kPose; ++j) {
      out[i][j] = 0.0;
      for (int m = 0; m < kPose; ++m) out[i][j] += inverse[i][m] * (b[m][j] - a[m][j]) / step;
    }
  }
}

}  // namespace detail

/// Fisher's information of Gaussian innovations: tr(S^-1 dS_i S^-1 dS_j) / 2 + de_i' S^-1 de_j,
/// by differences of linearised passes. Bit i of `active`: parameter i is looked at.
inline NoisePass noise_slopes(const FilterPass& first, const PoseSeries& poses,
                              const FilterNoise& noise, const FilterStart& start,
                              unsigned active = ~0U) {
  constexpr double kStep = 0.05;  // of a logarithm
  NoisePass out;
  FilterPass base;
  FilterPass moved[kNoiseParameters];
  repeated(first, poses, noise, start, base);
  out.cost = base.cost;
  const auto skipped = [active](int i) { return ((active >> i) & 1U) == 0; };
  for (int i = 0; i < kNoiseParameters; ++i) {
    if (skipped(i)) continue;
    FilterNoise up = noise;
    up.parameter(i) *= std::exp(kStep);
    repeated(first, poses, up, start, moved[i]);
  }
  for (int k = 0; k < poses.n; ++k) {
    if (poses.use[k] == 0) continue;
    const auto at = static_cast<std::size_t>(k);
    double s[kPose][kPose];
    double inverse[kPose][kPose];
    detail::unpack_spread(&base.spread[at * 6], s);
    detail::inverse3(s, inverse);
    double ds[kNoiseParameters][kPose][kPose];
    double de[kNoiseParameters][kPose];
    double sde[kNoiseParameters][kPose];
    for (int i = 0; i < kNoiseParameters; ++i) {
      if (skipped(i)) continue;
      double other[kPose][kPose];
      detail::unpack_spread(&moved[i].spread[at * 6], other);
      detail::relative_change(inverse, s, other, kStep, ds[i]);
      for (int m = 0; m < kPose; ++m) {
        de[i][m] = (moved[i].innovation[at * kPose + static_cast<std::size_t>(m)] -
                    base.innovation[at * kPose + static_cast<std::size_t>(m)]) /
                   kStep;
      }
      for (int m = 0; m < kPose; ++m) {
        sde[i][m] = inverse[m][0] * de[i][0] + inverse[m][1] * de[i][1] + inverse[m][2] * de[i][2];
      }
      for (int j = 0; j <= i; ++j) {
        if (skipped(j)) continue;
        double trace = 0.0;
        for (int a = 0; a < kPose; ++a) {
          for (int b = 0; b < kPose; ++b) trace += ds[i][a][b] * ds[j][b][a];
        }
        const double along = de[j][0] * sde[i][0] + de[j][1] * sde[i][1] + de[j][2] * sde[i][2];
        out.information[i][j] += 0.5 * trace + along;
      }
    }
  }
  for (int i = 0; i < kNoiseParameters; ++i) {
    if (skipped(i)) continue;
    for (int j = 0; j < i; ++j) out.information[j][i] = out.information[i][j];
    // the difference quotient less its second-order share
    out.gradient[i] =
        0.5 * (moved[i].cost - base.cost) / kStep - 0.5 * kStep * out.information[i][i];
  }
  return out;
}

}  // namespace seatrial
