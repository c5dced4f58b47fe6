// SPDX-License-Identifier: MIT
// The steps between stamps with the forces at their nodes. They do not depend on the boat, so
// roll-outs from many starts share them. Host side: uses heap.
#pragma once
#include <algorithm>
#include <vector>

#include "seatrial/integration/thrust_trace.hpp"

namespace seatrial {

/// A model and its integrator.
struct Boat {
  Structure structure;
  double coefficient[kMaxCoefficients] = {};
  Integrator integrator = Integrator::kRungeKutta;
  double longest_step = 1.0 / 60.0;  // [s] of the Runge-Kutta integrator
};

/// Steps of the intervals time[first] .. time[last]: Runge-Kutta steps that break at every change
/// of the input, or one forward-Euler step an interval with the force at its begin.
class StepSchedule {
 public:
  StepSchedule(const Boat& boat, const ThrustTrace& trace, const double* time, int first, int last,
               bool sensitivities)
      : boat_(boat), trace_(trace), first_(first), sensitivities_(sensitivities) {
    begin_.reserve(static_cast<std::size_t>(last - first) + 1);
    for (int i = first; i < last; ++i) {
      begin_.push_back(steps_.size());
      if (boat.integrator == Integrator::kForwardEuler) {
        add_euler(time[i], time[i + 1]);
      } else if (sensitivities) {
        add_sensitivities(time[i], time[i + 1]);
      } else {
        add(time[i], time[i + 1]);
      }
    }
    begin_.push_back(steps_.size());
  }

  /// The state over interval i, time[i] to time[i + 1]. False, and NaN, where the boat diverged.
  bool run(int i, double* x) const {
    const auto at = static_cast<std::size_t>(i - first_);
    for (std::size_t k = begin_[at]; k < begin_[at + 1]; ++k) {
      const Step& step = steps_[k];
      const bool solved =
          boat_.integrator == Integrator::kForwardEuler
              ? euler_step(boat_.structure, boat_.coefficient, step.h, step.force[0], x)
              : runge_kutta_step(boat_.structure, boat_.coefficient, step.h, step.force, x);
      if (!solved) return false;
    }
    return bounded(x);
  }

  /// The same with sensitivities to trace.columns().
  bool run(int i, double* x, StateSensitivities& dx) const {
    const Columns& columns = trace_.columns();
    detail::ForceSensitivities dforce[3];
    double dh[kMaxConstants] = {0.0};
    const auto at = static_cast<std::size_t>(i - first_);
    for (std::size_t k = begin_[at]; k < begin_[at + 1]; ++k) {
      const Step& step = steps_[k];
      unpack(k, dh, dforce);
      const bool solved =
          boat_.integrator == Integrator::kForwardEuler
              ? euler_step_sensitivities(boat_.structure, boat_.coefficient, columns, step.h,
                                         step.force[0], dforce[0], x, dx)
              : runge_kutta_step_sensitivities(boat_.structure, boat_.coefficient, columns, step.h,
                                               dh, step.force, dforce, x, dx);
      if (!solved) return false;
    }
    return bounded(x);
  }

 private:
  struct Step {
    double h;
    double force[3][kMaxForces];
  };

  void add_euler(double t0, double t1) {
    Step step{t1 - t0, {}};
    Thrust f;
    const int at = trace_.find(t0);
    if (!sensitivities_) {
      trace_.at(at, t0, f);
      forces_after(trace_.chain(), trace_.constants(), f, 0.0, step.force[0]);
      steps_.push_back(step);
      return;
    }
    const double still[kMaxConstants] = {0.0};
    ThrustSensitivities df;
    trace_.at(at, t0, nullptr, f, df);
    detail::StepForces forces;
    step_forces_sensitivities(trace_.chain(), trace_.constants(), trace_.columns(), 0.0, still, f,
                              df, forces);
    std::copy(forces.force[0], forces.force[0] + kMaxForces, step.force[0]);
    steps_.push_back(step);
    pack(still, forces.dforce);
  }

