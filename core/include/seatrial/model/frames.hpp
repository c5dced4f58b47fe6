// SPDX-License-Identifier: MIT
// Frames: body (x forward, y left, z up, REP-103) and earth-fixed.
#pragma once
#include <cmath>

namespace seatrial {

inline constexpr double kPi = 3.14159265358979323846;

/// A vector of the plane, (forward, left), in earth-fixed axes, from cos psi and sin psi.
template <class T>
inline void plane_to_earth(const T& c, const T& s, const T* body, T* earth) {
  earth[0] = c * body[0] - s * body[1];
  earth[1] = s * body[0] + c * body[1];
}

/// The inverse: an earth-fixed vector of the plane as (forward, left).
template <class T>
inline void plane_to_body(const T& c, const T& s, const T* earth, T* body) {
  body[0] = c * earth[0] + s * earth[1];
  body[1] = c * earth[1] - s * earth[0];
}

/// eta_dot = R(psi) nu, the paper's Eqs. (1) and (2), from cos psi and sin psi.
template <class T>
inline void body_to_earth(const T& c, const T& s, const T* nu, T* eta_dot) {
  plane_to_earth(c, s, nu, eta_dot);
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
