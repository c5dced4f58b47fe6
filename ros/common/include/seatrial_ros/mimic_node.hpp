// SPDX-License-Identifier: MIT
// The mimic's node without ROS: its parameters, and what the shells for ROS 1 and ROS 2 do with
// commands, the carrier's odometry and time. Stamps are nanoseconds.
#pragma once
#include <cmath>
#include <memory>
#include <set>
#include <string>
#include <type_traits>
#include <utility>

#include "seatrial/simulation/mimic.hpp"
#include "seatrial_ros/diagnosis.hpp"
#include "seatrial_ros/settings.hpp"
#include "seatrial_ros/signal.hpp"

namespace seatrial::ros {

struct MimicSettings {
  std::string model;
  std::string command_topic;
  double rate = 50.0;
  Carrier carrier;
};

/// As of `Settings`.
template <class Given, class Visit>
std::enable_if_t<std::is_same_v<std::remove_const_t<Given>, MimicSettings>> each_parameter(
    Given& s, Visit&& visit) {
  visit(Parameter{"model", "path of model.yaml, as `seatrial identify` writes it"}, s.model);
  visit(Parameter{"command_topic", "commands to the boat; empty: the vehicle's"}, s.command_topic);
  visit(Parameter{"rate", "of cmd_vel [Hz]", 1.0, 200.0}, s.rate);
  visit(Parameter{"speed", "the carrier's highest [m/s]", 0.001, 20.0}, s.carrier.speed);
  visit(Parameter{"yaw_rate", "its highest [rad/s]", 0.001, 50.0}, s.carrier.yaw_rate);
  visit(Parameter{"acceleration", "its highest [m/s^2]", 0.001, 100.0}, s.carrier.acceleration);
  visit(Parameter{"yaw_acceleration", "its highest [rad/s^2]", 0.001, 200.0},
        s.carrier.yaw_acceleration);
  visit(Parameter{"lag", "its delay and time constant together [s]", 0.0, 1.0}, s.carrier.lag);
  visit(Parameter{"gain", "on the carrier's error to the virtual boat's pose [1/s]", 0.0, 20.0},
        s.carrier.gain);
  visit(Parameter{"pose_timeout", "age of the carrier's pose from which it runs open-loop [s]",
                  0.01, 60.0},
        s.carrier.pose_timeout);
  visit(Parameter{"lost", "distance to the virtual boat at which it is stopped [m]", 0.01, 100.0},
        s.carrier.lost);
}

/// What the flags say, in the order of their bits.
inline constexpr const char* kMimicAdvice[] = {
    "no pose of the carrier: its drift is not corrected; check its odometry",
    "the boat exceeds the carrier's speed limit: it lags behind. Drive slower, or raise the limit",
    "the boat exceeds the carrier's acceleration limit: it lags behind for a while",
    "the carrier is too far from the virtual boat and is stopped: put it in place and restart",
    "no valid command: the virtual boat's thrust is zero",
    "the model diverges: the carrier is stopped; identify it again"};

class MimicNode {
 public:
  /// Throws std::runtime_error, with one line for whoever starts it.
  explicit MimicNode(MimicSettings settings) : settings_(std::move(settings)) {
    check_ranges(settings_);
    if (settings_.model.empty()) {
      throw std::runtime_error("parameter model is empty; expected the path of a model.yaml");
    }
    BoardModel board = load_model(settings_.model);
    if (!settings_.command_topic.empty()) {
      for (Channel& c : board.inputs) c.topic = settings_.command_topic;
    }
    expect_named(board, settings_.model);
    name_ = board.name;
    command_ = Signal(board.inputs);
    const OnboardModel& m = board.model;
    const auto plant = std::make_unique<Plant>(m.boat.structure, m.boat.coefficient, m.chain, m.q,
                                               m.boat.longest_step);
    mimic_ = std::make_unique<Mimic>(*plant, settings_.carrier, m.command_timeout);
  }

  const MimicSettings& settings() const { return settings_; }

  std::set<std::string> number_topics() const {
    std::set<std::string> topics;
    for (const Channel& c : command_.channels()) topics.insert(c.topic);
    return topics;
  }

  /// As of `Node`.
  void set_type(const std::string& topic, const std::string& type) {
    command_.set_type(topic, known_shape(topic, type));
  }

  /// A command acts when it comes.
  void numbers(const NumbersMessage& in) {
    if (!command_.update(in)) return;
    const bool taken =
        mimic_->command(seconds(in.arrival), command_.values(), static_cast<int>(command_.size()));
    ++(taken ? commands_ : refused_);
  }

  /// The carrier's own pose (3) at its header's stamp; 0: none, then its arrival.
  void pose(std::int64_t stamp, std::int64_t arrival, const double* eta) {
    ++(mimic_->pose(seconds(stamp == 0 ? arrival : stamp), eta) ? poses_ : refused_);
  }

  /// What the carrier is to do from now on.
  MimicOutput tick(std::int64_t now) {
    last_ = mimic_->at(seconds(now));
    return last_;
  }

  Diagnosis diagnose() const {
    Diagnosis out;
    for (std::size_t i = 0; i < std::size(kMimicAdvice); ++i) {
      if ((last_.health >> i & 1U) == 0U) continue;
      out.message += (out.message.empty() ? "" : "; ") + words(i);
    }
    const bool stopped = (last_.health & (kMimicLost | kMimicDiverged)) != 0U;
    out.level = stopped ? Diagnosis::kError : (last_.health != 0U ? Diagnosis::kWarn : out.level);
    if (out.message.empty()) out.message = "the carrier moves as the boat would";
    out.values.emplace_back("model", name_ + " (" + settings_.model + ")");
    out.values.emplace_back("mismatch forward [m]", std::to_string(last_.mismatch[0]));
    out.values.emplace_back("mismatch left [m]", std::to_string(last_.mismatch[1]));
    out.values.emplace_back("mismatch heading [rad]", std::to_string(last_.mismatch[2]));
    out.values.emplace_back("commands used", std::to_string(commands_));
    out.values.emplace_back("poses used", std::to_string(poses_));
    out.values.emplace_back("inputs not used", std::to_string(refused_));
    return out;
  }

 private:
  /// Advice of a flag; of a limit with the commanded and the allowed value.
  std::string words(std::size_t flag) const {
    const Carrier& most = settings_.carrier;
    const std::string advice = kMimicAdvice[flag];
    if (1U << flag == kMimicSpeedLimited) {
      return advice + " (commanded " + plain(std::hypot(last_.asked[0], last_.asked[1])) +
             " m/s, " + plain(std::abs(last_.asked[2])) + " rad/s; at most " + plain(most.speed) +
             ", " + plain(most.yaw_rate) + ")";
    }
    if (1U << flag == kMimicLost) {
      return advice + " (" + plain(std::hypot(last_.mismatch[0], last_.mismatch[1])) +
             " m away; at most " + plain(most.lost) + ")";
    }
    return advice;
  }

  /// From the first input on, so that a double has the digits.
  double seconds(std::int64_t stamp) {
    if (origin_ == 0) origin_ = stamp;
    return static_cast<double>(stamp - origin_) * 1e-9;
  }

  MimicSettings settings_;
  std::string name_;
  Signal command_;
  std::unique_ptr<Mimic> mimic_;
  MimicOutput last_;
  std::int64_t origin_ = 0;  // [ns]
  long commands_ = 0;
  long poses_ = 0;
  long refused_ = 0;
};

}  // namespace seatrial::ros
