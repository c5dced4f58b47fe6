// SPDX-License-Identifier: MIT
// What the odometry node is tested and timed with.
//
//   peer latency SECONDS HZ    plays boat and SLAM: joypad messages at HZ, poses at 15 Hz. Measures
//                              from publish() to the odometry that a command brings about (node
//                              with rate 0), as rclcpp hands it over.
//                              Prints: commands answers p50 p99 worst [ms]
//   peer relay RATE            an empty node with the same topics that answers each command with an
//                              empty odometry (0), or publishes one at RATE [Hz]: what ROS costs
//   peer reload                calls the service; prints what it answers
//   peer listen TOPIC TYPE     subscribes, and does nothing
//   peer compose CLASS...      components in one process, with intra-process communication
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <geometry_msgs/msg/pose_stamped.hpp>
#include <memory>
#include <nav_msgs/msg/odometry.hpp>
#include <rclcpp/rclcpp.hpp>
#include <sensor_msgs/msg/joy.hpp>
#include <std_srvs/srv/trigger.hpp>
#include <string>
#include <tf2_msgs/msg/tf_message.hpp>
#include <thread>
#include <vector>
#ifdef RCLCPP_COMPONENTS_STAND_IN
#include <rclcpp_components/register_node_macro.hpp>
#endif

namespace {

using namespace std::chrono_literals;
using Steady = std::chrono::steady_clock;
using geometry_msgs::msg::PoseStamped;
using nav_msgs::msg::Odometry;
using sensor_msgs::msg::Joy;
using tf2_msgs::msg::TFMessage;

double seconds(Steady::duration span) { return std::chrono::duration<double>(span).count(); }

double at(const std::vector<double>& sorted, double share) {
  return 1e3 * sorted[static_cast<std::size_t>(share * static_cast<double>(sorted.size() - 1))];
}

int latency(const rclcpp::Node::SharedPtr& node, double length, double rate) {
  const auto joypad = node->create_publisher<Joy>("joy", 10);
  const auto slam = node->create_publisher<PoseStamped>("slam/pose", 10);
  std::atomic<Steady::time_point> sent{Steady::now()};
  std::vector<double> took;
  const auto odometry = node->create_subscription<Odometry>(
      "odom", 10, [&sent, &took](const Odometry::ConstSharedPtr&) {
        took.push_back(seconds(Steady::now() - sent.load()));
      });
  while (rclcpp::ok() &&
         (joypad->get_subscription_count() == 0 || slam->get_subscription_count() == 0 ||
          odometry->get_publisher_count() == 0)) {
    std::this_thread::sleep_for(50ms);
  }
  std::thread hearing([&node] { rclcpp::spin(node); });
  const auto begin = Steady::now();
  int commands = 0;
  for (int poses = 0; rclcpp::ok();) {
    const double t = seconds(Steady::now() - begin);
    if (t > length) break;
    if (t >= poses / 15.0) {
      PoseStamped pose;
      pose.header.stamp = node->now();
      pose.header.frame_id = "map";
      slam->publish(pose);
      ++poses;
    }
    Joy joy;
    joy.header.stamp = node->now();
    joy.axes = {0.0F, commands % 200 < 100 ? 0.3F : -0.3F, 0.0F, 0.0F, 0.0F, 0.0F};
    sent = Steady::now();
    joypad->publish(joy);
    ++commands;
    std::this_thread::sleep_until(begin + std::chrono::duration<double>(commands / rate));
  }
  rclcpp::shutdown();
  hearing.join();
  if (took.empty()) {
    std::fprintf(stderr, "latency: no odometry came\n");
    return 1;
  }
  std::sort(took.begin(), took.end());
  std::printf("%d %zu %.3f %.3f %.3f\n", commands, took.size(), at(took, 0.5), at(took, 0.99),
              1e3 * took.back());
  return 0;
}

int relay(const rclcpp::Node::SharedPtr& node, double rate) {
  const auto odometry = node->create_publisher<Odometry>("odom", 10);
  const auto tf = node->create_publisher<TFMessage>("/tf", 100);
  const auto publish = [&node, &odometry, &tf] {
    Odometry message;
    message.header.stamp = node->now();
    message.header.frame_id = "odom";
    message.child_frame_id = "base_link";
    odometry->publish(message);
    TFMessage transforms;
    transforms.transforms.resize(1);
    transforms.transforms[0].header = message.header;
    transforms.transforms[0].child_frame_id = message.child_frame_id;
    tf->publish(transforms);
  };
  const auto joy = node->create_subscription<Joy>("joy", rclcpp::SensorDataQoS(),
                                                  [rate, &publish](const Joy::ConstSharedPtr&) {
                                                    if (rate == 0.0) publish();
                                                  });
  const auto pose = node->create_subscription<PoseStamped>(
      "slam/pose", rclcpp::SensorDataQoS(), [](const PoseStamped::ConstSharedPtr&) {});
  rclcpp::TimerBase::SharedPtr timer;
  if (rate > 0.0) {
    timer = node->create_wall_timer(std::chrono::duration<double>(1.0 / rate), publish);
  }
  rclcpp::spin(node);
  return 0;
}

int reload(const rclcpp::Node::SharedPtr& node) {
  using std_srvs::srv::Trigger;
  const auto client = node->create_client<Trigger>("/seatrial_odometry/reload");
  if (!client->wait_for_service(10s)) return 1;
  auto answer = client->async_send_request(std::make_shared<Trigger::Request>());
  if (rclcpp::spin_until_future_complete(node, answer, 10s) != rclcpp::FutureReturnCode::SUCCESS) {
    return 1;
  }
  const auto found = answer.get();
  std::printf("%s %s\n", found->success ? "success" : "failure", found->message.c_str());
  return 0;
}

int listen(const rclcpp::Node::SharedPtr& node, const std::string& topic, const std::string& type) {
  const auto heard = node->create_generic_subscription(
      topic, type, 10, [](std::shared_ptr<rclcpp::SerializedMessage>) {});
  rclcpp::spin(node);
  return 0;
}

int compose(const std::vector<std::string>& names) {
#ifdef RCLCPP_COMPONENTS_STAND_IN
  std::vector<rclcpp::Node::SharedPtr> nodes;
  rclcpp::executors::SingleThreadedExecutor executor;
  for (const std::string& name : names) {
    const auto options = rclcpp::NodeOptions().use_intra_process_comms(true);
    nodes.push_back(rclcpp_components::registered().at(name)(options));
    executor.add_node(nodes.back());
  }
  executor.spin();
  return 0;
#else
  std::fprintf(stderr, "built without the stand-in for rclcpp_components: %zu names\n",
               names.size());
  return 1;
#endif
}

}  // namespace

int main(int argc, char** argv) {
  const std::vector<std::string> words = rclcpp::init_and_remove_ros_arguments(argc, argv);
  const std::string what = words.size() > 1 ? words[1] : "";
  const bool empty = what == "relay";
  const auto node = std::make_shared<rclcpp::Node>(empty ? "seatrial_odometry" : "peer");
  int code = 2;
  if (what == "latency" && words.size() == 4) {
    code = latency(node, std::stod(words[2]), std::stod(words[3]));
  } else if (empty && words.size() == 3) {
    code = relay(node, std::stod(words[2]));
  } else if (what == "reload") {
    code = reload(node);
  } else if (what == "listen" && words.size() == 4) {
    code = listen(node, words[2], words[3]);
  } else if (what == "compose") {
    code = compose({words.begin() + 2, words.end()});
  }
  rclcpp::shutdown();
  return code;
}
