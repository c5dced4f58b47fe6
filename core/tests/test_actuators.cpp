// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include "boats.hpp"
#include "chain_by_hand.hpp"
#include "seatrial/actuators/chain.hpp"

using namespace seatrial;
using boats::Random;
using boats::Worst;

namespace {

const Chain kFull = boats::full_chain(Scheme::kMoorePenrose);

/// Of a single actuator: what the others are told plays no part.
double curve_with_slope(const Chain& c, const std::vector<double>& q, int k, double command,
                        double* slope) {
  double row[kMaxActuators];
  std::fill(row, row + kMaxActuators, std::nan(""));
  row[k] = command;
  return curve(c, q.data(), k, row, slope);
}

double curve_at(const Chain& c, const std::vector<double>& q, int k, double command) {
  return curve_with_slope(c, q, k, command, nullptr);
}

/// Commands well inside and outside the dead zone, on both sides.
std::vector<double> commands_off_the_edges() {
  std::vector<double> commands;
  for (int i = -19; i < 20; ++i) {
    const double x = 0.0625 * i;
    if (std::abs(x - 0.08) > 1e-3 && std::abs(x + 0.11) > 1e-3) commands.push_back(x);
  }
  return commands;
}

}  // namespace

TEST_CASE("full command gives the gain forward and gain times ratio in reverse") {
  const auto q = boats::full_constants();
  for (int k = 0; k < 4; ++k) {
    const double gain = q[static_cast<std::size_t>(boats::kGain0 + k)];
    CHECK(curve_at(kFull, q, k, 1.0) == doctest::Approx(gain).epsilon(1e-15));
    CHECK(curve_at(kFull, q, k, -1.0) == doctest::Approx(-0.7 * gain).epsilon(1e-15));
  }
  auto neutral = boats::plain_chain(Scheme::kMoorePenrose);
  CHECK(curve_at(neutral, q, 0, 1.0) == 1.0);
  CHECK(curve_at(neutral, q, 0, -0.37) == -0.37);
}

TEST_CASE("between its edges a thruster gives nothing and has no slope") {
  const auto q = boats::full_constants();
  for (const double command : {-0.11, -0.1, -0.01, 0.0, 0.01, 0.0799, 0.08}) {
    double slope[kMaxConstants] = {0.0};
    CHECK(curve_with_slope(kFull, q, 0, command, slope) == 0.0);
    for (const double s : slope) CHECK(s == 0.0);
  }
  CHECK(curve_at(kFull, q, 0, 0.0801) > 0.0);
  CHECK(curve_at(kFull, q, 0, -0.1101) < 0.0);
}

TEST_CASE("the curve is its definition: ratio ((|x| - edge) / (1 - edge))^power") {
  const auto q = boats::full_constants();
  Worst worst;
  for (const double x : commands_off_the_edges()) {
    for (int k = 0; k < 4; ++k) {
      worst.see(curve_at(kFull, q, k, x), boats::curve_by_hand(kFull, q, k, x));
    }
  }
  CHECK(worst.value() < 1e-15);
  // one value from a pocket calculator: 1.05 ((0.54 - 0.08) / 0.92)^1.3 = 1.05 * 0.5^1.3
  CHECK(curve_at(kFull, q, 0, 0.54) == doctest::Approx(1.05 * 0.40612619817811774));
}

TEST_CASE("the curve is continuous at its edges and at full command") {
  const auto q = boats::full_constants();
  for (const double edge : {0.08, -0.11, 1.0, -1.0}) {
    const double below = curve_at(kFull, q, 0, edge - 1e-9);
    const double above = curve_at(kFull, q, 0, edge + 1e-9);
    CHECK(std::abs(above - below) < 1e-8);
  }
}

