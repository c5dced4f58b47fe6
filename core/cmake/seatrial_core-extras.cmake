# With catkin, which exports no targets: the same target as without.
if(NOT TARGET seatrial_core::seatrial_core)
  find_package(Threads REQUIRED)
  add_library(seatrial_core::seatrial_core INTERFACE IMPORTED)
  set_target_properties(seatrial_core::seatrial_core PROPERTIES
    INTERFACE_INCLUDE_DIRECTORIES "${seatrial_core_INCLUDE_DIRS}"
    INTERFACE_COMPILE_FEATURES cxx_std_17
    INTERFACE_LINK_LIBRARIES Threads::Threads)
endif()
