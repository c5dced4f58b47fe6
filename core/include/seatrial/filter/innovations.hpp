// SPDX-License-Identifier: MIT
// A run of the filter along a recording: the likelihood that the estimator maximises, and its
// derivatives. Host side: uses heap.
//
// Without process noise the innovations are the simulation error of the whole recording; with much
// process noise each pose is a new start. The data decide.
#pragma once
#include "seatrial/filter/walk.hpp"

namespace seatrial {

namespace detail {

template <int N>
FilterRun innovations(Boat boat, const ThrustTrace& trace, const PoseSeries& poses,
                      const NoiseParameters& noise, double outlier, const FilterStart& start,
                      const Effects& effects, bool slopes, const Keeping& keeping) {
  const Effects all = with_known_delay(effects, poses);
  const PoseUpdates updates(poses, all);
  LikelihoodFilter<N> filter(trace.columns(), noise, outlier, start, all, slopes);
  const auto n = static_cast<std::size_t>(poses.n);
  const int* block = keeping.block;
  const auto blocks = block == nullptr ? n : static_cast<std::size_t>(block[poses.n - 1]) + 1;
  FilterRun out = room_for(filter.parameters(), n, blocks);
  out.effects = effects;
  if (keeping.transitions) {
    const auto transitions = static_cast<std::size_t>(updates.n() - 1);
    out.transition.reserve(transitions);
    out.gain.resize(transitions * kStates * static_cast<std::size_t>(filter.parameters()));
  }
  Walk<N> walk(filter, poses, updates, updates.time(), keeping, out);
  if (!walk.run(boat, trace, 0, updates.n())) return out;
  mirror(out.information.data(), out.parameters);
  if (!out.share.empty()) part_shares(out);
  return out;
}

}  // namespace detail

/// One run over a recording. The boat's last three coefficients must be the disturbance: terms
/// that are nothing but themselves in surge, sway and yaw; the trace's columns hold the initial
/// state, the chosen coefficients with these three last, and the chosen constants. `slopes`: the
/// effects are parameters, too. `counts`: how often each pose counts (bootstrap), once where null.
/// `block`: to which block of scores each pose belongs (n, rising from 0), its own where null.
/// `repeatable`: the transitions are kept, to repeat the run with other noise. `shares`: the
/// information of each block is kept, too.
inline FilterRun innovations(const Boat& boat, const ThrustTrace& trace, const PoseSeries& poses,
                             const NoiseParameters& noise, double outlier, const FilterStart& start,
                             const Effects& effects = {}, bool slopes = false,
                             const double* counts = nullptr, const int* block = nullptr,
                             bool repeatable = true, bool shares = false) {
  const detail::Keeping keeping{counts, block, true, repeatable, shares, false};
  return detail::with_states(noise.coloured(), noise.oscillating(), [&](auto states) {
    return detail::innovations<states()>(boat, trace, poses, noise, outlier, start, effects, slopes,
                                         keeping);
  });
}

}  // namespace seatrial
