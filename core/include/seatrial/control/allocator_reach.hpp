// SPDX-License-Identifier: MIT
// Which wrenches thrusters between bounds can give: the zonotope {T y : low <= y <= high}, by the
// planes of its faces. Every face is spanned by two thrusters (McMullen 1971); where an axis has no
// thrust, by one thruster and that axis, which is then without limits.
#pragma once
#include <algorithm>
#include <cmath>
#include <limits>

#include "seatrial/actuators/allocation.hpp"

namespace seatrial {

inline constexpr int kWrenchAxes = 3;  // surge, sway, yaw
inline constexpr int kMaxFaces = kMaxActuators * (kMaxActuators - 1) / 2;
static_assert(kMaxFaces >= kMaxActuators);

/// T (3 x n): what unit thrust of each thruster gives, in command units.
struct Effectiveness {
  int n = 0;
  double column[kMaxActuators][kWrenchAxes] = {};

  /// Whether no thruster pushes along an axis.
  bool idle(int axis) const {
    for (int k = 0; k < n; ++k) {
      if (column[k][axis] != 0.0) return false;
    }
    return true;
  }

  int driven() const {
    int axes = 0;
    for (int j = 0; j < kWrenchAxes; ++j) axes += idle(j) ? 0 : 1;
    return axes;
  }

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

inline double dot3(const double* a, const double* b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

inline void cross3(const double* a, const double* b, double* out) {
  out[0] = a[1] * b[2] - a[2] * b[1];
  out[1] = a[2] * b[0] - a[0] * b[2];
  out[2] = a[0] * b[1] - a[1] * b[0];
}

}  // namespace detail

inline constexpr double kLeastRank = 1e-12;  // determinant of T T' over the product of its diagonal
inline constexpr double kNoEntry = 1e-12;    // of T+: a smaller one is round-off

/// T+ = T' (T T')^-1 of the axes with thrust; false where they depend on each other.
inline bool pseudo_inverse(const Effectiveness& t, double (*inverse)[kWrenchAxes]) {
  double gram[kWrenchAxes][kWrenchAxes] = {};
  for (int k = 0; k < t.n; ++k) {
    for (int i = 0; i < kWrenchAxes; ++i) {
      for (int j = 0; j < kWrenchAxes; ++j) gram[i][j] += t.column[k][i] * t.column[k][j];
    }
  }
  for (int j = 0; j < kWrenchAxes; ++j) gram[j][j] = t.idle(j) ? 1.0 : gram[j][j];
  double adjoint[kWrenchAxes][kWrenchAxes];
  for (int i = 0; i < kWrenchAxes; ++i) {
    detail::cross3(gram[(i + 1) % kWrenchAxes], gram[(i + 2) % kWrenchAxes], adjoint[i]);
  }
  const double determinant = detail::dot3(gram[0], adjoint[0]);
  const double size = gram[0][0] * gram[1][1] * gram[2][2];
  if (!(determinant > kLeastRank * size)) return false;
  for (int k = 0; k < t.n; ++k) {
    for (int j = 0; j < kWrenchAxes; ++j) {
      const double entry = detail::dot3(adjoint[j], t.column[k]) / determinant;
      inverse[k][j] = std::abs(entry) < kNoEntry ? 0.0 : entry;
    }
  }
  return true;
}

/// The attainable wrenches, as slabs low <= normal . F <= high.
class Reach {
 public:
  Reach() = default;

  Reach(const Effectiveness& t, const Bounds& bounds) {
    for (int axis = 0; axis < kWrenchAxes; ++axis) {
      if (!t.idle(axis)) continue;
      double unit[kWrenchAxes] = {};
      unit[axis] = 1.0;
      for (int i = 0; i < t.n; ++i) add_face(t, bounds, i, i, unit);
      return;
    }
    for (int i = 0; i < t.n; ++i) {
      for (int j = i + 1; j < t.n; ++j) add_face(t, bounds, i, j, t.column[j]);
    }
  }

  /// The largest multiple in [0, most] of `direction` that may be added to `from`, a wrench within
  /// reach.
  double along(const double* from, const double* direction, double most) const {
    double alpha = most;
    for (int i = 0; i < n_; ++i) {
      const double rate = detail::dot3(normal_[i], direction);
      const double at = detail::dot3(normal_[i], from);
      if (rate > kParallel) alpha = std::min(alpha, (high_[i] - at) / rate);
      if (rate < -kParallel) alpha = std::min(alpha, (low_[i] - at) / rate);
    }
    return std::max(alpha, 0.0);
  }

