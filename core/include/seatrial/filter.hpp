// SPDX-License-Identifier: MIT
// The extended Kalman filter whose prediction errors the estimator looks at, with its
// sensitivities.
//
// The state is the boat's (6) and a disturbance (3): body-fixed accelerations that come and go with
// a time constant. Host side: uses heap.
#pragma once
#include <algorithm>
#include <cmath>
#include <vector>

#include "seatrial/schedule.hpp"

namespace seatrial {

inline constexpr int kFilterStates = kStates + kAxes;  // x, y, psi, u, v, r, d_u, d_v, d_r
inline constexpr int kPose = 3;                        // x, y [m], psi [rad] are measured
inline constexpr double kPoseSpread = 3.0;  // of the first pose, in standard deviations of one

inline constexpr int kNoiseParameters = 7;

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
  double outlier;             // innovations beyond so many sigma count linearly; infinity: never

  double pose(int i) const { return i < 2 ? position : heading; }
  double walk(int axis) const { return axis < 2 ? walk_linear : walk_yaw; }
  double disturbance(int axis) const { return axis < 2 ? disturbance_linear : disturbance_yaw; }
  double& parameter(int i) {
    double* const all[kNoiseParameters] = {
        &position,           &heading,         &walk_linear, &walk_yaw,
        &disturbance_linear, &disturbance_yaw, &memory};
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
};
enum Effect { kLever = 0, kCurrent = 2, kBias = 4, kWind = 7 };  // where each begins, as parameters
inline constexpr int kEffects = 9;

/// Poses of one recording.
struct PoseSeries {
  int n = 0;
  const double* time = nullptr;      // (n) [s], rising
  const double* eta = nullptr;       // (n, 3)
  const signed char* use = nullptr;  // (n) 0: not measured; 1: measured; 2: after a jump for good
};

/// How the filter went from one pose to the next: enough to repeat the way with other noise.
struct Transition {
  double from[kFilterStates];            // state that it began with
  double to[kFilterStates];              // where the model took it
  double slope[kStates][kFilterStates];  // d to / d from, of the boat's states
  double length;                         // [s]
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
  std::vector<double> score;        // (n, p) terms of the gradient, pose by pose
  std::vector<double> innovation;   // (n, 3)
  std::vector<double> spread;       // (n, 6) S: xx, xy, xpsi, yy, ypsi, psipsi
  std::vector<double> state;        // (n, 9) after the pose was used
  std::vector<double> deviation;    // (n, 9) standard deviations of the state
  std::vector<double> weight;       // (n) of each pose: 1, less for outliers, 0 for unused ones
  std::vector<Transition> way;      // (n - 1)
};

namespace detail {

inline constexpr int kMaxParameters = kMaxColumns + kEffects;
using Covariance = double[kFilterStates][kFilterStates];

/// Inverse of a symmetric 3 x 3, and its determinant.
inline double inverse3(const double s[3][3], double inverse[3][3]) {
  const double c0 = s[1][1] * s[2][2] - s[1][2] * s[2][1];
  const double c1 = s[1][2] * s[2][0] - s[1][0] * s[2][2];
  const double c2 = s[1][0] * s[2][1] - s[1][1] * s[2][0];
  const double determinant = s[0][0] * c0 + s[0][1] * c1 + s[0][2] * c2;
  const double d = 1.0 / determinant;
  inverse[0][0] = c0 * d;
  inverse[0][1] = inverse[1][0] = c1 * d;
  inverse[0][2] = inverse[2][0] = c2 * d;
  inverse[1][1] = (s[0][0] * s[2][2] - s[0][2] * s[2][0]) * d;
  inverse[1][2] = inverse[2][1] = (s[0][1] * s[2][0] - s[0][0] * s[2][1]) * d;
  inverse[2][2] = (s[0][0] * s[1][1] - s[0][1] * s[1][0]) * d;
  return determinant;
}

/// The filter between two poses.
class Filter {
 public:
  Filter(const Columns& columns, const FilterNoise& noise, const FilterStart& start,
         const Effects& effects, bool slopes)
      : columns_(columns),
        noise_(noise),
        effects_(effects),
        own_(columns.size() - kStates - kAxes),
        parameters_(own_ + (slopes ? kEffects : 0)) {
    std::copy(start.state, start.state + kStates, x_);
    std::fill(x_ + kStates, x_ + kFilterStates, 0.0);
    for (int i = 0; i < kFilterStates; ++i) {
      const double sigma = i < kPose     ? kPoseSpread * noise.pose(i)
                           : i < kStates ? start.velocity[i - kPose]
                                         : noise.disturbance(i - kStates);
      std::fill(p_[i], p_[i] + kFilterStates, 0.0);
      p_[i][i] = sigma * sigma;
      std::fill(d_[i], d_[i] + kMaxParameters, 0.0);
    }
    take_off_lever();
  }

