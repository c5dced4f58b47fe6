// SPDX-License-Identifier: MIT
// The extended Kalman filter whose prediction errors the estimator looks at, with its
// sensitivities.
//
// The state is the boat's (6), body-fixed or, in surge and sway, earth-fixed disturbances (3) and,
// where the noise has any, correlated errors of the poses, which a filter that takes all noise for
// white would take for the boat's motion (fading.hpp). Host side: uses heap.
#pragma once
#include <algorithm>
#include <cmath>

#include "seatrial/filter/filter_types.hpp"
#include "seatrial/filter/gauss_markov.hpp"
#include "seatrial/filter/inverse3.hpp"
#include "seatrial/integration/step_schedule.hpp"

namespace seatrial::detail {

inline constexpr int kMaxParameters = kMaxColumns + kEffects;
inline constexpr double kAnywhere[kPose] = {10.0, 10.0, 3.0};  // [m, m, rad] after a jump
inline constexpr double kTurn = 6.283185307179586;             // [rad]

/// The filter between two poses. N: its states, kFilterStates, kColouredStates or kSwingingStates.
template <int N>
class Filter {
  static constexpr bool kColoured = Fading<N>::kColoured;

 public:
  Filter(const Columns& columns, const FilterNoise& noise, const FilterStart& start,
         const Effects& effects, bool slopes)
      : columns_(columns),
        noise_(noise),
        effects_(effects),
        own_(columns.size() - kStates - kAxes),
        parameters_(own_ + (slopes ? kEffects : 0)) {
    std::copy(start.velocity, start.velocity + kAxes, spread_);
    begin(start.state);
  }

  /// Afresh at a pose of time t [s], with this velocity: what drove the boat there is not known.
  void begin_afresh(const double* eta, const double* velocity, double t) {
    double state[kStates];
    std::copy(eta, eta + kPose, state);
    std::copy(velocity, velocity + kAxes, state + kPose);
    begin(state);
    for (int i = 0; i < 2; ++i) {
      x_[i] -= effects_.current[i] * t;
      if (parameters_ > own_) d_[i][own_ + kCurrent + i] = -t;
    }
  }

  const double* state() const { return x_; }
  double variance(int i) const { return p_[i][i]; }
  int parameters() const { return parameters_; }

  /// To the next pose. False where the boat diverged.
  bool predict(const Schedule& schedule, int interval, Boat& boat, double length, Transition& way) {
    StateTangent dx;
    seed(columns_, dx);
    const int first = boat.structure.n_coefficients - kAxes;
    const Interval passed(noise_, x_[2], length);
    const bool earth = effects_.earth_fixed;
    const double w[2] = {effects_.wind[0] + (earth ? x_[kStates] : 0.0),
                         effects_.wind[1] + (earth ? x_[kStates + 1] : 0.0)};
    const double middle = x_[2] + 0.5 * length * x_[5];  // the heading that the wind meets
    const double c = std::cos(middle);
    const double s = std::sin(middle);
    double wind[kAxes] = {};
    plane_to_body(c, s, w, wind);
    for (int a = 0; a < kAxes; ++a) {
      const double own = earth && a < 2 ? 0.0 : x_[kStates + a];
      boat.coefficient[first + a] = own + effects_.bias[a] + wind[a];
    }
    if (!schedule.run(interval, x_, dx)) return false;
    const int force = kStates + columns_.n_coefficients - kAxes;
    for (int i = 0; i < kStates; ++i) {
      std::copy(dx.row[i] + 2, dx.row[i] + kStates, f_[i]);
      const double* push = dx.row[i] + force;
      std::copy(push, push + kAxes, f_[i] + kStates - 2);
      const double turned = push[0] * wind[1] - push[1] * wind[0];
      f_[i][0] += turned;  // a turn of the boat turns the wind on it
      f_[i][3] += 0.5 * length * turned;
      if (earth) plane_to_earth(c, s, push, f_[i] + kStates - 2);
    }
    std::copy(x_, x_ + kStates, way.to);
    fading_.pass(noise_, passed);
    fading_.carry(x_);
    carry_sensitivity(dx, force, c, s);
    for (int i = 0; i < kStates; ++i) {
      if (i >= 2) f_[i][i - 2] -= 1.0;
      for (int j = 0; j < kMoving; ++j) way.slope[i][j] = static_cast<float>(f_[i][j]);
    }
    carry_covariance();
    add_process_noise(passed);
    return true;
  }

