// SPDX-License-Identifier: MIT
// Python's view of the simulator: scenes, sensors and boats on one clock.
#pragma once
#include <nanobind/stl/optional.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/unique_ptr.h>
#include <nanobind/stl/vector.h>

#include <tuple>

#include "arrays.hpp"
#include "seatrial/onboard/input_checks.hpp"
#include "seatrial/simulation/simulator.hpp"

namespace {

using namespace seatrial;

Out1 copied(const std::vector<double>& values) {
  double* out = nullptr;
  auto made = fresh<Out1>({values.size()}, &out);
  std::copy(values.begin(), values.end(), out);
  return made;
}

Scene make_scene(const Matrix& segments, const Matrix& circles) {
  require(segments.shape(1) == 4 && circles.shape(1) == 3, "segments: n x 4, circles: m x 3");
  Scene scene;
  for (std::size_t i = 0; i < segments.shape(0); ++i) {
    const Segment s = {{segments(i, 0), segments(i, 1)}, {segments(i, 2), segments(i, 3)}};
    scene.segments.push_back(s);
  }
  for (std::size_t i = 0; i < circles.shape(0); ++i) {
    scene.circles.push_back({{circles(i, 0), circles(i, 1)}, circles(i, 2)});
  }
  return scene;
}

Out2 box_of(double x, double y, double length, double width, double turn) {
  const double centre[2] = {x, y};
  Segment sides[4];
  box(centre, length, width, turn, sides);
  double* out = nullptr;
  auto made = fresh<Out2>({std::size_t{4}, std::size_t{4}}, &out);
  for (const Segment& s : sides) {
    out = std::copy(s.begin, s.begin + 2, out);
    out = std::copy(s.end, s.end + 2, out);
  }
  return made;
}

Out1 ranges_of(const Scene& scene, const Matrix& origin, const Vector& angle) {
  const std::size_t n = angle.shape(0);
  require(origin.shape(0) == n && origin.shape(1) == 2, "origin: one row of 2 for each angle");
  double* out = nullptr;
  auto found = fresh<Out1>({n}, &out);
  for (std::size_t i = 0; i < n; ++i) out[i] = range(scene, &origin(i, 0), angle(i));
  return found;
}

Out1 distances_of(const Scene& scene, const Matrix& points) {
  require(points.shape(1) == 2, "points: n x 2");
  double* out = nullptr;
  auto found = fresh<Out1>({points.shape(0)}, &out);
  for (std::size_t i = 0; i < points.shape(0); ++i) out[i] = distance(scene, &points(i, 0));
  return found;
}

void set_lever(double* to, std::size_t n, const Vector& from) {
  require(from.shape(0) == n, "a lever or mount of another length");
  std::copy(from.data(), from.data() + n, to);
}

template <class Sensor>
void require_sound(const std::optional<Sensor>& sensor) {
  const char* why = sensor ? fault(*sensor) : nullptr;
  require(why == nullptr, why);
}

int add_boat(Simulator& self, const Boat& boat, const Chain& chain, const Vector& q,
             const Vector& start, double radius, const std::optional<PoseSensor>& pose,
             const std::optional<Imu>& imu, const std::optional<Lidar>& lidar) {
  require(static_cast<int>(q.shape(0)) == chain.n_constants, "one value for each chain constant");
  require(boat.structure.n_forces == chain.n_forces, "structure and chain differ in forces");
  require(start.shape(0) == kAxes, "start: x, y, psi");
  require_sound(pose);
  require_sound(imu);
  require_sound(lidar);
  auto plant =
      std::make_unique<Plant>(boat.structure, boat.coefficient, chain, q.data(), boat.longest_step);
  return self.add(std::move(plant), start.data(), radius, {pose, imu, lidar});
}

using ReadingTuple = std::tuple<int, int, double, double, Out1>;

std::vector<ReadingTuple> take_readings(Simulator& self) {
  std::vector<ReadingTuple> out;
  for (const Reading& r : self.take()) {
    out.emplace_back(static_cast<int>(r.kind), r.boat, r.stamp, r.arrival, copied(r.values));
  }
  return out;
}

int known_boat(const Simulator& self, int boat) {
  require(boat >= 0 && boat < self.n_boats(), "no such boat");
  return boat;
}

void bind_sensors(nb::module_& m) {
  using namespace nb::literals;
  nb::class_<PoseSensor>(m, "PoseSensor")
      .def(nb::init<>())
      .def_rw("rate", &PoseSensor::rate)
      .def_rw("position_noise", &PoseSensor::position_noise)
      .def_rw("heading_noise", &PoseSensor::heading_noise)
      .def_rw("noise_correlation", &PoseSensor::noise_correlation)
      .def_rw("stamp_jitter", &PoseSensor::stamp_jitter)
      .def_rw("delay", &PoseSensor::delay)
      .def_rw("drop_outs", &PoseSensor::drop_outs)
      .def_rw("drop_out_shortest", &PoseSensor::drop_out_shortest)
      .def_rw("drop_out_longest", &PoseSensor::drop_out_longest)
      .def_rw("jumps", &PoseSensor::jumps)
      .def_rw("jump_shortest", &PoseSensor::jump_shortest)
      .def_rw("jump_longest", &PoseSensor::jump_longest)
      .def_rw("jump_samples", &PoseSensor::jump_samples)
      .def_rw("position_delay", &PoseSensor::position_delay)
      .def_rw("heading_delay", &PoseSensor::heading_delay)
      .def("set_lever", [](PoseSensor& s, Vector lever) { set_lever(s.lever, 2, lever); });
  nb::class_<Imu>(m, "Imu")
      .def(nb::init<>())
      .def_rw("rate", &Imu::rate)
      .def_rw("yaw_rate_noise", &Imu::yaw_rate_noise)
      .def_rw("yaw_rate_bias", &Imu::yaw_rate_bias)
      .def_rw("acceleration_noise", &Imu::acceleration_noise)
      .def_rw("acceleration_bias", &Imu::acceleration_bias);
  nb::class_<Lidar>(m, "Lidar")
      .def(nb::init<>())
      .def_rw("rate", &Lidar::rate)
      .def_rw("field", &Lidar::field)
      .def_rw("beams", &Lidar::beams)
      .def_rw("nearest", &Lidar::nearest)
      .def_rw("farthest", &Lidar::farthest)
      .def_rw("noise", &Lidar::noise)
      .def_rw("bias", &Lidar::bias)
      .def("set_mount", [](Lidar& s, Vector mount) { set_lever(s.mount, 3, mount); })
      .def("angles",
           [](const Lidar& s) {
             std::vector<double> angles;
             for (int k = 0; k < s.beams; ++k) angles.push_back(beam_angle(s, k));
             return copied(angles);
           })
      .def("sweep", [](const Lidar& s) { return sweep(s); });
  m.def(
      "sensor_fault",
      [](const std::optional<PoseSensor>& pose, const std::optional<Imu>& imu,
         const std::optional<Lidar>& lidar) {
        const char* found[] = {pose ? fault(*pose) : nullptr, imu ? fault(*imu) : nullptr,
                               lidar ? fault(*lidar) : nullptr};
        for (const char* why : found) {
          if (why != nullptr) return nb::str(why);
        }
        return nb::str("");
      },
      "pose"_a.none(), "imu"_a.none(), "lidar"_a.none(), "Why they are refused; '': they are not.");
}

void bind_simulator(nb::module_& m) {
  using namespace nb::literals;
  m.attr("HULL_RADIUS") = kHullRadius;
  m.attr("STRONGEST_COMMAND") = kStrongest;
  nb::class_<Scene>(m, "Scene")
      .def(
          "__init__",
          [](Scene* self, Matrix segments, Matrix circles) {
            new (self) Scene(make_scene(segments, circles));
          },
          "segments"_a, "circles"_a)
      .def("ranges", &ranges_of, "origin"_a, "angle"_a)
      .def("distance", &distances_of, "points"_a);
  m.def("box", &box_of, "x"_a, "y"_a, "length"_a, "width"_a, "turn"_a);
  bind_sensors(m);
  nb::class_<Simulator>(m, "Simulator")
      .def(
          "__init__",
          [](Simulator* self, const Scene& scene, Vector current, std::uint64_t seed) {
            require(current.shape(0) == 2, "current: x, y");
            new (self) Simulator(scene, current.data(), seed);
          },
          "scene"_a, "current"_a, "seed"_a)
      .def("add", &add_boat, "boat"_a, "chain"_a, "q"_a, "start"_a, "radius"_a,
           "pose"_a = nb::none(), "imu"_a = nb::none(), "lidar"_a = nb::none(),
           "Number of the boat; -1 where there is no room for its hull, or time has begun.")
      .def(
          "command",
          [](Simulator& self, int boat, Vector values) {
            return self.command(known_boat(self, boat), values.data());
          },
          "boat"_a, "values"_a)
      .def("advance_to", &Simulator::advance_to, "t"_a)
      .def("take", &take_readings, "(kind, boat, stamp, arrival, values) of all that have arrived.")
      .def_prop_ro("time", &Simulator::time)
      .def("touched",
           [](const Simulator& self, int boat) { return self.touched(known_boat(self, boat)); })
      .def("state",
           [](const Simulator& self, int boat) {
             std::vector<double> x(kStates);
             self.state(known_boat(self, boat), x.data());
             return copied(x);
           })
      .def("forces", [](const Simulator& self, int boat, int n_forces) {
        double force[kMaxForces] = {0.0};
        self.forces(known_boat(self, boat), force);
        return copied(std::vector<double>(force, force + n_forces));
      });
}

}  // namespace