TEST_CASE("the curve's slopes equal central differences for every constant") {
  const auto q = boats::full_constants();
  Worst worst;
  std::vector<bool> moved(boats::kConstants, false);
  for (const double x : commands_off_the_edges()) {
    for (int k = 0; k < 4; ++k) {
      double slope[kMaxConstants] = {0.0};
      const double value = curve_with_slope(kFull, q, k, x, slope);
      REQUIRE(value == curve_at(kFull, q, k, x));
      for (std::size_t i = 0; i < q.size(); ++i) {
        auto up = q;
        auto down = q;
        up[i] += 1e-6;
        down[i] -= 1e-6;
        const double want = (curve_at(kFull, up, k, x) - curve_at(kFull, down, k, x)) / 2e-6;
        worst.see(slope[i], want);
        moved[i] = moved[i] || std::abs(want) > 1e-3;
      }
    }
  }
  CHECK(worst.value() < 1e-8);
  for (const int i : {2, 3, 4, 5, 8, 9, 10, 11}) CHECK(moved[static_cast<std::size_t>(i)]);
}

TEST_CASE("slopes are added to what is there") {
  const auto q = boats::full_constants();
  double once[kMaxConstants] = {0.0};
  double twice[kMaxConstants] = {0.0};
  curve_with_slope(kFull, q, 1, -0.6, once);
  curve_with_slope(kFull, q, 1, -0.6, twice);
  curve_with_slope(kFull, q, 1, -0.6, twice);
  for (int i = 0; i < boats::kConstants; ++i) CHECK(twice[i] == 2.0 * once[i]);
  CHECK(once[boats::kEdgeReverse] != 0.0);
}

TEST_CASE("a table is joined by straight lines and held beyond its ends") {
  const Chain c = boats::direct_chain();  // (-1, -0.6) (-0.2, 0) (0.3, 0) (1, 1)
  const auto q = boats::direct_constants();
  const double command[] = {-1.5, -1.0, -0.6, -0.2, 0.1, 0.3, 0.65, 1.0, 3.0};
  const double thrust[] = {-0.6, -0.6, -0.3, 0.0, 0.0, 0.0, 0.5, 1.0, 1.0};
  for (int i = 0; i < 9; ++i) {
    CHECK(curve_at(c, q, 3, command[i]) == doctest::Approx(thrust[i]).epsilon(1e-14));
  }
  CHECK(std::isnan(curve_at(c, q, 3, std::nan(""))));
}

TEST_CASE("of a table only the gain has a slope") {
  Chain c = boats::direct_chain();
  const auto q = boats::direct_constants();
  c.actuators[3].gain = 5;
  double slope[kMaxConstants] = {0.0};
  CHECK(curve_with_slope(c, q, 3, 0.65, slope) == doctest::Approx(1.2 * 0.5));
  for (int i = 0; i < 5; ++i) CHECK(slope[i] == 0.0);
  CHECK(slope[5] == doctest::Approx(0.5));
}

TEST_CASE("the scale multiplies by (s / reference)^power, with its slope") {
  auto q = boats::full_constants();
  const double volts[] = {14.4};
  double slope[kMaxConstants] = {0.0};
  const double got = multiplier(kFull, q.data(), 2, volts, slope);
  CHECK(got == doctest::Approx(std::exp(1.7 * std::log(1.2))).epsilon(1e-14));
  auto up = q;
  auto down = q;
  up[boats::kScalePower] += 1e-6;
  down[boats::kScalePower] -= 1e-6;
  const double want = (multiplier(kFull, up.data(), 2, volts, nullptr) -
                       multiplier(kFull, down.data(), 2, volts, nullptr)) /
                      2e-6;
  for (int i = 0; i < boats::kConstants; ++i) {
    CHECK(slope[i] == doctest::Approx(i == boats::kScalePower ? want : 0.0).epsilon(1e-8));
  }
  CHECK(multiplier(kFull, q.data(), 2, kFull.scale_reference, nullptr) == 1.0);

  Chain linear = kFull;
  linear.actuators[2].scale_power = -1;
  CHECK(multiplier(linear, q.data(), 2, volts, nullptr) == doctest::Approx(1.2));
  const double off[] = {0.0};
  CHECK(multiplier(kFull, q.data(), 2, off, nullptr) == 0.0);
  const Chain none = boats::plain_chain(Scheme::kMoorePenrose);
  CHECK(multiplier(none, q.data(), 2, nullptr, nullptr) == 1.0);
}

