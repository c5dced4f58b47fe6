// SPDX-License-Identifier: MIT
// The tracking controller's node without ROS: its safety, and what the shells for ROS 1 and ROS 2
// do with odometry, references and time. Stamps are nanoseconds of the node's own clock.
#pragma once
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "seatrial/control/tracking.hpp"
#include "seatrial_ros/command_writer.hpp"
#include "seatrial_ros/diagnosis.hpp"
#include "seatrial_ros/gains_file.hpp"
#include "seatrial_ros/signal.hpp"
#include "seatrial_ros/target.hpp"

namespace seatrial::ros {

/// What the last tick did; all but the first two: commands are zero.
enum class Conduct { kFollowing, kLimited, kNoReference, kNoOdometry, kUncertain, kOtherFrame };

struct ConductWords {
  Diagnosis::Level level;
  const char* advice;
};

/// In the order of Conduct.
inline constexpr ConductWords kConductWords[] = {
    {Diagnosis::kOk, "follows the reference"},
    {Diagnosis::kWarn, "the reference needs more thrust than available: slow it down"},
    {Diagnosis::kWarn, "no reference, or too old a one: commands are zero"},
    {Diagnosis::kError, "no odometry, or too old: commands are zero; check the odometry node"},
    {Diagnosis::kError,
     "pose or velocity is too uncertain: commands are zero; check that poses arrive"},
    {Diagnosis::kError, "the reference is in another frame than the pose: commands are zero"}};

class TrackingNode {
 public:
  /// Throws std::runtime_error, with one line for whoever starts it.
  explicit TrackingNode(TrackingSettings settings) : settings_(std::move(settings)) {
    check_ranges(settings_);
    if (settings_.model.empty()) {
      throw std::runtime_error("parameter model is empty; expected the path of a model.yaml");
    }
    BoardModel board = load_model(settings_.model);
    if (!settings_.command_topic.empty()) {
      for (Channel& c : board.inputs) c.topic = settings_.command_topic;
    }
    expect_named(board, settings_.model);
    gains_ = load_gains(settings_, board);
    topics_ = command_topics(board.inputs);
    name_ = board.name;
    const OnboardModel& m = board.model;
    std::copy(m.velocity_spread, m.velocity_spread + kAxes, unknown_);
    const auto& boat = m.boat;
    if (const auto steering = detail::steering_of(m, gains_.gains.limit)) {
      tracker_ =
          std::make_unique<Tracker>(boat.structure, boat.coefficient, *steering, gains_.gains);
    } else if (gains_.allocation) {
      const auto allocator = std::make_unique<Allocator>(*gains_.allocation);
      tracker_ =
          std::make_unique<Tracker>(boat.structure, boat.coefficient, *allocator, gains_.gains);
    } else {
      tracker_ = std::make_unique<Tracker>(boat.structure, boat.coefficient, m.chain.allocation,
                                           gains_.gains);
    }
  }

  const TrackingSettings& settings() const { return settings_; }
  const std::vector<CommandTopic>& topics() const { return topics_; }
  double rate() const { return gains_.rate; }  // [Hz]

  /// Velocity; without control_in_map the pose, too.
  void odometry(const MotionMessage& in) {
    if (take(in, velocity_.stamp, settings_.timeout)) velocity_ = in;
  }

  /// The pose in map.
  void map_pose(const MotionMessage& in) {
    if (take(in, map_pose_.stamp, settings_.timeout)) map_pose_ = in;
  }

  void reference(const MotionMessage& in) {
    if (!take(in, reference_, settings_.reference_timeout)) return;
    reference_ = in.stamp;
    target_.follow(in);
  }

  void goal(const MotionMessage& in) {
    if (take(in, 0, 0.0)) target_.hold(in);
  }

  /// Commands to all inputs from now on.
  const double* tick(std::int64_t now) {
    std::fill(values_, values_ + kMaxCommands, 0.0);
    conduct_ = hindrance(now);
    if (conduct_ == Conduct::kFollowing) {
      follow(now);
    } else {
      tracker_->forget();
      last_ = 0;
    }
    return values_;
  }

  /// All thrusters off.
  const double* zero() {
    std::fill(values_, values_ + kMaxCommands, 0.0);
    return values_;
  }

  Conduct conduct() const { return conduct_; }

