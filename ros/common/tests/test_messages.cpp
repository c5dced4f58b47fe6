// SPDX-License-Identifier: MIT
// Odometry in messages, and poses out of them.
#include <doctest/doctest.h>

#include <complex>
#include <memory>

#include "boats.hpp"
#include "messages.hpp"
#include "onboard.hpp"
#include "seatrial_ros/messages.hpp"

using namespace seatrial;  // NOLINT(google-build-using-namespace)
using boats::Random;
using boats::Worst;
using geometry_msgs::msg::Pose;
using geometry_msgs::msg::Quaternion;

namespace {

/// What boost::array and std::array have in common, and no more.
struct Indexed {
  double& operator[](std::size_t i) { return numbers[i]; }
  const double& operator[](std::size_t i) const { return numbers[i]; }
  double numbers[36] = {};
};

struct OtherPose {
  Pose pose;
  Indexed covariance;
};

struct OtherTwist {
  geometry_msgs::msg::Twist twist;
  Indexed covariance;
};

/// nav_msgs/Odometry of another library.
struct OtherOdometry {
  std_msgs::msg::Header header;
  std::string child_frame_id;
  OtherPose pose;
  OtherTwist twist;
};

/// Every number another one.
Odometry example() {
  Odometry o;
  for (int i = 0; i < kPose; ++i) {
    o.pose[i] = 1.5 - i;
    o.motion.velocity[i] = 0.3 + 0.1 * i;
    o.motion.pose[i] = -99.0;  // in map: not what is published
    for (int j = 0; j < kPose; ++j) o.covariance[i][j] = 10.0 * (i + 1) + j + 1;
  }
  for (int i = 0; i < kStates; ++i) {
    for (int j = 0; j < kStates; ++j) o.motion.covariance[i][j] = 0.1 * (i + 1) + 0.01 * (j + 1);
  }
  return o;
}

template <class Message>
Message filled() {
  Message message;
  message.pose.covariance[8] = 5.0;  // left from before
  message.twist.twist.linear.z = 5.0;
  ros::fill(example(), {"odom_of_boat", "boat"}, message);
  return message;
}

/// The 36 numbers as they are to be, written out.
template <class Covariance>
void check(const Covariance& got, const double (&want)[36]) {
  for (int i = 0; i < 36; ++i) {
    CAPTURE(i);
    CHECK(got[i] == doctest::Approx(want[i]).epsilon(1e-15));
  }
}

Quaternion times(const Quaternion& a, const Quaternion& b) {
  return {
      a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y, a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
      a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w, a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z};
}

}  // namespace

TEST_CASE_TEMPLATE("odometry fills a message; heave, roll and pitch are not known", Message,
                   nav_msgs::msg::Odometry, OtherOdometry) {
  const auto m = filled<Message>();
  CHECK(m.header.frame_id == "odom_of_boat");
  CHECK(m.child_frame_id == "boat");
  CHECK(m.header.stamp.sec == 0);  // the caller's
  CHECK(m.pose.pose.position.x == 1.5);
  CHECK(m.pose.pose.position.y == 0.5);
  CHECK(m.pose.pose.position.z == 0.0);
  CHECK(m.pose.pose.orientation.x == 0.0);
  CHECK(m.pose.pose.orientation.y == 0.0);
  CHECK(m.pose.pose.orientation.z == doctest::Approx(-0.24740395925452292));  // sin(-0.25)
  CHECK(m.pose.pose.orientation.w == doctest::Approx(0.9689124217106447));    // cos(0.25)
  CHECK(m.twist.twist.linear.x == 0.3);
  CHECK(m.twist.twist.linear.y == 0.4);
  CHECK(m.twist.twist.linear.z == 0.0);
  CHECK(m.twist.twist.angular.x == 0.0);
  CHECK(m.twist.twist.angular.y == 0.0);
  CHECK(m.twist.twist.angular.z == 0.5);
  // clang-format off
  check(m.pose.covariance, {11, 12, 0, 0, 0, 13,
                            21, 22, 0, 0, 0, 23,
                            0, 0, 1e6, 0, 0, 0,
                            0, 0, 0, 1e6, 0, 0,
                            0, 0, 0, 0, 1e6, 0,
                            31, 32, 0, 0, 0, 33});
  check(m.twist.covariance, {0.44, 0.45, 0, 0, 0, 0.46,
                             0.54, 0.55, 0, 0, 0, 0.56,
                             0, 0, 1e6, 0, 0, 0,
                             0, 0, 0, 1e6, 0, 0,
                             0, 0, 0, 0, 1e6, 0,
                             0.64, 0.65, 0, 0, 0, 0.66});
  // clang-format on
}

