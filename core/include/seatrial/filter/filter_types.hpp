// SPDX-License-Identifier: MIT
// What the estimator's filter takes and leaves: noise, starts, effects, poses; a pass along them.
// Host side: uses heap.
#pragma once
#include <cmath>
#include <vector>

#include "seatrial/filter/noise_parameters.hpp"
#include "seatrial/integration/step.hpp"

namespace seatrial {

inline constexpr int kFilterStates = kStates + kAxes;  // x, y, psi, u, v, r, d_u, d_v, d_r
inline constexpr int kPose = 3;                        // x, y [m], psi [rad] are measured
inline constexpr double kPoseSpread = 3.0;  // of the first pose, in standard deviations of one

inline constexpr int kNoiseParameters = 11;
inline constexpr int kTurnParameter = 10;
inline constexpr double kNoColour = 1e-8;  // [m, rad] correlated errors below this: none

/// Standard deviations and spectra that the filter believes in; the estimator's noise parameters
/// are their logarithms, in this order.
struct FilterNoise {
  double position;            // [m] of the poses
  double heading;             // [rad]
  double walk_linear;         // [m/s / sqrt(s)] random walk of u and v
  double walk_yaw;            // [rad/s / sqrt(s)]
  double disturbance_linear;  // [m/s^2] that comes and goes, in surge and sway
  double disturbance_yaw;     // [rad/s^2]
  double memory;              // [s] time constant of the disturbance
  double colour_position;     // [m] correlated errors of the poses, beside the white ones
  double colour_heading;      // [rad]
  double colour_memory;       // [s] time constant of these
  double colour_turn;         // [rad/s] how fast they swing meanwhile, as waves make them
  double outlier;             // innovations beyond so many sigma count linearly; infinity: never

  bool coloured() const { return colour_position > kNoColour || colour_heading > kNoColour; }
  bool swinging() const { return coloured() && colour_turn > kNoTurn; }
  double pose(int i) const { return i < 2 ? position : heading; }
  double colour(int i) const { return i < 2 ? colour_position : colour_heading; }
  double walk(int axis) const { return axis < 2 ? walk_linear : walk_yaw; }
  double disturbance(int axis) const { return axis < 2 ? disturbance_linear : disturbance_yaw; }
  double& parameter(int i) {
    double* const all[kNoiseParameters] = {
        &position,           &heading,         &walk_linear, &walk_yaw,
        &disturbance_linear, &disturbance_yaw, &memory,      &colour_position,
        &colour_heading,     &colour_memory,   &colour_turn};
    return *all[i];
  }
};

/// What is known of a recording's start: the state, and the standard deviations of its velocity.
/// The pose is as uncertain as three measurements of it, the disturbance as it ever is.
struct FilterStart {
  double state[kStates];   // x, y [m], psi [rad], u, v [m/s], r [rad/s]
  double velocity[kAxes];  // [m/s, m/s, rad/s]
};

/// What stands between boat and sensor, or differs from one recording to the next.
struct Effects {
  double lever[2] = {0.0, 0.0};      // [m] the measured point, forward and left of the origin
  double current[2] = {0.0, 0.0};    // [m/s] earth-fixed; the velocity is then that in the water
  double bias[3] = {0.0, 0.0, 0.0};  // [m/s^2, rad/s^2] body-fixed: trim
  double wind[2] = {0.0, 0.0};       // [m/s^2] earth-fixed
  bool earth_fixed = false;  // whether the disturbance is, as wind is, or turns with the boat
};
enum Effect { kLever = 0, kCurrent = 2, kBias = 4, kWind = 7 };  // where each begins, as parameters
inline constexpr int kEffects = 9;

/// What a pose is to the filter.
enum Use : signed char {
  kNotMeasured = 0,
  kMeasured = 1,
  kJumped = 2,     // the first after a jump for good: it may be anywhere
  kGapped = 3,     // the first after a gap, in which the poses may have jumped
  kBeginning = 4,  // the first by which it is known again what drives the boat
};

/// Poses of one recording.
struct PoseSeries {
  int n = 0;
  const double* time = nullptr;      // (n) [s], rising
  const double* eta = nullptr;       // (n, 3)
  const signed char* use = nullptr;  // (n) Use
  const double* velocity = nullptr;  // (n, 3) [m/s, m/s, rad/s] of those that are kBeginning
};

/// What of the state the motion depends on: psi, u, v, r and the disturbance, not where it is.
inline constexpr int kMoving = kFilterStates - 2;

/// What filters have in common between two poses, whatever noise they believe.
struct Interval {
  /// From a heading [rad] over `length` [s]; what fades does so as this noise has it.
  Interval(const FilterNoise& noise, double psi, double length)
      : length(length),
        cos(std::cos(psi)),
        sin(std::sin(psi)),
        memory(noise.memory),
        fade(std::exp(-length / noise.memory)),
        colour_memory(noise.colour_memory),
        colour_fade(noise.coloured() ? std::exp(-length / noise.colour_memory) : 0.0),
        colour_turn(noise.colour_turn),
        swing(noise.swinging() ? Swing(noise.colour_memory, noise.colour_turn, length) : Swing()) {}

  /// What is left after it of what fades with a time constant `tau` [s].
  double disturbance_after(double tau) const {
    return tau == memory ? fade : std::exp(-length / tau);
  }
  double colour_after(double tau) const {
    return tau == colour_memory ? colour_fade : std::exp(-length / tau);
  }
  /// The same of errors that swing at `turn` [rad/s].
  Swing swing_after(double tau, double turn) const {
    return tau == colour_memory && turn == colour_turn ? swing : Swing(tau, turn, length);
  }

  double length;  // [s]
  double cos, sin;
  double memory, fade;
  double colour_memory, colour_fade;
  double colour_turn;
  Swing swing;
};

/// How the filter went from one pose to the next: enough to repeat the way with other noise. Long
/// recordings have many: the slopes are stored short, less the identity, which keeps their digits.
struct Transition {
  double to[kStates];             // where the model took the boat
  float slope[kStates][kMoving];  // d to / d what it depends on, less 1 for the same state
};

/// A pose beside its prediction.
struct Innovation {
  double e[kPose];         // [m, m, rad]
  double s[kPose][kPose];  // its covariance
  double weight;           // 1; less for an outlier
  double cost;             // rho(e' S^-1 e) + log det S
};

/// What a pass accumulates. Parameters: the chosen coefficients, then the chosen constants, then
/// all effects where they are asked for.
struct FilterPass {
  int parameters = 0;
  bool good = true;
  Effects effects;
  double cost = 0.0;                // sum of rho(e' S^-1 e) + log det S over measured poses
  std::vector<double> information;  // (p, p) sum of J' S^-1 J
  std::vector<double> gradient;     // (p) sum of J' S^-1 e
  std::vector<double> score;        // (blocks, p) terms of the gradient
  std::vector<double> share;        // (blocks, p, p) terms of the information, where asked for
  std::vector<double> innovation;   // (n, 3)
  std::vector<float> spread;        // (n, 6) S: xx, xy, xpsi, yy, ypsi, psipsi
  std::vector<double> state;        // (n, 9) after the pose was used
  std::vector<float> deviation;     // (n, 3) standard deviations of the velocity after it
  std::vector<float> weight;        // (n) of each pose: 1, less for outliers, 0 for unused ones
  std::vector<Transition> way;      // (n - 1), until it is forgotten
};

}  // namespace seatrial
