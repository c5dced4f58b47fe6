// SPDX-License-Identifier: MIT
// What fades in the estimator's filter between two poses and comes anew: the disturbance (3),
// accelerations that come and go with a time constant; where the noise has any, correlated errors
// of the poses (3); and, where these swing as waves make them, their other sides (3): each is a
// damped oscillation then, as in the models of wave-frequency motion in Fossen, Handbook of Marine
// Craft Hydrodynamics and Motion Control.
#pragma once
#include <algorithm>

#include "seatrial/filter/filter_types.hpp"

namespace seatrial::detail {

inline constexpr int kColouredStates = kFilterStates + kPose;
inline constexpr int kSwingingStates = kColouredStates + kPose;

/// The states behind the boat's. N: all, kFilterStates, kColouredStates or kSwingingStates.
template <int N>
class Fading {
 public:
  static constexpr bool kSwinging = N == kSwingingStates;
  static constexpr bool kColoured = N == kColouredStates || kSwinging;
  static_assert(N == kFilterStates || kColoured);

  /// An interval passes: how much of each is left, and how far what swings has swung.
  void pass(const FilterNoise& noise, const Interval& passed) {
    std::fill(stays_, stays_ + kAxes, passed.disturbance_after(noise.memory));
    if constexpr (kSwinging) {
      std::fill(stays_ + kAxes, stays_ + N - kStates, 1.0);
      swing_ = passed.swing_after(noise.colour_memory, noise.colour_turn);
    } else if constexpr (kColoured) {
      std::fill(stays_ + kAxes, stays_ + kAxes + kPose, passed.colour_after(noise.colour_memory));
    }
  }

  void carry(double (&x)[N]) const {
    for (int i = kStates; i < N; ++i) x[i] *= stays_[i - kStates];
    if constexpr (kSwinging) {
      for (int i = kFilterStates; i < kColouredStates; ++i) swing_.turn(x[i], x[i + kPose]);
    }
  }

  /// The first `parameters` columns of d state / d parameters.
  template <int P>
  void carry(double (&d)[N][P], int parameters) const {
    for (int i = kStates; i < N; ++i) {
      for (int c = 0; c < parameters; ++c) d[i][c] *= stays_[i - kStates];
    }
    if constexpr (kSwinging) {
      for (int i = kFilterStates; i < kColouredStates; ++i) {
        for (int c = 0; c < parameters; ++c) swing_.turn(d[i][c], d[i + kPose][c]);
      }
    }
  }

  /// Its rows and columns of the covariance. `fp`: the boat's rows of F P.
  void carry(const double (&fp)[kStates][N], double (&p)[N][N]) const {
    for (int i = 0; i < kStates; ++i) {
      for (int j = kStates; j < N; ++j) p[i][j] = p[j][i] = stays_[j - kStates] * fp[i][j];
    }
    for (int i = kStates; i < N; ++i) {
      for (int j = kStates; j < N; ++j) p[i][j] *= stays_[i - kStates] * stays_[j - kStates];
    }
    if constexpr (kSwinging) {
      for (int i = kFilterStates; i < kColouredStates; ++i) {
        for (int j = 0; j < N; ++j) swing_.turn(p[i][j], p[i + kPose][j]);
      }
      for (double(&row)[N] : p) {
        for (int i = kFilterStates; i < kColouredStates; ++i) swing_.turn(row[i], row[i + kPose]);
      }
      for (int i = kFilterStates; i < N; ++i) {  // as rounding has it on one side
        for (int j = 0; j < i; ++j) p[i][j] = p[j][i];
      }
    }
  }

  /// What came anew: the variances stay those of the noise.
  void renew(const FilterNoise& noise, double (&p)[N][N]) const {
    for (int a = 0; a < kAxes; ++a) {
      renew(kStates + a, noise.disturbance(a), p);
      if constexpr (kSwinging) {
        renew_swing(kFilterStates + a, noise.colour(a), p);
      } else if constexpr (kColoured) {
        renew(kFilterStates + a, noise.colour(a), p);
      }
    }
  }

 private:
  void renew(int i, double sigma, double (&p)[N][N]) const {
    const double stays = stays_[i - kStates];
    p[i][i] += sigma * sigma * (1.0 - stays * stays);
  }

  void renew_swing(int i, double sigma, double (&p)[N][N]) const {
    const double variance = sigma * sigma;
    p[i][i] += variance * swing_.new_error();
    p[i + kPose][i + kPose] += variance * swing_.new_other();
    p[i][i + kPose] += variance * swing_.new_both();
    p[i + kPose][i] = p[i][i + kPose];
  }

  double stays_[N - kStates] = {};  // what is left of each after the interval
  Swing swing_;                     // what is left of errors that swing
};

}  // namespace seatrial::detail
