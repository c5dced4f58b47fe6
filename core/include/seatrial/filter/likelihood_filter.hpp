// SPDX-License-Identifier: MIT
// The estimator's use of the extended Kalman filter (ekf_predict.hpp, ekf_update.hpp): prediction
// errors along a recording with their sensitivities to the parameters, and the terms of the
// likelihood. The columns D are d state / d parameters. Host side: uses heap.
#pragma once
#include <algorithm>
#include <cmath>

#include "seatrial/filter/ekf_predict.hpp"
#include "seatrial/filter/ekf_update.hpp"
#include "seatrial/filter/filter_beginning.hpp"
#include "seatrial/filter/filter_types.hpp"
#include "seatrial/integration/step_schedule.hpp"

namespace seatrial::detail {

/// What a sensor measured at one time.
struct Seen {
  const double* eta;  // x, y [m], psi [rad]; of a yaw rate the third is r [rad/s]
  Parts parts = kWholePose;
  double rate_deviation = 0.0;  // [rad/s] of a yaw rate
};

inline constexpr int kMostSlopes = (kMaxColumns + kEffects + 1) / 2 * 2;  // even: see FilterState
inline constexpr double kAnywhere[kPose] = {10.0, 10.0, 3.0};  // [m, m, rad] after a jump

/// The filter between two poses. N: its states, kFilterStates, kColouredStates or
/// kOscillatingStates.
template <int N>
class LikelihoodFilter {
 public:
  LikelihoodFilter(const Columns& columns, const NoiseParameters& noise, double outlier,
                   const FilterStart& start, const Effects& effects, bool slopes)
      : columns_(columns),
        noise_(noise),
        effects_(effects),
        outlier_(outlier),
        own_(columns.size() - kStates - kAxes),
        parameters_(own_ + (slopes ? kEffects : 0)),
        beginning_(noise, effects, start.velocity, slopes ? own_ : -1) {
    beginning_.set(start.state, -effects.position_delay, s_);
  }

  /// Reset at a pose of time t [s], with this velocity: the disturbance there is unknown.
  void restart(const double* eta, const double* velocity, double t) {
    double state[kStates];
    std::copy(eta, eta + kPose, state);
    std::copy(velocity, velocity + kAxes, state + kPose);
    beginning_.set(state, t - effects_.position_delay, s_);
  }

  const double* state() const { return s_.x; }
  double variance(int i) const { return s_.p[i][i]; }
  const FilterState<N, kMostSlopes>& filter() const { return s_; }
  int parameters() const { return parameters_; }

  /// To the next pose. `gain`: takes G (6, p) where not null. False where the boat diverged.
  bool predict(const StepSchedule& schedule, int interval, Boat& boat, double length,
               Transition& kept, float* gain) {
    kept_gain_ = gain;
    const Interval passed(noise_, std::cos(s_.x[2]), std::sin(s_.x[2]), length);
    const Disturbing disturbing(s_.x, length, effects_.bias, effects_.wind, effects_.earth_fixed);
    const int first = boat.structure.n_coefficients - kAxes;
    std::copy(disturbing.total, disturbing.total + kAxes, boat.coefficient + first);
    const auto move = [&schedule, interval](double* x, StateSensitivities& dx) {
      return schedule.run(interval, x, dx);
    };
    MotionSlopes f;
    if (!ekf_predict<N>(columns_, disturbing, passed, noise_, move, *this, f, s_)) return false;
    std::copy(s_.x, s_.x + kStates, kept.to);
    for (int i = 0; i < kStates; ++i) {
      for (int j = 0; j < kMoving; ++j) kept.slope[i][j] = static_cast<float>(f[i][j]);
    }
    return true;
  }

  /// The same transition again, linearised about the states `from` (9) where it began. `moved` (6):
  /// what a step of the parameters adds to it, null for none; `gain`: its G (6, p), null where this
  /// filter carries no sensitivities.
  void repeat(const Transition& kept, const double* from, const Interval& passed,
              const double* moved, const float* gain) {
    double off[kFilterStates];
    for (int i = 0; i < kFilterStates; ++i) off[i] = s_.x[i] - from[i];
    MotionSlopes f;
    for (int i = 0; i < kStates; ++i) {
      double sum = kept.to[i] + off[i];
      for (int j = 0; j < kMoving; ++j) {
        f[i][j] = static_cast<double>(kept.slope[i][j]);
        sum += f[i][j] * off[j + 2];
      }
      s_.x[i] = moved == nullptr ? sum : sum + moved[i];
    }
    const GaussMarkov<N> others(noise_, passed);
    others.carry_mean(s_.x);
    if (gain != nullptr) {
      MotionSlopes whole;
      for (int i = 0; i < kStates; ++i) std::copy(f[i], f[i] + kMoving, whole[i]);
      for (int i = 2; i < kStates; ++i) whole[i][i - 2] += 1.0;
      const auto kept_gain = [this, gain](int i, double* row) {
        const float* from_row = gain + static_cast<std::ptrdiff_t>(i) * parameters_;
        for (int c = 0; c < parameters_; ++c) row[c] = static_cast<double>(from_row[c]);
      };
      carry_columns<N>(whole, others, parameters_, kept_gain, s_);
    }
    carry_covariance<N>(f, others, s_);
    add_process_noise<N>(noise_, passed, others, s_);
  }

