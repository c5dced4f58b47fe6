// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include "boats.hpp"
#include "problem.hpp"

using namespace seatrial;
using boats::Worst;
using problems::driven;
using problems::Problem;
using problems::simulated;

namespace {

using Rollout = std::vector<double> (*)(const Problem&, std::vector<double>*);

/// Predictions of 15 steps from every fifth stamp, all from x0.
std::vector<double> predicted(const Problem& p, std::vector<double>* sensitivities) {
  const ThrustTrace trace = p.trace();
  std::vector<int> start;
  std::vector<int> stop;
  std::vector<double> x0;
  for (int i = 0; i + 15 < static_cast<int>(p.time.size()); i += 5) {
    start.push_back(i);
    stop.push_back(i + 15);
    x0.insert(x0.end(), p.x0.begin(), p.x0.end());
  }
  std::vector<double> out(x0.size());
  if (sensitivities != nullptr)
    sensitivities->resize(out.size() * static_cast<std::size_t>(p.columns.size()));
  predict(p.boat, trace, p.time.data(), start.data(), stop.data(), x0.data(),
          static_cast<int>(start.size()), 1, out.data(),
          sensitivities == nullptr ? nullptr : sensitivities->data());
  return out;
}

enum class Side { kCentral, kLeft };

/// Checks sensitivities against differences, relative to the column's largest, and the values with
/// them against those without; gives the largest difference of each column.
std::vector<double> check_sensitivities(Problem p, Rollout rollout, double most = 1e-6,
                                        double step = 1e-5, Side side = Side::kCentral) {
  std::vector<double> sensitivities;
  const auto with = rollout(p, &sensitivities);
  const auto without = rollout(p, nullptr);
  Worst value;
  for (std::size_t i = 0; i < with.size(); ++i) value.see(with[i], without[i]);
  CHECK(value.value() < 1e-12);
  Worst relative;
  std::vector<double> all;
  const auto width = static_cast<std::size_t>(p.columns.size());
  for (std::size_t c = 0; c < width; ++c) {
    double& parameter = p.parameter(static_cast<int>(c));
    const double nominal = parameter;
    const double above = side == Side::kCentral ? nominal + step : nominal;
    const double below = nominal - step;
    parameter = above;
    const auto up = rollout(p, nullptr);
    parameter = below;
    const auto down = rollout(p, nullptr);
    parameter = nominal;
    std::vector<double> want(up.size());
    double largest = 0.0;
    for (std::size_t i = 0; i < up.size(); ++i) {
      want[i] = (up[i] - down[i]) / (above - below);
      largest = std::max(largest, std::abs(want[i]));
    }
    // a column of zeros is compared absolutely
    const double scale = std::max(largest, 1e-3);
    for (std::size_t i = 0; i < want.size(); ++i)
      relative.see(sensitivities[i * width + c], want[i], scale);
    all.push_back(largest);
  }
  CHECK(relative.value() < most);
  return all;
}

/// A few commands on sixteenths of a second, where pose stamps and both latencies stand too.
Problem coincident(bool lag) {
  Problem p(boats::mallard(), boats::mallard_coefficients(),
            boats::full_chain(Scheme::kMoorePenrose, lag), boats::full_constants());
  p.q[boats::kLatencyA] = 0.125;
  p.q[boats::kLatencyB] = 0.125;
  p.boat.longest_step = 0.013;
  p.commands.add(0.0, {0.3, 0.1, 0.2});
  p.commands.add(0.5, {-0.7, 0.8, -0.1});
  p.commands.add(0.8125, {0.9, -0.4, 0.5});
  p.commands.add(1.25, {0.2, 0.3, -0.9});
  for (int i = 0; i < 30; ++i) p.time.push_back(i / 16.0);
  return p;
}

}  // namespace

TEST_CASE("sensitivities of simulate equal central differences, for every parameter there is") {
  for (const Scheme scheme : {Scheme::kMoorePenrose, Scheme::kAlwaysForward}) {
    const auto largest = check_sensitivities(
        driven(boats::mallard(), boats::mallard_coefficients(), scheme, true), simulated);
    // every parameter moves the boat, but the reverse ones under always forward
    for (std::size_t c = 0; c < largest.size(); ++c) {
      const int constant = static_cast<int>(c) - kStates - boats::kMallardSize;
      const bool idle = scheme == Scheme::kAlwaysForward &&
                        (constant == boats::kEdgeReverse || constant == boats::kReverseRatio);
      CAPTURE(c);
      CHECK((largest[c] > 1e-3) == !idle);
    }
  }
}

