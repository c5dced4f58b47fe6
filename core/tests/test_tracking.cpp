// SPDX-License-Identifier: MIT
// The tracking controller: against a PID written out, the inverse of Eq. (12) by hand, and its
// limits.
#include <doctest/doctest.h>

#include <cmath>
#include <limits>

#include "boats.hpp"
#include "heap.hpp"
#include "seatrial/control/tracking.hpp"
#include "seatrial/simulation/plant.hpp"

using namespace seatrial;  // NOLINT(google-build-using-namespace)

namespace {

const double kStill[kAxes] = {};

TrackingGains gains(bool feed_forward = true) {
  TrackingGains g;
  const double p[kAxes] = {3.0, 2.0, 1.5};
  const double i[kAxes] = {0.8, 0.5, 0.4};
  const double d[kAxes] = {4.0, 3.0, 1.0};
  const auto c = boats::mallard_coefficients();
  const double authority[kAxes] = {c[boats::kXF], c[boats::kYF], c[boats::kNF]};
  for (int k = 0; k < kAxes; ++k) {
    g.proportional[k] = p[k];
    g.integral[k] = i[k];
    g.derivative[k] = d[k];
    g.authority[k] = authority[k];
    g.mix[k][k] = 1.0;
  }
  g.mix[2][0] = -c[boats::kNud] * authority[0] / authority[2];
  g.limit = 100.0;
  g.feed_forward = feed_forward;
  return g;
}

Tracker tracker(const TrackingGains& g, Scheme scheme = Scheme::kMoorePenrose, double limit = 1e9) {
  Chain c = boats::plain_chain(scheme);
  c.allocation.limit = limit;
  const auto coefficients = boats::mallard_coefficients();
  return {boats::mallard(), coefficients.data(), c.allocation, g};
}

}  // namespace

TEST_CASE("without feed-forward it is a PID in body axes") {
  Tracker t = tracker(gains(false));
  const double eta[kAxes] = {1.0, -0.5, 0.7};
  const double nu[kAxes] = {0.2, -0.1, 0.3};
  Reference r;
  const double wanted[3][kAxes] = {{1.3, -0.1, 0.9}, {0.15, 0.25, 0.1}, {9.0, 9.0, 9.0}};
  for (int i = 0; i < kAxes; ++i) {
    r.eta[i] = wanted[0][i];
    r.rate[i] = wanted[1][i];
    r.acceleration[i] = wanted[2][i];
  }
  const double c = std::cos(0.7);
  const double s = std::sin(0.7);
  const double error[kAxes] = {c * 0.3 + s * 0.4, -s * 0.3 + c * 0.4, 0.2};
  const double rate[kAxes] = {c * 0.15 + s * 0.25 - 0.2, -s * 0.15 + c * 0.25 + 0.1, 0.1 - 0.3};
  const TrackingGains g = gains();
  double values[kMaxCommands];
  for (int call = 0; call < 3; ++call) {
    CHECK(t.command(0.1, eta, nu, r, r, values) == Tracked::kFollowing);
    double axis[kAxes];
    for (int i = 0; i < kAxes; ++i) {
      axis[i] =
          (g.proportional[i] + 0.1 * call * g.integral[i]) * error[i] + g.derivative[i] * rate[i];
    }
    CHECK(values[0] == doctest::Approx(axis[0]));
    CHECK(values[1] == doctest::Approx(axis[1]));
    CHECK(values[2] == doctest::Approx(axis[2] + g.mix[2][0] * axis[0]));
  }
}

