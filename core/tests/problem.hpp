// SPDX-License-Identifier: MIT
// A boat on a recording, for the tests of roll-outs and of their sensitivities.
#pragma once
#include <doctest/doctest.h>

#include <cmath>
#include <utility>
#include <vector>

#include "boats.hpp"
#include "seatrial/integration/rollout.hpp"

namespace problems {

using namespace seatrial;  // NOLINT(google-build-using-namespace)
using boats::Script;

/// A boat on a recording: all that a roll-out depends on.
struct Problem {
  Boat boat;
  Chain chain;
  std::vector<double> q;
  Script commands;
  Script scales;
  std::vector<double> x0;
  std::vector<double> time;
  Columns columns;

  Problem(const Structure& s, const std::vector<double>& coefficients, const Chain& c,
          std::vector<double> constants)
      : chain(c), q(std::move(constants)), x0{0.3, -0.2, 0.5, 0.2, -0.1, 0.3} {
    boat.structure = s;
    std::copy(coefficients.begin(), coefficients.end(), boat.coefficient);
    columns = boats::all_columns(s, c);
  }

  ThrustTrace trace() const { return {chain, q.data(), commands.held(), scales.held(), columns}; }

  /// What column c differentiates to.
  double& parameter(int c) {
    if (c < kStates) return x0[static_cast<std::size_t>(c)];
    if (c < columns.first_constant()) return boat.coefficient[columns.coefficient[c - kStates]];
    return q[static_cast<std::size_t>(columns.constant[c - columns.first_constant()])];
  }
};

/// States at all stamps; sensitivities too where asked.
inline std::vector<double> simulated(const Problem& p, std::vector<double>* sensitivities) {
  const ThrustTrace trace = p.trace();
  std::vector<double> out(p.time.size() * kStates);
  if (sensitivities != nullptr)
    sensitivities->resize(out.size() * static_cast<std::size_t>(p.columns.size()));
  const int n = static_cast<int>(p.time.size());
  REQUIRE(simulate(p.boat, trace, p.x0.data(), p.time.data(), n, out.data(),
                   sensitivities == nullptr ? nullptr : sensitivities->data()) == n);
  return out;
}

/// The rich recording: 60 commands in about 10 s, a sagging battery, pose stamps off every grid.
inline Problem driven(const Structure& s, const std::vector<double>& coefficients, Scheme scheme,
                      bool lag) {
  Problem p(s, coefficients, boats::full_chain(scheme, lag), boats::full_constants());
  p.commands = boats::random_script(60, 60, 3, 0.05, -1.0, 1.0);
  p.scales.add(0.0, {13.2});
  p.scales.add(1.917, {12.6});
  p.scales.add(4.111, {11.4});
  for (int i = 0; i < 105; ++i) p.time.push_back(0.0137 + i / 15.0 + 0.003 * std::sin(7.0 * i));
  return p;
}

}  // namespace problems
