// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <vector>

#include "boats.hpp"
#include "onboard.hpp"

using namespace seatrial;
using boats::Random;
using boats::Worst;

namespace {

constexpr int kSizes[] = {kFilterStates, kColouredStates, kOscillatingStates};

/// A moving boat with a covariance in which all n states are correlated.
StateEstimate under_way(std::uint64_t seed, int n = kFilterStates) {
  Random random(seed);
  StateEstimate b;
  b.n = n;
  const double x[kOscillatingStates] = {0.3,  -0.2,  0.7,   0.25, -0.15, 0.5,   0.02, -0.03,
                                        0.05, 0.004, -0.01, 0.02, 0.01,  -0.02, 0.03};
  std::copy(x, x + n, b.x);
  double root[kOscillatingStates][kOscillatingStates];
  for (auto& row : root) random.fill(row, n, -0.1, 0.1);
  for (int i = 0; i < n; ++i) root[i][i] += 0.2;
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      for (int k = 0; k < n; ++k) b.p[i][j] += root[i][k] * root[j][k];
    }
  }
  return b;
}

constexpr double kPoseNoise[kPose][kPose] = {
    {4e-4, 1e-5, 0.0}, {1e-5, 9e-4, 2e-5}, {0.0, 2e-5, 1e-3}};

/// Whether what is not among its states is left alone.
bool rest_is_untouched(const StateEstimate& b) {
  for (int i = b.n; i < kOscillatingStates; ++i) {
    if (b.x[i] != 0.0) return false;
    for (int j = 0; j < kOscillatingStates; ++j) {
      if (b.p[i][j] != 0.0 || b.p[j][i] != 0.0) return false;
    }
  }
  return true;
}

constexpr double kForce[3][kMaxForces] = {{0.5, -0.3, 0.4}, {0.52, -0.2, 0.3}, {0.53, -0.1, 0.2}};
constexpr double kStep = 0.02;  // [s]

OnboardBoat boat(DisturbanceFrame frame) {
  OnboardBoat b = onboard::model().boat;
  b.frame = frame;
  b.current[0] = 0.05;
  b.current[1] = -0.02;
  return b;
}

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

using Dense = std::vector<std::vector<double>>;

/// By Gauss and Jordan; of a positive definite matrix.
Dense inverse(Dense a) {
  const std::size_t n = a.size();
  for (std::size_t k = 0; k < n; ++k) {
    const double pivot = 1.0 / a[k][k];
    a[k][k] = 1.0;
    for (double& x : a[k]) x *= pivot;
    for (std::size_t i = 0; i < n; ++i) {
      if (i == k) continue;
      const double factor = a[i][k];
      a[i][k] = 0.0;
      for (std::size_t j = 0; j < n; ++j) a[i][j] -= factor * a[k][j];
    }
  }
  return a;
}

/// The first n rows and columns.
template <int N>
Dense dense(const double (&from)[N][N], int n = N) {
  Dense out;
  for (int i = 0; i < n; ++i) out.emplace_back(from[i], from[i] + n);
  return out;
}

