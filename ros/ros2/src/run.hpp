// SPDX-License-Identifier: MIT
// A node from its start to its end.
#pragma once
#include <chrono>
#include <csignal>
#include <cstdio>
#include <exception>
#include <functional>
#include <memory>
#include <rclcpp/rclcpp.hpp>

namespace seatrial::ros {

/// Runs until the node ends; on what it can't do, one line and exit code 1. After rclcpp::init.
template <class Shell>
int run(const char* name) {
  int code = 0;
  try {
    rclcpp::spin(std::make_shared<Shell>());
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s: %s\n", name, error.what());
    code = 1;
  }
  rclcpp::shutdown();
  return code;
}

inline volatile std::sig_atomic_t end_asked = 0;

/// rclcpp::init for a node with a LastAct: rclcpp's own handlers would end it before that.
inline void init_with_last_act(int argc, char** argv) {
  rclcpp::init(argc, argv, rclcpp::InitOptions(), rclcpp::SignalHandlerOptions::None);
  for (const int signal : {SIGINT, SIGTERM}) std::signal(signal, [](int) { end_asked = 1; });
}

/// What a node that drives something does before it ends: it stops it.
class LastAct {
 public:
  LastAct(rclcpp::Node& node, std::function<void()> stop)
      : timer_(node.create_wall_timer(std::chrono::milliseconds(20), [stop] {
          if (end_asked == 0) return;
          stop();
          rclcpp::sleep_for(std::chrono::milliseconds(100));  // for it to leave
          rclcpp::shutdown();
        })) {}

 private:
  rclcpp::TimerBase::SharedPtr timer_;
};

}  // namespace seatrial::ros