TEST_CASE("a lag leaves exp(-h / lag) of the way, and none leaves nothing") {
  auto q = boats::full_constants();
  CHECK(decay(kFull, q.data(), 0, 0.08 * std::log(2.0)) == doctest::Approx(0.5).epsilon(1e-14));
  CHECK(decay(kFull, q.data(), 0, 0.0) == 1.0);
  q[boats::kLag] = 0.0;
  CHECK(decay(kFull, q.data(), 0, 0.01) == 0.0);
  q[boats::kLag] = -0.1;
  CHECK(decay(kFull, q.data(), 0, 0.01) == 0.0);
  CHECK(decay(boats::full_chain(Scheme::kMoorePenrose, false), q.data(), 0, 0.01) == 0.0);
}

TEST_CASE("a level after two waits is the level after their sum") {
  const auto q = boats::full_constants();
  Thrust f;
  f.level[1] = -0.4;
  f.target[1] = 0.9;
  const double whole = level_after(kFull, q.data(), f, 1, 0.13);
  f.level[1] = level_after(kFull, q.data(), f, 1, 0.05);
  CHECK(level_after(kFull, q.data(), f, 1, 0.08) == doctest::Approx(whole).epsilon(1e-14));
  CHECK(whole == doctest::Approx(0.9 - 1.3 * std::exp(-0.13 / 0.08)).epsilon(1e-14));
}

TEST_CASE("forces are T times the scaled levels") {
  const auto q = boats::full_constants();
  Random random(31);
  Thrust f;
  random.fill(f.level, 4, -1.0, 1.0);
  random.fill(f.target, 4, -1.0, 1.0);
  random.fill(f.multiplier, 4, 0.5, 1.5);
  double force[3];
  forces_after(kFull, q.data(), f, 0.03, force);
  for (int j = 0; j < 3; ++j) {
    double want = 0.0;
    for (int k = 0; k < 4; ++k) {
      const double gone = 1.0 - std::exp(-0.03 / 0.08);
      const double level = f.level[k] + (f.target[k] - f.level[k]) * gone;
      want += 0.5 * boats::kSigns[j][k] * f.multiplier[k] * level;
    }
    CHECK(force[j] == doctest::Approx(want).epsilon(1e-13));
  }
}

TEST_CASE("a lag gives its exact impulse and way over a step, however short it is beside it") {
  for (const double x : {1e-6, 9.9e-3, 1.01e-2, 0.3, 5.0, 400.0}) {
    LagDecay slope;
    const LagDecay f = lag_decay(x, &slope);
    const double mean = -std::expm1(-x) / x;
    double moment = 0.0;  // of (1 - s) exp(-x s), by the midpoint rule on a mesh that is fine at 0
    for (int i = 0; i < 200000; ++i) {
      const double s0 = std::pow(i / 200000.0, 3);
      const double s1 = std::pow((i + 1) / 200000.0, 3);
      const double s = 0.5 * (s0 + s1);
      moment += (s1 - s0) * (1.0 - s) * std::exp(-x * s);
    }
    CHECK((f.begin + 4.0 * f.middle + f.end) / 6.0 == doctest::Approx(mean).epsilon(1e-12));
    CHECK((f.begin + 2.0 * f.middle) / 6.0 == doctest::Approx(moment).epsilon(1e-8));
    const double d = 1e-4 * x;
    const LagDecay up = lag_decay(x + d);
    const LagDecay down = lag_decay(x - d);
    CHECK(slope.end == doctest::Approx((up.end - down.end) / (2 * d)).epsilon(1e-6));
    CHECK(slope.middle == doctest::Approx((up.middle - down.middle) / (2 * d)).epsilon(1e-5));
    const double w = std::min(0.5 * x, 1e-3);  // wider: it hardly moves where the step is short
    const double begins = (lag_decay(x + w).begin - lag_decay(x - w).begin) / (2 * w);
    CHECK(std::abs(slope.begin - begins) < 1e-7);
  }
  const LagDecay none = lag_decay(0.0);
  CHECK(none.begin == 1.0);
  CHECK(none.middle == 1.0);
  CHECK(none.end == 1.0);
}
