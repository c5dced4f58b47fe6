// SPDX-License-Identifier: MIT
// What a node publishes: frames, stamps, lever arm, another model, and what it does with nonsense.
#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <memory>

#include "heap.hpp"
#include "onboard.hpp"
#include "seatrial/onboard/odometer.hpp"

using namespace seatrial;  // NOLINT(google-build-using-namespace)
using boats::Random;
using onboard::Input;

namespace {

constexpr std::int64_t kEpoch = 1770000000123456789;  // [ns]
constexpr std::int64_t kTick = 20000000;              // [ns]
const double kNoLever[2] = {0.0, 0.0};

std::int64_t stamp_of(double t) { return static_cast<std::int64_t>(std::llround(1e9 * t)); }

Taken give(Odometer& o, const Input& in, std::int64_t epoch = 0) {
  const std::int64_t stamp = epoch + stamp_of(in.time);
  return in.pose ? o.pose(stamp, in.values) : o.command(stamp, in.values);
}

std::unique_ptr<Odometer> fresh(const double* lever = kNoLever) {
  return std::make_unique<Odometer>(onboard::model(), lever);
}

/// Largest difference of pose, velocity and place of odom in map.
double difference(const Odometry& a, const Odometry& b) {
  double most = 0.0;
  for (int i = 0; i < kPose; ++i) {
    most = std::max(most, std::abs(a.motion.pose[i] - b.motion.pose[i]));
    most = std::max(most, std::abs(a.motion.velocity[i] - b.motion.velocity[i]));
    most = std::max(most, std::abs(a.map_to_odom[i] - b.map_to_odom[i]));
  }
  return most;
}

}  // namespace

TEST_CASE("before the first pose nothing is known; after it odom begins at its origin") {
  auto o = fresh();
  CHECK_FALSE(o->at(kEpoch).known);
  const double still[3] = {};
  CHECK(o->command(kEpoch, still) == Taken::kUsed);
  CHECK_FALSE(o->at(kEpoch + kTick).known);
  const double eta[3] = {2.0, -1.0, 0.5};
  CHECK(o->pose(kEpoch + 2 * kTick, eta) == Taken::kUsed);
  const Odometry out = o->at(kEpoch + 2 * kTick);
  CHECK(out.known);
  for (const double value : out.pose) CHECK(std::abs(value) < 0.01);
  for (int i = 0; i < kPose; ++i) CHECK(std::abs(out.map_to_odom[i] - eta[i]) < 0.01);
}

TEST_CASE("stamps of today give to the last bit what stamps from zero on give") {
  auto now = fresh();
  auto zero = fresh();
  for (const Input& in : onboard::drive(3, 10.0)) {
    give(*now, in, kEpoch);
    give(*zero, in);
    const std::int64_t t = stamp_of(in.time);
    const Odometry a = now->at(kEpoch + t);
    const Odometry b = zero->at(t);
    REQUIRE(onboard::same_bits(a.pose, b.pose, kPose));
    REQUIRE(onboard::same_bits(a.motion.velocity, b.motion.velocity, kAxes));
    REQUIRE(a.stamp - b.stamp == kEpoch);
  }
}

TEST_CASE("odom drifts slowly, and odom in map after the way is the pose in map") {
  auto o = fresh();
  onboard::Sea sea(11);
  std::int64_t next = 0;
  double first[3] = {};
  bool begun = false;
  double worst = 0.0;
  while (next < stamp_of(60.0)) {
    const Input in = sea.next();
    give(*o, in);
    if (stamp_of(in.time) < next) continue;
    next = stamp_of(in.time) + kTick;
    const Odometry out = o->at(stamp_of(in.time));
    if (!out.known) continue;
    double there[kPose];
    compose(out.map_to_odom, out.pose, there);
    for (int i = 0; i < 2; ++i) REQUIRE(std::abs(there[i] - out.motion.pose[i]) < 1e-12);
    if (!begun && in.time > 5.0) {
      std::copy(out.map_to_odom, out.map_to_odom + kPose, first);
      begun = true;
    }
    if (begun) {
      worst =
          std::max(worst, std::hypot(out.map_to_odom[0] - first[0], out.map_to_odom[1] - first[1]));
    }
  }
  CHECK(begun);
  CHECK(worst > 0.0);
  CHECK(worst < 0.2);  // [m] in a minute
}

