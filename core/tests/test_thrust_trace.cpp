// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include "boats.hpp"
#include "chain_by_hand.hpp"
#include "seatrial/integration/thrust_trace.hpp"

using namespace seatrial;
using boats::Random;
using boats::Script;
using boats::Worst;

namespace {

const Columns kNone;

double output_at(const ThrustTrace& trace, int k, double t) {
  Thrust f;
  trace.at(trace.find(t), t, f);
  return f.multiplier[k] * f.level[k];
}

/// Largest deviation of the trace's outputs from the sum of step responses at random times.
double worst_output(const Chain& c, const std::vector<double>& q, const Script& commands,
                    const Script& scales) {
  const ThrustTrace trace(c, q.data(), commands.held(), scales.held(), kNone);
  Random random(50);
  Worst worst;
  for (int n = 0; n < 400; ++n) {
    const double t = random(commands.time.front() - 1.0, commands.time.back() + 1.0);
    for (int k = 0; k < c.n_actuators(); ++k) {
      worst.see(output_at(trace, k, t), boats::output_by_hand(c, q, commands, scales, k, t));
    }
  }
  return worst.value();
}

Script battery() {
  Script s;
  s.add(0.4, {13.1});
  s.add(2.13, {12.7});
  s.add(2.9, {12.7});
  s.add(4.4, {11.8});
  return s;
}

}  // namespace

TEST_CASE("thrust along a recording is the sum of its step responses, for both allocations") {
  const Script commands = boats::random_script(51, 40, 3, 0.3, -1.0, 1.0);
  for (const Scheme scheme : {Scheme::kMoorePenrose, Scheme::kAlwaysForward}) {
    for (const bool lag : {true, false}) {
      CHECK(worst_output(boats::full_chain(scheme, lag), boats::full_constants(), commands,
                         battery()) < 1e-13);
    }
  }
}

TEST_CASE("thrust with a negative latency comes before its command") {
  auto q = boats::full_constants();
  q[boats::kLatencyA] = -0.21;
  const Script commands = boats::random_script(52, 30, 3, 0.3, -1.0, 1.0);
  const Chain c = boats::full_chain(Scheme::kMoorePenrose, false);
  CHECK(worst_output(c, q, commands, battery()) < 1e-13);

  Script step;
  step.add(0.0, {0.0, 0.0, 0.0});
  step.add(1.0, {1.0, 0.0, 0.0});
  const ThrustTrace trace(c, q.data(), step.held(), Held{}, kNone);
  CHECK(output_at(trace, 2, 0.78) == 0.0);
  CHECK(output_at(trace, 2, 0.80) > 0.3);  // thruster 3: group A, 0.21 s early
  CHECK(output_at(trace, 3, 1.12) == 0.0);
  CHECK(output_at(trace, 3, 1.13) > 0.3);  // thruster 4: group B, 0.1273 s late
}

TEST_CASE("thrust agrees with a simulation in fine steps") {
  // trapezoidal rule at 0.1 ms; commands and latencies stand on its grid
  const Chain c = boats::full_chain(Scheme::kMoorePenrose);
  auto q = boats::full_constants();
  q[boats::kLatencyA] = 0.083;
  q[boats::kLatencyB] = 0.127;
  Script commands;
  commands.add(0.0, {0.4, 0.0, 0.0});
  commands.add(0.1, {0.4, -0.6, 0.3});
  commands.add(0.35, {-0.8, -0.6, 0.3});
  commands.add(0.36, {-0.8, 0.9, 0.0});
  commands.add(0.9, {0.0, 0.0, -0.2});
  const ThrustTrace trace(c, q.data(), commands.held(), Held{}, kNone);
  Worst worst;
  for (int k = 0; k < 4; ++k) {
    const double latency = q[k % 2 == 0 ? boats::kLatencyA : boats::kLatencyB];
    double thruster[kMaxActuators];
    allocate(c.allocation, commands.row(0), thruster);
    double level = boats::curve_by_hand(c, q, k, thruster[k]);
    const double h = 1e-4;
    for (int i = 0; i < 13000; ++i) {
      if (i % 97 == 0) worst.see(output_at(trace, k, i * h), level);
      allocate(c.allocation, commands.holding((i + 0.5) * h - latency), thruster);
      const double target = boats::curve_by_hand(c, q, k, thruster[k]);
      const double z = 0.5 * h / q[boats::kLag];
      level = ((1.0 - z) * level + 2.0 * z * target) / (1.0 + z);
    }
  }
  CHECK(worst.value() < 1e-6);
}