TEST_CASE("by an allocator the curves are inverted: thrust is as without a dead zone") {
  constexpr double kSigns[4][kAxes] = {{-1, 1, 1}, {-1, -1, -1}, {1, 1, -1}, {1, -1, 1}};
  AllocatorSetup setup;
  setup.scheme = AllocatorScheme::kNullSpace;
  setup.effectiveness.n = setup.chain.allocation.n_actuators = 4;
  setup.chain.n_constants = 1;
  setup.q[0] = 0.08;
  TrackingGains g = gains(false);
  for (int k = 0; k < 4; ++k) {
    setup.chain.actuators[k].edge_forward = setup.chain.actuators[k].edge_reverse = 0;
    setup.limit[k] = 1.0;
    setup.idle_forward[k] = setup.idle_reverse[k] = 0.12;
    for (int i = 0; i < kAxes; ++i) {
      setup.effectiveness.column[k][i] = 0.5 * kSigns[k][i];
      g.mix[k][i] = kSigns[k][i];
    }
  }
  const Allocator allocator(setup);
  REQUIRE(allocator.fault() == AllocatorFault::kOk);
  const auto c = boats::mallard_coefficients();
  Tracker t(boats::mallard(), c.data(), allocator, g);
  Reference r;
  r.eta[0] = 0.01;
  r.eta[1] = -0.02;
  r.eta[2] = 0.03;
  double values[kMaxCommands];
  const long before = allocations.load();
  CHECK(t.command(0.1, kStill, kStill, r, r, values) == Tracked::kFollowing);
  CHECK(allocations.load() == before);
  for (int i = 0; i < kAxes; ++i) {
    double given = 0.0;  // T y, T = S / 2, with y past the edge of 0.08
    for (int k = 0; k < 4; ++k) {
      CHECK(std::abs(values[k]) >= 0.12 - 1e-12);
      const double y = (std::abs(values[k]) - 0.08) / 0.92;
      given += 0.5 * kSigns[k][i] * std::copysign(y, values[k]);
    }
    CHECK(given == doctest::Approx(2.0 * g.proportional[i] * r.eta[i]));  // 4 thrusters of 1/2 each
  }
  r.eta[0] = 9.0;
  CHECK(t.command(0.1, kStill, kStill, r, r, values) == Tracked::kLimited);
  for (int k = 0; k < 4; ++k) CHECK(std::abs(values[k]) <= 1.0);
  CHECK(t.integral()[0] == doctest::Approx(0.1 * 0.01));  // full thrust: nothing more is integrated
}

TEST_CASE("a heading error goes the short way round") {
  Tracker t = tracker(gains(false));
  const double eta[kAxes] = {0.0, 0.0, 3.1};
  Reference r;
  r.eta[2] = -3.1;
  double values[kMaxCommands];
  t.command(0.0, eta, kStill, r, r, values);
  CHECK(values[2] == doctest::Approx(1.5 * (2.0 * kPi - 6.2)));
}

TEST_CASE("feed-forward is the inverse of Eq. (12): the boat then accelerates as the reference") {
  boats::Random random(5);
  const auto coefficients = boats::mallard_coefficients();
  for (int trial = 0; trial < 100; ++trial) {
    Tracker t = tracker(gains());
    Reference r;
    double eta[kAxes];
    for (int i = 0; i < kAxes; ++i) {
      eta[i] = r.eta[i] = random(-2.0, 2.0);
      r.rate[i] = random(-1.0, 1.0);
      r.acceleration[i] = random(-1.0, 1.0);
    }
    double nu[kAxes];
    earth_to_body(eta[2], r.rate, nu);
    double values[kMaxCommands];
    REQUIRE(t.command(0.0, eta, nu, r, r, values) == Tracked::kFollowing);
    double nu_dot[kAxes];
    boats::mallard_by_hand(coefficients.data(), nu, values, nu_dot);
    // d/dt (R nu) = R nu_dot + r S R nu
    double rate[kAxes];
    body_to_earth(eta[2], nu_dot, rate);
    rate[0] -= r.rate[2] * r.rate[1];
    rate[1] += r.rate[2] * r.rate[0];
    for (int i = 0; i < kAxes; ++i) CHECK(rate[i] == doctest::Approx(r.acceleration[i]));
  }
}

