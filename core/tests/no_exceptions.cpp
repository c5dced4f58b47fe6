// SPDX-License-Identifier: MIT
// Compiled with -fno-exceptions -fno-rtti: all that runs on board, used once.
#include "no_exceptions.hpp"

#include "seatrial/control/allocator.hpp"
#include "seatrial/control/tracking.hpp"
#include "seatrial/integration/sensitivities.hpp"
#include "seatrial/simulation/mimic.hpp"
#include "seatrial/simulation/plant.hpp"

namespace {

/// u_dot = coefficient u + F.
seatrial::Structure drag_and_force() {
  using namespace seatrial;  // NOLINT(google-build-using-namespace)
  Structure s;
  s.n_terms = 2;
  s.n_coefficients = 1;
  s.n_forces = 1;
  s.terms[0].coefficient = 0;
  s.terms[0].n_factors = 1;
  s.terms[0].factors[0] = kU;
  s.terms[1].n_factors = 1;
  s.terms[1].factors[0] = kForce0;
  return s;
}

seatrial::Chain one_thruster() {
  seatrial::Chain c;
  c.allocation.n_commands = 1;
  c.allocation.n_actuators = 1;
  c.n_forces = 1;
  c.mix[0][0] = 1.0;
  return c;
}

}  // namespace

/// Surge speed after 1 s at full command of a boat with u_dot = -u + F; NaN where refused.
double drive_without_exceptions() {
  using namespace seatrial;  // NOLINT(google-build-using-namespace)
  const Structure s = drag_and_force();
  if (check(s) != StructureFault::kOk) return std::nan("");
  const Chain c = one_thruster();
  const double coefficient = -1.0;
  const double q = 0.0;
  static Plant plant(s, &coefficient, c, &q, 0.01);
  const double still = 0.0;
  plant.reset(0.0, &still);
  const double full = 1.0;
  if (!plant.command(0.0, &full) || !plant.advance_to(1.0)) return std::nan("");
  return plant.state()[3];
}

/// The same as a carrier without a lag is told it.
double mimic_without_exceptions() {
  using namespace seatrial;  // NOLINT(google-build-using-namespace)
  const double coefficient = -1.0;
  const double q = 0.0;
  Carrier carrier;
  carrier.lag = 0.0;
  carrier.acceleration = 100.0;
  static Mimic mimic(Plant(drag_and_force(), &coefficient, one_thruster(), &q, 0.01), carrier, 9.0);
  const double full = 1.0;
  if (!mimic.command(0.0, &full, 1)) return std::nan("");
  return mimic.at(1.0).velocity[0];
}

/// The same by the step with sensitivities; `slope` is d u / d coefficient.
double drive_with_sensitivities(double* slope) {
  using namespace seatrial;  // NOLINT(google-build-using-namespace)
  const Structure s = drag_and_force();
  const Chain c = one_thruster();
  Columns columns;
  columns.n_coefficients = 1;
  const double coefficient = -1.0;
  Thrust f;
  f.target[0] = 1.0;
  f.multiplier[0] = 1.0;
  ThrustSensitivities df;
  StateSensitivities dx;
  seed(columns, dx);
  double x[kStates] = {0.0};
  const double still[kMaxConstants] = {0.0};
  if (!advance_sensitivities(s, &coefficient, c, still, columns, 1.0, still, 0.01, f, df, x, dx)) {
    return std::nan("");
  }
  *slope = dx.row[3][0];
  return x[3];
}

/// Command of the first of four thrusters at the corners for a yaw moment of 0.3.
double allocate_without_exceptions() {
  using namespace seatrial;  // NOLINT(google-build-using-namespace)
  constexpr double signs[4][3] = {{-1, 1, 1}, {-1, -1, -1}, {1, 1, -1}, {1, -1, 1}};
  AllocatorSetup s;
  s.scheme = AllocatorScheme::kMoorePenrose;
  s.effectiveness.n = 4;
  for (int k = 0; k < 4; ++k) {
    for (int j = 0; j < 3; ++j) s.effectiveness.column[k][j] = 0.5 * signs[k][j];
    s.limit[k] = 1.0;
  }
  Allocator allocator(s);
  if (allocator.fault() != AllocatorFault::kOk) return std::nan("");
  const double wrench[3] = {0.0, 0.0, 0.3};
  double command[kMaxActuators];
  return allocator.allocate(wrench, command).limited ? std::nan("") : command[0];
}
