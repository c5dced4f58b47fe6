// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include "boats.hpp"
#include "dual.hpp"
#include "seatrial/model/dynamics.hpp"

using namespace seatrial;
using boats::add;
using boats::Random;
using boats::Worst;

namespace {

struct Point {
  double nu[3];
  double force[3];
  double coefficient[kMaxCoefficients];
};

/// Random states and forces, coefficients shaken by up to 20 %.
Point random_point(Random& random, const std::vector<double>& nominal) {
  Point p{};
  random.fill(p.nu, 3, -1.5, 1.5);
  random.fill(p.force, 3, -1.0, 1.0);
  for (std::size_t i = 0; i < nominal.size(); ++i) {
    p.coefficient[i] = nominal[i] * random(0.8, 1.2);
  }
  return p;
}

/// Largest deviation of the Jacobian from dual numbers over many random points.
template <int kSize>
double worst_jacobian(const Structure& s, const std::vector<double>& nominal, int points) {
  using D = Dual<6 + kSize>;
  REQUIRE(s.n_coefficients == kSize);
  Random random(11);
  Worst worst;
  for (int n = 0; n < points; ++n) {
    const Point p = random_point(random, nominal);
    D nu[3];
    D force[3];
    D coefficient[kSize];
    D nu_dot[3];
    for (int i = 0; i < 3; ++i) {
      nu[i] = D::variable(p.nu[i], i);
      force[i] = D::variable(p.force[i], 3 + i);
    }
    for (int i = 0; i < kSize; ++i) coefficient[i] = D::variable(p.coefficient[i], 6 + i);
    REQUIRE(acceleration(s, coefficient, nu, force, nu_dot));
    double value[3] = {};
    AccelerationJacobian j;
    REQUIRE(acceleration_with_jacobian(s, p.coefficient, p.nu, p.force, value, j));
    for (int i = 0; i < 3; ++i) {
      worst.see(value[i], nu_dot[i].value);
      for (int c = 0; c < 3; ++c) {
        worst.see(j.nu[i][c], nu_dot[i][c]);
        worst.see(j.force[i][c], nu_dot[i][3 + c]);
      }
      for (int c = 0; c < kSize; ++c) worst.see(j.coefficient[i][c], nu_dot[i][6 + c]);
    }
  }
  return worst.value();
}

/// u_dot = a v_dot + F_u, v_dot = b u_dot + F_v: solvable unless a b = 1.
Structure cyclic() {
  Structure s;
  s.n_forces = 2;
  add(s, 0, 0, 1.0, {}, 1);
  add(s, 0, -1, 1.0, {boats::kFu});
  add(s, 1, 1, 1.0, {}, 0);
  add(s, 1, -1, 1.0, {boats::kFv});
  return s;
}

}  // namespace

TEST_CASE("the mallard's accelerations are the paper's Eq. (12)") {
  Random random(10);
  Worst worst;
  for (int n = 0; n < 500; ++n) {
    const Point p = random_point(random, boats::mallard_coefficients());
    double got[3] = {};
    double want[3] = {};
    REQUIRE(acceleration(boats::mallard(), p.coefficient, p.nu, p.force, got));
    boats::mallard_by_hand(p.coefficient, p.nu, p.force, want);
    for (int i = 0; i < 3; ++i) worst.see(got[i], want[i]);
  }
  CHECK(worst.value() < 1e-14);
}

TEST_CASE("the solved accelerations satisfy every equation of the rich boat") {
  Random random(12);
  Worst worst;
  double coupling = 0.0;
  for (int n = 0; n < 500; ++n) {
    const Point p = random_point(random, boats::rich_coefficients());
    double nu_dot[3] = {};
    double residual[3] = {};
    REQUIRE(acceleration(boats::rich(), p.coefficient, p.nu, p.force, nu_dot));
    boats::rich_residual(p.coefficient, p.nu, p.force, nu_dot, residual);
    for (const double left : residual) worst.see(left, 0.0);
    coupling = std::max(coupling, std::abs(p.coefficient[boats::kYrd] * nu_dot[2]));
  }
  CHECK(worst.value() < 1e-14);
  CHECK(coupling > 0.1);  // the acceleration terms do matter at these points
}

