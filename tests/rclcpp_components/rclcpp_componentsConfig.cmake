# A stand-in for rclcpp_components, which the small ROS 2 of the tests does not have: the same target and function.
add_library(rclcpp_components::component INTERFACE IMPORTED)
set_target_properties(rclcpp_components::component PROPERTIES
  INTERFACE_COMPILE_DEFINITIONS RCLCPP_COMPONENTS_STAND_IN
  INTERFACE_INCLUDE_DIRECTORIES "${CMAKE_CURRENT_LIST_DIR}/include")

function(rclcpp_components_register_nodes target)
  if(NOT TARGET ${target})
    message(FATAL_ERROR "rclcpp_components_register_nodes() first argument '${target}' is not a target")
  endif()
  string(REPLACE ";" "\n" names "${ARGN}")
  file(WRITE ${CMAKE_BINARY_DIR}/components.txt "${names}\n")
endfunction()
