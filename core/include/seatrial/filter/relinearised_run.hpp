// SPDX-License-Identifier: MIT
// A run repeated with other noise and other parameters, linearised about the first: no integration.
// Host side: uses heap.
#pragma once
#include <algorithm>
#include <cmath>
#include <vector>

#include "seatrial/filter/innovations.hpp"

namespace seatrial {

/// How many updates a run along these poses has: one more than transitions.
inline int updates_of(const FilterRun& first, const PoseSeries& poses) {
  const Effects all = detail::with_known_delay(first.effects, poses);
  return detail::PoseUpdates(poses, all).n();
}

namespace detail {

/// Columns of a filter that repeats a run, which has no model: so many parameters.
inline Columns columns_of(int parameters) {
  Columns kept;
  kept.n_initial = kStates;
  kept.n_coefficients = kAxes;
  kept.n_constants = parameters;
  return kept;
}

/// A run that is repeated with a step of the parameters, linearised about the first.
class Repetition {
 public:
  /// step: (p) of the first run's parameters, null for none; slopes: its effects are among them.
  Repetition(const FilterRun& first, const PoseSeries& poses, const double* step, bool slopes)
      : first_(first),
        step_(step),
        effects_(with_known_delay(first.effects, poses)),
        updates_(poses, effects_) {
    // NOLINTNEXTLINE(clang-analyzer-optin.cplusplus.UninitializedObject): updates_ sets all of its
    if (step == nullptr || !slopes) return;
    const double* by = step + first.parameters - kEffects;
    for (int i = 0; i < 2; ++i) effects_.lever[i] += by[kLever + i];
    for (int i = 0; i < 2; ++i) effects_.current[i] += by[kCurrent + i];
    std::copy(by + kDelay, by + kDelay + 2, effects_.later);
  }

  const Effects& effects() const { return effects_; }
  const PoseUpdates& updates() const { return updates_; }  // at the times of the first run

  /// Of the first run from update k to the next.
  const Transition& transition(int k) const {
    return first_.transition[static_cast<std::size_t>(k)];
  }
  Interval interval(const NoiseParameters& noise, int k) const {
    const double* x = state(k);
    return {noise, std::cos(x[2]), std::sin(x[2]), updates_.time()[k + 1] - updates_.time()[k]};
  }

  /// Filters from update k to the next, if there is one. The first one's noise is that of `passed`.
  template <int N>
  void follow(LikelihoodFilter<N>* filter, std::size_t filters, const NoiseParameters& noise, int k,
              bool sensitivities = false) const {
    if (k == updates_.n() - 1) return;
    const auto at = static_cast<std::size_t>(k);
    const auto p = static_cast<std::size_t>(first_.parameters);
    const double* from = state(k);
    const Interval passed = interval(noise, k);
    const float* gain = first_.gain.empty() ? nullptr : &first_.gain[at * kStates * p];
    double moved[kStates] = {};
    if (step_ != nullptr && gain != nullptr) {
      for (std::size_t i = 0; i < kStates; ++i) {
        for (std::size_t c = 0; c < p; ++c) {
          moved[i] += static_cast<double>(gain[i * p + c]) * step_[c];
        }
      }
    }
    for (std::size_t i = 0; i < filters; ++i) {
      filter[i].repeat(first_.transition[at], from, passed, step_ == nullptr ? nullptr : moved,
                       sensitivities ? gain : nullptr);
      filter[i].add_input_error(updates_.input_error(k));
    }
  }

 private:
  /// The first run's state (9) after update k.
  const double* state(int k) const {
    const auto& states = first_.update_state.empty() ? first_.state : first_.update_state;
    return &states[static_cast<std::size_t>(k) * kFilterStates];
  }

  const FilterRun& first_;
  const double* step_;
  Effects effects_;
  PoseUpdates updates_;
};

template <int N>
double repeated(const FilterRun& first, const PoseSeries& poses, const NoiseParameters& noise,
                double outlier, const FilterStart& start, const double* step, bool slopes) {
  const Columns none = columns_of(0);
  const Repetition repetition(first, poses, step, slopes);
  LikelihoodFilter<N> again(none, noise, outlier, start, repetition.effects(), false);
  double cost = 0.0;
  for (int k = 0; k < repetition.updates().n(); ++k) {
    const PoseUpdate next = repetition.updates()[k];
    if (next.parts != kNoPart) {
      cost += use_pose(again, poses, next, repetition.updates().time()[k]).cost;
    }
    repetition.follow(&again, 1, noise, k);
  }
  return cost;
}

template <int N>
FilterRun relinearised(const FilterRun& first, const PoseSeries& poses,
                       const NoiseParameters& noise, double outlier, const FilterStart& start,
                       const double* step, bool slopes, const int* block) {
  const Columns columns = columns_of(first.parameters - (slopes ? kEffects : 0));
  const Repetition repetition(first, poses, step, slopes);
  LikelihoodFilter<N> again(columns, noise, outlier, start, repetition.effects(), slopes);
  const auto n = static_cast<std::size_t>(poses.n);
  const auto blocks = block == nullptr ? n : static_cast<std::size_t>(block[poses.n - 1]) + 1;
  FilterRun out = room_for(first.parameters, n, blocks);
  out.effects = repetition.effects();
  int latest = 0;
  for (int k = 0; k < repetition.updates().n(); ++k) {
    const PoseUpdate next = repetition.updates()[k];
    latest = std::max(latest, next.pose);
    if (next.parts != kNoPart) {
      const CostedInnovation seen =
          use_pose(again, poses, next, repetition.updates().time()[k], 1.0, &out,
                   block == nullptr ? next.pose : block[latest]);
      out.cost += seen.cost;
      keep(seen, next, out);
    }
    if (next.keeps) keep(again, next.pose, out);
    repetition.follow(&again, 1, noise, k, true);
  }
  mirror(out.information.data(), out.parameters);
  return out;
}

}  // namespace detail

/// The cost of a run that is repeated with other noise and, where `step` (p) is not null, other
/// parameters, linearised about the first. `slopes`: the first run's effects are parameters.
inline double repeated(const FilterRun& first, const PoseSeries& poses,
                       const NoiseParameters& noise, double outlier, const FilterStart& start,
                       const double* step = nullptr, bool slopes = false) {
  return detail::with_states(noise.coloured(), noise.oscillating(), [&](auto states) {
    return detail::repeated<states()>(first, poses, noise, outlier, start, step, slopes);
  });
}

/// The same with gradient, information and scores: a run without integration.
inline FilterRun relinearised(const FilterRun& first, const PoseSeries& poses,
                              const NoiseParameters& noise, double outlier,
                              const FilterStart& start, const double* step = nullptr,
                              bool slopes = false, const int* block = nullptr) {
  return detail::with_states(noise.coloured(), noise.oscillating(), [&](auto states) {
    return detail::relinearised<states()>(first, poses, noise, outlier, start, step, slopes, block);
  });
}

}  // namespace seatrial
