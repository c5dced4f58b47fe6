// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <tuple>

#include "boats.hpp"
#include "seatrial/model/structure.hpp"

using namespace seatrial;
using boats::add;

TEST_CASE("the boats of these tests are accepted") {
  CHECK(check(boats::mallard()) == StructureFault::kOk);
  CHECK(check(boats::rich()) == StructureFault::kOk);
  CHECK(check(Structure{}) == StructureFault::kOk);
  CHECK(boats::mallard().n_terms == 13);
  CHECK(boats::mallard().n_coefficients == int{boats::kMallardSize});
  CHECK(boats::rich().n_coefficients == int{boats::kRichSize});
}

TEST_CASE("a full structure is accepted and one entry more is refused") {
  Structure s = boats::mallard();
  while (s.n_terms < kMaxTerms) add(s, 1, 0, 1.0, {kU});
  CHECK(check(s) == StructureFault::kOk);
  const std::tuple<int Structure::*, int, StructureFault> limits[] = {
      {&Structure::n_terms, kMaxTerms, StructureFault::kTooManyTerms},
      {&Structure::n_coefficients, kMaxCoefficients, StructureFault::kTooManyCoefficients},
      {&Structure::n_forces, kMaxForces, StructureFault::kTooManyForces}};
  for (const auto& [count, most, fault] : limits) {
    const int before = s.*count;
    s.*count = most;
    CHECK(check(s) == StructureFault::kOk);
    for (const int odd : {most + 1, -1}) {
      s.*count = odd;
      CHECK(check(s) == fault);
    }
    s.*count = before;
  }
  s.terms[3].n_factors = kMaxFactors;
  CHECK(check(s) == StructureFault::kOk);
  s.terms[3].n_factors = kMaxFactors + 1;
  CHECK(check(s) == StructureFault::kTooManyFactors);
}

TEST_CASE("a term that names what does not exist is refused") {
  const auto fault = [](auto change) {
    Structure s = boats::mallard();
    change(s);
    return check(s);
  };
  const auto fourth_force = [](Structure& s) { s.terms[3].factors[0] = kForce0 + 3; };
  CHECK(fault(fourth_force) == StructureFault::kUnknownSignal);
  CHECK(fault([&](Structure& s) {
          fourth_force(s);
          s.n_forces = 4;
        }) == StructureFault::kOk);
  CHECK(fault([](Structure& s) { s.terms[5].axis = 3; }) == StructureFault::kUnknownAxis);
  CHECK(fault([](Structure& s) { s.terms[8].acceleration = 3; }) == StructureFault::kUnknownAxis);
  CHECK(fault([](Structure& s) { s.terms[8].acceleration = 2; }) ==  // r_dot in that of r_dot
        StructureFault::kOwnAcceleration);
  CHECK(fault([](Structure& s) { s.terms[1].coefficient = boats::kMallardSize; }) ==
        StructureFault::kUnknownCoefficient);
  CHECK(fault([](Structure& s) { s.has_acceleration = false; }) ==  // N_ud u_dot would be dropped
        StructureFault::kAccelerationNotFlagged);
}

TEST_CASE("a factor that is not used is not looked at") {
  Structure s = boats::mallard();
  s.terms[3].factors[1] = 200;
  CHECK(check(s) == StructureFault::kOk);
}

TEST_CASE("signals are u, v, r, their sizes and the forces") {
  const Structure s = boats::mallard();
  const double nu[3] = {0.5, -0.25, -2.0};
  const double force[kMaxForces] = {-0.1, 0.2, 0.3};
  double z[kMaxSignals];
  signals(s, nu, force, z);
  const double expected[9] = {0.5, -0.25, -2.0, 0.5, 0.25, 2.0, -0.1, 0.2, 0.3};
  for (int i = 0; i < 9; ++i) CHECK(z[i] == expected[i]);
}

TEST_CASE("a term's product is its number times its factors") {
  Structure s;
  s.n_forces = 1;
  add(s, 0, -1, -3.0, {kAbsV, kV, kForce0, kR});
  add(s, 0, -1, 0.25, {});
  const double nu[3] = {0.5, -2.0, 3.0};
  const double force[kMaxForces] = {0.5};
  double z[kMaxSignals];
  signals(s, nu, force, z);
  CHECK(product(s.terms[0], z) == 18.0);  // -3 * 2 * -2 * 0.5 * 3
  CHECK(product(s.terms[1], z) == 0.25);
}
