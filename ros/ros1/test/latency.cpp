// SPDX-License-Identifier: MIT
// Plays boat and SLAM for the odometry node, and measures how long it takes from a command to the
// odometry that it brings about (node with rate 0): from publish() to when the answer was read off
// the socket. Poses at 15 Hz.
//
//   latency _seconds:=30 _commands:=100        prints: commands answers p50 p99 worst [ms]
#include <geometry_msgs/PoseStamped.h>
#include <nav_msgs/Odometry.h>
#include <ros/ros.h>
#include <sensor_msgs/Joy.h>

#include <algorithm>
#include <cstdio>
#include <vector>

#include "../src/network_queue.hpp"

namespace {

constexpr int kAxes = 6;  // of the joypad

double at(const std::vector<double>& sorted, double share) {
  return 1e3 * sorted[static_cast<std::size_t>(share * static_cast<double>(sorted.size() - 1))];
}

}  // namespace

int main(int argc, char** argv) {
  ros::init(argc, argv, "latency");
  seatrial::ros::NetworkQueue answers;
  ros::NodeHandle node;
  ros::NodeHandle hearing;
  hearing.setCallbackQueue(&answers);
  const ros::NodeHandle own("~");
  const double seconds = own.param("seconds", 30.0);
  const double rate = own.param("commands", 100.0);  // [Hz]
  const auto hints = ros::TransportHints().tcpNoDelay();
  ros::Publisher joypad = node.advertise<sensor_msgs::Joy>("joy", 10);
  ros::Publisher slam = node.advertise<geometry_msgs::PoseStamped>("slam/pose", 10);
  ros::WallTime sent;
  std::vector<double> took;
  const boost::function<void(const nav_msgs::Odometry::ConstPtr&)> heard =
      [&sent, &took](const nav_msgs::Odometry::ConstPtr&) {
        took.push_back((ros::WallTime::now() - sent).toSec());
      };
  const ros::Subscriber odometry =
      hearing.subscribe<nav_msgs::Odometry>("odom", 10, heard, ros::VoidConstPtr(), hints);
  while (ros::ok() && (joypad.getNumSubscribers() == 0 || slam.getNumSubscribers() == 0 ||
                       odometry.getNumPublishers() == 0)) {
    ros::WallDuration(0.05).sleep();
  }
  const ros::WallTime begin = ros::WallTime::now();
  int commands = 0;
  int poses = 0;
  while (ros::ok()) {
    const double t = (ros::WallTime::now() - begin).toSec();
    if (t > seconds) break;
    if (t >= poses / 15.0) {
      geometry_msgs::PoseStamped pose;
      pose.header.stamp = ros::Time::now();
      pose.header.frame_id = "map";
      pose.pose.orientation.w = 1.0;
      slam.publish(pose);
      ++poses;
    }
    sensor_msgs::Joy joy;
    joy.header.stamp = ros::Time::now();
    joy.axes.assign(kAxes, 0.0F);
    joy.axes[1] = commands % 200 < 100 ? 0.3F : -0.3F;
    {
      const auto held = answers.hold();
      sent = ros::WallTime::now();
    }
    joypad.publish(joy);
    ++commands;
    const ros::WallDuration rest =
        begin + ros::WallDuration(commands / rate) - ros::WallTime::now();
    if (rest > ros::WallDuration()) rest.sleep();
  }
  ros::shutdown();  // no answer comes any more
  if (took.empty()) {
    std::fprintf(stderr, "latency: no odometry came\n");
    return 1;
  }
  std::sort(took.begin(), took.end());
  std::printf("%d %zu %.3f %.3f %.3f\n", commands, took.size(), at(took, 0.5), at(took, 0.99),
              1e3 * took.back());
  return 0;
}
