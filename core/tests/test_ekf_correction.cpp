// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <vector>

#include "boats.hpp"
#include "filter_states.hpp"
#include "onboard.hpp"

using namespace seatrial;
using namespace filters;
using boats::Worst;

namespace {

constexpr double kPoseNoise[kPose][kPose] = {
    {4e-4, 1e-5, 0.0}, {1e-5, 9e-4, 2e-5}, {0.0, 2e-5, 1e-3}};

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