TEST_CASE("five direct actuators with a table, limits and latency for two of them") {
  const Script commands = boats::random_script(53, 40, 5, 0.0, -1.0, 1.0);
  const Chain c = boats::direct_chain();
  const auto q = boats::direct_constants();
  const ThrustTrace trace(c, q.data(), commands.held(), Held{}, kNone);
  // breaks where the table has its corners in time: at the commands, plus those of the latency
  int changes = 0;
  for (int i = 1; i < commands.size(); ++i) {
    changes += std::equal(commands.row(i), commands.row(i) + 5, commands.row(i - 1)) ? 0 : 1;
  }
  CHECK(trace.breaks() == 1 + 2 * changes);
  Random random(54);
  Worst worst;
  for (int n = 0; n < 200; ++n) {
    const double t = random(-1.0, 8.0);
    for (const int k : {0, 1, 2, 4}) {
      worst.see(output_at(trace, k, t), boats::output_by_hand(c, q, commands, Script{}, k, t));
    }
  }
  CHECK(worst.value() < 1e-13);
}

TEST_CASE(
    "of a pair each component has its own latency, and its partner's command is of the same row") {
  const Script commands = boats::random_script(64, 60, 4, 0.3, -1.2, 1.2);
  CHECK(worst_output(boats::paired_chain(), boats::paired_constants(), commands, Script{}) < 1e-13);
}

TEST_CASE("a command that repeats the last one makes no break") {
  const Chain c = boats::full_chain(Scheme::kMoorePenrose);
  const auto q = boats::full_constants();
  Script s;
  for (int i = 0; i < 100; ++i) s.add(0.01 * i, {i < 40 ? 0.0 : 0.5, 0.0, 0.0});
  const ThrustTrace trace(c, q.data(), s.held(), Held{}, kNone);
  CHECK(trace.breaks() == 3);  // for ever, and one change for two latencies
  CHECK(trace.time(0) == -std::numeric_limits<double>::infinity());
  CHECK(trace.time(1) == doctest::Approx(0.4831).epsilon(1e-14));
  CHECK(trace.time(2) == doctest::Approx(0.5273).epsilon(1e-14));
  Script volts;
  for (int i = 0; i < 50; ++i) volts.add(0.02 * i, {i < 30 ? 12.0 : 11.0});
  CHECK(ThrustTrace(c, q.data(), s.held(), volts.held(), kNone).breaks() == 4);
}

TEST_CASE("a change of scale acts at once on all thrusters, whatever the latency and the lag") {
  const Chain c = boats::full_chain(Scheme::kAlwaysForward);
  const auto q = boats::full_constants();
  Script s;
  s.add(0.0, {0.3, 0.2, 0.1});
  Script volts;
  volts.add(0.0, {12.0});
  volts.add(1.0, {14.4});
  const ThrustTrace trace(c, q.data(), s.held(), volts.held(), kNone);
  CHECK(trace.breaks() == 2);
  for (int k = 0; k < 4; ++k) {
    const double ratio = output_at(trace, k, 1.0) / output_at(trace, k, 0.999);
    CHECK(ratio == doctest::Approx(std::pow(1.2, 1.7)).epsilon(1e-14));
  }
}

