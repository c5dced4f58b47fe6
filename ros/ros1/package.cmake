find_package(catkin REQUIRED COMPONENTS
  diagnostic_msgs geometry_msgs nav_msgs roscpp rosgraph_msgs sensor_msgs std_msgs std_srvs tf2_ros
  topic_tools)
catkin_package()

foreach(node ${nodes})
  add_executable(${node} ros1/src/${node}.cpp)
  target_include_directories(${node} SYSTEM PRIVATE ${catkin_INCLUDE_DIRS})
  target_link_libraries(${node} PRIVATE seatrial_nodes ${catkin_LIBRARIES})
endforeach()

if(SEATRIAL_TESTING)
  foreach(program latency relay)
    add_executable(${program} ros1/test/${program}.cpp)
    target_include_directories(${program} SYSTEM PRIVATE ${catkin_INCLUDE_DIRS})
    target_link_libraries(${program} PRIVATE ${catkin_LIBRARIES})
  endforeach()
endif()

install(TARGETS ${nodes} RUNTIME DESTINATION ${CATKIN_PACKAGE_BIN_DESTINATION})
install(DIRECTORY ros1/launch ros1/config DESTINATION ${CATKIN_PACKAGE_SHARE_DESTINATION})
if(CATKIN_ENABLE_TESTING)
  find_package(roslaunch QUIET)
  if(roslaunch_FOUND)
    foreach(node ${nodes})  # slam.launch needs hector_mapping
      roslaunch_add_file_check(ros1/launch/${node}.launch)
    endforeach()
  endif()
endif()
