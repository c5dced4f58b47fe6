// SPDX-License-Identifier: MIT
// Runs of the filter along a recording: the likelihood that the estimator maximises, and its
// derivatives. Host side: uses heap.
//
// Without process noise the innovations are the simulation error of the whole recording; with much
// process noise each pose is a new start. The data decide.
#pragma once
#include <algorithm>
#include <cmath>
#include <vector>

#include "seatrial/filter/likelihood_filter.hpp"

namespace seatrial {

inline constexpr int kFilterChunk = 512;  // intervals that are scheduled at once

namespace detail {

/// Keeps an innovation.
inline void keep(const Innovation& seen, int k, FilterRun& out) {
  const auto at = static_cast<std::size_t>(k);
  std::copy(seen.e, seen.e + kPose, &out.innovation[at * kPose]);
  float* to = &out.spread[at * 6];
  for (int i = 0; i < kPose; ++i) {
    for (int j = i; j < kPose; ++j) *to++ = static_cast<float>(seen.s[i][j]);
  }
  out.weight[at] = static_cast<float>(seen.weight);
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

}  // namespace detail

namespace detail {

/// Jumps and restarts at pose k, before it is used.
template <int N>
void allow_jump(LikelihoodFilter<N>& filter, const PoseSeries& poses, int k) {
  const auto at = static_cast<std::ptrdiff_t>(k) * kPose;
  if (poses.use[k] == kJumped) filter.loosen(poses.eta + at, poses.time[k]);
  if (poses.use[k] == kGapped) filter.loosen_if_likelier(poses.eta + at, poses.time[k]);
  if (poses.use[k] == kBeginning) {
    filter.restart(poses.eta + at, poses.velocity + at, poses.time[k]);
  }
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

template <int N>
FilterRun innovations(Boat boat, const ThrustTrace& trace, const PoseSeries& poses,
                      const NoiseParameters& noise, double outlier, const FilterStart& start,
                      const Effects& effects, bool slopes, const double* counts, const int* block,
                      bool repeatable, bool shares) {
  LikelihoodFilter<N> filter(trace.columns(), noise, outlier, start, effects, slopes);
  const int p = filter.parameters();
  const auto n = static_cast<std::size_t>(poses.n);
  FilterRun out;
  out.parameters = p;
  out.effects = effects;
  out.information.assign(static_cast<std::size_t>(p) * static_cast<std::size_t>(p), 0.0);
  out.gradient.assign(static_cast<std::size_t>(p), 0.0);
  const auto blocks = block == nullptr ? n : static_cast<std::size_t>(block[poses.n - 1]) + 1;
  out.score.assign(blocks * static_cast<std::size_t>(p), 0.0);
  out.innovation.assign(n * kPose, std::nan(""));
  out.spread.assign(n * 6, std::nanf(""));
  out.state.assign(n * kFilterStates, std::nan(""));
  out.deviation.assign(n * kAxes, std::nanf(""));
  out.weight.assign(n, 0.0F);
  out.transition.reserve(repeatable ? n : 0);
  Transition unkept;
  for (int first = 0; first < poses.n; first += kFilterChunk) {
    const int last = std::min(poses.n - 1, first + kFilterChunk);
    const StepSchedule schedule(boat, trace, poses.time, first, last, true);
    for (int k = first; k < std::min(poses.n, first + kFilterChunk); ++k) {
      if (poses.use[k] != kNotMeasured) {
        allow_jump(filter, poses, k);
        const double counted = counts == nullptr ? 1.0 : counts[k];
        const CostedInnovation seen =
            filter.update(poses.eta + static_cast<std::ptrdiff_t>(k) * kPose, poses.time[k],
                          counted, &out, block == nullptr ? k : block[k]);
        out.cost += counted * seen.cost;
        keep(seen, k, out);
      }
      keep(filter, k, out);
      if (shares && block != nullptr) take_share(block[k], out);
      if (k == poses.n - 1) break;
      if (repeatable) out.transition.emplace_back();
      const double length = poses.time[k + 1] - poses.time[k];
      if (!filter.predict(schedule, k, boat, length, repeatable ? out.transition.back() : unkept)) {
        out.good = false;
        return out;
      }
    }
  }
  mirror(out.information.data(), p);
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
  return run(boat, trace, poses, noise, outlier, start, effects, slopes, counts, block, repeatable,
             shares);
}

namespace detail {

/// Columns of a filter that repeats a run: no parameters.
inline Columns no_parameters() {
  Columns none;
  none.n_initial = kStates;
  none.n_coefficients = kAxes;
  return none;
}

/// Uses pose k, which is to be used.
template <int N>
CostedInnovation use_pose(LikelihoodFilter<N>& filter, const PoseSeries& poses, int k) {
  allow_jump(filter, poses, k);
  return filter.update(poses.eta + static_cast<std::ptrdiff_t>(k) * kPose, poses.time[k]);
}

/// From pose k to the next, if there is one, linearised about the first run.
template <int N>
void follow(LikelihoodFilter<N>* filter, std::size_t filters, const NoiseParameters& noise,
            const FilterRun& first, const PoseSeries& poses, int k) {
  if (k == poses.n - 1) return;
  const auto at = static_cast<std::size_t>(k);
  const double* from = &first.state[at * kFilterStates];
  const Interval passed(noise, std::cos(from[2]), std::sin(from[2]),
                        poses.time[k + 1] - poses.time[k]);
  for (std::size_t i = 0; i < filters; ++i) filter[i].repeat(first.transition[at], from, passed);
}

}  // namespace detail

namespace detail {

template <int N>
double repeated(const FilterRun& first, const PoseSeries& poses, const NoiseParameters& noise,
                double outlier, const FilterStart& start) {
  const Columns none = no_parameters();
  LikelihoodFilter<N> again(none, noise, outlier, start, first.effects, false);
  double cost = 0.0;
  for (int k = 0; k < poses.n; ++k) {
    if (poses.use[k] != kNotMeasured) cost += use_pose(again, poses, k).cost;
    follow(&again, 1, noise, first, poses, k);
  }
  return cost;
}

}  // namespace detail

/// The cost of a run that is repeated with other noise, linearised about the first.
inline double repeated(const FilterRun& first, const PoseSeries& poses,
                       const NoiseParameters& noise, double outlier, const FilterStart& start) {
  const auto run = noise.oscillating() ? detail::repeated<kOscillatingStates>
                   : noise.coloured()  ? detail::repeated<kColouredStates>
                                       : detail::repeated<kFilterStates>;
  return run(first, poses, noise, outlier, start);
}

/// Half the cost's gradient and the Fisher information of the logarithms of the noise parameters.
struct NoiseDerivatives {
  double cost = 0.0;
  double gradient[kNoiseParameters] = {};
  double information[kNoiseParameters][kNoiseParameters] = {};
};

namespace detail {

/// Derivatives of innovations and of their covariance S to the noise parameters, one column each:
/// S^-1 dS and its transpose, S^-1 de and de. Fisher information is a product of columns.
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

template <int N>
NoiseDerivatives noise_slopes(const FilterRun& first, const PoseSeries& poses,
                              const NoiseParameters& noise, double outlier,
                              const FilterStart& start, unsigned active) {
  constexpr double kStep = 0.05;       // of a logarithm
  const auto step = [&noise](int i) {  // a resonance is sharp
    return i == kTurnParameter ? kStep / (1.0 + noise.colour_turn * noise.colour_memory) : kStep;
  };
  NoiseDerivatives out;
  const auto looked_at = [active](int i) { return ((active >> i) & 1U) != 0; };
  int place[kNoiseParameters];
  int m = 0;
  for (int i = 0; i < kNoiseParameters; ++i) {
    if (looked_at(i)) place[m++] = i;
  }
  const Columns none = no_parameters();
  LikelihoodFilter<N> base(none, noise, outlier, start, first.effects, false);
  std::vector<NoiseParameters> up(static_cast<std::size_t>(m), noise);
  std::vector<LikelihoodFilter<N>> moved;
  moved.reserve(up.size());
  std::vector<double> cost(up.size(), 0.0);
  for (std::size_t i = 0; i < up.size(); ++i) {
    up[i].parameter(place[i]) *= std::exp(step(place[i]));
    moved.emplace_back(none, up[i], outlier, start, first.effects, false);
  }
  double information[kNoiseParameters][kNoiseParameters] = {};
  NoiseColumns changes;
  for (int k = 0; k < poses.n; ++k) {
    if (poses.use[k] != kNotMeasured) {
      const CostedInnovation here = use_pose(base, poses, k);
      out.cost += here.cost;
      for (std::size_t i = 0; i < moved.size(); ++i) {
        const CostedInnovation there = use_pose(moved[i], poses, k);
        cost[i] += there.cost;
        changes.set(static_cast<int>(i), here, there, 1.0 / step(place[i]));
      }
      changes.inform(m, information);
    }
    follow(&base, 1, noise, first, poses, k);
    follow(moved.data(), moved.size(), noise, first, poses, k);
  }
  for (int i = 0; i < m; ++i) {
    const int a = place[i];
    for (int j = 0; j <= i; ++j) {
      out.information[a][place[j]] = out.information[place[j]][a] = information[i][j];
    }
    // the difference quotient less its second-order share
    const double rise = (cost[static_cast<std::size_t>(i)] - out.cost) / step(a);
    out.gradient[a] = 0.5 * rise - 0.5 * step(a) * out.information[a][a];
  }
  return out;
}

}  // namespace detail

/// Fisher's information of Gaussian innovations: tr(S^-1 dS_i S^-1 dS_j) / 2 + de_i' S^-1 de_j,
/// by differences of linearised runs. Bit i of `active`: parameter i is evaluated.
inline NoiseDerivatives noise_slopes(const FilterRun& first, const PoseSeries& poses,
                                     const NoiseParameters& noise, double outlier,
                                     const FilterStart& start, unsigned active = ~0U) {
  const auto run = noise.oscillating() ? detail::noise_slopes<kOscillatingStates>
                   : noise.coloured()  ? detail::noise_slopes<kColouredStates>
                                       : detail::noise_slopes<kFilterStates>;
  return run(first, poses, noise, outlier, start, active);
}

}  // namespace seatrial
