// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <memory>

#include "boats.hpp"
#include "chain_by_hand.hpp"
#include "heap.hpp"
#include "seatrial/integration/rollout.hpp"
#include "seatrial/simulation/plant.hpp"

using namespace seatrial;
using boats::Script;
using boats::Worst;

namespace {

/// A plant, and the same boat and chain as a recording sees them.
struct Twin {
  Boat boat;
  Chain chain;
  std::vector<double> q;
  std::unique_ptr<Plant> plant;

  explicit Twin(const Chain& c = boats::full_chain(Scheme::kMoorePenrose),
                std::vector<double> constants = boats::full_constants())
      : chain(c), q(std::move(constants)) {
    boat.structure = boats::mallard();
    const auto coefficients = boats::mallard_coefficients();
    std::copy(coefficients.begin(), coefficients.end(), boat.coefficient);
    boat.longest_step = 1e-3;
    plant = std::make_unique<Plant>(boat.structure, boat.coefficient, chain, q.data(),
                                    boat.longest_step);
  }
};

/// Drives the plant along the script, looking at it at the stamps; compares with simulate().
double worst_against_recording(Twin& twin, const Script& script, const std::vector<double>& time) {
  const ThrustTrace trace(twin.chain, twin.q.data(), script.held(), Held{}, Columns{});
  const int n = static_cast<int>(time.size());
  std::vector<double> want(time.size() * kStates);
  const double x0[kStates] = {0.0};
  REQUIRE(simulate(twin.boat, trace, x0, time.data(), n, want.data(), nullptr) == n);

  Plant& plant = *twin.plant;
  plant.reset(time[0], script.row(0));
  Worst worst;
  int next = 1;
  for (int i = 0; i < n; ++i) {
    const double t = time[static_cast<std::size_t>(i)];
    while (next < script.size() && script.time[static_cast<std::size_t>(next)] <= t) {
      const double at = script.time[static_cast<std::size_t>(next)];
      REQUIRE(plant.advance_to(at));
      REQUIRE(plant.command(at, script.row(next)));
      ++next;
    }
    REQUIRE(plant.advance_to(t));
    REQUIRE(plant.time() == t);
    double force[3];
    double expected[3];
    plant.forces(force);
    boats::forces_by_hand(twin.chain, twin.q, script, Script{1, {0.0}, {12.0}}, t, expected);
    for (int j = 0; j < 3; ++j) worst.see(force[j], expected[j]);
    for (int k = 0; k < kStates; ++k) {
      worst.see(plant.state()[k], want[static_cast<std::size_t>(i * kStates + k)]);
    }
  }
  CHECK(next == script.size());
  CHECK(std::abs(plant.state()[0]) + std::abs(plant.state()[1]) > 1e-3);
  return worst.value();
}

std::vector<double> stamps(int n) {
  std::vector<double> time;
  time.reserve(static_cast<std::size_t>(n));
  for (int i = 0; i < n; ++i) time.push_back(0.0137 + i / 15.0);
  return time;
}

}  // namespace

TEST_CASE("a plant that is driven live moves as one that replays its commands") {
  const Script script = boats::random_script(70, 40, 3, 0.0, -1.0, 1.0);
  for (const Scheme scheme : {Scheme::kMoorePenrose, Scheme::kAlwaysForward}) {
    for (const bool lag : {true, false}) {
      Twin twin(boats::full_chain(scheme, lag), boats::full_constants());
      CHECK(worst_against_recording(twin, script, stamps(110)) < 1e-9);
    }
  }
}

TEST_CASE("a plant with pairs of commands moves as one that replays them") {
  const Script script = boats::random_script(74, 40, 4, 0.0, -1.2, 1.2);
  Twin twin(boats::paired_chain(), boats::paired_constants());
  CHECK(worst_against_recording(twin, script, stamps(110)) < 1e-9);
}

TEST_CASE("a plant without any stage follows its commands at once") {
  const Script script = boats::random_script(71, 20, 3, 0.0, -1.0, 1.0);
  Twin twin(boats::plain_chain(Scheme::kMoorePenrose), {});
  CHECK(worst_against_recording(twin, script, stamps(70)) < 1e-9);
}

