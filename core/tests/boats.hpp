// SPDX-License-Identifier: MIT
// Boats and command scripts that the tests share.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <limits>
#include <random>
#include <vector>

#include "chains.hpp"
#include "seatrial/integration/thrust_trace.hpp"

namespace boats {

using namespace seatrial;  // NOLINT(google-build-using-namespace)

/// Fixed seed, same numbers on every machine.
class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}
  double operator()(double low, double high) {
    return low + (high - low) * std::ldexp(static_cast<double>(engine_() >> 11U), -53);
  }
  void fill(double* to, int n, double low, double high) {
    for (int i = 0; i < n; ++i) to[i] = (*this)(low, high);
  }

 private:
  std::mt19937_64 engine_;
};

/// The largest deviation seen; infinite once a NaN was seen.
class Worst {
 public:
  void see(double got, double want, double scale = 1.0) {
    const double off = std::abs(got - want) / scale;
    value_ = std::isnan(off) ? std::numeric_limits<double>::infinity() : std::max(value_, off);
    ++seen_;
  }
  /// Infinite also where nothing was compared, so that a test can't pass by doing nothing.
  double value() const { return seen_ > 0 ? value_ : std::numeric_limits<double>::infinity(); }

 private:
  double value_ = 0.0;
  int seen_ = 0;
};

inline void add(Structure& s, int axis, int coefficient, double number,
                std::initializer_list<int> factors, int acceleration = -1) {
  Term& t = s.terms[s.n_terms++];
  t.axis = static_cast<std::uint8_t>(axis);
  t.coefficient = static_cast<std::int8_t>(coefficient);
  t.number = number;
  t.acceleration = static_cast<std::int8_t>(acceleration);
  for (const int f : factors) t.factors[t.n_factors++] = static_cast<std::uint8_t>(f);
  s.n_coefficients = std::max(s.n_coefficients, coefficient + 1);
  s.has_acceleration = s.has_acceleration || acceleration >= 0;
}

inline constexpr int kFu = kForce0;
inline constexpr int kFv = kForce0 + 1;
inline constexpr int kFr = kForce0 + 2;

/// The paper's Eq. (12).
enum Mallard { kXu, kXuu, kXF, kYv, kYvv, kYF, kNud, kNr, kNrr, kNuu, kNF, kMallardSize };

inline Structure mallard() {
  Structure s;
  s.n_forces = 3;
  add(s, 0, -1, 1.0, {kV, kR});
  add(s, 0, kXu, 1.0, {kU});
  add(s, 0, kXuu, 1.0, {kAbsU, kU});
  add(s, 0, kXF, 1.0, {kFu});
  add(s, 1, -1, -1.0, {kU, kR});
  add(s, 1, kYv, 1.0, {kV});
  add(s, 1, kYvv, 1.0, {kAbsV, kV});
  add(s, 1, kYF, 1.0, {kFv});
  add(s, 2, kNud, 1.0, {}, 0);
  add(s, 2, kNr, 1.0, {kR});
  add(s, 2, kNrr, 1.0, {kAbsR, kR});
  add(s, 2, kNuu, 1.0, {kAbsU, kU});
  add(s, 2, kNF, 1.0, {kFr});
  return s;
}

/// Table II, MP column.
inline std::vector<double> mallard_coefficients() {
  return {-0.10, -1.67, 0.15, -0.23, -1.26, 0.26, -0.14, -0.73, -0.30, 1.07, 1.39};
}

/// Eq. (12) as printed, with u_dot put in by hand.
inline void mallard_by_hand(const double* c, const double* nu, const double* F, double* nu_dot) {
  const double u = nu[0];
  const double v = nu[1];
  const double r = nu[2];
  nu_dot[0] = v * r + (c[kXuu] * std::abs(u) + c[kXu]) * u + c[kXF] * F[0];
  nu_dot[1] = -u * r + (c[kYvv] * std::abs(v) + c[kYv]) * v + c[kYF] * F[1];
  nu_dot[2] = c[kNud] * nu_dot[0] + (c[kNrr] * std::abs(r) + c[kNr]) * r +
              c[kNuu] * std::abs(u) * u + c[kNF] * F[2];
}

/// Cross drag, cyclic accelerations, a shared coefficient, force times velocity, a bias.
enum Rich {
  kShared,
  kRXu,
  kRXuu,
  kRXF,
  kXFu,
  kXrd,
  kRYv,
  kYr,
  kYrr,
  kRYF,
  kYrd,
  kRNr,
  kNv,
  kNvv,
  kRNF,
  kNFuv,
  kNvd,
  kRNud,
  kBias,
  kRichSize
};

