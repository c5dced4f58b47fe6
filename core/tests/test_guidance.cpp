// SPDX-License-Identifier: MIT
// Guidance without sway thrust: line of sight by its formula, the nearest point of a bend by
// geometry, drift that is learned, and station keeping.
#include <doctest/doctest.h>

#include <cmath>

#include "heap.hpp"
#include "seatrial/control/guidance.hpp"

using namespace seatrial;  // NOLINT(google-build-using-namespace)

namespace {

const double kStill[kAxes] = {};
constexpr GuidanceSettings kSettings = {4.0, 0.8, 0.1, 1.2, 2.0};

double no_sway(const double* /*nu*/) { return 0.0; }

Reference along_x(double x, double speed) {
  Reference r;
  r.eta[0] = x;
  r.rate[0] = speed;
  return r;
}

/// On a circle round the origin, counter-clockwise.
Reference on_circle(double radius, double angle, double speed) {
  Reference r;
  const double c = std::cos(angle);
  const double s = std::sin(angle);
  r.eta[0] = radius * c;
  r.eta[1] = radius * s;
  r.eta[2] = wrap(angle + kPi / 2.0);
  r.rate[0] = -speed * s;
  r.rate[1] = speed * c;
  r.rate[2] = speed / radius;
  r.acceleration[0] = -speed * speed / radius * c;
  r.acceleration[1] = -speed * speed / radius * s;
  return r;
}

}  // namespace

TEST_CASE("on a straight path it is line of sight") {
  Guidance g(kSettings);
  const double eta[kAxes] = {2.0, 0.6, 0.3};
  const double nu[kAxes] = {0.5, -0.1, 0.2};
  const Reference r = along_x(2.4, 0.5);
  const long before = allocations.load();
  const Guided go = g.guide(0.0, eta, nu, r, r, no_sway);
  CHECK(allocations.load() == before);
  const double a = 0.6 / (4.0 * 0.5);  // look-ahead distance: time times speed
  CHECK(go.error[2] == doctest::Approx(-std::atan(a) - 0.3));
  CHECK(go.error[1] == 0.0);
  CHECK(go.error[0] == doctest::Approx(std::cos(0.3) * 0.4 - std::sin(0.3) * 0.6));
  CHECK(go.rate[0] == doctest::Approx(0.5 * std::cos(0.3)));
  const double across = 0.5 * std::sin(0.3) - 0.1 * std::cos(0.3);
  const double learned = 0.6 / (1.0 + a * a) / (4.0 * 16.0) / 0.5;  // y / (4 T^2 U), weighed
  CHECK(go.rate[2] == doctest::Approx(-(across / 2.0 + learned) / (1.0 + a * a)));
  CHECK(go.near);
}

TEST_CASE("a boat behind its reference in a bend is not off its path") {
  Guidance g(kSettings);
  const double radius = 3.0;
  const Reference r = on_circle(radius, 1.0, 0.3);
  const Reference place = on_circle(radius, 0.7, 0.3);  // 0.9 m behind, on the circle
  Guided go = g.guide(0.0, place.eta, kStill, r, r, no_sway);
  CHECK(go.error[2] == doctest::Approx(0.0));
  CHECK(go.error[0] == doctest::Approx(0.9));
  Reference out = place;  // 0.2 m outside: to the right
  out.eta[0] *= 1.0 + 0.2 / radius;
  out.eta[1] *= 1.0 + 0.2 / radius;
  go = g.guide(0.0, out.eta, kStill, r, r, no_sway);
  CHECK(go.error[2] == doctest::Approx(std::atan(0.2 / 1.2)));
}

TEST_CASE("a drift is learned, kept over a corner, and forgotten on request") {
  Guidance g(kSettings);
  const double drift[2] = {0.03, 0.08};  // [m/s]
  const double speed = 0.5;
  const double dt = 0.05;
  double eta[kAxes] = {0.0, 0.5, 0.0};
  for (int i = 0; i < 3000; ++i) {  // a boat that points at once where it is commanded to
    const Reference r = along_x(speed * dt * i, speed);
    eta[0] = r.eta[0];
    const Guided go = g.guide(dt, eta, kStill, r, r, no_sway);
    eta[2] = wrap(eta[2] + go.error[2]);
    eta[1] += dt * (speed * std::tan(eta[2]) + drift[1]);
  }
  CHECK(std::abs(eta[1]) < 1e-3);
  CHECK(g.drift()[0] == doctest::Approx(0.0));  // along the path nothing is seen
  CHECK(g.drift()[1] == doctest::Approx(drift[1]).epsilon(0.01));
  CHECK(eta[2] == doctest::Approx(-std::atan(drift[1] / speed)).epsilon(0.01));
  Reference left;  // the path turns by 90 degrees: across it now is the drift along x, unknown
  left.rate[1] = speed;
  const double on[kAxes] = {0.0, 0.0, 0.0};
  const Guided go = g.guide(0.0, on, kStill, left, left, no_sway);
  CHECK(go.error[2] == doctest::Approx(kPi / 2.0));
  g.forget();
  CHECK(g.drift()[1] == 0.0);
}