  /// The same way again, linearised about the states `from` (9) where it began.
  void repeat(const Transition& way, const double* from, const Interval& passed) {
    double off[kFilterStates];
    for (int i = 0; i < kFilterStates; ++i) off[i] = x_[i] - from[i];
    for (int i = 0; i < kStates; ++i) {
      double sum = way.to[i] + off[i];
      for (int j = 0; j < kMoving; ++j) {
        f_[i][j] = static_cast<double>(way.slope[i][j]);
        sum += f_[i][j] * off[j + 2];
      }
      x_[i] = sum;
    }
    fading_.pass(noise_, passed);
    fading_.carry(x_);
    carry_covariance();
    add_process_noise(passed);
  }

  /// The pose may be anywhere: it jumped. What is further than anywhere counts as just as far.
  void loosen(const double* eta, double t) {
    double arm[2];
    plane_to_earth(std::cos(x_[2]), std::sin(x_[2]), effects_.lever, arm);
    for (int i = 0; i < 2; ++i) {
      const double leap = eta[i] - x_[i] - arm[i] - effects_.current[i] * t;
      const double beyond = std::abs(leap) - kAnywhere[i];
      if (beyond > 0.0) x_[i] += std::copysign(beyond, leap);
    }
    for (int i = 0; i < kPose; ++i) {
      for (int j = 0; j < N; ++j) p_[i][j] = p_[j][i] = 0.0;
      p_[i][i] = kAnywhere[i] * kAnywhere[i];
    }
  }

  /// The same where that is likelier: the poses may have jumped while there were none. The lesser
  /// cost of the two is continuous in all that the filter is asked about.
  void loosen_if_likelier(const double* eta, double t) {
    Filter stays(*this);
    Filter jumps(*this);
    jumps.loosen(eta, t);
    if (jumps.update(eta, t).cost < stays.update(eta, t).cost) loosen(eta, t);
  }

