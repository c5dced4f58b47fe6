// SPDX-License-Identifier: MIT
// The order in which the filter uses the measurements of a recording. Where position and heading of
// one stamp are of two times, or other sensors measured asynchronously, each is an update of its
// own, at its time. Host side: uses heap.
#pragma once
#include <algorithm>
#include <vector>

#include "seatrial/filter/filter_types.hpp"

namespace seatrial::detail {

/// One update: parts of a pose, or a measurement at a time of its own.
struct PoseUpdate {
  int pose = 0;              // of an asynchronous measurement: the latest pose
  Parts parts = kWholePose;  // none: the filter only stops there
  bool first = true;         // of its pose
  bool keeps = true;         // the state after it is that of its pose
  int asynchronous = -1;     // which asynchronous measurement; -1: a pose
};

/// All updates, rising in time. What is not used has one, too: the filter stops at its time, so
/// that the number of updates does not depend on what is used.
class PoseUpdates {
 public:
  PoseUpdates(const PoseSeries& poses, const Effects& effects) : poses_(poses) {
    n_ = poses.n;
    time_ = poses.time;
    const double late[2] = {effects.position_delay, effects.heading_delay};
    if (late[0] == late[1] && poses.n_asynchronous == 0) {
      if (late[0] != 0.0) {
        own_time_.assign(poses.time, poses.time + poses.n);
        for (double& t : own_time_) t -= late[0];
        time_ = own_time_.data();
      }
    } else {
      list(late);
      n_ = static_cast<int>(update_.size());
      time_ = own_time_.data();
    }
    share_input_errors();
  }
  PoseUpdates(const PoseUpdates&) = delete;
  PoseUpdates& operator=(const PoseUpdates&) = delete;

  int n() const { return n_; }  // NOLINT(clang-analyzer-core.uninitialized.UndefReturn): it is set
  const double* time() const { return time_; }         // (n) [s]
  bool one_a_pose() const { return update_.empty(); }  // update k is of pose k
  /// Covariance (6) of what errors of the input change between update k and the next; null: none.
  const double* input_error(int k) const {
    return input_error_.empty() ? nullptr : &input_error_[static_cast<std::size_t>(k) * 6];
  }
  PoseUpdate operator[](int i) const {
    if (!update_.empty()) return update_[static_cast<std::size_t>(i)];
    PoseUpdate whole{i};
    whole.parts = measured(i);
    return whole;
  }

 private:
  Parts measured(int pose) const {
    if (poses_.use[pose] == kNotMeasured) return kNoPart;
    return poses_.parts == nullptr ? kWholePose : poses_.parts[pose];
  }

  /// The input's errors of each interval between two updates.
  void share_input_errors() {
    if (poses_.n_input_errors == 0) return;
    input_error_.resize(static_cast<std::size_t>(n_) * 6);
    double before[6];
    double after[6];
    int at = 0;
    input_errors_until(time_[0], at, before);
    for (int k = 0; k + 1 < n_; ++k) {
      input_errors_until(time_[k + 1], at, after);
      double* own = &input_error_[static_cast<std::size_t>(k) * 6];
      for (int i = 0; i < 6; ++i) own[i] = after[i] - before[i];
      std::copy(after, after + 6, before);
    }
  }

  /// Those up to t [s]. `at`: the last of their times before it, from where it is looked for.
  void input_errors_until(double t, int& at, double* sum) const {
    const double* time = poses_.input_error_time;
    while (at + 1 < poses_.n_input_errors && time[at + 1] <= t) ++at;
    const double* here = poses_.input_error + std::ptrdiff_t{at} * 6;
    std::copy(here, here + 6, sum);
    if (at + 1 == poses_.n_input_errors || t <= time[at]) return;
    const double share = (t - time[at]) / (time[at + 1] - time[at]);
    for (int i = 0; i < 6; ++i) sum[i] += share * (here[6 + i] - here[i]);
  }

  /// Lists the updates one by one, and sorts them by time.
  void list(const double* late) {
    struct Timed {
      double time;
      PoseUpdate update;
    };
    std::vector<Timed> all;
    all.reserve(2 * static_cast<std::size_t>(poses_.n) +
                static_cast<std::size_t>(poses_.n_asynchronous));
    for (int k = 0; k < poses_.n; ++k) {
      const double t = poses_.time[k];
      const Parts parts = measured(k);
      if (late[0] == late[1]) {
        all.push_back({t - late[0], {k, parts}});
        continue;
      }
      const bool two = parts == kWholePose;
      const auto position = static_cast<Parts>(parts & kPositionPart);
      const auto heading = static_cast<Parts>(parts & kHeadingPart);
      all.push_back({t - late[0], {k, position, !two || late[0] > late[1], false}});
      all.push_back({t - late[1], {k, heading, !two || late[0] < late[1]}});
    }
    int latest = 0;
    for (int i = 0; i < poses_.n_asynchronous; ++i) {
      const double t = poses_.asynchronous_time[i];
      while (latest + 1 < poses_.n && poses_.time[latest + 1] <= t) ++latest;
      all.push_back({t - late[1], {latest, poses_.asynchronous_parts[i], false, false, i}});
    }
    std::stable_sort(all.begin(), all.end(), [](const Timed& a, const Timed& b) {
      return a.time != b.time ? a.time < b.time : later(a.update) < later(b.update);
    });
    update_.reserve(all.size());
    own_time_.reserve(all.size());
    for (const Timed& each : all) {
      own_time_.push_back(each.time);
      update_.push_back(each.update);
    }
  }

  /// Of two updates of one time the position's is the first, and an asynchronous one the last.
  static int later(const PoseUpdate& update) {
    return update.asynchronous >= 0 ? 2 : update.keeps ? 1 : 0;
  }

  const PoseSeries& poses_;
  int n_ = 0;
  const double* time_ = nullptr;
  std::vector<double> own_time_;
  std::vector<double> input_error_;
  std::vector<PoseUpdate> update_;
};

}  // namespace seatrial::detail
