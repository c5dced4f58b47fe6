// SPDX-License-Identifier: MIT
// Runs of the filter along a recording: the likelihood that the estimator maximises, and its
// derivatives. Host side: uses heap.
//
// Without process noise the innovations are the simulation error of the whole recording; with much
// process noise each pose is a new start. The data decide.
#pragma once
#include <algorithm>
#include <cmath>
#include <type_traits>
#include <vector>

#include "seatrial/filter/likelihood_filter.hpp"
#include "seatrial/filter/pose_updates.hpp"

namespace seatrial {

inline constexpr int kFilterChunk = 512;  // intervals that are scheduled at once

namespace detail {

/// Keeps a pose's innovation. Of a pose in two parts the weight is the lesser.
inline void keep(const Innovation& seen, const PoseUpdate& update, FilterRun& out) {
  if (update.asynchronous >= 0) return;
  const auto at = static_cast<std::size_t>(update.pose);
  float* to = &out.spread[at * 6];
  for (int i = 0; i < kPose; ++i) {
    const bool own = has(update.parts, i);
    if (own) out.innovation[at * kPose + static_cast<std::size_t>(i)] = seen.e[i];
    for (int j = i; j < kPose; ++j, ++to) {
      if (own || has(update.parts, j)) *to = static_cast<float>(seen.s[i][j]);
    }
  }
  const auto weight = static_cast<float>(seen.weight);
  out.weight[at] = update.first ? weight : std::min(out.weight[at], weight);
}

/// Keeps the state after a pose.
template <int N>
void keep(const LikelihoodFilter<N>& filter, int k, FilterRun& out) {
  const auto at = static_cast<std::size_t>(k);
  std::copy(filter.state(), filter.state() + kFilterStates, &out.state[at * kFilterStates]);
  for (int i = 0; i < kAxes; ++i) {
    const double variance = std::max(0.0, filter.variance(kPose + i));
    out.deviation[at * kAxes + static_cast<std::size_t>(i)] =
        static_cast<float>(std::sqrt(variance));
  }
}

/// Jumps and restarts at a pose, before its part of time t [s] is used. Whether it jumped.
template <int N>
bool allow_jump(LikelihoodFilter<N>& filter, const PoseSeries& poses, const PoseUpdate& next,
                double t) {
  if (next.asynchronous >= 0) return false;
  const auto at = static_cast<std::ptrdiff_t>(next.pose) * kPose;
  const signed char use = poses.use[next.pose];
  if (use == kJumped) filter.loosen(poses.eta + at, t, next.parts);
  if (use == kBeginning && next.first) {
    filter.restart(poses.eta + at, poses.velocity + at, poses.time[next.pose]);
  }
  if (use != kGapped) return use == kJumped;
  return filter.loosen_if_likelier(poses.eta + at, t, next.parts);
}

/// The pose of an update, or an asynchronous measurement.
struct Measured {
  double asynchronous[kPose] = {0.0, 0.0, 0.0};
  Seen seen;

  Measured(const PoseSeries& poses, const PoseUpdate& next)
      : seen{poses.eta + static_cast<std::ptrdiff_t>(next.pose) * kPose, next.parts,
             poses.rate_deviation} {
    if (next.asynchronous < 0) return;
    asynchronous[2] = poses.asynchronous_value[next.asynchronous];
    seen.eta = asynchronous;
  }
  Measured(const Measured&) = delete;
  Measured& operator=(const Measured&) = delete;
};

/// One update at t [s], after a jump or restart. The last three arguments are of the filter's
/// update.
template <int N>
CostedInnovation use_pose(LikelihoodFilter<N>& filter, const PoseSeries& poses,
                          const PoseUpdate& next, double t, double counts = 1.0,
                          FilterRun* terms = nullptr, int block = 0) {
  allow_jump(filter, poses, next, t);
  return filter.update(Measured(poses, next).seen, t, counts, terms, block);
}

/// The effects with what is known of the delay.
inline Effects with_known_delay(Effects effects, const PoseSeries& poses) {
  effects.position_delay += poses.position_delay;
  return effects;
}

/// The upper triangle of a symmetric (p, p) from its lower.
inline void mirror(double* matrix, int p) {
  for (std::ptrdiff_t a = 0; a < p; ++a) {
    for (std::ptrdiff_t b = 0; b < a; ++b) matrix[b * p + a] = matrix[a * p + b];
  }
}

/// The information up to here, as the sum up to the block's end.
inline void take_share(int block, FilterRun& out) {
  const std::size_t size = out.information.size();
  out.share.resize((static_cast<std::size_t>(block) + 1) * size);
  std::copy(out.information.begin(), out.information.end(),
            out.share.end() - static_cast<std::ptrdiff_t>(size));
}

/// The sums up to each block's end, less those before it.
inline void part_shares(FilterRun& out) {
  const std::size_t size = out.information.size();
  for (std::size_t i = out.share.size(); i-- > size;) out.share[i] -= out.share[i - size];
  for (std::size_t i = 0; i < out.share.size(); i += size) {
    mirror(&out.share[i], out.parameters);
  }
}

/// Room for the results of a run along n poses, with `blocks` blocks of scores.
inline FilterRun room_for(int parameters, std::size_t n, std::size_t blocks) {
  FilterRun out;
  const auto p = static_cast<std::size_t>(parameters);
  out.parameters = parameters;
  out.information.assign(p * p, 0.0);
  out.gradient.assign(p, 0.0);
  out.score.assign(blocks * p, 0.0);
  out.innovation.assign(n * kPose, std::nan(""));
  out.spread.assign(n * 6, std::nanf(""));
  out.state.assign(n * kFilterStates, std::nan(""));
  out.deviation.assign(n * kAxes, std::nanf(""));
  out.weight.assign(n, 0.0F);
  return out;
}

/// What a run keeps beside its sums, and how often its poses count.
struct Keeping {
  const double* counts = nullptr;  // (n) of each pose; once where null
  const int* block = nullptr;      // (n) of scores, to which each pose belongs; its own where null
  bool poses = true;               // innovation, weight and state of each pose
  bool transitions = false;
  bool shares = false;
  bool one_block = false;  // the scores are summed
};

/// A filter along a recording, from one update to the next.
template <int N>
class Walk {
 public:
  /// time: (n) [s] of the updates; that before the first is where the filter is.
  Walk(LikelihoodFilter<N>& filter, const PoseSeries& poses, const PoseUpdates& updates,
       const double* time, const Keeping& keeping, FilterRun& out)
      : filter_(filter),
        poses_(poses),
        updates_(updates),
        time_(time),
        keeping_(keeping),
        gains_(keeping.transitions ? kStates * static_cast<std::size_t>(filter.parameters()) : 0),
        out_(out) {}