  /// Errors of the input: covariance (6) of what they changed the velocity by; null: none.
  void add_input_error(const double* covariance) {
    if (covariance == nullptr) return;
    for (int i = 0; i < kAxes; ++i) {
      for (int j = i; j < kAxes; ++j, ++covariance) {
        s_.p[kPose + i][kPose + j] += *covariance;
        if (i != j) s_.p[kPose + j][kPose + i] += *covariance;
      }
    }
  }

  /// The pose jumped and may be anywhere. A jump beyond kAnywhere counts as one of that size.
  void loosen(const double* eta, double t, Parts parts) {
    double arm[2];
    plane_to_earth(std::cos(s_.x[2]), std::sin(s_.x[2]), effects_.lever, arm);
    for (int i = 0; i < 2; ++i) {
      const double leap = eta[i] - s_.x[i] - arm[i] - effects_.current[i] * t;
      const double beyond = std::abs(leap) - kAnywhere[i];
      if (has(parts, i) && beyond > 0.0) s_.x[i] += std::copysign(beyond, leap);
    }
    for (int i = 0; i < kPose; ++i) {
      if (!has(parts, i)) continue;
      for (int j = 0; j < N; ++j) s_.p[i][j] = s_.p[j][i] = 0.0;
      s_.p[i][i] = kAnywhere[i] * kAnywhere[i];
    }
  }

  /// The same where that is likelier: the poses may have jumped while there were none. The lesser
  /// cost of the two is continuous in all parameters. Whether it is.
  bool loosen_if_likelier(const double* eta, double t, Parts parts) {
    LikelihoodFilter stays(*this);
    LikelihoodFilter jumps(*this);
    jumps.loosen(eta, t, parts);
    const Seen seen{eta, parts};
    const bool likelier = jumps.update(seen, t).cost < stays.update(seen, t).cost;
    if (likelier) loosen(eta, t, parts);
    return likelier;
  }

  /// From here on the disturbance counts as zero: its error is all of it. That of the velocity
  /// keeps its covariance with it, as what the filter knows of it is uncorrelated with the filter's
  /// errors.
  void leave_out_disturbance() {
    for (int i = kStates; i < kFilterStates; ++i) {
      const double sigma = noise_.disturbance(i - kStates);
      s_.x[i] = 0.0;
      for (int j = kStates; j < kFilterStates; ++j) s_.p[i][j] = 0.0;
      s_.p[i][i] = sigma * sigma;
    }
  }

  /// Use what was measured at t [s]. `terms`: takes its terms of gradient and
  /// information, and of the score of its block; null where none are needed. `counts`: how often it
  /// counts.
  CostedInnovation update(const Seen& at, double t, double counts = 1.0, FilterRun* terms = nullptr,
                          int block = 0) {
    // the pose as the sensor measures it
    const Parts parts = at.parts;
    const bool rate = (parts & kRatePart) != 0;
    const double* l = effects_.lever;
    const double* later = effects_.later;
    const bool shifts = later[0] != 0.0 || later[1] != 0.0;
    const bool turns = parameters_ > own_ || shifts || l[0] != 0.0 || l[1] != 0.0;  // else no angle
    const double cp = turns ? std::cos(s_.x[2]) : 1.0;
    const double sp = turns ? std::sin(s_.x[2]) : 0.0;
    double arm[2];
    plane_to_earth(cp, sp, l, arm);
    Measurement y{at.eta};
    y.parts = parts;
    y.turn[0] = -arm[1];
    y.turn[1] = arm[0];
    for (int i = 0; i < 2; ++i) y.offset[i] = arm[i] + effects_.current[i] * t;
    if (shifts) {
      double velocity[2];
      measured_velocity(effects_, s_.x, cp, sp, velocity);
      for (int i = 0; i < 2; ++i) y.offset[i] -= velocity[i] * later[0];
      y.offset[2] = rate ? 0.0 : -s_.x[5] * later[1];
    }
    for (int i = 0; i < kPose; ++i) y.noise[i][i] = noise_.white_variance(i);
    if (rate) y.noise[2][2] = at.rate_deviation * at.rate_deviation;
    // beside its prediction
    double hp[kPose][N];
    measured_covariance<N>(y, s_, hp);
    if (parts != kWholePose) leave_out(parts, hp);
    CostedInnovation out{innovation<N>(y, outlier_, hp, s_)};
    out.cost = cost(out);
    // terms of the likelihood's derivatives
    double slope[kPose][kMostSlopes];
    measured_columns<N>(y, s_, parameters_, slope);
    if (parameters_ > own_ && !rate) add_effects(cp, sp, t, slope);
    if (parts != kWholePose) leave_out(parts, slope);
    if (terms != nullptr) accumulate(out, slope, counts * out.weight, block, *terms);
    ekf_update<N>(out, hp, slope, parameters_, PlainForm{}, s_);
    return out;
  }

