// SPDX-License-Identifier: MIT
// The on-board predictor: commands and poses in, late or out of order; motion, its covariance and
// health out at any time. Every input returns what was done with it. No heap, no exceptions.
#pragma once
#include "seatrial/onboard/input_checks.hpp"
#include "seatrial/onboard/out_of_sequence.hpp"

namespace seatrial {

/// kCheckpoints: states within the window, one a pose and eight a second. kRows: commands within
/// window and latency.
template <int kCheckpoints, int kRows>
class BasicPredictor {
 public:
  explicit BasicPredictor(const OnboardModel& model) : buffer_(model) {}

  /// Commands to all inputs, stamped t [s].
  Taken command(double t, const double* values) {
    return offer(Kind::kCommand, t, values, model().chain.allocation.n_commands);
  }

  /// Known scale signals (propeller speed, voltage), stamped t [s].
  Taken scale(double t, const double* values) {
    return offer(Kind::kScale, t, values, model().chain.n_scales);
  }

  /// A pose x, y [m], psi [rad] stamped t [s], with its covariance (3 x 3, row by row) or, null,
  /// the model's pose noise. Position and heading are older than the stamp by the model's delays.
  /// lever: forward, left [m] of the measured point, where the heading is of another time or
  /// unknown. parts: kPositionPart or kHeadingPart of sensors with stamps of their own.
  Taken pose(double t, const double* eta, const double* covariance = nullptr,
             const double* lever = nullptr, Parts parts = kWholePose) {
    Input in;
    in.kind = Kind::kPose;
    in.time = t;
    in.pose.parts = parts;
    if (!all_within(eta, 2, kFarthest) || !std::isfinite(eta[2])) return refuse(Taken::kNotNumber);
    std::copy(eta, eta + 2, in.pose.eta);
    in.pose.eta[2] = wrap(eta[2]);
    if (lever != nullptr) std::copy(lever, lever + 2, in.pose.lever);
    if (!spread(covariance, in.pose.noise)) return refuse(Taken::kNotNumber);
    return take(in);
  }

  /// Motion at t [s] by all inputs up to then; after the newest one, prediction by the commands in
  /// force.
  Estimate at(double t) {
    // the state at t, or at the nearest time that is available
    const bool begun = buffer_.begun();
    PredictorState now;
    detail::reset_to_unknown(model(), now.state);
    now.time = std::isfinite(t) ? t : newest();
    if (begun) {
      const double back = std::max(now.time, buffer_.oldest());
      now = buffer_.at(std::min(back, newest() + kReach));
    }
    // the estimate, with the flags that depend on the inputs
    Estimate out = estimate(model(), now);
    const auto flag = [&out](bool raised, Health which) { out.health |= raised ? which : 0U; };
    flag(!begun || buffer_.silent(now.time), kCommandSilence);
    flag(now.time != t, kBeyondReach);
    flag(bad_ != kLongAgo && newest() - bad_ <= model().flag_for, kBadInput);
    flag(newest() - restarted_ <= model().flag_for, kDiverged);
    return out;
  }

  /// Resets to the start: no inputs, no state.
  void forget() {
    buffer_.forget();
    stamps_.in_place();
    bad_ = restarted_ = kLongAgo;
  }

  /// Stamp of the newest input [s]; 0 before the first.
  double newest() const { return buffer_.begun() ? buffer_.newest() : 0.0; }
  const OnboardModel& model() const { return buffer_.model(); }

 private:
  enum class Kind : std::uint8_t { kCommand, kScale, kPose };

  struct Input {
    Kind kind = Kind::kCommand;
    double time = 0.0;
    double values[kMaxCommands] = {};
    PoseSample pose;
  };

  static_assert(kMaxScales <= kMaxCommands, "one kind of row for both");

  /// Covariance of the white noise. False where the pose's own matrix is no covariance.
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
    if (!all_within(&noise[0][0], kPose * kPose, kFarthest)) return false;
    if (!detail::lower_root(noise, root)) return false;
    if (covariance != nullptr) detail::keep_white_part(n, noise);
    return true;
  }

