// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include "boats.hpp"
#include "seatrial/actuators/allocation.hpp"

using namespace seatrial;
using boats::Random;
using boats::Worst;

namespace {

/// Table I and Eq. (11), column by column as printed; F_os on each thruster.
void table_one(double fu, double fv, double fr, double offset, double* f) {
  for (int k = 0; k < 4; ++k) f[k] = offset;
  if (fu > 0.0) {
    f[2] += std::abs(fu);
    f[3] += std::abs(fu);
  } else if (fu < 0.0) {
    f[0] += std::abs(fu);
    f[1] += std::abs(fu);
  }
  if (fv > 0.0) {
    f[0] += std::abs(fv);
    f[2] += std::abs(fv);
  } else if (fv < 0.0) {
    f[1] += std::abs(fv);
    f[3] += std::abs(fv);
  }
  if (fr > 0.0) {
    f[0] += std::abs(fr);
    f[3] += std::abs(fr);
  } else if (fr < 0.0) {
    f[1] += std::abs(fr);
    f[2] += std::abs(fr);
  }
}

/// A random command, in which some axes are at rest.
void random_command(Random& random, double* wrench) {
  for (int j = 0; j < 3; ++j) wrench[j] = random(0.0, 1.0) < 0.2 ? 0.0 : random(-1.0, 1.0);
}

/// Deviation of T f from alpha F over many random commands.
double worst_wrench(Scheme scheme, double limit, int* limited) {
  Chain c = boats::plain_chain(scheme);
  c.allocation.limit = limit;
  Random random(20);
  Worst worst;
  for (int n = 0; n < 1000; ++n) {
    double wrench[3];
    double f[kMaxActuators];
    double force[3];
    random_command(random, wrench);
    const double alpha = allocate(c.allocation, wrench, f);
    REQUIRE(alpha >= 0.0);
    REQUIRE(alpha <= 1.0);
    *limited += alpha < 1.0 ? 1 : 0;
    mix_forces(c, f, force);
    for (int j = 0; j < 3; ++j) worst.see(force[j], alpha * wrench[j]);
  }
  return worst.value();
}

}  // namespace

TEST_CASE("either scheme gives alpha F, limited or not") {
  int limited = 0;
  CHECK(worst_wrench(Scheme::kMoorePenrose, std::numeric_limits<double>::infinity(), &limited) <
        1e-15);
  CHECK(worst_wrench(Scheme::kAlwaysForward, std::numeric_limits<double>::infinity(), &limited) <
        1e-15);
  CHECK(limited == 0);
  CHECK(worst_wrench(Scheme::kMoorePenrose, 0.6, &limited) < 1e-15);
  CHECK(limited > 100);
  limited = 0;
  CHECK(worst_wrench(Scheme::kAlwaysForward, 1.0, &limited) < 1e-15);
  CHECK(limited > 100);
}

TEST_CASE("the limit of an allocation is reached when it is active, and never passed") {
  for (const Scheme scheme : {Scheme::kMoorePenrose, Scheme::kAlwaysForward}) {
    Chain c = boats::plain_chain(scheme);
    c.allocation.limit = 0.7;
    Random random(21);
    int limited = 0;
    for (int n = 0; n < 1000; ++n) {
      double wrench[3];
      double f[kMaxActuators];
      random_command(random, wrench);
      const double alpha = allocate(c.allocation, wrench, f);
      double largest = 0.0;
      for (int k = 0; k < 4; ++k) largest = std::max(largest, std::abs(f[k]));
      REQUIRE(largest <= 0.7 + 1e-15);
      if (alpha < 1.0) {
        ++limited;
        REQUIRE(largest == doctest::Approx(0.7).epsilon(1e-14));
      }
    }
    CHECK(limited > 50);
  }
}

TEST_CASE("Moore-Penrose takes the least effort of all that give the wrench") {
  const Chain c = boats::plain_chain(Scheme::kMoorePenrose);
  const double wrench[3] = {0.3, -0.7, 0.2};
  double f[kMaxActuators];
  CHECK(allocate(c.allocation, wrench, f) == 1.0);
  // what T does not see is [1 1 1 1]; the least effort has no part of it
  CHECK(f[0] + f[1] + f[2] + f[3] == doctest::Approx(0.0));
  CHECK(f[0] == doctest::Approx(0.5 * (-0.3 - 0.7 + 0.2)));
  CHECK(f[3] == doctest::Approx(0.5 * (0.3 + 0.7 + 0.2)));
}

TEST_CASE("always forward is Table I of the paper") {
  const Chain c = boats::plain_chain(Scheme::kAlwaysForward);
  Random random(22);
  Worst worst;
  for (int n = 0; n < 1000; ++n) {
    double wrench[3];
    double f[kMaxActuators];
    double want[4];
    random_command(random, wrench);
    REQUIRE(allocate(c.allocation, wrench, f) == 1.0);
    table_one(wrench[0], wrench[1], wrench[2], 0.12, want);
    for (int k = 0; k < 4; ++k) worst.see(f[k], want[k]);
  }
  CHECK(worst.value() < 1e-15);
}

TEST_CASE("always forward never drives a thruster under its offset") {
  Chain c = boats::plain_chain(Scheme::kAlwaysForward);
  for (const double limit : {0.12, 0.5, 1.0, std::numeric_limits<double>::infinity()}) {
    c.allocation.limit = limit;
    Random random(23);
    for (int n = 0; n < 500; ++n) {
      double wrench[3];
      double f[kMaxActuators];
      random_command(random, wrench);
      allocate(c.allocation, wrench, f);
      for (int k = 0; k < 4; ++k) {
        REQUIRE(f[k] >= 0.12);
        REQUIRE(f[k] <= limit + 1e-15);
      }
    }
  }
}

TEST_CASE("at rest every thruster of the always-forward scheme idles at the offset") {
  const Chain c = boats::plain_chain(Scheme::kAlwaysForward);
  const double still[3] = {0.0, 0.0, 0.0};
  double f[kMaxActuators];
  CHECK(allocate(c.allocation, still, f) == 1.0);
  for (int k = 0; k < 4; ++k) CHECK(f[k] == 0.12);
}

TEST_CASE("direct commands are passed on one by one and clipped one by one") {
  const Chain c = boats::direct_chain();
  const double command[5] = {0.3, -0.9, 0.8, 1.5, -0.1};
  double f[kMaxActuators];
  CHECK(allocate(c.allocation, command, f) == 1.0);
  const double want[5] = {0.3, -0.8, 0.8, 0.8, -0.1};
  for (int k = 0; k < 5; ++k) CHECK(f[k] == want[k]);
}

TEST_CASE("a command that is not a number is never turned into thrust") {
  const double lost[5] = {std::nan(""), 0.0, 0.0, 0.0, 0.0};
  double f[kMaxActuators] = {0.0};
  allocate(boats::direct_chain().allocation, lost, f);
  CHECK(std::isnan(f[0]));
  CHECK(f[1] == 0.0);
  for (const Scheme scheme : {Scheme::kMoorePenrose, Scheme::kAlwaysForward}) {
    Chain c = boats::plain_chain(scheme);
    c.allocation.limit = 1.0;
    allocate(c.allocation, lost, f);
    for (int k = 0; k < 4; ++k) CHECK(std::isnan(f[k]));
  }
}