  /// D <- F D + G, G the step's derivatives to the parameters; of ekf_predict.
  template <int, class State>
  void columns(const StateSensitivities& dx, int force, const Disturbing& at, const MotionSlopes& f,
               const GaussMarkov<N>& others, State& s) const {
    const auto gain = [&](int i, double* row) {
      std::fill(row, row + parameters_, 0.0);
      for (int c = 0; c < own_; ++c) row[c] = dx.row[i][column(c)];
      if (parameters_ > own_) {
        const double* push = dx.row[i] + force;
        double* effect = row + own_;
        for (int a = 0; a < kAxes; ++a) effect[kBias + a] = push[a];
        effect[kWind] = at.cos * push[0] - at.sin * push[1];
        effect[kWind + 1] = at.sin * push[0] + at.cos * push[1];
        effect[kWind + 2] = -at.sin * push[2];
        effect[kWind + 3] = at.cos * push[2];
        effect[kWind + 4] = -at.sin * push[1];
        effect[kWind + 5] = at.cos * push[1];
      }
      if (kept_gain_ != nullptr) {
        float* kept = kept_gain_ + static_cast<std::ptrdiff_t>(i) * parameters_;
        for (int c = 0; c < parameters_; ++c) kept[c] = static_cast<float>(row[c]);
      }
    };
    carry_columns<N>(f, others, parameters_, gain, s);
  }

  /// Sensitivities add nothing to the covariance.
  template <int, class State>
  void covariance(const MotionSlopes&, State&) const {}

 private:
  static std::size_t row(int k, int width) {
    return static_cast<std::size_t>(k) * static_cast<std::size_t>(width);
  }

  /// Column of the sensitivities that is parameter c.
  int column(int c) const {
    const int own = columns_.n_coefficients - kAxes;  // the disturbance's are the last
    return kStates + (c < own ? c : c + kAxes);
  }

  /// rho(e' S^-1 e) + log det S; rho grows linearly beyond an outlier's distance.
  double cost(const Innovation& seen) const {
    const double size = std::sqrt(std::max(0.0, seen.nis));
    const double rho = size > outlier_ ? 2.0 * outlier_ * size - outlier_ * outlier_ : seen.nis;
    return rho + std::log(seen.determinant);
  }

  /// d measured pose / d effects, beside what the state has.
  void add_effects(double cp, double sp, double t, double slope[kPose][kMostSlopes]) const {
    slope[0][own_ + kLever] += cp;
    slope[1][own_ + kLever] += sp;
    slope[0][own_ + kLever + 1] -= sp;
    slope[1][own_ + kLever + 1] += cp;
    slope[0][own_ + kCurrent] += t;
    slope[1][own_ + kCurrent + 1] += t;
    double velocity[2];
    measured_velocity(effects_, s_.x, cp, sp, velocity);
    for (int i = 0; i < 2; ++i) slope[i][own_ + kDelay] -= velocity[i];
    slope[2][own_ + kDelay + 1] -= s_.x[5];
  }

  void accumulate(const Innovation& seen, const double slope[kPose][kMostSlopes], double weight,
                  int block, FilterRun& out) const {
    const double(&inverse)[kPose][kPose] = seen.inverse;
    const double* z = seen.z;
    double own[kPose][kMostSlopes];
    double scaled[kPose][kMostSlopes];
    for (int i = 0; i < kPose; ++i) {
      std::copy(slope[i], slope[i] + parameters_, own[i]);
      for (int a = 0; a < parameters_; ++a) {
        scaled[i][a] = weight * (inverse[i][0] * slope[0][a] + inverse[i][1] * slope[1][a] +
                                 inverse[i][2] * slope[2][a]);
      }
    }
    double sum[kMostSlopes];
    for (int a = 0; a < parameters_; ++a) {
      sum[a] = weight * (own[0][a] * z[0] + own[1][a] * z[1] + own[2][a] * z[2]);
    }
    double* to = out.gradient.data();
    for (int a = 0; a < parameters_; ++a) to[a] += sum[a];
    to = &out.score[row(block, parameters_)];
    for (int a = 0; a < parameters_; ++a) to[a] += sum[a];
    for (int a = 0; a < parameters_; ++a) {
      to = &out.information[row(a, parameters_)];
      for (int b = 0; b <= a; ++b) {
        to[b] += scaled[0][a] * own[0][b] + scaled[1][a] * own[1][b] + scaled[2][a] * own[2][b];
      }
    }
  }

  const Columns& columns_;
  const NoiseParameters& noise_;
  const Effects& effects_;
  double outlier_;  // [sigma]
  int own_;         // chosen coefficients and constants
  int parameters_;
  FilterBeginning<N> beginning_;
  float* kept_gain_ = nullptr;
  FilterState<N, kMostSlopes> s_;
};

}  // namespace seatrial::detail
