// SPDX-License-Identifier: MIT
// What a node that drives something does before it ends: it stops it.
#pragma once
#include <ros/ros.h>
#include <ros/xmlrpc_manager.h>

#include <atomic>
#include <csignal>
#include <functional>
#include <string>
#include <utility>

namespace seatrial::ros {

inline std::atomic<bool> end_asked{false};

/// ros::init for a node with a last act: ROS's own handler of signals would end it before that.
inline void init_with_last_act(int& argc, char** argv, const std::string& name) {
  ::ros::init(argc, argv, name, ::ros::init_options::NoSigintHandler);
  const auto ask_end = [](int) { end_asked = true; };
  std::signal(SIGINT, ask_end);
  std::signal(SIGTERM, ask_end);
}

/// Once the node is asked to end, by a signal or the master (rosnode kill, a second node of its
/// name), it stops what it drives, and ROS shuts down. The same where an exception ends it.
class LastAct {
 public:
  LastAct(::ros::NodeHandle& node, std::function<void()> stop)
      : stop_(std::move(stop)),
        timer_(node.createWallTimer(::ros::WallDuration(0.02),
                                    [this](const ::ros::WallTimerEvent&) { look(); })) {
    // ROS's own answer to the master would end the spinning before that, too
    const ::ros::XMLRPCManagerPtr& master = ::ros::XMLRPCManager::instance();
    master->unbind("shutdown");
    master->bind("shutdown", [](XmlRpc::XmlRpcValue&, XmlRpc::XmlRpcValue& answer) {
      end_asked = true;
      answer = ::ros::xmlrpc::responseInt(1, "", 0);
    });
  }

  ~LastAct() {
    if (::ros::ok()) act();
  }

  LastAct(const LastAct&) = delete;  // its timer holds its address
  LastAct& operator=(const LastAct&) = delete;

 private:
  void look() {
    if (!end_asked) return;
    act();
    ::ros::shutdown();
  }

  void act() const {
    stop_();
    ::ros::WallDuration(0.1).sleep();  // for its last message to leave
  }

  std::function<void()> stop_;
  ::ros::WallTimer timer_;
};

}  // namespace seatrial::ros