TEST_CASE("a heading comes back out of its quaternion, of any length and either sign") {
  Random random(1);
  Worst worst;
  for (int n = 0; n < 1000; ++n) {
    const double psi = random(-kPi, kPi);
    Quaternion q;
    ros::set_heading(psi, q);
    const double length = (n % 2 == 0 ? 1.0 : -1.0) * std::pow(10.0, random(-3.0, 3.0));
    for (double* part : {&q.x, &q.y, &q.z, &q.w}) *part *= length;
    worst.see(std::abs(wrap(ros::heading(q) - psi)), 0.0);
  }
  CHECK(worst.value() < 1e-14);
}

TEST_CASE("roll and pitch leave the heading where it is") {
  Random random(2);
  Worst worst;
  for (int n = 0; n < 1000; ++n) {
    const double psi = random(-kPi, kPi);
    const double pitch = 0.5 * random(-1.0, 1.0);
    const double roll = 0.5 * random(-1.0, 1.0);
    Quaternion yaw;
    ros::set_heading(psi, yaw);
    const Quaternion tilt = times({0.0, std::sin(pitch / 2), 0.0, std::cos(pitch / 2)},
                                  {std::sin(roll / 2), 0.0, 0.0, std::cos(roll / 2)});
    worst.see(std::abs(wrap(ros::heading(times(yaw, tilt)) - psi)), 0.0);
  }
  CHECK(worst.value() < 1e-14);
}

TEST_CASE("a quaternion of no length has no heading, and the odometer refuses it") {
  Pose pose;
  pose.position = {1.0, 2.0, 3.0};
  pose.orientation.w = 0.0;
  double eta[kPose];
  ros::read(pose, eta);
  CHECK(eta[0] == 1.0);
  CHECK(eta[1] == 2.0);
  CHECK(std::isnan(eta[2]));
  auto odometer = std::make_unique<Odometer>(onboard::model());
  CHECK(odometer->pose(0, eta) == Taken::kNotNumber);
}

TEST_CASE_TEMPLATE("x, y and yaw of a covariance; all zero is none", Covariance,
                   decltype(geometry_msgs::msg::PoseWithCovariance::covariance), Indexed) {
  Covariance c = {};
  double planar[kPose * kPose];
  c[14] = 3.0;  // of z
  CHECK_FALSE(ros::read_covariance(c, planar));
  for (int i = 0; i < 36; ++i) c[i] = i;
  CHECK(ros::read_covariance(c, planar));
  const double want[kPose * kPose] = {0, 1, 5, 6, 7, 11, 30, 31, 35};
  for (int i = 0; i < kPose * kPose; ++i) CHECK(planar[i] == want[i]);
}

TEST_CASE("what is filled in is read back") {
  const auto m = filled<nav_msgs::msg::Odometry>();
  double eta[kPose];
  double planar[kPose * kPose];
  ros::read(m.pose.pose, eta);
  CHECK(ros::read_covariance(m.pose.covariance, planar));
  for (int i = 0; i < kPose; ++i) {
    CHECK(eta[i] == doctest::Approx(example().pose[i]));
    for (int j = 0; j < kPose; ++j) CHECK(planar[kPose * i + j] == example().covariance[i][j]);
  }
}

TEST_CASE("a velocity and its variances are read back") {
  const auto m = filled<nav_msgs::msg::Odometry>();
  double nu[kAxes];
  double variance[kAxes];
  ros::read_twist(m.twist, nu, variance);
  for (int i = 0; i < kAxes; ++i) {
    CHECK(nu[i] == example().motion.velocity[i]);
    CHECK(variance[i] == example().motion.covariance[kPose + i][kPose + i]);
  }
}

TEST_CASE("a transform turns and moves as the pose does") {
  struct {
    geometry_msgs::msg::Vector3 translation{9.0, 9.0, 9.0};
    Quaternion rotation{9.0, 9.0, 9.0, 9.0};
  } transform;
  const double eta[kPose] = {3.0, -4.0, 2.0};
  ros::fill(eta, transform);
  const Quaternion& q = transform.rotation;
  const Quaternion ahead = times(times(q, {1.0, 0.0, 0.0, 0.0}), {-q.x, -q.y, -q.z, q.w});
  const std::complex<double> want = std::polar(1.0, eta[2]);
  CHECK(ahead.x == doctest::Approx(want.real()));
  CHECK(ahead.y == doctest::Approx(want.imag()));
  CHECK(transform.translation.x == 3.0);
  CHECK(transform.translation.y == -4.0);
  CHECK(transform.translation.z == 0.0);
}
