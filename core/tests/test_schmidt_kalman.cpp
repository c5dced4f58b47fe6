// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include "boats.hpp"
#include "onboard.hpp"

using namespace seatrial;
using boats::Worst;

namespace {

constexpr double kForce[3][kMaxForces] = {{0.5, -0.3, 0.4}, {0.52, -0.2, 0.3}, {0.53, -0.1, 0.2}};
constexpr double kNoise[kSeen][kSeen] = {{4e-4, 1e-5, 0.0}, {1e-5, 9e-4, 2e-5}, {0.0, 2e-5, 1e-3}};
constexpr double kStep = 0.02;  // [s]

/// Nothing is unknown but the parameters.
DrivenBoat only_doubted(DisturbanceFrame frame) {
  DrivenBoat b = onboard::model().boat;
  b.frame = frame;
  b.noise.walk_linear = b.noise.walk_yaw = 0.0;
  b.noise.disturbance_linear = b.noise.disturbance_yaw = 0.0;
  return b;
}

/// The coefficients as one cause has them wrong, so many times.
DrivenBoat other(const DrivenBoat& boat, int cause, double share) {
  DrivenBoat b = boat;
  for (int i = 0; i < b.structure.n_coefficients; ++i) {
    b.coefficient[i] += share * b.considered.coefficient[i][cause];
  }
  return b;
}

double product(const Belief& b, int i, int j) {
  double sum = 0.0;
  for (int k = 0; k < kMostConsidered; ++k) sum += b.by[i][k] * b.by[j][k];
  return sum;
}

}  // namespace

TEST_CASE("what a cause does is what boats of other coefficients do") {
  constexpr double kOff = 1e-3;
  for (const auto frame : {DisturbanceFrame::kEarth, DisturbanceFrame::kBody}) {
    const DrivenBoat boat = only_doubted(frame);
    Belief belief;
    belief.x[2] = 0.7;
    belief.x[3] = 0.2;
    belief.x[kStates] = 0.02;
    Belief ahead[kMostConsidered];
    Belief back[kMostConsidered];
    std::fill(ahead, ahead + kMostConsidered, belief);
    std::fill(back, back + kMostConsidered, belief);
    for (int step = 0; step < 200; ++step) {
      believe_step(boat, kStep, kForce, belief);
      for (int k = 0; k < kMostConsidered; ++k) {
        believe_step(other(boat, k, kOff), kStep, kForce, ahead[k]);
        believe_step(other(boat, k, -kOff), kStep, kForce, back[k]);
      }
    }
    for (int i = 0; i < kStates; ++i) {
      double largest = 0.0;
      for (int k = 0; k < kMostConsidered; ++k) {
        largest = std::max(largest, std::abs(belief.by[i][k]));
      }
      REQUIRE(largest > 0.0);
      for (int k = 0; k < kMostConsidered; ++k) {
        const double want = (ahead[k].x[i] - back[k].x[i]) / (2.0 * kOff);
        CHECK(std::abs(belief.by[i][k] - want) < 0.01 * largest);
      }
    }
  }
}

TEST_CASE("the covariance is what the causes make, where nothing else is unknown") {
  const DrivenBoat boat = only_doubted(DisturbanceFrame::kEarth);
  Belief belief;
  for (int i = 0; i < 6; ++i) belief.p[i][i] = 1e-30;
  for (int step = 0; step < 200; ++step) believe_step(boat, kStep, kForce, belief);
  for (int i = 0; i < kStates; ++i) {
    for (int j = 0; j < kStates; ++j) {
      const double size = std::sqrt(belief.p[i][i] * belief.p[j][j]);
      CHECK(std::abs(belief.p[i][j] - product(belief, i, j)) < 1e-9 * size);
    }
  }
}

TEST_CASE(
    "a pose corrects the state by Schmidt's gain, and what it has in common with the causes") {
  for (const OnboardModel& m :
       {onboard::model(), onboard::coloured_model(), onboard::swinging_model()}) {
    const bool coloured = m.boat.noise.coloured();
    Belief belief;
    detail::know_nothing(m, belief);
    PoseSample at;
    for (int i = 0; i < kSeen; ++i) std::copy(kNoise[i], kNoise[i] + kSeen, at.noise[i]);
    detail::place(m.boat.noise, at, belief);
    for (int step = 0; step < 200; ++step) {
      REQUIRE(believe_step(m.boat, kStep, kForce, belief));
    }
    const double eta[kSeen] = {belief.x[0] + 0.01, belief.x[1], belief.x[2]};
    const Belief before = belief;
    const Surprise found = surprise(before, eta, kNoise);
    correct(found, kNoise, belief);
    Worst worst;
    for (int i = 0; i < before.n; ++i) {
      double gain[kSeen];  // row of P H' S^-1
      for (int k = 0; k < kSeen; ++k) {
        gain[k] = before.p[i][k] + (coloured ? before.p[i][kBelieved + k] : 0.0);
      }
      detail::solve_root(found.root, gain);
      for (int c = 0; c < kMostConsidered; ++c) {
        double want = before.by[i][c];
        for (int k = 0; k < kSeen; ++k) {
          want -= gain[k] * (before.by[k][c] + (coloured ? before.by[kBelieved + k][c] : 0.0));
        }
        worst.see(belief.by[i][c], want);
      }
    }
    CHECK(worst.value() < 1e-12);
    for (int i = 0; i < kStates; ++i) CHECK(product(belief, i, i) < belief.p[i][i]);
  }
}

TEST_CASE("where the boat is placed anew the causes have no part in the pose") {
  const OnboardModel m = onboard::model();
  Belief belief;
  detail::know_nothing(m, belief);
  for (int step = 0; step < 50; ++step) REQUIRE(believe_step(m.boat, kStep, kForce, belief));
  PoseSample at;
  for (int i = 0; i < kSeen; ++i) at.noise[i][i] = 1e-4;
  detail::place(m.boat.noise, at, belief);
  for (int k = 0; k < kMostConsidered; ++k) {
    for (int i = 0; i < kSeen; ++i) CHECK(belief.by[i][k] == 0.0);
  }
  CHECK(product(belief, 3, 3) > 0.0);
}
