// SPDX-License-Identifier: MIT
// The on-board predictor: commands and poses in, late or out of order; motion, its covariance and
// health out at any time. No heap, no exceptions; what can't be used is refused, and said.
#pragma once
#include "seatrial/onboard/out_of_sequence.hpp"

namespace seatrial {

/// kMarks: instants that are kept within the window, one a pose and eight a second. kRows: commands
/// that are kept within window and latency.
template <int kMarks, int kRows>
class BasicPredictor {
 public:
  static constexpr double kReach = 60.0;    // [s] it looks ahead at most; after a gap so long: anew
  static constexpr double kLeap = 5.0;      // [s] a stamp so far ahead of all others is doubted
  static constexpr int kStaleRun = 10;      // so many old stamps near each other: clock set back
  static constexpr double kFarthest = 1e8;  // [m] of a pose
  static constexpr double kStrongest = 1e3;  // of a command or a scale

  explicit BasicPredictor(const OnboardModel& model) : line_(model) {}

  /// Commands to all inputs, stamped t [s].
  Taken command(double t, const double* values) {
    return offer(Kind::kCommand, t, values, model().chain.allocation.n_commands);
  }

  /// Known scale signals (propeller speed, voltage), stamped t [s].
  Taken scale(double t, const double* values) {
    return offer(Kind::kScale, t, values, model().chain.n_scales);
  }

  /// A pose x, y [m], psi [rad] of time t [s], with its covariance (3 x 3, row by row) or, null,
  /// the model's pose noise.
  Taken pose(double t, const double* eta, const double* covariance = nullptr) {
    Input in;
    in.kind = Kind::kPose;
    in.time = t;
    if (!numbers(eta, 2, kFarthest) || !std::isfinite(eta[2])) return refuse(Taken::kNotNumber);
    std::copy(eta, eta + 2, in.pose.eta);
    in.pose.eta[2] = wrap(eta[2]);
    if (!spread(covariance, in.pose.noise)) return refuse(Taken::kNotNumber);
    return take(in);
  }

  /// Motion at t [s], by all inputs up to then; ahead of them by the commands in force.
  Estimate at(double t) {
    const bool begun = line_.begun();
    Instant now;
    detail::know_nothing(model(), now.belief);
    now.time = std::isfinite(t) ? t : newest();
    if (begun) {
      const double back = std::max(now.time, line_.oldest());
      now = line_.look(std::min(back, newest() + kReach));
    }
    Estimate out = estimate(model(), now);
    const auto flag = [&out](bool raised, Health which) { out.health |= raised ? which : 0U; };
    flag(!begun || line_.silent(now.time), kCommandSilence);
    flag(now.time != t, kBeyondReach);
    flag(bad_ != kLongAgo && newest() - bad_ <= model().lately, kBadInput);
    flag(newest() - restarted_ <= model().lately, kDiverged);
    return out;
  }

  /// As at the start: no inputs, no state.
  void forget() {
    line_.forget();
    held_valid_ = false;
    stale_run_ = 0;
    bad_ = restarted_ = kLongAgo;
  }

  /// Stamp of the newest input [s]; 0 before the first.
  double newest() const { return line_.begun() ? line_.newest() : 0.0; }
  const OnboardModel& model() const { return line_.model(); }

 private:
  enum class Kind : std::uint8_t { kCommand, kScale, kPose };

  struct Input {
    Kind kind = Kind::kCommand;
    double time = 0.0;
    double values[kMaxCommands] = {};
    PoseSample pose;
  };

  static_assert(kMaxScales <= kMaxCommands, "one kind of row for both");

  static bool numbers(const double* values, int n, double most) {
    for (int i = 0; i < n; ++i) {
      if (!(std::abs(values[i]) <= most)) return false;
    }
    return true;
  }