  /// Use a pose of time t [s]. `terms`: takes its terms of gradient and information, and of the
  /// score of its block; null where they are not asked for. `counts`: how often it counts.
  Innovation update(const double* eta, double t, double counts = 1.0, FilterPass* terms = nullptr,
                    int block = 0) {
    const double* l = effects_.lever;
    const bool turns = parameters_ > own_ || l[0] != 0.0 || l[1] != 0.0;  // else nothing with it
    const double cp = turns ? std::cos(x_[2]) : 1.0;
    const double sp = turns ? std::sin(x_[2]) : 0.0;
    double arm[2];
    plane_to_earth(cp, sp, l, arm);
    const double turn[kPose] = {-arm[1], arm[0], 0.0};  // d measured / d psi, beyond the state's
    double hp[kPose][N];
    double inverse[kPose][kPose];
    Innovation out{};
    double(&e)[kPose] = out.e;
    double(&s)[kPose][kPose] = out.s;
    for (int i = 0; i < kPose; ++i) {
      const double moved = i < 2 ? arm[i] + effects_.current[i] * t : 0.0;
      e[i] = eta[i] - x_[i] - moved;
      for (int j = 0; j < N; ++j) hp[i][j] = p_[i][j] + turn[i] * p_[2][j];
      if constexpr (kColoured) {
        e[i] -= x_[kFilterStates + i];
        for (int j = 0; j < N; ++j) hp[i][j] += p_[kFilterStates + i][j];
      }
    }
    if (std::abs(e[2]) > kTurn / 2.0) e[2] = std::remainder(e[2], kTurn);  // turned in a gap
    for (int i = 0; i < kPose; ++i) {
      for (int j = 0; j < kPose; ++j) {
        s[i][j] = hp[i][j] + hp[i][2] * turn[j];
        if constexpr (kColoured) s[i][j] += hp[i][kFilterStates + j];
      }
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
    out.weight = outlier ? noise_.outlier / size : 1.0;
    const double rho =
        outlier ? 2.0 * noise_.outlier * size - noise_.outlier * noise_.outlier : square;
    out.cost = rho + std::log(determinant);
    double slope[kPose][kMaxParameters];
    measured_slope(turn, cp, sp, t, slope);
    if (terms != nullptr) accumulate(z, inverse, slope, counts * out.weight, block, *terms);
    if (outlier) {  // a pose that is far off is believed less: its noise is taken for larger
      const double less = out.weight * out.weight;
      for (double(&line)[kPose] : inverse) {
        for (double& entry : line) entry *= less;
      }
    }
    correct(e, inverse, hp, slope);
    return out;
  }

 private:
  /// At a state (6), known as well as one pose and the start's velocity are.
  void begin(const double* state) {
    std::copy(state, state + kStates, x_);
    std::fill(x_ + kStates, x_ + N, 0.0);
    for (int i = 0; i < N; ++i) {
      const double sigma = i < kPose           ? kPoseSpread * first_pose(i)
                           : i < kStates       ? spread_[i - kPose]
                           : i < kFilterStates ? noise_.disturbance(i - kStates)
                                               : noise_.colour((i - kFilterStates) % kPose);
      std::fill(p_[i], p_[i] + N, 0.0);
      p_[i][i] = sigma * sigma;
      std::fill(d_[i], d_[i] + kMaxParameters, 0.0);
    }
    take_off_effects();
  }

  /// The start is as measured: of a point off the origin, and over ground, not through the water.
  void take_off_effects() {
    const double c = std::cos(x_[2]);
    const double s = std::sin(x_[2]);
    const double* l = effects_.lever;
    const double* flow = effects_.current;
    double arm[2];
    double water[2];
    plane_to_earth(c, s, l, arm);
    plane_to_body(c, s, flow, water);
    for (int i = 0; i < 2; ++i) x_[i] -= arm[i];
    x_[3] += x_[5] * l[1] - water[0];
    x_[4] -= x_[5] * l[0] + water[1];
    if (parameters_ == own_) return;
    d_[0][own_ + kLever] = d_[1][own_ + kLever + 1] = -c;
    d_[0][own_ + kLever + 1] = s;
    d_[1][own_ + kLever] = -s;
    d_[3][own_ + kLever + 1] = x_[5];
    d_[4][own_ + kLever] = -x_[5];
    d_[3][own_ + kCurrent] = d_[4][own_ + kCurrent + 1] = -c;
    d_[3][own_ + kCurrent + 1] = -s;
    d_[4][own_ + kCurrent] = s;
  }

  /// What one pose is worth alone [m, m, rad].
  double first_pose(int i) const {
    return kColoured ? std::hypot(noise_.pose(i), noise_.colour(i)) : noise_.pose(i);
  }

  static std::size_t row(int k, int width) {
    return static_cast<std::size_t>(k) * static_cast<std::size_t>(width);
  }

  /// Column of the tangents that is parameter c.
  int column(int c) const {
    const int own = columns_.n_coefficients - kAxes;  // the disturbance's are the last
    return kStates + (c < own ? c : c + kAxes);
  }

  /// `force`: where the disturbance's columns begin among the tangents.
  void carry_sensitivity(const StateTangent& dx, int force, double cp, double sp) {
    for (int i = 0; i < kStates; ++i) {
      std::fill(next_[i], next_[i] + parameters_, 0.0);
      for (int c = 0; c < own_; ++c) next_[i][c] = dx.row[i][column(c)];
      const double* push = dx.row[i] + force;
      double* effect = next_[i] + own_;
      if (parameters_ > own_) {
        for (int a = 0; a < kAxes; ++a) effect[kBias + a] = push[a];
        effect[kWind] = cp * push[0] - sp * push[1];
        effect[kWind + 1] = sp * push[0] + cp * push[1];
      }
      if (i < 2) {
        for (int c = 0; c < parameters_; ++c) next_[i][c] += d_[i][c];
      }
      for (int j = 0; j < kMoving; ++j) {
        const double f = f_[i][j];
        for (int c = 0; c < parameters_; ++c) next_[i][c] += f * d_[j + 2][c];
      }
    }
    for (int i = 0; i < kStates; ++i) std::copy(next_[i], next_[i] + parameters_, d_[i]);
    fading_.carry(d_, parameters_);
  }

  /// d measured pose / d parameters.
  void measured_slope(const double* turn, double cp, double sp, double t,
                      double slope[kPose][kMaxParameters]) const {
    for (int i = 0; i < kPose; ++i) {
      for (int c = 0; c < parameters_; ++c) slope[i][c] = d_[i][c] + turn[i] * d_[2][c];
      if constexpr (kColoured) {
        for (int c = 0; c < parameters_; ++c) slope[i][c] += d_[kFilterStates + i][c];
      }
    }
    if (parameters_ == own_) return;
    slope[0][own_ + kLever] += cp;
    slope[1][own_ + kLever] += sp;
    slope[0][own_ + kLever + 1] -= sp;
    slope[1][own_ + kLever + 1] += cp;
    slope[0][own_ + kCurrent] += t;
    slope[1][own_ + kCurrent + 1] += t;
  }

  /// F P F', with the boat's slopes less the identity.
  void carry_covariance() {
    double fp[kStates][N];
    for (int i = 0; i < kStates; ++i) {
      std::copy(p_[i], p_[i] + N, fp[i]);
      for (int m = 0; m < kMoving; ++m) {
        for (int j = 0; j < N; ++j) fp[i][j] += f_[i][m] * p_[m + 2][j];
      }
    }
    for (int i = 0; i < kStates; ++i) {
      for (int j = i; j < kStates; ++j) {
        double sum = fp[i][j];
        for (int m = 0; m < kMoving; ++m) sum += fp[i][m + 2] * f_[j][m];
        p_[i][j] = p_[j][i] = sum;
      }
    }
    fading_.carry(fp, p_);
  }

  /// Random walk of the velocity, integrated into the pose; renewal of what fades. The walks of
  /// surge and sway are alike, so that they spread the position the same way in all directions.
  void add_process_noise(const Interval& passed) {
    const double length = passed.length;
    for (int a = 0; a < kAxes; ++a) {
      const double q = noise_.walk(a) * noise_.walk(a) * length;
      p_[3 + a][3 + a] += q;
      p_[a][a] += q * length * length / 3.0;
    }
    fading_.renew(noise_, p_);
    const double half = length * length / 2.0;
    const double plane = noise_.walk(0) * noise_.walk(0) * half;
    const double turn = noise_.walk(2) * noise_.walk(2) * half;
    const double cross[kPose][kAxes] = {{plane * passed.cos, -plane * passed.sin, 0.0},
                                        {plane * passed.sin, plane * passed.cos, 0.0},
                                        {0.0, 0.0, turn}};
    for (int i = 0; i < kPose; ++i) {
      for (int a = 0; a < kAxes; ++a) {
        p_[i][3 + a] += cross[i][a];
        p_[3 + a][i] += cross[i][a];
      }
    }
  }

  void accumulate(const double* z, const double inverse[kPose][kPose],
                  const double slope[kPose][kMaxParameters], double weight, int block,
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
      pass.score[row(block, parameters_) + static_cast<std::size_t>(a)] += weight * sum;
      double* line = &pass.information[row(a, parameters_)];
      for (int b = 0; b <= a; ++b) {
        line[b] +=
            scaled[0][a] * slope[0][b] + scaled[1][a] * slope[1][b] + scaled[2][a] * slope[2][b];
      }
    }
  }

