// SPDX-License-Identifier: MIT
// The node without ROS, driven by a script of events; what it would publish, in hexadecimal digits.
//
//   script NAME=VALUE... < EVENTS
//
// Names are the node's parameters. A line of events, stamps in nanoseconds ("-": a header has
// none):
//   ARRIVAL pose STAMP FRAME X Y PSI
//   ARRIVAL numbers TYPE TOPIC STAMP V V V | V V     groups as in seatrial_ros/fields.hpp
//   ARRIVAL tick
//   ARRIVAL reload
//   ARRIVAL adopt
//   ARRIVAL diagnose
// Each tick answers: stamp, then in odom x y psi, u v r, in map x y psi, odom in map x y psi,
// health; or "stamp unknown". At the end the diagnosis of then.
#include <cinttypes>
#include <cstdio>
#include <iostream>
#include <sstream>

#include "events.hpp"
#include "seatrial_ros/node.hpp"

namespace {

namespace sr = seatrial::ros;

std::int64_t stamp_of(const std::string& text) { return text == "-" ? 0 : std::stoll(text); }

void show(const seatrial::Odometry& o) {
  std::printf("%" PRId64, o.stamp);
  if (!o.known) {
    std::printf(" unknown\n");
    return;
  }
  for (const double* row : {o.pose, o.motion.velocity, o.motion.pose, o.map_to_odom}) {
    for (int i = 0; i < seatrial::kPose; ++i) std::printf(" %a", row[i]);
  }
  std::printf(" %u\n", static_cast<unsigned>(o.motion.health));
}

/// An event; when it was [ns].
std::int64_t follow(sr::Node& node, const std::string& line) {
  std::istringstream words(line);
  std::int64_t arrival = 0;
  std::string what;
  std::string stamp;
  words >> arrival >> what;
  if (what == "tick") {
    show(node.tick(arrival));
  } else if (what == "reload") {
    const std::string wrong = node.reload();
    std::printf("reload %s\n", wrong.empty() ? "done" : wrong.c_str());
  } else if (what == "adopt") {
    const std::string wrong = node.adopt();
    std::printf("adopt %s\n", wrong.empty() ? node.model_path().c_str() : wrong.c_str());
  } else if (what == "pose") {
    sr::PoseMessage in;
    in.arrival = arrival;
    words >> stamp >> in.frame >> in.eta[0] >> in.eta[1] >> in.eta[2];
    in.stamp = stamp_of(stamp);
    node.pose(in);
  } else if (what == "numbers") {
    sr::NumbersMessage in;
    in.arrival = arrival;
    std::string type;
    words >> type >> in.topic >> stamp;
    in.stamp = stamp_of(stamp);
    in.numbers = sr::numbers_of(words);
    node.set_type(in.topic, type);
    node.numbers(in);
  } else if (what != "diagnose") {
    throw std::runtime_error("no such event: " + line);
  }
  return arrival;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    sr::Node node(sr::settings_of<sr::Settings>(argc, argv));
    std::int64_t now = 0;
    for (std::string line; std::getline(std::cin, line);) {
      if (!line.empty()) now = follow(node, line);
    }
    const sr::Diagnosis d = node.diagnose(now);
    std::printf("diagnosis %d %s\n", static_cast<int>(d.level), d.message.c_str());
    for (const auto& [key, value] : d.values) {
      std::printf("  %s: %s\n", key.c_str(), value.c_str());
    }
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
  return 0;
}