TEST_CASE("a plant with commands far ahead of their arrival keeps them in order") {
  auto q = boats::full_constants();
  q[boats::kLatencyA] = 1.1;  // several commands are under way at once
  q[boats::kLatencyB] = 0.02;
  const Script script = boats::random_script(72, 40, 3, 0.0, -1.0, 1.0);
  Twin twin(boats::full_chain(Scheme::kMoorePenrose), q);
  CHECK(worst_against_recording(twin, script, stamps(120)) < 1e-9);
}

TEST_CASE("a queue of commands wraps around without a slip") {
  auto q = boats::full_constants();
  q[boats::kLatencyA] = 0.93;
  Twin twin(boats::full_chain(Scheme::kMoorePenrose), q);
  twin.boat.longest_step = 0.002;
  twin.plant = std::make_unique<Plant>(twin.boat.structure, twin.boat.coefficient, twin.chain,
                                       twin.q.data(), 0.002);
  boats::Random random(73);
  Script script;
  for (int i = 0; i < 3000; ++i) {
    script.add(0.01 * i, {random(-1.0, 1.0), random(-1.0, 1.0), random(-1.0, 1.0)});
  }
  const std::vector<double> time = {0.0, 10.004, 20.004, 29.996};
  const ThrustTrace trace(twin.chain, twin.q.data(), script.held(), Held{}, Columns{});
  std::vector<double> want(24);
  const double x0[kStates] = {0.0};
  REQUIRE(simulate(twin.boat, trace, x0, time.data(), 4, want.data(), nullptr) == 4);
  twin.plant->reset(0.0, script.row(0));
  for (int i = 1; i < 3000; ++i) {
    const double t = script.time[static_cast<std::size_t>(i)];
    REQUIRE(twin.plant->advance_to(t));
    REQUIRE(twin.plant->command(t, script.row(i)));
  }
  REQUIRE(twin.plant->advance_to(29.996));
  Worst worst;
  for (int i = 0; i < kStates; ++i) {
    worst.see(twin.plant->state()[i], want[18 + static_cast<std::size_t>(i)]);
  }
  CHECK(worst.value() < 1e-9);
}

TEST_CASE("a negative latency counts as none: a plant can't know a command before it") {
  auto q = boats::full_constants();
  q[boats::kLatencyA] = -0.5;
  q[boats::kLatencyB] = -0.5;
  Twin early(boats::full_chain(Scheme::kMoorePenrose), q);
  q[boats::kLatencyA] = 0.0;
  q[boats::kLatencyB] = 0.0;
  Twin prompt(boats::full_chain(Scheme::kMoorePenrose), q);
  const double full[3] = {1.0, 0.4, -0.3};
  for (Twin* twin : {&early, &prompt}) {
    REQUIRE(twin->plant->command(0.0, full));
    REQUIRE(twin->plant->advance_to(0.7));
  }
  for (int i = 0; i < kStates; ++i) CHECK(early.plant->state()[i] == prompt.plant->state()[i]);
  CHECK(prompt.plant->state()[3] > 0.01);
}

TEST_CASE("a command that is too late, or of no finite time, is refused") {
  Twin twin;
  Plant& plant = *twin.plant;
  const double full[3] = {1.0, 0.0, 0.0};
  REQUIRE(plant.advance_to(1.0));
  CHECK_FALSE(plant.command(0.999, full));
  CHECK_FALSE(plant.command(std::nan(""), full));
  CHECK_FALSE(plant.command(std::numeric_limits<double>::infinity(), full));
  CHECK(plant.command(1.0, full));
  REQUIRE(plant.advance_to(3.0));
  CHECK(plant.state()[3] > 0.05);  // the refused ones left no trace
  CHECK(plant.time() == 3.0);
}

TEST_CASE("commands act by their stamps, in whatever order they come") {
  const Script script = boats::random_script(75, 30, 3, 0.0, -1.0, 1.0);
  Twin ordered;
  Twin mixed;
  for (int i = 0; i < script.size(); ++i) {
    const int other = script.size() - 1 - i;
    REQUIRE(ordered.plant->command(script.time[static_cast<std::size_t>(i)], script.row(i)));
    REQUIRE(mixed.plant->command(script.time[static_cast<std::size_t>(other)], script.row(other)));
  }
  REQUIRE(ordered.plant->advance_to(script.time.back() + 1.0));
  REQUIRE(mixed.plant->advance_to(script.time.back() + 1.0));
  for (int i = 0; i < kStates; ++i) CHECK(mixed.plant->state()[i] == ordered.plant->state()[i]);
}

