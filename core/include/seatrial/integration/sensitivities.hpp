// SPDX-License-Identifier: MIT
// The step with its exact derivatives (sensitivities) to initial state, coefficients and constants.
#pragma once
#include "seatrial/integration/step.hpp"

namespace seatrial {

/// Columns of the sensitivities: initial state (6 or 0), chosen coefficients, chosen
/// constants.
struct Columns {
  int n_initial = 0;
  int n_coefficients = 0;
  int n_constants = 0;
  int coefficient[kMaxCoefficients] = {};
  int constant[kMaxConstants] = {};

  int size() const { return n_initial + n_coefficients + n_constants; }
  int first_constant() const { return n_initial + n_coefficients; }
};
inline constexpr int kMaxColumns = kStates + kMaxCoefficients + kMaxConstants;

/// d x / d parameters: one row for each state, one column for each parameter. Aligned: all rows are
/// then read two numbers at once.
struct StateSensitivities {
  alignas(16) double row[kStates][kMaxColumns];
};

/// Derivatives of a Thrust to the chosen constants.
struct ThrustSensitivities {
  double level[kMaxActuators][kMaxConstants] = {};
  double target[kMaxActuators][kMaxConstants] = {};
  double multiplier[kMaxActuators][kMaxConstants] = {};
};

/// Starts the columns of the initial state as the identity, all others at 0.
inline void seed(const Columns& columns, StateSensitivities& dx) {
  for (int i = 0; i < kStates; ++i) {
    for (int c = 0; c < columns.size(); ++c) dx.row[i][c] = 0.0;
    if (columns.n_initial == kStates) dx.row[i][i] = 1.0;
  }
}

namespace detail {

using ForceSensitivities = double[kMaxForces][kMaxConstants];

/// x_dot and d x_dot = J dx + explicit dependence on coefficients and forces.
inline bool state_rate_sensitivities(const Structure& s, const double* coefficient, const double* x,
                                     const double* force, const Columns& columns,
                                     const StateSensitivities& dx, const ForceSensitivities& dforce,
                                     double* x_dot, StateSensitivities& dx_dot) {
  AccelerationJacobian j;
  const double cp = std::cos(x[2]);
  const double sp = std::sin(x[2]);
  body_to_earth(cp, sp, x + 3, x_dot);
  if (!acceleration_with_jacobian(s, coefficient, x + 3, force, x_dot + 3, j)) return false;
  const int n = columns.size();
  const double* dpsi = dx.row[2];
  const double* du = dx.row[3];
  const double* dv = dx.row[4];
  const double* dr = dx.row[5];
  const double rate[2] = {x_dot[0], x_dot[1]};
  for (int c = 0; c < n; ++c) {
    dx_dot.row[0][c] = -rate[1] * dpsi[c] + cp * du[c] - sp * dv[c];
    dx_dot.row[1][c] = rate[0] * dpsi[c] + sp * du[c] + cp * dv[c];
    dx_dot.row[2][c] = dr[c];
  }
  for (int i = 0; i < kAxes; ++i) {
    const double by[kAxes] = {j.nu[i][0], j.nu[i][1], j.nu[i][2]};
    double* to = dx_dot.row[3 + i];
    for (int c = 0; c < n; ++c) to[c] = by[0] * du[c] + by[1] * dv[c] + by[2] * dr[c];
  }
  for (int i = 0; i < kAxes; ++i) {
    for (int c = 0; c < columns.n_coefficients; ++c) {
      dx_dot.row[3 + i][columns.n_initial + c] += j.coefficient[i][columns.coefficient[c]];
    }
    for (int f = 0; f < s.n_forces; ++f) {
      if (j.force[i][f] == 0.0) continue;  // most forces drive one axis
      for (int c = 0; c < columns.n_constants; ++c) {
        dx_dot.row[3 + i][columns.first_constant() + c] += j.force[i][f] * dforce[f][c];
      }
    }
  }
  return true;
}

/// out = dx + share (h dk + dh k), where only constants (a latency) move the step's length. From
/// row `first` on: the rates do not depend on the position, the first two.
inline void shift_sensitivities(const Columns& columns, const StateSensitivities& dx,
                                const StateSensitivities& dk, const double* k, double h,
                                const double* dh, int first, StateSensitivities& out) {
  const int n = columns.size();
  for (int i = first; i < kStates; ++i) {
    for (int c = 0; c < n; ++c) out.row[i][c] = dx.row[i][c] + h * dk.row[i][c];
    double* moved = out.row[i] + columns.first_constant();
    for (int c = 0; c < columns.n_constants; ++c) moved[c] += dh[c] * k[i];
  }
}

inline void scaled(const double* from, int n, double share, double* to) {
  for (int c = 0; c < n; ++c) to[c] = share * from[c];
}

}  // namespace detail

/// Forward Euler with sensitivities; h is fixed by the stamps.
inline bool euler_step_sensitivities(const Structure& s, const double* coefficient,
                                     const Columns& columns, double h, const double* force,
                                     const detail::ForceSensitivities& dforce, double* x,
                                     StateSensitivities& dx) {
  double k[kStates];
  StateSensitivities dk;
  if (!detail::state_rate_sensitivities(s, coefficient, x, force, columns, dx, dforce, k, dk)) {
    return false;
  }
  const double still[kMaxConstants] = {0.0};
  detail::shift_sensitivities(columns, dx, dk, k, h, still, 0, dx);
  for (int i = 0; i < kStates; ++i) x[i] += h * k[i];
  return true;
}

/// Runge-Kutta with sensitivities. dh: derivative of the step's length to each constant.
inline bool runge_kutta_step_sensitivities(const Structure& s, const double* coefficient,
                                           const Columns& columns, double h, const double* dh,
                                           const double force[3][kMaxForces],
                                           const detail::ForceSensitivities dforce[3], double* x,
                                           StateSensitivities& dx) {
  static constexpr int kNode[4] = {0, 1, 1, 2};
  static constexpr double kShare[4] = {0.0, 0.5, 0.5, 1.0};
  static constexpr double kWeight[4] = {1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0};
  double k[kStates] = {0.0};
  double sum[kStates] = {0.0};
  double at[kStates];
  double part[kMaxConstants];
  StateSensitivities dk;
  StateSensitivities shifted;
  StateSensitivities dsum;
  const StateSensitivities* dat = &dx;
  const int n = columns.size();
  for (int stage = 0; stage < 4; ++stage) {
    for (int i = 0; i < kStates; ++i) at[i] = x[i] + kShare[stage] * h * k[i];
    if (stage > 0) {
      detail::scaled(dh, columns.n_constants, kShare[stage], part);
      detail::shift_sensitivities(columns, dx, dk, k, kShare[stage] * h, part, 2, shifted);
      dat = &shifted;
    }
    if (!detail::state_rate_sensitivities(s, coefficient, at, force[kNode[stage]], columns, *dat,
                                          dforce[kNode[stage]], k, dk)) {
      return false;
    }
    for (int i = 0; i < kStates; ++i) {
      sum[i] += kWeight[stage] * k[i];
      for (int c = 0; c < n; ++c) {
        dsum.row[i][c] = (stage == 0 ? 0.0 : dsum.row[i][c]) + kWeight[stage] * dk.row[i][c];
      }
    }
  }
  detail::shift_sensitivities(columns, dx, dsum, sum, h, dh, 0, dx);
  for (int i = 0; i < kStates; ++i) x[i] += h * sum[i];
  return true;
}

namespace detail {

/// Levels at begin, middle and end of a step with their derivatives, mixed into forces.
struct StepForces {
  double force[3][kMaxForces];
  ForceSensitivities dforce[3];
};

inline void mix_node(const Chain& c, const Columns& columns, const double* output,
                     const double doutput[kMaxActuators][kMaxConstants], int node, StepForces& to) {
  mix_forces(c, output, to.force[node]);
  mix_slopes(c, output, doutput, columns.n_constants, to.dforce[node]);
}

/// The remaining distance to the target after `h`, and its derivatives.
inline double decay_sensitivities(const Chain& c, const double* q, const Columns& columns, int k,
                                  double h, const double* dh, double* dremains) {
  const double remains = decay(c, q, k, h);
  const double lag = constant(q, c.actuators[k].lag, 0.0);
  for (int p = 0; p < columns.n_constants; ++p) {
    if (remains == 0.0) {
      dremains[p] = 0.0;
      continue;
    }
    const double dlag = columns.constant[p] == c.actuators[k].lag ? 1.0 : 0.0;
    dremains[p] = remains * (-dh[p] / lag + h * dlag / (lag * lag));
  }
  return remains;
}

/// The level after `h`: target + (level - target) remains. dlevel, its derivatives, may be df's.
inline double level_sensitivities(const Columns& columns, const Thrust& f,
                                  const ThrustSensitivities& df, int k, double remains,
                                  const double* dremains, double* dlevel) {
  const double away = f.level[k] - f.target[k];
  for (int p = 0; p < columns.n_constants; ++p) {
    const double daway = df.level[k][p] - df.target[k][p];
    dlevel[p] = df.target[k][p] + daway * remains + away * dremains[p];
  }
  return f.target[k] + away * remains;
}

/// The level of an actuator with a rate limit after h [s]. dlevel, its derivatives, may be df's.
inline double limited_sensitivities(const Chain& c, const double* q, const Columns& columns,
                                    const Thrust& f, const ThrustSensitivities& df, int k, double h,
                                    const double* dh, double* dlevel) {
  const Actuator& a = c.actuators[k];
  const Distance d =
      rate_limited(f.level[k] - f.target[k], rate_limit(c, q, k), constant(q, a.lag, 0.0), h);
  for (int p = 0; p < columns.n_constants; ++p) {
    const double daway = df.level[k][p] - df.target[k][p];
    dlevel[p] = df.target[k][p] + d.dstart * daway + d.dtime * dh[p];
    if (columns.constant[p] == a.slew_rate) dlevel[p] += slew_unit(a) * d.drate;
    if (columns.constant[p] == a.lag) dlevel[p] += d.dlag;
  }
  return f.target[k] + d.left;
}

/// output = multiplier level, with derivatives.
inline double output_sensitivities(const Columns& columns, const Thrust& f,
                                   const ThrustSensitivities& df, int k, double level,
                                   const double* dlevel, double* doutput) {
  for (int p = 0; p < columns.n_constants; ++p) {
    doutput[p] = df.multiplier[k][p] * level + f.multiplier[k] * dlevel[p];
  }
  return f.multiplier[k] * level;
}

/// Outputs of an actuator with a rate limit at begin, middle and end of a step; its level moves
/// to the end.
inline void limited_nodes(const Chain& c, const double* q, const Columns& columns, double h,
                          const double* dh, int k, Thrust& f, ThrustSensitivities& df,
                          double output[3][kMaxActuators],
                          double doutput[3][kMaxActuators][kMaxConstants]) {
  double level = 0.0;
  double moved[kMaxConstants];
  double dpart[kMaxConstants];
  for (int node = 0; node < 3; ++node) {
    double* dlevel = node < 2 ? moved : df.level[k];  // the level's own at the end
    scaled(dh, columns.n_constants, 0.5 * node, dpart);
    level = limited_sensitivities(c, q, columns, f, df, k, 0.5 * node * h, dpart, dlevel);
    output[node][k] = output_sensitivities(columns, f, df, k, level, dlevel, doutput[node][k]);
  }
  f.level[k] = level;
}

}  // namespace detail

/// `step_forces` of step.hpp with sensitivities, for a step of h [s] that the constants move by dh.
inline void step_forces_sensitivities(const Chain& c, const double* q, const Columns& columns,
                                      double h, const double* dh, Thrust& f,
                                      ThrustSensitivities& df, detail::StepForces& to) {
  double output[3][kMaxActuators];
  double doutput[3][kMaxActuators][kMaxConstants];
  bool lags = false;
  LagDecay decays;
  LagDecay slope;
  double dx[kMaxConstants];
  int last = -1;  // whose lag the decays are of
  for (int k = 0; k < c.n_actuators(); ++k) {
    if (rate_limit(c, q, k) > 0.0) {
      detail::limited_nodes(c, q, columns, h, dh, k, f, df, output, doutput);
      continue;
    }
    const std::int8_t own = c.actuators[k].lag;
    if (last < 0 || own != c.actuators[last].lag) {
      last = k;
      const double lag = detail::constant(q, own, 0.0);
      lags = lag > kShortestLag;
      slope = LagDecay{};
      decays = lags ? lag_decay(h / lag, &slope) : LagDecay{};
      for (int p = 0; p < columns.n_constants; ++p) {
        const double dlag = columns.constant[p] == own ? 1.0 : 0.0;
        dx[p] = lags ? (dh[p] - h * dlag / lag) / lag : 0.0;
      }
    }
    double dfade[kMaxConstants];
    double dlevel[kMaxConstants];
    detail::scaled(dx, columns.n_constants, slope.begin, dfade);
    double level = detail::level_sensitivities(columns, f, df, k, decays.begin, dfade, dlevel);
    output[0][k] = detail::output_sensitivities(columns, f, df, k, level, dlevel, doutput[0][k]);
    detail::scaled(dx, columns.n_constants, slope.middle, dfade);
    level = detail::level_sensitivities(columns, f, df, k, decays.middle, dfade, dlevel);
    output[1][k] = detail::output_sensitivities(columns, f, df, k, level, dlevel, doutput[1][k]);
    detail::scaled(dx, columns.n_constants, slope.end, dfade);
    level = detail::level_sensitivities(columns, f, df, k, decays.end, dfade, df.level[k]);
    output[2][k] =
        detail::output_sensitivities(columns, f, df, k, level, df.level[k], doutput[2][k]);
    f.level[k] = level;
  }
  for (int node = 0; node < 3; ++node) {
    detail::mix_node(c, columns, output[node], doutput[node], node, to);
  }
}

/// `advance` of step.hpp with sensitivities. dlength: derivative of the interval to each constant.
inline bool advance_sensitivities(const Structure& s, const double* coefficient, const Chain& c,
                                  const double* q, const Columns& columns, double length,
                                  const double* dlength, double longest, Thrust& f,
                                  ThrustSensitivities& df, double* x, StateSensitivities& dx) {
  const int n = steps_for(length, longest);
  double dh[kMaxConstants] = {0.0};
  detail::scaled(dlength, columns.n_constants, 1.0 / n, dh);
  for (int i = 0; i < n; ++i) {
    detail::StepForces forces;
    step_forces_sensitivities(c, q, columns, length / n, dh, f, df, forces);
    if (!runge_kutta_step_sensitivities(s, coefficient, columns, length / n, dh, forces.force,
                                        forces.dforce, x, dx)) {
      return false;
    }
  }
  return bounded(x);
}

}  // namespace seatrial
