// SPDX-License-Identifier: MIT
#include "seatrial_ros/mimic_node.hpp"

#include <cmath>

namespace seatrial::ros {

MimicNode::MimicNode(MimicSettings settings) : settings_(std::move(settings)) {
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
  const OnboardModel& m = board.model;
  const double timeout =
      std::isfinite(m.command_timeout) ? m.command_timeout : settings_.command_timeout;
  command_ = Signal(board.inputs, timeout);
  const auto plant = std::make_unique<Plant>(m.boat.structure, m.boat.coefficient, m.chain, m.q,
                                             m.boat.longest_step);
  mimic_ = std::make_unique<Mimic>(*plant, settings_.carrier, timeout);
}

std::set<std::string> MimicNode::number_topics() const {
  std::set<std::string> topics;
  for (const Channel& c : command_.channels()) topics.insert(c.topic);
  return topics;
}

void MimicNode::numbers(const NumbersMessage& in) {
  if (!command_.update(in)) return;
  const bool taken =
      mimic_->command(seconds(in.arrival), command_.values(), static_cast<int>(command_.size()));
  ++(taken ? commands_ : refused_);
}

void MimicNode::pose(std::int64_t stamp, std::int64_t arrival, const double* eta) {
  ++(mimic_->pose(seconds(stamp == 0 ? arrival : stamp), eta) ? poses_ : refused_);
}

MimicOutput MimicNode::tick(std::int64_t now) {
  last_ = mimic_->at(seconds(now));
  return last_;
}

Diagnosis MimicNode::diagnose() const {
  Diagnosis out;
  for (const MimicWords& words : kMimicWords) {
    if ((last_.health & words.flag) == 0U) continue;
    out.message += (out.message.empty() ? "" : "; ") + advice(words);
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

/// Advice of a flag; of a limit with the commanded and the allowed value.
std::string MimicNode::advice(const MimicWords& words) const {
  const Carrier& most = settings_.carrier;
  std::string advice = words.advice;
  if (words.flag == kMimicSpeedLimited) {
    return advice + " (commanded " + plain(std::hypot(last_.asked[0], last_.asked[1])) + " m/s, " +
           plain(std::abs(last_.asked[2])) + " rad/s; at most " + plain(most.speed) + ", " +
           plain(most.yaw_rate) + ")";
  }
  if (words.flag == kMimicLost) {
    return advice + " (" + plain(std::hypot(last_.mismatch[0], last_.mismatch[1])) +
           " m away; at most " + plain(most.lost) + ")";
  }
  return advice;
}

/// From the first input on, so that a double has the digits.
double MimicNode::seconds(std::int64_t stamp) {
  if (origin_ == 0) origin_ = stamp;
  return static_cast<double>(stamp - origin_) * 1e-9;
}

}  // namespace seatrial::ros
