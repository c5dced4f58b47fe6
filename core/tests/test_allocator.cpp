// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include "boats.hpp"
#include "heap.hpp"
#include "no_exceptions.hpp"
#include "seatrial/control/allocator.hpp"

using namespace seatrial;
using boats::Random;
using boats::Worst;

namespace {

/// Thrusters at (x, y) pushing along an angle, with edges 0.08, limit 1 and idling at 0.12.
void add_thruster(AllocatorSetup& s, double x, double y, double angle) {
  const int k = s.effectiveness.n++;
  s.chain.allocation.n_actuators = s.effectiveness.n;
  s.effectiveness.column[k][0] = std::cos(angle);
  s.effectiveness.column[k][1] = std::sin(angle);
  s.effectiveness.column[k][2] = x * std::sin(angle) - y * std::cos(angle);
  s.chain.n_constants = 1;
  s.q[0] = 0.08;
  s.chain.actuators[k].edge_forward = 0;
  s.chain.actuators[k].edge_reverse = 0;
  s.limit[k] = 1.0;
  s.idle_forward[k] = s.idle_reverse[k] = 0.12;
}

/// MallARD: T is half the sign matrix of Table I.
AllocatorSetup mallard(AllocatorScheme scheme) {
  constexpr double signs[4][3] = {{-1, 1, 1}, {-1, -1, -1}, {1, 1, -1}, {1, -1, 1}};
  AllocatorSetup s;
  s.scheme = scheme;
  for (int k = 0; k < 4; ++k) {
    add_thruster(s, 0.0, 0.0, 0.0);
    for (int j = 0; j < 3; ++j) s.effectiveness.column[k][j] = 0.5 * signs[k][j];
  }
  return s;
}

/// Three around a circle, pushing along it.
AllocatorSetup triangle(AllocatorScheme scheme) {
  AllocatorSetup s;
  s.scheme = scheme;
  s.hysteresis = 0.05;
  for (int k = 0; k < 3; ++k) {
    const double a = 2.0 * std::acos(-1.0) / 3.0 * k;
    add_thruster(s, std::cos(a), std::sin(a), a + std::acos(0.0));
  }
  return s;
}

AllocatorSetup random_boat(Random& random, int n, AllocatorScheme scheme) {
  AllocatorSetup s;
  s.scheme = scheme;
  s.hysteresis = 0.02;
  for (int k = 0; k < n; ++k) {
    add_thruster(s, random(-1.0, 1.0), random(-1.0, 1.0), random(-3.2, 3.2));
  }
  return s;
}

void random_wrench(Random& random, double size, double* wrench) {
  for (int j = 0; j < 3; ++j) wrench[j] = random(-size, size);
}

constexpr AllocatorScheme kSchemes[] = {
    AllocatorScheme::kMoorePenrose, AllocatorScheme::kAlwaysForward, AllocatorScheme::kNullSpace,
    AllocatorScheme::kSignPattern, AllocatorScheme::kAutomatic};

}  // namespace

TEST_CASE("always forward is Table I and Eq. (11), where no curve is known") {
  AllocatorSetup s = mallard(AllocatorScheme::kAlwaysForward);
  s.q[0] = 0.0;
  Allocator a(s);
  REQUIRE(a.fault() == AllocatorFault::kOk);
  const Chain table_one = boats::plain_chain(Scheme::kAlwaysForward);
  Random random(1);
  Worst worst;
  for (int i = 0; i < 1000; ++i) {
    double wrench[3];
    double f[kMaxActuators];
    double want[kMaxActuators];
    random_wrench(random, 0.29, wrench);
    a.allocate(wrench, f);
    REQUIRE(allocate(table_one.allocation, wrench, want) == 1.0);
    for (int k = 0; k < 4; ++k) worst.see(f[k], want[k]);
  }
  CHECK(worst.value() < 1e-15);
}

TEST_CASE("every scheme gives the requested wrench, through the curves and within the limits") {
  for (const AllocatorScheme scheme : kSchemes) {
    Allocator a(mallard(scheme));
    REQUIRE(a.fault() == AllocatorFault::kOk);
    Random random(2);
    Worst worst;
    int limited = 0;
    for (int i = 0; i < 2000; ++i) {
      double wrench[3];
      double f[kMaxActuators];
      double given[3];
      random_wrench(random, 1.5, wrench);
      const Allotment out = a.allocate(wrench, f);
      limited += out.limited ? 1 : 0;
      a.wrench(f, given);
      for (int k = 0; k < 4; ++k) REQUIRE(std::abs(f[k]) <= 1.0);
      for (int j = 0; j < 3 && !out.held; ++j) worst.see(given[j], out.share[j] * wrench[j]);
    }
    CHECK(worst.value() < 1e-13);
    CHECK(limited > 20);
    CHECK(limited < 1980);
  }
}

