// SPDX-License-Identifier: MIT
// The odometry node for ROS 2, Humble to Rolling: subscriptions, publishers and clocks. What is
// done with the messages is in seatrial_ros/node.hpp.
#include <csignal>
#include <cstdio>
#include <diagnostic_msgs/msg/diagnostic_array.hpp>
#include <geometry_msgs/msg/pose_stamped.hpp>
#include <geometry_msgs/msg/pose_with_covariance_stamped.hpp>
#include <geometry_msgs/msg/transform_stamped.hpp>
#include <geometry_msgs/msg/twist_stamped.hpp>
#include <geometry_msgs/msg/wrench_stamped.hpp>
#include <map>
#include <memory>
#include <nav_msgs/msg/odometry.hpp>
#include <rcl_interfaces/msg/floating_point_range.hpp>
#include <rcl_interfaces/msg/parameter_descriptor.hpp>
#include <rclcpp/rclcpp.hpp>
#include <sensor_msgs/msg/joint_state.hpp>
#include <sensor_msgs/msg/joy.hpp>
#include <std_msgs/msg/float32.hpp>
#include <std_msgs/msg/float32_multi_array.hpp>
#include <std_msgs/msg/float64.hpp>
#include <std_msgs/msg/float64_multi_array.hpp>
#include <std_srvs/srv/trigger.hpp>
#if __has_include(<tf2_ros/transform_broadcaster.hpp>)
#include <tf2_ros/transform_broadcaster.hpp>
#else
#include <tf2_ros/transform_broadcaster.h>
#endif

#include "seatrial_ros/messages.hpp"
#include "seatrial_ros/node.hpp"

namespace {

namespace sr = seatrial::ros;
using namespace std::chrono_literals;

volatile std::sig_atomic_t reload_asked = 0;

void ask_reload(int) { reload_asked = 1; }

/// The parameters, declared with what they are; read when the node starts.
sr::Settings read_settings(rclcpp::Node& node) {
  sr::Settings settings;
  sr::each_parameter(settings, [&node](const sr::Parameter& p, auto& value) {
    rcl_interfaces::msg::ParameterDescriptor descriptor;
    descriptor.description = p.description;
    descriptor.read_only = true;
    if (p.low < p.high) {
      rcl_interfaces::msg::FloatingPointRange range;
      range.from_value = p.low;
      range.to_value = p.high;
      descriptor.floating_point_range.push_back(range);
    }
    value = node.declare_parameter(p.name, value, descriptor);
  });
  return settings;
}

class Shell : public rclcpp::Node {
 public:
  Shell()
      : rclcpp::Node("seatrial_odometry"),
        node_(read_settings(*this)),
        odometry_(create_publisher<nav_msgs::msg::Odometry>("odom", 10)),
        map_pose_(create_publisher<geometry_msgs::msg::PoseWithCovarianceStamped>("map_pose", 10)),
        diagnostics_(create_publisher<diagnostic_msgs::msg::DiagnosticArray>("/diagnostics", 10)),
        broadcaster_(*this) {
    using Trigger = std_srvs::srv::Trigger;
    reload_ =
        create_service<Trigger>("~/reload", [this](const std::shared_ptr<Trigger::Request>,
                                                   std::shared_ptr<Trigger::Response> response) {
          response->message = reload();
          response->success = response->message.empty();
        });
    look_ = create_wall_timer(500ms, [this] { look_for_topics(); });
    slow_ = create_wall_timer(1s, [this] { diagnose(); });
    quick_ = create_wall_timer(100ms, [this] {
      if (reload_asked == 0) return;
      reload_asked = 0;
      reload();
    });
    const double rate = node_.settings().rate;
    if (rate > 0.0) {
      tick_ = rclcpp::create_timer(this, get_clock(), rclcpp::Duration::from_seconds(1.0 / rate),
                                   [this] { publish(); });
    }
    look_for_topics();
  }

 private:
  /// Subscribes to what is there by now; a topic's type is known once it has a publisher.
  void look_for_topics() {
    std::set<std::string> wanted = node_.number_topics();
    wanted.insert(node_.pose_topic());
    const auto known = get_topic_names_and_types();
    for (const std::string& topic : wanted) {
      const auto found = known.find(get_node_topics_interface()->resolve_topic_name(topic));
      if (found == known.end() || found->second.empty() || subscribed(topic)) continue;
      const std::string& type = found->second.front();
      try {
        topic == node_.pose_topic() ? subscribe_pose(topic, type) : subscribe_numbers(topic, type);
      } catch (const std::runtime_error& error) {
        RCLCPP_ERROR_THROTTLE(get_logger(), *get_clock(), 10000, "%s", error.what());
      }
    }
  }

