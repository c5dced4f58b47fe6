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
#include "seatrial_ros/sim_messages.hpp"
#include "seatrial_ros/sim_node.hpp"

namespace seatrial_odometry {

namespace sr = seatrial::ros;
using namespace std::chrono_literals;
using geometry_msgs::msg::PoseStamped;
using nav_msgs::msg::Odometry;
using rosgraph_msgs::msg::Clock;
using seatrial::Reading;
using seatrial::ReadingKind;
using sensor_msgs::msg::Imu;
using sensor_msgs::msg::JointState;
using sensor_msgs::msg::LaserScan;

constexpr auto kPeriod = 5ms;  // of this machine's clock between steps

class SimulatorNode : public rclcpp::Node {
 public:
  explicit SimulatorNode(const rclcpp::NodeOptions& options)
      : rclcpp::Node("seatrial_simulator", options),
        node_(sr::read_settings<sr::SimSettings>(*this)),
        numbers_(*this, node_, [this](const sr::NumbersMessage& in) { on_numbers(in); }),
        broadcaster_(*this) {
    for (int boat = 0; boat < node_.n_boats(); ++boat) advertise(boat);
    place_lasers();
    if (node_.settings().publish_clock) {
      clock_ = create_publisher<Clock>("/clock", rclcpp::ClockQoS());
    }
    timer_ = create_wall_timer(kPeriod, [this] { step(); });
  }

 private:
  static constexpr std::size_t kQueue = 100;
  using Seconds = std::chrono::duration<double>;

  struct Outlets {
    rclcpp::Publisher<PoseStamped>::SharedPtr pose;
    rclcpp::Publisher<Odometry>::SharedPtr truth;
    rclcpp::Publisher<JointState>::SharedPtr taken;
    rclcpp::Publisher<Imu>::SharedPtr imu;
    rclcpp::Publisher<LaserScan>::SharedPtr scan;
    sr::Frames frames;
    std::string laser;
  };

  void advertise(int boat) {
    const sr::SimSettings& s = node_.settings();
    const seatrial::Sensors& sensors = node_.sensors();
    Outlets out;
    const auto name = [this, boat](const char* word) { return node_.named(boat, word); };
    out.truth = create_publisher<Odometry>(name("truth"), kQueue);
    out.taken = create_publisher<JointState>(name("taken"), kQueue);
    if (sensors.pose) out.pose = create_publisher<PoseStamped>(node_.pose_topic(boat), kQueue);
    if (sensors.imu) out.imu = create_publisher<Imu>(name("imu"), kQueue);
    if (sensors.lidar) out.scan = create_publisher<LaserScan>(name("scan"), kQueue);
    out.frames = {s.map_frame, node_.named(boat, s.base_frame)};
    out.laser = node_.named(boat, s.laser_frame);
    outlets_.push_back(out);
  }

  void place_lasers() {
    if (!node_.sensors().lidar) return;
    std::vector<geometry_msgs::msg::TransformStamped> all;
    for (const Outlets& out : outlets_) {
      geometry_msgs::msg::TransformStamped message;
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
      JointState message;
      message.header.stamp = stamp(node_.time());
      sr::fill_taken(command, message);
      outlets_[static_cast<std::size_t>(boat)].taken->publish(message);
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
        [this](const Reading& r) { publish(r); }, [this](int boat) { publish_truth(boat); });
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

  void publish_truth(int boat) {
    const Outlets& out = outlets_[static_cast<std::size_t>(boat)];
    double x[seatrial::kStates];
    node_.state(boat, x);
    Odometry message;
    message.header.stamp = stamp(node_.time());
    sr::fill_truth(x, out.frames, message);
    out.truth->publish(message);
  }

  void publish(const Reading& reading) {
    const Outlets& out = outlets_[static_cast<std::size_t>(reading.boat)];
    const auto head = [this, &reading](auto& message, const std::string& frame) {
      message.header.stamp = stamp(reading.stamp);
      message.header.frame_id = frame;
    };
    if (reading.kind == ReadingKind::kPose) {
      PoseStamped message;
      head(message, node_.pose_frame(reading.boat));
      double raw[3];
      node_.as_message(reading.boat, reading.values.data(), raw);
      sr::fill_pose(raw, message.pose);
      out.pose->publish(message);
    } else if (reading.kind == ReadingKind::kImu) {
      Imu message;
      head(message, out.frames.base_link);
      sr::fill_imu(reading, *node_.sensors().imu, message);
      out.imu->publish(message);
    } else {
      LaserScan message;
      head(message, out.laser);
      sr::fill_scan(reading, *node_.sensors().lidar, message);
      out.scan->publish(message);
    }
  }

  sr::SimNode node_;
  sr::NumberTopics numbers_;
  tf2_ros::StaticTransformBroadcaster broadcaster_;
  std::vector<Outlets> outlets_;
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