  const double* state() const { return x_; }
  double variance(int i) const { return p_[i][i]; }
  int parameters() const { return parameters_; }

  /// To the next pose. False where the boat diverged.
  bool predict(const Schedule& schedule, int interval, Boat& boat, double length, Transition& way) {
    StateTangent dx;
    seed(columns_, dx);
    const int first = boat.structure.n_coefficients - kAxes;
    const double c = std::cos(x_[2]);
    const double s = std::sin(x_[2]);
    const double* w = effects_.wind;
    const double wind[kAxes] = {c * w[0] + s * w[1], c * w[1] - s * w[0], 0.0};
    for (int a = 0; a < kAxes; ++a) {
      boat.coefficient[first + a] = x_[kStates + a] + effects_.bias[a] + wind[a];
    }
    std::copy(x_, x_ + kFilterStates, way.from);
    if (!schedule.run(interval, x_, dx)) return false;
    const int force = kStates + columns_.n_coefficients - kAxes;
    for (int i = 0; i < kStates; ++i) {
      std::copy(dx.row[i], dx.row[i] + kStates, way.slope[i]);
      std::copy(dx.row[i] + force, dx.row[i] + force + kAxes, way.slope[i] + kStates);
      // a turn of the boat turns the wind on it
      way.slope[i][2] += way.slope[i][kStates] * wind[1] - way.slope[i][kStates + 1] * wind[0];
    }
    std::copy(x_, x_ + kFilterStates, way.to);
    way.length = length;
    const double stays = std::exp(-length / noise_.memory);
    for (int i = kStates; i < kFilterStates; ++i) x_[i] *= stays;
    carry_sensitivity(dx, way, stays, c, s);
    carry_covariance(way, stays);
    add_process_noise(way.from[2], length, stays);
    return true;
  }

  /// The same way again, linearised about where it went then.
  void repeat(const Transition& way) {
    double off[kFilterStates];
    for (int i = 0; i < kFilterStates; ++i) off[i] = x_[i] - way.from[i];
    for (int i = 0; i < kStates; ++i) {
      double sum = way.to[i];
      for (int j = 0; j < kFilterStates; ++j) sum += way.slope[i][j] * off[j];
      x_[i] = sum;
    }
    const double stays = std::exp(-way.length / noise_.memory);
    for (int i = kStates; i < kFilterStates; ++i) x_[i] *= stays;
    carry_covariance(way, stays);
    add_process_noise(way.from[2], way.length, stays);
  }

  /// The pose may be anywhere: it jumped.
  void loosen(double position, double heading) {
    for (int i = 0; i < kPose; ++i) {
      for (int j = 0; j < kFilterStates; ++j) p_[i][j] = p_[j][i] = 0.0;
      p_[i][i] = i < 2 ? position * position : heading * heading;
    }
  }

  /// Use a pose of time t [s]; writes row k of the pass. `counts`: how often it counts.
  void update(const double* eta, double t, double counts, int k, FilterPass& pass) {
    const double cp = std::cos(x_[2]);
    const double sp = std::sin(x_[2]);
    const double* l = effects_.lever;
    const double arm[2] = {cp * l[0] - sp * l[1], sp * l[0] + cp * l[1]};
    const double turn[kPose] = {-arm[1], arm[0], 0.0};  // d measured / d psi, beyond the state's
    double hp[kPose][kFilterStates];
    double s[kPose][kPose];
    double inverse[kPose][kPose];
    double e[kPose];
    for (int i = 0; i < kPose; ++i) {
      const double moved = i < 2 ? arm[i] + effects_.current[i] * t : 0.0;
      e[i] = eta[i] - x_[i] - moved;
      for (int j = 0; j < kFilterStates; ++j) hp[i][j] = p_[i][j] + turn[i] * p_[2][j];
    }
    for (int i = 0; i < kPose; ++i) {
      for (int j = 0; j < kPose; ++j) s[i][j] = hp[i][j] + hp[i][2] * turn[j];
      s[i][i] += noise_.pose(i) * noise_.pose(i);
    }
    const double determinant = inverse3(s, inverse);
    double z[kPose];
    double square = 0.0;
    for (int i = 0; i < kPose; ++i) {
      z[i] = inverse[i][0] * e[0] + inverse[i][1] * e[1] + inverse[i][2] * e[2];
      square += e[i] * z[i];
    }
    const double size = std::sqrt(std::max(0.0, square));
    const bool outlier = size > noise_.outlier;
    const double weight = outlier ? noise_.outlier / size : 1.0;
    const double rho =
        outlier ? 2.0 * noise_.outlier * size - noise_.outlier * noise_.outlier : square;
    pass.cost += counts * (rho + std::log(determinant));
    double slope[kPose][kMaxParameters];
    measured_slope(turn, cp, sp, t, slope);
    accumulate(z, inverse, slope, counts * weight, k, pass);
    const int spread[6][2] = {{0, 0}, {0, 1}, {0, 2}, {1, 1}, {1, 2}, {2, 2}};
    for (int i = 0; i < 6; ++i) pass.spread[row(k, 6) + i] = s[spread[i][0]][spread[i][1]];
    std::copy(e, e + kPose, pass.innovation.begin() + static_cast<std::ptrdiff_t>(row(k, kPose)));
    pass.weight[static_cast<std::size_t>(k)] = weight;
    if (outlier) {  // a pose that is far off is believed less: its noise is taken for larger
      const double more = 1.0 / (weight * weight);
      for (double(&line)[kPose] : s) {
        for (double& entry : line) entry *= more;
      }
      inverse3(s, inverse);
    }
    correct(e, inverse, hp, slope);
  }

