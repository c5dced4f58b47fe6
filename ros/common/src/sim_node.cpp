// SPDX-License-Identifier: MIT
#include "seatrial_ros/sim_node.hpp"

#include <algorithm>
#include <cctype>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "seatrial/onboard/input_checks.hpp"

namespace seatrial::ros {

namespace {

constexpr double kAbreast = 1.5;  // [m] to port of each other, where no scene says it
constexpr double kBehind = 1.0;   // [s] that are made up for; what is more is lost

Words split(const std::string& list) {
  Words found;
  std::istringstream in(list);
  for (std::string word; std::getline(in, word, ',');) {
    const auto first = word.find_first_not_of(' ');
    if (first == std::string::npos) continue;
    found.push_back(word.substr(first, word.find_last_not_of(' ') - first + 1));
  }
  return found;
}

}  // namespace

SimNode::SimNode(SimSettings settings) : settings_(std::move(settings)) {
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

std::string SimNode::pose_topic(int boat) const {
  const std::string& own = at(boat).model.pose.topic;
  return named(boat, own.empty() ? "pose" : own);
}

const std::string& SimNode::pose_frame(int boat) const {
  const std::string& own = at(boat).model.pose.parent;
  return own.empty() ? settings_.map_frame : own;
}

std::set<std::string> SimNode::number_topics() const {
  std::set<std::string> topics;
  for (const Boat& b : boats_) {
    for (const Channel& c : b.command.channels()) topics.insert(c.topic);
  }
  return topics;
}

void SimNode::set_type(const std::string& topic, const std::string& type) {
  for (Boat& b : boats_) b.command.set_type(topic, type);
}

std::string SimNode::numbers(const NumbersMessage& in, const Accepted& accepted) {
  for (std::size_t i = 0; i < boats_.size(); ++i) {
    Signal& command = boats_[i].command;
    if (!command.update(in)) continue;
    const double* values = command.values();
    if (!all_within(values, static_cast<int>(command.size()), kStrongest)) {
      return in.topic + ": a command is missing, not a number or absurdly large; left out";
    }
    if (!simulator_->command(static_cast<int>(i), values)) {
      return in.topic + ": too many commands within the thrusters' latency; left out";
    }
    accepted(static_cast<int>(i), command);
  }
  return "";
}

bool SimNode::follow(double passed, const Arrived& arrived, const Truth& truth) {
  const double factor = settings_.real_time_factor;
  const double behind = passed - lost_ - time() / factor;
  if (behind > kBehind) {
    lost_ += behind;
    return false;
  }
  const auto due = [this] { return static_cast<double>(truths_) / settings_.rate; };
  const double goal = (passed - lost_) * factor;
  for (; due() <= goal; ++truths_) {
    advance_to(due(), arrived);
    for (int boat = 0; boat < n_boats(); ++boat) truth(boat);
  }
  advance_to(goal, arrived);
  return true;
}

void SimNode::advance_to(double t, const Arrived& arrived) {
  if (!simulator_->advance_to(t)) {
    throw std::runtime_error("a boat diverges: its model is unstable under these commands");
  }
  for (const Reading& reading : simulator_->take()) arrived(reading);
}

void SimNode::as_message(int boat, const double* pose, double* raw) const {
  const PoseSource& source = at(boat).model.pose;
  const Channel* channels[3] = {&source.x, &source.y, &source.heading};
  for (int i = 0; i < 3; ++i) raw[i] = (pose[i] - channels[i]->offset) / channels[i]->gain;
}

std::string SimNode::Boat::under(const std::string& topic) const {
  if (name.empty()) return topic;
  return topic.front() == '/' ? "/" + name + topic : name + "/" + topic;
}

void SimNode::add(const std::string& path, bool several, const SceneSetup& setup) {
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
std::string SimNode::free_name(const std::string& given) const {
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

}  // namespace seatrial::ros
