// SPDX-License-Identifier: MIT
// What Python gives the estimator's filter: the poses of a recording, effects, blocks. All checked.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <optional>
#include <tuple>
#include <vector>

#include "arrays.hpp"
#include "seatrial/filter/filter_types.hpp"
#include "seatrial/integration/step_schedule.hpp"

namespace {

using namespace seatrial;

void check_trace(const Boat& boat, const ThrustTrace& trace) {
  require(boat.structure.n_forces == trace.chain().n_forces,
          "structure and chain differ in forces");
  for (int i = 0; i < trace.columns().n_coefficients; ++i) {
    const int c = trace.columns().coefficient[i];
    require(c >= 0 && c < boat.structure.n_coefficients, "coefficient out of range");
  }
}

constexpr double kLongestDelay = 10.0;  // [s] twice that of a vehicle file: between two delays

/// Asynchronous measurements: time [s], Parts, value [rad or rad/s], deviation of rates
/// [rad/s].
using Asynchronous = std::tuple<Vector, Flags, Vector, double>;

/// Errors of the input: time (m) [s], and covariance (m, 6) of what they changed the velocity by up
/// to then: uu, uv, ur, vv, vr, rr.
using InputErrors = std::tuple<Vector, Matrix>;

/// Poses of one recording, and its start.
struct Series {
  PoseSeries poses;
  FilterStart start{};
  std::vector<double> time;
  std::vector<double> eta;
  std::vector<signed char> use;
  std::vector<double> velocities;
  std::vector<Parts> parts;
  std::vector<double> asynchronous_time;
  std::vector<double> asynchronous_value;
  std::vector<Parts> asynchronous_parts;
  std::vector<double> input_error_time;
  std::vector<double> input_error;

  Series(Vector t, Matrix e, Flags u, Vector x0, Vector velocity, std::optional<Matrix> afresh,
         double position_delay, std::optional<Flags> measured,
         std::optional<Asynchronous> asynchronous, std::optional<InputErrors> input_errors) {
    const std::size_t n = t.shape(0);
    require(n > 1 && e.shape(0) == n && e.shape(1) == kPose && u.shape(0) == n,
            "eta: n x 3, use: n");
    require(x0.shape(0) == kStates && velocity.shape(0) == kAxes, "start: 6, velocity: 3");
    time.assign(t.data(), t.data() + n);
    eta.assign(e.data(), e.data() + n * kPose);
    use.assign(u.data(), u.data() + n);
    std::copy(x0.data(), x0.data() + kStates, start.state);
    std::copy(velocity.data(), velocity.data() + kAxes, start.velocity);
    require(!afresh || (afresh->shape(0) == n && afresh->shape(1) == kAxes), "afresh: n x 3");
    require(afresh || std::find(use.begin(), use.end(), kBeginning) == use.end(),
            "USE_BEGINNING: a velocity to begin with expected");
    if (afresh) velocities.assign(afresh->data(), afresh->data() + n * kAxes);
    require(std::abs(position_delay) <= kLongestDelay, "position_delay: at most 10 s");
    poses = {static_cast<int>(n), time.data(),       eta.data(),
             use.data(),          velocities.data(), position_delay};
    if (measured) {
      require(measured->shape(0) == n, "parts: n");
      take_parts(*measured, kWholePose, parts);
      poses.parts = parts.data();
    }
    if (asynchronous) take_asynchronous(*asynchronous);
    if (input_errors) take_input_errors(*input_errors);
  }
  Series(const Series&) = delete;
  Series& operator=(const Series&) = delete;

 private:
  static void take_parts(const Flags& from, int most, std::vector<Parts>& to) {
    for (std::size_t i = 0; i < from.shape(0); ++i) {
      require(from(i) >= 0 && from(i) <= most, "parts: position 1, heading 2, both 3; rate 4");
      to.push_back(static_cast<Parts>(from(i)));
    }
  }

