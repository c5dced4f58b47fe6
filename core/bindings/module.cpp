// SPDX-License-Identifier: MIT
// Python's view of the core: arrays in, arrays out. No formula lives here.
#include <nanobind/stl/pair.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <limits>
#include <tuple>
#include <vector>

#include "arrays.hpp"
#include "filter.hpp"
#include "from_arrays.hpp"
#include "on_board.hpp"
#include "rollout.hpp"
#include "seatrial/model/frames.hpp"
#include "seatrial/simulation/plant.hpp"

using namespace nb::literals;
using namespace seatrial;

namespace {

Out2 trace_forces(const ThrustTrace& trace, Vector time) {
  const std::size_t n = time.shape(0);
  const auto width = static_cast<std::size_t>(trace.chain().n_forces);
  double* out = nullptr;
  auto forces = fresh<Out2>({n, width}, &out);
  int at = 0;
  for (std::size_t i = 0; i < n; ++i) {
    Thrust f;
    at = trace.find(time(i), at);
    trace.at(at, time(i), f);
    double output[kMaxActuators];
    for (int k = 0; k < trace.chain().n_actuators(); ++k) output[k] = f.multiplier[k] * f.level[k];
    mix_forces(trace.chain(), output, out + i * width);
  }
  return forces;
}

/// Value of every term's product (with its acceleration, without its coefficient): n x terms.
Out2 regressors(const Structure& s, Matrix nu, Matrix nu_dot, Matrix force) {
  const std::size_t n = nu.shape(0);
  require(nu.shape(1) == kAxes && nu_dot.shape(0) == n && nu_dot.shape(1) == kAxes, "nu: n x 3");
  require(force.shape(0) == n && static_cast<int>(force.shape(1)) == s.n_forces,
          "F: n x number of forces");
  const auto width = static_cast<std::size_t>(s.n_terms);
  double* out = nullptr;
  auto table = fresh<Out2>({n, width}, &out);
  for (std::size_t i = 0; i < n; ++i) {
    double z[kMaxSignals];
    signals(s, &nu(i, 0), force.data() + i * force.shape(1), z);
    for (int t = 0; t < s.n_terms; ++t) {
      const Term& term = s.terms[t];
      const double moved = term.acceleration < 0 ? 1.0 : nu_dot(i, term.acceleration);
      out[i * width + static_cast<std::size_t>(t)] = product(term, z) * moved;
    }
  }
  return table;
}

Out2 accelerations(const Structure& s, Vector coefficient, Matrix nu, Matrix force) {
  const std::size_t n = nu.shape(0);
  require(static_cast<int>(coefficient.shape(0)) == s.n_coefficients, "one value a coefficient");
  require(
      nu.shape(1) == kAxes && force.shape(0) == n && static_cast<int>(force.shape(1)) == s.n_forces,
      "nu: n x 3, F: n x number of forces");
  double* out = nullptr;
  auto rates = fresh<Out2>({n, std::size_t{kAxes}}, &out);
  for (std::size_t i = 0; i < n; ++i) {
    acceleration(s, coefficient.data(), &nu(i, 0), force.data() + i * force.shape(1),
                 out + i * kAxes);
  }
  return rates;
}

std::pair<Out2, Out1> run_allocate(const Chain& chain, Matrix wrench) {
  const std::size_t n = wrench.shape(0);
  require(static_cast<int>(wrench.shape(1)) == chain.allocation.n_commands, "one column a command");
  const auto width = static_cast<std::size_t>(chain.n_actuators());
  double* out = nullptr;
  double* share = nullptr;
  auto thrusters = fresh<Out2>({n, width}, &out);
  auto alpha = fresh<Out1>({n}, &share);
  for (std::size_t i = 0; i < n; ++i) {
    share[i] = allocate(chain.allocation, wrench.data() + i * wrench.shape(1), out + i * width);
  }
  return {thrusters, alpha};
}

/// Thrust of one actuator for rows of commands to all of them.
Out1 run_curve(const Chain& chain, Vector q, int actuator, Matrix command) {
  require(actuator >= 0 && actuator < chain.n_actuators(), "actuator out of range");
  require(static_cast<int>(q.shape(0)) == chain.n_constants, "one value for each chain constant");
  require(static_cast<int>(command.shape(1)) == chain.n_actuators(), "one column an actuator");
  const std::size_t n = command.shape(0);
  const std::size_t width = command.shape(1);
  double* out = nullptr;
  auto thrust = fresh<Out1>({n}, &out);
  for (std::size_t i = 0; i < n; ++i) {
    out[i] = curve(chain, q.data(), actuator, command.data() + i * width, nullptr);
  }
  return thrust;
}

/// Rows of earth-fixed rates into body axes, or back.
Out2 rotate(Vector psi, Matrix rate, bool to_body) {
  const std::size_t n = psi.shape(0);
  require(rate.shape(0) == n && rate.shape(1) == kAxes, "rate: n x 3");
  double* out = nullptr;
  auto rotated = fresh<Out2>({n, std::size_t{kAxes}}, &out);
  for (std::size_t i = 0; i < n; ++i) {
    if (to_body) {
      earth_to_body(psi(i), &rate(i, 0), out + i * kAxes);
    } else {
      body_to_earth(psi(i), &rate(i, 0), out + i * kAxes);
    }
  }
  return rotated;
}

Out1 wrap_all(Vector angle) {
  double* out = nullptr;
  auto wrapped = fresh<Out1>({angle.shape(0)}, &out);
  for (std::size_t i = 0; i < angle.shape(0); ++i) out[i] = wrap(angle(i));
  return wrapped;
}

Out1 vector_of(const double* from, std::size_t n) {
  double* out = nullptr;
  auto v = fresh<Out1>({n}, &out);
  std::copy(from, from + n, out);
  return v;
}

}  // namespace

