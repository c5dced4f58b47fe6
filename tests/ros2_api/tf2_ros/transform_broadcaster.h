// SPDX-License-Identifier: MIT
// Declarations after tf2_ros (Humble); see ../rclcpp/rclcpp.hpp.
#pragma once
#include <geometry_msgs/msg/transform_stamped.hpp>

namespace tf2_ros {

class TransformBroadcaster {
 public:
  template <class NodeT>
  explicit TransformBroadcaster(NodeT&& node);
  void sendTransform(const geometry_msgs::msg::TransformStamped& transform);
};

}  // namespace tf2_ros
