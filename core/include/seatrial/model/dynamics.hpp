// SPDX-License-Identifier: MIT
// nu_dot = (I - A)^-1 g(nu, F): the right-hand side and its exact derivatives.
#pragma once
#include <cmath>

#include "seatrial/model/structure.hpp"

namespace seatrial {

/// inverse = (I - a)^-1 for the accelerations that stand on the right; false where it is singular.
template <class T>
inline bool invert_identity_minus(const T a[kAxes][kAxes], T inverse[kAxes][kAxes]) {
  T m[3][3];
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) m[i][j] = T(i == j ? 1.0 : 0.0) - a[i][j];
  }
  const T c0 = m[1][1] * m[2][2] - m[1][2] * m[2][1];
  const T c1 = m[1][2] * m[2][0] - m[1][0] * m[2][2];
  const T c2 = m[1][0] * m[2][1] - m[1][1] * m[2][0];
  const T determinant = m[0][0] * c0 + m[0][1] * c1 + m[0][2] * c2;
  using std::abs;
  if (!(abs(determinant) > T(1e-9))) return false;
  const T d = T(1.0) / determinant;
  inverse[0][0] = c0 * d;
  inverse[0][1] = (m[0][2] * m[2][1] - m[0][1] * m[2][2]) * d;
  inverse[0][2] = (m[0][1] * m[1][2] - m[0][2] * m[1][1]) * d;
  inverse[1][0] = c1 * d;
  inverse[1][1] = (m[0][0] * m[2][2] - m[0][2] * m[2][0]) * d;
  inverse[1][2] = (m[0][2] * m[1][0] - m[0][0] * m[1][2]) * d;
  inverse[2][0] = c2 * d;
  inverse[2][1] = (m[0][1] * m[2][0] - m[0][0] * m[2][1]) * d;
  inverse[2][2] = (m[0][0] * m[1][1] - m[0][1] * m[1][0]) * d;
  return true;
}

/// nu_dot [m/s^2, m/s^2, rad/s^2] at nu [m/s, m/s, rad/s] under the generalised forces F.
/// Accelerations of other axes (N_ud u_dot) are solved for, never evaluated in order.
/// Returns false, and NaN, where I - A is singular.
template <class T>
inline bool acceleration(const Structure& s, const T* coefficient, const T* nu, const T* force,
                         T* nu_dot) {
  T z[kMaxSignals];
  signals(s, nu, force, z);
  T g[kAxes] = {T(0.0), T(0.0), T(0.0)};
  T a[kAxes][kAxes] = {};
  for (int i = 0; i < s.n_terms; ++i) {
    const Term& t = s.terms[i];
    T value = product(t, z);
    if (t.coefficient >= 0) value = value * coefficient[t.coefficient];
    if (t.acceleration < 0) {
      g[t.axis] = g[t.axis] + value;
    } else {
      a[t.axis][t.acceleration] = a[t.axis][t.acceleration] + value;
    }
  }
  if (!s.has_acceleration) {
    for (int i = 0; i < kAxes; ++i) nu_dot[i] = g[i];
    return true;
  }
  T inverse[kAxes][kAxes];
  if (!invert_identity_minus(a, inverse)) {
    for (int i = 0; i < kAxes; ++i) nu_dot[i] = T(std::nan(""));
    return false;
  }
  for (int i = 0; i < kAxes; ++i) {
    nu_dot[i] = inverse[i][0] * g[0] + inverse[i][1] * g[1] + inverse[i][2] * g[2];
  }
  return true;
}

/// Partial derivatives of nu_dot.
struct AccelerationJacobian {
  double nu[kAxes][kAxes];                      // d nu_dot / d nu
  double force[kAxes][kMaxForces];              // d nu_dot / d F
  double coefficient[kAxes][kMaxCoefficients];  // d nu_dot / d coefficient
};

