// SPDX-License-Identifier: MIT
// Fixed-interval smoother: the state at every pose, from the poses before and after it. The filter
// forward, then the modified Bryson-Frazier recursion backward (Bierman, "Fixed interval smoothing
// with discrete measurements", 1973), which equals that of Rauch, Tung and Striebel and inverts no
// covariance. Linearised about a first run of the filter. Host side: uses heap.
//
//   l <- (I - K H)' l - H' S^-1 e    L <- (I - K H)' L (I - K H) + H' S^-1 H    at a pose
//   l <- F' l                        L <- F' L F                                to the one before
//   x - P l                          P - P L P                                  smoothed
#pragma once
#include <algorithm>
#include <cmath>
#include <vector>

#include "seatrial/filter/relinearised_run.hpp"

namespace seatrial {

/// Smoothed states of a run.
struct SmootherRun {
  std::vector<double> state;     // (n, 9)
  std::vector<float> deviation;  // (n, 3) standard deviations of the velocity
};

namespace detail {

inline constexpr int kSmootherChunk = 512;  // poses whose filter states are kept at once

/// What the backward recursion needs of one pose.
template <int N>
struct SmootherPose {
  double x[N];     // after the pose was used
  double p[N][N];  // the same
  double gain[N][kPose] = {};
  double inverse[kPose][kPose] = {};  // S^-1, less for an outlier
  double e[kPose] = {};
  Measurement y{nullptr};  // its H
  bool used = false;
  bool jumped = false;  // nothing of these parts before it is known here
  bool began = false;   // nothing of the state before it
};

/// l and L of the file's head.
template <int N>
struct Adjoint {
  double l[N] = {};
  double m[N][N] = {};
};

/// H of a pose: its own state, a share of the heading, and coloured noise.
template <int N>
void measurement_rows(const Measurement& y, double (&h)[kPose][N]) {
  for (int i = 0; i < kPose; ++i) {
    std::fill(h[i], h[i] + N, 0.0);
    if (!has(y.parts, i)) continue;
    h[i][measured_state(y.parts, i)] = 1.0;
    h[i][2] += y.turn[i];
    if constexpr (N > kFilterStates) {
      if (has_colour(y.parts, i)) h[i][kFilterStates + i] = 1.0;
    }
  }
}

/// Uses parts of a pose, of time t [s], and keeps what the way back needs.
template <int N>
SmootherPose<N> forward_pose(LikelihoodFilter<N>& filter, const Effects& effects,
                             const PoseSeries& poses, const PoseUpdate& next, double t) {
  SmootherPose<N> out;
  out.y.parts = next.parts;
  if (next.parts != kNoPart) {
    out.jumped = allow_jump(filter, poses, next, t);
    out.began = poses.use[next.pose] == kBeginning && next.first;
    const auto before = filter.filter();
    const CostedInnovation seen = filter.update(Measured(poses, next).seen, t);
    const double* lever = effects.lever;
    double arm[2];
    plane_to_earth(std::cos(before.x[2]), std::sin(before.x[2]), lever, arm);
    out.y.turn[0] = -arm[1];
    out.y.turn[1] = arm[0];
    double hp[kPose][N];
    measured_covariance<N>(out.y, before, hp);
    leave_out(next.parts, hp);
    out.used = true;
    const double less = seen.weight * seen.weight;
    for (int i = 0; i < kPose; ++i) {
      out.e[i] = seen.e[i];
      for (int j = 0; j < kPose; ++j) out.inverse[i][j] = less * seen.inverse[i][j];
    }
    for (int a = 0; a < N; ++a) {
      for (int j = 0; j < kPose; ++j) {
        for (int i = 0; i < kPose; ++i) out.gain[a][j] += hp[i][a] * out.inverse[i][j];
      }
    }
  }
  std::copy(filter.filter().x, filter.filter().x + N, out.x);
  std::copy(&filter.filter().p[0][0], &filter.filter().p[0][0] + N * N, &out.p[0][0]);
  return out;
}

/// l <- F' l, L <- F' L F.
template <int N>
void through(const double (&f)[N][N], Adjoint<N>& a) {
  double l[N] = {};
  double mf[N][N] = {};
  for (int i = 0; i < N; ++i) {
    for (int k = 0; k < N; ++k) {
      l[k] += f[i][k] * a.l[i];
      const double own = a.m[i][k];
      for (int j = 0; j < N; ++j) mf[i][j] += own * f[k][j];
    }
  }
  std::copy(l, l + N, a.l);
  for (int i = 0; i < N; ++i) std::fill(a.m[i], a.m[i] + N, 0.0);
  for (int k = 0; k < N; ++k) {
    for (int i = 0; i < N; ++i) {
      const double own = f[k][i];
      if (own == 0.0) continue;
      for (int j = 0; j < N; ++j) a.m[i][j] += own * mf[k][j];
    }
  }
}

/// Back over the use of a pose.
template <int N>
void backward_pose(const SmootherPose<N>& at, Adjoint<N>& a) {
  if (at.began) {
    a = Adjoint<N>{};
    return;
  }
  if (!at.used) return;
  double h[kPose][N];
  measurement_rows<N>(at.y, h);
  double stays[N][N];  // I - K H
  for (int i = 0; i < N; ++i) {
    for (int j = 0; j < N; ++j) {
      stays[i][j] = (i == j ? 1.0 : 0.0) - at.gain[i][0] * h[0][j] - at.gain[i][1] * h[1][j] -
                    at.gain[i][2] * h[2][j];
    }
  }
  through<N>(stays, a);
  for (int i = 0; i < N; ++i) {
    double row[kPose];  // H' S^-1
    for (int k = 0; k < kPose; ++k) {
      row[k] = h[0][i] * at.inverse[0][k] + h[1][i] * at.inverse[1][k] + h[2][i] * at.inverse[2][k];
      a.l[i] -= row[k] * at.e[k];
    }
    for (int j = 0; j < N; ++j) {
      a.m[i][j] += row[0] * h[0][j] + row[1] * h[1][j] + row[2] * h[2][j];
    }
  }
  if (!at.jumped) return;
  for (int i = 0; i < kPose; ++i) {
    if (!has(at.y.parts, i)) continue;
    a.l[i] = 0.0;
    for (int j = 0; j < N; ++j) a.m[i][j] = a.m[j][i] = 0.0;
  }
}

/// F of all states.
template <int N>
void whole_transition(const Transition& kept, const GaussMarkov<N>& others, double (&f)[N][N]) {
  for (int i = 0; i < N; ++i) {
    std::fill(f[i], f[i] + N, 0.0);
    f[i][i] = 1.0;
  }
  others.carry_columns(f, N);
  for (int i = 0; i < kStates; ++i) {
    for (int j = 0; j < kMoving; ++j) f[i][j + 2] += static_cast<double>(kept.slope[i][j]);
  }
}

/// Keeps the smoothed state at pose k.
template <int N>
void keep(const SmootherPose<N>& at, const Adjoint<N>& a, int k, SmootherRun& out) {
  double* state = &out.state[static_cast<std::size_t>(k) * kFilterStates];
  float* deviation = &out.deviation[static_cast<std::size_t>(k) * kAxes];
  for (int i = 0; i < kFilterStates; ++i) {
    state[i] = at.x[i];
    for (int j = 0; j < N; ++j) state[i] -= at.p[i][j] * a.l[j];
  }
  for (int axis = 0; axis < kAxes; ++axis) {
    const double* row = at.p[kPose + axis];
    double less = 0.0;
    for (int i = 0; i < N; ++i) {
      for (int j = 0; j < N; ++j) less += row[i] * a.m[i][j] * row[j];
    }
    const double variance = std::max(0.0, row[kPose + axis] - less);
    deviation[axis] = static_cast<float>(std::sqrt(variance));
  }
}

template <int N>
SmootherRun smoothed(const FilterRun& first, const PoseSeries& poses, const NoiseParameters& noise,
                     double outlier, const FilterStart& start) {
  // forward: the filter at the begin of every chunk
  const Columns none = columns_of(0);
  const Repetition repetition(first, poses, nullptr, false);
  const PoseUpdates& updates = repetition.updates();
  LikelihoodFilter<N> filter(none, noise, outlier, start, repetition.effects(), false);
  std::vector<LikelihoodFilter<N>> begins;
  for (int k = 0; k < updates.n(); ++k) {
    if (k % kSmootherChunk == 0) begins.push_back(filter);
    const PoseUpdate next = updates[k];
    if (next.parts != kNoPart) use_pose(filter, poses, next, updates.time()[k]);
    repetition.follow(&filter, 1, noise, k);
  }
  // backward: chunk by chunk, each forward again
  SmootherRun out;
  out.state.resize(static_cast<std::size_t>(poses.n) * kFilterStates);
  out.deviation.resize(static_cast<std::size_t>(poses.n) * kAxes);
  Adjoint<N> a;
  std::vector<SmootherPose<N>> kept;
  for (auto chunk = static_cast<int>(begins.size()) - 1; chunk >= 0; --chunk) {
    LikelihoodFilter<N> again(begins[static_cast<std::size_t>(chunk)]);
    const int from = chunk * kSmootherChunk;
    const int to = std::min(updates.n(), from + kSmootherChunk);
    kept.clear();
    for (int k = from; k < to; ++k) {
      kept.push_back(
          forward_pose(again, repetition.effects(), poses, updates[k], updates.time()[k]));
      repetition.follow(&again, 1, noise, k);
    }
    for (int k = to - 1; k >= from; --k) {
      const SmootherPose<N>& at = kept[static_cast<std::size_t>(k - from)];
      if (updates[k].keeps) keep(at, a, updates[k].pose, out);
      backward_pose(at, a);
      if (k == 0) break;
      double f[N][N];
      whole_transition<N>(repetition.transition(k - 1),
                          GaussMarkov<N>(noise, repetition.interval(noise, k - 1)), f);
      through<N>(f, a);
    }
  }
  return out;
}

}  // namespace detail

/// The smoothed states of a first run that kept its transitions, with this noise.
inline SmootherRun smoothed(const FilterRun& first, const PoseSeries& poses,
                            const NoiseParameters& noise, double outlier,
                            const FilterStart& start) {
  return detail::with_states(noise.coloured(), noise.oscillating(), [&](auto states) {
    return detail::smoothed<states()>(first, poses, noise, outlier, start);
  });
}

}  // namespace seatrial
