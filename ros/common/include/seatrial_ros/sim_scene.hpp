// SPDX-License-Identifier: MIT
// `scene.yaml` for the simulator's node: what Python's `seatrial.simulation.load_scene(path)`
// reads.
#pragma once
#include "seatrial/simulation/simulator.hpp"
#include "seatrial_ros/model_value.hpp"

namespace seatrial::ros {

/// Where a boat begins; in the order of the models.
struct BoatStart {
  double pose[3] = {0.0, 0.0, 0.0};  // x, y [m], psi [rad]
  std::string name;                  // empty: the model's
  double radius = kHullRadius;       // [m]
};

struct SceneSetup {
  Scene scene;
  double current[2] = {0.0, 0.0};  // [m/s]
  Sensors sensors{PoseSensor{}, Imu{}, Lidar{}};
  std::vector<BoatStart> boats;
};

namespace detail {

inline void read_row(const Value& list, std::size_t n, double* to) {
  const std::vector<Value> items = list.items();
  if (items.size() != n) list.refuse("expected " + std::to_string(n) + " numbers");
  for (std::size_t i = 0; i < n; ++i) to[i] = items[i].number();
}

inline double number_or(const Value& mapping, const std::string& key, double other) {
  const auto found = mapping.find(key);
  return found ? found->number() : other;
}

inline int whole(const Value& value) {
  const double number = value.number();
  if (number != std::floor(number) || std::abs(number) > 1e6) {
    value.refuse("expected a whole number");
  }
  return static_cast<int>(number);
}

inline void add_box(const Value& b, double x, double y, double turn, Scene& scene) {
  const double centre[2] = {x, y};
  Segment sides[4];
  box(centre, b.at("length").positive(), b.at("width").positive(), turn, sides);
  scene.segments.insert(scene.segments.end(), sides, sides + 4);
}

inline void read_surfaces(const Value& file, Scene& scene) {
  if (const auto pool = file.find("pool")) {
    pool->only({"length", "width"});
    add_box(*pool, 0.0, 0.0, 0.0, scene);
  }
  if (const auto walls = file.find("walls")) {
    for (const Value& wall : walls->items()) {
      double ends[4];
      read_row(wall, 4, ends);
      scene.segments.push_back({{ends[0], ends[1]}, {ends[2], ends[3]}});
    }
  }
  if (const auto boxes = file.find("boxes")) {
    for (const Value& b : boxes->items()) {
      b.only({"x", "y", "length", "width", "turn_deg"});
      const double turn = number_or(b, "turn_deg", 0.0) * kPi / 180.0;
      add_box(b, b.at("x").number(), b.at("y").number(), turn, scene);
    }
  }
  if (const auto posts = file.find("posts")) {
    for (const Value& p : posts->items()) {
      p.only({"x", "y", "radius"});
      const double centre[2] = {p.at("x").number(), p.at("y").number()};
      scene.circles.push_back({{centre[0], centre[1]}, p.at("radius").positive()});
    }
  }
}

/// Numbers of a mapping by name; what is not given stays.
inline void read_numbers(const Value& mapping,
                         const std::vector<std::pair<std::string, double*>>& fields) {
  for (const auto& [name, to] : fields) *to = number_or(mapping, name, *to);
}

inline void read_pose_sensor(const Value& given, PoseSensor& s) {
  given.only({"rate", "position_noise", "heading_noise", "noise_correlation", "stamp_jitter",
              "delay", "drop_outs", "drop_out_shortest", "drop_out_longest", "jumps",
              "jump_shortest", "jump_longest", "jump_samples"});
  read_numbers(given, {{"rate", &s.rate},
                       {"position_noise", &s.position_noise},
                       {"heading_noise", &s.heading_noise},
                       {"noise_correlation", &s.noise_correlation},
                       {"stamp_jitter", &s.stamp_jitter},
                       {"delay", &s.delay},
                       {"drop_outs", &s.drop_outs},
                       {"drop_out_shortest", &s.drop_out_shortest},
                       {"drop_out_longest", &s.drop_out_longest},
                       {"jumps", &s.jumps},
                       {"jump_shortest", &s.jump_shortest},
                       {"jump_longest", &s.jump_longest}});
  if (const auto samples = given.find("jump_samples")) s.jump_samples = whole(*samples);
}

inline void read_imu(const Value& given, Imu& s) {
  given.only(
      {"rate", "yaw_rate_noise", "yaw_rate_bias", "acceleration_noise", "acceleration_bias"});
  read_numbers(given, {{"rate", &s.rate},
                       {"yaw_rate_noise", &s.yaw_rate_noise},
                       {"yaw_rate_bias", &s.yaw_rate_bias},
                       {"acceleration_noise", &s.acceleration_noise},
                       {"acceleration_bias", &s.acceleration_bias}});
}

inline void read_lidar(const Value& given, Lidar& s) {
  given.only({"rate", "field", "beams", "nearest", "farthest", "noise", "bias", "mount"});
  read_numbers(given, {{"rate", &s.rate},
                       {"field", &s.field},
                       {"nearest", &s.nearest},
                       {"farthest", &s.farthest},
                       {"noise", &s.noise},
                       {"bias", &s.bias}});
  if (const auto beams = given.find("beams")) s.beams = whole(*beams);
  if (const auto mount = given.find("mount")) read_row(*mount, 3, s.mount);
}

template <class Sensor>
void refuse_faulty(const Value& sensors, const std::optional<Sensor>& sensor) {
  const char* why = sensor ? fault(*sensor) : nullptr;
  if (why != nullptr) sensors.refuse(why);
}

/// A sensor whose key says `null` is none.
inline void read_sensors(const Value& given, Sensors& s) {
  given.only({"pose", "imu", "lidar"});
  for (const auto& entry : given.entries()) {
    const bool none = !given.find(entry.first);
    if (entry.first == "pose") none ? s.pose.reset() : read_pose_sensor(entry.second, *s.pose);
    if (entry.first == "imu") none ? s.imu.reset() : read_imu(entry.second, *s.imu);
    if (entry.first == "lidar") none ? s.lidar.reset() : read_lidar(entry.second, *s.lidar);
  }
  refuse_faulty(given, s.pose);
  refuse_faulty(given, s.imu);
  refuse_faulty(given, s.lidar);
}

inline SceneSetup read_scene(const Value& file) {
  const auto format = file.find("seatrial");
  if (!format || !format->is_word() || format->text() != "scene 1") {
    file.refuse("expected 'seatrial: scene 1': is it another file?");
  }
  file.only({"seatrial", "name", "pool", "walls", "boxes", "posts", "current", "sensors", "boats"});
  SceneSetup setup;
  read_surfaces(file, setup.scene);
  if (const auto current = file.find("current")) read_row(*current, 2, setup.current);
  if (const auto sensors = file.find("sensors")) read_sensors(*sensors, setup.sensors);
  if (const auto boats = file.find("boats")) {
    for (const Value& b : boats->items()) {
      b.only({"start", "name", "radius"});
      BoatStart start;
      if (const auto pose = b.find("start")) read_row(*pose, 3, start.pose);
      if (const auto name = b.find("name")) start.name = name->text();
      if (const auto radius = b.find("radius")) start.radius = radius->positive();
      setup.boats.push_back(start);
    }
  }
  return setup;
}

}  // namespace detail

/// A scene from its file; open water without one. Throws std::runtime_error with one line.
inline SceneSetup load_scene(const std::string& path) {
  if (path.empty()) return {};
  try {
    return detail::read_scene(read_yaml(path));
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(path + ": " + error.what());
  }
}

}  // namespace seatrial::ros
