// SPDX-License-Identifier: MIT
// The odometry node without ROS: what the shells for ROS 1 and ROS 2 do with each message and at
// each tick. All stamps are nanoseconds; `arrival` is the node's own clock.
#pragma once
#include <deque>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <variant>
#include <vector>

#include "seatrial/onboard/odometer.hpp"
#include "seatrial_ros/diagnosis.hpp"
#include "seatrial_ros/live_stream.hpp"
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
  explicit Node(Settings settings);

  const Settings& settings() const { return settings_; }
  const std::string& pose_topic() const { return board_.pose.topic; }
  const std::string& model_path() const { return path_; }      // of the model in use
  const std::string& map_frame() const { return map_frame_; }  // empty until a pose has come

  /// Topics of commands and scale signals, each once.
  std::set<std::string> number_topics() const;

  /// Throws std::runtime_error where a topic that it hears is one of those that it publishes: each
  /// message would come back at once. `resolved` is a topic's full name.
  template <class Resolved>
  void refuse_own_topics(const std::set<std::string>& published, const Resolved& resolved) const {
    std::set<std::string> heard = number_topics();
    heard.insert(pose_topic());
    for (const std::string& topic : heard) {
      const std::string name = resolved(topic);
      if (published.count(name) != 0) refuse_own_topic(name);
    }
  }

  /// What a topic's type is, before its first message; again after its type has changed. Throws
  /// std::runtime_error where the vehicle's fields are not in such messages.
  void set_type(const std::string& topic, const std::string& type);

  void pose(const PoseMessage& in);
  void numbers(const NumbersMessage& in);

  /// What is to be published now [ns], if it is known. While inputs are stamped ahead of `now` by
  /// more than the window, it is not: the filter keeps no state so old.
  Odometry tick(std::int64_t now);

  /// Diagnosis at `now` [ns], also where no tick has come since the inputs stopped.
  Diagnosis diagnose(std::int64_t now);

  /// Changes to `adapted_model` where that was written since the node started, or since the last
  /// call that changed to it. Empty: nothing to do, or done; else why the previous model stays.
  std::string adopt();

  /// Reloads the model file, with how it reads messages of the same topics. Empty: done; else, in
  /// one line, why the previous model stays in use.
  std::string reload();

 private:
  [[noreturn]] static void refuse_own_topic(const std::string& name);
  template <class Message>
  void keep(const Message& in);
  void take(const PoseMessage& in, bool first);  // first: not read again for another model
  void take(const NumbersMessage& in, bool first);
  void send_pose(std::int64_t stamp, const double* eta, const double* covariance);
  std::string change_to(const std::string& path);
  BoardModel load(const std::string& path) const;
  void apply_topics(BoardModel& board) const;
  double ahead(std::int64_t now) const;  // [s] by which the newest input is stamped after now
  std::string silence_fault(std::int64_t now) const;
  std::string timing_fault(std::int64_t now) const;

  Settings settings_;
  std::string path_;  // of the model in use
  std::int64_t adapted_ =
      0;  // [ns] when the adapted model was written that is in use, or was there
  LiveStream live_;
  BoardModel board_;
  std::unique_ptr<Odometer> odometer_;
  Signal command_;
  Signal scale_;
  std::map<std::string, std::string> types_;  // of topics of commands and scale signals
  std::deque<std::variant<PoseMessage, NumbersMessage>> recent_;
  std::string map_frame_;
  double late_ = 0.0;            // [s] of the last pose that came too late, behind the newest input
  std::int64_t late_at_ = 0;     // [ns] when that came
  std::int64_t numbers_at_ = 0;  // [ns] when the last command or scale came; 0: none
};

/// Adopts the changed boat's model, if there is one, and calls say(failed, text) with the outcome.
template <class Say>
void adopt(Node& node, const Say& say) {
  const std::string before = node.model_path();
  const std::string wrong = node.adopt();
  if (!wrong.empty()) {
    say(true, wrong + "; the previous model stays in use");
  } else if (node.model_path() != before) {
    say(false, node.model_path() + ": the model of the changed boat");
  }
}

/// Reloads the model file, and calls say(failed, text) with the outcome. Empty: done; else why not.
template <class Say>
std::string reload(Node& node, const Say& say) {
  std::string wrong = node.reload();
  say(!wrong.empty(), wrong.empty() ? node.settings().model + ": reloaded"
                                    : wrong + "; the previous model stays in use");
  return wrong;
}

}  // namespace seatrial::ros
