// SPDX-License-Identifier: MIT
// What the simulator's node publishes of each boat, as messages of either ROS.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "seatrial_ros/sim_messages.hpp"
#include "seatrial_ros/sim_node.hpp"

namespace seatrial::ros {

/// Sends a message to its topic.
template <class Message>
using Send = std::function<void(const Message&)>;

/// Outlets of all boats; Messages names the types. Stamps are the caller's.
template <class Messages>
class SimOutlets {
 public:
  /// advertise(topic, send): makes `send` publish there.
  template <class Advertise>
  SimOutlets(const SimNode& node, const Advertise& advertise) : node_(&node) {
    const SimSettings& s = node.settings();
    const Sensors& sensors = node.sensors();
    for (int boat = 0; boat < node.n_boats(); ++boat) {
      Outlets out;
      advertise(node.named(boat, "truth"), out.truth);
      advertise(node.named(boat, "taken"), out.taken);
      if (sensors.pose) advertise(node.pose_topic(boat), out.pose);
      if (sensors.imu) advertise(node.named(boat, "imu"), out.imu);
      if (sensors.lidar) advertise(node.named(boat, "scan"), out.scan);
      out.frames = {s.map_frame, node.named(boat, s.base_frame)};
      out.laser = node.named(boat, s.laser_frame);
      all_.push_back(out);
    }
  }

  /// Where the LiDARs are; none without them.
  std::vector<typename Messages::TransformStamped> lasers() const {
    std::vector<typename Messages::TransformStamped> found;
    for (const Outlets& out : all_) {
      if (!out.scan) continue;
      typename Messages::TransformStamped message;
      message.header.frame_id = out.frames.base_link;
      message.child_frame_id = out.laser;
      fill(node_->sensors().lidar->mount, message.transform);
      found.push_back(message);
    }
    return found;
  }

  template <class Stamp>
  void taken(int boat, const Signal& command, const Stamp& stamp) const {
    typename Messages::JointState message;
    message.header.stamp = stamp;
    fill_taken(command, message);
    of(boat).taken(message);
  }

  template <class Stamp>
  void truth(int boat, const Stamp& stamp) const {
    double x[kStates];
    node_->state(boat, x);
    typename Messages::Odometry message;
    message.header.stamp = stamp;
    fill_truth(x, of(boat).frames, message);
    of(boat).truth(message);
  }

  template <class Stamp>
  void reading(const Reading& reading, const Stamp& stamp) const {
    const Outlets& out = of(reading.boat);
    if (reading.kind == ReadingKind::kPose) {
      typename Messages::PoseStamped message;
      message.header.frame_id = node_->pose_frame(reading.boat);
      double raw[3];
      node_->as_message(reading.boat, reading.values.data(), raw);
      fill_pose(raw, message.pose);
      send(message, stamp, out.pose);
    } else if (reading.kind == ReadingKind::kImu) {
      typename Messages::Imu message;
      message.header.frame_id = out.frames.base_link;
      fill_imu(reading, *node_->sensors().imu, message);
      send(message, stamp, out.imu);
    } else {
      typename Messages::LaserScan message;
      message.header.frame_id = out.laser;
      fill_scan(reading, *node_->sensors().lidar, message);
      send(message, stamp, out.scan);
    }
  }

 private:
  struct Outlets {
    Send<typename Messages::PoseStamped> pose;  // this, imu and scan: where there is such a sensor
    Send<typename Messages::Odometry> truth;
    Send<typename Messages::JointState> taken;
    Send<typename Messages::Imu> imu;
    Send<typename Messages::LaserScan> scan;
    Frames frames;
    std::string laser;
  };

  const Outlets& of(int boat) const { return all_[static_cast<std::size_t>(boat)]; }

  template <class Message, class Stamp>
  static void send(Message& message, const Stamp& stamp, const Send<Message>& to) {
    message.header.stamp = stamp;
    to(message);
  }

  const SimNode* node_;
  std::vector<Outlets> all_;
};

}  // namespace seatrial::ros