TEST_CASE("accelerations that depend on each other are solved, not evaluated in order") {
  const double coefficient[2] = {0.5, -0.8};
  const double nu[3] = {0.0, 0.0, 0.0};
  const double force[kMaxForces] = {1.0, 2.0};
  double nu_dot[3] = {};
  REQUIRE(acceleration(cyclic(), coefficient, nu, force, nu_dot));
  CHECK(nu_dot[0] == doctest::Approx((1.0 + 0.5 * 2.0) / 1.4).epsilon(1e-14));
  CHECK(nu_dot[1] == doctest::Approx((2.0 - 0.8 * 1.0) / 1.4).epsilon(1e-14));
  CHECK(nu_dot[2] == 0.0);
}

TEST_CASE("the order of a structure's terms does not matter") {
  Structure reversed = boats::rich();
  std::reverse(reversed.terms, reversed.terms + reversed.n_terms);
  Random random(13);
  Worst worst;
  for (int n = 0; n < 50; ++n) {
    const Point p = random_point(random, boats::rich_coefficients());
    double a[3] = {};
    double b[3] = {};
    REQUIRE(acceleration(boats::rich(), p.coefficient, p.nu, p.force, a));
    REQUIRE(acceleration(reversed, p.coefficient, p.nu, p.force, b));
    for (int i = 0; i < 3; ++i) worst.see(a[i], b[i]);
  }
  CHECK(worst.value() < 1e-14);
}

TEST_CASE("where accelerations hold each other up there is no answer but NaN") {
  const double coefficient[2] = {0.5, 2.0};  // a b = 1
  const double nu[3] = {0.1, 0.2, 0.3};
  const double force[kMaxForces] = {1.0, 2.0};
  double nu_dot[3] = {};
  CHECK_FALSE(acceleration(cyclic(), coefficient, nu, force, nu_dot));
  for (const double value : nu_dot) CHECK(std::isnan(value));
  AccelerationJacobian j;
  std::fill(nu_dot, nu_dot + 3, 0.0);
  CHECK_FALSE(acceleration_with_jacobian(cyclic(), coefficient, nu, force, nu_dot, j));
  for (const double value : nu_dot) CHECK(std::isnan(value));
  const double unknown[2] = {std::nan(""), 2.0};
  CHECK_FALSE(acceleration(cyclic(), unknown, nu, force, nu_dot));
}

TEST_CASE("the inverse times I - A is the identity") {
  Random random(14);
  Worst worst;
  for (int n = 0; n < 200; ++n) {
    double a[3][3] = {};
    double inverse[3][3] = {};
    random.fill(&a[0][0], 9, -0.4, 0.4);
    REQUIRE(invert_identity_minus(a, inverse));
    for (int i = 0; i < 3; ++i) {
      for (int c = 0; c < 3; ++c) {
        double sum = inverse[i][c];
        for (int k = 0; k < 3; ++k) sum -= inverse[i][k] * a[k][c];
        worst.see(sum, i == c ? 1.0 : 0.0);
      }
    }
  }
  CHECK(worst.value() < 1e-13);
}

TEST_CASE("the mallard's Jacobian equals dual numbers") {
  CHECK(worst_jacobian<boats::kMallardSize>(boats::mallard(), boats::mallard_coefficients(), 500) <
        1e-12);
}

TEST_CASE("the rich boat's Jacobian equals dual numbers") {
  CHECK(worst_jacobian<boats::kRichSize>(boats::rich(), boats::rich_coefficients(), 500) < 1e-12);
}

TEST_CASE("quadratic drag is smooth where the boat stands still") {
  const auto c = boats::mallard_coefficients();
  const double still[3] = {0.0, 0.0, 0.0};
  const double force[kMaxForces] = {0.3, 0.2, 0.1};
  double nu_dot[3] = {};
  AccelerationJacobian j;
  REQUIRE(acceleration_with_jacobian(boats::mallard(), c.data(), still, force, nu_dot, j));
  CHECK(j.nu[0][0] == c[boats::kXu]);
  CHECK(j.nu[1][1] == c[boats::kYv]);
  CHECK(j.nu[2][2] == c[boats::kNr]);
  CHECK(j.nu[2][0] == doctest::Approx(c[boats::kNud] * c[boats::kXu]).epsilon(1e-14));
  CHECK(j.force[2][0] == doctest::Approx(c[boats::kNud] * c[boats::kXF]).epsilon(1e-14));
}
