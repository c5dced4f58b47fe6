// SPDX-License-Identifier: MIT
// Prediction step of the extended Kalman filter: the same for the estimator and on board. No heap,
// no exceptions.
//
//   x <- f(x)    P <- F P F' + Q    D <- F D + G
//
// f is the model's own step, F its exact derivative. D are the columns that are carried along (see
// filter_state.hpp); what they gain over a step, G, is up to `carried`.
#pragma once
#include <algorithm>
#include <cmath>

#include "seatrial/filter/gauss_markov.hpp"

namespace seatrial {

/// Parts of a steady wind, earth-fixed, two each: acceleration [m/s^2]; moment [rad/s^2], of which
/// the part across the boat turns it; acceleration [m/s^2] that sway has beyond that of the first,
/// as side area over mass differs from frontal area over mass.
inline constexpr int kWindParts = 6;

/// Accelerations beside the model's: disturbance, trim and wind. An earth-fixed one is turned to
/// the heading in the middle of the interval.
struct Disturbing {
  /// x: the state before; length [s]; bias (3) body-fixed; wind (kWindParts); earth: whether the
  /// disturbance in surge and sway is earth-fixed.
  Disturbing(const double* x, double length, const double* bias, const double* wind, bool earth)
      : earth(earth), half(0.5 * length) {
    const double w[2] = {wind[0] + (earth ? x[kStates] : 0.0),
                         wind[1] + (earth ? x[kStates + 1] : 0.0)};
    const double middle = x[2] + 0.5 * length * x[5];
    cos = std::cos(middle);
    sin = std::sin(middle);
    plane_to_body(cos, sin, w, turned);
    double moment[2];
    double side[2];
    plane_to_body(cos, sin, wind + 2, moment);
    plane_to_body(cos, sin, wind + 4, side);
    turning[0] = turned[1];
    turning[1] = -turned[0] - side[0];
    turning[2] = -moment[0];
    turned[1] += side[1];
    turned[2] = moment[1];
    for (int a = 0; a < kAxes; ++a) {
      const double own = earth && a < 2 ? 0.0 : x[kStates + a];
      total[a] = own + bias[a] + turned[a];
    }
  }

  /// F of the boat's states, from the sensitivities of the model's step. `force`: the first of the
  /// disturbance's columns among them.
  void slopes(const StateSensitivities& dx, int force, MotionSlopes& f) const {
    for (int i = 0; i < kStates; ++i) {
      std::copy(dx.row[i] + 2, dx.row[i] + kStates, f[i]);
      const double* push = dx.row[i] + force;
      std::copy(push, push + kAxes, f[i] + kStates - 2);
      const double bend = push[0] * turning[0] + push[1] * turning[1] + push[2] * turning[2];
      f[i][0] += bend;  // a turn of the boat turns what is earth-fixed on it
      f[i][3] += half * bend;
      if (earth) plane_to_earth(cos, sin, push, f[i] + kStates - 2);
    }
  }

