// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include "boats.hpp"
#include "filter_states.hpp"
#include "onboard.hpp"

using namespace seatrial;
using namespace filters;
using boats::Worst;

namespace {

/// d state / d state over a step, by central differences of the mean.
void slopes_by_differences(const OnboardBoat& boat, const StateEstimate& at,
                           double f[][kOscillatingStates]) {
  constexpr double kOff = 1e-5;
  for (int j = 0; j < at.n; ++j) {
    StateEstimate ahead = at;
    StateEstimate back = at;
    ahead.x[j] += kOff;
    back.x[j] -= kOff;
    REQUIRE(predict(boat, kStep, kForce, ahead));
    REQUIRE(predict(boat, kStep, kForce, back));
    for (int i = 0; i < at.n; ++i) f[i][j] = (ahead.x[i] - back.x[i]) / (2.0 * kOff);
  }
}

/// F P F'.
void carried(const double f[][kOscillatingStates], const StateEstimate& b,
             double out[][kOscillatingStates]) {
  for (int i = 0; i < b.n; ++i) {
    for (int j = 0; j < b.n; ++j) {
      out[i][j] = 0.0;
      for (int k = 0; k < b.n; ++k) {
        for (int l = 0; l < b.n; ++l) out[i][j] += f[i][k] * b.p[k][l] * f[j][l];
      }
    }
  }
}

}  // namespace

TEST_CASE("the covariance is carried by the derivatives of the motion") {
  for (const int n : kSizes) {
    for (const auto frame : {DisturbanceFrame::kEarth, DisturbanceFrame::kBody}) {
      OnboardBoat b = boat(frame);
      b.noise.walk_linear = b.noise.walk_yaw = 0.0;
      b.noise.disturbance_linear = b.noise.disturbance_yaw = 0.0;
      b.noise.colour_turn = 2.5;
      b.considered = {};
      StateEstimate state = under_way(3, n);
      double f[kOscillatingStates][kOscillatingStates];
      double want[kOscillatingStates][kOscillatingStates];
      slopes_by_differences(b, state, f);
      carried(f, state, want);
      REQUIRE(predict(b, kStep, kForce, state));
      Worst worst;
      for (int i = 0; i < n; ++i) {
        for (int j = 0; j < n; ++j) worst.see(state.p[i][j], want[i][j]);
      }
      CHECK(worst.value() < 1e-9);
      CHECK(rest_is_untouched(state));
    }
  }
}

