// SPDX-License-Identifier: MIT
// Thrust along a whole recording. It depends on commands and constants only, not on the boat, so it
// is computed once and shared by all roll-outs. Host side: uses heap.
#pragma once
#include <algorithm>
#include <limits>
#include <vector>

#include "seatrial/integration/sensitivities.hpp"

namespace seatrial {

/// A piecewise-constant signal: row i holds from time[i] until time[i + 1].
struct Held {
  int n = 0;
  int width = 0;
  const double* time = nullptr;   // [s], rising
  const double* value = nullptr;  // n rows of width entries
  const double* row(int i) const { return value + static_cast<std::ptrdiff_t>(i) * width; }
};

/// Thrust between breaks. A break is where a (delayed) command or a scale signal changes, or an
/// actuator reaches the end of its rate limit.
class ThrustTrace {
 public:
  /// The first row of each signal is taken to have held for ever before.
  ThrustTrace(const Chain& chain, const double* q, const Held& commands, const Held& scales,
              const Columns& columns)
      : chain_(chain), columns_(columns) {
    std::copy(q, q + chain.n_constants, q_);
    if (scales.n > 0) {
      std::copy(scales.row(0), scales.row(0) + chain_.n_scales, scale_);
    } else {
      std::copy(chain.scale_reference, chain.scale_reference + kMaxScales, scale_);
    }
    collect(commands, scales);
    sweep(commands, scales);
  }

  int breaks() const { return static_cast<int>(time_.size()); }
  double time(int i) const { return time_[static_cast<std::size_t>(i)]; }
  const Chain& chain() const { return chain_; }
  const double* constants() const { return q_; }
  const Columns& columns() const { return columns_; }

  /// The last break at or before t; 0 also where t is before all breaks. `near`: where to look
  /// first.
  int find(double t, int near = 0) const {
    if (time(near) <= t && (near + 1 == breaks() || t < time(near + 1))) return near;
    if (near + 2 < breaks() && time(near + 1) <= t && t < time(near + 2)) return near + 1;
    const auto above = std::upper_bound(time_.begin(), time_.end(), t);
    return std::max(0, static_cast<int>(above - time_.begin()) - 1);
  }

  /// Derivative of a break's time to the chosen constants: 1 for its own latency.
  void time_sensitivities(int i, double sign, double* dtime) const {
    const double* row = moved_.data() + static_cast<std::ptrdiff_t>(i) * columns_.n_constants;
    for (int p = 0; p < columns_.n_constants; ++p) dtime[p] += sign * row[p];
  }

  /// Thrust at t [s], in the interval that follows break i.
  void at(int i, double t, Thrust& f) const {
    load(i, f);
    const double length = std::isfinite(time(i)) ? t - time(i) : 0.0;
    double remains = 0.0;
    for (int k = 0; k < chain_.n_actuators(); ++k) {
      const bool same = k > 0 && chain_.actuators[k].lag == chain_.actuators[k - 1].lag;
      if (!same) remains = decay(chain_, q_, k, length);
      f.level[k] = chain_.actuators[k].slew_rate >= 0
                       ? level_after(chain_, q_, f, k, length)
                       : f.target[k] + (f.level[k] - f.target[k]) * remains;
    }
  }

  /// The same with derivatives; t itself is fixed, or moves with the constants by dt.
  void at(int i, double t, const double* dt, Thrust& f, ThrustSensitivities& df) const {
    load(i, f);
    load_sensitivities(i, df);
    const bool finite = std::isfinite(time(i));
    const double length = finite ? t - time(i) : 0.0;
    double dlength[kMaxConstants] = {0.0};
    if (finite) {
      for (int p = 0; p < columns_.n_constants; ++p) dlength[p] = dt == nullptr ? 0.0 : dt[p];
      time_sensitivities(i, -1.0, dlength);
    }
    settle(length, dlength, f, df);
  }

 private:
  struct Change {
    double time;
    int latency;  // index of the constant that moves it; -1: none
    int row;      // of the commands; of the scales where `scale`
    bool scale;
  };

  static bool differs(const Held& signal, int i) {
    return !std::equal(signal.row(i), signal.row(i) + signal.width, signal.row(i - 1));
  }

