// SPDX-License-Identifier: MIT
// `model.yaml` for a node on board: the model as the predictor takes it, and how its signals are
// read from messages. What Python's `seatrial.Predictor(model)` builds, without Python.
#pragma once
#include <string>
#include <vector>

#include "seatrial/onboard/predictor_state.hpp"
#include "seatrial_ros/model_signals.hpp"
#include "seatrial_ros/model_vehicle.hpp"

namespace seatrial::ros {

/// A model file. A node may choose model.window, model.boat.frame and model.boat.current.
struct BoardModel {
  OnboardModel model;
  std::string name;
  std::vector<Channel> inputs;  // in the order of the predictor's commands
  std::vector<Channel> scales;  // in the order of its scale signals
  CommandSource commands;
  PoseSource pose;
};

/// A model from its file. Throws std::runtime_error with one line: file, place, what to do.
BoardModel load_model(const std::string& path);

}  // namespace seatrial::ros
