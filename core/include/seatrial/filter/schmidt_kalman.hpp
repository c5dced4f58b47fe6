// SPDX-License-Identifier: MIT
// Schmidt-Kalman filter: errors of the model's parameters that the filter considers but does not
// estimate (Schmidt, "Application of state-space methods to navigation problems", 1966), and their
// effect on thrusters and boat. No heap, no exceptions.
#pragma once
#include <algorithm>

#include "seatrial/filter/ekf_predict.hpp"

namespace seatrial {

inline constexpr int kMostConsidered = 12;

/// Loadings: effects of independent errors of unit variance, the principal errors.
using Loadings = double[kMostConsidered];

/// Error (truth less model) of each parameter by each of n principal errors; the rest are zero.
struct PrincipalErrors {
  int n = 0;
  Loadings coefficient[kMaxCoefficients] = {};
  Loadings constant[kMaxConstants] = {};
};

/// Errors of the thrusters: `Thrust` differentiated to the principal errors.
struct ThrustErrors {
  Loadings target[kMaxActuators] = {};
  Loadings away[kMaxActuators] = {};  // of level less target
  Loadings multiplier[kMaxActuators] = {};
};

namespace detail {

inline constexpr double kImpulse =
    0.02;  // [s] over which the error of a jump's time acts without a lag

inline void add_loadings(double share, const Loadings& from, Loadings& to) {
  for (int i = 0; i < kMostConsidered; ++i) to[i] += share * from[i];
}

/// to += sum of slope_i times the error of constant i.
inline void add_constants(const PrincipalErrors& d, const double* slope, int n, Loadings& to) {
  for (int i = 0; i < n; ++i) {
    if (slope[i] != 0.0) add_loadings(slope[i], d.constant[i], to);
  }
}

}  // namespace detail

/// Actuator k gets a new target in place of `old`; `slope` (n_constants): its derivatives to the
/// constants. The level is continuous but for the error of the time of the change.
inline void retarget(const Chain& c, const double* q, const PrincipalErrors& d, int k, double old,
                     double target, const double* slope, ThrustErrors& e) {
  const Actuator& a = c.actuators[k];
  const double lag = detail::constant(q, a.lag, 0.0);
  const bool lags = !follows_at_once(c, q, k);
  Loadings fresh = {};
  detail::add_constants(d, slope, c.n_constants, fresh);
  for (int i = 0; i < kMostConsidered; ++i) {
    if (lags) e.away[k][i] += e.target[k][i] - fresh[i];
    e.target[k][i] = fresh[i];
  }
  if (a.latency < 0) return;
  const double rate = rate_limit(c, q, k);
  double speed = (old - target) / (lag > kShortestLag ? lag : detail::kImpulse);  // [1/s]
  if (rate > 0.0) speed = std::clamp(speed, -rate, rate);
  detail::add_loadings(speed, d.constant[a.latency], e.away[k]);
}

/// `lag_decays` with the decay of errors and derivatives to the lag.
struct ErrorDecay {
  LagDecay left;            // of an error of the level
  double mean = 0.0;        // of `left` over the step
  double mean_slope = 0.0;  // to the lag [1/s], of the level's distance to its target
  double end_slope = 0.0;
};

inline void error_decays(const Chain& c, const double* q, double h, LagDecay* decays,
                         ErrorDecay* out) {
  for (int k = 0; k < c.n_actuators(); ++k) {
    const double rate = rate_limit(c, q, k);
    if (rate > 0.0) {
      decays[k] = {0.0, 0.0, 0.0, rate, detail::constant(q, c.actuators[k].lag, 0.0), h};
      out[k] = ErrorDecay{};
      continue;
    }
    if (k > 0 && c.actuators[k].lag == c.actuators[k - 1].lag && decays[k - 1].rate == 0.0) {
      decays[k] = decays[k - 1];
      out[k] = out[k - 1];
      continue;
    }
    const double lag = detail::constant(q, c.actuators[k].lag, 0.0);
    const bool lags = lag > kShortestLag;
    const double time = lags ? lag : detail::kImpulse;
    LagDecay slope;
    ErrorDecay& e = out[k];
    e = ErrorDecay{};
    e.left = lag_decay(h / time, &slope);
    e.mean = (e.left.begin + 4.0 * e.left.middle + e.left.end) / 6.0;
    decays[k] = lags ? e.left : LagDecay{};
    if (!lags) continue;
    const double dx = -h / (lag * lag);
    e.mean_slope = dx * (slope.begin + 4.0 * slope.middle + slope.end) / 6.0;
    e.end_slope = dx * slope.end;
  }
}

namespace detail {

/// An actuator with a rate limit: mean level over a step, its mean error (moved), and e.away at the
/// step's end.
inline double limited_errors(const Actuator& a, const PrincipalErrors& d, const LagDecay& step,
                             double target, double start, int k, ThrustErrors& e, Loadings& moved) {
  const Distance middle = rate_limited(start, step.rate, step.lag, 0.5 * step.step);
  const Distance end = rate_limited(start, step.rate, step.lag, step.step);
  const auto mean = [](double begin, double half, double full) {
    return (begin + 4.0 * half + full) / 6.0;
  };
  const Loadings& rate = d.constant[a.slew_rate];
  const double unit = slew_unit(a);
  const Loadings none = {};
  const Loadings& lag = a.lag >= 0 ? d.constant[a.lag] : none;
  for (int i = 0; i < kMostConsidered; ++i) {
    moved[i] = e.target[k][i] + e.away[k][i] * mean(1.0, middle.dstart, end.dstart) +
               unit * rate[i] * mean(0.0, middle.drate, end.drate) +
               lag[i] * mean(0.0, middle.dlag, end.dlag);
    e.away[k][i] = e.away[k][i] * end.dstart + unit * rate[i] * end.drate + lag[i] * end.dlag;
  }
  return target + mean(start, middle.left, end.left);
}

}  // namespace detail

/// Mean errors of the generalised forces over a step; the thrusters' errors move to its end. To be
/// called before the thrust itself is moved.
inline void force_errors(const Chain& c, const PrincipalErrors& d, const LagDecay* decays,
                         const ErrorDecay* lag_decays, const Thrust& f, ThrustErrors& e,
                         Loadings force[kMaxForces]) {
  const Loadings none = {};
  double mean[kMaxActuators];
  Loadings output[kMaxActuators];
  for (int k = 0; k < c.n_actuators(); ++k) {
    const std::int8_t own = c.actuators[k].lag;
    const Loadings& lag = own >= 0 ? d.constant[own] : none;
    const double away = f.level[k] - f.target[k];
    const LagDecay& left = decays[k];
    double level = f.target[k] + away * (left.begin + 4.0 * left.middle + left.end) / 6.0;
    Loadings moved;
    if (left.rate > 0.0) {
      level = detail::limited_errors(c.actuators[k], d, left, f.target[k], away, k, e, moved);
    } else {
      for (int i = 0; i < kMostConsidered; ++i) {
        moved[i] = e.target[k][i] + e.away[k][i] * lag_decays[k].mean +
                   away * lag_decays[k].mean_slope * lag[i];
        e.away[k][i] =
            e.away[k][i] * lag_decays[k].left.end + away * lag_decays[k].end_slope * lag[i];
      }
    }
    mean[k] = f.multiplier[k] * level;
    for (int i = 0; i < kMostConsidered; ++i) {
      output[k][i] = f.multiplier[k] * moved[i] + e.multiplier[k][i] * level;
    }
  }
  mix_slopes(c, mean, output, kMostConsidered, force);
}

/// Accelerations by the principal errors in a step's middle, at a given velocity.
inline bool acceleration_errors(const Structure& s, const double* coefficient,
                                const PrincipalErrors& d, const double* nu, const double* force,
                                const Loadings force_error[kMaxForces], Loadings out[kAxes]) {
  AccelerationJacobian j;
  double nu_dot[kAxes];
  if (!acceleration_with_jacobian(s, coefficient, nu, force, nu_dot, j)) return false;
  for (int a = 0; a < kAxes; ++a) {
    std::fill(out[a], out[a] + kMostConsidered, 0.0);
    for (int i = 0; i < s.n_coefficients; ++i) {
      if (j.coefficient[a][i] != 0.0)
        detail::add_loadings(j.coefficient[a][i], d.coefficient[i], out[a]);
    }
    for (int i = 0; i < s.n_forces; ++i)
      detail::add_loadings(j.force[a][i], force_error[i], out[a]);
  }
  return true;
}

/// The errors in the filter, whose columns are D = cov(x, principal errors). Over a step the errors
/// add G to the state: D <- F D + G, and P gains F D G' + G D' F' + G G'.
class ConsideredErrors {
 public:
  /// For a step of h [s] at a heading of cosine c and sine s.
  ConsideredErrors(const PrincipalErrors& errors, double h, double c, double s)
      : errors_(errors), h_(h), cos_(c), sin_(s) {}