  bool subscribed(const std::string& topic) const { return subscriptions_.count(topic) > 0; }

  /// Best effort hears reliable publishers, too.
  template <class Message, class Take>
  void subscribe(const std::string& topic, Take take) {
    subscriptions_[topic] = create_subscription<Message>(
        topic, rclcpp::SensorDataQoS().keep_last(100),
        [take](const std::shared_ptr<const Message> message) { take(*message); });
  }

  void subscribe_pose(const std::string& topic, const std::string& type) {
    if (type == "geometry_msgs/msg/PoseStamped") {
      subscribe<geometry_msgs::msg::PoseStamped>(topic, [this](const auto& m) {
        sr::PoseMessage in;
        take_pose(m.header, m.pose, in);
      });
    } else if (type == "geometry_msgs/msg/PoseWithCovarianceStamped") {
      subscribe<geometry_msgs::msg::PoseWithCovarianceStamped>(topic, [this](const auto& m) {
        sr::PoseMessage in;
        in.has_covariance = sr::read_covariance(m.pose.covariance, in.covariance);
        take_pose(m.header, m.pose.pose, in);
      });
    } else if (type == "nav_msgs/msg/Odometry") {
      subscribe<nav_msgs::msg::Odometry>(topic, [this](const auto& m) {
        sr::PoseMessage in;
        in.has_covariance = sr::read_covariance(m.pose.covariance, in.covariance);
        in.child = m.child_frame_id;
        take_pose(m.header, m.pose.pose, in);
      });
    } else {
      throw std::runtime_error(topic + " is " + type +
                               "; expected geometry_msgs/msg/PoseStamped, "
                               "PoseWithCovarianceStamped or nav_msgs/msg/Odometry");
    }
  }

  template <class Header, class Pose>
  void take_pose(const Header& header, const Pose& pose, sr::PoseMessage& in) {
    in.arrival = now().nanoseconds();
    in.stamp = rclcpp::Time(header.stamp).nanoseconds();
    in.frame = header.frame_id;
    sr::read(pose, in.eta);
    node_.pose(in);
  }

  void subscribe_numbers(const std::string& topic, const std::string& type) {
    node_.set_type(topic, type);
    const auto stamp_of = [](const auto& m) { return rclcpp::Time(m.header.stamp).nanoseconds(); };
    switch (sr::shape_of(type)->kind) {
      case sr::Kind::kJoy:
        subscribe<sensor_msgs::msg::Joy>(topic, [this, topic, stamp_of](const auto& m) {
          take(topic, stamp_of(m), sr::joy_numbers(m));
        });
        break;
      case sr::Kind::kWrench:
        subscribe<geometry_msgs::msg::Wrench>(
            topic, [this, topic](const auto& m) { take(topic, 0, sr::wrench_numbers(m)); });
        break;
      case sr::Kind::kWrenchStamped:
        subscribe<geometry_msgs::msg::WrenchStamped>(topic, [this, topic, stamp_of](const auto& m) {
          take(topic, stamp_of(m), sr::wrench_numbers(m.wrench));
        });
        break;
      case sr::Kind::kTwist:
        subscribe<geometry_msgs::msg::Twist>(
            topic, [this, topic](const auto& m) { take(topic, 0, sr::twist_numbers(m)); });
        break;
      case sr::Kind::kTwistStamped:
        subscribe<geometry_msgs::msg::TwistStamped>(topic, [this, topic, stamp_of](const auto& m) {
          take(topic, stamp_of(m), sr::twist_numbers(m.twist));
        });
        break;
      case sr::Kind::kJointState:
        subscribe<sensor_msgs::msg::JointState>(topic, [this, topic, stamp_of](const auto& m) {
          take(topic, stamp_of(m), sr::joint_numbers(m));
        });
        break;
      case sr::Kind::kArray: {
        const auto use = [this, topic](const auto& m) { take(topic, 0, sr::array_numbers(m)); };
        type == "std_msgs/msg/Float64MultiArray"
            ? subscribe<std_msgs::msg::Float64MultiArray>(topic, use)
            : subscribe<std_msgs::msg::Float32MultiArray>(topic, use);
        break;
      }
      case sr::Kind::kNumber: {
        const auto use = [this, topic](const auto& m) { take(topic, 0, sr::single_number(m)); };
        type == "std_msgs/msg/Float64" ? subscribe<std_msgs::msg::Float64>(topic, use)
                                       : subscribe<std_msgs::msg::Float32>(topic, use);
        break;
      }
    }
  }

