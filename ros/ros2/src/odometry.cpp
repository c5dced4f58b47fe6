// SPDX-License-Identifier: MIT
// The odometry node for ROS 2, Humble to Rolling: subscriptions, publishers and clocks. What is
// done with the messages is in seatrial_ros/node.hpp.
#include <chrono>
#include <csignal>
#include <diagnostic_msgs/msg/diagnostic_array.hpp>
#include <functional>
#include <geometry_msgs/msg/pose_stamped.hpp>
#include <geometry_msgs/msg/pose_with_covariance_stamped.hpp>
#include <geometry_msgs/msg/transform_stamped.hpp>
#include <memory>
#include <nav_msgs/msg/odometry.hpp>
#include <rclcpp/rclcpp.hpp>
#include <set>
#include <std_srvs/srv/trigger.hpp>
#if __has_include(<tf2_ros/transform_broadcaster.hpp>)
#include <tf2_ros/transform_broadcaster.hpp>
#else
#include <tf2_ros/transform_broadcaster.h>
#endif

#include "component.hpp"
#include "diagnostics.hpp"
#include "nodes.hpp"
#include "numbers.hpp"
#include "parameters.hpp"
#include "seatrial_ros/messages.hpp"
#include "seatrial_ros/node.hpp"
#include "topics.hpp"

namespace seatrial_odometry {

namespace sr = seatrial::ros;
using namespace std::chrono_literals;
using diagnostic_msgs::msg::DiagnosticArray;
using geometry_msgs::msg::PoseStamped;
using geometry_msgs::msg::PoseWithCovarianceStamped;
using nav_msgs::msg::Odometry;

namespace {

volatile std::sig_atomic_t hangups = 0;

}  // namespace

class OdometryNode : public rclcpp::Node {
 public:
  explicit OdometryNode(const rclcpp::NodeOptions& options)
      : rclcpp::Node("seatrial_odometry", options),
        node_(sr::read_settings<sr::Settings>(*this)),
        odometry_(create_publisher<Odometry>("odom", kQueue)),
        map_pose_(create_publisher<PoseWithCovarianceStamped>("map_pose", kQueue)),
        diagnostics_(create_publisher<DiagnosticArray>("/diagnostics", kQueue)),
        broadcaster_(*this) {
    node_.refuse_own_topics({odometry_->get_topic_name(), map_pose_->get_topic_name()},
                            [this](const std::string& topic) {
                              return get_node_topics_interface()->resolve_topic_name(topic);
                            });
    numbers_ = std::make_unique<sr::NumberTopics>(
        *this, node_, [this](const sr::NumbersMessage& in) { on_numbers(in); });
    poses_ = std::make_unique<sr::TypedTopics>(
        *this, std::set<std::string>{node_.pose_topic()},
        [this](const auto& topic, const auto& type) { return hear_poses(topic, type); });
    using Trigger = std_srvs::srv::Trigger;
    reload_ =
        create_service<Trigger>("~/reload", [this](const std::shared_ptr<Trigger::Request>,
                                                   std::shared_ptr<Trigger::Response> response) {
          response->message = sr::reload(node_, say_);
          response->success = response->message.empty();
        });
    slow_ = create_wall_timer(1s, [this] { diagnose(); });
    quick_ = create_wall_timer(100ms, [this] {
      if (hangups == answered_) return;
      answered_ = hangups;
      sr::reload(node_, say_);
    });
    const double rate = node_.settings().rate;
    if (rate > 0.0) {
      tick_ = rclcpp::create_timer(this, get_clock(), rclcpp::Duration::from_seconds(1.0 / rate),
                                   [this] { publish(); });
    }
  }

 private:
  static constexpr std::size_t kQueue = 10;

