// SPDX-License-Identifier: MIT
// Every include path of release 0.1 still compiles.
#include <doctest/doctest.h>

#include "seatrial/actuators.hpp"
#include "seatrial/allocation.hpp"
#include "seatrial/allocator.hpp"
#include "seatrial/allocator_curve.hpp"
#include "seatrial/allocator_effort.hpp"
#include "seatrial/allocator_idle.hpp"
#include "seatrial/allocator_reach.hpp"
#include "seatrial/axis_commands.hpp"
#include "seatrial/belief.hpp"
#include "seatrial/causes.hpp"
#include "seatrial/considered.hpp"
#include "seatrial/contact.hpp"
#include "seatrial/correction.hpp"
#include "seatrial/doubt.hpp"
#include "seatrial/dynamics.hpp"
#include "seatrial/fading.hpp"
#include "seatrial/filter.hpp"
#include "seatrial/frames.hpp"
#include "seatrial/health.hpp"
#include "seatrial/history.hpp"
#include "seatrial/innovations.hpp"
#include "seatrial/inverse3.hpp"
#include "seatrial/lidar.hpp"
#include "seatrial/mimic.hpp"
#include "seatrial/motion_noise.hpp"
#include "seatrial/odometer.hpp"
#include "seatrial/onboard.hpp"
#include "seatrial/pass.hpp"
#include "seatrial/plant.hpp"
#include "seatrial/predictor.hpp"
#include "seatrial/random.hpp"
#include "seatrial/random_drive.hpp"
#include "seatrial/rollout.hpp"
#include "seatrial/scene.hpp"
#include "seatrial/schedule.hpp"
#include "seatrial/sensors.hpp"
#include "seatrial/simulator.hpp"
#include "seatrial/step.hpp"
#include "seatrial/structure.hpp"
#include "seatrial/tangents.hpp"
#include "seatrial/timeline.hpp"
#include "seatrial/trace.hpp"
#include "seatrial/tracking.hpp"
#include "seatrial/way.hpp"

TEST_CASE("a program of release 0.1 finds its headers under their old paths") {
  static_assert(seatrial::kStates == 6);  // step.hpp
  static_assert(sizeof(seatrial::DrivenBoat) == sizeof(seatrial::OnboardBoat));
  static_assert(sizeof(seatrial::Trace) == sizeof(seatrial::ThrustTrace));
  const seatrial::MotionNoise noise;
  CHECK(noise.memory == 2.0);
  CHECK(seatrial::wrap(7.0) == doctest::Approx(0.7168146));  // frames.hpp
}
