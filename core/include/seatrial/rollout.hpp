// SPDX-License-Identifier: MIT
// Roll-outs along a recording: simulation, k-step prediction from every start, sensitivities.
#pragma once
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <thread>
#include <vector>

#include "seatrial/trace.hpp"

namespace seatrial {

/// A model and the way it is integrated.
struct Boat {
  Structure structure;
  double coefficient[kMaxCoefficients] = {};
  Integrator integrator = Integrator::kRungeKutta;
  double longest_step = 1.0 / 60.0;  // [s] of the Runge-Kutta integrator
};

namespace detail {

inline void fail(double* x) { std::fill(x, x + kStates, std::nan("")); }

inline void fail(StateTangent& dx) {
  for (double(&row)[kMaxColumns] : dx.row) std::fill(row, row + kMaxColumns, std::nan(""));
}

}  // namespace detail

/// From t0 to t1, breaking at every change of the input. `cursor` is the break before t0 and is
/// moved along. False, and NaN, where the boat diverged.
inline bool roll(const Boat& boat, const Trace& trace, double t0, double t1, int& cursor,
                 double* x) {
  if (boat.integrator == Integrator::kForwardEuler) {
    Thrust f;
    double force[kMaxForces];
    cursor = trace.find(t0);
    trace.at(cursor, t0, f);
    forces_after(trace.chain(), trace.constants(), f, 0.0, force);
    if (euler_step(boat.structure, boat.coefficient, t1 - t0, force, x) && bounded(x)) return true;
    detail::fail(x);
    return false;
  }
  double t = t0;
  while (t < t1) {
    while (cursor + 1 < trace.breaks() && trace.time(cursor + 1) <= t) ++cursor;
    const double next = cursor + 1 < trace.breaks() ? trace.time(cursor + 1)
                                                    : std::numeric_limits<double>::infinity();
    const double end = std::min(t1, next);
    Thrust f;
    trace.at(cursor, t, f);
    if (!advance(boat.structure, boat.coefficient, trace.chain(), trace.constants(), end - t,
                 boat.longest_step, f, x)) {
      detail::fail(x);
      return false;
    }
    t = end;
  }
  return true;
}

/// `roll` with tangents of the state to trace.columns(). A break moves with its latency, a stamp
/// does not. Where both coincide a jump's derivative is the one from the left: the break came
/// first.
inline bool roll_tangent(const Boat& boat, const Trace& trace, double t0, double t1, int& cursor,
                         double* x, StateTangent& dx) {
  const Columns& columns = trace.columns();
  Thrust f;
  ThrustTangent df;
  if (boat.integrator == Integrator::kForwardEuler) {
    cursor = trace.find(t0);
    trace.at(cursor, t0, nullptr, f, df);
    detail::StepForces forces;
    double output[kMaxActuators];
    double doutput[kMaxActuators][kMaxConstants];
    for (int k = 0; k < trace.chain().n_actuators(); ++k) {
      output[k] = detail::output_tangent(columns, f, df, k, f.level[k], df.level[k], doutput[k]);
    }
    detail::mix_node(trace.chain(), columns, output, doutput, 0, forces);
    return euler_step_tangent(boat.structure, boat.coefficient, columns, t1 - t0, forces.force[0],
                              forces.dforce[0], x, dx) &&
           bounded(x);
  }
  if (!(t0 < t1)) return true;
  while (cursor + 1 < trace.breaks() && trace.time(cursor + 1) <= t0) ++cursor;
  double t = t0;
  double dbegin[kMaxConstants] = {0.0};
  for (bool more = true; more;) {
    more = cursor + 1 < trace.breaks() && trace.time(cursor + 1) <= t1;
    const double end = more ? trace.time(cursor + 1) : t1;
    double dend[kMaxConstants] = {0.0};
    double dlength[kMaxConstants];
    if (more) trace.time_tangent(cursor + 1, 1.0, dend);
    std::transform(dend, dend + kMaxConstants, dbegin, dlength, std::minus<>());
    // breaks at one instant may move apart: an interval without length has a derivative
    if (t < end || !std::equal(dend, dend + kMaxConstants, dbegin)) {
      trace.at(cursor, t, dbegin, f, df);
      if (!advance_tangent(boat.structure, boat.coefficient, trace.chain(), trace.constants(),
                           columns, end - t, dlength, boat.longest_step, f, df, x, dx)) {
        return false;
      }
    }
    t = end;
    std::copy(dend, dend + kMaxConstants, dbegin);
    cursor += more ? 1 : 0;
  }
  return true;
}

/// States at `time` (n, rising) from x0 at time[0]: out has n rows of 6; out[0] = x0.
/// With `tangent` (n rows of 6 x columns) also the sensitivities. Returns the rows that are good.
inline int simulate(const Boat& boat, const Trace& trace, const double* x0, const double* time,
                    int n, double* out, double* tangent) {
  const int width = trace.columns().size();
  double x[kStates];
  StateTangent dx;
  std::copy(x0, x0 + kStates, x);
  seed(trace.columns(), dx);
  int cursor = trace.find(n > 0 ? time[0] : 0.0);
  bool good = true;
  int reached = 0;
  for (int i = 0; i < n; ++i) {
    if (i > 0 && good) {
      good = tangent == nullptr ? roll(boat, trace, time[i - 1], time[i], cursor, x)
                                : roll_tangent(boat, trace, time[i - 1], time[i], cursor, x, dx);
    }
    if (!good) {
      detail::fail(x);
      detail::fail(dx);
    }
    reached += good ? 1 : 0;
    std::copy(x, x + kStates, out + static_cast<std::ptrdiff_t>(i) * kStates);
    for (int row = 0; tangent != nullptr && row < kStates; ++row) {
      double* to = tangent + (static_cast<std::ptrdiff_t>(i) * kStates + row) * width;
      std::copy(dx.row[row], dx.row[row] + width, to);
    }
  }
  return reached;
}

/// From start j: state x0[j] at time[start[j]], carried `steps` samples of `time` further.
/// Returns the state there (out, m rows of 6) and, where asked, its sensitivities.
inline void predict_range(const Boat& boat, const Trace& trace, const double* time,
                          const int* start, const double* x0, int begin, int end, int steps,
                          double* out, double* tangent) {
  const int width = trace.columns().size();
  for (int j = begin; j < end; ++j) {
    double x[kStates];
    StateTangent dx;
    std::copy(x0 + static_cast<std::ptrdiff_t>(j) * kStates,
              x0 + static_cast<std::ptrdiff_t>(j + 1) * kStates, x);
    seed(trace.columns(), dx);
    const double* t = time + start[j];
    int cursor = trace.find(t[0]);
    bool good = true;
    for (int k = 0; k < steps && good; ++k) {
      good = tangent == nullptr ? roll(boat, trace, t[k], t[k + 1], cursor, x)
                                : roll_tangent(boat, trace, t[k], t[k + 1], cursor, x, dx);
    }
    if (!good) {
      detail::fail(x);
      detail::fail(dx);
    }
    std::copy(x, x + kStates, out + static_cast<std::ptrdiff_t>(j) * kStates);
    for (int row = 0; tangent != nullptr && row < kStates; ++row) {
      double* to = tangent + (static_cast<std::ptrdiff_t>(j) * kStates + row) * width;
      std::copy(dx.row[row], dx.row[row] + width, to);
    }
  }
}

/// All m starts, spread over threads. Every start writes only its own rows, so that the result
/// does not depend on the number of threads.
inline void predict(const Boat& boat, const Trace& trace, const double* time, const int* start,
                    const double* x0, int m, int steps, int threads, double* out, double* tangent) {
  const int n = std::max(1, std::min(threads, m / 64));
  if (n == 1) {
    predict_range(boat, trace, time, start, x0, 0, m, steps, out, tangent);
    return;
  }
  std::vector<std::thread> pool;
  for (int i = 0; i < n; ++i) {
    const int begin = static_cast<int>(static_cast<long long>(m) * i / n);
    const int end = static_cast<int>(static_cast<long long>(m) * (i + 1) / n);
    pool.emplace_back([&, begin, end] {
      predict_range(boat, trace, time, start, x0, begin, end, steps, out, tangent);
    });
  }
  for (auto& thread : pool) thread.join();
}

}  // namespace seatrial
