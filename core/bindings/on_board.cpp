// SPDX-License-Identifier: MIT
#include "on_board.hpp"

#include "allocator.hpp"
#include "mimic.hpp"
#include "parameter_uncertainty.hpp"
#include "predictor.hpp"
#include "simulator.hpp"
#include "tracking.hpp"

void bind_on_board(nb::module_& m) {
  bind_predictor(m);
  bind_odometer(m);
  bind_parameter_uncertainty(m);
  bind_allocator(m);
  bind_steering(m);
  bind_tracking(m);
  bind_simulator(m);
  bind_mimic(m);
}