  /// Covariance of the white error. False where the pose's own is no covariance.
  bool spread(const double* covariance, double noise[kPose][kPose]) const {
    const NoiseParameters& n = model().boat.noise;
    for (int i = 0; i < kPose; ++i) {
      for (int j = 0; j < kPose; ++j) {
        noise[i][j] = i == j ? n.white_variance(i) : 0.0;
        if (covariance == nullptr) continue;
        noise[i][j] = 0.5 * (covariance[kPose * i + j] + covariance[kPose * j + i]);
      }
    }
    double root[kPose][kPose];
    if (!numbers(&noise[0][0], kPose * kPose, kFarthest)) return false;
    if (!detail::lower_root(noise, root)) return false;
    if (covariance != nullptr) detail::leave_white(n, noise);
    return true;
  }

  Taken offer(Kind kind, double t, const double* values, int n) {
    if (!numbers(values, n, kStrongest)) return refuse(Taken::kNotNumber);
    Input in;
    in.kind = kind;
    in.time = t;
    std::copy(values, values + n, in.values);
    return take(in);
  }

  Taken refuse(Taken why) {
    bad_ = newest();
    return why;
  }

  /// When an input first has an effect [s].
  double effect(const Input& in) const {
    return in.kind == Kind::kCommand ? in.time + line_.shortest() : in.time;
  }

  /// What time it is at least, by an input's stamp [s].
  double present(const Input& in) const { return std::min(in.time, effect(in)); }

  Taken take(const Input& in) {
    if (!std::isfinite(in.time)) return refuse(Taken::kNotNumber);
    if (!line_.begun()) {
      line_.begin(present(in));
    } else if (present(in) > newest() + kLeap) {
      return leap(in);
    } else if (effect(in) < newest() - line_.window()) {
      return stale(in);
    }
    stale_run_ = 0;
    held_valid_ = false;
    return enter(in);
  }

  /// One stamp far ahead of all others is doubted; when a second one agrees both are used.
  Taken leap(const Input& in) {
    if (!held_valid_ || std::abs(present(in) - present(held_)) > kLeap) {
      held_ = in;
      held_valid_ = true;
      return refuse(Taken::kAhead);
    }
    held_valid_ = false;
    stale_run_ = 0;
    const bool in_order = present(held_) <= present(in);
    const Taken first = enter(in_order ? held_ : in);
    const Taken second = enter(in_order ? in : held_);
    return in_order ? second : first;
  }

  /// Many stamps in a row that are old, but near each other: the clock was set back.
  Taken stale(const Input& in) {
    const bool near = stale_run_ > 0 && std::abs(in.time - stale_time_) < kLeap;
    stale_run_ = near ? stale_run_ + 1 : 1;
    stale_time_ = in.time;
    if (stale_run_ < kStaleRun) return refuse(Taken::kStale);
    forget();
    line_.begin(present(in));
    restarted_ = newest();
    return enter(in);
  }

  Taken enter(const Input& in) {
    const double now = std::max(newest(), present(in));
    if (now - line_.last() > kReach) {
      line_.begin(now);
      restarted_ = now;
    }
    line_.extend(now);
    if (in.kind == Kind::kPose) {
      const Taken done = line_.put_pose(in.time, in.pose);
      return done == Taken::kUsed || done == Taken::kTwice ? done : refuse(done);
    }
    const bool kept = in.kind == Kind::kCommand ? line_.put_command(in.time, in.values)
                                                : line_.put_scale(in.time, in.values);
    return kept ? Taken::kUsed : refuse(Taken::kNoRoom);
  }

  Timeline<kMarks, kRows> line_;
  double bad_ = kLongAgo;        // [s] when an input was refused last
  double restarted_ = kLongAgo;  // [s] when stamps leapt
  double stale_time_ = 0.0;      // [s]
  int stale_run_ = 0;
  bool held_valid_ = false;
  Input held_;  // an input whose stamp leapt ahead
};

/// For commands at 100 Hz, poses at up to 200 Hz, and room to spare: 1.1 MB.
using Predictor = BasicPredictor<128, 1024>;

}  // namespace seatrial
