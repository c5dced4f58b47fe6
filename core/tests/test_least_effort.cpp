// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <algorithm>

#include "boats.hpp"
#include "seatrial/control/allocator_effort.hpp"

using namespace seatrial;
using boats::Random;

TEST_CASE("least effort gives what is within reach in few steps, also at bounds") {
  Random random(7);
  int most = 0;
  for (int i = 0; i < 20000; ++i) {
    Effectiveness t;
    Bounds bounds;
    double softness[kMaxActuators];
    double y[kMaxActuators];
    t.n = 4 + i % 5;
    for (int k = 0; k < t.n; ++k) {
      for (double& entry : t.column[k]) entry = random(-1.0, 1.0);
      bounds.low[k] = random(-1.0, 0.1);
      bounds.high[k] = bounds.low[k] + random(0.5, 1.5);
      softness[k] = random(0.3, 3.0);
      const double share = std::min(std::max(random(-1.0, 2.0), 0.0), 1.0);  // two in three at one
      y[k] = bounds.low[k] + share * (bounds.high[k] - bounds.low[k]);
    }
    double wrench[kWrenchAxes];
    t.wrench(y, wrench);
    Reach(t, bounds).pin(t, wrench, bounds);
    const LeastEffort::Outcome out = LeastEffort(t, softness).solve(bounds, wrench, y);
    REQUIRE(out.error < 1e-11);
    most = std::max(most, out.steps);
  }
  CHECK(most < 20);
}
