// SPDX-License-Identifier: MIT
// The odometry node without ROS: what the shells for ROS 1 and ROS 2 do with each message and at
// each tick. All stamps are nanoseconds; `arrival` is the node's own clock.
#pragma once
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "seatrial/onboard/odometer.hpp"
#include "seatrial_ros/diagnosis.hpp"
#include "seatrial_ros/model_file.hpp"
#include "seatrial_ros/settings.hpp"
#include "seatrial_ros/signal.hpp"

namespace seatrial::ros {

/// A pose message.
struct PoseMessage {
  std::int64_t stamp = 0;       // [ns] of its header; 0: none
  std::int64_t arrival = 0;     // [ns]
  std::string frame;            // of its header
  std::string child;            // of Odometry; else empty
  double eta[kPose] = {};       // x, y [m], psi [rad] as they stand in the message
  bool has_covariance = false;  // and that is known
  double covariance[kPose * kPose] = {};
};

class Node {
 public:
  /// Throws std::runtime_error, with one line for whoever starts it.
  explicit Node(Settings settings) : settings_(std::move(settings)) {
    check(settings_);
    BoardModel board = load();
    apply_topics(board);
    if (board.pose.topic.empty()) {
      throw std::runtime_error("neither the vehicle nor the parameter pose_topic names a topic");
    }
    odometer_ = std::make_unique<Odometer>(board.model, board.pose.lever);
    board_ = std::move(board);
    command_ = Signal(board_.inputs);
    scale_ = Signal(board_.scales);
    map_frame_ = settings_.map_frame;
  }

  const Settings& settings() const { return settings_; }
  const std::string& pose_topic() const { return board_.pose.topic; }
  const std::string& map_frame() const { return map_frame_; }  // empty until a pose has come

  /// Topics of commands and scale signals, each once.
  std::set<std::string> number_topics() const {
    std::set<std::string> topics;
    for (const auto* channels : {&board_.inputs, &board_.scales}) {
      for (const Channel& c : *channels) topics.insert(c.topic);
    }
    return topics;
  }

  /// What a topic's type is, before its first message; again after its type has changed. Throws
  /// std::runtime_error where the vehicle's fields are not in such messages.
  void set_type(const std::string& topic, const std::string& type) {
    const Shape& shape = known_shape(topic, type);
    for (Signal* signal : {&command_, &scale_}) signal->set_type(topic, shape);
  }

  void pose(const PoseMessage& in) {
    const PoseSource& source = board_.pose;
    if (!source.parent.empty() && !in.frame.empty() && in.frame != source.parent) return;
    if (!source.child.empty() && !in.child.empty() && in.child != source.child) return;
    if (settings_.map_frame.empty() && !in.frame.empty()) map_frame_ = in.frame;
    const double eta[kPose] = {source.x.value(in.eta[0]), source.y.value(in.eta[1]),
                               source.heading.value(in.eta[2])};
    const double gain[kPose] = {source.x.gain, source.y.gain, source.heading.gain};
    double covariance[kPose * kPose];
    for (int i = 0; i < kPose; ++i) {
      for (int j = 0; j < kPose; ++j) {
        covariance[kPose * i + j] = gain[i] * gain[j] * in.covariance[kPose * i + j];
      }
    }
    const bool own = settings_.pose_covariance && in.has_covariance;
    odometer_->pose(chosen(in.stamp, in.arrival, source.clock), eta, own ? covariance : nullptr);
  }

  void numbers(const NumbersMessage& in) {
    const std::int64_t stamp = chosen(in.stamp, in.arrival, board_.commands.clock);
    if (command_.update(in)) odometer_->command(stamp, command_.values());
    if (scale_.update(in)) odometer_->scale(stamp, scale_.values());
  }

  /// What is to be published now [ns], if anything is known.
  Odometry tick(std::int64_t now) {
    last_ = odometer_->at(now);
    return last_;
  }

  /// How it is going, by the last tick.
  Diagnosis diagnose() const {
    Diagnosis out;
    const std::uint32_t health = last_.motion.health | (last_.known ? 0U : kNoPose);
    for (const HealthWords& words : kHealthWords) {
      if ((health & words.flag) == 0U) continue;
      out.message += (out.message.empty() ? "" : "; ") + std::string(words.advice);
      out.values.emplace_back(words.name, "yes");
    }
    if (out.message.empty()) out.message = "odometry by the model and poses";
    out.level = (health & kNoPose) != 0U ? Diagnosis::kError
                                         : (health != 0U ? Diagnosis::kWarn : Diagnosis::kOk);
    out.values.emplace_back("model", board_.name + " (" + settings_.model + ")");
    out.values.emplace_back("age of the last pose used [s]", age());
    static constexpr const char* kNames[kSources] = {"commands", "scales", "poses"};
    for (int s = 0; s < kSources; ++s) {
      for (int o = 0; o < kOutcomes; ++o) {
        const auto n = odometer_->count(static_cast<Source>(s), static_cast<Taken>(o));
        if (n == 0 && o != 0) continue;
        out.values.emplace_back(std::string(kNames[s]) + " " + kTakenWords[o], std::to_string(n));
      }
    }
    return out;
  }

  /// Reloads the model file. Empty: done; else, in one line, why the previous model stays in use.
  std::string reload() {
    try {
      BoardModel board = load();
      apply_topics(board);
      expect_same(board_.inputs, board.inputs, "inputs");
      expect_same(board_.scales, board.scales, "scales");
      odometer_->reload(board.model, board.pose.lever);
      board_.model = board.model;
      board_.name = board.name;
      return "";
    } catch (const std::runtime_error& error) {
      return error.what();
    }
  }

 private:
  BoardModel load() const {
    BoardModel board = load_model(settings_.model);
    board.model.window = settings_.window;
    board.model.boat.frame =
        settings_.body_fixed_disturbance ? DisturbanceFrame::kBody : DisturbanceFrame::kEarth;
    board.model.boat.current[0] = settings_.current_x;
    board.model.boat.current[1] = settings_.current_y;
    return board;
  }

  void apply_topics(BoardModel& board) const {
    if (!settings_.pose_topic.empty()) board.pose.topic = settings_.pose_topic;
    for (Channel& c : board.inputs) {
      const bool own = c.topic.empty() || c.topic == board.commands.topic;
      if (own && !settings_.command_topic.empty()) c.topic = settings_.command_topic;
    }
    expect_named(board, settings_.model);
  }

  static std::int64_t chosen(std::int64_t header, std::int64_t arrival, Clock clock) {
    return header == 0 || clock == Clock::kBag ? arrival : header;
  }

  static void expect_same(const std::vector<Channel>& before, const std::vector<Channel>& now,
                          const std::string& what) {
    Words old;
    Words own;
    for (const Channel& c : before) old.push_back(c.topic + " " + c.field + " as " + c.name);
    for (const Channel& c : now) own.push_back(c.topic + " " + c.field + " as " + c.name);
    if (old != own) {
      throw std::runtime_error("the new model has other " + what + ": " + joined(own) +
                               "; expected " + joined(old) + " as before; restart the node");
    }
  }

  std::string age() const {
    const double seconds = last_.motion.time - last_.motion.last_pose;
    return std::abs(seconds) < 1e9 ? std::to_string(seconds) : "none yet";
  }

  Settings settings_;
  BoardModel board_;
  std::unique_ptr<Odometer> odometer_;
  Signal command_;
  Signal scale_;
  std::string map_frame_;
  Odometry last_;
};

}  // namespace seatrial::ros