 private:
  /// The start is the first pose: of the measured point, not of the origin.
  void take_off_lever() {
    const double c = std::cos(x_[2]);
    const double s = std::sin(x_[2]);
    const double* l = effects_.lever;
    x_[0] -= c * l[0] - s * l[1];
    x_[1] -= s * l[0] + c * l[1];
    if (parameters_ == own_) return;
    d_[0][own_ + kLever] = d_[1][own_ + kLever + 1] = -c;
    d_[0][own_ + kLever + 1] = s;
    d_[1][own_ + kLever] = -s;
  }

  static std::size_t row(int k, int width) {
    return static_cast<std::size_t>(k) * static_cast<std::size_t>(width);
  }

  /// Column of the tangents that is parameter c.
  int column(int c) const {
    const int own = columns_.n_coefficients - kAxes;  // the disturbance's are the last
    return kStates + (c < own ? c : c + kAxes);
  }

  void carry_sensitivity(const StateTangent& dx, const Transition& way, double stays, double cp,
                         double sp) {
    for (int i = 0; i < kStates; ++i) {
      std::fill(next_[i], next_[i] + parameters_, 0.0);
      for (int c = 0; c < own_; ++c) next_[i][c] = dx.row[i][column(c)];
      const double* push = way.slope[i] + kStates;
      double* effect = next_[i] + own_;
      if (parameters_ > own_) {
        for (int a = 0; a < kAxes; ++a) effect[kBias + a] = push[a];
        effect[kWind] = cp * push[0] - sp * push[1];
        effect[kWind + 1] = sp * push[0] + cp * push[1];
      }
      for (int j = 0; j < kFilterStates; ++j) {
        const double f = way.slope[i][j];
        for (int c = 0; c < parameters_; ++c) next_[i][c] += f * d_[j][c];
      }
    }
    for (int i = 0; i < kStates; ++i) std::copy(next_[i], next_[i] + parameters_, d_[i]);
    for (int i = kStates; i < kFilterStates; ++i) {
      for (int c = 0; c < parameters_; ++c) d_[i][c] *= stays;
    }
  }

  /// d measured pose / d parameters.
  void measured_slope(const double* turn, double cp, double sp, double t,
                      double slope[kPose][kMaxParameters]) const {
    for (int i = 0; i < kPose; ++i) {
      for (int c = 0; c < parameters_; ++c) slope[i][c] = d_[i][c] + turn[i] * d_[2][c];
    }
    if (parameters_ == own_) return;
    slope[0][own_ + kLever] += cp;
    slope[1][own_ + kLever] += sp;
    slope[0][own_ + kLever + 1] -= sp;
    slope[1][own_ + kLever + 1] += cp;
    slope[0][own_ + kCurrent] += t;
    slope[1][own_ + kCurrent + 1] += t;
  }

