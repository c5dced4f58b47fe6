// SPDX-License-Identifier: MIT
// The odometry node for ROS 1: subscriptions, publishers and clocks. What is done with the messages
// is in seatrial_ros/node.hpp.
#include <geometry_msgs/PoseStamped.h>
#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <nav_msgs/Odometry.h>
#include <ros/callback_queue.h>
#include <ros/ros.h>
#include <std_srvs/Trigger.h>
#include <tf2_ros/transform_broadcaster.h>

#include <algorithm>
#include <csignal>
#include <memory>

#include "diagnostics.hpp"
#include "network_queue.hpp"
#include "network_timer.hpp"
#include "numbers.hpp"
#include "run.hpp"
#include "seatrial_ros/messages.hpp"
#include "seatrial_ros/node.hpp"

namespace {

namespace sr = seatrial::ros;
using sr::nanoseconds;
using sr::NumberTopics;
using sr::read_settings;
using topic_tools::ShapeShifter;

volatile std::sig_atomic_t reload_asked = 0;

void ask_reload(int) { reload_asked = 1; }

class Shell {
 public:
  Shell()
      : node_(read_settings<sr::Settings>(own_)),
        odometry_(public_.advertise<nav_msgs::Odometry>("odom", 10)),
        map_pose_(public_.advertise<geometry_msgs::PoseWithCovarianceStamped>("map_pose", 10)),
        diagnostics_(public_.advertise<diagnostic_msgs::DiagnosticArray>("/diagnostics", 10)),
        reload_(own_.advertiseService("reload", &Shell::on_reload, this)) {
    node_.refuse_own_topics(
        {odometry_.getTopic(), map_pose_.getTopic()},
        [this](const std::string& topic) { return public_.resolveName(topic); });
    network_.setCallbackQueue(&messages_);
    numbers_ = std::make_unique<NumberTopics<sr::Node>>(
        network_, node_, [this](const sr::NumbersMessage& in) { on_numbers(in); });
    pose_ = network_.subscribe(node_.pose_topic(), kQueue, &Shell::on_pose, this,
                               ros::TransportHints().tcpNoDelay());
    const double rate = node_.settings().rate;
    if (rate > 0.0) {
      timer_ = std::make_unique<sr::NetworkTimer>(rate, messages_, [this] { publish(); });
    }
    slow_ = public_.createWallTimer(ros::WallDuration(1.0), [this](const ros::WallTimerEvent&) {
      const auto held = messages_.hold();
      diagnose();
    });
  }

  /// Services, diagnostics and signals; all else happens in the network's thread.
  void spin() {
    while (ros::ok()) {
      ros::getGlobalCallbackQueue()->callAvailable(ros::WallDuration(kLongest));
      if (reload_asked == 0) continue;
      reload_asked = 0;
      const auto held = messages_.hold();
      sr::reload(node_, say);
    }
    ros::shutdown();  // joins the network's thread
  }

 private:
  static constexpr std::uint32_t kQueue = 100;
  static constexpr double kLongest = 0.1;  // between two looks at signals [s]

  void on_pose(const ros::MessageEvent<ShapeShifter const>& event) {
    const ShapeShifter& any = *event.getConstMessage();
    const std::string& type = any.getDataType();
    sr::PoseMessage in;
    in.arrival = nanoseconds(ros::Time::now());
    if (type == "geometry_msgs/PoseStamped") {
      const auto m = any.instantiate<geometry_msgs::PoseStamped>();
      take_pose(m->header, m->pose, in);
    } else if (type == "geometry_msgs/PoseWithCovarianceStamped") {
      const auto m = any.instantiate<geometry_msgs::PoseWithCovarianceStamped>();
      in.has_covariance = sr::read_covariance(m->pose.covariance, in.covariance);
      take_pose(m->header, m->pose.pose, in);
    } else if (type == "nav_msgs/Odometry") {
      const auto m = any.instantiate<nav_msgs::Odometry>();
      in.has_covariance = sr::read_covariance(m->pose.covariance, in.covariance);
      in.child = m->child_frame_id;
      take_pose(m->header, m->pose.pose, in);
    } else {
      ROS_ERROR_THROTTLE(10.0,
                         "%s is %s; expected geometry_msgs/PoseStamped, "
                         "PoseWithCovarianceStamped or nav_msgs/Odometry",
                         node_.pose_topic().c_str(), type.c_str());
    }
  }

  template <class Header, class Pose>
  void take_pose(const Header& header, const Pose& pose, sr::PoseMessage& in) {
    in.stamp = nanoseconds(header.stamp);
    in.frame = header.frame_id;
    sr::read(pose, in.eta);
    node_.pose(in);
  }

  void on_numbers(const sr::NumbersMessage& in) {
    node_.numbers(in);
    if (node_.settings().rate == 0.0) publish();
  }

  void publish() {
    const ros::Time now = ros::Time::now();
    if (now.isZero()) return;  // simulated time that has not begun
    const seatrial::Odometry found = node_.tick(nanoseconds(now));
    if (!found.known) return;
    const sr::Settings& s = node_.settings();
    nav_msgs::Odometry message;
    message.header.stamp = now;
    sr::fill(found, {s.odom_frame, s.base_frame}, message);
    odometry_.publish(message);
    if (map_pose_.getNumSubscribers() > 0) {
      geometry_msgs::PoseWithCovarianceStamped pose;
      pose.header.stamp = now;
      pose.header.frame_id = node_.map_frame();
      sr::fill_map_pose(found, pose.pose);
      map_pose_.publish(pose);
    }
    if (s.publish_tf) send(now, s.odom_frame, s.base_frame, found.pose);
    if (s.publish_map_to_odom && !node_.map_frame().empty()) {
      send(now, node_.map_frame(), s.odom_frame, found.map_to_odom);
    }
  }

  void send(const ros::Time& now, const std::string& parent, const std::string& child,
            const double* pose) {
    geometry_msgs::TransformStamped message;
    message.header.stamp = now;
    message.header.frame_id = parent;
    message.child_frame_id = child;
    sr::fill(pose, message.transform);
    broadcaster_.sendTransform(message);
  }

  void diagnose() {
    sr::adopt(node_, say);
    diagnostics_.publish(
        sr::diagnostics(node_.diagnose(nanoseconds(ros::Time::now())), "odometry"));
  }

  static void say(bool failed, const std::string& what) {
    if (failed) {
      ROS_ERROR("%s", what.c_str());
    } else {
      ROS_INFO("%s", what.c_str());
    }
  }

  bool on_reload(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response) {
    const auto held = messages_.hold();
    response.message = sr::reload(node_, say);
    response.success = response.message.empty();
    return true;
  }

  sr::NetworkQueue messages_;
  ros::NodeHandle public_;
  ros::NodeHandle network_;
  ros::NodeHandle own_{"~"};
  sr::Node node_;
  ros::Publisher odometry_;
  ros::Publisher map_pose_;
  ros::Publisher diagnostics_;
  ros::ServiceServer reload_;
  tf2_ros::TransformBroadcaster broadcaster_;
  std::unique_ptr<NumberTopics<sr::Node>> numbers_;  // these last: messages come from here on
  ros::Subscriber pose_;
  std::unique_ptr<sr::NetworkTimer> timer_;
  ros::WallTimer slow_;
};

}  // namespace

int main(int argc, char** argv) {
  return sr::run("seatrial_odometry", [&] {
    ros::init(argc, argv, "seatrial_odometry");
    std::signal(SIGHUP, ask_reload);
    Shell shell;
    shell.spin();
  });
}
