// SPDX-License-Identifier: MIT
// A run of the filter along a recording that grows: cost, gradient and information of all poses so
// far, whose memory does not grow. Host side: uses heap.
#pragma once
#include <algorithm>
#include <memory>
#include <vector>

#include "seatrial/filter/walk.hpp"

namespace seatrial {

/// `innovations` in parts, with the same sums to the last bit.
class GrowingRun {
 public:
  GrowingRun() = default;
  GrowingRun(const GrowingRun&) = delete;
  GrowingRun& operator=(const GrowingRun&) = delete;
  virtual ~GrowingRun() = default;

  /// Uses what was measured after `time()` and up to `until` [s]. poses: of the same clock, from
  /// `time()` or before on; trace: of the columns that the run began with. False where the boat
  /// diverged, now or before.
  virtual bool advance(const ThrustTrace& trace, const PoseSeries& poses, double until) = 0;
  virtual const double* state() const = 0;  // (9) at `time()`

  /// Sums over all poses so far: cost, gradient and information.
  FilterRun sums() const {
    FilterRun out = sums_;
    detail::mirror(out.information.data(), out.parameters);
    return out;
  }
  bool good() const { return sums_.good; }
  int parameters() const { return sums_.parameters; }
  bool slopes() const { return slopes_; }  // whether the effects are parameters
  bool begun() const { return begun_; }
  double time() const { return time_; }  // [s] of the latest update

 protected:
  FilterRun sums_;
  bool slopes_ = false;
  bool begun_ = false;
  double time_ = 0.0;
};

namespace detail {

template <int N>
class GrowingRunOf final : public GrowingRun {
 public:
  GrowingRunOf(const Boat& boat, const Columns& columns, const NoiseParameters& noise,
               double outlier, const FilterStart& start, const Effects& effects,
               double position_delay, bool slopes)
      : boat_(boat),
        columns_(columns),
        noise_(noise),
        effects_(effects),
        filter_(columns_, noise_, outlier, start, moved(effects_, position_delay), slopes) {
    sums_ = room_for(filter_.parameters(), 0, 1);
    sums_.effects = effects;
    slopes_ = slopes;
  }

  bool advance(const ThrustTrace& trace, const PoseSeries& poses, double until) override {
    const PoseUpdates updates(poses, effects_);
    std::vector<double> time(updates.time(), updates.time() + updates.n());
    const auto after = [&time](double t) {
      return static_cast<int>(std::upper_bound(time.begin(), time.end(), t) - time.begin());
    };
    const int first = begun_ ? after(time_) : 0;
    const int last = after(until);
    if (!good() || last <= first || (begun_ && first == 0)) return good();
    const double reached = time[static_cast<std::size_t>(last - 1)];
    if (begun_) time[static_cast<std::size_t>(first - 1)] = time_;
    const Keeping keeping{nullptr, nullptr, false, false, false, true};
    Walk<N> walk(filter_, poses, updates, time.data(), keeping, sums_);
    walk.run(boat_, trace, first, last);
    begun_ = true;
    time_ = reached;
    return good();
  }

  const double* state() const override { return filter_.state(); }

 private:
  static const Effects& moved(Effects& effects, double position_delay) {
    effects.position_delay += position_delay;
    return effects;
  }

  Boat boat_;
  Columns columns_;
  NoiseParameters noise_;
  Effects effects_;  // with the known delay
  LikelihoodFilter<N> filter_;
};

}  // namespace detail

/// A run that begins where the first poses do; arguments as of `innovations`. columns: of all
/// traces; position_delay: of all poses.
inline std::unique_ptr<GrowingRun> growing_run(const Boat& boat, const Columns& columns,
                                               const NoiseParameters& noise, double outlier,
                                               const FilterStart& start, const Effects& effects,
                                               double position_delay, bool slopes) {
  const auto made = [&](auto states) -> std::unique_ptr<GrowingRun> {
    return std::make_unique<detail::GrowingRunOf<states()>>(boat, columns, noise, outlier, start,
                                                            effects, position_delay, slopes);
  };
  return detail::with_states(noise.coloured(), noise.oscillating(), made);
}

}  // namespace seatrial