  /// F P F'.
  void carry_covariance(const Transition& way, double stays) {
    double fp[kStates][kFilterStates];
    for (int i = 0; i < kStates; ++i) {
      std::fill(fp[i], fp[i] + kFilterStates, 0.0);
      for (int m = 0; m < kFilterStates; ++m) {
        const double f = way.slope[i][m];
        for (int j = 0; j < kFilterStates; ++j) fp[i][j] += f * p_[m][j];
      }
    }
    for (int i = 0; i < kStates; ++i) {
      for (int j = i; j < kStates; ++j) {
        double sum = 0.0;
        for (int m = 0; m < kFilterStates; ++m) sum += fp[i][m] * way.slope[j][m];
        p_[i][j] = p_[j][i] = sum;
      }
      for (int j = kStates; j < kFilterStates; ++j) p_[i][j] = p_[j][i] = stays * fp[i][j];
    }
    for (int i = kStates; i < kFilterStates; ++i) {
      for (int j = kStates; j < kFilterStates; ++j) p_[i][j] *= stays * stays;
    }
  }

  /// Random walk of the velocity, integrated into the pose; renewal of the disturbance.
  void add_process_noise(double psi, double length, double stays) {
    const double c = std::cos(psi);
    const double s = std::sin(psi);
    const double turn[3][3] = {{c, -s, 0.0}, {s, c, 0.0}, {0.0, 0.0, 1.0}};
    for (int a = 0; a < kAxes; ++a) {
      const double q = noise_.walk(a) * noise_.walk(a);
      p_[3 + a][3 + a] += q * length;
      for (int i = 0; i < kPose; ++i) {
        const double cross = turn[i][a] * q * length * length / 2.0;
        p_[i][3 + a] += cross;
        p_[3 + a][i] += cross;
        for (int j = 0; j < kPose; ++j) {
          p_[i][j] += turn[i][a] * turn[j][a] * q * length * length * length / 3.0;
        }
      }
      const double renewed = noise_.disturbance(a) * noise_.disturbance(a) * (1.0 - stays * stays);
      p_[kStates + a][kStates + a] += renewed;
    }
  }

  void accumulate(const double* z, const double inverse[kPose][kPose],
                  const double slope[kPose][kMaxParameters], double weight, int k,
                  FilterPass& pass) const {
    double scaled[kPose][kMaxParameters];
    for (int i = 0; i < kPose; ++i) {
      for (int a = 0; a < parameters_; ++a) {
        scaled[i][a] = weight * (inverse[i][0] * slope[0][a] + inverse[i][1] * slope[1][a] +
                                 inverse[i][2] * slope[2][a]);
      }
    }
    for (int a = 0; a < parameters_; ++a) {
      const double sum = slope[0][a] * z[0] + slope[1][a] * z[1] + slope[2][a] * z[2];
      pass.gradient[static_cast<std::size_t>(a)] += weight * sum;
      pass.score[row(k, parameters_) + static_cast<std::size_t>(a)] = weight * sum;
      double* line = &pass.information[row(a, parameters_)];
      for (int b = 0; b <= a; ++b) {
        line[b] +=
            scaled[0][a] * slope[0][b] + scaled[1][a] * slope[1][b] + scaled[2][a] * slope[2][b];
      }
    }
  }

  /// x += K e, P -= K H P, and so for the sensitivities: the gain is held.
  void correct(const double* e, const double inverse[kPose][kPose],
               const double hp[kPose][kFilterStates], const double slope[kPose][kMaxParameters]) {
    double gain[kFilterStates][kPose];
    for (int i = 0; i < kFilterStates; ++i) {
      for (int j = 0; j < kPose; ++j) {
        gain[i][j] = hp[0][i] * inverse[0][j] + hp[1][i] * inverse[1][j] + hp[2][i] * inverse[2][j];
      }
    }
    for (int i = 0; i < kFilterStates; ++i) {
      for (int m = 0; m < kPose; ++m) x_[i] += gain[i][m] * e[m];
      for (int c = 0; c < parameters_; ++c) {
        d_[i][c] -= gain[i][0] * slope[0][c] + gain[i][1] * slope[1][c] + gain[i][2] * slope[2][c];
      }
      for (int j = i; j < kFilterStates; ++j) {
        const double less = gain[i][0] * hp[0][j] + gain[i][1] * hp[1][j] + gain[i][2] * hp[2][j];
        p_[i][j] = p_[j][i] = p_[i][j] - less;
      }
    }
  }

  const Columns& columns_;
  const FilterNoise& noise_;
  const Effects& effects_;
  int own_;  // chosen coefficients and constants
  int parameters_;
  double x_[kFilterStates];
  Covariance p_;
  double d_[kFilterStates][kMaxParameters];  // d state / d parameters
  double next_[kStates][kMaxParameters];
};

}  // namespace detail

}  // namespace seatrial
