// SPDX-License-Identifier: MIT
// Simulated readings as messages of either ROS, but for their stamps.
#pragma once
#include "seatrial/simulation/simulator.hpp"
#include "seatrial_ros/messages.hpp"
#include "seatrial_ros/signal.hpp"

namespace seatrial::ros {

inline constexpr double kGravity = 9.80665;  // [m/s^2] in what an inertial unit says (REP-145)

/// geometry_msgs/Pose by x, y [m], psi [rad].
template <class Pose>
void fill_pose(const double* eta, Pose& out) {
  out.position.x = eta[0];
  out.position.y = eta[1];
  out.position.z = 0.0;
  set_heading(eta[2], out.orientation);
}

/// nav_msgs/Odometry: the truth, without covariance as it is known.
template <class Message>
void fill_truth(const double* x, const Frames& frames, Message& out) {
  out.header.frame_id = frames.odom;
  out.child_frame_id = frames.base_link;
  fill_pose(x, out.pose.pose);
  fill_twist(x + kPose, out.twist.twist);
}

/// sensor_msgs/Imu at rest upright; no orientation is measured.
template <class Message>
void fill_imu(const Reading& reading, const Imu& imu, Message& out) {
  out.orientation_covariance[0] = -1.0;
  out.angular_velocity.z = reading.values[0];
  out.linear_acceleration.x = reading.values[1];
  out.linear_acceleration.y = reading.values[2];
  out.linear_acceleration.z = kGravity;
  for (const int i : {0, 4, 8}) {
    out.angular_velocity_covariance[i] = imu.yaw_rate_noise * imu.yaw_rate_noise;
    out.linear_acceleration_covariance[i] = imu.acceleration_noise * imu.acceleration_noise;
  }
}

/// sensor_msgs/LaserScan.
template <class Message>
void fill_scan(const Reading& reading, const Lidar& lidar, Message& out) {
  const auto beams = static_cast<float>(lidar.beams - 1);
  out.angle_min = static_cast<float>(beam_angle(lidar, 0));
  out.angle_max = static_cast<float>(beam_angle(lidar, lidar.beams - 1));
  out.angle_increment = static_cast<float>(lidar.field) / beams;
  out.time_increment = static_cast<float>(sweep(lidar)) / beams;
  out.scan_time = static_cast<float>(1.0 / lidar.rate);
  out.range_min = static_cast<float>(lidar.nearest);
  out.range_max = static_cast<float>(lidar.farthest);
  out.ranges.assign(reading.values.begin(), reading.values.end());
}

/// A command as it was taken: names and values of the inputs, as sensor_msgs/JointState.
template <class Message>
void fill_taken(const Signal& command, Message& out) {
  for (const Channel& c : command.channels()) out.name.push_back(c.name);
  out.position.assign(command.values(), command.values() + command.size());
}

}  // namespace seatrial::ros
