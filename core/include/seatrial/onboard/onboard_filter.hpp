// SPDX-License-Identifier: MIT
// The predictor's use of the extended Kalman filter (ekf_predict.hpp, ekf_update.hpp): one step of
// the boat at a time, in Joseph's form, with the errors of the model's parameters considered
// (schmidt_kalman.hpp). The columns D are the state's covariance with these errors. No heap, no
// exceptions.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <type_traits>

#include "seatrial/filter/ekf_update.hpp"
#include "seatrial/filter/schmidt_kalman.hpp"

namespace seatrial {

enum class DisturbanceFrame : std::uint8_t { kEarth, kBody };

/// The model as it is stepped on board.
struct OnboardBoat {
  Structure structure;                        // ends with the terms of add_disturbance
  double coefficient[kMaxCoefficients] = {};  // of the model; the disturbance's three follow
  Integrator integrator = Integrator::kRungeKutta;
  double longest_step = 1.0 / 60.0;  // [s]
  NoiseParameters noise;
  DisturbanceFrame frame = DisturbanceFrame::kEarth;
  double current[2] = {0.0, 0.0};  // [m/s] earth-fixed; u, v are then those in the water
  PrincipalErrors considered;      // errors of coefficients and chain constants
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

/// Mean and covariance of the first n states of filter_state.hpp. The covariance includes the
/// errors of the model's parameters.
struct StateEstimate : FilterState<kOscillatingStates, kMostConsidered> {
  int n = kFilterStates;  // or kColouredStates, or kOscillatingStates

