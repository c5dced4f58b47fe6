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
#include "seatrial_ros/sim_outlets.hpp"

namespace {

namespace sr = seatrial::ros;
using seatrial::Reading;

struct SimMessages {
  using Imu = sensor_msgs::Imu;
  using JointState = sensor_msgs::JointState;
  using LaserScan = sensor_msgs::LaserScan;
  using Odometry = nav_msgs::Odometry;
  using PoseStamped = geometry_msgs::PoseStamped;
  using TransformStamped = geometry_msgs::TransformStamped;
};

constexpr double kPeriod = 0.005;  // [s] of this machine's clock between steps

class Shell {
 public:
  Shell()
      : node_(sr::read_settings<sr::SimSettings>(own_)),
        outlets_(node_, [this](const std::string& topic, auto& send) { advertise(topic, send); }),
        numbers_(public_, node_, [this](const sr::NumbersMessage& in) { on_numbers(in); }) {
    if (node_.sensors().lidar) broadcaster_.sendTransform(outlets_.lasers());
    if (node_.settings().publish_clock) {
      clock_ = public_.advertise<rosgraph_msgs::Clock>("/clock", kQueue);
    }
    timer_ = public_.createSteadyTimer(ros::WallDuration(kPeriod),
                                       [this](const ros::SteadyTimerEvent&) { step(); });
  }

 private:
  static constexpr std::uint32_t kQueue = 100;

  template <class Message>
  void advertise(const std::string& topic, sr::Send<Message>& send) {
    send = [publisher = public_.advertise<Message>(topic, kQueue)](const Message& message) {
      publisher.publish(message);
    };
  }

  void on_numbers(const sr::NumbersMessage& in) {
    step();
    const std::string wrong = node_.numbers(in, [this](int boat, const sr::Signal& command) {
      outlets_.taken(boat, command, stamp(node_.time()));
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
    const bool in_time =
        node_.follow((ros::SteadyTime::now() - began_).toSec(),
                     [this](const Reading& r) { outlets_.reading(r, stamp(r.stamp)); },
                     [this](int boat) { outlets_.truth(boat, stamp(node_.time())); });
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

  ros::NodeHandle public_;
  ros::NodeHandle own_{"~"};
  sr::SimNode node_;
  sr::SimOutlets<SimMessages> outlets_;
  sr::NumberTopics<sr::SimNode> numbers_;
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
