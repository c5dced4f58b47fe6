// SPDX-License-Identifier: MIT
// Correlated pose errors, from the first pose to a SLAM that jumps; the Kalman filter's
// own steps are in test_ekf.cpp.
#include <doctest/doctest.h>

#include <memory>

#include "onboard.hpp"

using namespace seatrial;
using boats::Random;
using onboard::coloured_model;
using onboard::swinging_model;

namespace {

PoseSample sample(const OnboardModel& m, double x, double y, double psi) {
  PoseSample pose;
  const double eta[kPose] = {x, y, psi};
  std::copy(eta, eta + kPose, pose.eta);
  for (int i = 0; i < kPose; ++i) pose.noise[i][i] = m.boat.noise.white_variance(i);
  return pose;
}

/// A boat at rest, after its first pose.
PredictorState begun(const OnboardModel& m) {
  PredictorState now;
  detail::reset_to_unknown(m, now.state);
  update_by_pose(m, sample(m, 1.0, 2.0, 0.3), now);
  return now;
}

/// Whether the coloured noise is as at the start, but for its correlation with the pose.
bool colour_is_new(const OnboardModel& m, const StateEstimate& b) {
  for (int i = 0; i < kPose; ++i) {
    const int c = kFilterStates + i;
    if (b.x[c] != 0.0 || b.p[c][c] != m.boat.noise.colour_variance(i)) return false;
    for (int j = kPose; j < kOscillatingStates; ++j) {
      if (j != c && b.p[c][j] != 0.0) return false;
    }
    const int other = kColouredStates + i;
    if (b.oscillating() && b.p[other][other] != m.boat.noise.colour_variance(i)) return false;
  }
  return true;
}

}  // namespace

TEST_CASE("many poses at one time average out the white noise; the coloured noise remains") {
  const OnboardModel m = coloured_model();
  PredictorState now = begun(m);
  constexpr int kPoses = 400;
  for (int i = 0; i < kPoses; ++i) update_by_pose(m, sample(m, 1.0, 2.0, 0.3), now);
  const StateEstimate& b = now.state;
  for (int i = 0; i < kPose; ++i) {
    const double white = m.boat.noise.white_variance(i);
    CHECK(b.p[i][i] == doctest::Approx(m.boat.noise.colour_variance(i)).epsilon(1e-3));
    const int c = kFilterStates + i;
    const double predicted = b.p[i][i] + b.p[i][c] + b.p[c][i] + b.p[c][c];  // of H P H'
    CHECK(predicted == doctest::Approx(white / kPoses).epsilon(1e-2));
  }
  CHECK(onboard::positive(b.p, b.n));
}

TEST_CASE("the first pose has the uncertainty of one pose") {
  for (const OnboardModel& m : {coloured_model(), swinging_model()}) {
    const StateEstimate b = begun(m).state;
    CHECK(b.n == (m.boat.noise.oscillating() ? kOscillatingStates : kColouredStates));
    CHECK(colour_is_new(m, b));
    for (int i = 0; i < kPose; ++i) {
      const double colour = m.boat.noise.colour_variance(i);
      const double all = colour + m.boat.noise.white_variance(i);
      CHECK(b.p[i][i] == doctest::Approx(9.0 * all));  // three standard deviations of one
      CHECK(b.p[i][kFilterStates + i] == -colour);     // eta = x + c + white
    }
    CHECK(onboard::positive(b.p, b.n));
  }
}

