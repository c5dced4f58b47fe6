// SPDX-License-Identifier: MIT
// Python's view of the on-board predictor, and of the odometry made of it.
#pragma once
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <optional>
#include <string>
#include <tuple>
#include <type_traits>
#include <vector>

#include "arrays.hpp"
#include "noise.hpp"
#include "seatrial/integration/step_schedule.hpp"
#include "seatrial/onboard/odometer.hpp"

namespace {

using namespace seatrial;

/// (n, 2) least and most.
void make_ranges(const Matrix& from, int n, double (*range)[2]) {
  require(from.shape(0) == static_cast<std::size_t>(n) && from.shape(1) == 2, "ranges: n x 2");
  std::copy(from.data(), from.data() + std::ptrdiff_t{2} * n, &range[0][0]);
}

/// (coefficients and constants, causes).
void make_considered(const Matrix& from, const Boat& boat, const Chain& chain,
                     PrincipalErrors& to) {
  const int own = boat.structure.n_coefficients;
  const int n = own + chain.n_constants;
  require(from.shape(0) == static_cast<std::size_t>(n) &&
              from.shape(1) <= static_cast<std::size_t>(kMostConsidered),
          "considered: a row for each coefficient and constant, up to 12 causes");
  to.n = static_cast<int>(from.shape(1));
  for (int i = 0; i < n; ++i) {
    Loadings& row = i < own ? to.coefficient[i] : to.constant[i - own];
    const double* begin = from.data() + std::ptrdiff_t{i} * to.n;
    std::copy(begin, begin + to.n, row);
  }
}

OnboardModel make_onboard(const Boat& boat, const Chain& chain, const Vector& q,
                          const Vector& noise, const Matrix& considered, bool earth_fixed,
                          const Vector& current, std::optional<double> timeout,
                          const Matrix& speeds, const Matrix& forces, const Vector& spread,
                          double window, const Vector& delays) {
  require(boat.structure.n_forces == chain.n_forces, "structure and chain differ in forces");
  require(static_cast<int>(q.shape(0)) == chain.n_constants, "one value for each chain constant");
  require(current.shape(0) == 2 && spread.shape(0) == kAxes, "current: 2, spread: 3");
  require(window > 0.0 && window <= 5.0, "window: more than 0 s, at most 5 s");
  require(delays.shape(0) == 2 && std::abs(delays(0)) <= 1.0 && std::abs(delays(1)) <= 1.0,
          "delays: of position and heading, at most 1 s");
  OnboardModel m;
  m.window = window;
  m.position_delay = delays(0);
  m.heading_delay = delays(1);
  m.boat.structure = boat.structure;
  require(add_disturbance(m.boat.structure), "no room for a disturbance: too many terms");
  std::copy(boat.coefficient, boat.coefficient + kMaxCoefficients, m.boat.coefficient);
  m.boat.integrator = boat.integrator;
  m.boat.longest_step = boat.longest_step;
  m.boat.noise = make_noise(noise);
  make_considered(considered, boat, chain, m.boat.considered);
  m.boat.frame = earth_fixed ? DisturbanceFrame::kEarth : DisturbanceFrame::kBody;
  std::copy(current.data(), current.data() + 2, m.boat.current);
  m.chain = chain;
  std::copy(q.data(), q.data() + chain.n_constants, m.q);
  if (timeout) m.command_timeout = *timeout;
  make_ranges(speeds, kAxes, m.envelope.speed);
  make_ranges(forces, chain.n_forces, m.envelope.force);
  std::copy(spread.data(), spread.data() + kAxes, m.velocity_spread);
  return m;
}

template <class P, class T>
int give_pose(P& self, T t, const Vector& eta, std::optional<Matrix> covariance, int parts) {
  require(parts > kNoPart && parts <= kWholePose, "parts: position 1, heading 2, both 3");
  require(eta.shape(0) == kPose, "eta: x, y, psi");
  require(!covariance || (covariance->shape(0) == kPose && covariance->shape(1) == kPose),
          "covariance: 3 x 3");
  const double* spread = covariance ? covariance->data() : nullptr;
  const auto measured = static_cast<Parts>(parts);
  if constexpr (std::is_same_v<P, Predictor>) {
    return static_cast<int>(self.pose(t, eta.data(), spread, nullptr, measured));
  } else {
    return static_cast<int>(self.pose(t, eta.data(), spread, measured));
  }
}

template <class P, class T>
int give_row(P& self, T t, const Vector& values, bool scale) {
  const Chain& c = self.model().chain;
  const int width = scale ? c.n_scales : c.allocation.n_commands;
  require(static_cast<int>(values.shape(0)) == width, "one value for each signal");
  return static_cast<int>(scale ? self.scale(t, values.data()) : self.command(t, values.data()));
}

/// On the heap: too large for a stack.
template <class P>
P* copy_of(const P& self) {
  return new P(self);
}

template <std::size_t N>
Out1 row_of(const double (&from)[N]) {
  double* out = nullptr;
  auto to = fresh<Out1>({N}, &out);
  std::copy(from, from + N, out);
  return to;
}

template <std::size_t N>
Out2 square(const double (&from)[N][N]) {
  double* out = nullptr;
  auto to = fresh<Out2>({N, N}, &out);
  std::copy(&from[0][0], &from[0][0] + N * N, out);
  return to;
}

/// time, pose, velocity, covariance, disturbance, stamp of the last pose used, flags.
using Answer = std::tuple<double, Out1, Out1, Out2, Out1, double, unsigned>;

Answer answer(const Estimate& e) {
  return {
      e.time,      row_of(e.pose), row_of(e.velocity), square(e.covariance), row_of(e.disturbance),
      e.last_pose, e.health};
}

void bind_predictor(nb::module_& m) {
  using namespace nb::literals;
  m.def("health_words", [] {
    std::vector<std::tuple<unsigned, std::string, std::string>> out;
    for (const HealthWords& w : kHealthWords) out.emplace_back(w.flag, w.name, w.advice);
    return out;
  });
  nb::class_<OnboardModel>(m, "OnboardModel")
      .def(
          "__init__",
          [](OnboardModel* self, const Boat& boat, const Chain& chain, Vector q, Vector noise,
             Matrix considered, bool earth_fixed, Vector current, std::optional<double> timeout,
             Matrix speeds, Matrix forces, Vector spread, double window, Vector delays) {
            new (self)
                OnboardModel(make_onboard(boat, chain, q, noise, considered, earth_fixed, current,
                                          timeout, speeds, forces, spread, window, delays));
          },
          "boat"_a, "chain"_a, "q"_a, "noise"_a, "considered"_a, "earth_fixed"_a, "current"_a,
          "timeout"_a.none(), "speeds"_a, "forces"_a, "spread"_a, "window"_a, "delays"_a);
  nb::class_<Predictor>(m, "Predictor")
      .def(nb::init<const OnboardModel&>(), "model"_a)
      .def(
          "command",
          [](Predictor& self, double t, Vector v) { return give_row(self, t, v, false); }, "t"_a,
          "values"_a)
      .def(
          "scale", [](Predictor& self, double t, Vector v) { return give_row(self, t, v, true); },
          "t"_a, "values"_a)
      .def("pose", &give_pose<Predictor, double>, "t"_a, "eta"_a, "covariance"_a = nb::none(),
           "parts"_a = static_cast<int>(kWholePose))
      .def(
          "at", [](Predictor& self, double t) { return answer(self.at(t)); }, "t"_a)
      .def("forget", &Predictor::forget)
      .def("copy", &copy_of<Predictor>, nb::rv_policy::take_ownership)
      .def_prop_ro("newest", &Predictor::newest);
}

/// stamp, known, pose in odom, covariance, odom in map, motion.
using Published = std::tuple<std::int64_t, bool, Out1, Out2, Out1, Answer>;

Published publish(Odometer& self, std::int64_t stamp) {
  const Odometry o = self.at(stamp);
  return {o.stamp,         o.known, row_of(o.pose), square(o.covariance), row_of(o.map_to_odom),
          answer(o.motion)};
}

void bind_odometer(nb::module_& m) {
  using namespace nb::literals;
  nb::class_<Odometer>(m, "Odometer")
      .def(
          "__init__",
          [](Odometer* self, const OnboardModel& model, Vector lever) {
            require(lever.shape(0) == 2, "lever: forward, left");
            new (self) Odometer(model, lever.data());
          },
          "model"_a, "lever"_a)
      .def(
          "command",
          [](Odometer& self, std::int64_t t, Vector v) { return give_row(self, t, v, false); },
          "stamp"_a, "values"_a)
      .def(
          "scale",
          [](Odometer& self, std::int64_t t, Vector v) { return give_row(self, t, v, true); },
          "stamp"_a, "values"_a)
      .def("pose", &give_pose<Odometer, std::int64_t>, "stamp"_a, "eta"_a,
           "covariance"_a = nb::none(), "parts"_a = static_cast<int>(kWholePose))
      .def(
          "look", [](Odometer& self, std::int64_t t) { return answer(self.look(t)); }, "stamp"_a)
      .def("at", &publish, "stamp"_a)
      .def("copy", &copy_of<Odometer>, nb::rv_policy::take_ownership)
      .def_prop_ro("newest", &Odometer::newest)
      .def(
          "reload",
          [](Odometer& self, const OnboardModel& model, Vector lever) {
            require(lever.shape(0) == 2, "lever: forward, left");
            self.reload(model, lever.data());
          },
          "model"_a, "lever"_a)
      .def(
          "count",
          [](const Odometer& self, int source, int taken) {
            require(source >= 0 && source < kSources && taken >= 0 && taken < kOutcomes,
                    "no such count");
            return self.count(static_cast<Source>(source), static_cast<Taken>(taken));
          },
          "source"_a, "taken"_a);
}

}  // namespace