TEST_CASE("a command that expires is as one of zero at that time, at each thruster") {
  auto q = boats::full_constants();
  q[boats::kLatencyA] = 0.4;
  q[boats::kLatencyB] = 0.05;
  Twin expiring(boats::full_chain(Scheme::kMoorePenrose), q);
  Twin by_hand(boats::full_chain(Scheme::kMoorePenrose), q);
  expiring.plant->set_timeout(0.5);
  const double full[3] = {1.0, 0.4, -0.3};
  const double still[3] = {0.0, 0.0, 0.0};
  // the first two hold for less than the time-out, the third for all of it, the fourth is last
  for (Twin* twin : {&expiring, &by_hand}) {
    for (const double t : {0.0, 0.3, 0.5, 2.0}) REQUIRE(twin->plant->command(t, full));
  }
  for (const double t : {1.0, 2.5}) REQUIRE(by_hand.plant->command(t, still));
  for (const double t : {0.9, 1.6, 2.01, 2.45, 2.6, 4.0}) {
    REQUIRE(expiring.plant->advance_to(t));
    REQUIRE(by_hand.plant->advance_to(t));
    for (int i = 0; i < kStates; ++i) {
      CHECK(expiring.plant->state()[i] == doctest::Approx(by_hand.plant->state()[i]).epsilon(1e-9));
    }
    CHECK(expiring.plant->silent() == (t == 1.6 || t == 2.01 || t >= 2.6));
    CHECK_FALSE(by_hand.plant->silent());
  }
}

TEST_CASE("a clock that is set moves all times of a plant, and nothing else") {
  Twin own;
  Twin other;
  const double full[3] = {1.0, 0.4, -0.3};
  constexpr double kLeap = -1024.0;  // [s] exact in binary
  for (Twin* twin : {&own, &other}) {
    twin->plant->set_timeout(0.5);
    REQUIRE(twin->plant->command(0.0, full));
    REQUIRE(twin->plant->command(0.25, full));
    REQUIRE(twin->plant->advance_to(0.25));
  }
  own.plant->shift_clock(kLeap);
  for (const double t : {0.5, 0.75, 1.5}) {
    REQUIRE(own.plant->advance_to(t + kLeap));
    REQUIRE(other.plant->advance_to(t));
    for (int i = 0; i < kStates; ++i) {
      CHECK(own.plant->state()[i] == doctest::Approx(other.plant->state()[i]).epsilon(1e-9));
    }
    CHECK(own.plant->silent() == other.plant->silent());
  }
  CHECK(own.plant->silent());
}

TEST_CASE("a plant whose commands are dropped has its thrusters off until the next") {
  Twin twin;
  Plant& plant = *twin.plant;
  const double full[3] = {1.0, 0.0, 0.0};
  for (const double t : {0.0, 2.0}) REQUIRE(plant.command(t, full));
  REQUIRE(plant.advance_to(2.0));
  const double fast = plant.state()[3];
  plant.drop_commands();
  CHECK(plant.silent());
  REQUIRE(plant.advance_to(6.0));
  CHECK(plant.state()[3] < 0.5 * fast);
  REQUIRE(plant.command(6.0, full));
  REQUIRE(plant.advance_to(8.0));
  CHECK_FALSE(plant.silent());
  CHECK(plant.state()[3] > 0.8 * fast);
}

TEST_CASE("a plant refuses a command more than it can hold, and takes it later") {
  Twin twin;
  Plant& plant = *twin.plant;
  const double full[3] = {1.0, 0.0, 0.0};
  for (int i = 0; i < kMaxPending; ++i) REQUIRE(plant.command(1e-4 * i, full));
  CHECK_FALSE(plant.command(1.0, full));
  REQUIRE(plant.advance_to(0.5));
  CHECK(plant.command(1.0, full));
}