TEST_CASE("odom does not jump where the map does") {
  auto o = fresh();
  onboard::Sea sea(5);
  std::int64_t next = 0;
  Odometry before;
  double odom_step = 0.0;
  double map_step = 0.0;
  while (next < stamp_of(30.0)) {
    Input in = sea.next();
    if (in.pose && in.time > 15.0) in.values[0] += 3.0;  // SLAM closes a loop
    give(*o, in);
    if (stamp_of(in.time) < next) continue;
    next = stamp_of(in.time) + kTick;
    const Odometry out = o->at(stamp_of(in.time));
    if (before.known) {
      odom_step = std::max(odom_step,
                           std::hypot(out.pose[0] - before.pose[0], out.pose[1] - before.pose[1]));
      map_step = std::max(map_step, std::abs(out.motion.pose[0] - before.motion.pose[0]));
    }
    before = out;
  }
  CHECK(map_step > 2.5);
  CHECK(odom_step < 0.05);
}

TEST_CASE("poses of a point off the origin, with its lever arm, are those of the origin") {
  const double lever[2] = {0.4, -0.25};
  auto there = fresh(lever);
  auto here = fresh();
  for (Input in : onboard::drive(8, 30.0)) {
    give(*here, in);
    if (in.pose) {
      double moved[kPose];
      const double arm[kPose] = {lever[0], lever[1], 0.0};
      compose(in.values, arm, moved);
      std::copy(moved, moved + 2, in.values);
    }
    give(*there, in);
  }
  const Odometry a = here->at(stamp_of(30.0));
  const Odometry b = there->at(stamp_of(30.0));
  // the heading's noise reaches the origin's position by the arm: weighed otherwise, but near
  CHECK(difference(a, b) < 0.01);
  CHECK(b.motion.covariance[0][0] > 0.0);
}

TEST_CASE("an arm of no length changes nothing, whether or not pose errors are correlated") {
  const double lever[2] = {1e-9, 0.0};
  for (const OnboardModel& m : {onboard::model(), onboard::coloured_model()}) {
    auto there = std::make_unique<Odometer>(m, lever);
    auto here = std::make_unique<Odometer>(m, kNoLever);
    for (const Input& in : onboard::drive(8, 5.0)) {
      give(*here, in);
      give(*there, in);
    }
    const Odometry a = here->at(stamp_of(5.0));
    const Odometry b = there->at(stamp_of(5.0));
    CHECK(difference(a, b) < 1e-8);
    for (int i = 0; i < kStates; ++i) {
      CHECK(a.motion.covariance[i][i] == doctest::Approx(b.motion.covariance[i][i]).epsilon(1e-6));
    }
  }
}

TEST_CASE("with an arm a first pose is as unsure, whether its error is white or is correlated") {
  const double lever[2] = {0.6, 0.3};
  const double eta[3] = {1.0, 2.0, 0.8};
  OnboardModel m = onboard::model();
  Odometer white(m, lever);
  NoiseParameters& n = m.boat.noise;
  n.colour_position = 0.8 * n.position;
  n.colour_heading = 0.8 * n.heading;
  n.position *= 0.6;
  n.heading *= 0.6;
  Odometer coloured(m, lever);
  REQUIRE(white.pose(0, eta) == Taken::kUsed);
  REQUIRE(coloured.pose(0, eta) == Taken::kUsed);
  for (int i = 0; i < kPose; ++i) {
    CHECK(coloured.look(0).covariance[i][i] == doctest::Approx(white.look(0).covariance[i][i]));
  }
}

TEST_CASE("the arm's part of the covariance is that of many poses") {
  OnboardModel m = onboard::model();
  const double lever[2] = {0.6, 0.3};
  const double eta[3] = {1.0, 2.0, 0.8};
  Odometer o(m, lever);
  REQUIRE(o.pose(0, eta) == Taken::kUsed);
  const Estimate e = o.look(0);
  Random random(4);
  double origin[3] = {};
  double sum[2][3] = {};
  constexpr int kMany = 20000;
  const double arm[3] = {-lever[0], -lever[1], 0.0};
  compose(eta, arm, origin);
  for (int i = 0; i < kMany; ++i) {
    double noisy[3];
    double moved[3];
    for (int k = 0; k < 3; ++k) noisy[k] = eta[k] + onboard::kNoise[k] * onboard::normal(random);
    compose(noisy, arm, moved);
    for (int k = 0; k < 2; ++k) {
      for (int j = 0; j < 3; ++j)
        sum[k][j] += (moved[k] - origin[k]) * (moved[j] - origin[j]) / kMany;
    }
  }
  CHECK(e.pose[0] == doctest::Approx(origin[0]));
  CHECK(e.pose[1] == doctest::Approx(origin[1]));
  const double ratio = e.covariance[2][2] / (onboard::kNoise[2] * onboard::kNoise[2]);
  for (int k = 0; k < 2; ++k) {
    for (int j = 0; j < 3; ++j) {
      const double scale = std::sqrt(sum[k][k] * (j == 2 ? 1.6e-5 : sum[j][j]));
      CHECK(std::abs(e.covariance[k][j] / ratio - sum[k][j]) < 0.05 * scale);
    }
  }
}

