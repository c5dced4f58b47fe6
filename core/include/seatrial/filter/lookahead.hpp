// SPDX-License-Identifier: MIT
// Predictions that start from the filter, and how uncertain they are. With the disturbance they are
// the k-step predictor of Ljung, System Identification, section 3.2: what the filter on board
// predicts without poses. Without it they carry the model's states only; then the error of the
// start and the disturbance are correlated, as the filter lags behind what the disturbance does.
// Host side: uses heap.
#pragma once
#include <array>
#include <cmath>
#include <vector>

#include "seatrial/filter/relinearised_run.hpp"
#include "seatrial/integration/rollout.hpp"

namespace seatrial {
namespace detail {

template <int N>
std::vector<double> lookahead_variance(const FilterRun& first, const PoseSeries& poses,
                                       const NoiseParameters& noise, double outlier,
                                       const FilterStart& start, const std::vector<int>& from,
                                       const std::vector<int>& to, bool disturbed) {
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
      if (!disturbed) ahead.leave_out_disturbance();
      for (int i = k; !(updates[i].keeps && updates[i].pose >= to[next]); ++i) {
        repetition.follow(&ahead, 1, noise, i);
      }
      for (int axis = 0; axis < kAxes; ++axis) out.push_back(ahead.variance(kPose + axis));
    }
    repetition.follow(&filter, 1, noise, k);
  }
  return out;
}

/// A state (9) over an interval of `length` [s]: the disturbance pushes the boat, and fades.
inline void cross_disturbed(const StepSchedule& schedule, int interval, double length,
                            const NoiseParameters& noise, bool earth_fixed, Boat& boat, double* x) {
  constexpr double kNone[kWindParts] = {};
  const Disturbing disturbing(x, length, kNone, kNone, earth_fixed);
  std::copy(disturbing.total, disturbing.total + kAxes,
            boat.coefficient + boat.structure.n_coefficients - kAxes);
  if (!schedule.run(interval, x)) std::fill(x, x + kStates, std::nan(""));
  const Interval passed(noise, 1.0, 0.0, length);
  GaussMarkov<kFilterStates>(noise, passed).carry_mean(x);
}

}  // namespace detail

/// All m starts: the filter's state x0[j] (9) at time[from[j]], carried to time[to[j]] with its
/// disturbance, whose coefficients are the boat's last three. Returns the boat's state there (out,
/// m rows of 6), NaN where it diverged.
inline void lookahead(const Boat& boat, const ThrustTrace& trace, const double* time,
                      const int* from, const int* to, const double* x0, int m,
                      const NoiseParameters& noise, bool earth_fixed, int threads, double* out) {
  using State = std::array<double, kFilterStates>;
  detail::spread_starts(m, threads, [=, &boat, &trace, &noise](int begin, int end) {
    Boat pushed(boat);  // a thread's own, as the disturbance is among its coefficients
    detail::predict_range(
        pushed, trace, time, from, to, begin, end, false,
        [&](int j) {
          State x;
          std::copy_n(x0 + static_cast<std::ptrdiff_t>(j) * kFilterStates, kFilterStates, x.data());
          return x;
        },
        [&](State& x, const StepSchedule& schedule, int k) {
          detail::cross_disturbed(schedule, k, time[k + 1] - time[k], noise, earth_fixed, pushed,
                                  x.data());
        },
        [&](int j, const State& x) {
          std::copy_n(x.data(), kStates, out + static_cast<std::ptrdiff_t>(j) * kStates);
        });
  });
}

/// Variances (m, 3) of the velocities at the poses `to` (m) of predictions from the filter's state
/// after the poses `from` (m, rising), with this noise, linearised about a first run that kept its
/// transitions. `disturbed`: with the disturbance.
inline std::vector<double> lookahead_variance(const FilterRun& first, const PoseSeries& poses,
                                              const NoiseParameters& noise, double outlier,
                                              const FilterStart& start,
                                              const std::vector<int>& from,
                                              const std::vector<int>& to, bool disturbed) {
  return detail::with_states(noise.coloured(), noise.oscillating(), [&](auto states) {
    return detail::lookahead_variance<states()>(first, poses, noise, outlier, start, from, to,
                                                disturbed);
  });
}

}  // namespace seatrial
