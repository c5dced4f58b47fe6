// SPDX-License-Identifier: MIT
// The simulator's node for ROS 2: boats take commands, and publish pose, truth, IMU, scan and
// clock. What is done with commands and time is in seatrial_ros/sim_node.hpp.
#include <chrono>
#include <cmath>
#include <geometry_msgs/msg/pose_stamped.hpp>
#include <geometry_msgs/msg/transform_stamped.hpp>
#include <nav_msgs/msg/odometry.hpp>
#include <rclcpp/rclcpp.hpp>
#include <rosgraph_msgs/msg/clock.hpp>
#include <sensor_msgs/msg/imu.hpp>
#include <sensor_msgs/msg/joint_state.hpp>
#include <sensor_msgs/msg/laser_scan.hpp>
#include <vector>
#if __has_include(<tf2_ros/static_transform_broadcaster.hpp>)
#include <tf2_ros/static_transform_broadcaster.hpp>
#else
#include <tf2_ros/static_transform_broadcaster.h>
#endif

#include "component.hpp"
#include "nodes.hpp"
#include "numbers.hpp"
#include "parameters.hpp"
#include "seatrial_ros/sim_outlets.hpp"

namespace seatrial_odometry {

namespace sr = seatrial::ros;
using namespace std::chrono_literals;
using rosgraph_msgs::msg::Clock;
using seatrial::Reading;

struct SimMessages {
  using Imu = sensor_msgs::msg::Imu;
  using JointState = sensor_msgs::msg::JointState;
  using LaserScan = sensor_msgs::msg::LaserScan;
  using Odometry = nav_msgs::msg::Odometry;
  using PoseStamped = geometry_msgs::msg::PoseStamped;
  using TransformStamped = geometry_msgs::msg::TransformStamped;
};

constexpr auto kPeriod = 5ms;  // of this machine's clock between steps

class SimulatorNode : public rclcpp::Node {
 public:
  explicit SimulatorNode(const rclcpp::NodeOptions& options)
      : rclcpp::Node("seatrial_simulator", options),
        node_(sr::read_settings<sr::SimSettings>(*this)),
        outlets_(node_, [this](const std::string& topic, auto& send) { advertise(topic, send); }),
        numbers_(*this, node_, [this](const sr::NumbersMessage& in) { on_numbers(in); }),
        broadcaster_(*this) {
    if (node_.sensors().lidar) broadcaster_.sendTransform(outlets_.lasers());
    if (node_.settings().publish_clock) {
      clock_ = create_publisher<Clock>("/clock", rclcpp::ClockQoS());
    }
    timer_ = create_wall_timer(kPeriod, [this] { step(); });
  }

 private:
  static constexpr std::size_t kQueue = 100;
  using Seconds = std::chrono::duration<double>;

  template <class Message>
  void advertise(const std::string& topic, sr::Send<Message>& send) {
    send = [publisher = create_publisher<Message>(topic, kQueue)](const Message& message) {
      publisher->publish(message);
    };
  }

  void on_numbers(const sr::NumbersMessage& in) {
    step();
    const std::string wrong = node_.numbers(in, [this](int boat, const sr::Signal& command) {
      outlets_.taken(boat, command, stamp(node_.time()));
    });
    if (!wrong.empty()) RCLCPP_WARN_THROTTLE(get_logger(), steady_, 1000, "%s", wrong.c_str());
  }

  /// Simulated time as a stamp: from this machine's time at the start on.
  rclcpp::Time stamp(double t) const {
    return rclcpp::Time(start_.count() + std::llround(t * 1e9));
  }

  /// On to where this machine's clock is.
  void step() {
    const bool in_time = node_.follow(
        Seconds(std::chrono::steady_clock::now() - began_).count(),
        [this](const Reading& r) { outlets_.reading(r, stamp(r.stamp)); },
        [this](int boat) { outlets_.truth(boat, stamp(node_.time())); });
    if (!in_time) {
      RCLCPP_WARN_THROTTLE(
          get_logger(), steady_, 5000,
          "the machine is too slow for real time: simulated time continues from here");
      return;
    }
    if (clock_ == nullptr) return;
    Clock message;
    message.clock = stamp(node_.time());
    clock_->publish(message);
  }

  sr::SimNode node_;
  sr::SimOutlets<SimMessages> outlets_;
  sr::NumberTopics numbers_;
  tf2_ros::StaticTransformBroadcaster broadcaster_;
  rclcpp::Publisher<Clock>::SharedPtr clock_;
  rclcpp::Clock steady_{RCL_STEADY_TIME};
  // simulated time 0, by either clock of this machine
  const std::chrono::nanoseconds start_ = std::chrono::system_clock::now().time_since_epoch();
  const std::chrono::steady_clock::time_point began_ = std::chrono::steady_clock::now();
  rclcpp::TimerBase::SharedPtr timer_;
};

NodePtr make_simulator(const rclcpp::NodeOptions& options) {
  return std::make_shared<SimulatorNode>(options);
}

}  // namespace seatrial_odometry

SEATRIAL_COMPONENT(seatrial_odometry::SimulatorNode)
