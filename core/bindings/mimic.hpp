// SPDX-License-Identifier: MIT
// Python's view of the mimic.
#pragma once
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <memory>
#include <string>
#include <tuple>

#include "arrays.hpp"
#include "seatrial/integration/step_schedule.hpp"
#include "seatrial/simulation/mimic.hpp"

namespace {

using namespace seatrial;

struct MimicBox {
  Mimic mimic;
  std::size_t n_inputs;
};

using CarrierAnswer = std::tuple<std::string, double, std::string, std::string>;
using MimicAnswer = std::tuple<double, std::vector<double>, std::vector<double>,
                               std::vector<double>, std::vector<double>, unsigned>;

void bind_mimic(nb::module_& m) {
  using namespace nb::literals;
  nb::class_<Carrier>(m, "Carrier")
      .def(nb::init<>())
      .def_rw("speed", &Carrier::speed)
      .def_rw("yaw_rate", &Carrier::yaw_rate)
      .def_rw("acceleration", &Carrier::acceleration)
      .def_rw("yaw_acceleration", &Carrier::yaw_acceleration)
      .def_rw("lag", &Carrier::lag)
      .def_rw("gain", &Carrier::gain)
      .def_rw("pose_timeout", &Carrier::pose_timeout)
      .def_rw("lost", &Carrier::lost)
      .def(
          "fault",
          [](const Carrier& c) {
            const CarrierFault f = fault(c);
            return CarrierAnswer{f.name == nullptr ? "" : f.name, f.got, f.expected, f.advice};
          },
          "Name (empty: none), value, what was expected, what to do.");
  nb::class_<MimicBox>(m, "Mimic")
      .def(
          "__init__",
          [](MimicBox* self, const Boat& boat, const Chain& chain, Vector q, const Carrier& carrier,
             double timeout) {
            require(static_cast<int>(q.shape(0)) == chain.n_constants, "one value a constant");
            require(boat.structure.n_forces == chain.n_forces, "structure and chain differ");
            require(fault(carrier).name == nullptr, "a carrier without fault");
            const auto plant = std::make_unique<Plant>(boat.structure, boat.coefficient, chain,
                                                       q.data(), boat.longest_step);
            const auto n = static_cast<std::size_t>(chain.allocation.n_commands);
            new (self) MimicBox{Mimic(*plant, carrier, timeout), n};
          },
          "boat"_a, "chain"_a, "q"_a, "carrier"_a, "timeout"_a)
      .def(
          "command",
          [](MimicBox& self, double t, Vector values) {
            require(values.shape(0) == self.n_inputs, "one value for each input");
            return self.mimic.command(t, values.data(), static_cast<int>(self.n_inputs));
          },
          "t"_a, "values"_a)
      .def(
          "pose",
          [](MimicBox& self, double t, Vector eta) {
            require(eta.shape(0) == kAxes, "eta: x, y, psi");
            return self.mimic.pose(t, eta.data());
          },
          "t"_a, "eta"_a)
      .def(
          "at",
          [](MimicBox& self, double t) -> MimicAnswer {
            const MimicOutput o = self.mimic.at(t);
            return {o.time,
                    {o.velocity, o.velocity + 3},
                    {o.asked, o.asked + 3},
                    {o.boat, o.boat + kStates},
                    {o.mismatch, o.mismatch + 3},
                    o.health};
          },
          "t"_a,
          "time, velocity for the carrier, the same before its limits, the virtual boat's state, "
          "mismatch, health.")
      .def_prop_ro(
          "newest", [](const MimicBox& self) { return self.mimic.newest(); },
          "Newest stamp [s] of all inputs and answers.");
  m.def(
      "mimic_words",
      [] {
        std::vector<std::tuple<unsigned, std::string>> out;
        for (const MimicWords& w : kMimicWords) out.emplace_back(w.flag, w.advice);
        return out;
      },
      "Flag and advice of each health flag of a mimic.");
}

}  // namespace
