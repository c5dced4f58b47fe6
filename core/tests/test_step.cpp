// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include "boats.hpp"
#include "seatrial/integration/step.hpp"

using namespace seatrial;
using boats::add;

namespace {

/// u_dot = coefficient u + F_u.
Structure linear_drag() {
  Structure s;
  s.n_forces = 1;
  add(s, 0, 0, 1.0, {kU});
  add(s, 0, -1, 1.0, {boats::kFu});
  return s;
}

/// It makes F_u.
Chain one_thruster() {
  Chain c;
  c.allocation.n_actuators = 1;
  c.allocation.n_commands = 1;
  c.n_forces = 1;
  c.mix[0][0] = 1.0;
  return c;
}

/// v r and -u r alone: no force in the earth-fixed frame.
Structure free_body() {
  Structure s;
  add(s, 0, -1, 1.0, {kV, kR});
  add(s, 1, -1, -1.0, {kU, kR});
  return s;
}

/// The mallard after 1 s of n steps at a constant force, where no speed changes its sign.
void mallard_after(int n, bool euler, double* x) {
  const auto c = boats::mallard_coefficients();
  const double start[kStates] = {0.0, 0.0, 0.3, 0.4, 0.3, 0.5};
  const double force[3][kMaxForces] = {{0.8, 0.5, 0.6}, {0.8, 0.5, 0.6}, {0.8, 0.5, 0.6}};
  std::copy(start, start + kStates, x);
  for (int i = 0; i < n; ++i) {
    const double h = 1.0 / n;
    REQUIRE((euler ? euler_step(boats::mallard(), c.data(), h, force[0], x)
                   : runge_kutta_step(boats::mallard(), c.data(), h, force, x)));
  }
}

double error_of(int n, bool euler) {
  double x[kStates];
  double best[kStates];
  mallard_after(n, euler, x);
  mallard_after(2000, false, best);
  double error = 0.0;
  for (int i = 0; i < kStates; ++i) error = std::max(error, std::abs(x[i] - best[i]));
  return error;
}

}  // namespace

TEST_CASE("the state's rate is the rotated velocity and Eq. (12)") {
  const auto c = boats::mallard_coefficients();
  const double x[kStates] = {3.0, 4.0, 0.5 * kPi, 0.4, -0.3, 0.5};
  const double force[kMaxForces] = {0.1, 0.2, 0.3};
  double rate[kStates];
  double want[3];
  REQUIRE(state_rate(boats::mallard(), c.data(), x, force, rate));
  boats::mallard_by_hand(c.data(), x + 3, force, want);
  CHECK(rate[0] == doctest::Approx(0.3));
  CHECK(rate[1] == doctest::Approx(0.4));
  CHECK(rate[2] == 0.5);
  for (int i = 0; i < 3; ++i) CHECK(rate[3 + i] == doctest::Approx(want[i]).epsilon(1e-14));
}

TEST_CASE("one Euler step is the paper's: x + h x_dot") {
  const auto c = boats::mallard_coefficients();
  double x[kStates] = {0.1, -0.2, 0.7, 0.4, -0.3, 0.5};
  const double force[kMaxForces] = {0.1, 0.2, 0.3};
  double nu_dot[3];
  boats::mallard_by_hand(c.data(), x + 3, force, nu_dot);
  const double h = 1.0 / 15.0;
  const double want[kStates] = {0.1 + h * (0.4 * std::cos(0.7) + 0.3 * std::sin(0.7)),
                                -0.2 + h * (0.4 * std::sin(0.7) - 0.3 * std::cos(0.7)),
                                0.7 + h * 0.5,
                                0.4 + h * nu_dot[0],
                                -0.3 + h * nu_dot[1],
                                0.5 + h * nu_dot[2]};
  REQUIRE(euler_step(boats::mallard(), c.data(), h, force, x));
  for (int i = 0; i < kStates; ++i) CHECK(x[i] == doctest::Approx(want[i]).epsilon(1e-14));
}

TEST_CASE("Runge-Kutta is of fourth order and Euler of first") {
  CHECK(error_of(8, false) / error_of(16, false) == doctest::Approx(16.0).epsilon(0.1));
  CHECK(error_of(16, false) / error_of(32, false) == doctest::Approx(16.0).epsilon(0.05));
  CHECK(error_of(16, false) > 1e-10);  // far above rounding, so that the ratios mean something
  CHECK(error_of(64, true) / error_of(128, true) == doctest::Approx(2.0).epsilon(0.05));
}

TEST_CASE("a Runge-Kutta step of linear drag is the Taylor polynomial of the exponential") {
  const double coefficient = -0.7;
  const double force[3][kMaxForces] = {};
  const double h = 0.5;
  const double z = coefficient * h;
  double x[kStates] = {0.0, 0.0, 0.0, 2.0, 0.0, 0.0};
  REQUIRE(runge_kutta_step(linear_drag(), &coefficient, h, force, x));
  const double polynomial = 1.0 + z * (1.0 + z / 2.0 * (1.0 + z / 3.0 * (1.0 + z / 4.0)));
  CHECK(x[3] == doctest::Approx(2.0 * polynomial).epsilon(1e-15));
}

