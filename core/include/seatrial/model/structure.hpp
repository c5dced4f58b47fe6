// SPDX-License-Identifier: MIT
// A model structure is data: for each axis a list of terms, each a product of factors.
#pragma once
#include <cmath>
#include <cstdint>

namespace seatrial {

inline constexpr int kAxes = 3;        // surge, sway, yaw
inline constexpr int kMaxForces = 8;   // generalised forces F_j
inline constexpr int kMaxFactors = 4;  // factors of one term
inline constexpr int kMaxTerms = 48;   // terms of all axes together
inline constexpr int kMaxCoefficients = 40;

/// What a factor can be. Force j is kForce0 + j.
enum Signal : std::uint8_t { kU = 0, kV, kR, kAbsU, kAbsV, kAbsR, kForce0 };
inline constexpr int kMaxSignals = kForce0 + kMaxForces;

/// One term of one axis: number * coefficient * product of factors [* acceleration of an axis].
struct Term {
  std::uint8_t axis = 0;                    // 0 surge, 1 sway, 2 yaw: the equation it stands in
  std::int8_t coefficient = -1;             // index into the coefficients; -1: none (known term)
  double number = 1.0;                      // constant multiplier, for instance -1 of -u r
  std::int8_t acceleration = -1;            // 0 u_dot, 1 v_dot, 2 r_dot; -1: none
  std::uint8_t n_factors = 0;               //
  std::uint8_t factors[kMaxFactors] = {0};  // Signal codes
};

/// The right-hand side of Eq. (12) and its generalisations, as a flat list of terms.
struct Structure {
  int n_terms = 0;
  int n_coefficients = 0;
  int n_forces = 0;
  bool has_acceleration = false;
  Term terms[kMaxTerms];
};

/// Why a structure is refused; kOk otherwise.
enum class StructureFault : std::uint8_t {
  kOk,
  kTooManyTerms,
  kTooManyCoefficients,
  kTooManyForces,
  kTooManyFactors,
  kUnknownSignal,
  kUnknownAxis,
  kOwnAcceleration,
  kUnknownCoefficient,
  kAccelerationNotFlagged  // a term has one but has_acceleration is false: it would be dropped
};

inline StructureFault check(const Structure& s) {
  if (s.n_terms < 0 || s.n_terms > kMaxTerms) return StructureFault::kTooManyTerms;
  if (s.n_coefficients < 0 || s.n_coefficients > kMaxCoefficients) {
    return StructureFault::kTooManyCoefficients;
  }
  if (s.n_forces < 0 || s.n_forces > kMaxForces) return StructureFault::kTooManyForces;
  for (int i = 0; i < s.n_terms; ++i) {
    const Term& t = s.terms[i];
    if (t.axis >= kAxes || t.acceleration >= kAxes) return StructureFault::kUnknownAxis;
    if (t.acceleration >= 0 && !s.has_acceleration) return StructureFault::kAccelerationNotFlagged;
    if (t.acceleration == t.axis) return StructureFault::kOwnAcceleration;
    if (t.n_factors > kMaxFactors) return StructureFault::kTooManyFactors;
    if (t.coefficient >= s.n_coefficients) return StructureFault::kUnknownCoefficient;
    for (int k = 0; k < t.n_factors; ++k) {
      if (t.factors[k] >= kForce0 + s.n_forces) return StructureFault::kUnknownSignal;
    }
  }
  return StructureFault::kOk;
}

/// Values of all signals at (nu, F). z has kMaxSignals entries.
template <class T>
inline void signals(const Structure& s, const T* nu, const T* force, T* z) {
  using std::abs;
  for (int i = 0; i < kAxes; ++i) {
    z[i] = nu[i];
    z[kAbsU + i] = abs(nu[i]);
  }
  for (int j = 0; j < s.n_forces; ++j) z[kForce0 + j] = force[j];
}

/// The product of a term's factors: what multiplies its coefficient (and its acceleration).
template <class T>
inline T product(const Term& t, const T* z) {
  const std::uint8_t* f = t.factors;
  switch (t.n_factors) {  // most terms have one or two
    case 0:
      return T(t.number);
    case 1:
      return T(t.number) * z[f[0]];
    case 2:
      return T(t.number) * z[f[0]] * z[f[1]];
    case 3:
      return T(t.number) * z[f[0]] * z[f[1]] * z[f[2]];
    default:
      return T(t.number) * z[f[0]] * z[f[1]] * z[f[2]] * z[f[3]];
  }
}

}  // namespace seatrial
