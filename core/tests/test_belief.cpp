// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include "boats.hpp"
#include "onboard.hpp"

using namespace seatrial;
using boats::Random;
using boats::Worst;

namespace {

/// A boat under way, believed with a covariance that links everything.
Belief under_way(std::uint64_t seed) {
  Random random(seed);
  Belief b;
  const double x[kBelieved] = {0.3, -0.2, 0.7, 0.25, -0.15, 0.5, 0.02, -0.03, 0.05};
  std::copy(x, x + kBelieved, b.x);
  double root[kBelieved][kBelieved];
  for (auto& row : root) random.fill(row, kBelieved, -0.1, 0.1);
  for (int i = 0; i < kBelieved; ++i) root[i][i] += 0.2;
  for (int i = 0; i < kBelieved; ++i) {
    for (int j = 0; j < kBelieved; ++j) {
      for (int k = 0; k < kBelieved; ++k) b.p[i][j] += root[i][k] * root[j][k];
    }
  }
  return b;
}

constexpr double kForce[3][kMaxForces] = {{0.5, -0.3, 0.4}, {0.52, -0.2, 0.3}, {0.53, -0.1, 0.2}};
constexpr double kStep = 0.02;  // [s]

DrivenBoat boat(DisturbanceFrame frame) {
  DrivenBoat b = onboard::model().boat;
  b.frame = frame;
  b.current[0] = 0.05;
  b.current[1] = -0.02;
  return b;
}

/// d state / d state over a step, by central differences of the mean.
void slopes_by_differences(const DrivenBoat& boat, const Belief& at, double f[][kBelieved]) {
  constexpr double kOff = 1e-5;
  for (int j = 0; j < kBelieved; ++j) {
    Belief ahead = at;
    Belief back = at;
    ahead.x[j] += kOff;
    back.x[j] -= kOff;
    REQUIRE(believe_step(boat, kStep, kForce, ahead));
    REQUIRE(believe_step(boat, kStep, kForce, back));
    for (int i = 0; i < kBelieved; ++i) f[i][j] = (ahead.x[i] - back.x[i]) / (2.0 * kOff);
  }
}

/// F P F'.
void carried(const double f[][kBelieved], const Belief& b, double out[][kBelieved]) {
  for (int i = 0; i < kBelieved; ++i) {
    for (int j = 0; j < kBelieved; ++j) {
      out[i][j] = 0.0;
      for (int k = 0; k < kBelieved; ++k) {
        for (int l = 0; l < kBelieved; ++l) out[i][j] += f[i][k] * b.p[k][l] * f[j][l];
      }
    }
  }
}

}  // namespace

TEST_CASE("the covariance is carried by the derivatives of the motion") {
  for (const auto frame : {DisturbanceFrame::kEarth, DisturbanceFrame::kBody}) {
    DrivenBoat b = boat(frame);
    b.noise.walk_linear = b.noise.walk_yaw = 0.0;
    b.noise.disturbance_linear = b.noise.disturbance_yaw = 0.0;
    Belief belief = under_way(3);
    double f[kBelieved][kBelieved];
    double want[kBelieved][kBelieved];
    slopes_by_differences(b, belief, f);
    carried(f, belief, want);
    REQUIRE(believe_step(b, kStep, kForce, belief));
    Worst worst;
    for (int i = 0; i < kBelieved; ++i) {
      for (int j = 0; j < kBelieved; ++j) worst.see(belief.p[i][j], want[i][j]);
    }
    CHECK(worst.value() < 1e-9);
  }
}

TEST_CASE("process noise is that of a random walk and of a disturbance that renews itself") {
  DrivenBoat b = boat(DisturbanceFrame::kEarth);
  b.noise = {1e-3, 1e-3, 0.02, 0.05, 0.03, 0.07, 2.0};
  Belief with = under_way(4);
  Belief without = with;
  DrivenBoat quiet = b;
  quiet.noise.walk_linear = quiet.noise.walk_yaw = 0.0;
  quiet.noise.disturbance_linear = quiet.noise.disturbance_yaw = 0.0;
  const double psi = with.x[2] + 0.5 * kStep * with.x[5];
  REQUIRE(believe_step(b, kStep, kForce, with));
  REQUIRE(believe_step(quiet, kStep, kForce, without));
  const double q = 0.02 * 0.02;
  const auto added = [&](int i, int j) { return with.p[i][j] - without.p[i][j]; };
  CHECK(added(3, 3) == doctest::Approx(q * kStep));
  CHECK(added(5, 5) == doctest::Approx(0.05 * 0.05 * kStep));
  CHECK(added(0, 3) == doctest::Approx(std::cos(psi) * q * kStep * kStep / 2.0));
  CHECK(added(1, 3) == doctest::Approx(std::sin(psi) * q * kStep * kStep / 2.0));
  CHECK(added(0, 4) == doctest::Approx(-std::sin(psi) * q * kStep * kStep / 2.0));
  CHECK(added(0, 0) == doctest::Approx(q * kStep * kStep * kStep / 3.0).epsilon(1e-6));
  CHECK(added(6, 6) == doctest::Approx(0.03 * 0.03 * (1.0 - std::exp(-2.0 * kStep / 2.0))));
  CHECK(added(8, 8) == doctest::Approx(0.07 * 0.07 * (1.0 - std::exp(-2.0 * kStep / 2.0))));
}

