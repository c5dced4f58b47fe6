// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include "boats.hpp"
#include "onboard.hpp"

using namespace seatrial;
using boats::Worst;

namespace {

constexpr double kForce[3][kMaxForces] = {{0.5, -0.3, 0.4}, {0.52, -0.2, 0.3}, {0.53, -0.1, 0.2}};
constexpr double kNoise[kPose][kPose] = {{4e-4, 1e-5, 0.0}, {1e-5, 9e-4, 2e-5}, {0.0, 2e-5, 1e-3}};
constexpr double kStep = 0.02;  // [s]

/// Nothing is unknown but the parameters.
OnboardBoat only_doubted(DisturbanceFrame frame) {
  OnboardBoat b = onboard::model().boat;
  b.frame = frame;
  b.noise.walk_linear = b.noise.walk_yaw = 0.0;
  b.noise.disturbance_linear = b.noise.disturbance_yaw = 0.0;
  return b;
}

/// The coefficients as one cause has them wrong, so many times.
OnboardBoat other(const OnboardBoat& boat, int cause, double share) {
  OnboardBoat b = boat;
  for (int i = 0; i < b.structure.n_coefficients; ++i) {
    b.coefficient[i] += share * b.considered.coefficient[i][cause];
  }
  return b;
}

double product(const StateEstimate& b, int i, int j) {
  double sum = 0.0;
  for (int k = 0; k < kMostConsidered; ++k) sum += b.d[i][k] * b.d[j][k];
  return sum;
}

}  // namespace

TEST_CASE("the effect of a principal error is that of other coefficients") {
  constexpr double kOff = 1e-3;
  for (const auto frame : {DisturbanceFrame::kEarth, DisturbanceFrame::kBody}) {
    const OnboardBoat boat = only_doubted(frame);
    StateEstimate state;
    state.x[2] = 0.7;
    state.x[3] = 0.2;
    state.x[kStates] = 0.02;
    StateEstimate ahead[kMostConsidered];
    StateEstimate back[kMostConsidered];
    std::fill(ahead, ahead + kMostConsidered, state);
    std::fill(back, back + kMostConsidered, state);
    for (int step = 0; step < 200; ++step) {
      predict(boat, kStep, kForce, state);
      for (int k = 0; k < kMostConsidered; ++k) {
        predict(other(boat, k, kOff), kStep, kForce, ahead[k]);
        predict(other(boat, k, -kOff), kStep, kForce, back[k]);
      }
    }
    for (int i = 0; i < kStates; ++i) {
      double largest = 0.0;
      for (int k = 0; k < kMostConsidered; ++k) {
        largest = std::max(largest, std::abs(state.d[i][k]));
      }
      REQUIRE(largest > 0.0);
      for (int k = 0; k < kMostConsidered; ++k) {
        const double want = (ahead[k].x[i] - back[k].x[i]) / (2.0 * kOff);
        CHECK(std::abs(state.d[i][k] - want) < 0.01 * largest);
      }
    }
  }
}

TEST_CASE("the covariance is that of the principal errors, where nothing else is uncertain") {
  const OnboardBoat boat = only_doubted(DisturbanceFrame::kEarth);
  StateEstimate state;
  for (int i = 0; i < 6; ++i) state.p[i][i] = 1e-30;
  for (int step = 0; step < 200; ++step) predict(boat, kStep, kForce, state);
  for (int i = 0; i < kStates; ++i) {
    for (int j = 0; j < kStates; ++j) {
      const double size = std::sqrt(state.p[i][i] * state.p[j][j]);
      CHECK(std::abs(state.p[i][j] - product(state, i, j)) < 1e-9 * size);
    }
  }
}

TEST_CASE(
    "a pose corrects the state by Schmidt's gain, and what it has in common with the causes") {
  for (const OnboardModel& m :
       {onboard::model(), onboard::coloured_model(), onboard::swinging_model()}) {
    const bool coloured = m.boat.noise.coloured();
    StateEstimate state;
    detail::reset_to_unknown(m, state);
    PoseSample at;
    for (int i = 0; i < kPose; ++i) std::copy(kNoise[i], kNoise[i] + kPose, at.noise[i]);
    detail::reset_pose(m.boat.noise, at, state);
    for (int step = 0; step < 200; ++step) {
      REQUIRE(predict(m.boat, kStep, kForce, state));
    }
    const double eta[kPose] = {state.x[0] + 0.01, state.x[1], state.x[2]};
    const StateEstimate before = state;
    const Innovation found = innovation(before, eta, kNoise);
    update(found, kNoise, state);
    Worst worst;
    for (int i = 0; i < before.n; ++i) {
      double gain[kPose] = {};  // row of P H' S^-1
      for (int k = 0; k < kPose; ++k) {
        const double ph = before.p[i][k] + (coloured ? before.p[i][kFilterStates + k] : 0.0);
        for (int l = 0; l < kPose; ++l) gain[l] += ph * found.inverse[k][l];
      }
      for (int c = 0; c < kMostConsidered; ++c) {
        double want = before.d[i][c];
        for (int k = 0; k < kPose; ++k) {
          want -= gain[k] * (before.d[k][c] + (coloured ? before.d[kFilterStates + k][c] : 0.0));
        }
        worst.see(state.d[i][c], want);
      }
    }
    CHECK(worst.value() < 1e-12);
    for (int i = 0; i < kStates; ++i) CHECK(product(state, i, i) < state.p[i][i]);
  }
}

TEST_CASE("after a reset of the pose its covariance with the principal errors is zero") {
  const OnboardModel m = onboard::model();
  StateEstimate state;
  detail::reset_to_unknown(m, state);
  for (int step = 0; step < 50; ++step) REQUIRE(predict(m.boat, kStep, kForce, state));
  PoseSample at;
  for (int i = 0; i < kPose; ++i) at.noise[i][i] = 1e-4;
  detail::reset_pose(m.boat.noise, at, state);
  for (int k = 0; k < kMostConsidered; ++k) {
    for (int i = 0; i < kPose; ++i) CHECK(state.d[i][k] == 0.0);
  }
  CHECK(product(state, 3, 3) > 0.0);
}