TEST_CASE("a reload of the same model changes little, and odom continues") {
  auto o = fresh();
  const auto inputs = onboard::drive(21, 20.0);
  for (const Input& in : inputs) {
    give(*o, in);
    o->at(stamp_of(in.time));
  }
  const std::int64_t t = stamp_of(inputs.back().time);
  const Odometry before = o->at(t);
  o->reload(onboard::model(), kNoLever);
  const Odometry after = o->at(t);
  CHECK(onboard::same_bits(before.pose, after.pose, kPose));
  CHECK(after.known);
  CHECK((after.motion.health & kNoPose) == 0U);
  CHECK(difference(before, after) < 0.02);
  CHECK(o->count(Source::kPose, Taken::kUsed) > 250);  // counted once
  CHECK(o->count(Source::kPose, Taken::kUsed) < 350);
}

TEST_CASE("inputs that are given again after a reload count as those that it has kept") {
  auto kept = fresh();
  auto again = fresh();
  const auto inputs = onboard::drive(22, 5.0);
  for (auto* o : {kept.get(), again.get()}) {
    for (const Input& in : inputs) give(*o, in);
  }
  kept->reload(onboard::model(), kNoLever);
  again->forget_inputs();
  again->reload(onboard::model(), kNoLever);
  const std::int64_t t = stamp_of(inputs.back().time);
  CHECK((again->look(t).health & kNoPose) != 0U);
  CHECK(again->count(Source::kPose, Taken::kUsed) == 0);
  for (const Input& in : inputs) give(*again, in);
  CHECK(difference(kept->at(t), again->at(t)) == 0.0);
  CHECK(again->count(Source::kPose, Taken::kUsed) == kept->count(Source::kPose, Taken::kUsed));
}

TEST_CASE("nonsense leaves no mark, and a clock that is set back stops the way only for a while") {
  auto o = fresh();
  for (const Input& in : onboard::drive(2, 10.0)) give(*o, in, kEpoch);
  const Odometry before = o->at(kEpoch + stamp_of(10.0));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double bad[3] = {nan, 0.0, 0.0};
  CHECK(o->pose(kEpoch + stamp_of(10.0), bad) == Taken::kNotNumber);
  CHECK(o->count(Source::kPose, Taken::kNotNumber) == 1);
  for (const std::int64_t odd : {std::numeric_limits<std::int64_t>::min(),
                                 std::numeric_limits<std::int64_t>::max(), std::int64_t{0}}) {
    const Odometry out = o->at(odd);
    CHECK(onboard::sound(out.motion));
    CHECK((out.motion.health & kBeyondReach) != 0U);
    CHECK(onboard::same_bits(out.pose, before.pose, kPose));
    CHECK(o->command(odd, bad) == Taken::kNotNumber);
  }
  // the clock begins at 0 again
  double far = 0.0;
  for (const Input& in : onboard::drive(2, 10.0)) {
    give(*o, in);
    const Odometry out = o->at(stamp_of(in.time));
    far = std::max(far, std::hypot(out.pose[0] - before.pose[0], out.pose[1] - before.pose[1]));
    REQUIRE(onboard::sound(out.motion));
  }
  CHECK(far > 0.05);
}

TEST_CASE("no heap") {
  auto o = fresh();
  const auto inputs = onboard::drive(9, 3.0);
  const OnboardModel another = onboard::model();
  const long before = allocations;
  for (const Input& in : inputs) {
    give(*o, in);
    o->at(stamp_of(in.time));
  }
  o->reload(another, kNoLever);
  CHECK(allocations == before);
}