TEST_CASE("without a lag the latency's derivative comes from the moving breaks alone") {
  const auto largest = check_sensitivities(
      driven(boats::mallard(), boats::mallard_coefficients(), Scheme::kMoorePenrose, false),
      simulated);
  const std::size_t first = kStates + boats::kMallardSize;
  CHECK(largest[first + boats::kLatencyA] > 0.01);
  CHECK(largest[first + boats::kLatencyB] > 0.01);
  CHECK(largest[first + boats::kLag] == 0.0);
}

TEST_CASE("sensitivities of the rich boat equal central differences") {
  for (const bool lag : {true, false}) {
    check_sensitivities(
        driven(boats::rich(), boats::rich_coefficients(), Scheme::kMoorePenrose, lag), simulated);
  }
}

TEST_CASE("sensitivities of predict equal central differences") {
  for (const bool lag : {true, false}) {
    check_sensitivities(
        driven(boats::mallard(), boats::mallard_coefficients(), Scheme::kMoorePenrose, lag),
        predicted);
  }
}

TEST_CASE("sensitivities of the paper's Euler integrator equal central differences") {
  for (const Structure& s : {boats::mallard(), boats::rich()}) {
    const bool rich = s.n_coefficients == boats::kRichSize;
    Problem p = driven(s, rich ? boats::rich_coefficients() : boats::mallard_coefficients(),
                       Scheme::kMoorePenrose, true);
    p.boat.integrator = Integrator::kForwardEuler;
    for (const Rollout rollout : {simulated, predicted}) check_sensitivities(p, rollout);
  }
}

TEST_CASE("sensitivities of five direct actuators with a table equal central differences") {
  Problem p(boats::mallard(), boats::mallard_coefficients(), boats::direct_chain(),
            boats::direct_constants());
  p.commands = boats::random_script(61, 40, 5, 0.02, -1.0, 1.0);
  for (int i = 0; i < 70; ++i) p.time.push_back(0.0137 + i / 15.0);
  for (const double largest : check_sensitivities(p, simulated)) CHECK(largest > 1e-3);
}

TEST_CASE("sensitivities of a boat with a rudder and an azimuth thruster") {
  for (const Integrator integrator : {Integrator::kRungeKutta, Integrator::kForwardEuler}) {
    Problem p(boats::mallard(), boats::mallard_coefficients(), boats::steered_chain(),
              boats::steered_constants());
    p.boat.integrator = integrator;
    p.commands = boats::random_script(63, 40, 4, 0.4, -1.0, 1.0);
    for (int i = 0; i < 110; ++i) p.time.push_back(0.0137 + i / 5.0);
    for (const double largest : check_sensitivities(p, simulated)) CHECK(largest > 1e-3);
  }
}

TEST_CASE("sensitivities hold where latencies are negative and the groups overtake each other") {
  Problem p = driven(boats::mallard(), boats::mallard_coefficients(), Scheme::kMoorePenrose, true);
  p.q[boats::kLatencyA] = -0.2117;
  p.q[boats::kLatencyB] = 0.3319;
  check_sensitivities(p, simulated);
}

TEST_CASE("sensitivities hold where breaks fall on stamps and on each other, with a lag") {
  // the state is smooth in the latencies there, but only once: hence the small step
  check_sensitivities(coincident(true), simulated, 1e-5, 1e-7);
  check_sensitivities(coincident(true), predicted, 1e-5, 1e-7);
}

TEST_CASE("sensitivities hold where two latencies are equal, without a lag") {
  Problem p = coincident(false);
  for (double& t : p.time) t += 0.0211;
  check_sensitivities(p, simulated, 1e-5, 1e-6);
}

TEST_CASE("where a jump falls on a stamp the latency's derivative is the one from the left") {
  check_sensitivities(coincident(false), simulated, 1e-5, 1e-7, Side::kLeft);
}