  /// x += K e, P -= K H P, and so for the sensitivities: the gain is held.
  void correct(const double* e, const double inverse[kPose][kPose], const double hp[kPose][N],
               const double slope[kPose][kMaxParameters]) {
    double gain[N][kPose];
    for (int i = 0; i < N; ++i) {
      for (int j = 0; j < kPose; ++j) {
        gain[i][j] = hp[0][i] * inverse[0][j] + hp[1][i] * inverse[1][j] + hp[2][i] * inverse[2][j];
      }
    }
    for (int i = 0; i < N; ++i) {
      for (int m = 0; m < kPose; ++m) x_[i] += gain[i][m] * e[m];
      for (int c = 0; c < parameters_; ++c) {
        d_[i][c] -= gain[i][0] * slope[0][c] + gain[i][1] * slope[1][c] + gain[i][2] * slope[2][c];
      }
      for (int j = i; j < N; ++j) {
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
  double spread_[kAxes] = {};  // of the velocity that it begins with
  double x_[N] = {};
  double p_[N][N] = {};
  Fading<N> fading_;
  double d_[N][kMaxParameters] = {};  // d state / d parameters
  double next_[kStates][kMaxParameters] = {};
  double f_[kStates][kMoving] = {};  // d state / d what the motion depends on; less 1 once carried
};

}  // namespace seatrial::detail
