// SPDX-License-Identifier: MIT
// The simulator's node for ROS 1: boats take commands, and publish pose, truth, IMU, scan and
// clock. What is done with commands and time is in seatrial_ros/sim_node.hpp.
#include <geometry_msgs/PoseStamped.h>
#include <nav_msgs/Odometry.h>
#include <ros/ros.h>
#include <rosgraph_msgs/Clock.h>
#include <sensor_msgs/Imu.h>
#include <sensor_msgs/JointState.h>
#include <sensor_msgs/LaserScan.h>
#include <tf2_ros/static_transform_broadcaster.h>

#include "numbers.hpp"
#include "run.hpp"
#include "seatrial_ros/sim_messages.hpp"
#include "seatrial_ros/sim_node.hpp"

namespace {

namespace sr = seatrial::ros;
using seatrial::Reading;
using seatrial::ReadingKind;

constexpr double kPeriod = 0.005;  // [s] of this machine's clock between steps

class Shell {
 public:
  Shell()
      : node_(sr::read_settings<sr::SimSettings>(own_)),
        numbers_(public_, node_, [this](const sr::NumbersMessage& in) { on_numbers(in); }) {
    for (int boat = 0; boat < node_.n_boats(); ++boat) advertise(boat);
    place_lasers();
    if (node_.settings().publish_clock) {
      clock_ = public_.advertise<rosgraph_msgs::Clock>("/clock", kQueue);
    }
    timer_ = public_.createSteadyTimer(ros::WallDuration(kPeriod),
                                       [this](const ros::SteadyTimerEvent&) { step(); });
  }

 private:
  static constexpr std::uint32_t kQueue = 100;

  struct Outlets {
    ros::Publisher pose;
    ros::Publisher truth;
    ros::Publisher taken;
    ros::Publisher imu;
    ros::Publisher scan;
    sr::Frames frames;
    std::string laser;
  };

  void advertise(int boat) {
    const sr::SimSettings& s = node_.settings();
    const seatrial::Sensors& sensors = node_.sensors();
    Outlets out;
    const auto name = [this, boat](const char* word) { return node_.named(boat, word); };
    out.truth = public_.advertise<nav_msgs::Odometry>(name("truth"), kQueue);
    out.taken = public_.advertise<sensor_msgs::JointState>(name("taken"), kQueue);
    if (sensors.pose) {
      out.pose = public_.advertise<geometry_msgs::PoseStamped>(node_.pose_topic(boat), kQueue);
    }
    if (sensors.imu) out.imu = public_.advertise<sensor_msgs::Imu>(name("imu"), kQueue);
    if (sensors.lidar) out.scan = public_.advertise<sensor_msgs::LaserScan>(name("scan"), kQueue);
    out.frames = {s.map_frame, node_.named(boat, s.base_frame)};
    out.laser = node_.named(boat, s.laser_frame);
    outlets_.push_back(out);
  }

  void place_lasers() {
    if (!node_.sensors().lidar) return;
    std::vector<geometry_msgs::TransformStamped> all;
    for (const Outlets& out : outlets_) {
      geometry_msgs::TransformStamped message;
      message.header.frame_id = out.frames.base_link;
      message.child_frame_id = out.laser;
      sr::fill(node_.sensors().lidar->mount, message.transform);
      all.push_back(message);
    }
    broadcaster_.sendTransform(all);
  }

  void on_numbers(const sr::NumbersMessage& in) {
    step();
    const std::string wrong = node_.numbers(in, [this](int boat, const sr::Signal& command) {
      sensor_msgs::JointState message;
      message.header.stamp = stamp(node_.time());
      sr::fill_taken(command, message);
      outlets_[static_cast<std::size_t>(boat)].taken.publish(message);
    });
    if (!wrong.empty()) ROS_WARN_THROTTLE(1.0, "%s", wrong.c_str());
  }

  /// Simulated time as a stamp: from this machine's time at the start on.
  ros::Time stamp(double t) const {
    ros::Time time;
    time.fromNSec(start_.toNSec() + static_cast<std::uint64_t>(std::llround(t * 1e9)));
    return time;
  }

  /// On to where this machine's clock is.
  void step() {
    const bool in_time = node_.follow((ros::SteadyTime::now() - began_).toSec(),
                                      [this](const Reading& r) { publish(r); },
                                      [this](int boat) { publish_truth(boat); });
    if (!in_time) {
      ROS_WARN_THROTTLE(
          5.0, "the machine is too slow for real time: simulated time continues from here");
      return;
    }
    if (!clock_) return;
    rosgraph_msgs::Clock message;
    message.clock = stamp(node_.time());
    clock_.publish(message);
  }

  void publish_truth(int boat) {
    const Outlets& out = outlets_[static_cast<std::size_t>(boat)];
    double x[seatrial::kStates];
    node_.state(boat, x);
    nav_msgs::Odometry message;
    message.header.stamp = stamp(node_.time());
    sr::fill_truth(x, out.frames, message);
    out.truth.publish(message);
  }

  void publish(const Reading& reading) {
    const Outlets& out = outlets_[static_cast<std::size_t>(reading.boat)];
    const auto head = [this, &reading](auto& message, const std::string& frame) {
      message.header.stamp = stamp(reading.stamp);
      message.header.frame_id = frame;
    };
    if (reading.kind == ReadingKind::kPose) {
      geometry_msgs::PoseStamped message;
      head(message, node_.pose_frame(reading.boat));
      double raw[3];
      node_.as_message(reading.boat, reading.values.data(), raw);
      sr::fill_pose(raw, message.pose);
      out.pose.publish(message);
    } else if (reading.kind == ReadingKind::kImu) {
      sensor_msgs::Imu message;
      head(message, out.frames.base_link);
      sr::fill_imu(reading, *node_.sensors().imu, message);
      out.imu.publish(message);
    } else {
      sensor_msgs::LaserScan message;
      head(message, out.laser);
      sr::fill_scan(reading, *node_.sensors().lidar, message);
      out.scan.publish(message);
    }
  }

  ros::NodeHandle public_;
  ros::NodeHandle own_{"~"};
  sr::SimNode node_;
  sr::NumberTopics<sr::SimNode> numbers_;
  std::vector<Outlets> outlets_;
  ros::Publisher clock_;
  tf2_ros::StaticTransformBroadcaster broadcaster_;
  const ros::WallTime start_ = ros::WallTime::now();      // that simulated time 0 is
  const ros::SteadyTime began_ = ros::SteadyTime::now();  // the same, by a clock that nobody sets
  ros::SteadyTimer timer_;
};

}  // namespace

int main(int argc, char** argv) {
  return sr::run("seatrial_simulator", [&] {
    ros::init(argc, argv, "seatrial_simulator");
    Shell shell;
    ros::spin();
  });
}