TEST_CASE("where poses overrule the filter, their errors begin anew") {
  for (OnboardModel m : {coloured_model(), swinging_model()}) {
    m.votes = 3;
    m.votes_for = 0.0;
    PredictorState now = begun(m);
    Random random(5);
    for (int i = 0; i < 20; ++i) {
      propagate(m, 0.05, now);
      update_by_pose(m, sample(m, 1.0 + random(-0.01, 0.01), 2.0, 0.3), now);
    }
    CHECK_FALSE(colour_is_new(m, now.state));
    const PoseSample far = sample(m, 3.0, 2.0, 0.3);
    update_by_pose(m, far, now);
    CHECK(now.votes == 1);
    CHECK(colour_is_new(m, now.alternative));
    CHECK(onboard::positive(now.alternative.p, now.alternative.n));
    CHECK(now.alternative.x[0] == 3.0);
    update_by_pose(m, far, now);
    update_by_pose(m, far, now);
    CHECK(now.reinitialised == now.time);
    CHECK(now.state.x[0] == doctest::Approx(3.0));
    CHECK(onboard::positive(now.state.p, now.state.n));
  }
}

TEST_CASE("a heading that is lost, and a model that ran away, begin them anew, too") {
  for (const OnboardModel& m : {coloured_model(), swinging_model()}) {
    PredictorState lost = begun(m);
    update_by_pose(m, sample(m, 1.01, 2.0, 0.3), lost);
    lost.state.p[2][2] = 4.0;
    update_by_pose(m, sample(m, 5.0, 2.0, 2.0), lost);
    CHECK(lost.reinitialised == lost.time);
    CHECK(colour_is_new(m, lost.state));
    PredictorState gone = begun(m);
    update_by_pose(m, sample(m, 1.01, 2.0, 0.3), gone);
    reset_diverged(m, gone.state, gone);
    CHECK(colour_is_new(m, gone.state));
    CHECK(gone.state.n == (m.boat.noise.oscillating() ? kOscillatingStates : kColouredStates));
  }
}

TEST_CASE(
    "of a pose's own covariance the white part is what the coloured noise leaves; correlations "
    "stay") {
  NoiseParameters n;
  n.position = 0.002;
  n.heading = 0.001;
  const double own[kPose][kPose] = {{25e-6, 6e-6, 0.0}, {6e-6, 9e-6, -1e-7}, {0.0, -1e-7, 4e-7}};
  double noise[kPose][kPose];
  const auto leave = [&] {
    std::copy(&own[0][0], &own[0][0] + std::ptrdiff_t{kPose} * kPose, &noise[0][0]);
    detail::keep_white_part(n, noise);
  };
  leave();  // nothing is correlated: all of it is white
  CHECK(onboard::same_bits(&noise[0][0], &own[0][0], kPose * kPose));
  n.colour_position = 0.003;
  n.colour_heading = 0.003;
  leave();
  CHECK(noise[0][0] == doctest::Approx(25e-6 - 9e-6));
  CHECK(noise[1][1] == doctest::Approx(4e-6));  // not below the model's
  CHECK(noise[2][2] == doctest::Approx(4e-7));  // it says that it is better than that
  for (int i = 0; i < kPose; ++i) {
    for (int j = 0; j < kPose; ++j) {
      const double was = own[i][j] / std::sqrt(own[i][i] * own[j][j]);
      CHECK(noise[i][j] / std::sqrt(noise[i][i] * noise[j][j]) == doctest::Approx(was));
    }
  }
  CHECK(onboard::positive(noise));
}

TEST_CASE("a pose with the model's own covariance counts as one without") {
  const OnboardModel m = coloured_model();
  auto plain = std::make_unique<Predictor>(m);
  auto told = std::make_unique<Predictor>(m);
  double total[kPose][kPose] = {};
  for (int i = 0; i < kPose; ++i) {
    total[i][i] = m.boat.noise.white_variance(i) + m.boat.noise.colour_variance(i);
  }
  for (const onboard::Input& in : onboard::drive(4, 5.0, onboard::kMemory)) {
    onboard::give(*plain, in);
    in.pose ? told->pose(in.time, in.values, &total[0][0]) : told->command(in.time, in.values);
  }
  const Estimate a = plain->at(5.0);
  const Estimate b = told->at(5.0);
  for (int i = 0; i < kStates; ++i) {
    CHECK(a.covariance[i][i] == doctest::Approx(b.covariance[i][i]).epsilon(1e-9));
  }
}