  bool any() const { return errors_.n > 0; }

  /// The accelerations by the errors in the step's middle, at the velocity nu. False where the
  /// model has none.
  bool accelerate(const Structure& structure, const double* coefficient, const double* nu,
                  const double* force, const Loadings force_error[kMaxForces]) {
    return acceleration_errors(structure, coefficient, errors_, nu, force, force_error, rate_);
  }

  /// D <- F D; of ekf_predict.
  template <int N, class State>
  void columns(const StateSensitivities&, int, const Disturbing&, const MotionSlopes& f,
               const GaussMarkov<N>& others, State& b) const {
    if (!any()) return;
    const auto none = [](int, double* row) { std::fill(row, row + kMostConsidered, 0.0); };
    detail::carry_columns<N>(f, others, kMostConsidered, none, b);
  }

  /// P += F D G' + G D' F' + G G' and D += G; of ekf_predict.
  template <int N, class State>
  void covariance(const MotionSlopes& f, State& b) const {
    if (!any()) return;
    Loadings push[kStates];
    step_errors(f, push);
    for (int i = 0; i < kStates; ++i) {
      for (int j = i; j < N; ++j) {
        double sum = 0.0;
        for (int k = 0; k < kMostConsidered; ++k) {
          sum += push[i][k] * b.d[j][k];
          if (j < kStates) sum += (b.d[i][k] + push[i][k]) * push[j][k];
        }
        b.p[i][j] = b.p[j][i] = b.p[i][j] + sum;
      }
    }
    for (int i = 0; i < kStates; ++i) detail::add_loadings(1.0, push[i], b.d[i]);
  }

 private:
  /// G: pose in the world and velocity. f: less the identity.
  void step_errors(const MotionSlopes& f, Loadings push[kStates]) const {
    for (int i = 0; i < kMostConsidered; ++i) {
      const double gained[kAxes] = {h_ * rate_[0][i], h_ * rate_[1][i], h_ * rate_[2][i]};
      for (int a = 0; a < kAxes; ++a) {  // an acceleration in the step is damped by half of it
        push[3 + a][i] = gained[a];
        for (int b = 0; b < kAxes; ++b) push[3 + a][i] += 0.5 * f[3 + a][1 + b] * gained[b];
      }
      double moved[kAxes];
      body_to_earth(cos_, sin_, gained, moved);
      for (int a = 0; a < kAxes; ++a) push[a][i] = 0.5 * h_ * moved[a];
    }
  }

  const PrincipalErrors& errors_;
  double h_;  // [s]
  double cos_;
  double sin_;
  Loadings rate_[kAxes] = {};
};

}  // namespace seatrial