  void add(double t0, double t1) {
    LagDecay decays[kMaxActuators];
    Thrust f;
    int cursor = trace_.find(t0);
    for (double t = t0; t < t1;) {
      while (cursor + 1 < trace_.breaks() && trace_.time(cursor + 1) <= t) ++cursor;
      const bool last = cursor + 1 >= trace_.breaks() || trace_.time(cursor + 1) > t1;
      const double end = last ? t1 : trace_.time(cursor + 1);
      const int n = steps_for(end - t, boat_.longest_step);
      Step step{(end - t) / n, {}};
      trace_.at(cursor, t, f);
      lag_decays(trace_.chain(), trace_.constants(), step.h, decays);
      for (int i = 0; i < n; ++i) {
        step_forces(trace_.chain(), decays, f, step.force);
        steps_.push_back(step);
      }
      t = end;
    }
  }

  /// A break moves with its latency, a stamp does not. Where both coincide a jump's derivative is
  /// the one from the left: the break is the earlier of the two.
  void add_sensitivities(double t0, double t1) {
    if (!(t0 < t1)) return;
    const int n = trace_.columns().n_constants;
    int cursor = trace_.find(t0);
    double t = t0;
    double dbegin[kMaxConstants] = {0.0};
    for (bool more = true; more;) {
      more = cursor + 1 < trace_.breaks() && trace_.time(cursor + 1) <= t1;
      const double end = more ? trace_.time(cursor + 1) : t1;
      double dend[kMaxConstants] = {0.0};
      double dlength[kMaxConstants];
      if (more) trace_.time_sensitivities(cursor + 1, 1.0, dend);
      bool apart = false;
      for (int p = 0; p < n; ++p) {
        dlength[p] = dend[p] - dbegin[p];
        apart = apart || dlength[p] != 0.0;
      }
      // breaks at one instant may move apart: an interval without length has a derivative
      if (t < end || apart) add_steps(cursor, t, dbegin, end - t, dlength);
      t = end;
      std::copy(dend, dend + n, dbegin);
      cursor += more ? 1 : 0;
    }
  }

  void add_steps(int cursor, double t, const double* dt, double length, const double* dlength) {
    const Columns& columns = trace_.columns();
    const int n = steps_for(length, boat_.longest_step);
    double dh[kMaxConstants] = {0.0};
    detail::scaled(dlength, columns.n_constants, 1.0 / n, dh);
    Thrust f;
    trace_.at(cursor, t, dt, f, moving_);
    for (int i = 0; i < n; ++i) {
      detail::StepForces forces;
      step_forces_sensitivities(trace_.chain(), trace_.constants(), columns, length / n, dh, f,
                                moving_, forces);
      Step step{length / n, {}};
      for (int node = 0; node < 3; ++node) {
        std::copy(forces.force[node], forces.force[node] + kMaxForces, step.force[node]);
      }
      steps_.push_back(step);
      pack(dh, forces.dforce);
    }
  }

  std::size_t packed() const {
    return static_cast<std::size_t>(trace_.columns().n_constants) *
           static_cast<std::size_t>(1 + 3 * trace_.chain().n_forces);
  }

  // Rows are a few numbers long: loops are quicker than a call to move memory for each.
  void pack(const double* dh, const detail::ForceSensitivities dforce[3]) {
    const int n = trace_.columns().n_constants;
    slopes_.resize(slopes_.size() + packed());
    double* to = slopes_.data() + slopes_.size() - packed();
    for (int p = 0; p < n; ++p) *to++ = dh[p];
    for (int node = 0; node < 3; ++node) {
      for (int j = 0; j < trace_.chain().n_forces; ++j) {
        for (int p = 0; p < n; ++p) *to++ = dforce[node][j][p];
      }
    }
  }

  void unpack(std::size_t k, double* dh, detail::ForceSensitivities dforce[3]) const {
    const int n = trace_.columns().n_constants;
    const double* from = slopes_.data() + k * packed();
    for (int p = 0; p < n; ++p) dh[p] = *from++;
    for (int node = 0; node < 3; ++node) {
      for (int j = 0; j < trace_.chain().n_forces; ++j) {
        for (int p = 0; p < n; ++p) dforce[node][j][p] = *from++;
      }
    }
  }

  const Boat& boat_;
  const ThrustTrace& trace_;
  int first_;
  bool sensitivities_;
  ThrustSensitivities moving_;  // of the interval
  std::vector<std::size_t> begin_;
  std::vector<Step> steps_;
  std::vector<double> slopes_;
};

}  // namespace seatrial
