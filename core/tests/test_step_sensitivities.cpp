// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include "boats.hpp"
#include "dual.hpp"
#include "no_exceptions.hpp"
#include "seatrial/integration/sensitivities.hpp"

using namespace seatrial;
using boats::Random;
using boats::Worst;

namespace {

constexpr int kFree = 4;  // constants of which everything may depend

/// One step with everything that moves it, in doubles and in duals.
template <int kSize>
struct Case {
  using D = Dual<kStates + kSize + kFree>;
  static constexpr int kFirst = kStates + kSize;

  Structure structure;
  Columns columns;
  double coefficient[kMaxCoefficients] = {};
  double h = 0.0;
  double dh[kMaxConstants] = {};
  double force[3][kMaxForces] = {};
  detail::ForceSensitivities dforce[3] = {};
  double x[kStates] = {};
  StateSensitivities dx{};
  D dual_coefficient[kSize];
  D dual_h;
  D dual_force[3][kMaxForces];
  D dual_x[kStates];

  Case(const Structure& s, const std::vector<double>& nominal, Random& random, bool length_moves)
      : structure(s) {
    columns.n_initial = kStates;
    columns.n_coefficients = kSize;
    columns.n_constants = kFree;
    for (int i = 0; i < kFree; ++i) columns.constant[i] = i;
    for (int i = 0; i < kSize; ++i) {
      columns.coefficient[i] = i;
      coefficient[i] = nominal[static_cast<std::size_t>(i)] * random(0.8, 1.2);
      dual_coefficient[i] = D::variable(coefficient[i], kStates + i);
    }
    h = random(0.01, 0.2);
    dual_h = D(h);
    for (int p = 0; p < kFree && length_moves; ++p) {
      dh[p] = random(-1.0, 1.0);
      dual_h.slope[static_cast<std::size_t>(kFirst + p)] = dh[p];
    }
    for (int node = 0; node < 3; ++node) {
      for (int j = 0; j < 3; ++j) {
        force[node][j] = random(-1.0, 1.0);
        dual_force[node][j] = D(force[node][j]);
        for (int p = 0; p < kFree; ++p) {
          dforce[node][j][p] = random(-1.0, 1.0);
          dual_force[node][j].slope[static_cast<std::size_t>(kFirst + p)] = dforce[node][j][p];
        }
      }
    }
    // sensitivities that came from earlier steps: full, not the identity
    for (int i = 0; i < kStates; ++i) {
      x[i] = random(-1.2, 1.2);
      dual_x[i] = D(x[i]);
      for (int c = 0; c < columns.size(); ++c) {
        dx.row[i][c] = random(-1.0, 1.0);
        dual_x[i].slope[static_cast<std::size_t>(c)] = dx.row[i][c];
      }
    }
  }

  void compare(Worst& worst) const {
    for (int i = 0; i < kStates; ++i) {
      worst.see(x[i], dual_x[i].value);
      for (int c = 0; c < columns.size(); ++c) worst.see(dx.row[i][c], dual_x[i][c]);
    }
  }
};

/// The largest deviation from duals over many cases; `step` takes both through one step.
template <int kSize, class Step>
double worst_step(const Structure& s, const std::vector<double>& nominal, bool length_moves,
                  Step step) {
  Random random(length_moves ? 41 : 40);
  Worst worst;
  for (int n = 0; n < 200; ++n) {
    Case<kSize> c(s, nominal, random, length_moves);
    step(c);
    c.compare(worst);
  }
  return worst.value();
}

}  // namespace

TEST_CASE("an Euler step's sensitivities equal dual numbers") {
  const auto step = [](auto& c) {
    REQUIRE(euler_step(c.structure, c.dual_coefficient, c.dual_h, c.dual_force[0], c.dual_x));
    REQUIRE(euler_step_sensitivities(c.structure, c.coefficient, c.columns, c.h, c.force[0],
                                     c.dforce[0], c.x, c.dx));
  };
  CHECK(worst_step<boats::kMallardSize>(boats::mallard(), boats::mallard_coefficients(), false,
                                        step) < 1e-11);
  CHECK(worst_step<boats::kRichSize>(boats::rich(), boats::rich_coefficients(), false, step) <
        1e-11);
}