TEST_CASE("a null-space bias keeps every thruster at or past its idle command, on its side") {
  Random random(3);
  int kept = 0;
  for (int boat = 0; boat < 40; ++boat) {
    Allocator a(random_boat(random, 4 + boat % 5, AllocatorScheme::kNullSpace));
    if (a.fault() != AllocatorFault::kOk) continue;
    ++kept;
    for (int i = 0; i < 200; ++i) {
      double wrench[3];
      double f[kMaxActuators];
      random_wrench(random, 1.0, wrench);
      a.allocate(wrench, f);
      for (int k = 0; k < a.setup().effectiveness.n; ++k) {
        REQUIRE(static_cast<double>(a.idle().side[k]) * f[k] >= 0.12 - 1e-12);
      }
    }
  }
  CHECK(kept > 25);
}

TEST_CASE("MallARD at rest idles all at the idle command, at four times its power") {
  for (const AllocatorScheme scheme : {AllocatorScheme::kNullSpace, AllocatorScheme::kAutomatic}) {
    Allocator a(mallard(scheme));
    const double still[3] = {};
    double f[kMaxActuators];
    a.allocate(still, f);
    for (int k = 0; k < 4; ++k) {
      CHECK(f[k] == doctest::Approx(0.12).epsilon(1e-12));
      CHECK(a.idle().side[k] == Side::kForward);
    }
    // thrust past the edge is (0.12 - 0.08) / (1 - 0.08) of full
    CHECK(a.idle().power == doctest::Approx(4.0 * std::pow(0.04 / 0.92, 1.5)).epsilon(1e-9));
    CHECK(a.power(f) == doctest::Approx(a.idle().power).epsilon(1e-12));
  }
}

TEST_CASE("three thrusters have no null space: their sides change, with hysteresis") {
  CHECK(Allocator(triangle(AllocatorScheme::kNullSpace)).fault() == AllocatorFault::kNullSpace);
  Allocator a(triangle(AllocatorScheme::kAutomatic));
  REQUIRE(a.fault() == AllocatorFault::kOk);
  CHECK(a.idle().n_switching == 3);
  double f[kMaxActuators];
  int changes = 0;
  double before = 1.0;
  for (int i = 0; i < 1000; ++i) {  // a yaw stick that trembles about zero: all thrusters alike
    const double wrench[3] = {0.0, 0.0, i % 2 == 0 ? 0.03 : -0.03};
    const Allotment out = a.allocate(wrench, f);
    CHECK(out.held == (i % 2 == 1));
    for (int k = 0; k < 3; ++k) CHECK(f[k] >= 0.08);  // at the edge, never inside
    changes += f[0] * before < 0.0 ? 1 : 0;
    before = f[0];
  }
  CHECK(changes == 0);
  const double turn[3] = {0.0, 0.0, -0.3};
  CHECK_FALSE(a.allocate(turn, f).held);
  for (int k = 0; k < 3; ++k) CHECK(f[k] == doctest::Approx(-0.08 - 0.92 * 0.1));
  a.reset();
  const double still[3] = {};
  a.allocate(still, f);
  for (int k = 0; k < 3; ++k) CHECK(f[k] == 0.08);
}

TEST_CASE("at the limits yaw has priority where configured, and directions stay otherwise") {
  AllocatorSetup s = mallard(AllocatorScheme::kMoorePenrose);
  const double wrench[3] = {1.6, 0.8, 1.2};
  double f[kMaxActuators];
  Allocator together(s);
  const Allotment all = together.allocate(wrench, f);
  CHECK(all.limited);
  CHECK(all.share[0] == all.share[2]);
  CHECK(all.share[0] == doctest::Approx(together.reach(wrench, 1.0)).epsilon(1e-12));

  s.rank[0] = s.rank[1] = 1;
  Allocator yaw_first(s);
  const Allotment out = yaw_first.allocate(wrench, f);
  CHECK(out.share[2] == 1.0);
  CHECK(out.share[0] == out.share[1]);
  CHECK(out.share[0] < all.share[0]);
  double given[3];
  yaw_first.wrench(f, given);
  CHECK(given[2] == doctest::Approx(1.2).epsilon(1e-12));
  CHECK(given[0] / given[1] == doctest::Approx(2.0).epsilon(1e-12));
  double largest = 0.0;
  for (int k = 0; k < 4; ++k) largest = std::max(largest, std::abs(f[k]));
  CHECK(largest == doctest::Approx(1.0).epsilon(1e-12));
}

