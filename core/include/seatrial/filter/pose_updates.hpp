// SPDX-License-Identifier: MIT
// The order in which the filter uses the poses of a recording. Where position and heading of one
// stamp are of two times, both are updates of their own, each at its time.
// Host side: uses heap.
#pragma once
#include <vector>

#include "seatrial/filter/filter_types.hpp"

namespace seatrial::detail {

/// One update: parts of a pose.
struct PoseUpdate {
  int pose = 0;
  Parts parts = kWholePose;
  bool first = true;  // of its pose
};

/// All updates, rising in time. Poses that are not measured have one: the filter stops at their
/// time.
class PoseUpdates {
 public:
  PoseUpdates(const PoseSeries& poses, const Effects& effects) {
    n_ = poses.n;
    time_ = poses.time;
    const double late[2] = {effects.position_delay, effects.heading_delay};
    if (late[0] == 0.0 && late[1] == 0.0) return;
    if (late[0] == late[1]) {
      own_time_.assign(poses.time, poses.time + poses.n);
      for (double& t : own_time_) t -= late[0];
      time_ = own_time_.data();
      return;
    }
    const double delay = late[0] - late[1];  // of positions to headings
    own_time_.reserve(2 * static_cast<std::size_t>(poses.n));
    update_.reserve(own_time_.capacity());
    int position = next_measured(poses, 0);
    for (int k = 0; k < poses.n; ++k) {
      const double heading = poses.time[k] - late[1];
      for (; position < poses.n && poses.time[position] - late[0] <= heading;
           position = next_measured(poses, position + 1)) {
        add(poses.time[position] - late[0], {position, kPositionPart, delay > 0.0});
      }
      add(heading, {k, kHeadingPart, delay < 0.0});
    }
    for (; position < poses.n; position = next_measured(poses, position + 1)) {
      add(poses.time[position] - late[0], {position, kPositionPart, false});
    }
    n_ = static_cast<int>(update_.size());
    time_ = own_time_.data();
  }
  PoseUpdates(const PoseUpdates&) = delete;
  PoseUpdates& operator=(const PoseUpdates&) = delete;

  int n() const { return n_; }  // NOLINT(clang-analyzer-core.uninitialized.UndefReturn): it is set
  const double* time() const { return time_; }  // (n) [s]
  PoseUpdate operator[](int i) const {
    return update_.empty() ? PoseUpdate{i} : update_[static_cast<std::size_t>(i)];
  }

 private:
  static int next_measured(const PoseSeries& poses, int k) {
    while (k < poses.n && poses.use[k] == kNotMeasured) ++k;
    return k;
  }

  void add(double t, const PoseUpdate& update) {
    own_time_.push_back(t);
    update_.push_back(update);
  }

  int n_ = 0;
  const double* time_ = nullptr;
  std::vector<double> own_time_;
  std::vector<PoseUpdate> update_;
};

}  // namespace seatrial::detail
