// SPDX-License-Identifier: MIT
// Roll-outs along a recording: simulation, k-step prediction from every start, sensitivities.
#pragma once
#include <algorithm>
#include <cmath>
#include <thread>
#include <vector>

#include "seatrial/integration/step_schedule.hpp"

namespace seatrial {

inline constexpr int kChunk = 512;  // intervals that are scheduled at once: bounds the memory

namespace detail {

/// A state along a roll-out, with optional sensitivities. After a divergence all is NaN.
struct Traveller {
  double x[kStates];
  StateSensitivities dx;
  bool sensitivities;
  bool good = true;

  Traveller(const Columns& columns, const double* x0, bool with_sensitivities)
      : sensitivities(with_sensitivities) {
    std::copy(x0, x0 + kStates, x);
    if (sensitivities) seed(columns, dx);
  }

  void cross(const StepSchedule& schedule, int interval) {
    if (!good) return;
    good = sensitivities ? schedule.run(interval, x, dx) : schedule.run(interval, x);
    if (good) return;
    std::fill(x, x + kStates, std::nan(""));
    for (double(&row)[kMaxColumns] : dx.row) std::fill(row, row + kMaxColumns, std::nan(""));
  }

  /// Row i of the results.
  void write(std::ptrdiff_t i, int width, double* out, double* sensitivities) const {
    std::copy(x, x + kStates, out + i * kStates);
    for (int row = 0; sensitivities && row < kStates; ++row) {
      std::copy(dx.row[row], dx.row[row] + width, sensitivities + (i * kStates + row) * width);
    }
  }
};

}  // namespace detail

/// States at `time` (n, rising) from x0 at time[0]: out has n rows of 6; out[0] = x0.
/// With `sensitivities` (n rows of 6 x columns) also the sensitivities. Returns the rows that are
/// good.
inline int simulate(const Boat& boat, const ThrustTrace& trace, const double* x0,
                    const double* time, int n, double* out, double* sensitivities) {
  if (n < 1) return 0;
  const int width = trace.columns().size();
  detail::Traveller boat_state(trace.columns(), x0, sensitivities != nullptr);
  boat_state.write(0, width, out, sensitivities);
  int reached = 1;
  for (int first = 0; first < n - 1; first += kChunk) {
    const int last = std::min(n - 1, first + kChunk);
    const StepSchedule schedule(boat, trace, time, first, last, sensitivities != nullptr);
    for (int i = first; i < last; ++i) {
      boat_state.cross(schedule, i);
      boat_state.write(i + 1, width, out, sensitivities);
      reached += boat_state.good ? 1 : 0;
    }
  }
  return reached;
}

namespace detail {

/// From j in [begin, end): `begun(j)`, carried from time[start[j]] to time[stop[j]], writes row j
/// of the results. `carry(state, schedule, k)` carries a state over the interval k.
template <class Begun, class Carry, class Write>
void predict_range(const Boat& boat, const ThrustTrace& trace, const double* time, const int* start,
                   const int* stop, int begin, int end, bool sensitivities, Begun begun,
                   Carry carry, Write write) {
  for (int j = begin; j < end;) {
    int next = j + 1;  // starts that lie close together share a schedule, without a gap in it
    int low = start[j];
    int high = start[j];
    int last = stop[j];
    for (; next < end; ++next) {
      const int next_low = std::min(low, start[next]);
      const int next_high = std::max(high, start[next]);
      if (start[next] > last || next_high - next_low > kChunk) break;
      low = next_low;
      high = next_high;
      last = std::max(last, stop[next]);
    }
    const StepSchedule schedule(boat, trace, time, low, last, sensitivities);
    for (; j < next; ++j) {
      auto state = begun(j);
      for (int k = start[j]; k < stop[j]; ++k) carry(state, schedule, k);
      write(j, state);
    }
  }
}

/// `range(begin, end)` of all m starts, spread over threads. Every start writes only its own rows,
/// so that the result does not depend on the number of threads.
template <class Range>
void spread_starts(int m, int threads, Range range) {
  const int n = std::max(1, std::min(threads, m / 64));
  if (n == 1) return range(0, m);
  std::vector<std::thread> pool;
  for (int i = 0; i < n; ++i) {
    const int begin = static_cast<int>(static_cast<long long>(m) * i / n);
    const int end = static_cast<int>(static_cast<long long>(m) * (i + 1) / n);
    pool.emplace_back(range, begin, end);
  }
  for (auto& thread : pool) thread.join();
}

}  // namespace detail

/// All m starts: state x0[j] at time[start[j]], carried to time[stop[j]]. Returns the state there
/// (out, m rows of 6) and, optionally, its sensitivities.
inline void predict(const Boat& boat, const ThrustTrace& trace, const double* time,
                    const int* start, const int* stop, const double* x0, int m, int threads,
                    double* out, double* sensitivities) {
  const int width = trace.columns().size();
  const bool with = sensitivities != nullptr;
  detail::spread_starts(m, threads, [=, &boat, &trace](int begin, int end) {
    detail::predict_range(
        boat, trace, time, start, stop, begin, end, with,
        [&](int j) {
          const double* from = x0 + static_cast<std::ptrdiff_t>(j) * kStates;
          return detail::Traveller(trace.columns(), from, with);
        },
        [](detail::Traveller& state, const StepSchedule& schedule, int k) {
          state.cross(schedule, k);
        },
        [&](int j, const detail::Traveller& state) { state.write(j, width, out, sensitivities); });
  });
}

}  // namespace seatrial
