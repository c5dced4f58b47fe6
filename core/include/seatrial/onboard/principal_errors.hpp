// SPDX-License-Identifier: MIT
// Principal errors: the few combinations of parameter errors that explain nearly all of their
// effect on the motion. Host side: uses heap.
//
// Along a drive parameter errors e of covariance C = R R' give the state an error S e, S = d state
// / d parameters; of the pose, that of the last ten seconds. With e = R z the errors z are
// independent and of unit variance. W is the sum of S' S over the drive, each state relative to its
// own mean square. The principal directions U of R' W R sort z by their effect. Errors that cancel
// in the range of motion cancel in S.
#pragma once
#include <numeric>

#include "seatrial/onboard/random_drive.hpp"

namespace seatrial {
namespace detail {

/// A square matrix on the heap.
class Square {
 public:
  explicit Square(int n) : n_(n), a_(static_cast<std::size_t>(n) * static_cast<std::size_t>(n)) {}
  int size() const { return n_; }
  double& operator()(int i, int j) { return a_[place(i, j)]; }
  double operator()(int i, int j) const { return a_[place(i, j)]; }

 private:
  std::size_t place(int i, int j) const {
    return static_cast<std::size_t>(i) * static_cast<std::size_t>(n_) + static_cast<std::size_t>(j);
  }
  int n_;
  std::vector<double> a_;
};

/// Eigenvalues on the diagonal of a symmetric matrix, by Jacobi's rotations (Golub and Van Loan,
/// 8.5); columns of v: the eigenvectors.
inline void diagonalise(Square& a, Square& v) {
  constexpr int kSweeps = 30;
  const int n = a.size();
  for (int i = 0; i < n; ++i) v(i, i) = 1.0;
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    bool turned = false;
    for (int p = 0; p < n; ++p) {
      for (int q = p + 1; q < n; ++q) {
        const double off = a(p, q);
        if (!(std::abs(off) > 1e-15 * std::sqrt(std::abs(a(p, p) * a(q, q))))) continue;
        turned = true;
        const double theta = 0.5 * (a(q, q) - a(p, p)) / off;
        const double t = std::copysign(1.0, theta) / (std::abs(theta) + std::hypot(theta, 1.0));
        const double c = 1.0 / std::hypot(t, 1.0);
        const double s = t * c;
        for (int i = 0; i < n; ++i) {
          const double x = a(i, p);
          a(i, p) = c * x - s * a(i, q);
          a(i, q) = s * x + c * a(i, q);
        }
        for (int i = 0; i < n; ++i) {
          const double x = a(p, i);
          a(p, i) = c * x - s * a(q, i);
          a(q, i) = s * x + c * a(q, i);
          const double y = v(i, p);
          v(i, p) = c * y - s * v(i, q);
          v(i, q) = s * y + c * v(i, q);
        }
      }
    }
    if (!turned) break;
  }
}

/// Sums over a drive, state by state.
struct DriveSums {
  std::vector<Square> slopes;  // S' S

  explicit DriveSums(int n) : slopes(kStates, Square(n)) {}

  /// False where a number is not finite.
  bool add(const StateSensitivities& dx, int n) {
    double size = 0.0;
    for (const auto& row : dx.row) {
      for (int i = 0; i < n; ++i) size += std::abs(row[i]);
    }
    if (!std::isfinite(size)) return false;
    for (int state = 0; state < kStates; ++state) {
      const double* s = dx.row[state];
      Square& sum = slopes[static_cast<std::size_t>(state)];
      for (int i = 0; i < n; ++i) {
        for (int j = 0; j < n; ++j) sum(i, j) += s[i] * s[j];
      }
    }
    return true;
  }
};

/// R with C = R R'.
inline Square root_of(const double (*c)[kMaxParameters], int n) {
  Square values(n);
  Square root(n);
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) values(i, j) = 0.5 * (c[i][j] + c[j][i]);
  }
  diagonalise(values, root);
  for (int k = 0; k < n; ++k) {
    const double length = std::sqrt(std::max(values(k, k), 0.0));
    for (int i = 0; i < n; ++i) root(i, k) *= length;
  }
  return root;
}

/// R' W R, W of each state relative to its mean square by C.
inline Square effects(const DriveSums& sum, const Square& root) {
  const int n = root.size();
  Square out(n);
  for (const Square& w : sum.slopes) {
    Square half(n);
    Square own(n);
    double trace = 0.0;
    for (int i = 0; i < n; ++i) {
      for (int k = 0; k < n; ++k) {
        if (w(i, k) == 0.0) continue;
        for (int j = 0; j < n; ++j) half(i, j) += w(i, k) * root(k, j);
      }
    }
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j < n; ++j) {
        for (int k = 0; k < n; ++k) own(i, j) += root(k, i) * half(k, j);
      }
      trace += own(i, i);
    }
    if (!(trace > 0.0)) continue;
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j < n; ++j) out(i, j) += own(i, j) / trace;
    }
  }
  return out;
}

/// R U of the largest eigenvalues.
inline PrincipalErrors principal(const UncertainModel& m, const DriveSums& sum) {
  const int n = m.n_parameters();
  const int own = m.boat.structure.n_coefficients;
  const Square root = root_of(m.covariance, n);
  Square values = effects(sum, root);
  Square turn(n);
  diagonalise(values, turn);
  std::vector<int> order(static_cast<std::size_t>(n));
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](int i, int j) { return values(i, i) > values(j, j); });
  PrincipalErrors out;
  for (const int k : order) {
    if (out.n == kMostConsidered || !(values(k, k) > 0.0)) break;
    for (int i = 0; i < n; ++i) {
      double& to = i < own ? out.coefficient[i][out.n] : out.constant[i - own][out.n];
      for (int j = 0; j < n; ++j) to += root(i, j) * turn(j, k);
    }
    ++out.n;
  }
  return out;
}

}  // namespace detail

/// The principal errors along a random drive; none where there is no such drive.
inline PrincipalErrors principal_errors(const UncertainModel& m) {
  PrincipalErrors out;
  with_strongest_commands(m, [&m, &out](double most) {
    detail::DriveSums sum(m.n_parameters());
    const int instants = detail::random_drive(
        m, most, [&](const ThrustTrace&, double, const double*, const StateSensitivities& dx) {
          return sum.add(dx, m.n_parameters());
        });
    if (instants < detail::kEnough) return false;
    out = detail::principal(m, sum);
    return true;
  });
  return out;
}

}  // namespace seatrial