TEST_CASE("too much is scaled as a whole, to what thrusters can") {
  for (const Scheme scheme : {Scheme::kMoorePenrose, Scheme::kAlwaysForward}) {
    Tracker free = tracker(gains(false));
    TrackingGains g = gains(false);
    g.limit = 1.0;
    Tracker t = tracker(g, scheme, 1.0);
    Reference r;
    r.eta[0] = 5.0;
    r.eta[1] = -3.0;
    r.eta[2] = 1.0;
    double asked[kMaxCommands];
    double values[kMaxCommands];
    free.command(0.0, kStill, kStill, r, r, asked);
    CHECK(t.command(0.0, kStill, kStill, r, r, values) == Tracked::kLimited);
    const double share = values[0] / asked[0];
    CHECK(share < 1.0);
    for (int k = 0; k < 3; ++k) CHECK(values[k] == doctest::Approx(share * asked[k]));
    // an input or a thruster is at its limit, none beyond
    Chain c = boats::plain_chain(scheme);
    c.allocation.limit = 1.0;
    double thruster[kMaxActuators];
    CHECK(allocate(c.allocation, values, thruster) == doctest::Approx(1.0));
    double most = 0.0;
    for (int k = 0; k < 4; ++k) most = std::max(most, std::abs(thruster[k]));
    for (int k = 0; k < 3; ++k) most = std::max(most, std::abs(values[k]));
    CHECK(most == doctest::Approx(1.0));
  }
}

TEST_CASE(
    "anti-windup: beyond the limits nothing is integrated, and the integral recovers at once") {
  TrackingGains g = gains(false);
  g.limit = 1.0;
  Tracker t = tracker(g, Scheme::kMoorePenrose, 1.0);
  Reference far;
  far.eta[0] = 10.0;
  double values[kMaxCommands];
  for (int i = 0; i < 1000; ++i) t.command(0.1, kStill, kStill, far, far, values);
  CHECK(t.integral()[0] == 0.0);
  Reference beyond;
  beyond.eta[0] = -0.01;
  t.command(0.1, kStill, kStill, beyond, beyond, values);
  CHECK(values[0] == doctest::Approx(-0.01 * g.proportional[0]));
}

TEST_CASE("the integral alone asks for no more than the limit, and is fixed to the earth") {
  TrackingGains g = gains(false);
  g.limit = 1.0;
  for (double& p : g.proportional) p = 0.0;
  Tracker t = tracker(g);
  Reference r;
  r.eta[0] = 0.1;
  double values[kMaxCommands];
  for (int i = 0; i < 2000; ++i) t.command(0.1, kStill, kStill, r, r, values);
  CHECK(g.integral[0] * t.integral()[0] == doctest::Approx(1.0));
  // a boat that has turned a quarter to port feels it from starboard
  const double turned[kAxes] = {0.0, 0.0, kPi / 2};
  Reference here;
  here.eta[2] = kPi / 2;
  t.command(0.0, turned, kStill, here, here, values);
  CHECK(values[0] == doctest::Approx(0.0));
  CHECK(values[1] == doctest::Approx(-g.integral[1] / g.integral[0]));
  t.forget();
  t.command(0.0, turned, kStill, here, here, values);
  CHECK(values[1] == doctest::Approx(0.0));
}

TEST_CASE("what is no number gives no command, and leaves no trace") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  Tracker t = tracker(gains());
  Reference r;
  r.eta[0] = 0.1;
  double values[kMaxCommands];
  t.command(0.1, kStill, kStill, r, r, values);
  const double before = t.integral()[0];
  Reference bad = r;
  bad.acceleration[2] = nan;
  const double lost[kAxes] = {nan, 0.0, 0.0};
  const long used = allocations;
  CHECK(t.command(0.1, lost, kStill, r, r, values) == Tracked::kNotNumber);
  CHECK(t.command(0.1, kStill, lost, r, r, values) == Tracked::kNotNumber);
  CHECK(t.command(nan, kStill, kStill, r, r, values) == Tracked::kNotNumber);
  CHECK(t.command(0.1, kStill, kStill, r, bad, values) == Tracked::kNotNumber);
  CHECK(allocations == used);
  for (int k = 0; k < 3; ++k) CHECK(values[k] == 0.0);
  CHECK(t.integral()[0] == before);
}

TEST_CASE("a clock that stands, or leaps, does not wind the integral up") {
  Tracker t = tracker(gains());
  Reference r;
  r.eta[0] = 0.1;
  double values[kMaxCommands];
  t.command(-5.0, kStill, kStill, r, r, values);
  CHECK(t.integral()[0] == 0.0);
  t.command(1e6, kStill, kStill, r, r, values);
  CHECK(t.integral()[0] == doctest::Approx(0.1 * Tracker::kLongestStep));
}