  /// Predicts and uses updates first to last - 1; there is no prediction to update 0. False where
  /// the boat diverged.
  bool run(Boat& boat, const ThrustTrace& trace, int first, int last) {
    for (int begin = first; begin < last; begin += kFilterChunk) {
      const int end = std::min(last, begin + kFilterChunk);
      const StepSchedule schedule(boat, trace, time_, std::max(begin - 1, 0), end - 1, true);
      for (int k = begin; k < end; ++k) {
        if (k > 0 && !predict(schedule, boat, k - 1)) return false;
        use(k);
      }
    }
    return true;
  }

 private:
  /// To the next update from update k.
  bool predict(const StepSchedule& schedule, Boat& boat, int k) {
    Transition unkept;
    if (keeping_.transitions) out_.transition.emplace_back();
    Transition& kept = keeping_.transitions ? out_.transition.back() : unkept;
    float* const gain = gains_ == 0 ? nullptr : &out_.gain[static_cast<std::size_t>(k) * gains_];
    out_.good = filter_.predict(schedule, k, boat, time_[k + 1] - time_[k], kept, gain);
    return out_.good;
  }

  /// Update by a pose or its part.
  void use(int k) {
    const PoseUpdate next = updates_[k];
    latest_ = std::max(latest_, next.pose);
    if (next.parts != kNoPart) {
      const double counted = keeping_.counts == nullptr ? 1.0 : keeping_.counts[next.pose];
      const CostedInnovation seen =
          use_pose(filter_, poses_, next, time_[k], counted, &out_, block(next.pose));
      out_.cost += counted * seen.cost;
      if (keeping_.poses) keep(seen, next, out_);
    }
    if (keeping_.poses && next.keeps) keep(filter_, next.pose, out_);
    if (keeping_.transitions && !updates_.one_a_pose()) {
      const double* x = filter_.state();
      out_.update_state.insert(out_.update_state.end(), x, x + kFilterStates);
    }
    if (keeping_.shares && keeping_.block != nullptr) take_share(keeping_.block[latest_], out_);
  }

  int block(int pose) const {
    if (keeping_.one_block) return 0;
    return keeping_.block == nullptr ? pose : keeping_.block[latest_];
  }

  LikelihoodFilter<N>& filter_;
  const PoseSeries& poses_;
  const PoseUpdates& updates_;
  const double* time_;
  const Keeping& keeping_;
  std::size_t gains_;
  FilterRun& out_;
  int latest_ = 0;  // pose so far: its block is that of the update
};

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
  const auto run = noise.oscillating() ? detail::innovations<kOscillatingStates>
                   : noise.coloured()  ? detail::innovations<kColouredStates>
                                       : detail::innovations<kFilterStates>;
  const detail::Keeping keeping{counts, block, true, repeatable, shares, false};
  return run(boat, trace, poses, noise, outlier, start, effects, slopes, keeping);
}

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

/// The number of states that all of these noises need, as a call with it as template argument.
template <class Call>
auto with_states(bool coloured, bool oscillating, Call call) {
  if (oscillating) return call(std::integral_constant<int, kOscillatingStates>{});
  if (coloured) return call(std::integral_constant<int, kColouredStates>{});
  return call(std::integral_constant<int, kFilterStates>{});
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
