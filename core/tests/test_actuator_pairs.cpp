// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include "boats.hpp"
#include "chain_by_hand.hpp"
#include "seatrial/actuators/chain.hpp"

using namespace seatrial;
using boats::Random;
using boats::Worst;

namespace {

const Chain kPaired = boats::paired_chain();
const std::vector<double> kPairValues = boats::paired_constants();

double pair_at(const std::vector<double>& q, int k, double along, double across) {
  const double command[4] = {along, across, along, across};
  return curve(kPaired, q.data(), k, command, nullptr);
}

}  // namespace

TEST_CASE("a pair's thrust is along its vector, as long as the vector past the dead zone") {
  const auto& q = kPairValues;
  Random random(32);
  Worst worst;
  for (int i = 0; i < 500; ++i) {
    double row[4];
    random.fill(row, 4, -1.2, 1.2);
    for (int k = 0; k < 4; ++k) {
      worst.see(curve(kPaired, q.data(), k, row, nullptr),
                boats::target_by_hand(kPaired, q, k, row));
    }
  }
  CHECK(worst.value() < 1e-14);
}

TEST_CASE(
    "a pair without offset and dead zone passes what is shorter than 1, and limits the rest") {
  const std::vector<double> q = {0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0};
  CHECK(pair_at(q, 0, 0.0, 0.0) == 0.0);
  CHECK(pair_at(q, 0, 0.3, -0.4) == doctest::Approx(0.3).epsilon(1e-15));
  CHECK(pair_at(q, 1, 0.3, -0.4) == doctest::Approx(-0.4).epsilon(1e-15));
  CHECK(pair_at(q, 0, 1.0, 0.0) == 1.0);
  // both at full command: each gives 1 / sqrt(2)
  CHECK(pair_at(q, 0, 1.0, -1.0) == doctest::Approx(std::sqrt(0.5)).epsilon(1e-15));
  CHECK(pair_at(q, 1, 1.0, -1.0) == doctest::Approx(-std::sqrt(0.5)).epsilon(1e-15));
  CHECK(std::isnan(pair_at(q, 0, std::nan(""), 0.1)));
  CHECK(std::isnan(pair_at(q, 0, 0.1, std::nan(""))));
}

TEST_CASE("a pair gives nothing within its dead zone, which stands around minus the offset") {
  const auto& q = kPairValues;
  for (int i = 0; i < 12; ++i) {
    const double angle = 0.5 * i;
    for (const double length : {0.0, 0.1, 0.1999, 0.2001}) {
      const double p = length * std::cos(angle) - q[boats::kAlong];
      const double s = length * std::sin(angle) - q[boats::kAcross];
      const double size = std::hypot(pair_at(q, 2, p, -s), pair_at(q, 3, p, -s));
      if (length < 0.2) CHECK(size == 0.0);
      if (length > 0.2) CHECK(size == doctest::Approx(0.0001 / 0.8).epsilon(1e-6));
    }
  }
}

TEST_CASE("a pair is continuous at its dead zone and at its limit") {
  const double along = kPairValues[boats::kAlong];
  const double across = kPairValues[boats::kAcross];
  for (const double edge : {0.2, 1.0}) {
    for (int k = 0; k < 2; ++k) {
      double value[2];
      for (int side = 0; side < 2; ++side) {
        const double length = edge + (side == 0 ? -1e-9 : 1e-9);
        value[side] = pair_at(kPairValues, k, 0.6 * length - along, 0.8 * length - across);
      }
      CHECK(std::abs(value[1] - value[0]) < 1e-8);
    }
  }
}

TEST_CASE("a mirrored pair does to the mirrored command the mirrored thing") {
  auto q = kPairValues;
  q[boats::kPairGain] = 1.0;
  Random random(33);
  for (int i = 0; i < 50; ++i) {
    const double p = random(-1.2, 1.2);
    const double s = random(-1.2, 1.2);
    CHECK(pair_at(q, 2, p, -s) == pair_at(q, 0, p, s));
    CHECK(pair_at(q, 3, p, -s) == -pair_at(q, 1, p, s));
  }
}

TEST_CASE("a pair's slopes equal central differences for every constant") {
  const auto& q = kPairValues;
  Random random(34);
  Worst worst;
  double largest[boats::kPairConstants] = {0.0};
  for (int i = 0; i < 500; ++i) {
    const double p = random(-1.2, 1.2);
    const double s = random(-1.2, 1.2);
    for (int k = 0; k < 4; ++k) {
      const double across = k < 2 ? s + q[boats::kAcross] : -s + q[boats::kAcross];
      const double length = std::hypot(p + q[boats::kAlong], across);
      if (std::abs(length - 0.2) < 1e-4 || std::abs(length - 1.0) < 1e-4) continue;
      const double command[4] = {p, s, p, s};
      double slope[kMaxConstants] = {0.0};
      REQUIRE(curve(kPaired, q.data(), k, command, slope) == pair_at(q, k, p, s));
      for (int c = 0; c < boats::kPairConstants; ++c) {
        auto up = q;
        auto down = q;
        up[static_cast<std::size_t>(c)] += 1e-6;
        down[static_cast<std::size_t>(c)] -= 1e-6;
        const double want = (pair_at(up, k, p, s) - pair_at(down, k, p, s)) / 2e-6;
        worst.see(slope[c], want);
        largest[c] = std::max(largest[c], std::abs(want));
      }
    }
  }
  CHECK(worst.value() < 1e-8);
  for (const int c : {boats::kAlong, boats::kAcross, boats::kDead, boats::kPairGain}) {
    CHECK(largest[c] > 0.5);
  }
}

TEST_CASE("an incomplete pair is distinguished from a pair") {
  CHECK(pairs_are_whole(kPaired));
  CHECK(pairs_are_whole(boats::full_chain(Scheme::kMoorePenrose)));
  const auto broken = [](auto change) {
    Chain c = kPaired;
    change(c.actuators);
    return !pairs_are_whole(c);
  };
  CHECK(broken([](Actuator* a) { a[0].partner = 2; }));
  CHECK(broken([](Actuator* a) { a[0].partner = 0; }));
  CHECK(broken([](Actuator* a) { a[0].partner = 4; }));
  CHECK(broken([](Actuator* a) { a[0].partner = -1; }));
  CHECK(broken([](Actuator* a) { a[1].across = false; }));
  CHECK(broken([](Actuator* a) { a[1].offset_across = -1; }));
  CHECK(broken([](Actuator* a) { a[2].edge_forward = boats::kDead; }));
  CHECK(broken([](Actuator* a) { a[2].power = boats::kPairGain; }));
  CHECK(broken([](Actuator* a) { a[2].tabulated = true; }));
}