  sr::SubscriptionPtr hear_poses(const std::string& topic, const std::string& type) {
    if (type == "geometry_msgs/msg/PoseStamped") {
      return on<PoseStamped>(topic, [this](const PoseStamped& m) {
        sr::PoseMessage in;
        take_pose(m.header, m.pose, in);
      });
    }
    if (type == "geometry_msgs/msg/PoseWithCovarianceStamped") {
      return on<PoseWithCovarianceStamped>(topic, [this](const PoseWithCovarianceStamped& m) {
        sr::PoseMessage in;
        in.has_covariance = sr::read_covariance(m.pose.covariance, in.covariance);
        take_pose(m.header, m.pose.pose, in);
      });
    }
    if (type == "nav_msgs/msg/Odometry") {
      return on<Odometry>(topic, [this](const Odometry& m) {
        sr::PoseMessage in;
        in.has_covariance = sr::read_covariance(m.pose.covariance, in.covariance);
        in.child = m.child_frame_id;
        take_pose(m.header, m.pose.pose, in);
      });
    }
    throw std::runtime_error(topic + " is " + type +
                             "; expected geometry_msgs/msg/PoseStamped, "
                             "PoseWithCovarianceStamped or nav_msgs/msg/Odometry");
  }

  template <class Message, class Take>
  sr::SubscriptionPtr on(const std::string& topic, Take take) {
    return sr::hear<Message>(*this, topic, sr::stream(), take);
  }

  template <class Header, class Pose>
  void take_pose(const Header& header, const Pose& pose, sr::PoseMessage& in) {
    in.arrival = now().nanoseconds();
    in.stamp = sr::nanoseconds(header.stamp);
    in.frame = header.frame_id;
    sr::read(pose, in.eta);
    node_.pose(in);
  }

  void on_numbers(const sr::NumbersMessage& in) {
    node_.numbers(in);
    if (node_.settings().rate == 0.0) publish();
  }

  void publish() {
    const rclcpp::Time stamp = now();
    if (stamp.nanoseconds() == 0) return;  // simulated time that has not begun
    const seatrial::Odometry found = node_.tick(stamp.nanoseconds());
    if (!found.known) return;
    const sr::Settings& s = node_.settings();
    Odometry message;
    message.header.stamp = stamp;
    sr::fill(found, {s.odom_frame, s.base_frame}, message);
    odometry_->publish(message);
    PoseWithCovarianceStamped pose;
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
    sr::adopt(node_, say_);
    diagnostics_->publish(sr::diagnostics(*this, node_.diagnose(now().nanoseconds()), "odometry"));
  }

  const std::function<void(bool, const std::string&)> say_ =
      [log = get_logger()](bool failed, const std::string& what) {
        if (failed) {
          RCLCPP_ERROR(log, "%s", what.c_str());
        } else {
          RCLCPP_INFO(log, "%s", what.c_str());
        }
      };
  sr::Node node_;
  rclcpp::Publisher<Odometry>::SharedPtr odometry_;
  rclcpp::Publisher<PoseWithCovarianceStamped>::SharedPtr map_pose_;
  rclcpp::Publisher<DiagnosticArray>::SharedPtr diagnostics_;
  rclcpp::Service<std_srvs::srv::Trigger>::SharedPtr reload_;
  tf2_ros::TransformBroadcaster broadcaster_;
  std::unique_ptr<sr::NumberTopics> numbers_;
  std::unique_ptr<sr::TypedTopics> poses_;
  std::sig_atomic_t answered_ = hangups;
  rclcpp::TimerBase::SharedPtr tick_;
  rclcpp::TimerBase::SharedPtr slow_;
  rclcpp::TimerBase::SharedPtr quick_;
};

NodePtr make_odometry(const rclcpp::NodeOptions& options) {
  return std::make_shared<OdometryNode>(options);
}

void reload_on_hangup() {
  std::signal(SIGHUP, [](int) { hangups = hangups + 1; });
}

}  // namespace seatrial_odometry

SEATRIAL_COMPONENT(seatrial_odometry::OdometryNode)
