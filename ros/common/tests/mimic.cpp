// SPDX-License-Identifier: MIT
// The mimic node without ROS, driven by a script of events; what it answers, in hexadecimal digits.
//
//   mimic NAME=VALUE... < EVENTS
//
// Names are the node's parameters. A line of events, the stamp in nanoseconds:
//   STAMP numbers TYPE TOPIC V V V | V V
//   STAMP pose X Y PSI
//   STAMP tick
// Each tick answers: health, then the virtual boat's x y psi u v r.
#include <cinttypes>
#include <cstdio>
#include <iostream>

#include "events.hpp"
#include "seatrial_ros/mimic_node.hpp"

namespace {

namespace sr = seatrial::ros;

void follow(sr::MimicNode& node, const std::string& line) {
  std::istringstream words(line);
  std::int64_t stamp = 0;
  std::string what;
  words >> stamp >> what;
  if (what == "tick") {
    const seatrial::MimicOutput out = node.tick(stamp);
    std::printf("%" PRIu32, out.health);
    for (const double x : out.boat) std::printf(" %a", x);
    std::printf("\n");
  } else if (what == "pose") {
    double eta[seatrial::kAxes];
    for (double& x : eta) words >> x;
    node.pose(stamp, stamp, eta);
  } else {
    sr::NumbersMessage in;
    std::string type;
    words >> type >> in.topic;
    in.arrival = stamp;
    in.numbers = sr::numbers_of(words);
    node.set_type(in.topic, type);
    node.numbers(in);
  }
}

}  // namespace

int main(int argc, char** argv) {
  try {
    sr::MimicNode node(sr::settings_of<sr::MimicSettings>(argc, argv));
    for (std::string line; std::getline(std::cin, line);) follow(node, line);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
  return 0;
}
