// SPDX-License-Identifier: MIT
// What the on-board predictor believes of a boat: its state and disturbance with their covariance,
// through the model's own steps; where the model has any, correlated errors of the poses,
// too, as in the estimator's filter. The errors of the model's own parameters are considered, not
// estimated. No heap, no exceptions.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>

#include "seatrial/filter/noise_parameters.hpp"
#include "seatrial/filter/schmidt_kalman.hpp"
#include "seatrial/integration/sensitivities.hpp"

namespace seatrial {

inline constexpr int kBelieved = kStates + kAxes;  // x, y, psi, u, v, r and the disturbance's three
inline constexpr int kSeen = 3;                    // x, y [m], psi [rad] are measured
inline constexpr int kColoured = kBelieved + kSeen;      // and the correlated errors
inline constexpr int kMostBelieved = kColoured + kSeen;  // and, where they swing, their other side

enum class DisturbanceFrame : std::uint8_t { kEarth, kBody };

/// The model as it is stepped on board.
struct DrivenBoat {
  Structure structure;                        // ends with the terms of add_disturbance
  double coefficient[kMaxCoefficients] = {};  // of the model; the disturbance's three follow
  Integrator integrator = Integrator::kRungeKutta;
  double longest_step = 1.0 / 60.0;  // [s]
  MotionNoise noise;
  DisturbanceFrame frame = DisturbanceFrame::kEarth;
  double current[2] = {0.0, 0.0};  // [m/s] earth-fixed; u, v are then those in the water
  Considered considered;           // errors of coefficients and chain constants
};

/// Adds an acceleration to every axis, the structure's last three coefficients. False: no room.
inline bool add_disturbance(Structure& s) {
  if (s.n_terms + kAxes > kMaxTerms || s.n_coefficients + kAxes > kMaxCoefficients) return false;
  for (int axis = 0; axis < kAxes; ++axis) {
    Term& term = s.terms[s.n_terms++];
    term = Term{};
    term.axis = static_cast<std::uint8_t>(axis);
    term.coefficient = static_cast<std::int8_t>(s.n_coefficients++);
  }
  return true;
}

/// Mean and covariance of the first n: x, y [m], psi [rad], u, v [m/s], r [rad/s], disturbance
/// [m/s^2, rad/s^2]; correlated errors of the poses [m, m, rad]; where these swing, as
/// waves make them, their other side [m, m, rad], by which they turn. The covariance is of all that
/// may be wrong, the model's parameters included.
struct Belief {
  int n = kBelieved;  // or kColoured, or kMostBelieved
  double x[kMostBelieved] = {};
  double p[kMostBelieved][kMostBelieved] = {};
  Causes by[kMostBelieved] = {};  // covariance with the causes of the parameters' errors