TEST_CASE("process noise is that of a random walk and of a disturbance that renews itself") {
  OnboardBoat b = boat(DisturbanceFrame::kEarth);
  b.noise = {1e-3, 1e-3, 0.02, 0.05, 0.03, 0.07, 2.0};
  StateEstimate with = under_way(4);
  StateEstimate without = with;
  OnboardBoat quiet = b;
  quiet.noise.walk_linear = quiet.noise.walk_yaw = 0.0;
  quiet.noise.disturbance_linear = quiet.noise.disturbance_yaw = 0.0;
  const double psi = with.x[2] + 0.5 * kStep * with.x[5];
  REQUIRE(predict(b, kStep, kForce, with));
  REQUIRE(predict(quiet, kStep, kForce, without));
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

TEST_CASE("unequal process noise of surge and sway spreads the position along the boat's axes") {
  OnboardBoat b = boat(DisturbanceFrame::kBody);
  b.noise = {1e-3, 1e-3, 0.02, 0.05, 0.03, 0.07, 2.0};
  b.noise.sway_ratio = 0.5;
  OnboardBoat quiet = b;
  quiet.noise.walk_linear = quiet.noise.walk_yaw = 0.0;
  quiet.noise.disturbance_linear = quiet.noise.disturbance_yaw = 0.0;
  const StateEstimate before = under_way(4);
  const auto added = [&](const OnboardBoat& noisy, int i, int j) {
    StateEstimate with = before;
    StateEstimate without = before;
    REQUIRE(predict(noisy, kStep, kForce, with));
    OnboardBoat still = quiet;
    still.frame = noisy.frame;
    REQUIRE(predict(still, kStep, kForce, without));
    return with.p[i][j] - without.p[i][j];
  };
  const double psi = before.x[2] + 0.5 * kStep * before.x[5];
  const double c = std::cos(psi);
  const double s = std::sin(psi);
  const double q = 0.02 * 0.02;
  const double third = kStep * kStep * kStep / 3.0;
  CHECK(added(b, 3, 3) == doctest::Approx(q * kStep));
  CHECK(added(b, 4, 4) == doctest::Approx(0.25 * q * kStep));
  CHECK(added(b, 0, 4) == doctest::Approx(-s * 0.25 * q * kStep * kStep / 2.0));
  CHECK(added(b, 0, 0) == doctest::Approx(q * third * (c * c + 0.25 * s * s)).epsilon(1e-5));
  CHECK(added(b, 1, 1) == doctest::Approx(q * third * (s * s + 0.25 * c * c)).epsilon(1e-5));
  CHECK(added(b, 0, 1) == doctest::Approx(q * third * 0.75 * c * s).epsilon(1e-5));
  const double renewed = 0.03 * 0.03 * (1.0 - std::exp(-2.0 * kStep / 2.0));
  CHECK(added(b, 6, 6) == doctest::Approx(renewed));
  CHECK(added(b, 7, 7) == doctest::Approx(0.25 * renewed));
  // an earth-fixed disturbance has no axes of the boat: the mean power in both
  OnboardBoat earth = b;
  earth.frame = DisturbanceFrame::kEarth;
  for (int i : {6, 7}) CHECK(added(earth, i, i) == doctest::Approx(0.625 * renewed));
  for (int i : {3, 4}) CHECK(added(earth, i, i) == doctest::Approx(0.625 * q * kStep));
}

TEST_CASE("coloured pose noise decays and is renewed, and does not move the boat") {
  OnboardBoat b = boat(DisturbanceFrame::kEarth);
  b.noise.colour_position = 0.006;
  b.noise.colour_heading = 0.003;
  b.noise.colour_memory = 0.3;
  const StateEstimate before = under_way(4, kColouredStates);
  StateEstimate renewed = before;
  StateEstimate faded = before;
  std::fill(renewed.x + kFilterStates, renewed.x + kOscillatingStates, 0.0);
  REQUIRE(predict(b, kStep, kForce, renewed));
  b.noise.colour_position = b.noise.colour_heading = 0.0;
  REQUIRE(predict(b, kStep, kForce, faded));
  const double stays = std::exp(-kStep / 0.3);
  for (int i = 0; i < kPose; ++i) {
    const int c = kFilterStates + i;
    const double sigma = i < 2 ? 0.006 : 0.003;
    CHECK(faded.x[c] == doctest::Approx(stays * before.x[c]));
    CHECK(renewed.p[c][c] - faded.p[c][c] ==
          doctest::Approx(sigma * sigma * (1.0 - stays * stays)).epsilon(1e-6));
  }
  CHECK(onboard::same_bits(renewed.x, faded.x, kFilterStates));
}

TEST_CASE(
    "oscillating pose noise keeps its variance and rotates, uncorrelated with its quadrature") {
  const double memory = 4.0;
  const double turn = 2.5;
  OnboardBoat b = boat(DisturbanceFrame::kEarth);
  b.considered = {};
  b.noise.colour_position = 0.06;
  b.noise.colour_heading = 0.03;
  b.noise.colour_memory = memory;
  b.noise.colour_turn = turn;
  StateEstimate state = under_way(4, kOscillatingStates);
  for (int i = kFilterStates; i < kOscillatingStates; ++i) {
    state.x[i] = i < kColouredStates ? 0.01 : 0.0;
    std::fill(state.p[i], state.p[i] + kOscillatingStates, 0.0);
    for (auto& row : state.p) row[i] = 0.0;
    state.p[i][i] = b.noise.colour_variance((i - kFilterStates) % kPose);
  }
  constexpr int kSteps = 60;
  for (int i = 0; i < kSteps; ++i) REQUIRE(predict(b, kStep, kForce, state));
  const double t = kSteps * kStep;
  const double rate = std::sqrt(turn * turn - 1.0 / (memory * memory));
  const double left =  // of e with e' = 0 at the begin
      std::exp(-t / memory) * (std::cos(rate * t) + std::sin(rate * t) / (rate * memory));
  for (int i = 0; i < kPose; ++i) {
    const int c = kFilterStates + i;
    const int o = kColouredStates + i;
    const double variance = b.noise.colour_variance(i);
    CHECK(state.x[c] == doctest::Approx(0.01 * left).epsilon(1e-9));
    CHECK(state.p[c][c] == doctest::Approx(variance).epsilon(1e-9));
    CHECK(state.p[o][o] == doctest::Approx(variance).epsilon(1e-9));
    CHECK(std::abs(state.p[c][o]) < 1e-12 * variance);
  }
}

TEST_CASE("an earth-fixed disturbance keeps its direction while the boat turns") {
  OnboardBoat b = boat(DisturbanceFrame::kEarth);
  b.current[0] = b.current[1] = 0.0;
  std::fill(b.coefficient, b.coefficient + kMaxCoefficients, 0.0);  // no drag, no thrust
  b.noise.memory = 1e9;
  StateEstimate state;
  state.x[5] = 2.0;  // [rad/s]
  state.x[6] = 0.1;  // [m/s^2]
  for (int i = 0; i < kFilterStates; ++i) state.p[i][i] = 1e-4;
  for (int i = 0; i < 200; ++i) REQUIRE(predict(b, kStep, kForce, state));
  CHECK(state.x[0] == doctest::Approx(0.5 * 0.1 * 4.0 * 4.0).epsilon(1e-4));
  CHECK(state.x[1] == doctest::Approx(0.0).epsilon(1e-4).scale(0.8));
  b.frame = DisturbanceFrame::kBody;
  StateEstimate turned;
  turned.x[5] = 2.0;
  turned.x[6] = 0.1;
  for (int i = 0; i < kFilterStates; ++i) turned.p[i][i] = 1e-4;
  for (int i = 0; i < 200; ++i) REQUIRE(predict(b, kStep, kForce, turned));
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