  void take(const std::string& topic, std::int64_t stamp, sr::Numbers numbers) {
    node_.numbers({topic, stamp, now().nanoseconds(), std::move(numbers)});
    if (node_.settings().rate == 0.0) publish();
  }

  void publish() {
    const rclcpp::Time stamp = now();
    if (stamp.nanoseconds() == 0) return;  // simulated time that has not begun
    const seatrial::Odometry found = node_.tick(stamp.nanoseconds());
    if (!found.known) return;
    const sr::Settings& s = node_.settings();
    nav_msgs::msg::Odometry message;
    message.header.stamp = stamp;
    sr::fill(found, {s.odom_frame, s.base_frame}, message);
    odometry_->publish(message);
    geometry_msgs::msg::PoseWithCovarianceStamped pose;
    pose.header.stamp = stamp;
    pose.header.frame_id = node_.map_frame();
    sr::fill_map_pose(found, pose.pose);
    map_pose_->publish(pose);
    if (s.publish_tf) send(stamp, s.odom_frame, s.base_frame, found.pose);
    if (s.publish_map_to_odom && !node_.map_frame().empty()) {
      send(stamp, node_.map_frame(), s.odom_frame, found.map_to_odom);
    }
  }

  void send(const rclcpp::Time& stamp, const std::string& parent, const std::string& child,
            const double* pose) {
    geometry_msgs::msg::TransformStamped message;
    message.header.stamp = stamp;
    message.header.frame_id = parent;
    message.child_frame_id = child;
    sr::fill(pose, message.transform);
    broadcaster_.sendTransform(message);
  }

  void diagnose() {
    const sr::Diagnosis found = node_.diagnose();
    diagnostic_msgs::msg::DiagnosticStatus status;
    status.name = std::string(get_fully_qualified_name()) + ": odometry";
    status.hardware_id = "seatrial";
    status.level = found.level;
    status.message = found.message;
    for (const auto& [key, value] : found.values) {
      diagnostic_msgs::msg::KeyValue pair;
      pair.key = key;
      pair.value = value;
      status.values.push_back(pair);
    }
    diagnostic_msgs::msg::DiagnosticArray message;
    message.header.stamp = now();
    message.status.push_back(status);
    diagnostics_->publish(message);
  }

  std::string reload() {
    const std::string wrong = node_.reload();
    const char* path = node_.settings().model.c_str();
    if (wrong.empty()) {
      RCLCPP_INFO(get_logger(), "%s: read once more", path);
    } else {
      RCLCPP_ERROR(get_logger(), "%s; the model of before goes on", wrong.c_str());
    }
    return wrong;
  }

  sr::Node node_;
  rclcpp::Publisher<nav_msgs::msg::Odometry>::SharedPtr odometry_;
  rclcpp::Publisher<geometry_msgs::msg::PoseWithCovarianceStamped>::SharedPtr map_pose_;
  rclcpp::Publisher<diagnostic_msgs::msg::DiagnosticArray>::SharedPtr diagnostics_;
  rclcpp::Service<std_srvs::srv::Trigger>::SharedPtr reload_;
  tf2_ros::TransformBroadcaster broadcaster_;
  std::map<std::string, rclcpp::SubscriptionBase::SharedPtr> subscriptions_;
  rclcpp::TimerBase::SharedPtr look_;
  rclcpp::TimerBase::SharedPtr tick_;
  rclcpp::TimerBase::SharedPtr slow_;
  rclcpp::TimerBase::SharedPtr quick_;
};

}  // namespace

int main(int argc, char** argv) {
  rclcpp::init(argc, argv);
  std::signal(SIGHUP, ask_reload);
  int code = 0;
  try {
    rclcpp::spin(std::make_shared<Shell>());
  } catch (const std::exception& error) {
    std::fprintf(stderr, "seatrial_odometry: %s\n", error.what());
    code = 1;
  }
  rclcpp::shutdown();
  return code;
}
