// SPDX-License-Identifier: MIT
// The nodes by their names, and a node's life from its start to its end.
#pragma once
#include <atomic>
#include <functional>
#include <memory>
#include <rclcpp/rclcpp.hpp>

namespace seatrial_odometry {

using NodePtr = std::shared_ptr<rclcpp::Node>;

/// Throw std::runtime_error, with one line for whoever starts it, where the settings can't be used.
NodePtr make_odometry(const rclcpp::NodeOptions& options);
NodePtr make_simulator(const rclcpp::NodeOptions& options);
NodePtr make_mimic(const rclcpp::NodeOptions& options);
NodePtr make_tracking(const rclcpp::NodeOptions& options);

/// From now on SIGHUP reloads the model of this process' odometry nodes.
void reload_on_hangup();

/// What a node that drives something does before it ends: it stops it. Before its context shuts
/// down, or before the node is taken out of a container.
class LastAct {
 public:
  /// stop: called once, from any thread.
  LastAct(rclcpp::Node& node, std::function<void()> stop);
  ~LastAct();
  LastAct(const LastAct&) = delete;  // the context holds its address
  LastAct& operator=(const LastAct&) = delete;

 private:
  void once();

  rclcpp::Context::SharedPtr context_;
  std::function<void()> stop_;
  std::atomic<bool> done_{false};
  rclcpp::PreShutdownCallbackHandle handle_;
};

}  // namespace seatrial_odometry
