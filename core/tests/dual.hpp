// SPDX-License-Identifier: MIT
// Dual numbers with N sensitivities: the oracle for every derivative that the core writes by hand.
#pragma once
#include <array>
#include <cmath>

/// value + sum_i slope_i eps_i with eps_i eps_j = 0. f(x + eps) = f(x) + f'(x) eps.
template <int N>
struct Dual {
  double value = 0.0;
  std::array<double, N> slope{};

  Dual() = default;
  Dual(double v) : value(v) {}  // NOLINT(google-explicit-constructor): numbers mix with duals

  /// The i-th independent variable at v.
  static Dual variable(double v, int i) {
    Dual x(v);
    x.slope[static_cast<std::size_t>(i)] = 1.0;
    return x;
  }
  double operator[](int i) const { return slope[static_cast<std::size_t>(i)]; }
};

namespace dual_detail {

/// value, with the sensitivities da a + db b.
template <int N>
Dual<N> chain(double value, double da, const Dual<N>& a, double db, const Dual<N>& b) {
  Dual<N> out(value);
  for (std::size_t i = 0; i < N; ++i) out.slope[i] = da * a.slope[i] + db * b.slope[i];
  return out;
}

}  // namespace dual_detail

template <int N>
Dual<N> operator+(const Dual<N>& a, const Dual<N>& b) {
  return dual_detail::chain(a.value + b.value, 1.0, a, 1.0, b);
}
template <int N>
Dual<N> operator-(const Dual<N>& a, const Dual<N>& b) {
  return dual_detail::chain(a.value - b.value, 1.0, a, -1.0, b);
}
template <int N>
Dual<N> operator-(const Dual<N>& a) {
  return dual_detail::chain(-a.value, -1.0, a, 0.0, a);
}
template <int N>
Dual<N> operator*(const Dual<N>& a, const Dual<N>& b) {
  return dual_detail::chain(a.value * b.value, b.value, a, a.value, b);
}
template <int N>
Dual<N> operator/(const Dual<N>& a, const Dual<N>& b) {
  const double q = a.value / b.value;
  return dual_detail::chain(q, 1.0 / b.value, a, -q / b.value, b);
}
template <int N>
bool operator>(const Dual<N>& a, const Dual<N>& b) {
  return a.value > b.value;
}
template <int N>
Dual<N> abs(const Dual<N>& a) {
  const double sign = a.value > 0.0 ? 1.0 : (a.value < 0.0 ? -1.0 : 0.0);
  return dual_detail::chain(std::abs(a.value), sign, a, 0.0, a);
}
template <int N>
Dual<N> sin(const Dual<N>& a) {
  return dual_detail::chain(std::sin(a.value), std::cos(a.value), a, 0.0, a);
}
template <int N>
Dual<N> cos(const Dual<N>& a) {
  return dual_detail::chain(std::cos(a.value), -std::sin(a.value), a, 0.0, a);
}
