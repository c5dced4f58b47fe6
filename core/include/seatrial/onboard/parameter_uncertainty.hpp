// SPDX-License-Identifier: MIT
// Uncertainty of a model's parameters on board: its process noise and the considered errors. Host
// side: uses heap.
//
// Where structure and noise explain the data, the parameters are constants and their errors are
// considered (principal_errors.hpp, schmidt_kalman.hpp). Under model mismatch the parameters are
// averages over what the structure lacks, and their errors vary with the motion: then they are
// process noise. Along a drive errors of covariance C give the velocity an error S e, S = d nu /
// d parameters, of covariance P = S C S'. A random walk of power Q has dP/dt = J P + P J' + Q,
// J = d nu_dot / d nu. On average P neither grows nor shrinks, so that Q = -(J P + P J'), averaged
// over the drive, is the random walk of the same velocity error.
#pragma once
#include "seatrial/onboard/onboard_filter.hpp"
#include "seatrial/onboard/principal_errors.hpp"

namespace seatrial {
namespace detail {

/// Least noise of the filter on board, so that the covariance keeps its digits over days. The
/// estimator's floors (NOISE_LEAST of Python) are lower: they end the search of a logarithm.
inline constexpr NoiseParameters kLeastNoise{1e-4, 1e-4, 1e-6, 1e-6, 1e-5,
                                             1e-5, 0.3,  1e-5, 1e-5, 0.02};

/// S C S' of three rows of slopes.
inline void covariance_of(const double (*slope)[kMaxColumns], const double (*c)[kMaxParameters],
                          int n, double p[kAxes][kAxes]) {
  for (int a = 0; a < kAxes; ++a) {
    double row[kMaxParameters] = {};  // of S C
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j < n; ++j) row[j] += slope[a][i] * c[i][j];
    }
    for (int b = 0; b < kAxes; ++b) {
      p[a][b] = 0.0;
      for (int j = 0; j < n; ++j) p[a][b] += row[j] * slope[b][j];
    }
  }
}

/// The covariance of latencies and lags only, or of all others only.
inline UncertainModel part_of(const UncertainModel& m, bool timing) {
  UncertainModel part = m;
  bool timed[kMaxParameters] = {};
  for (int k = 0; k < m.chain.n_actuators(); ++k) {
    for (const int own : {m.chain.actuators[k].latency, m.chain.actuators[k].lag}) {
      if (own >= 0) timed[m.boat.structure.n_coefficients + own] = true;
    }
  }
  for (int i = 0; i < m.n_parameters(); ++i) {
    for (int j = 0; j < m.n_parameters(); ++j) {
      if (timed[i] != timing || timed[j] != timing) part.covariance[i][j] = 0.0;
    }
  }
  return part;
}

/// Jacobian and slopes at one instant of a drive.
struct DriveSample {
  AccelerationJacobian j;
  double slope[kAxes][kMaxColumns] = {};  // d nu_dot / d parameters
  bool good = false;

  DriveSample(const UncertainModel& m, const ThrustTrace& trace, double t, const double* nu) {
    const double still[kMaxConstants] = {0.0};
    const Columns& columns = trace.columns();
    Thrust f;
    ThrustSensitivities df;
    StepForces forces;
    double nu_dot[kAxes];
    trace.at(trace.find(t), t, nullptr, f, df);
    step_forces_sensitivities(m.chain, m.q, columns, 0.0, still, f, df, forces);
    good = acceleration_with_jacobian(m.boat.structure, m.boat.coefficient, nu, forces.force[0],
                                      nu_dot, j);
    for (int a = 0; a < kAxes && good; ++a) {
      std::copy(j.coefficient[a], j.coefficient[a] + columns.n_coefficients, slope[a]);
      for (int k = 0; k < m.chain.n_forces; ++k) {
        for (int c = 0; c < columns.n_constants; ++c) {
          slope[a][columns.n_coefficients + c] += j.force[a][k] * forces.dforce[0][k][c];
        }
      }
    }
  }
};

/// power[a] += power of the random walk of the same velocity error.
inline bool add_power(const AccelerationJacobian& j, const StateSensitivities& dx,
                      const UncertainModel& m, double* power) {
  double p[kAxes][kAxes];
  covariance_of(dx.row + 3, m.covariance, m.n_parameters(), p);
  for (int a = 0; a < kAxes; ++a) {
    for (int b = 0; b < kAxes; ++b) power[a] -= 2.0 * j.nu[a][b] * p[b][a];
  }
  return std::isfinite(power[0] + power[1] + power[2]);
}

}  // namespace detail

/// Process noise in place of parameter errors.
struct ErrorNoise {
  double disturbance[kAxes] = {};  // [m/s^2, m/s^2, rad/s^2] standard deviations
  double memory[kAxes] = {};       // [s]
  double walk[kAxes] = {};         // [m/s, m/s, rad/s per sqrt(s)]
};

namespace detail {

/// Sums over the instants of a drive.
struct PowerSums {
  double variance[kAxes] = {};  // of the acceleration, by all parameters but latency and lag
  double steady[kAxes] = {};    // power, by the same
  double timing[kAxes] = {};    // power, by latency and lag

