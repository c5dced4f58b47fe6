// SPDX-License-Identifier: MIT
// What a model's covariance amounts to on board: errors of its parameters as a random walk of the
// velocity. Host side: uses heap.
//
// Along a drive the errors e (covariance C) make the velocity wrong by S e, S = d nu / d
// parameters, with covariance P = S C S'. A walk of power Q has dP/dt = J P + P J' + Q, J = d
// nu_dot / d nu. On average P neither grows nor shrinks, so that Q = -(J P + P J'), averaged over
// the drive, is the walk which makes the velocity as wrong. Errors that cancel where the boat goes
// cancel in S.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "seatrial/belief.hpp"
#include "seatrial/health.hpp"
#include "seatrial/schedule.hpp"

namespace seatrial {

inline constexpr int kMaxParameters = kMaxCoefficients + kMaxConstants;

/// A model, with what is known of its errors and where it was identified.
struct UncertainModel {
  Boat boat;
  Chain chain;
  double q[kMaxConstants] = {};
  double speed[kAxes][2] = {};                             // [m/s, m/s, rad/s] least, most
  double covariance[kMaxParameters][kMaxParameters] = {};  // coefficients, then constants

  int n_parameters() const { return boat.structure.n_coefficients + chain.n_constants; }
};

namespace detail {

inline constexpr double kHold[2] = {1.0, 3.0};  // [s] that a command is held
inline constexpr double kTick = 0.1;            // [s] between the instants that are averaged
inline constexpr int kTicks = 6000;             // ten minutes
inline constexpr int kEnough = kTicks / 10;     // instants that an average is made of
inline constexpr int kPiece = 100;              // ticks that are scheduled at once
inline constexpr double kGentlest = 1.0 / 64;   // share of full commands

/// Less is not believed, so that the covariance keeps its digits.
inline constexpr MotionNoise kLeastNoise{1e-4, 1e-4, 1e-6, 1e-6, 1e-5, 1e-5, 0.3, 1e-5, 1e-5, 0.02};

/// Splitmix64: the same numbers on every machine.
class Dice {
 public:
  double operator()(double low, double high) {
    std::uint64_t z = state_ += 0x9e3779b97f4a7c15U;
    z = (z ^ (z >> 30U)) * 0xbf58476d1ce4e5b9U;
    z = (z ^ (z >> 27U)) * 0x94d049bb133111ebU;
    z ^= z >> 31U;
    return low + (high - low) * std::ldexp(static_cast<double>(z >> 11U), -53);
  }

 private:
  std::uint64_t state_ = 0;
};

/// Commands of a drive, each to any other.
struct Sticks {
  std::vector<double> time;   // [s]
  std::vector<double> value;  // rows of n_commands

  Sticks(int n_commands, double most) {
    Dice dice;
    double t = 0.0;
    while (t < kTick * kTicks) {
      time.push_back(t);
      for (int j = 0; j < n_commands; ++j) value.push_back(dice(-most, most));
      t += dice(kHold[0], kHold[1]);
    }
  }

  Held held(int n_commands) const {
    return {static_cast<int>(time.size()), n_commands, time.data(), value.data()};
  }
};

/// All coefficients and constants.
inline Columns all_columns(const UncertainModel& m) {
  Columns columns;
  columns.n_coefficients = m.boat.structure.n_coefficients;
  columns.n_constants = m.chain.n_constants;
  for (int i = 0; i < columns.n_coefficients; ++i) columns.coefficient[i] = i;
  for (int i = 0; i < columns.n_constants; ++i) columns.constant[i] = i;
  return columns;
}

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

/// The boat at one instant of a drive.
struct Glance {
  AccelerationJacobian j;
  double slope[kAxes][kMaxColumns] = {};  // d nu_dot / d parameters
  bool good = false;