TEST_CASE("the first rows have held for ever") {
  const Chain c = boats::full_chain(Scheme::kAlwaysForward);
  const auto q = boats::full_constants();
  const Script commands = boats::random_script(55, 5, 3, 10.0, -1.0, 1.0);
  Script volts;
  volts.add(20.0, {13.0});
  const ThrustTrace trace(c, q.data(), commands.held(), volts.held(), kNone);
  double thruster[kMaxActuators];
  allocate(c.allocation, commands.row(0), thruster);
  for (int k = 0; k < 4; ++k) {
    const double want = boats::curve_by_hand(c, q, k, thruster[k]) * std::pow(13.0 / 12.0, 1.7);
    CHECK(output_at(trace, k, -1e6) == doctest::Approx(want).epsilon(1e-14));
    CHECK(output_at(trace, k, 10.0) == doctest::Approx(want).epsilon(1e-14));
  }
}

TEST_CASE("without scale signals the multiplier is that of the reference: 1") {
  const Chain c = boats::full_chain(Scheme::kMoorePenrose);
  const auto q = boats::full_constants();
  const Script commands = boats::random_script(56, 5, 3, 0.0, -1.0, 1.0);
  const ThrustTrace trace(c, q.data(), commands.held(), Held{}, kNone);
  Thrust f;
  trace.at(2, trace.time(2), f);
  for (int k = 0; k < 4; ++k) CHECK(f.multiplier[k] == 1.0);
}

TEST_CASE("find gives the last break that is not after t") {
  const Chain c = boats::full_chain(Scheme::kMoorePenrose);
  const auto q = boats::full_constants();
  const Script commands = boats::random_script(57, 20, 3, 0.0, -1.0, 1.0);
  const ThrustTrace trace(c, q.data(), commands.held(), battery().held(), kNone);
  CHECK(trace.find(-1e9) == 0);
  CHECK(trace.find(1e9) == trace.breaks() - 1);
  for (int i = 1; i < trace.breaks(); ++i) {
    REQUIRE(trace.time(i) > trace.time(i - 1));
    CHECK(trace.find(trace.time(i)) == i);
    CHECK(trace.find(std::nextafter(trace.time(i), -1e9)) == i - 1);
  }
}

TEST_CASE("derivatives of level, target and multiplier equal central differences") {
  for (const int kind : {0, 1, 2}) {
    const Chain c =
        kind == 2 ? boats::paired_chain() : boats::full_chain(Scheme::kMoorePenrose, kind == 0);
    const auto q = kind == 2 ? boats::paired_constants() : boats::full_constants();
    const int width = c.allocation.n_commands;
    const Script commands = boats::random_script(58, 30, width, 0.0, -1.0, 1.0);
    const Columns columns = boats::all_columns(boats::mallard(), c);
    const Script volts = kind == 2 ? Script{} : battery();
    const ThrustTrace trace(c, q.data(), commands.held(), volts.held(), columns);
    Random random(59);
    Worst worst;
    for (int n = 0; n < 40; ++n) {
      const double t = random(-0.5, 6.0);
      Thrust f;
      ThrustSensitivities df;
      trace.at(trace.find(t), t, nullptr, f, df);
      for (int i = 0; i < c.n_constants; ++i) {
        auto up = q;
        auto down = q;
        up[static_cast<std::size_t>(i)] += 1e-6;
        down[static_cast<std::size_t>(i)] -= 1e-6;
        const ThrustTrace above(c, up.data(), commands.held(), volts.held(), columns);
        const ThrustTrace below(c, down.data(), commands.held(), volts.held(), columns);
        Thrust a;
        Thrust b;
        above.at(above.find(t), t, a);
        below.at(below.find(t), t, b);
        for (int k = 0; k < 4; ++k) {
          worst.see(df.level[k][i], (a.level[k] - b.level[k]) / 2e-6);
          worst.see(df.target[k][i], (a.target[k] - b.target[k]) / 2e-6);
          worst.see(df.multiplier[k][i], (a.multiplier[k] - b.multiplier[k]) / 2e-6);
        }
      }
    }
    CHECK(worst.value() < 1e-7);
  }
}