TEST_CASE("a Runge-Kutta step's sensitivities equal dual numbers, also to the step's length") {
  const auto step = [](auto& c) {
    REQUIRE(runge_kutta_step(c.structure, c.dual_coefficient, c.dual_h, c.dual_force, c.dual_x));
    REQUIRE(runge_kutta_step_sensitivities(c.structure, c.coefficient, c.columns, c.h, c.dh,
                                           c.force, c.dforce, c.x, c.dx));
  };
  CHECK(worst_step<boats::kMallardSize>(boats::mallard(), boats::mallard_coefficients(), true,
                                        step) < 1e-11);
  CHECK(worst_step<boats::kRichSize>(boats::rich(), boats::rich_coefficients(), true, step) <
        1e-11);
}

TEST_CASE("sensitivities start as the identity in the initial state, where that is a column") {
  Columns columns;
  columns.n_initial = kStates;
  columns.n_coefficients = 2;
  columns.n_constants = 1;
  StateSensitivities dx;
  seed(columns, dx);
  CHECK(columns.size() == 9);
  CHECK(columns.first_constant() == 8);
  for (int i = 0; i < kStates; ++i) {
    for (int c = 0; c < 9; ++c) CHECK(dx.row[i][c] == (i == c ? 1.0 : 0.0));
  }
  columns.n_initial = 0;
  seed(columns, dx);
  for (const auto& row : dx.row) {
    for (int c = 0; c < 3; ++c) CHECK(row[c] == 0.0);
  }
}

TEST_CASE("only the columns that are chosen are computed, in the order chosen") {
  const auto nominal = boats::mallard_coefficients();
  Random random(42);
  Case<boats::kMallardSize> all(boats::mallard(), nominal, random, true);
  seed(all.columns, all.dx);
  Columns few;
  few.n_coefficients = 2;
  few.coefficient[0] = boats::kNF;
  few.coefficient[1] = boats::kXuu;
  StateSensitivities dx;
  seed(few, dx);
  double x[kStates];
  std::copy(all.x, all.x + kStates, x);
  REQUIRE(runge_kutta_step_sensitivities(boats::mallard(), all.coefficient, few, all.h, all.dh,
                                         all.force, all.dforce, x, dx));
  REQUIRE(runge_kutta_step_sensitivities(boats::mallard(), all.coefficient, all.columns, all.h,
                                         all.dh, all.force, all.dforce, all.x, all.dx));
  for (int i = 0; i < kStates; ++i) {
    CHECK(x[i] == all.x[i]);
    CHECK(dx.row[i][0] == all.dx.row[i][kStates + boats::kNF]);
    CHECK(dx.row[i][1] == all.dx.row[i][kStates + boats::kXuu]);
  }
}