  /// The largest a in [0, 1] for which from + a first + b rest is within reach with some b in [0,
  /// 1], and then the largest b: a linear programme in the plane, face by face (Seidel 1991). There
  /// must be such a and b.
  void most(const double* from, const double* first, const double* rest, double* a,
            double* b) const {
    Half half[2 * kMaxFaces + 4] = {{1, 0, 1}, {0, 1, 1}, {-1, 0, 0}, {0, -1, 0}};
    int n = 4;
    for (int i = 0; i < n_; ++i) {
      const double p = detail::dot3(normal_[i], first);
      const double q = detail::dot3(normal_[i], rest);
      const double length = std::sqrt(p * p + q * q);
      if (length < kParallel) continue;
      const double at = detail::dot3(normal_[i], from);
      const double per = 1.0 / length;
      half[n++] = {p * per, q * per, (high_[i] - at) * per};
      half[n++] = {-p * per, -q * per, (at - low_[i]) * per};
    }
    *a = *b = 1.0;
    for (int i = 4; i < n; ++i) {
      if (half[i].p * *a + half[i].q * *b > half[i].bound + kParallel) best_on(half, i, a, b);
    }
  }

  /// On a face only the thrusters that span it are free: fixes all others of each face that the
  /// wrench lies on at the bound that the face stands for.
  void pin(const Effectiveness& t, const double* wrench, Bounds& bounds) const {
    if (std::abs(depth(wrench)) > kOnFace) return;
    for (int i = 0; i < n_; ++i) {
      const double at = detail::dot3(normal_[i], wrench);
      const bool top = std::abs(high_[i] - at) < kOnFace;
      if (!top && std::abs(at - low_[i]) >= kOnFace) continue;
      for (int k = 0; k < t.n; ++k) {
        const double share = detail::dot3(normal_[i], t.column[k]);
        if (std::abs(share) < kInPlane) continue;
        if (top == (share > 0.0)) {
          bounds.low[k] = bounds.high[k];
        } else {
          bounds.high[k] = bounds.low[k];
        }
      }
    }
  }

  /// How far a wrench is inside the nearest face; negative outside.
  double depth(const double* wrench) const {
    double least = n_ > 0 ? high_[0] - low_[0] : 0.0;
    for (int i = 0; i < n_; ++i) {
      const double at = detail::dot3(normal_[i], wrench);
      least = std::min(least, std::min(high_[i] - at, at - low_[i]));
    }
    return least;
  }

 private:
  static constexpr double kParallel = 1e-12;
  static constexpr double kOnFace = 1e-11;  // [command units]
  static constexpr double kInPlane = 1e-9;

  /// p a + q b <= bound, with p^2 + q^2 = 1.
  struct Half {
    double p;
    double q;
    double bound;
  };

  /// The best point within the first `last` half planes on the line that ends half plane `last`.
  static void best_on(const Half* half, int last, double* a, double* b) {
    const Half& line = half[last];
    double low = -std::numeric_limits<double>::infinity();
    double high = std::numeric_limits<double>::infinity();
    for (int i = 0; i < last; ++i) {  // the point bound (p, q) + t (-q, p)
      const double rate = half[i].q * line.p - half[i].p * line.q;
      const double left = half[i].bound - line.bound * (half[i].p * line.p + half[i].q * line.q);
      if (rate > kParallel) high = std::min(high, left / rate);
      if (rate < -kParallel) low = std::max(low, left / rate);
    }
    const bool up = std::abs(line.q) > kParallel ? line.q < 0.0 : line.p > 0.0;
    const double t = low > high ? 0.5 * (low + high) : up ? high : low;
    *a = line.bound * line.p - t * line.q;
    *b = line.bound * line.q + t * line.p;
  }

  /// Spanned by thruster i and a second vector: of thruster j, or an axis without thrust (j = i).
  void add_face(const Effectiveness& t, const Bounds& bounds, int i, int j, const double* second) {
    double* normal = normal_[n_];
    detail::cross3(t.column[i], second, normal);
    const double length = std::sqrt(detail::dot3(normal, normal));
    if (length < kParallel) return;  // two thrusters in line span no face
    double low = 0.0;
    double high = 0.0;
    for (int a = 0; a < kWrenchAxes; ++a) normal[a] /= length;
    for (int k = 0; k < t.n; ++k) {
      const double share = k == i || k == j ? 0.0 : detail::dot3(normal, t.column[k]);
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