TEST_CASE("what can't be allocated to is refused") {
  AllocatorSetup row;
  for (const double x : {-0.2, 0.0, 0.2}) add_thruster(row, x, 0.0, 0.0);
  CHECK(Allocator(row).fault() == AllocatorFault::kRank);
  AllocatorSetup two;
  add_thruster(two, 0.2, 0.0, 1.0);
  add_thruster(two, -0.2, 0.0, 1.0);
  CHECK(Allocator(two).fault() == AllocatorFault::kSize);
  AllocatorSetup wide = mallard(AllocatorScheme::kAutomatic);
  wide.limit[2] = 0.12;
  CHECK(Allocator(wide).fault() == AllocatorFault::kDeadZone);
  AllocatorSetup inside = mallard(AllocatorScheme::kAutomatic);
  inside.idle_forward[1] = 0.07;  // in the dead zone
  CHECK(Allocator(inside).fault() == AllocatorFault::kDeadZone);
  CHECK(Allocator(triangle(AllocatorScheme::kAlwaysForward)).fault() ==
        AllocatorFault::kAlwaysForward);
  AllocatorSetup flat = mallard(AllocatorScheme::kAutomatic);
  flat.chain.actuators[0].reverse_ratio = 1;
  flat.chain.n_constants = 2;
  flat.q[1] = 0.0;  // no thrust astern
  CHECK(Allocator(flat).fault() == AllocatorFault::kCurve);
}

TEST_CASE("an allocator works where exceptions are switched off") {
  CHECK(allocate_without_exceptions() == doctest::Approx(0.15).epsilon(1e-12));
}

TEST_CASE("a wrench that is not a number stops all thrusters, and nothing asks for memory") {
  Allocator a(triangle(AllocatorScheme::kAutomatic));
  double f[kMaxActuators] = {1.0, 1.0, 1.0};
  const double lost[3] = {0.1, std::nan(""), 0.0};
  CHECK_FALSE(a.allocate(lost, f).number);
  for (int k = 0; k < 3; ++k) CHECK(f[k] == 0.0);
  Random random(4);
  const long before = allocations;
  for (int i = 0; i < 1000; ++i) {
    double wrench[3];
    random_wrench(random, 1.0, wrench);
    a.allocate(wrench, f);
  }
  const Allocator fresh(triangle(AllocatorScheme::kAutomatic));
  CHECK(allocations == before);
}

TEST_CASE("two thrusters side by side have surge and yaw") {
  AllocatorSetup setup;
  setup.scheme = AllocatorScheme::kMoorePenrose;
  setup.rank[0] = 1;  // yaw first
  setup.rank[1] = 1;
  add_thruster(setup, -0.5, 0.4, 0.0);
  add_thruster(setup, -0.5, -0.4, 0.0);
  Allocator allocator(setup);
  REQUIRE(allocator.fault() == AllocatorFault::kOk);
  double command[kMaxActuators];
  double given[kWrenchAxes];
  const double wrench[kWrenchAxes] = {0.5, 0.0, 0.2};  // y = (F_u -+ F_r / 0.4) / 2
  const long before = allocations.load();
  Allotment out = allocator.allocate(wrench, command);
  CHECK(allocations.load() == before);
  CHECK_FALSE(out.limited);
  CHECK(command[0] == doctest::Approx(0.0));
  CHECK(command[1] == doctest::Approx(0.08 + 0.92 * 0.5));
  const double sideways[kWrenchAxes] = {0.5, 0.3, 0.2};
  out = allocator.allocate(sideways, command);
  CHECK(out.limited);
  CHECK(out.share[1] == 0.0);
  CHECK(out.share[0] == 1.0);
  allocator.wrench(command, given);
  for (int i = 0; i < kWrenchAxes; ++i) CHECK(given[i] == doctest::Approx(wrench[i]));
  const double most[kWrenchAxes] = {2.0, 0.0, 0.4};  // beside half the yaw half the surge is left
  out = allocator.allocate(most, command);
  CHECK(out.share[2] == 1.0);
  CHECK(out.share[0] == doctest::Approx(0.5));
  const double axes[3][kWrenchAxes] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  CHECK(allocator.reach(axes[0], 1e6) == doctest::Approx(2.0));
  CHECK(allocator.reach(axes[1], 1e6) == 0.0);
  CHECK(allocator.reach(axes[2], 1e6) == doctest::Approx(0.8));
}

TEST_CASE("without sway thrust, too: surge and yaw must be independent") {
  AllocatorSetup setup;
  setup.scheme = AllocatorScheme::kMoorePenrose;
  add_thruster(setup, 0.0, 0.4, 0.0);
  CHECK(Allocator(setup).fault() == AllocatorFault::kSize);
  add_thruster(setup, 0.3, 0.4, 0.0);  // in line with the first
  CHECK(Allocator(setup).fault() == AllocatorFault::kRank);
}
