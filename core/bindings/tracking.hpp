// SPDX-License-Identifier: MIT
// Python's view of the tracking controller.
#pragma once
#include <nanobind/stl/tuple.h>

#include <tuple>

#include "arrays.hpp"
#include "predictor.hpp"
#include "seatrial/control/allocator.hpp"
#include "seatrial/control/steering.hpp"
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

/// Surge, yaw by full commands at a speed ahead, and the side of a positive angle.
std::tuple<double, double, double> full_steering(const Steering& self, double speed) {
  double surge = 0.0;
  double yaw = 0.0;
  self.authority(speed, &surge, &yaw);
  return {surge, yaw, self.side(speed)};
}

/// Commands (thrust, angle) as inputs, and whether they give both accelerations.
std::tuple<Out1, bool> steer(Steering& self, double surge, double yaw, Vector nu, double dt) {
  require(nu.shape(0) == kAxes, "nu: 3");
  require(self.fault() == SteeringFault::kOk, "this steering has a fault");
  double* out = nullptr;
  auto found = fresh<Out1>({std::size_t{2}}, &out);
  const bool given = self.command(surge, yaw, nu.data(), dt, out);
  return {found, given};
}

/// Commands as inputs for a steady thrust and angle [rad].
Out1 steady_commands(const Steering& self, double thrust, double angle) {
  require(self.fault() == SteeringFault::kOk, "this steering has a fault");
  double* out = nullptr;
  auto found = fresh<Out1>({std::size_t{2}}, &out);
  self.commands(thrust, angle, out);
  return found;
}

/// Accelerations at a motion by a thrust of 1 and by the sine of its angle.
Out1 steered_effect(const Steering& self, Vector nu) {
  require(nu.shape(0) == kAxes, "nu: 3");
  const SteeredEffect e = self.effect(nu.data());
  double* out = nullptr;
  auto found = fresh<Out1>({std::size_t{6}}, &out);
  const double values[] = {e.along, e.turn, e.across, e.flow, e.sway_across, e.sway_flow};
  std::copy(values, values + 6, out);
  return found;
}

void bind_steering(nb::module_& m) {
  using namespace nb::literals;
  nb::class_<Steering>(m, "Steering")
      .def(
          "__init__",
          [](Steering* self, const Boat& boat, const Chain& chain, Vector q, double limit) {
            require(static_cast<int>(q.shape(0)) == chain.n_constants,
                    "one value for each chain constant");
            new (self) Steering(boat.structure, boat.coefficient, chain, q.data(), limit);
          },
          "boat"_a, "chain"_a, "q"_a, "limit"_a = 1.0,
          "One thruster with an angle; limit: of both commands.")
      .def_prop_ro("fault", [](const Steering& self) { return static_cast<int>(self.fault()); })
      .def_prop_ro("thrust", &Steering::thrust, "Its input.")
      .def_prop_ro("angle", &Steering::angle, "Its input.")
      .def_prop_ro("trim", &Steering::trim, "[rad] angle at no command.")
      .def_prop_ro("full_angle", &Steering::full_angle, "[rad] from the trim at full command.")
      .def_prop_ro("angle_rate", &Steering::angle_rate, "[rad/s]; 0: no limit.")
      .def_prop_ro("thrusts",
                   [](const Steering& self) {
                     return std::make_tuple(self.astern_thrust(), self.full_thrust());
                   })
      .def_prop_ro(
          "sines",
          [](const Steering& self) { return std::make_tuple(self.least_sine(), self.most_sine()); })
      .def("commands", &steady_commands, "thrust"_a, "angle"_a,
           "Commands (2,) whose steady thrust and angle [rad] these are.")
      .def("authority", &full_steering, "speed"_a,
           "Surge and yaw acceleration by full commands at a speed ahead [m/s], and 1, or -1 where "
           "a "
           "positive command turns the bow to starboard.")
      .def("effect", &steered_effect, "nu"_a,
           "along, turn, across, flow, sway_across, sway_flow (6,): accelerations at a motion.")
      .def("command", &steer, "surge"_a, "yaw"_a, "nu"_a, "dt"_a,
           "Commands (2,) for accelerations, dt [s] after the last; whether they give "
           "both.")
      .def("forget", &Steering::forget);
}

void bind_tracking(nb::module_& m) {
  using namespace nb::literals;
  nb::class_<Tracker>(m, "Tracker")
      .def(
          "__init__",
          [](Tracker* self, const Boat& boat, const Chain& chain, Matrix gains, Matrix mix,
             double limit, bool feed_forward, const Allocator* allocator, Vector guidance,
             const Steering* steering) {
            const TrackingGains g = make_gains(chain, gains, mix, limit, feed_forward, guidance);
            if (steering != nullptr) {
              require(steering->fault() == SteeringFault::kOk, "this steering has a fault");
              new (self) Tracker(boat.structure, boat.coefficient, *steering, g);
              return;
            }
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
          "allocator"_a.none(), "guidance"_a, "steering"_a.none() = nb::none(),
          "allocator: for inputs that are the thrusters; without it the boat's own allocation. "
          "guidance: time, radius, slowest, fastest, approach; a time of 0: none. "
          "steering: for one thruster with an angle.")
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