  void collect(const Held& commands, const Held& scales) {
    std::vector<int> latencies;
    for (int k = 0; k < chain_.n_actuators(); ++k) {
      const int own = chain_.actuators[k].latency;
      if (std::find(latencies.begin(), latencies.end(), own) == latencies.end()) {
        latencies.push_back(own);
      }
    }
    for (int i = 1; i < commands.n; ++i) {
      if (!differs(commands, i)) continue;
      for (const int own : latencies) {
        const double delay = own >= 0 ? q_[own] : 0.0;
        changes_.push_back({commands.time[i] + delay, own, i, false});
      }
    }
    for (int i = 1; i < scales.n; ++i) {
      if (differs(scales, i)) changes_.push_back({scales.time[i], -1, i, true});
    }
    std::stable_sort(changes_.begin(), changes_.end(),
                     [](const Change& a, const Change& b) { return a.time < b.time; });
  }

  void sweep(const Held& commands, const Held& scales) {
    Thrust f;
    ThrustSensitivities df;
    double thruster[kMaxActuators];
    allocate(chain_.allocation, commands.row(0), thruster);
    for (int k = 0; k < chain_.n_actuators(); ++k) aim(thruster, k, f, df);
    rescale(f, df);
    std::copy(f.target, f.target + kMaxActuators, f.level);
    df = start(df);
    const double still[kMaxConstants] = {0.0};
    reserve(changes_.size() + 1);
    store(-std::numeric_limits<double>::infinity(), still, f, df);
    for (const Change& change : changes_) {
      arrive(change.time, f, df);
      const int before = breaks() - 1;
      double dt[kMaxConstants] = {0.0};
      for (int p = 0; p < columns_.n_constants; ++p) {
        if (change.latency >= 0 && columns_.constant[p] == change.latency) dt[p] = 1.0;
      }
      at(before, change.time, dt, f, df);
      if (change.scale) {
        std::copy(scales.row(change.row), scales.row(change.row) + chain_.n_scales, scale_);
        rescale(f, df);
      } else {
        allocate(chain_.allocation, commands.row(change.row), thruster);
        for (int k = 0; k < chain_.n_actuators(); ++k) {
          if (chain_.actuators[k].latency == change.latency) aim(thruster, k, f, df);
        }
      }
      store(change.time, dt, f, df);
    }
    arrive(std::numeric_limits<double>::infinity(), f, df);
    changes_.clear();
    changes_.shrink_to_fit();
  }

  /// Breaks after the last one and before `end` [s] where actuators reach the end of their rate
  /// limit. f, df: thrust at the last break.
  void arrive(double end, Thrust& f, ThrustSensitivities& df) {
    while (true) {
      int first = 0;
      for (int k = 1; k < chain_.n_actuators(); ++k) {
        if (time_limited(chain_, q_, f, k) < time_limited(chain_, q_, f, first)) first = k;
      }
      const int before = breaks() - 1;
      const double t = time(before) + time_limited(chain_, q_, f, first);
      if (!std::isfinite(t) || !(t < end)) return;
      double dt[kMaxConstants] = {0.0};
      time_sensitivities(before, 1.0, dt);
      arrival_sensitivities(first, f, df, dt);
      at(before, t, dt, f, df);
      store(t, dt, f, df);
    }
  }

  /// dt += derivatives of `time_limited`: (|away| - rate lag) / rate.
  void arrival_sensitivities(int k, const Thrust& f, const ThrustSensitivities& df,
                             double* dt) const {
    const Actuator& a = chain_.actuators[k];
    const double away = f.level[k] - f.target[k];
    const double rate = rate_limit(chain_, q_, k);
    const bool lags = detail::constant(q_, a.lag, 0.0) > kShortestLag;
    for (int p = 0; p < columns_.n_constants; ++p) {
      dt[p] += std::copysign(1.0, away) * (df.level[k][p] - df.target[k][p]) / rate;
      if (columns_.constant[p] == a.slew_rate)
        dt[p] -= slew_unit(a) * std::abs(away) / (rate * rate);
      if (lags && columns_.constant[p] == a.lag) dt[p] -= 1.0;
    }
  }

  static ThrustSensitivities start(const ThrustSensitivities& df) {
    ThrustSensitivities out = df;
    std::copy(&df.target[0][0], &df.target[0][0] + std::ptrdiff_t{kMaxActuators} * kMaxConstants,
              &out.level[0][0]);
    return out;
  }

