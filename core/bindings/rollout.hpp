// SPDX-License-Identifier: MIT
// Python's view of the boat along a recording: one simulation, or predictions from many starts.
#pragma once
#include <nanobind/stl/pair.h>

#include <utility>

#include "arrays.hpp"
#include "filter.hpp"
#include "seatrial/filter/lookahead.hpp"

namespace {

using namespace seatrial;

/// States (rows x 6) and d state / d columns (rows x 6 x columns) for Python, and where to write.
struct Rollout {
  Rollout(const ThrustTrace& trace, std::size_t rows, bool sensitivities)
      : states(fresh<Out2>({rows, std::size_t{kStates}}, &out)),
        jacobian(fresh<Out3>({sensitivities ? rows : 0, std::size_t{kStates},
                              sensitivities ? static_cast<std::size_t>(trace.columns().size()) : 0},
                             &made)),
        slopes(sensitivities ? made : nullptr) {}

  double* out = nullptr;
  double* made = nullptr;
  Out2 states;
  Out3 jacobian;
  double* slopes;  // null where sensitivities are not asked for
};

std::pair<Out2, Out3> run_simulate(const Boat& boat, const ThrustTrace& trace, Vector x0,
                                   Vector time, bool sensitivities) {
  check_trace(boat, trace);
  require(x0.shape(0) == kStates, "x0: [x, y, psi, u, v, r]");
  const std::size_t n = time.shape(0);
  const Rollout to(trace, n, sensitivities);
  {
    nb::gil_scoped_release released;
    simulate(boat, trace, x0.data(), time.data(), static_cast<int>(n), to.out, to.slopes);
  }
  return {to.states, to.jacobian};
}

/// Starts and stops are among the times, and each start has a state of `width`.
void check_starts(const Indices& start, const Indices& stop, std::size_t times, const Matrix& x0,
                  std::size_t width) {
  const std::size_t m = start.shape(0);
  require(x0.shape(0) == m && x0.shape(1) == width, "x0: one state for each start");
  require(stop.shape(0) == m, "stop: one for each start");
  for (std::size_t j = 0; j < m; ++j) {
    require(start(j) >= 0 && stop(j) >= start(j) && static_cast<std::size_t>(stop(j)) < times,
            "a start's stop is not among the times after it");
  }
}

std::pair<Out2, Out3> run_predict(const Boat& boat, const ThrustTrace& trace, Vector time,
                                  Indices start, Indices stop, Matrix x0, int threads,
                                  bool sensitivities) {
  check_trace(boat, trace);
  const std::size_t m = start.shape(0);
  check_starts(start, stop, time.shape(0), x0, kStates);
  const Rollout to(trace, m, sensitivities);
  {
    nb::gil_scoped_release released;
    predict(boat, trace, time.data(), start.data(), stop.data(), x0.data(), static_cast<int>(m),
            threads, to.out, to.slopes);
  }
  return {to.states, to.jacobian};
}

Out2 run_lookahead(const Boat& boat, const ThrustTrace& trace, Vector time, Indices start,
                   Indices stop, Matrix x0, Vector noise, bool earth_fixed, int threads) {
  check_trace(boat, trace);
  require(boat.structure.n_coefficients >= kAxes, "boat: its last coefficients: disturbance");
  const std::size_t m = start.shape(0);
  check_starts(start, stop, time.shape(0), x0, kFilterStates);
  const NoiseParameters own = make_noise(noise);
  double* out = nullptr;
  auto found = fresh<Out2>({m, std::size_t{kStates}}, &out);
  {
    nb::gil_scoped_release released;
    lookahead(boat, trace, time.data(), start.data(), stop.data(), x0.data(), static_cast<int>(m),
              own, earth_fixed, threads, out);
  }
  return found;
}

/// Levels of all actuators h [s] after these, with constant targets: lag and rate limit, exact.
Out1 levels_after(const Chain& chain, Vector q, Vector level, Vector target, double h) {
  const auto n = static_cast<std::size_t>(chain.n_actuators());
  require(static_cast<int>(q.shape(0)) == chain.n_constants, "one value for each chain constant");
  require(level.shape(0) == n && target.shape(0) == n, "one level and target an actuator");
  Thrust f;
  std::copy(level.data(), level.data() + n, f.level);
  std::copy(target.data(), target.data() + n, f.target);
  double* out = nullptr;
  auto found = fresh<Out1>({n}, &out);
  for (std::size_t k = 0; k < n; ++k) {
    out[k] = level_after(chain, q.data(), f, static_cast<int>(k), h);
  }
  return found;
}

void bind_rollout(nb::module_& m) {
  using namespace nb::literals;
  m.def("simulate", &run_simulate, "boat"_a, "trace"_a, "x0"_a, "time"_a, "sensitivities"_a = false,
        "States at time (n x 6) from x0 at time[0], and d state / d columns (n x 6 x columns).");
  m.def("predict", &run_predict, "boat"_a, "trace"_a, "time"_a, "start"_a, "stop"_a, "x0"_a,
        "threads"_a = 1, "sensitivities"_a = false,
        "State at the stop of every start (m x 6), and its sensitivities.");
  m.def(
      "lookahead", &run_lookahead, "boat"_a, "trace"_a, "time"_a, "start"_a, "stop"_a, "x0"_a,
      "noise"_a, "earth_fixed"_a = false, "threads"_a = 1,
      "State at the stop of every start (m x 6), from the filter's (m x 9) with its disturbance.");
  m.def("levels_after", &levels_after, "chain"_a, "q"_a, "level"_a, "target"_a, "h"_a,
        "Levels of all actuators h [s] after these, with constant targets.");
}

}  // namespace
