// SPDX-License-Identifier: MIT
// The mimic's node for ROS 2: commands to a virtual boat and the carrier's odometry in, cmd_vel
// out. What is done with them is in seatrial_ros/mimic_node.hpp.
#include <diagnostic_msgs/msg/diagnostic_array.hpp>
#include <geometry_msgs/msg/twist.hpp>
#include <geometry_msgs/msg/twist_stamped.hpp>
#include <mutex>
#include <nav_msgs/msg/odometry.hpp>
#include <rclcpp/rclcpp.hpp>

#include "component.hpp"
#include "diagnostics.hpp"
#include "nodes.hpp"
#include "numbers.hpp"
#include "parameters.hpp"
#include "seatrial_ros/mimic_node.hpp"
#include "seatrial_ros/sim_messages.hpp"
#include "topics.hpp"

namespace seatrial_odometry {

namespace sr = seatrial::ros;
using namespace std::chrono_literals;
using diagnostic_msgs::msg::DiagnosticArray;
using geometry_msgs::msg::Twist;
using geometry_msgs::msg::TwistStamped;
using nav_msgs::msg::Odometry;

class MimicNode : public rclcpp::Node {
 public:
  explicit MimicNode(const rclcpp::NodeOptions& options)
      : rclcpp::Node("seatrial_mimic", options),
        node_(sr::read_settings<sr::MimicSettings>(*this)),
        velocity_(stamped() ? nullptr : create_publisher<Twist>("cmd_vel", kQueue)),
        stamped_velocity_(stamped() ? create_publisher<TwistStamped>("cmd_vel", kQueue) : nullptr),
        boat_(create_publisher<Odometry>("virtual_boat", kQueue)),
        diagnostics_(create_publisher<DiagnosticArray>("/diagnostics", kQueue)),
        numbers_(*this, node_, [this](const sr::NumbersMessage& in) { node_.numbers(in); }),
        odometry_(sr::hear<Odometry>(*this, "odom", sr::stream(),
                                     [this](const Odometry& m) { on_odometry(m); })),
        timer_(rclcpp::create_timer(this, get_clock(),
                                    rclcpp::Duration::from_seconds(1.0 / node_.settings().rate),
                                    [this] { publish(); })),
        slow_(create_wall_timer(1s, [this] { diagnose(); })),
        last_act_(*this, [this] { stop(); }) {}

 private:
  static constexpr std::size_t kQueue = 10;

  bool stamped() const { return node_.settings().enable_stamped_cmd_vel; }

  void on_odometry(const Odometry& message) {
    double eta[seatrial::kAxes];
    sr::read(message.pose.pose, eta);
    frame_ = message.header.frame_id;
    carrier_ = message.child_frame_id;
    node_.pose(sr::nanoseconds(message.header.stamp), now().nanoseconds(), eta);
  }

  /// The carrier is left standing.
  void stop() {
    const std::lock_guard<std::mutex> held(mutex_);
    stopped_ = true;
    send(now(), Twist());
  }

  void send(const rclcpp::Time& stamp, const Twist& velocity) {
    if (velocity_) return velocity_->publish(velocity);
    TwistStamped message;
    message.header.stamp = stamp;
    message.header.frame_id = carrier_;
    message.twist = velocity;
    stamped_velocity_->publish(message);
  }

  void publish() {
    const std::lock_guard<std::mutex> held(mutex_);
    if (stopped_) return;
    const rclcpp::Time stamp = now();
    if (stamp.nanoseconds() == 0) return;  // simulated time that has not begun
    const seatrial::MimicOutput found = node_.tick(stamp.nanoseconds());
    Twist velocity;
    sr::fill_twist(found.velocity, velocity);
    send(stamp, velocity);
    Odometry boat;
    boat.header.stamp = stamp;
    sr::fill_truth(found.boat, {frame_, "virtual_boat"}, boat);
    boat_->publish(boat);
  }

  void diagnose() { diagnostics_->publish(sr::diagnostics(*this, node_.diagnose(), "mimic")); }

  sr::MimicNode node_;
  rclcpp::Publisher<Twist>::SharedPtr velocity_;  // this one, or
  rclcpp::Publisher<TwistStamped>::SharedPtr stamped_velocity_;
  rclcpp::Publisher<Odometry>::SharedPtr boat_;
  rclcpp::Publisher<DiagnosticArray>::SharedPtr diagnostics_;
  sr::NumberTopics numbers_;
  sr::SubscriptionPtr odometry_;
  rclcpp::TimerBase::SharedPtr timer_;
  rclcpp::TimerBase::SharedPtr slow_;
  std::string frame_ = "odom";
  std::string carrier_ = "base_link";
  std::mutex mutex_;  // the last act may be in another thread
  bool stopped_ = false;
  LastAct last_act_;
};

NodePtr make_mimic(const rclcpp::NodeOptions& options) {
  return std::make_shared<MimicNode>(options);
}

}  // namespace seatrial_odometry

SEATRIAL_COMPONENT(seatrial_odometry::MimicNode)
