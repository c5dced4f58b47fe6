// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include "boats.hpp"
#include "chain_by_hand.hpp"
#include "problem.hpp"

using namespace seatrial;
using boats::Random;
using boats::Worst;
using problems::driven;
using problems::Problem;
using problems::simulated;

namespace {

/// Eq. (12) and the chain written out by hand, classical Runge-Kutta at a grid of 1 ms.
std::vector<double> mallard_in_fine_steps(const Problem& p, double end) {
  const double* c = p.boat.coefficient;
  const auto rate = [&](const std::vector<double>& x, double t) {
    double force[3];
    double nu_dot[3];
    boats::forces_by_hand(p.chain, p.q, p.commands, p.scales, t, force);
    boats::mallard_by_hand(c, x.data() + 3, force, nu_dot);
    return std::vector<double>{std::cos(x[2]) * x[3] - std::sin(x[2]) * x[4],
                               std::sin(x[2]) * x[3] + std::cos(x[2]) * x[4],
                               x[5],
                               nu_dot[0],
                               nu_dot[1],
                               nu_dot[2]};
  };
  const auto moved = [](std::vector<double> x, double h, const std::vector<double>& k) {
    for (std::size_t i = 0; i < x.size(); ++i) x[i] += h * k[i];
    return x;
  };
  std::vector<double> x = p.x0;
  const double h = 1e-3;
  const int n = static_cast<int>(std::lround(end / h));
  for (int i = 0; i < n; ++i) {
    const double t = i * h;
    const auto k1 = rate(x, t);
    const auto k2 = rate(moved(x, 0.5 * h, k1), t + 0.5 * h);
    const auto k3 = rate(moved(x, 0.5 * h, k2), t + 0.5 * h);
    const auto k4 = rate(moved(x, h, k3), t + h);
    for (std::size_t s = 0; s < 6; ++s)
      x[s] += h / 6.0 * (k1[s] + 2.0 * k2[s] + 2.0 * k3[s] + k4[s]);
  }
  return x;
}

}  // namespace

TEST_CASE("a simulation agrees with Eq. (12) integrated by hand in fine steps") {
  Problem p(boats::mallard(), boats::mallard_coefficients(),
            boats::full_chain(Scheme::kAlwaysForward), boats::full_constants());
  p.q[boats::kLatencyA] = 0.083;  // on the fine grid
  p.q[boats::kLatencyB] = 0.127;
  p.boat.longest_step = 1.0 / 200.0;
  p.commands.add(0.0, {0.0, 0.0, 0.0});
  p.commands.add(0.2, {0.9, 0.1, -0.4});
  p.commands.add(0.71, {-0.5, 0.8, 0.3});
  p.commands.add(1.3, {-0.5, -0.8, 0.9});
  p.time = {0.0, 0.4, 1.1, 2.0};
  const auto got = simulated(p, nullptr);
  const auto want = mallard_in_fine_steps(p, 2.0);
  Worst worst;
  for (std::size_t i = 0; i < 6; ++i) worst.see(got[18 + i], want[i]);
  CHECK(worst.value() < 2e-7);
}

TEST_CASE("a simulation may be stopped and taken up anywhere, at a break or between") {
  Problem p = driven(boats::mallard(), boats::mallard_coefficients(), Scheme::kMoorePenrose, true);
  p.boat.longest_step = 1.0 / 500.0;
  const ThrustTrace trace = p.trace();
  const double end = 5.0;
  const double whole_time[2] = {0.0, end};
  double whole[2 * kStates];
  REQUIRE(simulate(p.boat, trace, p.x0.data(), whole_time, 2, whole, nullptr) == 2);
  Random random(62);
  Worst worst;
  for (int n = 0; n < 30; ++n) {
    const double t1 = n % 2 == 0 ? trace.time(1 + n) : random(0.0, end);
    REQUIRE(t1 < end);
    const double first_time[2] = {0.0, t1};
    const double second_time[2] = {t1, end};
    double first[2 * kStates] = {};
    double second[2 * kStates] = {};
    REQUIRE(simulate(p.boat, trace, p.x0.data(), first_time, 2, first, nullptr) == 2);
    REQUIRE(simulate(p.boat, trace, first + kStates, second_time, 2, second, nullptr) == 2);
    for (int i = 0; i < kStates; ++i) worst.see(second[kStates + i], whole[kStates + i]);
  }
  CHECK(worst.value() < 1e-9);
}

TEST_CASE("a prediction is a simulation from its own start") {
  const Problem p =
      driven(boats::mallard(), boats::mallard_coefficients(), Scheme::kAlwaysForward, true);
  const ThrustTrace trace = p.trace();
  const int start[2] = {7, 40};
  std::vector<double> x0(p.x0);
  x0.insert(x0.end(), {1.0, 2.0, -0.4, 0.1, 0.2, -0.3});
  double got[2 * kStates];
  const int stop[2] = {27, 60};
  predict(p.boat, trace, p.time.data(), start, stop, x0.data(), 2, 1, got, nullptr);
  for (int j = 0; j < 2; ++j) {
    double rows[21 * kStates];
    REQUIRE(simulate(p.boat, trace, x0.data() + static_cast<std::ptrdiff_t>(j) * kStates,
                     p.time.data() + start[j], 21, rows, nullptr) == 21);
    for (int i = 0; i < kStates; ++i) CHECK(got[j * kStates + i] == rows[20 * kStates + i]);
  }
}