  Taken offer(Kind kind, double t, const double* values, int n) {
    if (!all_within(values, n, kStrongest)) return refuse(Taken::kNotNumber);
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
    if (in.kind == Kind::kCommand) return in.time + buffer_.shortest();
    if (in.kind == Kind::kScale) return in.time;
    return in.time - std::max(model().position_delay, model().heading_delay);
  }

  /// The earliest present time that an input's stamp allows [s].
  double present(const Input& in) const {
    if (in.kind != Kind::kPose) return std::min(in.time, effect(in));
    return in.time - std::min({0.0, model().position_delay, model().heading_delay});
  }

  /// The algorithm: an input takes its place by its stamp, and all after it is computed again.
  Taken take(const Input& in) {
    // beyond, steps of the grid round to nothing: nanoseconds that were given as seconds
    if (!(std::abs(in.time) <= kLatest)) return refuse(Taken::kNotNumber);
    if (!buffer_.begun()) {
      // the first input starts the buffer
      buffer_.begin(present(in));
    } else if (present(in) > newest() + kLeap) {
      // a stamp far ahead of all others waits for a second one that agrees
      return hold(in);
    } else if (effect(in) < newest() - buffer_.window()) {
      // a stamp before the window is refused; many in a row mean that the clock was set back
      return stale(in);
    }
    stamps_.in_place();
    return enter(in);
  }

  /// An input of a plausible stamp.
  Taken enter(const Input& in) {
    // after a gap beyond the reach the buffer starts again
    const double now = std::max(newest(), present(in));
    if (now - buffer_.last() > kReach) {
      buffer_.begin(now);
      restarted_ = now;
    }
    // checkpoints up to the present; old ones are dropped
    buffer_.extend(now);
    // the input at its stamp, and all checkpoints after it again
    Taken done = Taken::kUsed;
    if (in.kind == Kind::kPose) {
      done = put_pose(in);
    } else {
      const bool kept = in.kind == Kind::kCommand ? buffer_.put_command(in.time, in.values)
                                                  : buffer_.put_scale(in.time, in.values);
      if (!kept) done = Taken::kNoRoom;
    }
    return done == Taken::kUsed || done == Taken::kTwice ? done : refuse(done);
  }

  /// A pose at its time, or its position and heading each at its own.
  Taken put_pose(const Input& in) {
    const double late[2] = {model().position_delay, model().heading_delay};
    if (late[0] == late[1] || in.pose.parts != kWholePose) {
      return buffer_.put_pose(in.time - late[has(in.pose.parts, 0) ? 0 : 1], in.pose);
    }
    PoseSample position = in.pose;
    PoseSample heading = in.pose;
    position.parts = kPositionPart;
    heading.parts = kHeadingPart;
    const Taken first = buffer_.put_pose(in.time - late[0], position);
    const Taken second = buffer_.put_pose(in.time - late[1], heading);
    return first == Taken::kUsed ? second : first;
  }

  /// A stamp far ahead of all others: used with the second one that agrees with it.
  Taken hold(const Input& in) {
    const Input before = held_;
    held_ = in;
    if (!stamps_.agrees_ahead(present(in))) return refuse(Taken::kAhead);
    stamps_.in_place();
    const bool in_order = present(before) <= present(in);
    const Taken first = enter(in_order ? before : in);
    const Taken second = enter(in_order ? in : before);
    return in_order ? second : first;
  }

  /// An old stamp. Many in a row that are near each other: the clock was set back.
  Taken stale(const Input& in) {
    if (!stamps_.agrees_behind(in.time)) return refuse(Taken::kStale);
    forget();
    buffer_.begin(present(in));
    restarted_ = newest();
    return enter(in);
  }

  OutOfSequenceBuffer<kCheckpoints, kRows> buffer_;
  double bad_ = kLongAgo;        // [s] of the last refused input
  double restarted_ = kLongAgo;  // [s] of the last restart of the buffer
  StampCheck stamps_;
  Input held_;  // the last input with a stamp far ahead
};

/// For commands at 100 Hz and poses at up to 200 Hz: 1.3 MB.
using Predictor = BasicPredictor<128, 1024>;

}  // namespace seatrial
