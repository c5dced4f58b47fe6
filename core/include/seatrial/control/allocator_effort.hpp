// SPDX-License-Identifier: MIT
// Least effort: of all thrusts between their bounds that give a wrench, those with the least
// weighted square; where none gives it, those that come nearest.
#pragma once
#include <algorithm>
#include <cmath>
#include <limits>

#include "seatrial/control/allocator_reach.hpp"

namespace seatrial {

/// min 1/2 sum_k y_k^2 / softness_k  subject to  T y = F,  low <= y <= high, by its dual: with one
/// multiplier for each axis of F, y_k = clamp(softness_k t_k . lambda), and F - T y(lambda) is the
/// gradient of a concave function, piecewise quadratic. Newton's method with exact line search
/// ends after a few 3 x 3 systems, however many thrusters there are. A proximal term 1/rho keeps
/// the system regular where all thrusters that matter are at their bounds, and makes the answer
/// the nearest wrench (weight rho) where F is out of reach.
class LeastEffort {
 public:
  LeastEffort() = default;

  LeastEffort(const Effectiveness& t, const double* softness) : t_(t) {
    std::copy(softness, softness + t.n, softness_);
    for (int i = 0; i < kWrenchAxes; ++i) {
      free_[i][i] = 1.0 / kRho;
      for (int j = 0; j < kWrenchAxes; ++j) {
        for (int k = 0; k < t.n; ++k) free_[i][j] += softness[k] * t.column[k][i] * t.column[k][j];
      }
    }
  }

  /// The largest deviation of T y from F, and how many 3 x 3 systems it took.
  struct Outcome {
    double error = std::numeric_limits<double>::infinity();
    int steps = 0;
  };

  /// Writes y.
  Outcome solve(const Bounds& bounds, const double* wrench, double* y) const {
    double lambda[kWrenchAxes];
    double centre[kWrenchAxes];
    solve_three(free_, wrench, lambda);  // the answer, where no bound is in the way
    std::copy(lambda, lambda + kWrenchAxes, centre);
    Outcome out;
    out.steps = 1;
    for (int pass = 0; pass < kPasses; ++pass) {
      out.steps += climb(bounds, wrench, centre, lambda);
      thrusts(bounds, lambda, y);
      const double before = out.error;
      out.error = deviation(wrench, y);
      // within reach a pass moves lambda by up to rho times the error; out of reach, and where
      // nothing but rounding is left, the error stays
      const bool stays = out.error > 0.5 * before;
      const bool given = out.error < 10 * kExact;
      if (given || (stays && (out.error > kOutOfReach || out.error < kSettled))) break;
      std::copy(lambda, lambda + kWrenchAxes, centre);
    }
    return out;
  }

 private:
  static constexpr double kRho = 1e8;
  static constexpr double kExact = 1e-14;
  static constexpr double kRounding = 1e-15;   // of a multiplier
  static constexpr double kOutOfReach = 1e-6;  // [command units]
  static constexpr double kSettled = 1e-11;    // [command units] to which Reach distinguishes faces
  static constexpr int kPasses = 8;
  static constexpr int kSteps = 20;

  void thrusts(const Bounds& b, const double* lambda, double* y) const {
    for (int k = 0; k < t_.n; ++k) {
      const double free = softness_[k] * detail::dot3(t_.column[k], lambda);
      y[k] = std::min(std::max(free, b.low[k]), b.high[k]);
    }
  }

  double deviation(const double* wrench, const double* y) const {
    double given[kWrenchAxes];
    t_.wrench(y, given);
    for (int j = 0; j < kWrenchAxes; ++j) given[j] -= wrench[j];
    return largest(given);
  }

  /// To the maximum of the dual function, less |lambda - centre|^2 / (2 rho); how many steps.
  int climb(const Bounds& b, const double* wrench, const double* centre, double* lambda) const {
    for (int step = 0; step < kSteps; ++step) {
      double gradient[kWrenchAxes];
      double curvature[kWrenchAxes][kWrenchAxes];
      derivatives(b, wrench, centre, lambda, gradient, curvature);
      if (largest(gradient) < kExact + kRounding * largest(lambda)) return step;
      double direction[kWrenchAxes];
      solve_three(curvature, gradient, direction);
      const double length = line_search(b, wrench, centre, lambda, direction);
      bool moved = false;  // by less than lambda's last digit: so would every step after it
      for (int j = 0; j < kWrenchAxes; ++j) {
        const double before = lambda[j];
        lambda[j] += length * direction[j];
        moved = moved || lambda[j] != before;
      }
      if (!moved) return step + 1;
    }
    return kSteps;
  }

  static double largest(const double* v) {
    return std::max(std::abs(v[0]), std::max(std::abs(v[1]), std::abs(v[2])));
  }

