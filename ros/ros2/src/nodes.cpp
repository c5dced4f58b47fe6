// SPDX-License-Identifier: MIT
#include "nodes.hpp"

#include <chrono>
#include <cstdio>
#include <exception>
#include <string>
#include <utility>

#include "run.hpp"

namespace seatrial_odometry {

namespace {

struct Entry {
  std::string name;
  NodePtr (*make)(const rclcpp::NodeOptions&);
};

const Entry kNodes[] = {{"odometry", make_odometry},
                        {"simulator", make_simulator},
                        {"mimic", make_mimic},
                        {"tracking", make_tracking}};

}  // namespace

int run(const std::string& name, int argc, char** argv) {
  int code = 0;
  try {
    rclcpp::init(argc, argv);
    if (name == "odometry") reload_on_hangup();
    for (const Entry& entry : kNodes) {
      if (entry.name == name) rclcpp::spin(entry.make(rclcpp::NodeOptions()));
    }
  } catch (const std::exception& error) {
    std::fprintf(stderr, "seatrial_%s: %s\n", name.c_str(), error.what());
    code = 1;
  }
  rclcpp::shutdown();
  return code;
}

LastAct::LastAct(rclcpp::Node& node, std::function<void()> stop)
    : context_(node.get_node_base_interface()->get_context()),
      stop_(std::move(stop)),
      handle_(context_->add_pre_shutdown_callback([this] { once(); })) {}

LastAct::~LastAct() {
  context_->remove_pre_shutdown_callback(handle_);
  once();
}

void LastAct::once() {
  if (done_.exchange(true)) return;
  stop_();
  rclcpp::sleep_for(std::chrono::milliseconds(100), context_);  // for it to leave
}

}  // namespace seatrial_odometry