TEST_CASE("a correction is Bayes' rule: information adds up") {
  Belief b = under_way(5);
  const Belief before = b;
  const double noise[kSeen][kSeen] = {{4e-4, 1e-5, 0.0}, {1e-5, 9e-4, 2e-5}, {0.0, 2e-5, 1e-3}};
  const double eta[kSeen] = {b.x[0] + 0.01, b.x[1] - 0.02, b.x[2] + 0.03 + 2.0 * kPi};
  const Surprise found = surprise(b, eta, noise);
  CHECK(found.e[2] == doctest::Approx(0.03));
  correct(found, noise, b);
  CHECK(onboard::positive(&b.p[0][0], kBelieved));
  // P+ = P - P H' S^-1 H P, column by column; and the residual left is R S^-1 of it
  Worst worst;
  for (int j = 0; j < kBelieved; ++j) {
    double z[kSeen] = {before.p[0][j], before.p[1][j], before.p[2][j]};
    detail::solve_root(found.root, z);
    for (int i = 0; i < kBelieved; ++i) {
      const double less = before.p[i][0] * z[0] + before.p[i][1] * z[1] + before.p[i][2] * z[2];
      worst.see(b.p[i][j], before.p[i][j] - less);
    }
  }
  double z[kSeen] = {found.e[0], found.e[1], found.e[2]};
  detail::solve_root(found.root, z);
  for (int i = 0; i < kSeen; ++i) {
    const double left = noise[i][0] * z[0] + noise[i][1] * z[1] + noise[i][2] * z[2];
    worst.see(found.e[i] - (b.x[i] - before.x[i]), left);
  }
  CHECK(worst.value() < 1e-14);
}

TEST_CASE("an outlier moves the belief as far as one at the limit, and is worth as much less") {
  const Belief before = under_way(7);
  const double noise[kSeen][kSeen] = {{4e-4, 1e-5, 0.0}, {1e-5, 9e-4, 2e-5}, {0.0, 2e-5, 1e-3}};
  const auto moved = [&](double far, Belief& b) {
    b = before;
    const double eta[kSeen] = {b.x[0] + far, b.x[1] - far, b.x[2] + 0.5 * far};
    const Surprise found = surprise(b, eta, noise);
    correct_robustly(found, noise, 4.0, b);
    return std::sqrt(found.square);
  };
  Belief at;
  Belief beyond;
  Belief within;
  const double unit = moved(0.01, within) / 0.01;  // [sigma per m]
  CHECK(moved(4.0 / unit, at) == doctest::Approx(4.0));
  CHECK(moved(12.0 / unit, beyond) == doctest::Approx(12.0));
  for (int i = 0; i < kBelieved; ++i) {  // the gain falls with the square of the distance
    CHECK(beyond.x[i] - before.x[i] == doctest::Approx((at.x[i] - before.x[i]) / 3.0));
    CHECK(at.p[i][i] == doctest::Approx(within.p[i][i]));
    CHECK(before.p[i][i] - beyond.p[i][i] ==
          doctest::Approx((before.p[i][i] - at.p[i][i]) / 9.0).epsilon(1e-6));
  }
  CHECK(onboard::positive(&beyond.p[0][0], kBelieved));
}

TEST_CASE("a covariance stays one through steps and corrections of very different size") {
  DrivenBoat b = boat(DisturbanceFrame::kEarth);
  b.noise = {1e-4, 1e-4, 1e-6, 1e-6, 1e-5, 1e-5, 0.3};
  Belief belief = under_way(6);
  const double tight[kSeen][kSeen] = {{1e-12, 0.0, 0.0}, {0.0, 1e-12, 0.0}, {0.0, 0.0, 1e-12}};
  for (int i = 0; i < 3000; ++i) {
    REQUIRE(believe_step(b, kStep, kForce, belief));
    if (i % 3 == 0 && (i < 1000 || i > 2000)) {
      const double eta[kSeen] = {belief.x[0], belief.x[1], belief.x[2]};
      correct(surprise(belief, eta, tight), tight, belief);
    }
    REQUIRE(onboard::positive(&belief.p[0][0], kBelieved));
  }
}

TEST_CASE("an earth-fixed disturbance keeps its direction while the boat turns") {
  DrivenBoat b = boat(DisturbanceFrame::kEarth);
  b.current[0] = b.current[1] = 0.0;
  std::fill(b.coefficient, b.coefficient + kMaxCoefficients, 0.0);  // no drag, no thrust
  b.noise.memory = 1e9;
  Belief belief;
  belief.x[5] = 2.0;  // [rad/s]
  belief.x[6] = 0.1;  // [m/s^2]
  for (int i = 0; i < kBelieved; ++i) belief.p[i][i] = 1e-4;
  for (int i = 0; i < 200; ++i) REQUIRE(believe_step(b, kStep, kForce, belief));
  CHECK(belief.x[0] == doctest::Approx(0.5 * 0.1 * 4.0 * 4.0).epsilon(1e-4));
  CHECK(belief.x[1] == doctest::Approx(0.0).epsilon(1e-4).scale(0.8));
  b.frame = DisturbanceFrame::kBody;
  Belief turned;
  turned.x[5] = 2.0;
  turned.x[6] = 0.1;
  for (int i = 0; i < kBelieved; ++i) turned.p[i][i] = 1e-4;
  for (int i = 0; i < 200; ++i) REQUIRE(believe_step(b, kStep, kForce, turned));
  const double radius = 0.1 / 4.0;  // a / r^2
  CHECK(turned.x[0] == doctest::Approx(radius * (1.0 - std::cos(8.0))).epsilon(1e-3));
}

TEST_CASE("without room for a disturbance a structure is refused") {
  Structure s = boats::mallard();
  const int terms = s.n_terms;
  CHECK(add_disturbance(s));
  CHECK(s.n_terms == terms + 3);
  CHECK(check(s) == StructureFault::kOk);
  s.n_terms = kMaxTerms - 2;
  CHECK_FALSE(add_disturbance(s));
  CHECK(s.n_terms == kMaxTerms - 2);
}
