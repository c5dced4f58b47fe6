// SPDX-License-Identifier: MIT
// The tracking node without ROS, driven by a script of events; commands in hexadecimal digits.
//
//   tracking NAME=VALUE... < EVENTS
//
// Names are the node's parameters, lists by commas. A line of events, the stamp in
// nanoseconds:
//   STAMP odom|map_pose|reference|goal X Y PSI U V R [variances of U V R]
//   STAMP tick
// Each tick answers: what the node did, as the number of Conduct, and the commands to all inputs.
#include <cstdio>
#include <iostream>
#include <sstream>
#include <string>
#include <vector>

#include "seatrial_ros/tracking_node.hpp"

namespace {

namespace sr = seatrial::ros;

std::vector<double> numbers_of(const std::string& text) {
  std::vector<double> found;
  std::istringstream in(text);
  for (std::string item; std::getline(in, item, ',');) found.push_back(std::stod(item));
  return found;
}

struct Take {
  std::string name;
  std::string text;
  void operator()(const sr::Parameter& p, std::string& to) const {
    if (p.name == name) to = text;
  }
  void operator()(const sr::Parameter& p, double& to) const {
    if (p.name == name) to = std::stod(text);
  }
  void operator()(const sr::Parameter& p, bool& to) const {
    if (p.name == name) to = text == "true";
  }
  void operator()(const sr::Parameter& p, std::vector<double>& to) const {
    if (p.name == name) to = numbers_of(text);
  }
};

sr::TrackingSettings settings_of(int argc, char** argv) {
  sr::TrackingSettings settings;
  for (int i = 1; i < argc; ++i) {
    const std::string pair = argv[i];
    const std::size_t at = pair.find('=');
    if (at == std::string::npos) throw std::runtime_error(pair + ": expected NAME=VALUE");
    sr::each_parameter(settings, Take{pair.substr(0, at), pair.substr(at + 1)});
  }
  return settings;
}

void answer(sr::TrackingNode& node, std::int64_t stamp, std::size_t inputs) {
  const double* values = node.tick(stamp);
  std::printf("%d", static_cast<int>(node.conduct()));
  for (std::size_t i = 0; i < inputs; ++i) std::printf(" %a", values[i]);
  std::printf("\n");
}

void follow(sr::TrackingNode& node, std::size_t inputs) {
  for (std::string line; std::getline(std::cin, line);) {
    std::istringstream in(line);
    sr::MotionMessage message;
    std::string kind;
    in >> message.stamp >> kind;
    for (double& x : message.eta) in >> x;
    for (double& x : message.nu) in >> x;
    for (double& x : message.nu_variance) in >> x;
    if (kind == "tick") answer(node, message.stamp, inputs);
    if (kind == "odom") node.odometry(message);
    if (kind == "map_pose") node.map_pose(message);
    if (kind == "reference") node.reference(message);
    if (kind == "goal") node.goal(message);
  }
}

}  // namespace

int main(int argc, char** argv) {
  try {
    const sr::TrackingSettings settings = settings_of(argc, argv);
    sr::TrackingNode node(settings);
    follow(node, sr::load_model(settings.model).inputs.size());
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
  return 0;
}
