// SPDX-License-Identifier: MIT
// A model with the covariance of its parameters, and a simulated drive with random commands that
// shows the effect of parameter errors. Host side: uses heap.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "seatrial/filter/schmidt_kalman.hpp"
#include "seatrial/integration/step_schedule.hpp"
#include "seatrial/onboard/health.hpp"

namespace seatrial {

inline constexpr int kMaxParameters = kMaxCoefficients + kMaxConstants;

/// A model with the covariance of its parameters and the range of its identification.
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
inline constexpr double kDriveStep = 0.1;       // [s] between instants
inline constexpr int kTicks = 6000;             // ten minutes
inline constexpr int kEnough = kTicks / 10;     // instants that a sum needs
inline constexpr int kPiece = 100;              // ticks that are scheduled at once
inline constexpr double kGentlest = 1.0 / 64;   // least share of full commands
inline constexpr double kScaled[2] = {0.7,
                                      1.3};  // range of a scale signal, relative to its reference

/// Splitmix64: the same numbers on every machine.
class SplitMix {
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

/// Random commands and scale signals of a drive.
struct RandomCommands {
  int n_commands;
  int n_scales;
  std::vector<double> time;   // [s]
  std::vector<double> value;  // rows of commands
  std::vector<double> scale;  // rows of scales

  RandomCommands(const Chain& c, double most)
      : n_commands(c.allocation.n_commands), n_scales(c.n_scales) {
    SplitMix dice;
    SplitMix other;
    double t = 0.0;
    while (t < kDriveStep * kTicks) {
      time.push_back(t);
      for (int j = 0; j < n_commands; ++j) value.push_back(dice(-most, most));
      for (int j = 0; j < n_scales; ++j) {
        scale.push_back(c.scale_reference[j] * other(kScaled[0], kScaled[1]));
      }
      t += dice(kHold[0], kHold[1]);
    }
  }

  Held commands() const {
    return {static_cast<int>(time.size()), n_commands, time.data(), value.data()};
  }
  Held scales() const {
    return {n_scales > 0 ? static_cast<int>(time.size()) : 0, n_scales, time.data(), scale.data()};
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

/// A drive from rest with random commands up to `most`. At each tick `look(trace, t, x, dx)` sees
/// state and slopes to all parameters within the envelope; false: the boat begins at rest again.
/// The number of ticks that were good.
template <class Look>
inline int random_drive(const UncertainModel& m, double most, Look look) {
  const Columns columns = all_columns(m);
  const RandomCommands sticks(m.chain, most);
  const ThrustTrace trace(m.chain, m.q, sticks.commands(), sticks.scales(), columns);
  Boat boat = m.boat;
  boat.integrator = Integrator::kRungeKutta;
  boat.longest_step = kDriveStep;
  std::vector<double> time;
  for (int i = 0; i <= kTicks; ++i) time.push_back(kDriveStep * i);
  int instants = 0;
  double x[kStates] = {};
  StateSensitivities dx;
  seed(columns, dx);
  for (int i = 0; i < kTicks; i += kPiece) {
    for (int a = 0; a < kAxes; ++a) std::fill(dx.row[a], dx.row[a] + columns.size(), 0.0);
    const StepSchedule schedule(boat, trace, time.data(), i, i + kPiece, true);
    for (int k = i; k < i + kPiece; ++k) {
      bool good = schedule.run(k, x, dx);
      if (good && !Envelope::outside(x + 3, m.speed, kAxes)) {
        good = look(trace, time[static_cast<std::size_t>(k) + 1], x, dx);
        if (good) ++instants;
      }
      if (good) continue;
      std::fill(x, x + kStates, 0.0);
      seed(columns, dx);
    }
  }
  return instants;
}

}  // namespace detail

/// Calls `sum(most)` with random commands up to `most`, at first full ones, until it returns true:
/// until the boat stays within its envelope for a tenth of the time. False: there are no such
/// commands, or the parameters have no errors.
template <class Sum>
inline bool with_strongest_commands(const UncertainModel& m, Sum sum) {
  bool uncertain = false;
  for (int i = 0; i < m.n_parameters(); ++i) uncertain = uncertain || m.covariance[i][i] > 0.0;
  for (double most = 1.0; uncertain && most >= detail::kGentlest; most *= 0.5) {
    if (sum(most)) return true;
  }
  return false;
}

}  // namespace seatrial