/// d measured pose_k / d state_i.
double measures(int k, std::size_t i) {
  const bool pose = i == static_cast<std::size_t>(k);
  return pose || i == static_cast<std::size_t>(kFilterStates + k) ? 1.0 : 0.0;
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

TEST_CASE("a correction is Bayes' rule: information adds up") {
  const Dense precision = inverse(dense(kPoseNoise));
  for (const int n : kSizes) {
    StateEstimate b = under_way(5, n);
    const StateEstimate before = b;
    const double off[kPose] = {0.01, -0.02, 0.03};
    double eta[kPose];
    for (int i = 0; i < kPose; ++i) {
      eta[i] = off[i] + b.x[i] + (b.coloured() ? b.x[kFilterStates + i] : 0.0);
    }
    eta[2] += 2.0 * kPi;
    const Innovation found = innovation(b, eta, kPoseNoise);
    update(found, kPoseNoise, b);
    CHECK(onboard::positive(b.p, n));
    CHECK(rest_is_untouched(b));
    Dense information = inverse(dense(before.p, n));  // and H' R^-1 H is added
    std::vector<double> weighed(information.size());  // H' R^-1 e
    for (std::size_t i = 0; i < weighed.size(); ++i) {
      for (int k = 0; k < kPose; ++k) {
        for (int l = 0; l < kPose; ++l) {
          const double r = measures(k, i) * precision[k][l];
          weighed[i] += r * off[l];
          for (std::size_t j = 0; j < weighed.size(); ++j) {
            information[i][j] += r * measures(l, j);
          }
        }
      }
    }
    const Dense want = inverse(information);
    Worst worst;
    for (std::size_t i = 0; i < weighed.size(); ++i) {
      double moved = 0.0;
      for (std::size_t j = 0; j < weighed.size(); ++j) {
        worst.see(b.p[i][j], want[i][j]);
        moved += want[i][j] * weighed[j];
      }
      worst.see(b.x[i] - before.x[i], moved);
    }
    CHECK(worst.value() < 1e-13);
    // the square is e' S^-1 e, and S what the poses are predicted with
    double square = 0.0;
    Dense s = dense(kPoseNoise);
    for (int k = 0; k < kPose; ++k) {
      for (int l = 0; l < kPose; ++l) {
        for (std::size_t i = 0; i < weighed.size(); ++i) {
          for (std::size_t j = 0; j < weighed.size(); ++j) {
            s[k][l] += measures(k, i) * before.p[i][j] * measures(l, j);
          }
        }
      }
    }
    const Dense gate = inverse(s);
    for (int k = 0; k < kPose; ++k) {
      for (int l = 0; l < kPose; ++l) square += off[k] * gate[k][l] * off[l];
    }
    CHECK(found.nis == doctest::Approx(square).epsilon(1e-10));
  }
}

TEST_CASE(
    "an outlier moves the state as far as one at the limit, and reduces the covariance less") {
  for (const int n : kSizes) {
    const StateEstimate before = under_way(7, n);
    const auto moved = [&](double far, StateEstimate& b) {
      b = before;
      double eta[kPose] = {b.x[0] + far, b.x[1] - far, b.x[2] + 0.5 * far};
      for (int i = 0; i < kPose && b.coloured(); ++i) eta[i] += b.x[kFilterStates + i];
      const Innovation found = innovation(b, eta, kPoseNoise, 4.0);
      update(found, kPoseNoise, b);
      return std::sqrt(found.nis);
    };
    StateEstimate at;
    StateEstimate beyond;
    StateEstimate within;
    const double unit = moved(0.01, within) / 0.01;  // [sigma per m]
    CHECK(moved(4.0 / unit, at) == doctest::Approx(4.0));
    CHECK(moved(12.0 / unit, beyond) == doctest::Approx(12.0));
    for (int i = 0; i < n; ++i) {  // the gain falls with the square of the distance
      CHECK(beyond.x[i] - before.x[i] == doctest::Approx((at.x[i] - before.x[i]) / 3.0));
      CHECK(at.p[i][i] == doctest::Approx(within.p[i][i]));
      CHECK(before.p[i][i] - beyond.p[i][i] ==
            doctest::Approx((before.p[i][i] - at.p[i][i]) / 9.0).epsilon(1e-6));
    }
    CHECK(onboard::positive(beyond.p, n));
  }
}

TEST_CASE("a covariance stays one through steps and corrections of very different size") {
  const double tight[kPose][kPose] = {{1e-12, 0.0, 0.0}, {0.0, 1e-12, 0.0}, {0.0, 0.0, 1e-12}};
  const double errors[][3] = {{0.0, 0.02, 0.0},  {1e-5, 0.02, 0.0}, {0.1, 0.02, 0.0},
                              {1e-5, 60.0, 0.5}, {0.1, 60.0, 15.0}, {0.1, 0.1, 2.0}};
  for (const auto& [colour, lasts, turn] : errors) {
    OnboardBoat b = boat(DisturbanceFrame::kEarth);
    b.noise = {1e-4, 1e-4, 1e-6, 1e-6, 1e-5, 1e-5, 0.3, colour, colour, lasts, turn};
    const NoiseParameters& n = b.noise;
    StateEstimate state = under_way(6, n.oscillating() ? kOscillatingStates
                                       : n.coloured()  ? kColouredStates
                                                       : kFilterStates);
    for (int i = 0; i < 3000; ++i) {
      REQUIRE(predict(b, kStep, kForce, state));
      if (i % 3 == 0 && (i < 1000 || i > 2000)) {
        double eta[kPose] = {state.x[0], state.x[1], state.x[2]};
        for (int k = 0; k < kPose && n.coloured(); ++k) eta[k] += state.x[kFilterStates + k];
        update(innovation(state, eta, tight), tight, state);
      }
      REQUIRE(onboard::positive(state.p, state.n));
    }
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
