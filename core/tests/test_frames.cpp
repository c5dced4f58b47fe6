// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include "boats.hpp"
#include "dual.hpp"
#include "seatrial/model/frames.hpp"

using boats::Random;
using boats::Worst;
using namespace seatrial;

TEST_CASE("pi is the C library's") { CHECK(kPi == std::acos(-1.0)); }

TEST_CASE("a boat that heads along earth's y and surges moves along y, and sways to minus x") {
  const double nu[3] = {0.7, 0.2, -0.4};
  double rate[3];
  body_to_earth(0.5 * kPi, nu, rate);
  CHECK(rate[0] == doctest::Approx(-0.2));
  CHECK(rate[1] == doctest::Approx(0.7));
  CHECK(rate[2] == -0.4);
}

TEST_CASE("a rotation is multiplication by exp(i psi)") {
  Random random(1);
  Worst worst;
  for (int n = 0; n < 200; ++n) {
    double nu[3];
    random.fill(nu, 3, -2.0, 2.0);
    const double psi = random(-10.0, 10.0);
    double rate[3];
    body_to_earth(psi, nu, rate);
    // half-angle products keep away from the sine and cosine that the core takes
    const double t = std::tan(0.5 * psi);
    const double re = (1.0 - t * t) / (1.0 + t * t);
    const double im = 2.0 * t / (1.0 + t * t);
    worst.see(rate[0], re * nu[0] - im * nu[1]);
    worst.see(rate[1], im * nu[0] + re * nu[1]);
    worst.see(rate[2], nu[2]);
  }
  CHECK(worst.value() < 1e-13);
}

TEST_CASE("earth to body undoes body to earth") {
  Random random(2);
  Worst worst;
  for (int n = 0; n < 200; ++n) {
    double nu[3];
    random.fill(nu, 3, -2.0, 2.0);
    const double psi = random(-10.0, 10.0);
    double rate[3];
    double back[3];
    body_to_earth(psi, nu, rate);
    earth_to_body(psi, rate, back);
    for (int i = 0; i < 3; ++i) worst.see(back[i], nu[i]);
  }
  CHECK(worst.value() < 1e-15 * 4);
}

TEST_CASE("the earth-fixed rate turns by d eta_dot / d psi = z x eta_dot") {
  const Dual<1> psi = Dual<1>::variable(0.83, 0);
  const Dual<1> nu[3] = {0.4, -0.3, 0.2};
  Dual<1> rate[3];
  body_to_earth(psi, nu, rate);
  CHECK(rate[0][0] == doctest::Approx(-rate[1].value).epsilon(1e-14));
  CHECK(rate[1][0] == doctest::Approx(rate[0].value).epsilon(1e-14));
  CHECK(rate[2][0] == 0.0);
}

TEST_CASE("a wrapped angle is the same direction and lies in (-pi, pi]") {
  Random random(3);
  Worst worst;
  for (int n = 0; n < 500; ++n) {
    const double angle = random(-60.0, 60.0);
    const double wrapped = wrap(angle);
    REQUIRE(wrapped > -kPi);
    REQUIRE(wrapped <= kPi);
    worst.see(std::sin(wrapped), std::sin(angle));
    worst.see(std::cos(wrapped), std::cos(angle));
  }
  CHECK(worst.value() < 1e-13);
  CHECK(wrap(kPi) == kPi);
  CHECK(wrap(-kPi) == kPi);
  CHECK(wrap(0.25 - 6.0 * kPi) == doctest::Approx(0.25));
}
