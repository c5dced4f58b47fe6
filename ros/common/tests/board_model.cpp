// SPDX-License-Identifier: MIT
// What the reader makes of a model file, in hexadecimal digits: compared with Python's.
//
//   board_model signals MODEL        names, channels, pose source
//   board_model noise MODEL          what the filter believes
//   board_model follow MODEL EVENTS  estimates along "command|scale|pose|at STAMP VALUES..." lines
#include <cstdio>
#include <cstdlib>
#include <memory>

#include "seatrial/onboard/predictor.hpp"
#include "seatrial_ros/model_file.hpp"

namespace {

using namespace seatrial;  // NOLINT(google-build-using-namespace)

void show(const double* values, int n) {
  for (int i = 0; i < n; ++i) std::printf(" %a", values[i]);
}

void show(const char* role, const ros::Channel& c) {
  std::printf("%s %s topic=%s field=%s index=%d", role, c.name.c_str(), c.topic.c_str(),
              c.field.c_str(), c.index);
  show(&c.gain, 1);
  show(&c.offset, 1);
  std::printf("\n");
}

const char* word(ros::Clock clock) { return clock == ros::Clock::kBag ? "bag" : "header"; }

void signals(const ros::BoardModel& board) {
  std::printf("name %s\n", board.name.c_str());
  std::printf("commands topic=%s clock=%s\n", board.commands.topic.c_str(),
              word(board.commands.clock));
  for (const ros::Channel& c : board.inputs) show("input", c);
  for (const ros::Channel& c : board.scales) show("scale", c);
  const ros::PoseSource& pose = board.pose;
  std::printf("pose topic=%s parent=%s child=%s clock=%s", pose.topic.c_str(), pose.parent.c_str(),
              pose.child.c_str(), word(pose.clock));
  show(pose.lever, 2);
  std::printf("\n");
  show("pose", pose.x);
  show("pose", pose.y);
  show("pose", pose.psi);
  show("heading", pose.heading);
}

void noise(const ros::BoardModel& board) {
  const NoiseParameters& n = board.model.boat.noise;
  const double row[] = {n.position,           n.heading,         n.walk_linear, n.walk_yaw,
                        n.disturbance_linear, n.disturbance_yaw, n.memory,      n.colour_position,
                        n.colour_heading,     n.colour_memory,   n.colour_turn, n.sway_ratio};
  show(row, 12);
  std::printf("\n");
}

void show(const Estimate& e) {
  std::printf("%a %u", e.time, static_cast<unsigned>(e.health));
  show(e.pose, kPose);
  show(e.velocity, kAxes);
  show(e.disturbance, kAxes);
  show(&e.covariance[0][0], kStates * kStates);
  std::printf("\n");
}

void follow(const ros::BoardModel& board, const char* events) {
  const auto predictor = std::make_unique<Predictor>(board.model);
  std::ifstream file(events);
  for (std::string line; std::getline(file, line);) {
    std::istringstream in(line);
    std::string kind;
    in >> kind;
    std::vector<double> row;
    for (std::string number; in >> number;) row.push_back(std::strtod(number.c_str(), nullptr));
    const double t = row.at(0);
    if (kind == "command") predictor->command(t, &row.at(1));
    if (kind == "scale") predictor->scale(t, &row.at(1));
    if (kind == "pose") predictor->pose(t, &row.at(1));
    if (kind == "at") show(predictor->at(t));
  }
}

}  // namespace

int main(int n, char** words) {
  const std::string what = n > 2 ? words[1] : "";
  try {
    if (what == "signals" && n == 3) {
      signals(ros::load_model(words[2]));
    } else if (what == "noise" && n == 3) {
      noise(ros::load_model(words[2]));
    } else if (what == "follow" && n == 4) {
      follow(ros::load_model(words[2]), words[3]);
    } else {
      std::fprintf(stderr, "usage: board_model signals|noise|follow MODEL [EVENTS]\n");
      return 2;
    }
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
  return 0;
}
