// SPDX-License-Identifier: MIT
// Which wrenches thrusters between bounds can give: the zonotope {T y : low <= y <= high}, by the
// planes of its faces. Every face is spanned by two thrusters (McMullen 1971).
#pragma once
#include <algorithm>
#include <cmath>

#include "seatrial/allocation.hpp"

namespace seatrial {

inline constexpr int kWrenchAxes = 3;  // surge, sway, yaw
inline constexpr int kMaxFaces = kMaxActuators * (kMaxActuators - 1) / 2;

/// T (3 x n): what unit thrust of each thruster gives, in command units.
struct Effectiveness {
  int n = 0;
  double column[kMaxActuators][kWrenchAxes] = {};

  void wrench(const double* thrust, double* out) const {
    for (int j = 0; j < kWrenchAxes; ++j) out[j] = 0.0;
    for (int k = 0; k < n; ++k) {
      for (int j = 0; j < kWrenchAxes; ++j) out[j] += column[k][j] * thrust[k];
    }
  }
};

/// Bounds of every thruster's thrust.
struct Bounds {
  double low[kMaxActuators] = {};
  double high[kMaxActuators] = {};
};

namespace detail {

inline double dot(const double* a, const double* b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

inline void cross(const double* a, const double* b, double* out) {
  out[0] = a[1] * b[2] - a[2] * b[1];
  out[1] = a[2] * b[0] - a[0] * b[2];
  out[2] = a[0] * b[1] - a[1] * b[0];
}

}  // namespace detail

/// The attainable wrenches, as slabs low <= normal . F <= high.
class Reach {
 public:
  Reach() = default;

  Reach(const Effectiveness& t, const Bounds& bounds) {
    for (int i = 0; i < t.n; ++i) {
      for (int j = i + 1; j < t.n; ++j) add_face(t, bounds, i, j);
    }
  }

  /// The largest multiple in [0, most] of `direction` that may be added to `from`, a wrench within
  /// reach.
  double along(const double* from, const double* direction, double most) const {
    double alpha = most;
    for (int i = 0; i < n_; ++i) {
      const double rate = detail::dot(normal_[i], direction);
      const double at = detail::dot(normal_[i], from);
      if (rate > kParallel) alpha = std::min(alpha, (high_[i] - at) / rate);
      if (rate < -kParallel) alpha = std::min(alpha, (low_[i] - at) / rate);
    }
    return std::max(alpha, 0.0);
  }

  /// How far a wrench is inside the nearest face; negative outside.
  double depth(const double* wrench) const {
    double least = n_ > 0 ? high_[0] - low_[0] : 0.0;
    for (int i = 0; i < n_; ++i) {
      const double at = detail::dot(normal_[i], wrench);
      least = std::min(least, std::min(high_[i] - at, at - low_[i]));
    }
    return least;
  }

 private:
  static constexpr double kParallel = 1e-12;

  void add_face(const Effectiveness& t, const Bounds& bounds, int i, int j) {
    double* normal = normal_[n_];
    detail::cross(t.column[i], t.column[j], normal);
    const double length = std::sqrt(detail::dot(normal, normal));
    if (length < kParallel) return;  // two thrusters in line span no face
    double low = 0.0;
    double high = 0.0;
    for (int a = 0; a < kWrenchAxes; ++a) normal[a] /= length;
    for (int k = 0; k < t.n; ++k) {
      const double share = k == i || k == j ? 0.0 : detail::dot(normal, t.column[k]);
      low += std::min(share * bounds.low[k], share * bounds.high[k]);
      high += std::max(share * bounds.low[k], share * bounds.high[k]);
    }
    low_[n_] = low;
    high_[n_] = high;
    ++n_;
  }

  int n_ = 0;
  double normal_[kMaxFaces][kWrenchAxes] = {};
  double low_[kMaxFaces] = {};
  double high_[kMaxFaces] = {};
};

}  // namespace seatrial
