// SPDX-License-Identifier: MIT
// The core's structure, chain, thrust and boat from Python's arrays, checked.
#pragma once
#include <algorithm>
#include <cstdint>
#include <tuple>
#include <vector>

#include "arrays.hpp"
#include "seatrial/integration/step_schedule.hpp"
#include "seatrial/integration/thrust_trace.hpp"

namespace {

using namespace seatrial;

using TermRow = std::tuple<int, int, double, int, std::vector<int>>;

Structure make_structure(const std::vector<TermRow>& rows, int n_coefficients, int n_forces) {
  Structure s;
  require(rows.size() <= static_cast<std::size_t>(kMaxTerms), "too many terms");
  s.n_coefficients = n_coefficients;
  s.n_forces = n_forces;
  for (const auto& [axis, coefficient, number, acceleration, factors] : rows) {
    Term& term = s.terms[s.n_terms++];
    term.axis = static_cast<std::uint8_t>(axis);
    term.coefficient = static_cast<std::int8_t>(coefficient);
    term.number = number;
    term.acceleration = static_cast<std::int8_t>(acceleration);
    require(factors.size() <= static_cast<std::size_t>(kMaxFactors), "too many factors in a term");
    term.n_factors = static_cast<std::uint8_t>(factors.size());
    for (std::size_t k = 0; k < factors.size(); ++k) {
      term.factors[k] = static_cast<std::uint8_t>(factors[k]);
    }
    s.has_acceleration = s.has_acceleration || term.acceleration >= 0;
  }
  require(check(s) == StructureFault::kOk,
          "structure refused: unknown factor, axis or coefficient, "
          "or an axis with its own acceleration");
  return s;
}

Chain make_chain(int scheme, Matrix inverse, double offset, double limit, Matrix mix,
                 IndexTable actuators, int n_constants, Vector scale_reference, Matrix table,
                 Matrix deflection) {
  Chain c;
  require(inverse.shape(0) <= kMaxActuators && inverse.shape(1) <= kMaxCommands,
          "at most 8 actuators and 8 commands");
  require(mix.shape(0) <= kMaxForces && mix.shape(1) == inverse.shape(0),
          "mix: forces x actuators");
  require(actuators.shape(0) == inverse.shape(0) && actuators.shape(1) == 20, "actuators: n x 20");
  require(deflection.shape(0) == mix.shape(0) && deflection.shape(1) == mix.shape(1),
          "deflection: forces x actuators");
  require(n_constants >= 0 && n_constants <= kMaxConstants, "too many chain constants");
  require(scale_reference.shape(0) <= kMaxScales, "at most 4 scale signals");
  require(table.shape(0) <= kMaxTable && table.shape(1) == 2, "table: at most 256 x 2");
  c.allocation.scheme = static_cast<Scheme>(scheme);
  c.allocation.n_actuators = static_cast<int>(inverse.shape(0));
  c.allocation.n_commands = static_cast<int>(inverse.shape(1));
  c.allocation.offset = offset;
  c.allocation.limit = limit;
  c.n_forces = static_cast<int>(mix.shape(0));
  c.n_constants = n_constants;
  c.n_scales = static_cast<int>(scale_reference.shape(0));
  c.n_table = static_cast<int>(table.shape(0));
  for (int k = 0; k < c.n_actuators(); ++k) {
    for (int j = 0; j < c.allocation.n_commands; ++j) c.allocation.inverse[k][j] = inverse(k, j);
    for (int j = 0; j < c.n_forces; ++j) {
      c.mix[j][k] = mix(j, k);
      c.deflection[j][k] = deflection(j, k);
    }
    for (int i = 0; i < 14; ++i) require(actuators(k, i) < n_constants, "constant out of range");
    require(actuators(k, 14) < c.n_scales, "scale signal out of range");
    Actuator& a = c.actuators[k];
    std::int8_t* fields[] = {&a.latency,      &a.edge_forward,  &a.edge_reverse,   &a.reverse_ratio,
                             &a.power,        &a.lag,           &a.scale_power,    &a.gain,
                             &a.offset_along, &a.offset_across, &a.pair_dead_zone, &a.full_angle,
                             &a.angle_offset, &a.slew_rate,     &a.scale};
    for (int i = 0; i < 15; ++i) *fields[i] = static_cast<std::int8_t>(actuators(k, i));
    a.tabulated = actuators(k, 15) > 0;
    a.partner = static_cast<std::int8_t>(actuators(k, 16));
    a.across = actuators(k, 17) > 0;
    a.mirrored = actuators(k, 18) > 0;
    a.steers = static_cast<std::int8_t>(actuators(k, 19));
    require(!a.tabulated || c.n_table >= 2, "a tabulated actuator needs a table");
  }
  require(
      pairs_are_whole(c),
      "a pair: two actuators, each other's partner, with the same constants and no other curve");
  require(angles_are_whole(c),
          "an angle turns one other actuator's thrust, and has no scale or gain");
  for (int i = 0; i < c.n_scales; ++i) c.scale_reference[i] = scale_reference(i);
  for (int i = 0; i < c.n_table; ++i) {
    c.table_command[i] = table(i, 0);
    c.table_thrust[i] = table(i, 1);
  }
  return c;
}

Columns make_columns(bool initial, const std::vector<int>& coefficients,
                     const std::vector<int>& constants) {
  Columns columns;
  require(coefficients.size() <= kMaxCoefficients && constants.size() <= kMaxConstants,
          "too many columns");
  columns.n_initial = initial ? kStates : 0;
  for (const int i : coefficients) columns.coefficient[columns.n_coefficients++] = i;
  for (const int i : constants) columns.constant[columns.n_constants++] = i;
  return columns;
}

Held make_held(const Vector& time, const Matrix& value) {
  require(time.shape(0) == value.shape(0), "one row of values for each stamp");
  Held held;
  held.n = static_cast<int>(time.shape(0));
  held.width = static_cast<int>(value.shape(1));
  held.time = time.data();
  held.value = value.data();
  return held;
}

ThrustTrace make_trace(const Chain& chain, Vector q, Vector time, Matrix commands,
                       Vector scale_time, Matrix scales, bool initial,
                       const std::vector<int>& coefficients, const std::vector<int>& constants) {
  require(static_cast<int>(q.shape(0)) == chain.n_constants, "one value for each chain constant");
  require(time.shape(0) > 0, "at least one command");
  require(static_cast<int>(commands.shape(1)) == chain.allocation.n_commands,
          "one column for each command");
  require(static_cast<int>(scales.shape(1)) == chain.n_scales, "one column for each scale signal");
  for (const int i : constants) require(i >= 0 && i < chain.n_constants, "constant out of range");
  const Held held = make_held(time, commands);
  const Held scaled = make_held(scale_time, scales);
  const Columns columns = make_columns(initial, coefficients, constants);
  nb::gil_scoped_release released;
  return ThrustTrace(chain, q.data(), held, scaled, columns);
}

Boat make_boat(const Structure& structure, Vector coefficient, int integrator, double step) {
  require(static_cast<int>(coefficient.shape(0)) == structure.n_coefficients,
          "one value a coefficient");
  require(step > 0.0, "step > 0");
  Boat boat;
  boat.structure = structure;
  std::copy(coefficient.data(), coefficient.data() + structure.n_coefficients, boat.coefficient);
  boat.integrator = static_cast<Integrator>(integrator);
  boat.longest_step = step;
  return boat;
}

}  // namespace
