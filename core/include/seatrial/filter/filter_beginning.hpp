// SPDX-License-Identifier: MIT
// Where the estimator's filter begins: at a pose, with a velocity, both as the sensor shows them.
#pragma once
#include <algorithm>
#include <cmath>
#include <iterator>

#include "seatrial/filter/filter_types.hpp"
#include "seatrial/filter/gauss_markov.hpp"
#include "seatrial/filter/noise_parameters.hpp"

namespace seatrial::detail {

/// Velocity over ground [m/s], earth-fixed, of the point that the sensor measures, in the state x
/// (6).
inline void measured_velocity(const Effects& effects, const double* x, double cosine, double sine,
                              double* out) {
  double arm[2];
  plane_to_earth(cosine, sine, x + 3, out);
  plane_to_earth(cosine, sine, effects.lever, arm);
  out[0] += effects.current[0] - x[5] * arm[1];
  out[1] += effects.current[1] + x[5] * arm[0];
}

/// Sets the state of a filter of N states, its covariance and sensitivities.
template <int N>
class FilterBeginning {
 public:
  /// spread: (3) standard deviation of the velocity [m/s, m/s, rad/s]; effects_at: first column of
  /// the effects among the parameters, -1 where they are none.
  FilterBeginning(const NoiseParameters& noise, const Effects& effects, const double* spread,
                  int effects_at)
      : noise_(noise), effects_(effects), effects_at_(effects_at) {
    std::copy(spread, spread + kAxes, spread_);
  }

  /// To a state (6), as certain as one pose and the start's velocity, with its position of
  /// time t [s]. Of position and heading the earlier one is where it starts.
  template <class State>
  void set(const double* state, double t, State& s) const {
    std::copy(state, state + kStates, s.x);
    std::fill(s.x + kStates, s.x + N, 0.0);
    for (int i = 0; i < N; ++i) {
      const double sigma = i < kPose           ? kPoseSpread * first_pose(i)
                           : i < kStates       ? spread_[i - kPose]
                           : i < kFilterStates ? noise_.disturbance(i - kStates)
                                               : noise_.colour((i - kFilterStates) % kPose);
      std::fill(s.p[i], s.p[i] + N, 0.0);
      s.p[i][i] = sigma * sigma;
      std::fill(std::begin(s.d[i]), std::end(s.d[i]), 0.0);
    }
    const double delay = effects_.position_delay - effects_.heading_delay;
    s.x[2] -= delay * s.x[5];  // when the position was measured
    take_off_effects(t, s);
    if (delay > 0.0) turn_back(delay, s);
    if (delay < 0.0) move_back(-delay, s);
  }

 private:
  /// Start at the position's time, `delay` [s] before the heading's: r adds to the heading's
  /// errors.
  template <class State>
  void turn_back(double delay, State& s) const {
    const double rate = spread_[2] * spread_[2];
    s.p[2][2] += delay * delay * rate;
    s.p[2][5] = s.p[5][2] = -delay * rate;
  }

  /// Start at the heading's time, `early` [s] before the position's: u and v add to its errors.
  template <class State>
  void move_back(double early, State& s) const {
    const double cosine = std::cos(s.x[2]);
    const double sine = std::sin(s.x[2]);
    const double slope[2][2] = {{-early * cosine, early * sine}, {-early * sine, -early * cosine}};
    for (int i = 0; i < 2; ++i) {
      for (int j = 0; j < 2; ++j) {
        s.x[i] += slope[i][j] * s.x[3 + j];
        s.p[i][3 + j] = s.p[3 + j][i] = slope[i][j] * spread_[j] * spread_[j];
      }
    }
    for (int i = 0; i < 2; ++i) {
      for (int j = 0; j < 2; ++j) {
        for (int k = 0; k < 2; ++k) {
          s.p[i][j] += slope[i][k] * slope[j][k] * spread_[k] * spread_[k];
        }
      }
    }
    s.x[2] -= early * s.x[5];
  }

  /// The start is that of the measured point and over ground: to the origin and through the water,
  /// in axes that drift with it for t [s].
  template <class State>
  void take_off_effects(double t, State& s) const {
    const double cosine = std::cos(s.x[2]);
    const double sine = std::sin(s.x[2]);
    const double* l = effects_.lever;
    const double* flow = effects_.current;
    double arm[2];
    double water[2];
    plane_to_earth(cosine, sine, l, arm);
    plane_to_body(cosine, sine, flow, water);
    for (int i = 0; i < 2; ++i) s.x[i] -= arm[i] + flow[i] * t;
    s.x[3] += s.x[5] * l[1] - water[0];
    s.x[4] -= s.x[5] * l[0] + water[1];
    double velocity[2];
    measured_velocity(effects_, s.x, cosine, sine, velocity);
    const double swing[2] = {s.x[5] * arm[1], -s.x[5] * arm[0]};
    const double* later = effects_.later;
    for (int i = 0; i < 2; ++i) s.x[i] += velocity[i] * later[0] + swing[i] * later[1];
    s.x[2] += s.x[5] * later[1];
    if (effects_at_ < 0) return;
    s.d[0][effects_at_ + kLever] = s.d[1][effects_at_ + kLever + 1] = -cosine;
    s.d[0][effects_at_ + kLever + 1] = sine;
    s.d[1][effects_at_ + kLever] = -sine;
    s.d[3][effects_at_ + kLever + 1] = s.x[5];
    s.d[4][effects_at_ + kLever] = -s.x[5];
    s.d[3][effects_at_ + kCurrent] = s.d[4][effects_at_ + kCurrent + 1] = -cosine;
    s.d[3][effects_at_ + kCurrent + 1] = -sine;
    s.d[4][effects_at_ + kCurrent] = sine;
    s.d[0][effects_at_ + kCurrent] = s.d[1][effects_at_ + kCurrent + 1] = -t;
    for (int i = 0; i < 2; ++i) {
      s.d[i][effects_at_ + kDelay] = velocity[i];
      s.d[i][effects_at_ + kDelay + 1] = swing[i];
    }
    s.d[2][effects_at_ + kDelay + 1] = s.x[5];
  }

  /// Standard deviation of one pose [m, m, rad].
  double first_pose(int i) const {
    return GaussMarkov<N>::kColoured ? std::hypot(noise_.white(i), noise_.colour(i))
                                     : noise_.white(i);
  }

  const NoiseParameters& noise_;
  const Effects& effects_;
  int effects_at_;
  double spread_[kAxes] = {};
};

}  // namespace seatrial::detail
