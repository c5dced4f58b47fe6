// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <cmath>

#include "onboard.hpp"

using namespace seatrial;
using namespace onboard;

TEST_CASE("false matches of 0.3 to 2 m, single or five in a row, move it nowhere") {
  auto p = fresh();
  Sea sea(11);
  boats::Random random(12);
  int left = 0;
  int rejected = 0;
  int wrong = 0;
  double jump[2] = {};
  until(*p, sea, 3.0);
  while (sea.truth() != nullptr && p->newest() < 300.0) {
    Input in = sea.next();
    const bool far = in.pose && (left > 0 || random(0.0, 1.0) < 0.01);
    if (far && left == 0) {
      left = random(0.0, 1.0) < 0.5 ? 5 : 1;
      const double size = random(0.3, 2.0);
      const double angle = random(-kPi, kPi);
      jump[0] = size * std::cos(angle);
      jump[1] = size * std::sin(angle);
    }
    if (far) {
      --left;
      ++wrong;
      in.values[0] += jump[0];
      in.values[1] += jump[1];
    }
    give(*p, in);
    if (!in.pose) continue;
    const Estimate e = p->at(in.time);
    CHECK(away(e, sea.truth()) < 0.03);
    CHECK(has(e, kGateRejecting) == far);
    CHECK_FALSE(has(e, kReinitialised));
    rejected += has(e, kGateRejecting) ? 1 : 0;
  }
  CHECK(rejected == wrong);
  CHECK(wrong > 60);
}

TEST_CASE("when all poses move for good it was the filter: it follows, and keeps its velocity") {
  auto p = fresh();
  Sea sea(21);
  until(*p, sea, 10.0);
  const double before = p->at(p->newest()).last_pose;
  int poses = 0;
  double found = 0.0;
  while (p->newest() < 14.0) {
    Input in = sea.next();
    if (in.pose) {
      in.values[0] += 0.6;
      in.values[2] += 0.3;
      ++poses;
    }
    give(*p, in);
    const Estimate e = p->at(p->newest());
    CHECK(std::hypot(e.velocity[0] - sea.truth()[3], e.velocity[1] - sea.truth()[4]) < 0.08);
    if (found == 0.0 && has(e, kReinitialised)) {
      found = p->newest();
      CHECK(poses == onboard::model().votes);
    }
    if (found == 0.0 && poses > 0) CHECK(has(e, kGateRejecting));
  }
  CHECK(found - before > 0.5);
  CHECK(found - before < 0.9);
  const Estimate e = p->at(p->newest());
  const double moved[2] = {sea.truth()[0] + 0.6, sea.truth()[1]};
  CHECK(away(e, moved) < 0.01);
  CHECK_FALSE(has(e, kReinitialised));  // for a second only
  CHECK_FALSE(has(e, kGateRejecting));
}

TEST_CASE(
    "overruled twice it is wary of its model, a good while; once, as by a SLAM that jumps, not") {
  const auto drive = [](double second) {
    auto p = fresh();
    Sea sea(23);
    until(*p, sea, second + 5.0, [second](Input& in) {
      in.values[0] += (in.time > 10.0 ? 0.6 : 0.0) + (in.time > second ? 0.6 : 0.0);
    });
    return p;
  };
  const auto once = drive(80.0);
  CHECK_FALSE(has(once->at(once->newest()), kModelDoubted));
  const auto twice = drive(40.0);
  const Estimate e = twice->at(twice->newest());
  CHECK(has(e, kModelDoubted));
  CHECK(e.covariance[3][3] > 1.5 * once->at(once->newest()).covariance[3][3]);
  CHECK(has(twice->at(twice->newest() + 50.0), kModelDoubted));
}

TEST_CASE("what makes a filter wary is no less than its own noise") {
  NoiseParameters own;
  own.walk_linear = 1.0;
  own.disturbance_yaw = 1e-9;
  own.position = 1e-9;
  const NoiseParameters more = with_default_process_noise(own);
  CHECK(more.walk_linear == 1.0);
  CHECK(more.disturbance_yaw == NoiseParameters{}.disturbance_yaw);
  CHECK(more.position == 1e-9);
}

