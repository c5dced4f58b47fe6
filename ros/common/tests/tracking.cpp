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

#include "events.hpp"
#include "seatrial_ros/tracking_node.hpp"

namespace {

namespace sr = seatrial::ros;

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
    const auto settings = sr::settings_of<sr::TrackingSettings>(argc, argv);
    sr::TrackingNode node(settings);
    follow(node, sr::load_model(settings.model).inputs.size());
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
  return 0;
}
