// SPDX-License-Identifier: MIT
// What ROS itself costs: a node with the odometry node's topics that answers each joypad message
// with an empty odometry (rate 0), or publishes one at a fixed rate, and computes nothing.
//
//   relay _rate:=0
#include <geometry_msgs/PoseStamped.h>
#include <nav_msgs/Odometry.h>
#include <ros/ros.h>
#include <sensor_msgs/Joy.h>
#include <tf2_ros/transform_broadcaster.h>

int main(int argc, char** argv) {
  ros::init(argc, argv, "seatrial_odometry");
  ros::NodeHandle node;
  const double rate = ros::NodeHandle("~").param("rate", 0.0);  // [Hz]
  const auto hints = ros::TransportHints().tcpNoDelay();
  ros::Publisher odometry = node.advertise<nav_msgs::Odometry>("odom", 10);
  tf2_ros::TransformBroadcaster broadcaster;
  const auto publish = [&odometry, &broadcaster]() {
    nav_msgs::Odometry message;
    message.header.stamp = ros::Time::now();
    message.header.frame_id = "odom";
    message.child_frame_id = "base_link";
    odometry.publish(message);
    geometry_msgs::TransformStamped transform;
    transform.header = message.header;
    transform.child_frame_id = message.child_frame_id;
    broadcaster.sendTransform(transform);
  };
  const boost::function<void(const sensor_msgs::Joy::ConstPtr&)> on_joy =
      [rate, &publish](const sensor_msgs::Joy::ConstPtr&) {
        if (rate == 0.0) publish();
      };
  const boost::function<void(const geometry_msgs::PoseStamped::ConstPtr&)> on_pose =
      [](const geometry_msgs::PoseStamped::ConstPtr&) {};
  const ros::Subscriber joy =
      node.subscribe<sensor_msgs::Joy>("joy", 100, on_joy, ros::VoidConstPtr(), hints);
  const ros::Subscriber pose = node.subscribe<geometry_msgs::PoseStamped>(
      "slam/pose", 100, on_pose, ros::VoidConstPtr(), hints);
  ros::Timer timer;
  if (rate > 0.0) {
    timer = node.createTimer(ros::Duration(1.0 / rate),
                             [&publish](const ros::TimerEvent&) { publish(); });
  }
  ros::spin();
  return 0;
}
