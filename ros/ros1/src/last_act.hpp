// SPDX-License-Identifier: MIT
// What a node that drives something does before it ends: it stops it.
#pragma once
#include <ros/ros.h>

#include <csignal>
#include <functional>
#include <string>
#include <utility>

namespace seatrial::ros {

inline volatile std::sig_atomic_t end_asked = 0;

/// ros::init for a node with a last act: ROS's own handler of signals would end it before that.
inline void init_with_last_act(int argc, char** argv, const std::string& name) {
  ::ros::init(argc, argv, name, ::ros::init_options::NoSigintHandler);
  const auto ask_end = [](int) { end_asked = 1; };
  std::signal(SIGINT, ask_end);
  std::signal(SIGTERM, ask_end);
}

/// Once the node is asked to end it stops what it drives, and ROS shuts down.
class LastAct {
 public:
  LastAct(::ros::NodeHandle& node, std::function<void()> stop)
      : stop_(std::move(stop)),
        timer_(node.createWallTimer(::ros::WallDuration(0.02),
                                    [this](const ::ros::WallTimerEvent&) { look(); })) {}

 private:
  void look() {
    if (end_asked == 0) return;
    stop_();
    ::ros::WallDuration(0.1).sleep();  // for its last message to leave
    ::ros::shutdown();
  }

  std::function<void()> stop_;
  ::ros::WallTimer timer_;
};

}  // namespace seatrial::ros
