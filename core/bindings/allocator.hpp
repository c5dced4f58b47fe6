// SPDX-License-Identifier: MIT
// Python's view of thrust allocation for any geometry.
#pragma once
#include <nanobind/stl/pair.h>
#include <nanobind/stl/tuple.h>

#include <tuple>
#include <utility>

#include "arrays.hpp"
#include "seatrial/control/allocator.hpp"

namespace {

using namespace seatrial;

/// `commands` (3, n): limit, idle forward, idle astern.
AllocatorSetup make_allocator_setup(const Chain& chain, Vector q, Matrix effectiveness,
                                    Matrix commands, int scheme, bool inverted, double hysteresis,
                                    Indices rank) {
  AllocatorSetup s;
  const std::size_t n = effectiveness.shape(1);
  require(static_cast<int>(q.shape(0)) == chain.n_constants, "one value for each chain constant");
  require(effectiveness.shape(0) == kWrenchAxes, "effectiveness: 3 x actuators");
  require(static_cast<int>(n) == chain.n_actuators(), "effectiveness and chain differ");
  require(commands.shape(0) == 3 && commands.shape(1) == n, "commands: 3 x actuators");
  require(rank.shape(0) == kWrenchAxes, "rank: 3");
  s.scheme = static_cast<AllocatorScheme>(scheme);
  s.chain = chain;
  s.inverted = inverted;
  s.hysteresis = hysteresis;
  std::copy(q.data(), q.data() + chain.n_constants, s.q);
  s.effectiveness.n = static_cast<int>(n);
  for (std::size_t k = 0; k < n; ++k) {
    for (std::size_t j = 0; j < kWrenchAxes; ++j) {
      s.effectiveness.column[k][j] = effectiveness(j, k);
    }
    s.limit[k] = commands(0, k);
    s.idle_forward[k] = commands(1, k);
    s.idle_reverse[k] = commands(2, k);
  }
  for (std::size_t j = 0; j < kWrenchAxes; ++j) {
    require(rank(j) >= 0 && rank(j) < kWrenchAxes, "rank: 0, 1 or 2");
    s.rank[j] = static_cast<std::uint8_t>(rank(j));
  }
  return s;
}

/// Commands (m, n), shares (m, 3), and whether thrusters were held within the hysteresis (m).
std::tuple<Out2, Out2, Out1> run_allocator(Allocator& self, Matrix wrench) {
  require(self.fault() == AllocatorFault::kOk, "this allocator has a fault");
  require(wrench.shape(1) == kWrenchAxes, "wrench: m x 3");
  const std::size_t m = wrench.shape(0);
  const auto n = static_cast<std::size_t>(self.setup().effectiveness.n);
  double* command = nullptr;
  double* share = nullptr;
  double* held = nullptr;
  auto commands = fresh<Out2>({m, n}, &command);
  auto shares = fresh<Out2>({m, std::size_t{kWrenchAxes}}, &share);
  auto helds = fresh<Out1>({m}, &held);
  for (std::size_t i = 0; i < m; ++i) {
    const Allotment out = self.allocate(&wrench(i, 0), command + i * n);
    std::copy(out.share, out.share + kWrenchAxes, share + i * kWrenchAxes);
    held[i] = out.held ? 1.0 : 0.0;
  }
  return {commands, shares, helds};
}

/// Wrench (m, 3) and power (m) of commands (m, n).
std::pair<Out2, Out1> run_wrench(const Allocator& self, Matrix command) {
  const std::size_t m = command.shape(0);
  require(static_cast<int>(command.shape(1)) == self.setup().effectiveness.n,
          "commands: one column an actuator");
  double* given = nullptr;
  double* power = nullptr;
  auto wrenches = fresh<Out2>({m, std::size_t{kWrenchAxes}}, &given);
  auto powers = fresh<Out1>({m}, &power);
  for (std::size_t i = 0; i < m; ++i) {
    self.wrench(&command(i, 0), given + i * kWrenchAxes);
    power[i] = self.power(&command(i, 0));
  }
  return {wrenches, powers};
}

/// One function of thruster and number, for rows (m, n).
template <double (Allocator::*each)(int, double) const>
Out2 thruster_by_thruster(const Allocator& self, Matrix rows) {
  const std::size_t m = rows.shape(0);
  const std::size_t n = rows.shape(1);
  require(static_cast<int>(n) == self.setup().effectiveness.n, "one column an actuator");
  double* out = nullptr;
  auto found = fresh<Out2>({m, n}, &out);
  for (std::size_t i = 0; i < m; ++i) {
    for (std::size_t k = 0; k < n; ++k)
      out[i * n + k] = (self.*each)(static_cast<int>(k), rows(i, k));
  }
  return found;
}

Out1 run_reach(const Allocator& self, Matrix direction, double most) {
  require(direction.shape(1) == kWrenchAxes, "direction: m x 3");
  double* out = nullptr;
  auto multiples = fresh<Out1>({direction.shape(0)}, &out);
  for (std::size_t i = 0; i < direction.shape(0); ++i) {
    out[i] = self.reach(&direction(i, 0), most);
  }
  return multiples;
}

/// Sides at rest: 1 forward, -1 astern, 0 switches.
Out1 sides_of(const Allocator& self) {
  const auto n = static_cast<std::size_t>(self.setup().effectiveness.n);
  double* out = nullptr;
  auto sides = fresh<Out1>({n}, &out);
  for (std::size_t k = 0; k < n; ++k) out[k] = static_cast<double>(self.idle().side[k]);
  return sides;
}

/// (2, n): where thrust begins, forward and astern.
Out2 edges_of(const Allocator& self) {
  const auto n = static_cast<std::size_t>(self.setup().effectiveness.n);
  double* out = nullptr;
  auto edges = fresh<Out2>({2, n}, &out);
  for (std::size_t k = 0; k < n; ++k) {
    out[k] = self.edge(static_cast<int>(k), Side::kForward);
    out[n + k] = self.edge(static_cast<int>(k), Side::kReverse);
  }
  return edges;
}

void bind_allocator(nb::module_& m) {
  using namespace nb::literals;
  nb::class_<Allocator>(m, "Allocator")
      .def(
          "__init__",
          [](Allocator* self, const Chain& chain, Vector q, Matrix effectiveness, Matrix commands,
             int scheme, bool inverted, double hysteresis, Indices rank) {
            new (self) Allocator(make_allocator_setup(chain, q, effectiveness, commands, scheme,
                                                      inverted, hysteresis, rank));
          },
          "chain"_a, "q"_a, "effectiveness"_a, "commands"_a, "scheme"_a, "inverted"_a,
          "hysteresis"_a, "rank"_a, "commands (3, n): limit, idle forward, idle astern.")
      .def_prop_ro("fault", [](const Allocator& self) { return static_cast<int>(self.fault()); })
      .def_prop_ro("idle_power", [](const Allocator& self) { return self.idle().power; })
      .def_prop_ro("sides", &sides_of, nb::rv_policy::move)
      .def_prop_ro("edges", &edges_of, nb::rv_policy::move)
      .def("reset", &Allocator::reset)
      .def("allocate", &run_allocator, "wrench"_a,
           "Commands (m x n), shares (m x 3), whether thrusters were held (m).")
      .def("wrench", &run_wrench, "command"_a, "Wrench (m x 3) and power (m).")
      .def("command", &thruster_by_thruster<&Allocator::command>, "thrust"_a,
           "Commands (m x n) that give thrusts (m x n).")
      .def("thrust", &thruster_by_thruster<&Allocator::thrust>, "command"_a,
           "Thrusts (m x n) at commands (m x n).")
      .def("reach", &run_reach, "direction"_a, "most"_a);
}

}  // namespace
