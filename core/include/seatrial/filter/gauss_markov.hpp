// SPDX-License-Identifier: MIT
// Gauss-Markov states of the filter, behind those of the boat: the disturbance (3), where the noise
// has any coloured pose noise (3), and where that oscillates its quadrature states (3). Each
// oscillating component is the damped oscillator of wave-frequency motion in Fossen, Handbook of
// Marine Craft Hydrodynamics and Motion Control. No heap, no exceptions.
#pragma once
#include <algorithm>
#include <cmath>

#include "seatrial/filter/filter_state.hpp"
#include "seatrial/filter/noise_parameters.hpp"

namespace seatrial {

/// An interval of `length` [s] at a heading of cosine c and sine s. It keeps the transitions of one
/// noise's Gauss-Markov states, so that filters of nearly the same noise share them.
class Interval {
 public:
  Interval(const NoiseParameters& noise, double c, double s, double length)
      : length(length),
        cos(c),
        sin(s),
        memory_(noise.memory),
        decay_(std::exp(-length / noise.memory)),
        coloured_(noise.coloured()),
        oscillating_(noise.oscillating()),
        colour_memory_(noise.colour_memory),
        colour_decay_(coloured_ ? std::exp(-length / noise.colour_memory) : 0.0),
        colour_turn_(noise.colour_turn),
        oscillator_(oscillating_ ? Oscillator(noise.colour_memory, noise.colour_turn, length)
                                 : Oscillator()) {}

  /// exp(-length / tau) of the disturbance's time constant tau [s].
  double disturbance_decay(double tau) const {
    return tau == memory_ ? decay_ : std::exp(-length / tau);
  }
  /// The same of the coloured pose noise.
  double colour_decay(double tau) const {
    return coloured_ && tau == colour_memory_ ? colour_decay_ : std::exp(-length / tau);
  }
  /// The transition of pose noise that oscillates at `turn` [rad/s].
  Oscillator oscillator(double tau, double turn) const {
    const bool kept = oscillating_ && tau == colour_memory_ && turn == colour_turn_;
    return kept ? oscillator_ : Oscillator(tau, turn, length);
  }

  double length;  // [s]
  double cos, sin;

 private:
  double memory_, decay_;
  bool coloured_, oscillating_;
  double colour_memory_, colour_decay_;
  double colour_turn_;
  Oscillator oscillator_;
};

/// Transition of the states behind the boat's over an interval. N: all states, kFilterStates,
/// kColouredStates or kOscillatingStates.
template <int N>
class GaussMarkov {
 public:
  static constexpr bool kOscillates = N == kOscillatingStates;
  static constexpr bool kColoured = N == kColouredStates || kOscillates;
  static_assert(N == kFilterStates || kColoured);

  GaussMarkov(const NoiseParameters& noise, const Interval& passed) {
    std::fill(decay_, decay_ + kAxes, passed.disturbance_decay(noise.memory));
    if constexpr (kOscillates) {
      std::fill(decay_ + kAxes, decay_ + N - kStates, 1.0);
      oscillator_ = passed.oscillator(noise.colour_memory, noise.colour_turn);
    } else if constexpr (kColoured) {
      std::fill(decay_ + kAxes, decay_ + kAxes + kPose, passed.colour_decay(noise.colour_memory));
    }
  }

  /// x <- F x.
  void carry_mean(double* x) const {
    for (int i = kStates; i < N; ++i) x[i] *= decay_[i - kStates];
    if constexpr (kOscillates) {
      for (int i = kFilterStates; i < kColouredStates; ++i) oscillator_.turn(x[i], x[i + kPose]);
    }
  }

  /// D <- F D of the first `count` columns.
  template <int C>
  void carry_columns(double (*d)[C], int count) const {
    for (int i = kStates; i < N; ++i) {
      for (int c = 0; c < count; ++c) d[i][c] *= decay_[i - kStates];
    }
    if constexpr (kOscillates) {
      for (int i = kFilterStates; i < kColouredStates; ++i) {
        for (int c = 0; c < count; ++c) oscillator_.turn(d[i][c], d[i + kPose][c]);
      }
    }
  }

  /// Their rows and columns of P <- F P F'. `fp`: the boat's rows of F P.
  template <int W>
  void carry_covariance(const double (&fp)[kStates][N], double (&p)[W][W]) const {
    for (int i = 0; i < kStates; ++i) {
      for (int j = kStates; j < N; ++j) p[i][j] = p[j][i] = decay_[j - kStates] * fp[i][j];
    }
    for (int i = kStates; i < N; ++i) {
      for (int j = kStates; j < N; ++j) p[i][j] *= decay_[i - kStates] * decay_[j - kStates];
    }
    if constexpr (kOscillates) {
      for (int i = kFilterStates; i < kColouredStates; ++i) {
        for (int j = 0; j < N; ++j) oscillator_.turn(p[i][j], p[i + kPose][j]);
      }
      for (int j = 0; j < N; ++j) {
        for (int i = kFilterStates; i < kColouredStates; ++i) {
          oscillator_.turn(p[j][i], p[j][i + kPose]);
        }
      }
      for (int i = kFilterStates; i < N; ++i) {  // rounding made it unsymmetric
        for (int j = 0; j < i; ++j) p[i][j] = p[j][i];
      }
    }
  }

  /// P += Q: the stationary variances stay those of the noise.
  template <int W>
  void add_noise(const NoiseParameters& noise, double (&p)[W][W]) const {
    for (int a = 0; a < kAxes; ++a) {
      add_noise(kStates + a, noise.disturbance(a), p);
      if constexpr (kOscillates) {
        add_oscillator_noise(kFilterStates + a, noise.colour(a), p);
      } else if constexpr (kColoured) {
        add_noise(kFilterStates + a, noise.colour(a), p);
      }
    }
  }

 private:
  template <int W>
  void add_noise(int i, double sigma, double (&p)[W][W]) const {
    const double decay = decay_[i - kStates];
    p[i][i] += sigma * sigma * (1.0 - decay * decay);
  }

  template <int W>
  void add_oscillator_noise(int i, double sigma, double (&p)[W][W]) const {
    const double variance = sigma * sigma;
    p[i][i] += variance * oscillator_.noise_error();
    p[i + kPose][i + kPose] += variance * oscillator_.noise_other();
    p[i][i + kPose] += variance * oscillator_.noise_both();
    p[i + kPose][i] = p[i][i + kPose];
  }

  double decay_[N - kStates] = {};
  Oscillator oscillator_;
};

}  // namespace seatrial