TEST_CASE("nothing is learned where commands are limited, or in a bend") {
  Guidance g(kSettings);
  const double eta[kAxes] = {0.0, 0.5, 0.0};
  const Reference r = along_x(0.0, 0.5);
  g.hold(true);
  g.guide(0.1, eta, kStill, r, r, no_sway);
  CHECK(g.drift()[1] == 0.0);
  g.hold(false);
  const Reference bend = on_circle(1.0, 0.0, 0.5);  // 2 rad in the look-ahead time
  g.guide(0.1, eta, kStill, bend, bend, no_sway);
  CHECK(g.drift()[1] == 0.0);
  g.guide(0.1, eta, kStill, r, r, no_sway);
  CHECK(g.drift()[1] > 0.0);
}

TEST_CASE("in a turn the bow points inwards by the sway of the model") {
  Guidance g(kSettings);
  // v_dot = -r u - 2 v: in a steady turn v = -r u / 2
  const auto sway = [](const double* nu) { return -nu[2] * nu[0] - 2.0 * nu[1]; };
  Guided go;
  double angle = 0.0;
  for (int i = 0; i < 400; ++i) {
    angle = 0.1 * 0.4 / 3.0 * i;
    const Reference r = on_circle(3.0, angle, 0.4);
    go = g.guide(0.1, r.eta, kStill, r, r, sway);
  }
  const double v = -0.4 / 3.0 * 0.4 / 2.0;
  CHECK(go.nu[1] == doctest::Approx(v).epsilon(1e-3));
  CHECK(go.error[2] == doctest::Approx(-std::asin(v / 0.4)).epsilon(1e-3));
  CHECK(go.nu[2] == doctest::Approx(0.4 / 3.0).epsilon(1e-3));
}

TEST_CASE("approach is no faster than the fastest, and never astern but at the goal") {
  Guidance g(kSettings);
  const double behind[kAxes] = {-50.0, 0.0, 0.0};
  const double beyond[kAxes] = {50.0, 0.0, 0.0};
  const Reference r = along_x(0.0, 0.5);
  Guided go = g.guide(0.0, behind, kStill, r, r, no_sway);
  CHECK(go.rate[0] + go.error[0] / 2.0 == doctest::Approx(1.2));
  CHECK_FALSE(go.near);
  go = g.guide(0.0, beyond, kStill, r, r, no_sway);
  CHECK(go.rate[0] + go.error[0] / 2.0 == doctest::Approx(0.0));
  Reference goal;
  go = g.guide(0.0, beyond, kStill, goal, goal, no_sway);
  CHECK(go.error[0] == doctest::Approx(0.0));  // it points away: it turns first
  CHECK(std::abs(go.error[2]) == doctest::Approx(kPi));
  const double at[kAxes] = {0.3, 0.0, 0.0};
  Guidance fresh(kSettings);
  go = fresh.guide(0.0, at, kStill, goal, goal, no_sway);
  CHECK(go.error[0] == doctest::Approx(-0.3));  // at the goal it may back
}

TEST_CASE("station keeping points from afar at the goal, at the goal into the drift") {
  Guidance g(kSettings);
  Reference goal;
  const double far[kAxes] = {-3.0, -4.0, 0.0};
  Guided go = g.guide(0.0, far, kStill, goal, goal, no_sway);
  CHECK(go.error[2] == doctest::Approx(std::atan2(4.0, 3.0)));
  g.forget();
  goal.eta[2] = 0.4;  // the goal's heading, until the drift turns it
  const double left[kAxes] = {0.0, 0.1, 0.4};
  go = g.guide(0.0, left, kStill, goal, goal, no_sway);
  const double y = std::cos(0.4) * 0.1;
  CHECK(go.error[2] == doctest::Approx(-std::atan(y / 0.8)));
  const double turned = g.direction();
  for (int i = 0; i < 10; ++i) g.guide(0.1, left, kStill, goal, goal, no_sway);
  CHECK(g.direction() < turned);  // held to the left: the bow goes to the right
}
