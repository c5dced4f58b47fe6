// SPDX-License-Identifier: MIT
// Symmetric 3 x 3 matrices. No heap, no exceptions.
#pragma once
#include <cmath>

namespace seatrial::detail {

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

/// Cholesky root: l l' = s; false where s is not positive definite. Only the lower half of s is
/// read.
inline bool lower_root(const double s[3][3], double l[3][3]) {
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j <= i; ++j) {
      double sum = s[i][j];
      for (int k = 0; k < j; ++k) sum -= l[i][k] * l[j][k];
      if (i == j && !(sum > 0.0)) return false;
      l[i][j] = i == j ? std::sqrt(sum) : sum / l[j][j];
    }
  }
  return true;
}

}  // namespace seatrial::detail
