// SPDX-License-Identifier: MIT
// The tracking controller's node for ROS 1: odometry and a reference in, commands to the boat out.
// What is done with them is in seatrial_ros/tracking_node.hpp.
#include <geometry_msgs/PoseStamped.h>
#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <nav_msgs/Odometry.h>
#include <ros/ros.h>

#include "commands.hpp"
#include "diagnostics.hpp"
#include "last_act.hpp"
#include "numbers.hpp"
#include "run.hpp"
#include "seatrial_ros/messages.hpp"
#include "seatrial_ros/tracking_node.hpp"

namespace {

namespace sr = seatrial::ros;
using sr::nanoseconds;

class Shell {
 public:
  Shell()
      : node_(sr::read_settings<sr::TrackingSettings>(own_)),
        commands_(public_, node_.topics()),
        diagnostics_(public_.advertise<diagnostic_msgs::DiagnosticArray>("/diagnostics", kQueue)),
        subscribers_{
            subscribe("odom", &Shell::on_odometry), subscribe("map_pose", &Shell::on_map_pose),
            subscribe("reference", &Shell::on_reference), subscribe("goal", &Shell::on_goal)},
        timer_(public_.createTimer(ros::Duration(1.0 / node_.rate()),
                                   [this](const ros::TimerEvent&) { publish(); })),
        slow_(public_.createWallTimer(ros::WallDuration(1.0),
                                      [this](const ros::WallTimerEvent&) { diagnose(); })),
        last_act_(public_, [this] { end(); }) {}

 private:
  static constexpr std::uint32_t kQueue = 10;

  template <class Message>
  ros::Subscriber subscribe(const char* topic, void (Shell::*hear)(const Message&)) {
    return public_.subscribe(topic, kQueue, hear, this, ros::TransportHints().tcpNoDelay());
  }

  template <class Header, class Pose>
  static sr::MotionMessage located(const Header& header, const Pose& pose) {
    sr::MotionMessage out;
    const ros::Time stamp = header.stamp.isZero() ? ros::Time::now() : header.stamp;
    out.stamp = nanoseconds(stamp);
    out.frame = header.frame_id;
    sr::read(pose, out.eta);
    return out;
  }

  static sr::MotionMessage moving(const nav_msgs::Odometry& message) {
    sr::MotionMessage out = located(message.header, message.pose.pose);
    sr::read_twist(message.twist, out.nu, out.nu_variance);
    return out;
  }

  void on_odometry(const nav_msgs::Odometry& message) { node_.odometry(moving(message)); }

  void on_map_pose(const geometry_msgs::PoseWithCovarianceStamped& message) {
    sr::MotionMessage in = located(message.header, message.pose.pose);
    in.has_covariance = sr::read_covariance(message.pose.covariance, in.covariance);
    node_.map_pose(in);
  }

  void on_reference(const nav_msgs::Odometry& message) { node_.reference(moving(message)); }

  void on_goal(const geometry_msgs::PoseStamped& message) {
    node_.goal(located(message.header, message.pose));
  }

  /// The boat is left with its thrusters off.
  void end() {
    timer_.stop();
    commands_.publish(ros::Time::now(), node_.zero());
  }

  void publish() {
    const ros::Time now = ros::Time::now();
    if (now.isZero()) return;  // simulated time that has not begun
    const sr::Conduct before = node_.conduct();
    commands_.publish(now, node_.tick(nanoseconds(now)));
    const bool stops = node_.conduct() > sr::Conduct::kLimited;
    if (stops && node_.conduct() != before) diagnose();  // at once, not within a second
  }

  void diagnose() { diagnostics_.publish(sr::diagnostics(node_.diagnose(), "tracking")); }

  ros::NodeHandle public_;
  ros::NodeHandle own_{"~"};
  sr::TrackingNode node_;
  sr::CommandPublishers commands_;
  ros::Publisher diagnostics_;
  ros::Subscriber subscribers_[4];
  ros::Timer timer_;
  ros::WallTimer slow_;
  sr::LastAct last_act_;
};

}  // namespace

int main(int argc, char** argv) {
  return sr::run("seatrial_tracking", [&] {
    sr::init_with_last_act(argc, argv, "seatrial_tracking");
    Shell shell;
    ros::spin();
  });
}