TEST_CASE("poses good to 0.1 mm beside a model wrong by a millimetre are no false matches") {
  OnboardModel m = onboard::model();
  m.boat.noise = {1e-4, 1e-4, 1e-3, 1e-3, 1e-3, 1e-3, 2.0};
  auto p = fresh(m);
  const double little[kMaxCommands] = {0.2, 0.0, 0.0};
  p->command(0.0, little);  // the model goes, the boat is held
  int rejected = 0;
  for (int i = 0; i < 150; ++i) {
    const double t = 0.05 * i;
    const double eta[3] = {1.5e-3 * (i % 2), 0.0, 0.0};
    p->pose(t, eta);
    rejected += has(p->at(t), kGateRejecting) ? 1 : 0;
  }
  CHECK(rejected == 0);
  const double far[3] = {0.0, 0.3, 0.0};
  p->pose(7.5, far);
  CHECK(has(p->at(7.5), kGateRejecting));
}

TEST_CASE("it recovers through further false matches, and from a false first pose") {
  auto p = fresh();
  Sea sea(22);
  const double wrong[3] = {5.0, 5.0, 2.0};
  p->pose(0.0, wrong);
  boats::Random random(23);
  until(*p, sea, 3.0, [&random](Input& in) {
    if (random(0.0, 1.0) < 0.15) in.values[1] += random(0.3, 2.0);
  });
  CHECK(away(p->at(p->newest()), sea.truth()) < 0.03);
}

TEST_CASE("false matches that don't agree with each other never overrule it") {
  auto p = fresh();
  Sea sea(24);
  until(*p, sea, 5.0);
  boats::Random random(25);
  until(*p, sea, 9.0, [&random](Input& in) {
    for (int i = 0; i < 2; ++i) in.values[i] += random(0.5, 3.0);
  });
  const Estimate e = p->at(p->newest());
  CHECK(has(e, kGateRejecting));
  CHECK(has(e, kDeadReckoning));
  CHECK(away(e, sea.truth()) < 0.1);
}

TEST_CASE(
    "without poses it predicts by the model with growing covariance, and recovers with the next") {
  auto p = fresh();
  Sea sea(31);
  until(*p, sea, 10.0);
  const double last = p->at(p->newest()).last_pose;
  double variance = 0.0;
  while (p->newest() < 40.0) {
    const Input in = sea.next();
    if (in.pose) continue;
    give(*p, in);
    const Estimate e = p->at(in.time);
    CHECK(e.last_pose == last);
    CHECK(has(e, kDeadReckoning) == (in.time - last > 0.5));
    const double now = e.covariance[0][0] + e.covariance[1][1];
    CHECK(now > variance);
    variance = now;
    CHECK(away(e, sea.truth()) < 5.0 * std::sqrt(now));
  }
  until(*p, sea, 41.0);
  const Estimate e = p->at(p->newest());
  CHECK_FALSE(has(e, kDeadReckoning));
  CHECK(away(e, sea.truth()) < 0.01);
}

TEST_CASE("outside the speeds and commands of the recordings it says so") {
  OnboardModel m = onboard::model();
  for (auto& range : m.envelope.force) {
    range[0] = -0.5;
    range[1] = 0.5;
  }
  m.envelope.speed[0][0] = -0.05;
  m.envelope.speed[0][1] = 0.05;
  auto p = fresh(m);
  const double origin[3] = {0.0, 0.0, 0.0};
  const double half[kMaxCommands] = {0.5, 0.0, 0.0};
  const double full[kMaxCommands] = {0.9, 0.0, 0.0};
  p->pose(0.0, origin);
  p->command(0.0, half);
  CHECK_FALSE(has(p->at(0.5), kOutsideCommands));
  CHECK_FALSE(has(p->at(0.5), kOutsideSpeeds));
  p->command(0.5, full);
  CHECK(has(p->at(1.0), kOutsideCommands));
  CHECK(has(p->at(3.0), kOutsideSpeeds));
}

TEST_CASE("a divergence is caught and reported, and the filter restarts at the next pose") {
  OnboardModel m = onboard::model();
  m.boat.coefficient[boats::kXuu] = 40.0;
  auto p = fresh(m);
  const double origin[3] = {0.0, 0.0, 0.0};
  const double full[kMaxCommands] = {1.0, 0.0, 0.0};
  p->command(0.0, full);
  p->pose(0.0, origin);
  bool caught = false;
  for (int i = 1; i < 3000; ++i) {
    const double t = 0.01 * i;
    p->command(t, full);
    const Estimate e = p->at(t);
    CHECK(onboard::sound(e));
    caught = caught || (has(e, kDiverged) && has(e, kNoPose));
  }
  CHECK(caught);
  CHECK(p->pose(29.99, origin) == Taken::kUsed);
  CHECK_FALSE(has(p->at(29.99), kNoPose));
}