TEST_CASE("linear drag decays as an exponential, and the way made is its integral") {
  const double coefficient = -0.7;
  Chain none;
  none.n_forces = 1;
  Thrust f;
  double x[kStates] = {0.0, 0.0, 0.0, 2.0, 0.0, 0.0};
  REQUIRE(advance(linear_drag(), &coefficient, none, nullptr, 3.0, 1.0 / 60.0, f, x));
  const double left = std::exp(-2.1);
  CHECK(x[3] == doctest::Approx(2.0 * left).epsilon(1e-10));
  CHECK(x[0] == doctest::Approx(2.0 * (1.0 - left) / 0.7).epsilon(1e-10));
}

TEST_CASE("a body without forces keeps its speed and goes straight while it turns") {
  const Chain none;
  Thrust f;
  double x[kStates] = {1.0, 2.0, 0.4, 0.5, -0.3, 1.6};
  double velocity[3];
  body_to_earth(x[2], x + 3, velocity);
  REQUIRE(advance(free_body(), nullptr, none, nullptr, 10.0, 1.0 / 200.0, f, x));
  CHECK(std::hypot(x[3], x[4]) == doctest::Approx(std::hypot(0.5, 0.3)).epsilon(1e-10));
  CHECK(x[2] == doctest::Approx(0.4 + 16.0).epsilon(1e-13));
  CHECK(x[5] == 1.6);
  CHECK(x[0] == doctest::Approx(1.0 + 10.0 * velocity[0]).epsilon(1e-9));
  CHECK(x[1] == doctest::Approx(2.0 + 10.0 * velocity[1]).epsilon(1e-9));
}

TEST_CASE("thrust behind a lag drives a linear boat along the closed form") {
  // u_dot = -a u + b (1 - exp(-t / lag))
  const double a = 0.7;
  const double b = 0.9;
  const double lag = 0.3;
  Chain c = one_thruster();
  c.n_constants = 1;
  c.actuators[0].lag = 0;
  Thrust f;
  f.target[0] = b;
  f.multiplier[0] = 1.0;
  double x[kStates] = {0.0};
  const double coefficient = -a;
  REQUIRE(advance(linear_drag(), &coefficient, c, &lag, 1.0, 0.01, f, x));
  CHECK(f.level[0] == doctest::Approx(b * (1.0 - std::exp(-1.0 / lag))).epsilon(1e-13));
  const double rate = a - 1.0 / lag;
  const double want = b / a - b * std::exp(-1.0 / lag) / rate + (b / rate - b / a) * std::exp(-a);
  CHECK(x[3] == doctest::Approx(want).epsilon(1e-8));
}

TEST_CASE("without a lag the thrust is at its target from the interval's begin") {
  const Chain c = one_thruster();
  Thrust f;
  f.level[0] = -5.0;  // where it was before
  f.target[0] = 0.5;
  f.multiplier[0] = 2.0;
  const double coefficient = 0.0;
  double x[kStates] = {0.0};
  REQUIRE(advance(linear_drag(), &coefficient, c, nullptr, 3.0, 0.01, f, x));
  CHECK(x[3] == doctest::Approx(3.0).epsilon(1e-13));
  CHECK(x[0] == doctest::Approx(4.5).epsilon(1e-13));
}

TEST_CASE("an interval is cut into the fewest equal steps that are short enough") {
  CHECK(steps_for(1.0, 0.3) == 4);
  CHECK(steps_for(0.9, 0.3) == 3);  // although 0.9 / 0.3 is a little over 3
  CHECK(steps_for(0.01, 0.3) == 1);
  CHECK(steps_for(0.0, 0.3) == 1);
  CHECK(steps_for(0.300001, 0.3) == 2);
}

TEST_CASE("an interval without length changes nothing") {
  const double coefficient = -0.7;
  double x[kStates] = {1.0, 2.0, 3.0, 4.0, 5.0, 6.0};
  Thrust f;
  f.level[0] = 0.25;
  f.target[0] = 1.0;
  REQUIRE(advance(linear_drag(), &coefficient, Chain{}, nullptr, 0.0, 0.1, f, x));
  for (int i = 0; i < kStates; ++i) CHECK(x[i] == i + 1.0);
  CHECK(f.level[0] == 0.25);
}

TEST_CASE("a boat that runs away is reported") {
  const double coefficient = 40.0;  // drag of the wrong sign
  double x[kStates] = {0.0, 0.0, 0.0, 1.0, 0.0, 0.0};
  Chain none;
  none.n_forces = 1;
  const double no_constants[kMaxConstants] = {};
  Thrust f;
  CHECK_FALSE(advance(linear_drag(), &coefficient, none, no_constants, 1.0, 0.01, f, x));
  double lost[kStates] = {0.0, 0.0, std::nan(""), 0.0, 0.0, 0.0};
  CHECK_FALSE(advance(linear_drag(), &coefficient, none, no_constants, 0.1, 0.01, f, lost));
}
