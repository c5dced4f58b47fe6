// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <memory>

#include "boats.hpp"
#include "heap.hpp"
#include "no_exceptions.hpp"
#include "seatrial/simulation/mimic.hpp"

using namespace seatrial;

namespace {

std::unique_ptr<Plant> boat() {
  const auto coefficients = boats::mallard_coefficients();
  const auto constants = boats::full_constants();
  return std::make_unique<Plant>(boats::mallard(), coefficients.data(),
                                 boats::full_chain(Scheme::kMoorePenrose, true), constants.data(),
                                 1e-2);
}

constexpr double kForever = std::numeric_limits<double>::infinity();

}  // namespace

TEST_CASE("a carrier without a lag and in place gets the boat's velocity") {
  Carrier carrier;
  carrier.lag = 0.0;
  carrier.acceleration = carrier.yaw_acceleration = 1e3;
  const auto plant = boat();
  const auto mimic = std::make_unique<Mimic>(*boat(), carrier, kForever);
  const double command[3] = {0.4, 0.2, -0.3};
  REQUIRE(mimic->command(0.0, command, 3));
  REQUIRE(plant->command(0.0, command));
  for (int i = 1; i <= 50; ++i) {
    const MimicOutput out = mimic->at(0.05 * i);
    REQUIRE(plant->advance_to(0.05 * i));
    for (int k = 0; k < 3; ++k) {
      CHECK(out.velocity[k] == doctest::Approx(plant->state()[3 + k]).epsilon(1e-9));
    }
    CHECK(out.health == kMimicNoPose);
  }
}

TEST_CASE("the plant's rate is the difference of its states") {
  const auto plant = boat();
  const double command[3] = {0.4, 0.2, -0.3};
  REQUIRE(plant->command(0.0, command));
  REQUIRE(plant->advance_to(1.0));
  double rate[kStates];
  REQUIRE(plant->rate(rate));
  double before[kStates];
  std::copy(plant->state(), plant->state() + kStates, before);
  constexpr double kShort = 1e-5;
  REQUIRE(plant->advance_to(1.0 + kShort));
  for (int i = 0; i < kStates; ++i) {
    CHECK((plant->state()[i] - before[i]) / kShort == doctest::Approx(rate[i]).epsilon(1e-3));
  }
}

TEST_CASE("the first pose places a boat that is already moving") {
  const auto mimic = std::make_unique<Mimic>(*boat(), Carrier{}, kForever);
  const auto free = std::make_unique<Mimic>(*boat(), Carrier{}, kForever);
  const double command[3] = {0.5, 0.0, 0.3};
  REQUIRE(mimic->command(0.0, command, 3));
  REQUIRE(free->command(0.0, command, 3));
  MimicOutput then;
  for (int i = 1; i <= 50; ++i) {
    mimic->at(0.02 * i);
    const MimicOutput out = free->at(0.02 * i);
    if (i == 40) then = out;
  }
  const double here[3] = {1.0, -2.0, 0.7};
  REQUIRE(mimic->pose(0.8, here));  // 0.2 s late
  const MimicOutput placed = mimic->at(1.0);
  const MimicOutput out = free->at(1.0);
  const double since[3] = {out.boat[0] - then.boat[0], out.boat[1] - then.boat[1], 0.0};
  double turned[3];
  body_to_earth(0.7 - then.boat[2], since, turned);
  CHECK(placed.boat[0] == doctest::Approx(1.0 + turned[0]));
  CHECK(placed.boat[1] == doctest::Approx(-2.0 + turned[1]));
  CHECK(placed.boat[2] == doctest::Approx(0.7 + out.boat[2] - then.boat[2]));
  CHECK(std::hypot(since[0], since[1]) > 1e-3);
  for (const double off : placed.mismatch) CHECK(std::abs(off) < 1e-12);
}

TEST_CASE("nothing of it takes memory from the heap") {
  const auto mimic = std::make_unique<Mimic>(*boat(), Carrier{}, 0.5);
  const double command[3] = {0.5, 0.0, 0.3};
  const double pose[3] = {0.0, 0.0, 0.0};
  const long before = allocations;
  for (int i = 0; i < 2000; ++i) {
    mimic->command(0.01 * i, command, 3);
    mimic->pose(0.01 * i, pose);
    mimic->at(0.01 * i);
  }
  CHECK(allocations == before);
}

TEST_CASE("it works where exceptions and type information are switched off") {
  CHECK(mimic_without_exceptions() == doctest::Approx(1.0 - std::exp(-1.0)).epsilon(1e-9));
}
