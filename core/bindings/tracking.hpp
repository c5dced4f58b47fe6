// SPDX-License-Identifier: MIT
// Python's view of the tracking controller.
#pragma once
#include <nanobind/stl/tuple.h>

#include <tuple>

#include "arrays.hpp"
#include "predictor.hpp"
#include "seatrial/control/allocator.hpp"
#include "seatrial/control/tracking.hpp"

namespace {

using namespace seatrial;

/// gains: proportional, integral, derivative, authority: 4 x 3; mix: inputs x 3.
/// guidance: time, radius, slowest, fastest, approach.
TrackingGains make_gains(const Chain& chain, const Matrix& gains, const Matrix& mix, double limit,
                         bool feed_forward, const Vector& guidance) {
  const auto n = static_cast<std::size_t>(chain.allocation.n_commands);
  require(gains.shape(0) == 4 && gains.shape(1) == kAxes, "gains: 4 x 3");
  require(mix.shape(0) == n && mix.shape(1) == kAxes, "mix: one row an input, 3 columns");
  TrackingGains g;
  double* rows[] = {g.proportional, g.integral, g.derivative, g.authority};
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = 0; j < kAxes; ++j) rows[i][j] = gains(i, j);
  }
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < kAxes; ++j) g.mix[i][j] = mix(i, j);
  }
  g.limit = limit;
  g.feed_forward = feed_forward;
  require(guidance.shape(0) == 5, "guidance: 5 numbers");
  const double* given = guidance.data();
  g.guidance = {given[0], given[1], given[2], given[3], given[4]};
  return g;
}

/// Rows: pose, rate, acceleration.
Reference make_reference(const Matrix& rows) {
  require(rows.shape(0) == 3 && rows.shape(1) == kAxes, "reference: 3 x 3");
  Reference r;
  double* to[] = {r.eta, r.rate, r.acceleration};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < kAxes; ++j) to[i][j] = rows(i, j);
  }
  return r;
}

std::tuple<Out1, int> track(Tracker& self, int inputs, double dt, Vector eta, Vector nu, Matrix now,
                            Matrix ahead) {
  require(eta.shape(0) == kAxes && nu.shape(0) == kAxes, "eta and nu: 3 each");
  double values[kMaxCommands];
  const Tracked done =
      self.command(dt, eta.data(), nu.data(), make_reference(now), make_reference(ahead), values);
  double* out = nullptr;
  auto found = fresh<Out1>({static_cast<std::size_t>(inputs)}, &out);
  std::copy(values, values + inputs, out);
  return {found, static_cast<int>(done)};
}

void bind_tracking(nb::module_& m) {
  using namespace nb::literals;
  nb::class_<Tracker>(m, "Tracker")
      .def(
          "__init__",
          [](Tracker* self, const Boat& boat, const Chain& chain, Matrix gains, Matrix mix,
             double limit, bool feed_forward, const Allocator* allocator, Vector guidance) {
            const TrackingGains g = make_gains(chain, gains, mix, limit, feed_forward, guidance);
            if (allocator == nullptr) {
              new (self) Tracker(boat.structure, boat.coefficient, chain.allocation, g);
              return;
            }
            require(allocator->fault() == AllocatorFault::kOk, "this allocator has a fault");
            require(allocator->setup().effectiveness.n == chain.allocation.n_commands,
                    "inputs and the allocator's thrusters differ");
            new (self) Tracker(boat.structure, boat.coefficient, *allocator, g);
          },
          "boat"_a, "chain"_a, "gains"_a, "mix"_a, "limit"_a, "feed_forward"_a,
          "allocator"_a.none(), "guidance"_a,
          "allocator: for inputs that are the thrusters; without it the boat's own allocation. "
          "guidance: time, radius, slowest, fastest, approach; a time of 0: none.")
      .def("command", &track, "inputs"_a, "dt"_a, "eta"_a, "nu"_a, "now"_a, "ahead"_a,
           "Commands (inputs,), and the status of the call.")
      .def("forget", &Tracker::forget)
      .def_prop_ro(
          "drift",
          [](const Tracker& self) {
            const double* d = self.guidance().drift();
            const double row[kAxes] = {d[0], d[1], self.guidance().direction()};
            return row_of(row);
          },
          nb::for_getter(nb::rv_policy::move),
          "Drift velocity that is compensated, earth-fixed [m/s], and the direction [rad].")
      .def_prop_ro(
          "integral",
          [](const Tracker& self) {
            double row[kAxes];
            std::copy(self.integral(), self.integral() + kAxes, row);
            return row_of(row);
          },
          nb::for_getter(nb::rv_policy::move));
}

}  // namespace
