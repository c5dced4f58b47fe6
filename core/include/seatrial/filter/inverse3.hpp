// SPDX-License-Identifier: MIT
// Symmetric 3 x 3 matrices.
#pragma once

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

}  // namespace seatrial::detail
