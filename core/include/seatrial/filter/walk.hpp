// SPDX-License-Identifier: MIT
// The filter along a recording, from one update to the next, and what it keeps of each pose. Host
// side: uses heap.
#pragma once
#include <algorithm>
#include <cassert>
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
    assert(poses.asynchronous_value != nullptr);
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
        if (keeping_.shares && keeping_.block != nullptr && ends_block(k, last)) {
          take_share(keeping_.block[latest_], out_);
        }
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
    filter_.add_input_error(updates_.input_error(k));
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
  }

  /// Whether update k is the last one of its block so far.
  bool ends_block(int k, int last) const {
    if (k + 1 == last) return true;
    return keeping_.block[std::max(latest_, updates_[k + 1].pose)] != keeping_.block[latest_];
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

/// The number of states that all of these noises need, as a call with it as template argument.
template <class Call>
auto with_states(bool coloured, bool oscillating, Call call) {
  if (oscillating) return call(std::integral_constant<int, kOscillatingStates>{});
  if (coloured) return call(std::integral_constant<int, kColouredStates>{});
  return call(std::integral_constant<int, kFilterStates>{});
}

}  // namespace detail

}  // namespace seatrial
