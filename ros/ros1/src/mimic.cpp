// SPDX-License-Identifier: MIT
// The mimic's node for ROS 1: commands to a virtual boat and the carrier's odometry in, cmd_vel
// out. What is done with them is in seatrial_ros/mimic_node.hpp.
#include <geometry_msgs/Twist.h>
#include <geometry_msgs/TwistStamped.h>
#include <nav_msgs/Odometry.h>
#include <ros/ros.h>

#include "diagnostics.hpp"
#include "last_act.hpp"
#include "numbers.hpp"
#include "run.hpp"
#include "seatrial_ros/mimic_node.hpp"
#include "seatrial_ros/sim_messages.hpp"

namespace {

namespace sr = seatrial::ros;
using sr::nanoseconds;

class Shell {
 public:
  Shell()
      : node_(sr::read_settings<sr::MimicSettings>(own_)),
        velocity_(node_.settings().enable_stamped_cmd_vel
                      ? public_.advertise<geometry_msgs::TwistStamped>("cmd_vel", kQueue)
                      : public_.advertise<geometry_msgs::Twist>("cmd_vel", kQueue)),
        boat_(public_.advertise<nav_msgs::Odometry>("virtual_boat", kQueue)),
        diagnostics_(public_.advertise<diagnostic_msgs::DiagnosticArray>("/diagnostics", kQueue)),
        numbers_(public_, node_, [this](const sr::NumbersMessage& in) { node_.numbers(in); }),
        odometry_(public_.subscribe("odom", kQueue, &Shell::on_odometry, this,
                                    ros::TransportHints().tcpNoDelay())),
        timer_(public_.createTimer(ros::Duration(1.0 / node_.settings().rate),
                                   [this](const ros::TimerEvent&) { publish(); })),
        slow_(public_.createWallTimer(ros::WallDuration(1.0),
                                      [this](const ros::WallTimerEvent&) {
                                        diagnostics_.publish(
                                            sr::diagnostics(node_.diagnose(), "mimic"));
                                      })),
        last_act_(public_, [this] { end(); }) {}

 private:
  static constexpr std::uint32_t kQueue = 10;

  void on_odometry(const nav_msgs::Odometry& message) {
    double eta[seatrial::kAxes];
    sr::read(message.pose.pose, eta);
    frame_ = message.header.frame_id;
    carrier_ = message.child_frame_id;
    node_.pose(nanoseconds(message.header.stamp), nanoseconds(ros::Time::now()), eta);
  }

  /// The carrier is left standing.
  void end() {
    timer_.stop();
    send(ros::Time::now(), geometry_msgs::Twist());
  }

  void send(const ros::Time& now, const geometry_msgs::Twist& velocity) {
    if (!node_.settings().enable_stamped_cmd_vel) return velocity_.publish(velocity);
    geometry_msgs::TwistStamped message;
    message.header.stamp = now;
    message.header.frame_id = carrier_;
    message.twist = velocity;
    velocity_.publish(message);
  }

  void publish() {
    const ros::Time now = ros::Time::now();
    if (now.isZero()) return;  // simulated time that has not begun
    const seatrial::MimicOutput found = node_.tick(nanoseconds(now));
    geometry_msgs::Twist velocity;
    sr::fill_twist(found.velocity, velocity);
    send(now, velocity);
    nav_msgs::Odometry boat;
    boat.header.stamp = now;
    sr::fill_truth(found.boat, {frame_, "virtual_boat"}, boat);
    boat_.publish(boat);
  }

  ros::NodeHandle public_;
  ros::NodeHandle own_{"~"};
  sr::MimicNode node_;
  ros::Publisher velocity_;
  ros::Publisher boat_;
  ros::Publisher diagnostics_;
  sr::NumberTopics<sr::MimicNode> numbers_;
  ros::Subscriber odometry_;
  ros::Timer timer_;
  ros::WallTimer slow_;
  std::string frame_ = "odom";
  std::string carrier_ = "base_link";
  sr::LastAct last_act_;
};

}  // namespace

int main(int argc, char** argv) {
  return sr::run("seatrial_mimic", [&] {
    sr::init_with_last_act(argc, argv, "seatrial_mimic");
    Shell shell;
    ros::spin();
  });
}