NB_MODULE(_core, m) {
  nb::set_leak_warnings(false);  // objects that live until the interpreter ends
  m.doc() = "The core of seatrial: model, thrusters, integration, sensitivities (C++).";
  m.attr("MAX_FORCES") = kMaxForces;
  m.attr("MAX_FACTORS") = kMaxFactors;
  m.attr("MAX_TERMS") = kMaxTerms;
  m.attr("MAX_ACTUATORS") = kMaxActuators;
  m.attr("MAX_COEFFICIENTS") = kMaxCoefficients;
  m.attr("MAX_CONSTANTS") = kMaxConstants;
  m.attr("MAX_SCALES") = kMaxScales;
  m.attr("MAX_TABLE") = kMaxTable;
  m.attr("FIRST_FORCE") = static_cast<int>(kForce0);

  nb::class_<Structure>(m, "Structure")
      .def(
          "__init__",
          [](Structure* self, const std::vector<TermRow>& rows, int n_coefficients, int n_forces) {
            new (self) Structure(make_structure(rows, n_coefficients, n_forces));
          },
          "rows"_a, "n_coefficients"_a, "n_forces"_a,
          "rows: (axis, coefficient or -1, number, acceleration or -1, [factor codes]) each.");
  nb::class_<Chain>(m, "Chain")
      .def(
          "__init__",
          [](Chain* self, int scheme, Matrix inverse, double offset, double limit, Matrix mix,
             IndexTable actuators, int n_constants, Vector scale_reference, Matrix table,
             Matrix deflection) {
            new (self) Chain(make_chain(scheme, inverse, offset, limit, mix, actuators, n_constants,
                                        scale_reference, table, deflection));
          },
          "scheme"_a, "inverse"_a, "offset"_a, "limit"_a, "mix"_a, "actuators"_a, "n_constants"_a,
          "scale_reference"_a, "table"_a, "deflection"_a);
  nb::class_<Boat>(m, "Boat").def(
      "__init__",
      [](Boat* self, const Structure& structure, Vector coefficient, int integrator, double step) {
        new (self) Boat(make_boat(structure, coefficient, integrator, step));
      },
      "structure"_a, "coefficient"_a, "integrator"_a, "longest_step"_a);
  nb::class_<ThrustTrace>(m, "ThrustTrace")
      .def(
          "__init__",
          [](ThrustTrace* self, const Chain& chain, Vector q, Vector time, Matrix commands,
             Vector scale_time, Matrix scales, bool initial, std::vector<int> coefficients,
             std::vector<int> constants) {
            new (self) ThrustTrace(make_trace(chain, q, time, commands, scale_time, scales, initial,
                                              coefficients, constants));
          },
          "chain"_a, "q"_a, "time"_a, "commands"_a, "scale_time"_a, "scales"_a, "initial"_a = false,
          "coefficients"_a = std::vector<int>{}, "constants"_a = std::vector<int>{})
      .def_prop_ro("breaks", &ThrustTrace::breaks)
      .def("forces", &trace_forces, "time"_a, "Generalised forces F at time [s]: n x forces.");
  nb::class_<Plant>(m, "Plant")
      .def(
          "__init__",
          [](Plant* self, const Boat& boat, const Chain& chain, Vector q) {
            require(static_cast<int>(q.shape(0)) == chain.n_constants, "one value a constant");
            require(boat.structure.n_forces == chain.n_forces, "structure and chain differ");
            new (self) Plant(boat.structure, boat.coefficient, chain, q.data(), boat.longest_step);
          },
          "boat"_a, "chain"_a, "q"_a)
      .def(
          "command",
          [](Plant& self, double t, Vector values) { return self.command(t, values.data()); },
          "t"_a, "values"_a)
      .def("advance_to", &Plant::advance_to, "t"_a)
      .def_prop_ro("time", &Plant::time)
      .def_prop_rw(
          "state", [](const Plant& self) { return vector_of(self.state(), kStates); },
          [](Plant& self, Vector x) {
            require(x.shape(0) == kStates, "state: [x, y, psi, u, v, r]");
            std::copy(x.data(), x.data() + kStates, self.state());
          },
          nb::for_getter(nb::rv_policy::move))
      .def(
          "forces",
          [](const Plant& self, int n_forces) {
            double force[kMaxForces];
            self.forces(force);
            return vector_of(force, static_cast<std::size_t>(n_forces));
          },
          "n_forces"_a);

  bind_rollout(m);
  bind_filter(m);
  bind_on_board(m);
  m.def("regressors", &regressors, "structure"_a, "nu"_a, "nu_dot"_a, "force"_a);
  m.def("accelerations", &accelerations, "structure"_a, "coefficient"_a, "nu"_a, "force"_a);
  m.def("allocate", &run_allocate, "chain"_a, "wrench"_a,
        "Thruster commands (n x actuators) and the share alpha of each wrench that is given.");
  m.def("curve", &run_curve, "chain"_a, "q"_a, "actuator"_a, "command"_a);
  m.def("wrap", &wrap_all, "angle"_a, "Angles in (-pi, pi].");
  m.def("rotate", &rotate, "psi"_a, "rate"_a, "to_body"_a);
}
