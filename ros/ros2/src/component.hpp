// SPDX-License-Identifier: MIT
// A node as a component, where rclcpp_components was found when this was built.
#pragma once
#ifdef SEATRIAL_COMPONENTS
#include <rclcpp_components/register_node_macro.hpp>
#define SEATRIAL_COMPONENT(Class) RCLCPP_COMPONENTS_REGISTER_NODE(Class)
#else
#define SEATRIAL_COMPONENT(Class)
#endif
