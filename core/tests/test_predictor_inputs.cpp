// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <limits>
#include <memory>

#include "onboard.hpp"

using namespace seatrial;
using namespace onboard;

namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinite = std::numeric_limits<double>::infinity();

}  // namespace

TEST_CASE("an input that is not a number changes nothing and is reported") {
  auto p = fresh();
  auto q = fresh();
  Sea sea(41);
  const double good[kMaxCommands] = {0.1, 0.2, 0.3};
  const double flat[9] = {0.0};
  const double no_root[9] = {1.0, 2.0, 0.0, 2.0, 1.0, 0.0, 0.0, 0.0, 1.0};
  for (int i = 0; i < 2000; ++i) {
    const Input in = sea.next();
    CHECK(give(*p, in) == give(*q, in));
    for (const double odd : {kNan, kInfinite, -kInfinite, 1e300}) {
      for (int k = 0; k < 3; ++k) {
        double values[3] = {0.1, 0.2, 0.3};
        values[k] = odd;
        CHECK(p->command(in.time, values) == Taken::kNotNumber);
        if (k < 2 || odd != 1e300) CHECK(p->pose(in.time, values) == Taken::kNotNumber);
      }
      if (odd == 1e300) continue;
      CHECK(p->command(odd, good) == Taken::kNotNumber);
      CHECK(p->pose(odd, good) == Taken::kNotNumber);
      const Estimate e = p->at(odd);
      CHECK(onboard::sound(e));
      CHECK(has(e, kBeyondReach));
    }
    CHECK(p->pose(in.time, good, flat) == Taken::kNotNumber);
    CHECK(p->pose(in.time, good, no_root) == Taken::kNotNumber);
    if (i % 100 != 0) continue;
    const Estimate a = p->at(in.time);
    const Estimate b = q->at(in.time);
    CHECK(onboard::same_bits(a.pose, b.pose, kPose));
    CHECK(onboard::same_bits(&a.covariance[0][0], &b.covariance[0][0], kStates * kStates));
    CHECK(has(a, kBadInput));
    CHECK_FALSE(has(b, kBadInput));
  }
}

TEST_CASE("before the first pose it says so, with numbers that are numbers") {
  auto p = fresh();
  CHECK(has(p->at(3.0), kNoPose));
  CHECK(onboard::sound(p->at(3.0)));
  CHECK(onboard::sound(p->at(kNan)));
  const double full[kMaxCommands] = {1.0, 0.0, 0.0};
  p->command(10.0, full);
  const Estimate e = p->at(10.5);
  CHECK(has(e, kNoPose));
  CHECK_FALSE(has(e, kCommandSilence));
  CHECK(onboard::sound(e));
  const double eta[3] = {1.0, 2.0, 7.0};
  CHECK(p->pose(10.2, eta) == Taken::kUsed);
  const Estimate f = p->at(10.2);
  CHECK_FALSE(has(f, kNoPose));
  CHECK(f.pose[1] == 2.0);
  CHECK(f.pose[2] == doctest::Approx(7.0 - 2.0 * kPi));
  CHECK(p->pose(10.2, eta) == Taken::kTwice);
}

TEST_CASE("commands hold, then are zero, as the vehicle file says") {
  OnboardModel m = onboard::model();
  m.command_timeout = 0.4;
  auto p = fresh(m);
  const double origin[3] = {0.0, 0.0, 0.0};
  const double full[kMaxCommands] = {1.0, 0.0, 0.0};
  p->pose(1.0, origin);
  p->command(1.0, full);
  const double latency = m.q[onboard::kLatency];
  CHECK_FALSE(has(p->at(1.39 + latency), kCommandSilence));
  CHECK(has(p->at(1.41 + latency), kCommandSilence));
  CHECK(has(p->at(1.0), kCommandSilence));  // not yet in force
  // the same as a command of zero at that time
  m.command_timeout = kInfinite;
  auto q = fresh(m);
  const double still[kMaxCommands] = {0.0, 0.0, 0.0};
  q->pose(1.0, origin);
  q->command(1.0, full);
  q->command(1.4, still);
  CHECK(p->at(3.0).velocity[0] == doctest::Approx(q->at(3.0).velocity[0]).epsilon(1e-12));
  CHECK(p->at(3.0).velocity[0] > 0.01);
  CHECK(p->at(1.0 + 20.0).velocity[0] < p->at(3.0).velocity[0]);
}

TEST_CASE(
    "stamps: late ones are refused, a jump needs a second one, a clock set back is followed") {
  auto p = fresh();
  Sea sea(51);
  until(*p, sea, 5.0);
  const double eta[3] = {0.0, 0.0, 0.0};
  const double still[kMaxCommands] = {0.0, 0.0, 0.0};
  CHECK(p->pose(p->newest() - 0.51, eta) == Taken::kStale);
  CHECK(has(p->at(p->newest()), kBadInput));
  CHECK(p->pose(p->newest() + 1e6, eta) == Taken::kAhead);
  until(*p, sea, 7.0);
  CHECK_FALSE(has(p->at(p->newest()), kBadInput));
  CHECK(away(p->at(p->newest()), sea.truth()) < 0.01);
  // after half a minute without inputs the second one is used, and the first with it
  CHECK(p->command(37.0, still) == Taken::kAhead);
  CHECK(p->command(37.01, still) == Taken::kUsed);
  CHECK(p->newest() == 37.01);
  CHECK_FALSE(has(p->at(p->newest()), kNoPose));
  // after an hour it restarts
  CHECK(p->command(3637.0, still) == Taken::kAhead);
  CHECK(p->command(3637.01, still) == Taken::kUsed);
  CHECK(has(p->at(p->newest()), kNoPose));
  CHECK(has(p->at(p->newest()), kDiverged));
  for (int i = 0; i < 9; ++i) CHECK(p->command(0.01 * i, still) == Taken::kStale);
  CHECK(p->command(0.1, still) == Taken::kUsed);
  CHECK(p->newest() == 0.1);
  CHECK(p->pose(0.1, eta) == Taken::kUsed);
  CHECK(onboard::sound(p->at(0.2)));
  CHECK_FALSE(has(p->at(0.2), kNoPose));
}

TEST_CASE("inputs beyond the capacity are refused and reported") {
  auto p = std::make_unique<BasicPredictor<16, 32>>(onboard::model());
  const double eta[kMaxCommands] = {};
  int refused = 0;
  for (int i = 0; i < 300; ++i) {
    const double t = 1e-3 * i;
    refused += p->command(t, eta) == Taken::kNoRoom ? 1 : 0;
    p->pose(t, eta);
    CHECK(onboard::sound(p->at(t)));
  }
  CHECK(refused > 0);
  CHECK((p->at(0.3).health & kBadInput) != 0U);
  CHECK(p->pose(0.2985, eta) == Taken::kUsed);
  CHECK(p->pose(0.1, eta) == Taken::kStale);
}