  bool earth;
  double half;       // [s] of the interval
  double cos = 1.0;  // of the heading in its middle
  double sin = 0.0;
  double turned[kAxes] = {};   // the earth-fixed part in body axes
  double turning[kAxes] = {};  // its derivative to the heading
  double total[kAxes] = {};    // [m/s^2, m/s^2, rad/s^2] in body axes
};

namespace detail {

/// F less the identity, as the covariance takes it: that keeps its digits.
inline void less_identity(MotionSlopes& f) {
  for (int i = 2; i < kStates; ++i) f[i][i - 2] -= 1.0;
}

/// D <- F D + G of the first `count` columns; F with its identity. `gain(i, row)` writes row i of
/// G.
template <int N, class State, class Gain>
void carry_columns(const MotionSlopes& f, const GaussMarkov<N>& others, int count, Gain gain,
                   State& b) {
  double gained[kStates][State::kColumns];
  for (int i = 0; i < kStates; ++i) gain(i, gained[i]);
  double slope[kStates][kMoving];
  for (int i = 0; i < kStates; ++i) std::copy(f[i], f[i] + kMoving, slope[i]);
  // column by column: all that F takes is read before its rows are written
  for (int c = 0; c < count; ++c) {
    double before[kMoving];
    for (int j = 0; j < kMoving; ++j) before[j] = b.d[j + 2][c];
    for (int i = 0; i < kStates; ++i) {
      double sum = gained[i][c];
      if (i < 2) sum += b.d[i][c];
      for (int j = 0; j < kMoving; ++j) sum += slope[i][j] * before[j];
      b.d[i][c] = sum;
    }
  }
  others.carry_columns(b.d, count);
}

/// P <- F P F'; F less its identity.
template <int N, class State>
void carry_covariance(const MotionSlopes& f, const GaussMarkov<N>& others, State& b) {
  double fp[kStates][N];
  for (int i = 0; i < kStates; ++i) {
    std::copy(b.p[i], b.p[i] + N, fp[i]);
    for (int m = 0; m < kMoving; ++m) {
      for (int j = 0; j < N; ++j) fp[i][j] += f[i][m] * b.p[m + 2][j];
    }
  }
  for (int i = 0; i < kStates; ++i) {
    for (int j = i; j < kStates; ++j) {
      double sum = fp[i][j];
      for (int m = 0; m < kMoving; ++m) sum += fp[i][m + 2] * f[j][m];
      b.p[i][j] = b.p[j][i] = sum;
    }
  }
  others.carry_covariance(fp, b.p);
}

/// P += Q: the random walk of the velocity, integrated into the pose, and the Gauss-Markov states'.
template <int N, class State>
void add_process_noise(const NoiseParameters& noise, const Interval& passed,
                       const GaussMarkov<N>& others, State& b) {
  const double length = passed.length;
  double q[kAxes];
  double spread[kPose];
  for (int a = 0; a < kAxes; ++a) {
    q[a] = noise.walk(a) * noise.walk(a) * length;
    b.p[3 + a][3 + a] += q[a];
    spread[a] = q[a] * length * length / 3.0;
  }
  // unequal walks of surge and sway spread the position unequally in the boat's directions
  const double unequal = spread[1] - spread[0];
  spread[0] += passed.sin * passed.sin * unequal;
  spread[1] -= passed.sin * passed.sin * unequal;
  for (int i = 0; i < kPose; ++i) b.p[i][i] += spread[i];
  b.p[0][1] -= passed.cos * passed.sin * unequal;
  b.p[1][0] = b.p[0][1];
  others.add_noise(noise, b.p);
  const double half = length * length / 2.0;
  const double ahead = noise.walk(0) * noise.walk(0) * half;
  const double across = noise.walk(1) * noise.walk(1) * half;
  const double turn = noise.walk(2) * noise.walk(2) * half;
  const double cross[kPose][kAxes] = {{ahead * passed.cos, -across * passed.sin, 0.0},
                                      {ahead * passed.sin, across * passed.cos, 0.0},
                                      {0.0, 0.0, turn}};
  for (int i = 0; i < kPose; ++i) {
    for (int a = 0; a < kAxes; ++a) {
      b.p[i][3 + a] += cross[i][a];
      b.p[3 + a][i] += cross[i][a];
    }
  }
}

}  // namespace detail

/// One prediction. N: states in use. `move(x, dx)`: the model's step with its sensitivities, of
/// which `columns` are the boat's states and, last of the coefficients, the disturbance. `carried`:
/// what the columns D are, `columns(...)` carries them and `covariance(...)` adds what they give P.
/// `f`: takes F less the identity. False where the boat diverged.
template <int N, class State, class Move, class Carried>
bool ekf_predict(const Columns& columns, const Disturbing& disturbing, const Interval& passed,
                 const NoiseParameters& noise, Move move, const Carried& carried, MotionSlopes& f,
                 State& b) {
  // the mean, by the model
  StateSensitivities dx;
  seed(columns, dx);
  if (!move(b.x, dx)) return false;
  const GaussMarkov<N> others(noise, passed);
  others.carry_mean(b.x);
  // its derivative F
  const int force = kStates + columns.n_coefficients - kAxes;
  disturbing.slopes(dx, force, f);
  // the columns that are carried along
  carried.template columns<N>(dx, force, disturbing, f, others, b);
  // the covariance
  detail::less_identity(f);
  detail::carry_covariance<N>(f, others, b);
  carried.template covariance<N>(f, b);
  detail::add_process_noise<N>(noise, passed, others, b);
  return true;
}

}  // namespace seatrial
