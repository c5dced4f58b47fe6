// SPDX-License-Identifier: MIT
// The simulator's node without ROS: what the shells for ROS 1 and ROS 2 do with commands and time.
#pragma once
#include <algorithm>
#include <cctype>
#include <memory>
#include <set>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "seatrial_ros/signal.hpp"
#include "seatrial_ros/sim_scene.hpp"
#include "seatrial_ros/sim_settings.hpp"

namespace seatrial::ros {

inline constexpr double kAbreast = 1.5;  // [m] to port of each other, where no scene says it

class SimNode {
 public:
  /// Throws std::runtime_error, with one line for whoever starts it.
  explicit SimNode(SimSettings settings) : settings_(std::move(settings)) {
    check_ranges(settings_);
    const Words paths = split(settings_.models);
    if (paths.empty()) {
      throw std::runtime_error(
          "parameter models is empty; expected the path of a model.yaml, or several with commas "
          "between");
    }
    const SceneSetup setup = load_scene(settings_.scene);
    sensors_ = setup.sensors;
    simulator_ = std::make_unique<Simulator>(setup.scene, setup.current,
                                             static_cast<std::uint64_t>(settings_.seed));
    for (const std::string& path : paths) add(path, paths.size() > 1, setup);
  }

  const SimSettings& settings() const { return settings_; }
  const Sensors& sensors() const { return sensors_; }
  int n_boats() const { return static_cast<int>(boats_.size()); }
  double time() const { return simulator_->time(); }

  /// A name below the boat's own, where there are several: /joy is /name/joy.
  std::string named(int boat, const std::string& name) const { return at(boat).under(name); }

  /// Where a boat's poses go, and the frame that they are in.
  std::string pose_topic(int boat) const {
    const std::string& own = at(boat).model.pose.topic;
    return named(boat, own.empty() ? "pose" : own);
  }
  const std::string& pose_frame(int boat) const {
    const std::string& own = at(boat).model.pose.parent;
    return own.empty() ? settings_.map_frame : own;
  }

  std::set<std::string> number_topics() const {
    std::set<std::string> topics;
    for (const Boat& b : boats_) {
      for (const Channel& c : b.command.channels()) topics.insert(c.topic);
    }
    return topics;
  }

  /// As of `Node`.
  void set_type(const std::string& topic, const std::string& type) {
    const Shape& shape = known_shape(topic, type);
    for (Boat& b : boats_) b.command.set_type(topic, shape);
  }

  /// A command acts when it comes, and is told: taken(boat, command). Empty, or in one line why it
  /// was left out.
  template <class Taken>
  std::string numbers(const NumbersMessage& in, const Taken& taken) {
    for (std::size_t i = 0; i < boats_.size(); ++i) {
      Signal& command = boats_[i].command;
      if (!command.update(in)) continue;
      const double* values = command.values();
      const bool finite =
          std::all_of(values, values + command.size(), [](double v) { return std::isfinite(v); });
      if (!finite) return in.topic + ": a command is missing or not a number; left out";
      if (!simulator_->command(static_cast<int>(i), values)) {
        return in.topic + ": too many commands within the thrusters' latency; left out";
      }
      taken(static_cast<int>(i), command);
    }
    return "";
  }

  /// On to t [s]; what arrives meanwhile. Throws std::runtime_error where a boat diverges.
  std::vector<Reading> advance_to(double t) {
    if (!simulator_->advance_to(t)) {
      throw std::runtime_error("a boat diverges: its model is unstable under these commands");
    }
    return simulator_->take();
  }

  /// Truth: x, y [m], psi [rad], u, v [m/s], r [rad/s] over ground.
  void state(int boat, double* x) const { simulator_->state(boat, x); }

  /// A pose (3) as the vehicle's messages have it: x, y, and the heading of the quaternion.
  void as_message(int boat, const double* pose, double* raw) const {
    const PoseSource& source = at(boat).model.pose;
    const Channel* channels[3] = {&source.x, &source.y, &source.heading};
    for (int i = 0; i < 3; ++i) raw[i] = (pose[i] - channels[i]->offset) / channels[i]->gain;
  }

 private:
  struct Boat {
    std::string name;  // empty: the only one
    BoardModel model;
    Signal command;

    std::string under(const std::string& topic) const {
      if (name.empty()) return topic;
      return topic.front() == '/' ? "/" + name + topic : name + "/" + topic;
    }
  };

  static Words split(const std::string& list) {
    Words found;
    std::istringstream in(list);
    for (std::string word; std::getline(in, word, ',');) {
      const auto first = word.find_first_not_of(' ');
      if (first == std::string::npos) continue;
      found.push_back(word.substr(first, word.find_last_not_of(' ') - first + 1));
    }
    return found;
  }

  void add(const std::string& path, bool several, const SceneSetup& setup) {
    const std::size_t i = boats_.size();
    BoatStart start;
    start.pose[1] = kAbreast * static_cast<double>(i);
    if (i < setup.boats.size()) start = setup.boats[i];
    Boat boat;
    boat.model = load_model(path);
    expect_named(boat.model, path);
    if (several) boat.name = free_name(start.name.empty() ? boat.model.name : start.name);
    std::vector<Channel> inputs = boat.model.inputs;
    for (Channel& c : inputs) c.topic = boat.under(c.topic);
    boat.command = Signal(std::move(inputs));
    Sensors sensors = setup.sensors;
    if (sensors.pose) {
      std::copy(boat.model.pose.lever, boat.model.pose.lever + 2, sensors.pose->lever);
      sensors.pose->position_delay = boat.model.model.position_delay;
      sensors.pose->heading_delay = boat.model.model.heading_delay;
    }
    const OnboardModel& m = boat.model.model;
    auto plant = std::make_unique<Plant>(m.boat.structure, m.boat.coefficient, m.chain, m.q,
                                         m.boat.longest_step);
    if (simulator_->add(std::move(plant), start.pose, start.radius, sensors) < 0) {
      throw std::runtime_error(path + ": the boat does not fit where it is to begin; place the " +
                               "boats with start: in the scene, or give a smaller radius");
    }
    boats_.push_back(std::move(boat));
  }

  /// A valid ROS name, with a number where another boat has it.
  std::string free_name(const std::string& given) const {
    std::string name = given;
    std::replace_if(
        name.begin(), name.end(), [](unsigned char c) { return std::isalnum(c) == 0; }, '_');
    if (name.empty() || std::isalpha(static_cast<unsigned char>(name.front())) == 0) {
      throw std::runtime_error("boat '" + given +
                               "': expected a name that begins with a letter a to z, as a ROS "
                               "namespace does; give it another under boats: name: in the scene");
    }
    const auto taken = [this](const std::string& wanted) {
      return std::any_of(boats_.begin(), boats_.end(),
                         [&wanted](const Boat& b) { return b.name == wanted; });
    };
    std::string wanted = name;
    for (int k = 2; taken(wanted); ++k) wanted = name + "_" + std::to_string(k);
    return wanted;
  }

  const Boat& at(int boat) const { return boats_[static_cast<std::size_t>(boat)]; }

  SimSettings settings_;
  Sensors sensors_;
  std::unique_ptr<Simulator> simulator_;
  std::vector<Boat> boats_;
};

}  // namespace seatrial::ros