  Diagnosis diagnose() const {
    const ConductWords& words = kConductWords[static_cast<std::size_t>(conduct_)];
    Diagnosis out;
    out.level = words.level;
    out.message = words.advice;
    out.values.emplace_back("model", name_ + " (" + settings_.model + ")");
    out.values.emplace_back("gains", settings_.gains.empty() ? "parameters" : settings_.gains);
    static constexpr const char* kErrors[kAxes] = {"error forward [m]", "error left [m]",
                                                   "error heading [rad]"};
    for (int i = 0; i < kAxes; ++i) out.values.emplace_back(kErrors[i], std::to_string(error_[i]));
    out.values.emplace_back("frame of the reference", target_.frame());
    out.values.emplace_back("frame of the pose", pose().frame);
    out.values.emplace_back("inputs not used", std::to_string(refused_));
    return out;
  }

 private:
  /// Numbers, and newer than the newest [ns] of its topic; one older by more than `timeout` [s]
  /// means a clock that was set back.
  bool take(const MotionMessage& in, std::int64_t newest, double timeout) {
    const double late = seconds(newest - in.stamp);
    const bool used = in.is_finite() && in.stamp > 0 && !(late > 0.0 && late <= timeout);
    if (!used) ++refused_;
    return used;
  }

  const MotionMessage& pose() const { return settings_.control_in_map ? map_pose_ : velocity_; }

  /// What forbids to follow; kFollowing: nothing.
  Conduct hindrance(std::int64_t now) const {
    if (!fresh(velocity_, now) || !fresh(pose(), now)) return Conduct::kNoOdometry;
    if (uncertain(velocity_.nu_variance) || uncertain(pose())) return Conduct::kUncertain;
    if (!target_.known() || target_.age(now) > settings_.reference_timeout) {
      return Conduct::kNoReference;
    }
    const bool said = !target_.frame().empty() && !pose().frame.empty();
    if (said && target_.frame() != pose().frame) return Conduct::kOtherFrame;
    return Conduct::kFollowing;
  }

  bool fresh(const MotionMessage& in, std::int64_t now) const {
    return in.stamp > 0 && std::abs(seconds(now - in.stamp)) <= settings_.timeout;
  }

  /// Whether a velocity is known no better than before the first pose.
  bool uncertain(const double* variance) const {
    for (int i = 0; i < kAxes; ++i) {
      if (!(std::sqrt(variance[i]) < kKnown * unknown_[i])) return true;
    }
    return false;
  }

  /// In odom the pose drifts by design, so that its covariance says nothing of health.
  bool uncertain(const MotionMessage& in) const {
    if (!settings_.control_in_map || !in.has_covariance) return false;
    const double position = std::sqrt(std::max(in.covariance[0], in.covariance[4]));
    const double heading = std::sqrt(in.covariance[8]);
    return !(position <= settings_.position_uncertainty &&
             heading <= settings_.heading_uncertainty);
  }

  void follow(std::int64_t now) {
    double eta[kAxes];
    moved(pose(), seconds(now - pose().stamp), eta);
    const Reference wanted = target_.at(now);
    const Reference ahead = target_.at(now + std::llround(gains_.lead * 1e9));
    const double dt = last_ == 0 ? 0.0 : seconds(now - last_);
    last_ = now;
    const Tracked done = tracker_->command(dt, eta, velocity_.nu, wanted, ahead, values_);
    if (done == Tracked::kLimited) conduct_ = Conduct::kLimited;
    const double off[kAxes] = {wanted.eta[0] - eta[0], wanted.eta[1] - eta[1],
                               wrap(wanted.eta[2] - eta[2])};
    earth_to_body(eta[2], off, error_);
  }

  /// A pose as old as `age` [s], moved on to now by the velocity.
  void moved(const MotionMessage& from, double age, double* eta) const {
    double rate[kAxes];
    body_to_earth(from.eta[2], velocity_.nu, rate);
    for (int i = 0; i < kAxes; ++i) eta[i] = from.eta[i] + age * rate[i];
  }

  static double seconds(std::int64_t span) { return static_cast<double>(span) * 1e-9; }

  static constexpr double kKnown = 1.0 - 1e-9;  // of `unknown_`: rounding

  TrackingSettings settings_;
  double unknown_[kAxes] =
      {};  // [m/s, m/s, rad/s] deviation of a velocity of which nothing is known
  BoardGains gains_;
  std::string name_;
  std::vector<CommandTopic> topics_;
  std::unique_ptr<Tracker> tracker_;
  MotionMessage velocity_;
  MotionMessage map_pose_;
  Target target_;
  std::int64_t reference_ = 0;  // [ns] stamp of the newest one; 0: none
  Conduct conduct_ = Conduct::kNoOdometry;
  double values_[kMaxCommands] = {};
  double error_[kAxes] = {};  // of the last tick that followed, forward, left [m], heading [rad]
  std::int64_t last_ = 0;     // [ns] of that tick; 0: none since a stop
  long refused_ = 0;
};

}  // namespace seatrial::ros