namespace detail {

/// d(|w|)/dw, with 0 at 0: the products that occur (|u|u) are smooth there.
inline double sign(double w) { return w > 0.0 ? 1.0 : (w < 0.0 ? -1.0 : 0.0); }

/// Adds the derivative of one term, scaled, to the rows of its own axis.
inline void add_term(const Term& t, const double* z, const double* nu, double scale,
                     AccelerationJacobian& j) {
  for (int k = 0; k < t.n_factors; ++k) {
    double others = t.number * scale;
    for (int m = 0; m < t.n_factors; ++m) {
      if (m != k) others *= z[t.factors[m]];
    }
    const int f = t.factors[k];
    if (f < kAbsU) {
      j.nu[t.axis][f] += others;
    } else if (f < kForce0) {
      j.nu[t.axis][f - kAbsU] += others * sign(nu[f - kAbsU]);
    } else {
      j.force[t.axis][f - kForce0] += others;
    }
  }
}

/// Multiplies a block of columns by (I - A)^-1.
template <int kColumns>
inline void solve_columns(const double inverse[kAxes][kAxes], int n,
                          double block[kAxes][kColumns]) {
  for (int c = 0; c < n; ++c) {
    const double b0 = block[0][c];
    const double b1 = block[1][c];
    const double b2 = block[2][c];
    for (int i = 0; i < kAxes; ++i) {
      block[i][c] = inverse[i][0] * b0 + inverse[i][1] * b1 + inverse[i][2] * b2;
    }
  }
}

}  // namespace detail

/// nu_dot and its derivatives. With R = g + A nu_dot - nu_dot = 0 the implicit function theorem
/// gives d nu_dot = (I - A)^-1 (dg + dA nu_dot): every term is differentiated at fixed nu_dot.
inline bool acceleration_with_jacobian(const Structure& s, const double* coefficient,
                                       const double* nu, const double* force, double* nu_dot,
                                       AccelerationJacobian& j) {
  double z[kMaxSignals];
  signals(s, nu, force, z);
  double g[kAxes] = {0.0, 0.0, 0.0};
  double a[kAxes][kAxes] = {};
  double p[kMaxTerms];
  for (int i = 0; i < s.n_terms; ++i) {
    const Term& t = s.terms[i];
    p[i] = product(t, z);
    const double value = t.coefficient >= 0 ? p[i] * coefficient[t.coefficient] : p[i];
    (t.acceleration < 0 ? g[t.axis] : a[t.axis][t.acceleration]) += value;
  }
  double inverse[kAxes][kAxes] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  if (s.has_acceleration && !invert_identity_minus(a, inverse)) {
    for (int i = 0; i < kAxes; ++i) nu_dot[i] = std::nan("");
    return false;
  }
  for (int i = 0; i < kAxes; ++i) {
    nu_dot[i] = inverse[i][0] * g[0] + inverse[i][1] * g[1] + inverse[i][2] * g[2];
    for (int c = 0; c < kAxes; ++c) j.nu[i][c] = 0.0;
    for (int c = 0; c < s.n_forces; ++c) j.force[i][c] = 0.0;
    for (int c = 0; c < s.n_coefficients; ++c) j.coefficient[i][c] = 0.0;
  }
  for (int i = 0; i < s.n_terms; ++i) {
    const Term& t = s.terms[i];
    const double moved = t.acceleration < 0 ? 1.0 : nu_dot[t.acceleration];
    const double scale = (t.coefficient >= 0 ? coefficient[t.coefficient] : 1.0) * moved;
    detail::add_term(t, z, nu, scale, j);
    if (t.coefficient >= 0) j.coefficient[t.axis][t.coefficient] += p[i] * moved;
  }
  if (s.has_acceleration) {
    detail::solve_columns(inverse, kAxes, j.nu);
    detail::solve_columns(inverse, s.n_forces, j.force);
    detail::solve_columns(inverse, s.n_coefficients, j.coefficient);
  }
  return true;
}

}  // namespace seatrial
