// SPDX-License-Identifier: MIT
// The way since the start: against closed forms, and its covariance against many drives.
#include <doctest/doctest.h>

#include <cmath>

#include "onboard.hpp"
#include "seatrial/onboard/odom_integrator.hpp"

using namespace seatrial;  // NOLINT(google-build-using-namespace)

namespace {

const double kNothing[kAxes][kAxes] = {};
const double kSecond[kAxes] = {1.0, 1.0, 1.0};

}  // namespace

TEST_CASE("a way and its inverse lead nowhere") {
  const double a[kPose] = {1.5, -0.7, 2.9};
  double back[kPose];
  double none[kPose];
  inverse(a, back);
  compose(a, back, none);
  for (const double value : none) CHECK(std::abs(value) < 1e-15);
  compose(back, a, none);
  for (const double value : none) CHECK(std::abs(value) < 1e-15);
}

TEST_CASE("a boat that turns at a steady speed comes back to where it was") {
  OdomIntegrator way;
  const double nu[kAxes] = {0.4, 0.1, 0.8};
  const double spread[kAxes][kAxes] = {{1e-8, 0, 0}, {0, 1e-8, 0}, {0, 0, 1e-8}};
  constexpr int kSteps = 400;
  const double h = 2.0 * kPi / nu[2] / kSteps;
  double farthest = 0.0;
  for (int i = 0; i < kSteps; ++i) {
    way.advance(h, nu, spread, kSecond);
    farthest = std::max(farthest, std::hypot(way.pose()[0], way.pose()[1]));
  }
  const double diameter = 2.0 * std::hypot(nu[0], nu[1]) / nu[2];
  CHECK(std::abs(farthest / diameter - 1.0) < 1e-4);
  for (int i = 0; i < kPose; ++i) CHECK(std::abs(way.pose()[i]) < 1e-9);
}

TEST_CASE("a covariance without a root moves the pose all the same and adds nothing to its own") {
  const double singular[kAxes][kAxes] = {{1e-4, 1e-4, 0}, {1e-4, 1e-4, 0}, {0, 0, 1e-6}};
  const double spread[kAxes][kAxes] = {{1e-4, 0, 0}, {0, 1e-4, 0}, {0, 0, 1e-6}};
  const double nu[kAxes] = {0.5, 0.0, 0.0};
  const double brief[kAxes] = {1e-3, 1e-3, 1e-3};  // [s] errors of one step are over in the next
  for (const auto& without : {kNothing, singular}) {
    OdomIntegrator way;
    way.advance(0.1, nu, spread, brief);
    const double heading = way.covariance()[2][2];
    const double along = way.covariance()[0][0];
    const double across = way.covariance()[1][1];
    for (int i = 0; i < 20; ++i) way.advance(0.1, nu, without, brief);
    CHECK(way.pose()[0] == doctest::Approx(0.5 * 0.1 * 21));
    CHECK(way.covariance()[2][2] == heading);
    CHECK(way.covariance()[0][0] == along);
    // the error of the heading turns the 1 m since then
    CHECK(way.covariance()[1][1] == doctest::Approx(across + heading));
  }
}

TEST_CASE("errors that last for ever grow as the time, short ones as its root") {
  const double sd = 0.02;
  const double nu[kAxes] = {0.0, 0.0, 0.0};
  const double spread[kAxes][kAxes] = {{sd * sd, 0, 0}, {0, sd * sd, 0}, {0, 0, 1e-20}};
  const double h = 0.02;
  const int n = 500;
  OdomIntegrator lasting;
  OdomIntegrator brief;
  const double memory = 0.1;
  const double each[kAxes] = {memory, memory, memory};
  const double ever[kAxes] = {1e12, 1e12, 1e12};
  for (int i = 0; i < n; ++i) {
    lasting.advance(h, nu, spread, ever);
    brief.advance(h, nu, spread, each);
  }
  const double length = h * n;
  CHECK(std::sqrt(lasting.covariance()[0][0]) == doctest::Approx(sd * length).epsilon(1e-6));
  // the exact sum of a discrete Markov chain's covariances
  const double a = std::exp(-h / memory);
  const double sum =
      (1.0 + a) / (1.0 - a) - 2.0 * a * (1.0 - std::pow(a, n)) / (n * (1.0 - a) * (1.0 - a));
  CHECK(std::sqrt(brief.covariance()[1][1]) ==
        doctest::Approx(sd * h * std::sqrt(n * sum)).epsilon(1e-6));
}

TEST_CASE("the covariance is that of many drives with such errors") {
  const double memory[kAxes] = {0.7, 0.2, 1.5};
  const double h = 0.04;
  constexpr int kSteps = 75;
  constexpr int kDrives = 4000;
  const double root[kAxes][kAxes] = {{0.02, 0, 0}, {-0.01, 0.015, 0}, {0.01, 0.02, 0.03}};
  double spread[kAxes][kAxes] = {};
  for (int i = 0; i < kAxes; ++i) {
    for (int j = 0; j < kAxes; ++j) {
      for (int k = 0; k < kAxes; ++k) spread[i][j] += root[i][k] * root[j][k];
    }
  }
  const auto truth = [](double t, double* nu) {
    nu[0] = 0.3 + 0.1 * std::sin(t);
    nu[1] = 0.1 * std::cos(2.0 * t);
    nu[2] = 0.5 * std::sin(0.7 * t);
  };
  boats::Random random(7);
  OdomIntegrator exact;
  for (int i = 0; i < kSteps; ++i) {
    double nu[kAxes];
    truth(h * i, nu);
    exact.advance(h, nu, spread, memory);
  }
  double stays[kAxes];
  for (int k = 0; k < kAxes; ++k) stays[k] = std::exp(-h / memory[k]);
  double sum[kPose][kPose] = {};
  for (int drive = 0; drive < kDrives; ++drive) {
    OdomIntegrator way;
    double w[kAxes];
    for (double& value : w) value = onboard::normal(random);
    for (int i = 0; i < kSteps; ++i) {
      double nu[kAxes];
      truth(h * i, nu);
      for (int a = 0; a < kAxes; ++a) {
        for (int k = 0; k < kAxes; ++k) nu[a] += root[a][k] * w[k];
      }
      way.advance(h, nu, spread, memory);
      for (int k = 0; k < kAxes; ++k) {
        w[k] = stays[k] * w[k] + std::sqrt(1.0 - stays[k] * stays[k]) * onboard::normal(random);
      }
    }
    double e[kPose];
    for (int i = 0; i < kPose; ++i) e[i] = way.pose()[i] - exact.pose()[i];
    for (int i = 0; i < kPose; ++i) {
      for (int j = 0; j < kPose; ++j) sum[i][j] += e[i] * e[j] / kDrives;
    }
  }
  for (int i = 0; i < kPose; ++i) {
    for (int j = 0; j < kPose; ++j) {
      const double scale = std::sqrt(exact.covariance()[i][i] * exact.covariance()[j][j]);
      CHECK(std::abs(sum[i][j] - exact.covariance()[i][j]) < 0.08 * scale);
    }
  }
}