  /// Adds an instant. False: an error is not a number, and nothing is added.
  bool add(const DriveSample& now, const StateSensitivities& dx, const UncertainModel& lasting,
           const UncertainModel& late) {
    PowerSums next = *this;
    if (!now.good || !add_power(now.j, dx, lasting, next.steady) ||
        !add_power(now.j, dx, late, next.timing)) {
      return false;
    }
    double p[kAxes][kAxes];
    covariance_of(now.slope, lasting.covariance, lasting.n_parameters(), p);
    for (int a = 0; a < kAxes; ++a) next.variance[a] += p[a][a];
    *this = next;
    return true;
  }

  /// Noise of the mean over the instants: a disturbance for lasting errors, a random walk for those
  /// of latency and lag.
  ErrorNoise noise(int instants) const {
    ErrorNoise out;
    for (int a = 0; a < kAxes; ++a) {
      const double mean = std::max(variance[a] / instants, 0.0);
      const double power = std::max(steady[a] / instants, 0.0);
      out.disturbance[a] = std::sqrt(mean);
      if (mean > 0.0) out.memory[a] = power / (2.0 * mean);
      out.walk[a] = std::sqrt(std::max(timing[a] / instants, 0.0));
    }
    return out;
  }
};

}  // namespace detail

/// A model's parameter errors as process noise, along a random drive; none without such a drive.
inline ErrorNoise error_noise(const UncertainModel& m) {
  ErrorNoise out;
  const UncertainModel lasting = detail::part_of(m, false);
  const UncertainModel late = detail::part_of(m, true);
  with_strongest_commands(m, [&](double most) {
    detail::PowerSums sum;
    const int instants = detail::random_drive(
        m, most,
        [&](const ThrustTrace& trace, double t, const double* x, const StateSensitivities& dx) {
          return sum.add(detail::DriveSample(m, trace, t, x + 3), dx, lasting, late);
        });
    if (instants < detail::kEnough) return false;
    out = sum.noise(instants);
    return true;
  });
  return out;
}

namespace detail {

/// Sum of two disturbances: variances and powers add up.
struct SumOfDisturbances {
  double spread = 0.0;  // standard deviation
  double memory = 0.0;  // [s]

  SumOfDisturbances(double own, double own_memory, double more, double more_memory)
      : spread(std::hypot(own, more)) {
    const double share = more > 0.0 ? (more / spread) * (more / spread) : 0.0;
    memory = own_memory + share * (more_memory - own_memory);
  }
};

/// One number for surge and sway.
inline double root_mean_square(const double* axes) {
  return std::hypot(axes[0], axes[1]) / std::sqrt(2.0);
}

}  // namespace detail

/// Noise of the filter on board: the model's own and that of its parameter errors. All disturbances
/// share one time constant, the mean; each keeps its power at low frequencies.
inline NoiseParameters onboard_noise(const NoiseParameters& model, const ErrorNoise& d) {
  const double linear = detail::root_mean_square(d.disturbance);
  const double walk = detail::root_mean_square(d.walk);
  const NoiseParameters own = linear > 0.0 || walk > 0.0 ? equal_in_plane(model) : model;
  const double power[2] = {d.disturbance[0] * std::sqrt(d.memory[0]),
                           d.disturbance[1] * std::sqrt(d.memory[1])};
  const double ratio = linear > 0.0 ? detail::root_mean_square(power) / linear : 0.0;
  const detail::SumOfDisturbances ahead(own.disturbance_linear, own.memory, linear, ratio * ratio);
  const detail::SumOfDisturbances turning(own.disturbance_yaw, own.memory, d.disturbance[2],
                                          d.memory[2]);
  const NoiseParameters& least = detail::kLeastNoise;
  NoiseParameters n = own;
  n.position = std::max(own.position, least.position);
  n.heading = std::max(own.heading, least.heading);
  n.walk_linear = std::max(std::hypot(own.walk_linear, walk), least.walk_linear);
  n.walk_yaw = std::max(std::hypot(own.walk_yaw, d.walk[2]), least.walk_yaw);
  n.memory = std::max(0.5 * (ahead.memory + turning.memory), least.memory);
  n.disturbance_linear =
      std::max(ahead.spread * std::sqrt(ahead.memory / n.memory), least.disturbance_linear);
  n.disturbance_yaw =
      std::max(turning.spread * std::sqrt(turning.memory / n.memory), least.disturbance_yaw);
  if (!own.coloured()) return n;
  n.colour_position = std::max(own.colour_position, least.colour_position);
  n.colour_heading = std::max(own.colour_heading, least.colour_heading);
  n.colour_memory = std::max(own.colour_memory, least.colour_memory);
  return n;
}

/// Noise and considered errors of a boat whose model has the noise `own`. explained: whether
/// structure and noise explain the data, see above.
inline void set_uncertainty(const UncertainModel& m, const NoiseParameters& own, bool explained,
                            OnboardBoat& boat) {
  boat.noise = onboard_noise(own, explained ? ErrorNoise{} : error_noise(m));
  boat.considered = explained ? principal_errors(m) : PrincipalErrors{};
}

}  // namespace seatrial