TEST_CASE("one thread and more predict the same bits") {
  Problem p = driven(boats::mallard(), boats::mallard_coefficients(), Scheme::kMoorePenrose, true);
  const ThrustTrace trace = p.trace();
  Random random(63);
  const int m = 300;
  std::vector<int> start(m);
  std::vector<double> x0(start.size() * kStates);
  std::vector<int> stop(m);
  for (std::size_t j = 0; j < start.size(); ++j) {
    start[j] = static_cast<int>(random(0.0, 89.0));
    stop[j] = start[j] + static_cast<int>(random(1.0, 15.0));  // some beyond the next one's start
  }
  random.fill(x0.data(), m * kStates, -0.5, 0.5);
  const auto width = static_cast<std::size_t>(p.columns.size());
  std::vector<double> one(x0.size());
  std::vector<double> one_sensitivities(x0.size() * width);
  predict(p.boat, trace, p.time.data(), start.data(), stop.data(), x0.data(), m, 1, one.data(),
          one_sensitivities.data());
  for (const int threads : {2, 3, 4}) {
    std::vector<double> more(x0.size(), std::nan(""));
    std::vector<double> more_sensitivities(one_sensitivities.size(), std::nan(""));
    predict(p.boat, trace, p.time.data(), start.data(), stop.data(), x0.data(), m, threads,
            more.data(), more_sensitivities.data());
    CHECK(more == one);
    CHECK(more_sensitivities == one_sensitivities);
  }
}

TEST_CASE("rows at equal stamps are equal") {
  Problem p = driven(boats::mallard(), boats::mallard_coefficients(), Scheme::kMoorePenrose, true);
  p.time = {0.0, 0.5, 0.5, 1.0};
  for (const bool euler : {false, true}) {
    p.boat.integrator = euler ? Integrator::kForwardEuler : Integrator::kRungeKutta;
    std::vector<double> sensitivities;
    const auto out = simulated(p, &sensitivities);
    for (std::size_t i = 0; i < 6; ++i) CHECK(out[6 + i] == out[12 + i]);
    CHECK(out[6] != out[0]);
    const auto width = 6 * static_cast<std::size_t>(p.columns.size());
    for (std::size_t i = 0; i < width; ++i)
      CHECK(sensitivities[width + i] == sensitivities[2 * width + i]);
  }
}

TEST_CASE("a boat that runs away ends in rows of NaN, sensitivities too, and is counted so") {
  Problem p = driven(boats::mallard(), boats::mallard_coefficients(), Scheme::kMoorePenrose, true);
  p.boat.coefficient[boats::kXuu] = 40.0;  // quadratic drag of the wrong sign
  p.boat.coefficient[boats::kXu] = 5.0;
  p.x0[3] = 0.5;
  const ThrustTrace trace = p.trace();
  const int n = static_cast<int>(p.time.size());
  const auto width = static_cast<std::size_t>(p.columns.size());
  for (const bool euler : {false, true}) {
    p.boat.integrator = euler ? Integrator::kForwardEuler : Integrator::kRungeKutta;
    std::vector<double> plain(p.time.size() * kStates);
    std::vector<double> with(plain.size());
    std::vector<double> sensitivities(plain.size() * width);
    const int reached =
        simulate(p.boat, trace, p.x0.data(), p.time.data(), n, plain.data(), nullptr);
    CHECK(reached > 0);
    CHECK(reached < n);
    CHECK(simulate(p.boat, trace, p.x0.data(), p.time.data(), n, with.data(),
                   sensitivities.data()) == reached);
    for (int i = 0; i < n * kStates; ++i) {
      const bool good = i < reached * kStates;
      REQUIRE(std::isfinite(plain[static_cast<std::size_t>(i)]) == good);
      REQUIRE(std::isfinite(with[static_cast<std::size_t>(i)]) == good);
      for (std::size_t c = 0; c < width && !good; ++c) {
        REQUIRE(std::isnan(sensitivities[static_cast<std::size_t>(i) * width + c]));
      }
    }
    const int start[1] = {0};
    const int stop[1] = {60};
    double out[kStates];
    std::vector<double> slopes(kStates * width);
    predict(p.boat, trace, p.time.data(), start, stop, p.x0.data(), 1, 1, out, nullptr);
    for (const double value : out) CHECK(std::isnan(value));
    std::fill(out, out + kStates, 0.0);
    predict(p.boat, trace, p.time.data(), start, stop, p.x0.data(), 1, 1, out, slopes.data());
    for (const double value : out) CHECK(std::isnan(value));
    for (const double value : slopes) CHECK(std::isnan(value));
  }
}

TEST_CASE("a boat whose accelerations hold each other up stops at its first row") {
  Structure s = boats::mallard();
  boats::add(s, 0, -1, 1.0, {}, 2);  // u_dot = ... + r_dot, and r_dot = ... + N_ud u_dot
  auto c = boats::mallard_coefficients();
  c[boats::kNud] = 1.0;
  Problem p = driven(s, c, Scheme::kMoorePenrose, true);
  const ThrustTrace trace = p.trace();
  std::vector<double> out(p.time.size() * kStates);
  std::vector<double> sensitivities(out.size() * static_cast<std::size_t>(p.columns.size()));
  const int n = static_cast<int>(p.time.size());
  for (const bool euler : {false, true}) {
    p.boat.integrator = euler ? Integrator::kForwardEuler : Integrator::kRungeKutta;
    for (double* slopes : {static_cast<double*>(nullptr), sensitivities.data()}) {
      CHECK(simulate(p.boat, trace, p.x0.data(), p.time.data(), n, out.data(), slopes) == 1);
      CHECK(out[3] == p.x0[3]);
      CHECK(std::isnan(out[6]));
      CHECK(std::isnan(out.back()));
    }
  }
}