  Glance(const UncertainModel& m, const Trace& trace, double t, const double* nu) {
    const double still[kMaxConstants] = {0.0};
    const Columns& columns = trace.columns();
    Thrust f;
    ThrustTangent df;
    StepForces forces;
    double nu_dot[kAxes];
    trace.at(trace.find(t), t, nullptr, f, df);
    step_forces_tangent(m.chain, m.q, columns, 0.0, still, f, df, forces);
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

/// Sums over a drive.
struct DriveSums {
  double variance[kAxes] = {};  // of the acceleration, by all but latency and lag
  double pushed[kAxes] = {};    // power, by the same
  double kicked[kAxes] = {};    // power, by latency and lag
  int instants = 0;             // within the envelope
};

/// add[a] += power of the noise that would make the velocity as wrong.
inline bool add_power(const AccelerationJacobian& j, const StateTangent& dx,
                      const UncertainModel& m, double* add) {
  double p[kAxes][kAxes];
  covariance_of(dx.row + 3, m.covariance, m.n_parameters(), p);
  for (int a = 0; a < kAxes; ++a) {
    for (int b = 0; b < kAxes; ++b) add[a] -= 2.0 * j.nu[a][b] * p[b][a];
  }
  return std::isfinite(add[0] + add[1] + add[2]);
}

/// A drive from rest with commands up to `most`; where it is outside the envelope is not counted.
inline DriveSums random_drive(const UncertainModel& m, const UncertainModel& timing, double most) {
  const Columns columns = all_columns(m);
  const Sticks sticks(m.chain.allocation.n_commands, most);
  const Trace trace(m.chain, m.q, sticks.held(m.chain.allocation.n_commands), Held{}, columns);
  Boat boat = m.boat;
  boat.integrator = Integrator::kRungeKutta;
  boat.longest_step = kTick;
  std::vector<double> time;
  for (int i = 0; i <= kTicks; ++i) time.push_back(kTick * i);
  DriveSums sum;
  double x[kStates] = {};
  StateTangent dx;
  seed(columns, dx);
  for (int i = 0; i < kTicks; i += kPiece) {
    const Schedule schedule(boat, trace, time.data(), i, i + kPiece, true);
    for (int k = i; k < i + kPiece; ++k) {
      bool good = schedule.run(k, x, dx);
      if (good && !Envelope::outside(x + 3, m.speed, kAxes)) {
        const Glance now(m, trace, time[static_cast<std::size_t>(k) + 1], x + 3);
        DriveSums next = sum;
        good = now.good && add_power(now.j, dx, m, next.pushed) &&
               add_power(now.j, dx, timing, next.kicked);
        double p[kAxes][kAxes];
        covariance_of(now.slope, m.covariance, m.n_parameters(), p);
        for (int a = 0; a < kAxes; ++a) next.variance[a] += p[a][a];
        ++next.instants;
        if (good) sum = next;
      }
      if (good) continue;  // else at rest again
      std::fill(x, x + kStates, 0.0);
      seed(columns, dx);
    }
  }
  return sum;
}

}  // namespace detail

/// What the errors of a model do as it is driven.
struct Doubt {
  double disturbance[kAxes] = {};  // [m/s^2, m/s^2, rad/s^2] standard deviations
  double memory[kAxes] = {};       // [s]
  double walk[kAxes] = {};         // [m/s, m/s, rad/s per sqrt(s)]
};

/// The doubt about a model, under random commands up to the stops, or as strong as leave the boat
/// within its envelope for a tenth of the time. None where no such command is found.
inline Doubt doubt(const UncertainModel& m) {
  Doubt out;
  bool doubted = false;
  for (int i = 0; i < m.n_parameters(); ++i) doubted = doubted || m.covariance[i][i] > 0.0;
  const UncertainModel lasting = detail::part_of(m, false);
  const UncertainModel timing = detail::part_of(m, true);
  for (double most = 1.0; doubted && most >= detail::kGentlest; most *= 0.5) {
    const detail::DriveSums sum = detail::random_drive(lasting, timing, most);
    if (sum.instants < detail::kEnough) continue;
    for (int a = 0; a < kAxes; ++a) {
      const double variance = std::max(sum.variance[a] / sum.instants, 0.0);
      const double power = std::max(sum.pushed[a] / sum.instants, 0.0);
      out.disturbance[a] = std::sqrt(variance);
      if (variance > 0.0) out.memory[a] = power / (2.0 * variance);
      out.walk[a] = std::sqrt(std::max(sum.kicked[a] / sum.instants, 0.0));
    }
    break;
  }
  return out;
}

namespace detail {

/// Disturbances of two causes as one: their variances and their powers add up.
struct Together {
  double spread = 0.0;  // standard deviation
  double memory = 0.0;  // [s]

  Together(double own, double own_memory, double more, double more_memory)
      : spread(std::hypot(own, more)) {
    const double share = more > 0.0 ? (more / spread) * (more / spread) : 0.0;
    memory = own_memory + share * (more_memory - own_memory);
  }
};

/// Surge and sway share one number.
inline double root_mean_square(const double* axes) {
  return std::hypot(axes[0], axes[1]) / std::sqrt(2.0);
}

}  // namespace detail

/// The noise that the on-board filter believes: the model's own, and what its errors do. All
/// disturbances have one memory, the mean; with it each keeps its power at low frequencies.
inline MotionNoise believed_noise(const MotionNoise& own, const Doubt& d) {
  const double linear = detail::root_mean_square(d.disturbance);
  const double power[2] = {d.disturbance[0] * std::sqrt(d.memory[0]),
                           d.disturbance[1] * std::sqrt(d.memory[1])};
  const double ratio = linear > 0.0 ? detail::root_mean_square(power) / linear : 0.0;
  const detail::Together ahead(own.disturbance_linear, own.memory, linear, ratio * ratio);
  const detail::Together turning(own.disturbance_yaw, own.memory, d.disturbance[2], d.memory[2]);
  const MotionNoise& least = detail::kLeastNoise;
  MotionNoise n = own;
  n.position = std::max(own.position, least.position);
  n.heading = std::max(own.heading, least.heading);
  n.walk_linear =
      std::max(std::hypot(own.walk_linear, detail::root_mean_square(d.walk)), least.walk_linear);
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

}  // namespace seatrial
