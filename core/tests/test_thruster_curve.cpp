// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include "seatrial/control/allocator_curve.hpp"

using namespace seatrial;

TEST_CASE("the inverse of a curve undoes it, and waits at the edge where no thrust is requested") {
  Chain chain;
  chain.allocation.n_actuators = 2;
  chain.n_constants = 5;
  const double q[5] = {0.1, 0.2, 0.7, 1.8, 1.1};
  Actuator& shaped = chain.actuators[0];
  shaped.edge_forward = 0;
  shaped.edge_reverse = 1;
  shaped.reverse_ratio = 2;
  shaped.power = 3;
  shaped.gain = 4;
  chain.actuators[1].tabulated = true;
  const double table[5][2] = {{-1, -0.8}, {-0.2, 0}, {0.15, 0}, {0.6, 0.3}, {1, 1}};
  chain.n_table = 5;
  for (int i = 0; i < 5; ++i) {
    chain.table_command[i] = table[i][0];
    chain.table_thrust[i] = table[i][1];
  }
  const double edges[2][2] = {{0.1, 0.2}, {0.15, 0.2}};
  for (int k = 0; k < 2; ++k) {
    const ThrusterCurve c(chain, q, k, true);
    REQUIRE(c.invertible(chain));
    for (int i = -100; i <= 100; ++i) {
      double row[kMaxActuators] = {};
      row[k] = 0.01 * i;
      const double thrust = c.thrust(chain, q, row[k]);
      CHECK(thrust == doctest::Approx(curve(chain, q, k, row, nullptr)).epsilon(1e-14));
      if (thrust == 0.0) continue;
      CHECK(c.command(chain, thrust, Side::kOff) == doctest::Approx(row[k]).epsilon(1e-12));
    }
    CHECK(c.command(chain, 0.0, Side::kForward) == edges[k][0]);
    CHECK(c.command(chain, 0.0, Side::kReverse) == -edges[k][1]);
    CHECK(c.command(chain, 0.0, Side::kOff) == 0.0);
  }
  chain.table_thrust[3] = 0.0;
  chain.table_thrust[4] = -0.1;  // falls
  CHECK_FALSE(ThrusterCurve(chain, q, 1, true).invertible(chain));
}