  bool coloured() const { return n >= kColoured; }
  bool swinging() const { return n == kMostBelieved; }
};

namespace detail {

inline constexpr ForceTangent kFixedForces[3] = {};  // no constant is differentiated to on board
inline constexpr double kFixedStep[kMaxConstants] = {};

/// Initial state and the structure's last three coefficients.
inline Columns believed_columns(const Structure& s) {
  Columns columns;
  columns.n_initial = kStates;
  columns.n_coefficients = kAxes;
  for (int a = 0; a < kAxes; ++a) columns.coefficient[a] = s.n_coefficients - kAxes + a;
  return columns;
}

/// F P F' of N states, with the motion's slopes less the identity; the others keep `stays` of
/// themselves.
template <int N>
void carry(const double f[kStates][kBelieved], const double* stays, double p[][kMostBelieved]) {
  double fp[kStates][N];
  for (int i = 0; i < kStates; ++i) {
    for (int j = 0; j < N; ++j) {
      double sum = p[i][j];
      for (int m = 2; m < kBelieved; ++m) sum += f[i][m] * p[m][j];
      fp[i][j] = sum;
    }
  }
  for (int i = 0; i < kStates; ++i) {
    for (int j = i; j < kStates; ++j) {
      double sum = fp[i][j];
      for (int m = 2; m < kBelieved; ++m) sum += fp[i][m] * f[j][m];
      p[i][j] = p[j][i] = sum;
    }
    for (int j = kStates; j < N; ++j) p[i][j] = p[j][i] = stays[j - kStates] * fp[i][j];
  }
  for (int i = kStates; i < N; ++i) {
    for (int j = kStates; j < N; ++j) p[i][j] *= stays[i - kStates] * stays[j - kStates];
  }
}

/// Random walk of the velocity, integrated into the pose; renewal of the disturbance. c, s: of the
/// heading. The walk of u is that of v: turned, it is the same.
inline void add_noise(const MotionNoise& n, double c, double s, double h, double stays,
                      double p[][kMostBelieved]) {
  const double turn[3][3] = {{c, -s, 0.0}, {s, c, 0.0}, {0.0, 0.0, 1.0}};
  for (int a = 0; a < kAxes; ++a) {
    const double walk = a < 2 ? n.walk_linear : n.walk_yaw;
    const double force = a < 2 ? n.disturbance_linear : n.disturbance_yaw;
    const double q = walk * walk * h;
    p[a][a] += q * h * h / 3.0;
    p[3 + a][3 + a] += q;
    for (int i = 0; i < kSeen; ++i) {
      p[i][3 + a] += turn[i][a] * q * h / 2.0;
      p[3 + a][i] = p[i][3 + a];
    }
    p[kStates + a][kStates + a] += force * force * (1.0 - stays * stays);
  }
}

/// Of the correlated errors.
inline void renew_colour(const MotionNoise& n, double stays, double p[][kMostBelieved]) {
  for (int i = 0; i < kSeen; ++i) {
    p[kBelieved + i][kBelieved + i] += n.colour_variance(i) * (1.0 - stays * stays);
  }
}

/// Errors that swing and their other sides, h [s] later.
inline void swing(const MotionNoise& n, double h, Belief& b) {
  const Swing swing(n.colour_memory, n.colour_turn, h);
  for (int i = kBelieved; i < kColoured; ++i) {
    swing.turn(b.x[i], b.x[i + kSeen]);
    for (int j = 0; j < b.n; ++j) swing.turn(b.p[i][j], b.p[i + kSeen][j]);
    for (int j = 0; j < kMostConsidered; ++j) swing.turn(b.by[i][j], b.by[i + kSeen][j]);
  }
  for (int j = 0; j < b.n; ++j) {
    for (int i = kBelieved; i < kColoured; ++i) swing.turn(b.p[j][i], b.p[j][i + kSeen]);
  }
  for (int i = kBelieved; i < b.n; ++i) {  // as rounding has it on one side
    for (int j = 0; j < i; ++j) b.p[i][j] = b.p[j][i];
  }
  for (int i = kBelieved; i < kColoured; ++i) {
    const double variance = n.colour_variance(i - kBelieved);
    b.p[i][i] += variance * swing.new_error();
    b.p[i + kSeen][i + kSeen] += variance * swing.new_other();
    b.p[i][i + kSeen] += variance * swing.new_both();
    b.p[i + kSeen][i] = b.p[i][i + kSeen];
  }
}

/// What the causes do over a step to the pose in the world and the velocity; c, s: of the heading.
/// False where the model has no acceleration.
inline bool push_of_causes(const DrivenBoat& boat, double h, const double* nu, const double* force,
                           const Causes force_error[kMaxForces], double c, double s,
                           const double f[kStates][kBelieved], Causes push[kStates]) {
  Causes rate[kAxes];
  if (!acceleration_errors(boat.structure, boat.coefficient, boat.considered, nu, force,
                           force_error, rate)) {
    return false;
  }
  for (int i = 0; i < kMostConsidered; ++i) {
    const double way[kAxes] = {h * rate[0][i], h * rate[1][i], h * rate[2][i]};
    for (int a = 0; a < kAxes; ++a) {  // what comes at the begin is damped for all of the step
      push[3 + a][i] = way[a];
      for (int b = 0; b < kAxes; ++b) push[3 + a][i] += 0.5 * f[3 + a][3 + b] * way[b];
    }
    double moved[kAxes];
    body_to_earth(c, s, way, moved);
    for (int a = 0; a < kAxes; ++a) push[a][i] = 0.5 * h * moved[a];
  }
  return true;
}

/// F B + G of B = cov(state, causes) and the step's push G; to the covariance, which has F P F'
/// already, what both add: F B G' + G B' F' + G G'.
inline void carry_causes(const double f[kStates][kBelieved], const double* stays,
                         const Causes push[kStates], Belief& b) {
  Causes moved[kStates];
  for (int i = 0; i < kStates; ++i) {
    std::copy(b.by[i], b.by[i] + kMostConsidered, moved[i]);
    for (int m = 2; m < kBelieved; ++m) add_causes(f[i][m], b.by[m], moved[i]);
  }
  for (int i = 0; i < kStates; ++i) std::copy(moved[i], moved[i] + kMostConsidered, b.by[i]);
  for (int i = kStates; i < b.n; ++i) {
    for (double& x : b.by[i]) x *= stays[i - kStates];
  }
  for (int i = 0; i < kStates; ++i) {
    for (int j = i; j < b.n; ++j) {
      double sum = 0.0;
      for (int k = 0; k < kMostConsidered; ++k) {
        sum += push[i][k] * b.by[j][k];
        if (j < kStates) sum += (b.by[i][k] + push[i][k]) * push[j][k];
      }
      b.p[i][j] = b.p[j][i] = b.p[i][j] + sum;
    }
  }
  for (int i = 0; i < kStates; ++i) add_causes(1.0, push[i], b.by[i]);
}

}  // namespace detail

/// Whether the numbers are those of a boat: false where it, or what is known of it, ran away.
inline bool plausible(const Belief& b) {
  constexpr double kFastest = 100.0;      // [m/s, rad/s]
  constexpr double kMostVariance = 1e12;  // of whatever unit
  if (!bounded(b.x)) return false;
  for (int i = 3; i < kStates; ++i) {
    if (!(std::abs(b.x[i]) < kFastest)) return false;
  }
  for (int i = 0; i < b.n; ++i) {
    if (!(b.p[i][i] > 0.0 && b.p[i][i] < kMostVariance)) return false;
  }
  return true;
}

/// One step of h [s] under the forces at its begin, middle and end, and, where errors are
/// considered, the forces' mean errors. An earth-fixed disturbance is turned to the heading in the
/// step's middle. False where the boat diverged.
inline bool believe_step(const DrivenBoat& boat, const MotionNoise& noise, double h,
                         const double force[3][kMaxForces], const Causes force_error[kMaxForces],
                         Belief& b) {
  const Columns columns = detail::believed_columns(boat.structure);
  double coefficient[kMaxCoefficients];
  std::copy(boat.coefficient, boat.coefficient + boat.structure.n_coefficients, coefficient);
  const double psi = b.x[2] + 0.5 * h * b.x[5];
  const double c = std::cos(psi);
  const double s = std::sin(psi);
  const bool earth = boat.frame == DisturbanceFrame::kEarth;
  const double* d = b.x + kStates;
  double push[kAxes] = {d[0], d[1], d[2]};
  if (earth) plane_to_body(c, s, d, push);
  std::copy(push, push + kAxes, coefficient + columns.coefficient[0]);
  const double before[kAxes] = {b.x[3], b.x[4], b.x[5]};
  StateTangent dx;
  seed(columns, dx);
  const bool solved =
      boat.integrator == Integrator::kForwardEuler
          ? euler_step_tangent(boat.structure, coefficient, columns, h, force[0],
                               detail::kFixedForces[0], b.x, dx)
          : runge_kutta_step_tangent(boat.structure, coefficient, columns, h, detail::kFixedStep,
                                     force, detail::kFixedForces, b.x, dx);
  if (!solved) return false;
  for (int i = 0; i < 2; ++i) b.x[i] += h * boat.current[i];
  double f[kStates][kBelieved];
  for (int i = 0; i < kStates; ++i) {
    std::copy(dx.row[i], dx.row[i] + kBelieved, f[i]);
    if (earth) {
      const double bend = f[i][kStates] * push[1] - f[i][kStates + 1] * push[0];  // d / d psi
      const double own[2] = {f[i][kStates], f[i][kStates + 1]};
      f[i][2] += bend;
      f[i][5] += 0.5 * h * bend;
      plane_to_earth(c, s, own, f[i] + kStates);
    }
    f[i][i] -= 1.0;
  }
  double stays[kMostBelieved - kStates];
  std::fill(stays, stays + kAxes, std::exp(-h / noise.memory));
  const double stays_coloured = b.swinging() ? 1.0 : std::exp(-h / noise.colour_memory);
  std::fill(stays + kAxes, stays + kMostBelieved - kStates, stays_coloured);
  for (int i = kStates; i < b.n; ++i) b.x[i] *= stays[i - kStates];
  Causes push_by[kStates];
  if (boat.considered.n > 0) {
    const double nu[kAxes] = {0.5 * (before[0] + b.x[3]), 0.5 * (before[1] + b.x[4]),
                              0.5 * (before[2] + b.x[5])};
    if (!detail::push_of_causes(boat, h, nu, force[1], force_error, c, s, f, push_by)) return false;
  }
  if (b.swinging()) {
    detail::carry<kMostBelieved>(f, stays, b.p);
  } else if (b.coloured()) {
    detail::carry<kColoured>(f, stays, b.p);
    detail::renew_colour(noise, stays_coloured, b.p);
  } else {
    detail::carry<kBelieved>(f, stays, b.p);
  }
  if (boat.considered.n > 0) detail::carry_causes(f, stays, push_by, b);
  if (b.swinging()) detail::swing(noise, h, b);
  detail::add_noise(noise, c, s, h, stays[0], b.p);
  return plausible(b);
}

/// The same without errors of the forces.
inline bool believe_step(const DrivenBoat& boat, double h, const double force[3][kMaxForces],
                         Belief& b) {
  const Causes none[kMaxForces] = {};
  return believe_step(boat, boat.noise, h, force, none, b);
}

}  // namespace seatrial