  void choose(const double* slope, double* chosen) const {
    for (int p = 0; p < columns_.n_constants; ++p) chosen[p] = slope[columns_.constant[p]];
  }

  /// Target of actuator k for new commands of the thrusters.
  void aim(const double* thruster, int k, Thrust& f, ThrustSensitivities& df) const {
    double slope[kMaxConstants] = {0.0};
    f.target[k] = curve(chain_, q_, k, thruster, slope);
    choose(slope, df.target[k]);
  }

  void rescale(Thrust& f, ThrustSensitivities& df) const {
    for (int k = 0; k < chain_.n_actuators(); ++k) {
      double slope[kMaxConstants] = {0.0};
      f.multiplier[k] = multiplier(chain_, q_, k, scale_, slope);
      choose(slope, df.multiplier[k]);
    }
  }

  /// Levels (and their derivatives) after `length` in the interval that f, df begin.
  void settle(double length, const double* dlength, Thrust& f, ThrustSensitivities& df) const {
    double remains = 1.0;
    double dremains[kMaxConstants];
    int last = -1;  // whose lag they are of
    for (int k = 0; k < chain_.n_actuators(); ++k) {
      if (rate_limit(chain_, q_, k) > 0.0) {
        f.level[k] = detail::limited_sensitivities(chain_, q_, columns_, f, df, k, length, dlength,
                                                   df.level[k]);
        continue;
      }
      if (last < 0 || chain_.actuators[k].lag != chain_.actuators[last].lag) {
        last = k;
        remains = detail::decay_sensitivities(chain_, q_, columns_, k, length, dlength, dremains);
      }
      f.level[k] = detail::level_sensitivities(columns_, f, df, k, remains, dremains, df.level[k]);
    }
  }

  /// Room for so many breaks; those at the end of a rate limit come on top.
  void reserve(std::size_t breaks) {
    const auto constants = static_cast<std::size_t>(columns_.n_constants);
    const auto values = 3 * static_cast<std::size_t>(chain_.n_actuators());
    time_.reserve(breaks);
    moved_.reserve(breaks * constants);
    value_.reserve(breaks * values);
    sensitivities_.reserve(breaks * values * constants);
  }

  /// dt: derivative of the break's time to the chosen constants. Rows are a few numbers long: loops
  /// are quicker than a call to move memory for each.
  void store(double t, const double* dt, const Thrust& f, const ThrustSensitivities& df) {
    const int n = columns_.n_constants;
    time_.push_back(t);
    moved_.insert(moved_.end(), dt, dt + n);
    const std::size_t before = sensitivities_.size();
    const auto rows = 3 * static_cast<std::size_t>(chain_.n_actuators());
    sensitivities_.resize(before + rows * static_cast<std::size_t>(n));
    double* to = sensitivities_.data() + before;
    for (int k = 0; k < chain_.n_actuators(); ++k) {
      value_.insert(value_.end(), {f.level[k], f.target[k], f.multiplier[k]});
      for (const auto* block : {&df.level, &df.target, &df.multiplier}) {
        for (int p = 0; p < n; ++p) *to++ = (*block)[k][p];
      }
    }
  }

  void load(int i, Thrust& f) const {
    const int n = chain_.n_actuators();
    const double* from = value_.data() + static_cast<std::ptrdiff_t>(i) * 3 * n;
    for (int k = 0; k < n; ++k, from += 3) {
      f.level[k] = from[0];
      f.target[k] = from[1];
      f.multiplier[k] = from[2];
    }
  }

  void load_sensitivities(int i, ThrustSensitivities& df) const {
    const int n = chain_.n_actuators();
    const int w = columns_.n_constants;
    const double* from = sensitivities_.data() + static_cast<std::ptrdiff_t>(i) * 3 * n * w;
    for (int k = 0; k < n; ++k) {
      for (auto* block : {&df.level, &df.target, &df.multiplier}) {
        for (int p = 0; p < w; ++p) (*block)[k][p] = *from++;
      }
    }
  }

  Chain chain_;
  Columns columns_;
  double q_[kMaxConstants] = {};
  double scale_[kMaxScales] = {};
  std::vector<Change> changes_;
  std::vector<double> time_;
  std::vector<double> moved_;  // derivatives of the breaks' times
  std::vector<double> value_;
  std::vector<double> sensitivities_;
};

}  // namespace seatrial
