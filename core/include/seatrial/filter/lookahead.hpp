// SPDX-License-Identifier: MIT
// How uncertain predictions are that start from the filter and leave out the disturbance: they
// carry the model's states only. The error of the start and the disturbance are correlated, as the
// filter lags behind what the disturbance does. Host side: uses heap.
#pragma once
#include <vector>

#include "seatrial/filter/relinearised_run.hpp"

namespace seatrial {
namespace detail {

template <int N>
std::vector<double> lookahead_variance(const FilterRun& first, const PoseSeries& poses,
                                       const NoiseParameters& noise, double outlier,
                                       const FilterStart& start, const std::vector<int>& from,
                                       const std::vector<int>& to) {
  const Columns none = columns_of(0);
  const Repetition repetition(first, poses, nullptr, false);
  const PoseUpdates& updates = repetition.updates();
  LikelihoodFilter<N> filter(none, noise, outlier, start, repetition.effects(), false);
  std::vector<double> out;
  out.reserve(from.size() * kAxes);
  std::size_t next = 0;
  for (int k = 0; k < updates.n() && next < from.size(); ++k) {
    const PoseUpdate at = updates[k];
    if (at.parts != kNoPart) use_pose(filter, poses, at, updates.time()[k]);
    // a pose's state is that at its heading's time
    for (; at.keeps && next < from.size() && from[next] == at.pose; ++next) {
      LikelihoodFilter<N> ahead(filter);
      ahead.leave_out_disturbance();
      for (int i = k; !(updates[i].keeps && updates[i].pose >= to[next]); ++i) {
        repetition.follow(&ahead, 1, noise, i);
      }
      for (int axis = 0; axis < kAxes; ++axis) out.push_back(ahead.variance(kPose + axis));
    }
    repetition.follow(&filter, 1, noise, k);
  }
  return out;
}

}  // namespace detail

/// Variances (m, 3) of the velocities at the poses `to` (m) of predictions from the filter's state
/// after the poses `from` (m, rising), with this noise, linearised about a first run that kept its
/// transitions.
inline std::vector<double> lookahead_variance(const FilterRun& first, const PoseSeries& poses,
                                              const NoiseParameters& noise, double outlier,
                                              const FilterStart& start,
                                              const std::vector<int>& from,
                                              const std::vector<int>& to) {
  return detail::with_states(noise.coloured(), noise.oscillating(), [&](auto states) {
    return detail::lookahead_variance<states()>(first, poses, noise, outlier, start, from, to);
  });
}

}  // namespace seatrial
