// SPDX-License-Identifier: MIT
// The likelihood's derivatives to the noise parameters, by differences of repeated runs. Host side:
// uses heap.
#pragma once
#include <vector>

#include "seatrial/filter/relinearised_run.hpp"

namespace seatrial {

/// A noise beside the one whose derivatives are sought, and its distance in the coordinate moved.
struct NoiseDirection {
  NoiseParameters noise;
  double step;
};

/// Half the cost's gradient (m) and the Fisher information (m, m) in the directions of noise.
struct NoiseDerivatives {
  double cost = 0.0;
  std::vector<double> gradient;
  std::vector<double> information;
};

namespace detail {

/// Derivatives of innovations and of their covariance S in m directions, one column each: S^-1 dS
/// and its transpose, S^-1 de and de. Fisher information is a product of columns.
struct NoiseColumns {
  static constexpr int kTerms = kPose * kPose + kPose;
  double left[kTerms][kNoiseParameters];
  double right[kTerms][kNoiseParameters];

  void set(int at, const Innovation& from, const Innovation& to, double per_step) {
    double de[kPose];
    double ds[kPose][kPose];
    for (int i = 0; i < kPose; ++i) {
      de[i] = (to.e[i] - from.e[i]) * per_step;
      for (int j = 0; j < kPose; ++j) ds[i][j] = (to.s[i][j] - from.s[i][j]) * per_step;
    }
    for (int i = 0; i < kPose; ++i) {
      const double* row = from.inverse[i];
      for (int j = 0; j < kPose; ++j) {
        const double scaled = row[0] * ds[0][j] + row[1] * ds[1][j] + row[2] * ds[2][j];
        left[i * kPose + j][at] = scaled;
        right[j * kPose + i][at] = 0.5 * scaled;
      }
      left[kPose * kPose + i][at] = row[0] * de[0] + row[1] * de[1] + row[2] * de[2];
      right[kPose * kPose + i][at] = de[i];
    }
  }

  /// Adds tr(S^-1 dS_i S^-1 dS_j) / 2 + de_i' S^-1 de_j of the first n, j <= i.
  void inform(int n, double information[kNoiseParameters][kNoiseParameters]) const {
    for (int i = 0; i < n; ++i) {
      for (int t = 0; t < kTerms; ++t) {
        const double own = left[t][i];
        for (int j = 0; j <= i; ++j) information[i][j] += own * right[t][j];
      }
    }
  }
};

/// The derivatives from the information and the costs (m): the slope is the difference quotient
/// less its second-order share.
inline void derive(const std::vector<NoiseDirection>& directions,
                   const double information[kNoiseParameters][kNoiseParameters], const double* cost,
                   NoiseDerivatives& out) {
  const std::size_t m = directions.size();
  out.gradient.resize(m);
  out.information.resize(m * m);
  for (std::size_t i = 0; i < m; ++i) {
    for (std::size_t j = 0; j <= i; ++j) {
      out.information[i * m + j] = out.information[j * m + i] = information[i][j];
    }
    const double step = directions[i].step;
    out.gradient[i] = 0.5 * (cost[i] - out.cost) / step - 0.5 * step * information[i][i];
  }
}

template <int N>
NoiseDerivatives noise_slopes(const FilterRun& first, const PoseSeries& poses,
                              const NoiseParameters& noise,
                              const std::vector<NoiseDirection>& directions, double outlier,
                              const FilterStart& start, const double* step, bool slopes) {
  // one filter of this noise, and one for each direction
  const std::size_t m = directions.size();
  const Columns none = columns_of(0);
  const Repetition repetition(first, poses, step, slopes);
  std::vector<LikelihoodFilter<N>> filters;
  filters.reserve(m + 1);
  filters.emplace_back(none, noise, outlier, start, repetition.effects(), false);
  for (const NoiseDirection& to : directions) {
    filters.emplace_back(none, to.noise, outlier, start, repetition.effects(), false);
  }
  // side by side along the recording
  NoiseDerivatives out;
  double cost[kNoiseParameters] = {};
  double information[kNoiseParameters][kNoiseParameters] = {};
  NoiseColumns changes;
  for (int k = 0; k < repetition.updates().n(); ++k) {
    const PoseUpdate next = repetition.updates()[k];
    const double t = repetition.updates().time()[k];
    if (next.parts != kNoPart) {
      const CostedInnovation here = use_pose(filters[0], poses, next, t);
      out.cost += here.cost;
      for (std::size_t i = 0; i < m; ++i) {
        const CostedInnovation there = use_pose(filters[i + 1], poses, next, t);
        cost[i] += there.cost;
        changes.set(static_cast<int>(i), here, there, 1.0 / directions[i].step);
      }
      changes.inform(static_cast<int>(m), information);
    }
    repetition.follow(filters.data(), m + 1, noise, k);
  }
  derive(directions, information, cost, out);
  return out;
}

}  // namespace detail

/// Fisher's information of Gaussian innovations: tr(S^-1 dS_i S^-1 dS_j) / 2 + de_i' S^-1 de_j, by
/// differences of linearised runs. At most kNoiseParameters directions. `step`, `slopes`: as of
/// `repeated`.
inline NoiseDerivatives noise_slopes(const FilterRun& first, const PoseSeries& poses,
                                     const NoiseParameters& noise,
                                     const std::vector<NoiseDirection>& directions, double outlier,
                                     const FilterStart& start, const double* step = nullptr,
                                     bool slopes = false) {
  bool coloured = noise.coloured();
  bool oscillating = noise.oscillating();
  for (const NoiseDirection& to : directions) {
    coloured = coloured || to.noise.coloured();
    oscillating = oscillating || to.noise.oscillating();
  }
  return detail::with_states(coloured, oscillating, [&](auto states) {
    return detail::noise_slopes<states()>(first, poses, noise, directions, outlier, start, step,
                                          slopes);
  });
}

}  // namespace seatrial
