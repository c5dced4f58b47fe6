// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include "boats.hpp"
#include "seatrial/simulation/simulator.hpp"

using namespace seatrial;

namespace {

Scene room() {
  Scene scene;
  const double centre[2] = {0.0, 0.0};
  Segment sides[4];
  box(centre, 8.0, 6.0, 0.0, sides);
  scene.segments.assign(sides, sides + 4);
  scene.circles.push_back({{2.0, 0.0}, 0.5});
  return scene;
}

std::unique_ptr<Plant> boat() {
  const auto coefficients = boats::mallard_coefficients();
  const auto constants = boats::full_constants();
  return std::make_unique<Plant>(boats::mallard(), coefficients.data(),
                                 boats::full_chain(Scheme::kMoorePenrose, true), constants.data(),
                                 1e-2);
}

double far() { return std::numeric_limits<double>::infinity(); }

}  // namespace

TEST_CASE("a ray ends at the first surface, and a point is as far from it as Pythagoras says") {
  const Scene scene = room();
  const double origin[2] = {0.0, 0.0};
  CHECK(range(scene, origin, 0.0) == doctest::Approx(1.5));
  CHECK(range(scene, origin, kPi) == doctest::Approx(4.0));
  CHECK(range(scene, origin, 0.5 * kPi) == doctest::Approx(3.0));
  CHECK(range(scene, origin, 0.25 * kPi) == doctest::Approx(3.0 * std::sqrt(2.0)));
  const double outside[2] = {9.0, 7.0};
  CHECK(range(scene, outside, 0.0) == far());
  const double corner = std::hypot(5.0, 4.0);
  CHECK(distance(scene, outside) == doctest::Approx(corner));
  const double within[2] = {2.1, 0.0};
  CHECK(distance(scene, within) == doctest::Approx(0.4));
  CHECK(clearance(scene.circles[0], within).away[0] == doctest::Approx(-1.0));
}

TEST_CASE("a disc that is in a wall is pushed out, and what went into it bounces") {
  const Scene scene = room();
  Hull hull = {{3.8, 1.0}, {0.4, 0.2}, 0.5};
  CHECK(touch(scene, hull));
  CHECK(hull.place[0] == doctest::Approx(3.5));
  CHECK(hull.place[1] == doctest::Approx(1.0));
  CHECK(hull.velocity[0] == doctest::Approx(-kBounce * 0.4));
  CHECK(hull.velocity[1] == doctest::Approx(0.2));
  CHECK_FALSE(touch(scene, hull));
  Hull away = {{3.8, 1.0}, {-0.4, 0.0}, 0.5};
  CHECK(touch(scene, away));
  CHECK(away.velocity[0] == doctest::Approx(-0.4));
}

TEST_CASE("random numbers are those of the standard's generator, on every machine") {
  Random one(7, 0, 0);
  Random same(7, 0, 0);
  Random other(7, 0, 1);
  double sum = 0.0;
  double square = 0.0;
  constexpr int kDraws = 100000;
  for (int i = 0; i < kDraws; ++i) {
    const double x = one.normal();
    CHECK(x == same.normal());
    CHECK(x != other.normal());
    sum += x;
    square += x * x;
  }
  CHECK(std::abs(sum / kDraws) < 0.01);
  CHECK(square / kDraws == doctest::Approx(1.0).epsilon(0.02));
}

TEST_CASE("a simulator moves as its plant, whatever its sensors and steps") {
  const auto plant = boat();
  const double current[2] = {0.0, 0.0};
  const double start[3] = {0.0, 0.0, 0.0};
  Simulator simulator({}, current, 1);
  REQUIRE(simulator.add(boat(), start, 0.3, {PoseSensor{}, Imu{}, Lidar{}}) == 0);
  CHECK(simulator.add(boat(), start, 0.3, {}) == -1);  // no room
  const double command[3] = {0.5, -0.2, 0.4};
  REQUIRE(plant->command(0.0, command));
  REQUIRE(simulator.command(0, command));
  REQUIRE(plant->advance_to(3.0));
  for (int i = 1; i <= 7; ++i) REQUIRE(simulator.advance_to(3.0 * i / 7.0));
  double x[kStates];
  simulator.state(0, x);
  for (int i = 0; i < kStates; ++i) CHECK(x[i] == doctest::Approx(plant->state()[i]).epsilon(1e-7));
  CHECK_FALSE(simulator.advance_to(far()));
}

TEST_CASE("readings are in order of arrival, each once") {
  const double current[2] = {0.0, 0.0};
  const double start[3] = {0.0, 0.0, 0.0};
  PoseSensor pose;
  pose.rate = 10.0;
  pose.delay = 0.25;
  Imu imu;
  imu.rate = 20.0;
  Simulator simulator({}, current, 1);
  REQUIRE(simulator.add(boat(), start, 0.3, {pose, imu, std::nullopt}) == 0);
  int poses = 0;
  int imus = 0;
  double last = 0.0;
  for (int i = 1; i <= 100; ++i) {
    REQUIRE(simulator.advance_to(0.03 * i));
    for (const Reading& r : simulator.take()) {
      CHECK(r.arrival <= simulator.time());
      CHECK(r.arrival >= last);
      last = r.arrival;
      (r.kind == ReadingKind::kPose ? poses : imus) += 1;
    }
  }
  CHECK(poses == 27);  // 0.1 s to 2.7 s: those that are 0.25 s old by 3 s
  CHECK(imus == 60);
}

TEST_CASE("settings that make no sense are refused in words") {
  PoseSensor pose;
  CHECK(fault(pose) == nullptr);
  pose.rate = 0.0;
  CHECK(fault(pose) != nullptr);
  Imu imu;
  CHECK(fault(imu) == nullptr);
  imu.acceleration_noise = -1.0;
  CHECK(fault(imu) != nullptr);
  Lidar lidar;
  CHECK(fault(lidar) == nullptr);
  lidar.beams = kMostBeams + 1;
  CHECK(fault(lidar) != nullptr);
}
