// SPDX-License-Identifier: MIT
// Frames: body (x forward, y left, z up, REP-103) and earth-fixed.
#pragma once
#include <cmath>

namespace seatrial {

inline constexpr double kPi = 3.14159265358979323846;

/// eta_dot = R(psi) nu, the paper's Eqs. (1) and (2), from cos psi and sin psi.
template <class T>
inline void body_to_earth(const T& c, const T& s, const T* nu, T* eta_dot) {
  eta_dot[0] = c * nu[0] - s * nu[1];
  eta_dot[1] = s * nu[0] + c * nu[1];
  eta_dot[2] = nu[2];
}

/// The same. psi [rad], nu [m/s, m/s, rad/s].
template <class T>
inline void body_to_earth(const T& psi, const T* nu, T* eta_dot) {
  using std::cos;
  using std::sin;
  body_to_earth(T(cos(psi)), T(sin(psi)), nu, eta_dot);
}

/// nu = R(psi)^T eta_dot, the inverse of Eq. (1).
template <class T>
inline void earth_to_body(const T& psi, const T* eta_dot, T* nu) {
  using std::cos;
  using std::sin;
  body_to_earth(T(cos(psi)), T(-sin(psi)), eta_dot, nu);  // R^T turns back
}

/// The angle in (-pi, pi] that equals `angle` [rad] up to whole turns.
inline double wrap(double angle) {
  const double turned = std::remainder(angle, 2.0 * kPi);
  return turned <= -kPi ? kPi : turned;
}

}  // namespace seatrial