inline Structure rich() {
  Structure s;
  s.n_forces = 3;
  add(s, 0, kShared, 1.0, {kV, kR});
  add(s, 0, kRXu, 1.0, {kU});
  add(s, 0, kRXuu, 1.0, {kAbsU, kU});
  add(s, 0, kRXF, 1.0, {kFu});
  add(s, 0, kXFu, 1.0, {kFu, kU});
  add(s, 0, kXrd, 1.0, {kAbsV}, 2);
  add(s, 1, kShared, -1.0, {kU, kR});
  add(s, 1, kRYv, 1.0, {kV});
  add(s, 1, kYr, 1.0, {kR});
  add(s, 1, kYrr, 1.0, {kAbsR, kR});
  add(s, 1, kRYF, 1.0, {kFv});
  add(s, 1, kYrd, 1.0, {}, 2);
  add(s, 1, -1, 0.07, {}, 0);
  add(s, 2, kRNr, 1.0, {kR});
  add(s, 2, kNv, 1.0, {kV});
  add(s, 2, kNvv, 0.5, {kAbsV, kV});
  add(s, 2, kRNF, 1.0, {kFr});
  add(s, 2, kNFuv, 1.0, {kFr, kU, kAbsV, kFu});
  add(s, 2, kNvd, 1.0, {}, 1);
  add(s, 2, kRNud, 1.0, {kU}, 0);
  add(s, 2, kBias, 1.0, {});
  return s;
}

inline std::vector<double> rich_coefficients() {
  return {0.9,  -0.15, -1.4, 0.16, -0.08, 0.11, -0.3,  0.12, -0.09, 0.24,
          -0.2, -0.6,  0.15, 0.4,  1.2,   0.25, -0.35, 0.17, 0.02};
}

/// Each equation's right-hand side at given accelerations, less the acceleration: 0 if solved.
inline void rich_residual(const double* c, const double* nu, const double* F, const double* nu_dot,
                          double* residual) {
  const double u = nu[0];
  const double v = nu[1];
  const double r = nu[2];
  residual[0] = c[kShared] * v * r + c[kRXu] * u + c[kRXuu] * std::abs(u) * u + c[kRXF] * F[0] +
                c[kXFu] * F[0] * u + c[kXrd] * std::abs(v) * nu_dot[2] - nu_dot[0];
  residual[1] = -c[kShared] * u * r + c[kRYv] * v + c[kYr] * r + c[kYrr] * std::abs(r) * r +
                c[kRYF] * F[1] + c[kYrd] * nu_dot[2] + 0.07 * nu_dot[0] - nu_dot[1];
  residual[2] = c[kRNr] * r + c[kNv] * v + 0.5 * c[kNvv] * std::abs(v) * v + c[kRNF] * F[2] +
                c[kNFuv] * F[2] * u * std::abs(v) * F[0] + c[kNvd] * nu_dot[1] +
                c[kRNud] * u * nu_dot[0] + c[kBias] - nu_dot[2];
}

/// A piecewise-constant signal that owns its numbers.
struct Script {
  int width = 0;
  std::vector<double> time;   // [s]
  std::vector<double> value;  // rows of width

  void add(double t, std::initializer_list<double> row) {
    width = static_cast<int>(row.size());
    time.push_back(t);
    value.insert(value.end(), row);
  }
  const double* row(int i) const { return value.data() + static_cast<std::ptrdiff_t>(i) * width; }
  int size() const { return static_cast<int>(time.size()); }
  Held held() const { return {size(), width, time.data(), value.data()}; }
  /// The row that holds at t; the first row has held for ever.
  const double* holding(double t) const {
    int i = 0;
    while (i + 1 < size() && time[static_cast<std::size_t>(i) + 1] <= t) ++i;
    return row(i);
  }
};

/// n rows from t0 on, 50 to 300 ms apart; each third row repeats the one before.
inline Script random_script(std::uint64_t seed, int n, int width, double t0, double low,
                            double high) {
  Random random(seed);
  Script s;
  s.width = width;
  double t = t0;
  for (int i = 0; i < n; ++i) {
    s.time.push_back(t);
    t += random(0.05, 0.3);
    for (int j = 0; j < width; ++j) {
      const double drawn = random(low, high);
      s.value.push_back(i % 3 == 2 ? s.row(i - 1)[j] : drawn);
    }
  }
  return s;
}

/// All initial states, coefficients and constants.
inline Columns all_columns(const Structure& s, const Chain& c) {
  Columns columns;
  columns.n_initial = kStates;
  columns.n_coefficients = s.n_coefficients;
  columns.n_constants = c.n_constants;
  for (int i = 0; i < s.n_coefficients; ++i) columns.coefficient[i] = i;
  for (int i = 0; i < c.n_constants; ++i) columns.constant[i] = i;
  return columns;
}

}  // namespace boats
