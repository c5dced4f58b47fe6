// SPDX-License-Identifier: MIT
// The tracking controller's node for ROS 2: odometry and a reference in, commands to the boat out.
// What is done with them is in seatrial_ros/tracking_node.hpp.
#include <diagnostic_msgs/msg/diagnostic_array.hpp>
#include <geometry_msgs/msg/pose_stamped.hpp>
#include <geometry_msgs/msg/pose_with_covariance_stamped.hpp>
#include <mutex>
#include <nav_msgs/msg/odometry.hpp>
#include <rclcpp/rclcpp.hpp>

#include "commands.hpp"
#include "component.hpp"
#include "diagnostics.hpp"
#include "nodes.hpp"
#include "parameters.hpp"
#include "seatrial_ros/messages.hpp"
#include "seatrial_ros/tracking_node.hpp"
#include "topics.hpp"

namespace seatrial_odometry {

namespace sr = seatrial::ros;
using namespace std::chrono_literals;
using diagnostic_msgs::msg::DiagnosticArray;
using geometry_msgs::msg::PoseStamped;
using geometry_msgs::msg::PoseWithCovarianceStamped;
using nav_msgs::msg::Odometry;

class TrackingNode : public rclcpp::Node {
 public:
  explicit TrackingNode(const rclcpp::NodeOptions& options)
      : rclcpp::Node("seatrial_tracking", options),
        node_(sr::read_settings<sr::TrackingSettings>(*this)),
        commands_(*this, node_.topics()),
        diagnostics_(create_publisher<DiagnosticArray>("/diagnostics", kQueue)),
        subscriptions_{
            sr::hear<Odometry>(*this, "odom", sr::stream(),
                               [this](const Odometry& m) { node_.odometry(moving(m)); }),
            sr::hear<PoseWithCovarianceStamped>(
                *this, "map_pose", sr::stream(),
                [this](const PoseWithCovarianceStamped& m) { on_map_pose(m); }),
            sr::hear<Odometry>(*this, "reference", sr::stream(),
                               [this](const Odometry& m) { node_.reference(moving(m)); }),
            // reliable, as it is sent once
            sr::hear<PoseStamped>(
                *this, "goal", rclcpp::QoS(kQueue),
                [this](const PoseStamped& m) { node_.goal(located(m.header, m.pose)); })},
        timer_(rclcpp::create_timer(this, get_clock(),
                                    rclcpp::Duration::from_seconds(1.0 / node_.rate()),
                                    [this] { publish(); })),
        slow_(create_wall_timer(1s, [this] { diagnose(); })),
        last_act_(*this, [this] { stop(); }) {}

 private:
  static constexpr std::size_t kQueue = 10;

  template <class Header, class Pose>
  sr::MotionMessage located(const Header& header, const Pose& pose) const {
    sr::MotionMessage out;
    out.stamp = sr::nanoseconds(header.stamp);
    if (out.stamp == 0) out.stamp = now().nanoseconds();
    out.frame = header.frame_id;
    sr::read(pose, out.eta);
    return out;
  }

  sr::MotionMessage moving(const Odometry& message) const {
    sr::MotionMessage out = located(message.header, message.pose.pose);
    sr::read_twist(message.twist, out.nu, out.nu_variance);
    return out;
  }

  void on_map_pose(const PoseWithCovarianceStamped& message) {
    sr::MotionMessage in = located(message.header, message.pose.pose);
    in.has_covariance = sr::read_covariance(message.pose.covariance, in.covariance);
    node_.map_pose(in);
  }

  /// The boat is left with its thrusters off.
  void stop() {
    const std::lock_guard<std::mutex> held(mutex_);
    stopped_ = true;
    commands_.publish(now(), node_.zero());
  }

  void publish() {
    const std::lock_guard<std::mutex> held(mutex_);
    if (stopped_) return;
    const rclcpp::Time stamp = now();
    if (stamp.nanoseconds() == 0) return;  // simulated time that has not begun
    const sr::Conduct before = node_.conduct();
    commands_.publish(stamp, node_.tick(stamp.nanoseconds()));
    const bool stops = node_.conduct() > sr::Conduct::kLimited;
    if (stops && node_.conduct() != before) diagnose();  // at once, not within a second
  }

  void diagnose() { diagnostics_->publish(sr::diagnostics(*this, node_.diagnose(), "tracking")); }

  sr::TrackingNode node_;
  sr::CommandPublishers commands_;
  rclcpp::Publisher<DiagnosticArray>::SharedPtr diagnostics_;
  sr::SubscriptionPtr subscriptions_[4];
  rclcpp::TimerBase::SharedPtr timer_;
  rclcpp::TimerBase::SharedPtr slow_;
  std::mutex mutex_;  // the last act may be in another thread
  bool stopped_ = false;
  LastAct last_act_;
};

NodePtr make_tracking(const rclcpp::NodeOptions& options) {
  return std::make_shared<TrackingNode>(options);
}

}  // namespace seatrial_odometry

SEATRIAL_COMPONENT(seatrial_odometry::TrackingNode)