  void derivatives(const Bounds& b, const double* wrench, const double* centre,
                   const double* lambda, double* gradient, double (*curvature)[kWrenchAxes]) const {
    for (int i = 0; i < kWrenchAxes; ++i) {
      gradient[i] = wrench[i] - (lambda[i] - centre[i]) / kRho;
      for (int j = 0; j < kWrenchAxes; ++j) curvature[i][j] = i == j ? 1.0 / kRho : 0.0;
    }
    for (int k = 0; k < t_.n; ++k) {
      const double* t = t_.column[k];
      const double free = softness_[k] * detail::dot3(t, lambda);
      const double y = std::min(std::max(free, b.low[k]), b.high[k]);
      const bool moves = free >= b.low[k] && free <= b.high[k] && b.low[k] < b.high[k];
      for (int i = 0; i < kWrenchAxes; ++i) {
        gradient[i] -= t[i] * y;
        if (!moves) continue;
        for (int j = 0; j < kWrenchAxes; ++j) curvature[i][j] += softness_[k] * t[i] * t[j];
      }
    }
  }

  /// Cholesky.
  static void solve_three(const double (*a)[kWrenchAxes], const double* b, double* x) {
    const double l00 = std::sqrt(a[0][0]);
    const double l10 = a[1][0] / l00;
    const double l20 = a[2][0] / l00;
    const double l11 = std::sqrt(std::max(a[1][1] - l10 * l10, kTiny));
    const double l21 = (a[2][1] - l20 * l10) / l11;
    const double l22 = std::sqrt(std::max(a[2][2] - l20 * l20 - l21 * l21, kTiny));
    const double z0 = b[0] / l00;
    const double z1 = (b[1] - l10 * z0) / l11;
    const double z2 = (b[2] - l20 * z0 - l21 * z1) / l22;
    x[2] = z2 / l22;
    x[1] = (z1 - l21 * x[2]) / l11;
    x[0] = (z0 - l10 * x[1] - l20 * x[2]) / l00;
  }

  /// Along one direction: every thrust is a line between its bounds, the slope of the dual function
  /// falls and is straight between their ends.
  struct Ray {
    double start[kMaxActuators];  // free thrust at step 0, and its rate
    double rate[kMaxActuators];
    double push[kMaxActuators];  // t_k . direction
    double constant = 0.0;
    double falls = 0.0;  // of the proximal term
  };

  double slope(const Bounds& b, const Ray& ray, double s) const {
    double sum = ray.constant - s * ray.falls;
    for (int k = 0; k < t_.n; ++k) {
      const double free = ray.start[k] + s * ray.rate[k];
      sum -= ray.push[k] * std::min(std::max(free, b.low[k]), b.high[k]);
    }
    return sum;
  }

  /// The step in (0, 1] at which the slope is zero, or 1.
  double line_search(const Bounds& b, const double* wrench, const double* centre,
                     const double* lambda, const double* direction) const {
    Ray ray;
    ray.falls = detail::dot3(direction, direction) / kRho;
    for (int j = 0; j < kWrenchAxes; ++j) {
      ray.constant += direction[j] * (wrench[j] - (lambda[j] - centre[j]) / kRho);
    }
    for (int k = 0; k < t_.n; ++k) {
      ray.push[k] = detail::dot3(t_.column[k], direction);
      ray.start[k] = softness_[k] * detail::dot3(t_.column[k], lambda);
      ray.rate[k] = softness_[k] * ray.push[k];
    }
    return slope(b, ray, 1.0) >= 0.0 ? 1.0 : flat_point(b, ray);
  }

  /// The step in (0, 1) at which a slope that is negative at 1 is zero.
  double flat_point(const Bounds& b, const Ray& ray) const {
    double ends[2 * kMaxActuators + 1];
    int n_ends = 0;
    for (int k = 0; k < t_.n; ++k) {
      if (ray.rate[k] == 0.0) continue;
      for (const double bound : {b.low[k], b.high[k]}) {
        const double s = (bound - ray.start[k]) / ray.rate[k];
        if (s > 0.0 && s < 1.0) ends[n_ends++] = s;
      }
    }
    ends[n_ends++] = 1.0;
    std::sort(ends, ends + n_ends);
    int low = 0;  // the slope is negative at ends[high]
    int high = n_ends - 1;
    while (low < high) {
      const int middle = (low + high) / 2;
      if (slope(b, ray, ends[middle]) < 0.0) {
        high = middle;
      } else {
        low = middle + 1;
      }
    }
    const double from = high == 0 ? 0.0 : ends[high - 1];
    const double at_from = slope(b, ray, from);
    const double at_end = slope(b, ray, ends[high]);
    if (at_from <= 0.0) return from;  // no more in it than rounding
    return from + (ends[high] - from) * at_from / (at_from - at_end);
  }

  static constexpr double kTiny = 1e-30;
  Effectiveness t_;
  double free_[kWrenchAxes][kWrenchAxes] = {};  // T softness T', without bounds
  double softness_[kMaxActuators] = {};
};

}  // namespace seatrial