  void take_input_errors(const InputErrors& errors) {
    const auto& [t, covariance] = errors;
    const std::size_t m = t.shape(0);
    require(covariance.shape(0) == m && covariance.shape(1) == 6, "input_errors: (m), m x 6");
    for (std::size_t i = 1; i < m; ++i) {
      require(t(i) > t(i - 1), "input_errors: rising times");
      for (std::size_t j : {0, 3, 5}) {
        require(covariance(i, j) >= covariance(i - 1, j), "input_errors: variances that grow");
      }
    }
    input_error_time.assign(t.data(), t.data() + m);
    input_error.assign(covariance.data(), covariance.data() + m * 6);
    poses.n_input_errors = static_cast<int>(m);
    poses.input_error_time = input_error_time.data();
    poses.input_error = input_error.data();
  }

  void take_asynchronous(const Asynchronous& asynchronous) {
    const auto& [t, kinds, values, deviation] = asynchronous;
    const std::size_t m = t.shape(0);
    require(kinds.shape(0) == m && values.shape(0) == m,
            "asynchronous: time, parts, value: one each");
    asynchronous_time.assign(t.data(), t.data() + m);
    asynchronous_value.assign(values.data(), values.data() + m);
    take_parts(kinds, kRatePart, asynchronous_parts);
    bool rates = false;
    for (std::size_t i = 0; i < m; ++i) {
      require(asynchronous_parts[i] == kHeadingPart || asynchronous_parts[i] == kRatePart ||
                  asynchronous_parts[i] == kNoPart,
              "asynchronous: heading 2, rate 4, or none 0");
      require(asynchronous_time[i] >= (i == 0 ? time[0] : asynchronous_time[i - 1]),
              "asynchronous: times that rise from the first pose's");
      require(std::isfinite(asynchronous_value[i]), "asynchronous: finite values");
      rates = rates || asynchronous_parts[i] == kRatePart;
    }
    require(!rates || deviation > 0.0, "asynchronous: a positive deviation of the rates");
    poses.n_asynchronous = static_cast<int>(m);
    poses.asynchronous_time = asynchronous_time.data();
    poses.asynchronous_value = asynchronous_value.data();
    poses.asynchronous_parts = asynchronous_parts.data();
    poses.rate_deviation = deviation;
  }
};

Effects make_effects(const Vector& effects) {
  require(effects.shape(0) == kEffects,
          "effects: lever (2), current (2), bias (3), wind (6), delays (2)");
  const double* from = effects.data();
  Effects out;
  std::copy(from + kLever, from + kLever + 2, out.lever);
  std::copy(from + kCurrent, from + kCurrent + 2, out.current);
  std::copy(from + kBias, from + kBias + kAxes, out.bias);
  std::copy(from + kWind, from + kWind + kWindParts, out.wind);
  out.position_delay = from[kDelay];
  out.heading_delay = from[kDelay + 1];
  for (int i = 0; i < 2; ++i) {
    require(std::abs(from[kDelay + i]) <= kLongestDelay, "delays: at most 10 s");
  }
  return out;
}

void check_blocks(const Series& series, const std::optional<Places>& blocks) {
  if (!blocks) return;
  require(blocks->shape(0) == series.time.size(), "blocks: one for each pose");
  const int* at = blocks->data();
  for (std::size_t k = 1; k < series.time.size(); ++k) {
    require(at[k - 1] >= 0 && at[k] >= at[k - 1], "blocks: rising from 0");
  }
}

void check_filter_trace(const Boat& boat, const ThrustTrace& trace) {
  check_trace(boat, trace);
  const Columns& columns = trace.columns();
  require(columns.n_initial == kStates && columns.n_coefficients >= kAxes &&
              columns.coefficient[columns.n_coefficients - kAxes] ==
                  boat.structure.n_coefficients - kAxes,
          "columns: initial state, then coefficients that end with the disturbance's three");
}

}  // namespace