TEST_CASE("an interval's sensitivities equal central differences of the interval") {
  // level, target, multiplier, lag and the length move with one constant each
  Chain c = boats::plain_chain(Scheme::kMoorePenrose);
  c.n_constants = 5;
  for (int k = 0; k < 4; ++k) c.actuators[k].lag = 4;
  const auto coefficient = boats::rich_coefficients();
  const double direction[4] = {0.3, -0.7, 1.1, 0.4};
  const auto run = [&](const double* p, double* x, bool sensitivities, StateSensitivities* dx) {
    const double q[5] = {0.0, 0.0, 0.0, 0.0, 0.08 + p[4]};
    Columns columns;
    columns.n_constants = 5;
    for (int i = 0; i < 5; ++i) columns.constant[i] = i;
    Thrust f;
    ThrustSensitivities df;
    for (int k = 0; k < 4; ++k) {
      f.level[k] = 0.2 * k - 0.3 + p[0] * direction[k];
      f.target[k] = 0.5 - 0.3 * k + p[1] * direction[k];
      f.multiplier[k] = 1.0 + 0.1 * k + p[2] * direction[k];
      df.level[k][0] = direction[k];
      df.target[k][1] = direction[k];
      df.multiplier[k][2] = direction[k];
    }
    const double start[kStates] = {0.0, 0.0, 0.3, 0.4, 0.3, 0.5};
    std::copy(start, start + kStates, x);
    const double length = 0.21 + p[3];
    if (!sensitivities) {
      REQUIRE(advance(boats::rich(), coefficient.data(), c, q, length, 0.016, f, x));
      return;
    }
    double dlength[kMaxConstants] = {0.0};
    dlength[3] = 1.0;
    seed(columns, *dx);
    REQUIRE(advance_sensitivities(boats::rich(), coefficient.data(), c, q, columns, length, dlength,
                                  0.016, f, df, x, *dx));
  };
  double p[5] = {0.0};
  double x[kStates];
  double plain[kStates];
  StateSensitivities dx;
  run(p, x, true, &dx);
  run(p, plain, false, nullptr);
  Worst value;
  for (int i = 0; i < kStates; ++i) value.see(x[i], plain[i]);
  CHECK(value.value() < 1e-14);
  Worst worst;
  for (int n = 0; n < 5; ++n) {
    double up[kStates];
    double down[kStates];
    double size = 0.0;
    p[n] = 1e-6;
    run(p, up, false, nullptr);
    p[n] = -1e-6;
    run(p, down, false, nullptr);
    p[n] = 0.0;
    for (int i = 0; i < kStates; ++i) {
      const double want = (up[i] - down[i]) / 2e-6;
      worst.see(dx.row[i][n], want);
      size = std::max(size, std::abs(want));
    }
    CHECK(size > 1e-3);
  }
  CHECK(worst.value() < 1e-9);
}

TEST_CASE("a shortest of lags moves the boat alike with and without sensitivities") {
  // exp(-h / lag) is below the smallest double, yet the lag counts
  Chain c = boats::plain_chain(Scheme::kMoorePenrose);
  c.n_constants = 1;
  for (int k = 0; k < 4; ++k) c.actuators[k].lag = 0;
  const double q[1] = {1e-5};
  const auto coefficient = boats::mallard_coefficients();
  Thrust f;
  for (int k = 0; k < 4; ++k) {
    f.target[k] = 0.3 * k;
    f.multiplier[k] = 1.0;
  }
  Thrust g = f;
  ThrustSensitivities dg;
  Columns columns;
  columns.n_constants = 1;
  StateSensitivities dx;
  seed(columns, dx);
  const double still[kMaxConstants] = {0.0};
  double x[kStates] = {0.0};
  double y[kStates] = {0.0};
  REQUIRE(advance(boats::mallard(), coefficient.data(), c, q, 0.5, 1.0 / 60.0, f, x));
  REQUIRE(advance_sensitivities(boats::mallard(), coefficient.data(), c, q, columns, 0.5, still,
                                1.0 / 60.0, g, dg, y, dx));
  Worst worst;
  for (int i = 0; i < kStates; ++i) worst.see(y[i], x[i]);
  CHECK(worst.value() < 1e-14);
}

TEST_CASE("what runs on board also runs where there are no exceptions") {
  CHECK(drive_without_exceptions() == doctest::Approx(1.0 - std::exp(-1.0)).epsilon(1e-9));
  double slope = 0.0;
  CHECK(drive_with_sensitivities(&slope) == doctest::Approx(1.0 - std::exp(-1.0)).epsilon(1e-9));
  // u = (exp(c t) - 1) / c, so du/dc = (t exp(c t) c - exp(c t) + 1) / c^2 at c = -1, t = 1
  CHECK(slope == doctest::Approx(1.0 - 2.0 * std::exp(-1.0)).epsilon(1e-8));
}
