// SPDX-License-Identifier: MIT
// Between the odometer and messages. Templates, because ROS 1, ROS 2 and plain DDS have types of
// their own whose members have the same names. Headers' stamps are the caller's: they differ.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string>

#include "seatrial/onboard/odometer.hpp"

namespace seatrial::ros {

/// REP-105: the odometry's own frame, and the boat's.
struct Frames {
  std::string odom = "odom";
  std::string base_link = "base_link";
};

/// Variance of z, roll, pitch and their rates [m^2, rad^2, m^2/s^2, rad^2/s^2], which are not
/// estimated: a boat does heave and roll, and 0 would say that it is known not to.
inline constexpr double kUnknown = 1e6;

namespace detail {

inline constexpr int kDirections = 6;             // x, y, z, roll, pitch, yaw
inline constexpr int kPlanar[kPose] = {0, 1, 5};  // x, y, yaw among them
inline constexpr int kVertical[kPose] = {2, 3, 4};

/// A 6 x 6 covariance, row by row, by that of x, y and yaw: the upper left of `planar`.
template <int kColumns, class Covariance>
void spread(const double (*planar)[kColumns], Covariance& out) {
  for (int i = 0; i < kDirections * kDirections; ++i) out[i] = 0.0;
  for (const int i : kVertical) out[kDirections * i + i] = kUnknown;
  for (int i = 0; i < kPose; ++i) {
    for (int j = 0; j < kPose; ++j) out[kDirections * kPlanar[i] + kPlanar[j]] = planar[i][j];
  }
}

}  // namespace detail

/// A turn by psi [rad] about z.
template <class Quaternion>
void set_heading(double psi, Quaternion& q) {
  q.x = q.y = 0.0;
  q.z = std::sin(0.5 * psi);
  q.w = std::cos(0.5 * psi);
}

/// Heading [rad] of a quaternion of any length; not a number for one of none.
template <class Quaternion>
double heading(const Quaternion& q) {
  const double square = q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w;
  if (!(square > 0.0)) return std::numeric_limits<double>::quiet_NaN();
  return std::atan2(2.0 * (q.w * q.z + q.x * q.y), q.w * q.w + q.x * q.x - q.y * q.y - q.z * q.z);
}

/// geometry_msgs/Pose to x, y [m], psi [rad].
template <class Pose>
void read(const Pose& pose, double eta[kPose]) {
  eta[0] = pose.position.x;
  eta[1] = pose.position.y;
  eta[2] = heading(pose.orientation);
}

/// A 6 x 6 covariance to that of x, y and yaw, row by row. False where it is all zero, which in
/// messages means that it is not known.
template <class Covariance>
bool read_covariance(const Covariance& covariance, double planar[kPose * kPose]) {
  bool known = false;
  for (int i = 0; i < kPose; ++i) {
    for (int j = 0; j < kPose; ++j) {
      const int from = detail::kDirections * detail::kPlanar[i] + detail::kPlanar[j];
      planar[kPose * i + j] = covariance[from];
      known = known || covariance[from] != 0.0;
    }
  }
  return known;
}

/// geometry_msgs/TwistWithCovariance to u, v [m/s], r [rad/s] and their variances; 0: not known.
template <class Twist>
void read_twist(const Twist& in, double nu[kAxes], double variance[kAxes]) {
  nu[0] = in.twist.linear.x;
  nu[1] = in.twist.linear.y;
  nu[2] = in.twist.angular.z;
  double planar[kAxes * kAxes];
  read_covariance(in.covariance, planar);
  for (int i = 0; i < kAxes; ++i) variance[i] = planar[std::ptrdiff_t{kAxes + 1} * i];
}

/// geometry_msgs/Twist by u, v [m/s], r [rad/s].
template <class Twist>
void fill_twist(const double nu[kAxes], Twist& out) {
  out.linear.x = nu[0];
  out.linear.y = nu[1];
  out.linear.z = 0.0;
  out.angular.x = out.angular.y = 0.0;
  out.angular.z = nu[2];
}

/// geometry_msgs/Transform by x, y [m], psi [rad].
template <class Transform>
void fill(const double eta[kPose], Transform& out) {
  out.translation.x = eta[0];
  out.translation.y = eta[1];
  out.translation.z = 0.0;
  set_heading(eta[2], out.rotation);
}

/// geometry_msgs/PoseWithCovariance: the pose in map.
template <class Message>
void fill_map_pose(const Odometry& found, Message& out) {
  out.pose.position.x = found.motion.pose[0];
  out.pose.position.y = found.motion.pose[1];
  out.pose.position.z = 0.0;
  set_heading(found.motion.pose[2], out.pose.orientation);
  detail::spread(found.motion.covariance, out.covariance);
}

/// nav_msgs/Odometry but for the header's stamp: pose in frames.odom, twist in frames.base_link.
template <class Message>
void fill(const Odometry& found, const Frames& frames, Message& out) {
  out.header.frame_id = frames.odom;
  out.child_frame_id = frames.base_link;
  out.pose.pose.position.x = found.pose[0];
  out.pose.pose.position.y = found.pose[1];
  out.pose.pose.position.z = 0.0;
  set_heading(found.pose[2], out.pose.pose.orientation);
  detail::spread(found.covariance, out.pose.covariance);
  fill_twist(found.motion.velocity, out.twist.twist);
  double spread[kAxes][kAxes];
  for (int a = 0; a < kAxes; ++a) {
    std::copy(found.motion.covariance[3 + a] + 3, found.motion.covariance[3 + a] + kStates,
              spread[a]);
  }
  detail::spread(spread, out.twist.covariance);
}

}  // namespace seatrial::ros