TEST_CASE("a reset plant rests at the origin and has forgotten what was under way") {
  Twin twin(boats::full_chain(Scheme::kAlwaysForward));
  Plant& plant = *twin.plant;
  const double full[3] = {1.0, 0.5, -0.5};
  const double still[3] = {0.0, 0.0, 0.0};
  REQUIRE(plant.command(0.0, full));
  REQUIRE(plant.advance_to(2.0));
  REQUIRE(plant.command(2.0, full));
  plant.reset(10.0, still);
  CHECK(plant.time() == 10.0);
  for (int i = 0; i < kStates; ++i) CHECK(plant.state()[i] == 0.0);
  REQUIRE(plant.advance_to(11.0));
  Twin fresh(boats::full_chain(Scheme::kAlwaysForward));
  REQUIRE(fresh.plant->advance_to(1.0));
  for (int i = 0; i < kStates; ++i) {
    CHECK(plant.state()[i] == doctest::Approx(fresh.plant->state()[i]).epsilon(1e-12));
  }
}

TEST_CASE("a plant never goes back in time, and not to a time that is none") {
  Twin twin;
  Plant& plant = *twin.plant;
  REQUIRE(plant.advance_to(1.0));
  CHECK(plant.advance_to(0.5));
  CHECK(plant.time() == 1.0);
  CHECK_FALSE(plant.advance_to(std::nan("")));
  CHECK_FALSE(plant.advance_to(std::numeric_limits<double>::infinity()));
  CHECK(plant.time() == 1.0);
}

TEST_CASE(
    "a plant that diverges, or gets an input that is no number, reports it and does not hang") {
  Twin twin;
  twin.boat.coefficient[boats::kXuu] = 40.0;
  twin.boat.coefficient[boats::kXu] = 5.0;
  Plant runaway(twin.boat.structure, twin.boat.coefficient, twin.chain, twin.q.data(), 0.01);
  const double full[3] = {1.0, 0.0, 0.0};
  REQUIRE(runaway.command(0.0, full));
  CHECK_FALSE(runaway.advance_to(60.0));
  CHECK_FALSE(runaway.advance_to(120.0));

  const double lost[3] = {std::nan(""), 0.0, 0.0};
  REQUIRE(twin.plant->command(0.0, lost));
  CHECK_FALSE(twin.plant->advance_to(1.0));
}

TEST_CASE("a plant allocates nothing, nor does a step with sensitivities") {
  Twin twin(boats::full_chain(Scheme::kAlwaysForward));
  const Columns columns = boats::all_columns(twin.boat.structure, twin.chain);
  const double full[3] = {1.0, 0.5, -0.5};
  const double force[3] = {0.1, 0.2, 0.3};
  const double still[kMaxConstants] = {0.0};
  double x[kStates] = {0.0};
  double f[kMaxActuators];
  Thrust thrust;
  ThrustSensitivities dthrust;
  StateSensitivities dx;
  seed(columns, dx);
  detail::ForceSensitivities dforce = {};

  Twin paired(boats::paired_chain(), boats::paired_constants());
  const double four[4] = {1.0, 0.5, -0.5, 0.2};

  const long before = allocations;
  bool good = true;
  twin.plant->reset(0.0, still);
  for (int i = 0; i < 100; ++i) {
    good = good && twin.plant->command(0.02 * i, full);
    good = good && twin.plant->advance_to(0.02 * (i + 1));
  }
  paired.plant->reset(0.0, still);
  good = good && paired.plant->command(0.0, four) && paired.plant->advance_to(2.0);
  allocate(twin.chain.allocation, full, f);
  good = good && euler_step_sensitivities(twin.boat.structure, twin.boat.coefficient, columns, 0.1,
                                          force, dforce, x, dx);
  good = good &&
         advance_sensitivities(twin.boat.structure, twin.boat.coefficient, twin.chain,
                               twin.q.data(), columns, 0.1, still, 0.01, thrust, dthrust, x, dx);
  const long after = allocations;
  CHECK(good);
  CHECK(after == before);

  const auto counted = std::make_unique<int>(3);  // the counter does count
  CHECK(allocations > after);
  CHECK(*counted == 3);
}