  bool coloured() const { return n >= kColouredStates; }
  bool oscillating() const { return n == kOscillatingStates; }
};

/// How many states noise needs.
inline int states_for(const NoiseParameters& n) {
  return n.oscillating() ? kOscillatingStates : n.coloured() ? kColouredStates : kFilterStates;
}

namespace detail {

inline constexpr ForceSensitivities kFixedForces[3] =
    {};  // no constant is differentiated to on board
inline constexpr double kFixedStep[kMaxConstants] = {};

/// `run` with the number of states in use as a constant.
template <class Run>
auto with_states(const StateEstimate& b, Run run) {
  if (b.oscillating()) return run(std::integral_constant<int, kOscillatingStates>());
  if (b.coloured()) return run(std::integral_constant<int, kColouredStates>());
  return run(std::integral_constant<int, kFilterStates>());
}

/// Initial state and the structure's last three coefficients.
inline Columns onboard_columns(const Structure& s) {
  Columns columns;
  columns.n_initial = kStates;
  columns.n_coefficients = kAxes;
  for (int a = 0; a < kAxes; ++a) columns.coefficient[a] = s.n_coefficients - kAxes + a;
  return columns;
}

/// One step of the boat with its sensitivities. False where the model has no acceleration.
inline bool step_with_slopes(const OnboardBoat& boat, const double* coefficient,
                             const Columns& columns, double h, const double force[3][kMaxForces],
                             double* x, StateSensitivities& dx) {
  if (boat.integrator == Integrator::kForwardEuler) {
    return euler_step_sensitivities(boat.structure, coefficient, columns, h, force[0],
                                    kFixedForces[0], x, dx);
  }
  return runge_kutta_step_sensitivities(boat.structure, coefficient, columns, h, kFixedStep, force,
                                        kFixedForces, x, dx);
}

/// A whole pose of the origin, of this white noise.
inline Measurement measured_pose(const double* eta, const double noise[kPose][kPose]) {
  Measurement y{eta};
  std::copy(&noise[0][0], &noise[0][0] + std::ptrdiff_t{kPose} * kPose, &y.noise[0][0]);
  return y;
}

/// Whether s is positive definite, by its leading minors.
inline bool positive_definite(const double s[kPose][kPose], double determinant) {
  return s[0][0] > 0.0 && s[0][0] * s[1][1] - s[0][1] * s[1][0] > 0.0 && determinant > 0.0;
}

}  // namespace detail

/// Whether the numbers are those of a boat: false where it, or its covariance, diverged.
inline bool plausible(const StateEstimate& b) {
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

/// Prediction over h [s] under the forces at its begin, middle and end, and, where errors are
/// considered, the forces' mean errors. False where the boat diverged.
inline bool predict(const OnboardBoat& boat, const NoiseParameters& own, double h,
                    const double force[3][kMaxForces], const Loadings force_error[kMaxForces],
                    StateEstimate& b) {
  const double none[kWindParts] = {};
  const bool earth = boat.frame == DisturbanceFrame::kEarth;
  const NoiseParameters noise = earth ? equal_in_plane(own) : own;
  const Disturbing disturbing(b.x, h, none, none, earth);
  const Interval passed(noise, disturbing.cos, disturbing.sin, h);
  ConsideredErrors errors(boat.considered, h, disturbing.cos, disturbing.sin);
  const Columns columns = detail::onboard_columns(boat.structure);
  double coefficient[kMaxCoefficients];
  std::copy(boat.coefficient, boat.coefficient + boat.structure.n_coefficients, coefficient);
  std::copy(disturbing.total, disturbing.total + kAxes, coefficient + columns.coefficient[0]);
  const auto move = [&](double* x, StateSensitivities& dx) {
    const double before[kAxes] = {x[3], x[4], x[5]};
    if (!detail::step_with_slopes(boat, coefficient, columns, h, force, x, dx)) return false;
    for (int i = 0; i < 2; ++i) x[i] += h * boat.current[i];
    if (!errors.any()) return true;
    const double nu[kAxes] = {0.5 * (before[0] + x[3]), 0.5 * (before[1] + x[4]),
                              0.5 * (before[2] + x[5])};
    return errors.accelerate(boat.structure, boat.coefficient, nu, force[1], force_error);
  };
  MotionSlopes f;
  const bool moved = detail::with_states(b, [&](auto n) {
    return ekf_predict<n()>(columns, disturbing, passed, noise, move, errors, f, b);
  });
  return moved && plausible(b);
}

/// The same without errors of the forces.
inline bool predict(const OnboardBoat& boat, double h, const double force[3][kMaxForces],
                    StateEstimate& b) {
  const Loadings none[kMaxForces] = {};
  return predict(boat, boat.noise, h, force, none, b);
}

/// A measurement beside its prediction. `outlier`: from how many standard deviations on it counts
/// less. The NIS is infinite where S is no covariance.
inline Innovation innovation(const StateEstimate& b, const Measurement& y,
                             double outlier = std::numeric_limits<double>::infinity()) {
  Innovation out = detail::with_states(b, [&](auto n) {
    double hp[kPose][n()];
    detail::measured_covariance<n()>(y, b, hp);
    if (y.parts != kWholePose) detail::leave_out(y.parts, hp);
    return detail::innovation<n()>(y, outlier, hp, b);
  });
  if (!detail::positive_definite(out.s, out.determinant)) {
    out.nis = std::numeric_limits<double>::infinity();
  }
  return out;
}

/// The same of a pose of this white noise (its covariance).
inline Innovation innovation(const StateEstimate& b, const double* eta,
                             const double noise[kPose][kPose],
                             double outlier = std::numeric_limits<double>::infinity()) {
  return innovation(b, detail::measured_pose(eta, noise), outlier);
}

/// Update by a measurement; an outlier counts by its weight.
inline void update(const Innovation& seen, const Measurement& y, StateEstimate& b) {
  detail::with_states(b, [&](auto n) {
    double hp[kPose][n()];
    double hd[kPose][kMostConsidered];
    detail::measured_covariance<n()>(y, b, hp);
    detail::measured_columns<n()>(y, b, kMostConsidered, hd);
    if (y.parts != kWholePose) {
      detail::leave_out(y.parts, hp);
      detail::leave_out(y.parts, hd);
    }
    ekf_update<n()>(seen, hp, hd, kMostConsidered, detail::JosephForm{y}, b);
  });
}

/// The same of a pose of this white noise.
inline void update(const Innovation& seen, const double noise[kPose][kPose], StateEstimate& b) {
  update(seen, detail::measured_pose(nullptr, noise), b);
}

}  // namespace seatrial
