// SPDX-License-Identifier: MIT
// Declarations after tf2_ros (Humble); see ../rclcpp/rclcpp.hpp.
#pragma once
#include <geometry_msgs/msg/transform_stamped.hpp>
#include <vector>

namespace tf2_ros {

class StaticTransformBroadcaster {
 public:
  template <class NodeT>
  explicit StaticTransformBroadcaster(NodeT&& node);
  void sendTransform(const geometry_msgs::msg::TransformStamped& transform);
  void sendTransform(const std::vector<geometry_msgs::msg::TransformStamped>& transforms);
};

}  // namespace tf2_ros
