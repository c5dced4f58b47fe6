// SPDX-License-Identifier: MIT
// Odometry as a node publishes it: the predictor's motion in the frames of REP-105, stamped in
// nanoseconds. `odom` integrates the filtered velocity: it never jumps, and drifts. The pose in
// `map` follows the poses. No heap, no exceptions.
#pragma once
#include <new>

#include "seatrial/onboard/odom_integrator.hpp"
#include "seatrial/onboard/predictor.hpp"

namespace seatrial {

/// Published at one stamp.
struct Odometry {
  std::int64_t stamp = 0;                // [ns]
  double pose[kPose] = {};               // x, y [m], psi [rad] in odom
  double covariance[kPose][kPose] = {};  // of the same
  Estimate motion;                       // pose in map, body velocity, covariance, health
  double map_to_odom[kPose] = {};        // x, y [m], psi [rad]: pose of odom in map
  bool known = false;                    // a pose was used; before that all is zero
};

/// Sources of inputs; each is counted by outcome.
enum class Source : std::uint8_t { kCommand, kScale, kPose };
inline constexpr int kSources = 3;
inline constexpr int kOutcomes = 6;  // of Taken

/// kCheckpoints, kRows: of the predictor. kRecent: inputs that are kept for a reload.
template <int kCheckpoints, int kRows, int kRecent>
class BasicOdometer {
 public:
  static constexpr double kLongestStep = 0.05;  // [s] of the integration
  static constexpr double kAhead = 0.05;  // [s] over which the growth of a variance is evaluated
  static constexpr std::int64_t kFarStamp = 4000000000000000000;  // [ns]
  static constexpr std::int64_t kSetBack =
      5000000000;  // [ns] a stamp so much earlier is of another clock

  /// lever: forward, left [m] of the measured point from the boat's origin.
  explicit BasicOdometer(const OnboardModel& model, const double* lever = nullptr)
      : predictor_(model) {
    if (lever != nullptr) std::copy(lever, lever + 2, lever_);
  }

  /// Commands to all inputs, stamped [ns].
  Taken command(std::int64_t stamp, const double* values) {
    return take(stamp, Source::kCommand, values, nullptr);
  }

  /// Known scale signals, stamped [ns].
  Taken scale(std::int64_t stamp, const double* values) {
    return take(stamp, Source::kScale, values, nullptr);
  }

  /// x, y [m], psi [rad] of the measured point, stamped [ns]; covariance (3 x 3, row by row) or,
  /// null, the model's pose noise. parts: kPositionPart or kHeadingPart alone.
  Taken pose(std::int64_t stamp, const double* eta, const double* covariance = nullptr,
             Parts parts = kWholePose) {
    return take(stamp, Source::kPose, eta, covariance, parts);
  }

  /// Motion at any stamp [ns] within reach; `odom` is not integrated.
  Estimate look(std::int64_t stamp) { return predictor_.at(seconds(stamp)); }

  /// Odometry at a stamp [ns]. Stamps rise from call to call; `odom` is not integrated until they
  /// do.
  Odometry at(std::int64_t stamp) {
    Odometry out;
    out.stamp = stamp;
    out.motion = look(stamp);
    known_ = known_ || (out.motion.health & kNoPose) == 0U;
    if (known_ && moved_) integrate(stamp, out.motion);
    const bool rises = !moved_ || stamp > last_stamp_ || stamp < last_stamp_ - kSetBack;
    if (rises && usable(stamp)) remember(stamp, out.motion);
    out.known = known_;
    std::copy(odom_.pose(), odom_.pose() + kPose, out.pose);
    for (int i = 0; i < kPose; ++i) {
      std::copy(odom_.covariance()[i], odom_.covariance()[i] + kPose, out.covariance[i]);
    }
    double back[kPose];
    inverse(out.pose, back);
    compose(out.motion.pose, back, out.map_to_odom);
    return out;
  }

  /// Changes to another model of the same inputs; recent inputs are processed again. `odom`
  /// continues at its pose.
  void reload(const OnboardModel& model, const double* lever) {
    new (&predictor_)
        BasicPredictor<kCheckpoints, kRows>(model);  // in its place: too large for a stack
    std::copy(lever, lever + 2, lever_);
    for (int i = 0; i < recents_; ++i) give(recent_[(first_ + i) % kRecent]);
  }

  /// Forgets the inputs that a reload would process again, and their counts: for whoever gives them
  /// again, read in another way.
  void forget_inputs() {
    recents_ = 0;
    std::fill(&counts_[0][0], &counts_[0][0] + std::ptrdiff_t{kSources} * kOutcomes, 0);
  }

  /// Number of inputs of a source with this outcome.
  std::uint64_t count(Source source, Taken outcome) const {
    return counts_[static_cast<int>(source)][static_cast<int>(outcome)];
  }
  const OnboardModel& model() const { return predictor_.model(); }
  /// Stamp of the newest input that was used [ns]; 0 before the first.
  std::int64_t newest() const {
    return begun_ ? origin_ + std::llround(1e9 * predictor_.newest()) : 0;
  }

 private:
  static constexpr int kCells = kPose * kPose;

  /// An input as received.
  struct Recent {
    Source source = Source::kCommand;
    bool own_noise = false;  // with a covariance
    Parts parts = kWholePose;
    std::int64_t stamp = 0;
    double values[kMaxCommands] = {};
    double covariance[kCells] = {};
  };

  int width(Source source) const {
    if (source == Source::kPose) return kPose;
    const Chain& c = model().chain;
    return source == Source::kCommand ? c.allocation.n_commands : c.n_scales;
  }

  static bool usable(std::int64_t stamp) { return stamp >= -kFarStamp && stamp <= kFarStamp; }

  /// [s] since the first input; not a number where the stamp is not usable.
  double seconds(std::int64_t stamp) const {
    if (!usable(stamp)) return std::numeric_limits<double>::quiet_NaN();
    return 1e-9 * static_cast<double>(stamp - origin_);
  }

  Taken take(std::int64_t stamp, Source source, const double* values, const double* covariance,
             Parts parts = kWholePose) {
    if (!begun_ && usable(stamp)) {
      origin_ = stamp;
      begun_ = true;
    }
    Recent& in = next();
    in.source = source;
    in.stamp = stamp;
    std::copy(values, values + width(source), in.values);
    in.parts = parts;
    in.own_noise = covariance != nullptr;
    if (in.own_noise) std::copy(covariance, covariance + kCells, in.covariance);
    const Taken taken = give(in);
    ++counts_[static_cast<int>(source)][static_cast<int>(taken)];
    return taken;
  }

  /// A place for an input; the oldest one is dropped.
  Recent& next() {
    if (recents_ == kRecent) {
      first_ = (first_ + 1) % kRecent;
    } else {
      ++recents_;
    }
    return recent_[(first_ + recents_ - 1) % kRecent];
  }

  Taken give(const Recent& in) {
    const double t = seconds(in.stamp);
    if (in.source == Source::kCommand) return predictor_.command(t, in.values);
    if (in.source == Source::kScale) return predictor_.scale(t, in.values);
    const double* covariance = in.own_noise ? in.covariance : nullptr;
    // a heading of another time, or none: the predictor turns the lever by its own
    const bool none = lever_[0] == 0.0 && lever_[1] == 0.0;
    const bool other = model().position_delay != model().heading_delay || in.parts != kWholePose;
    if (none || other) {
      return predictor_.pose(t, in.values, covariance, none ? nullptr : lever_, in.parts);
    }
    double origin[kPose];
    double spread[kCells];
    to_origin(in.values, covariance, origin, spread);
    return predictor_.pose(t, origin, spread);
  }

  /// The pose of the boat's origin by that of the measured point: p - R l. Its covariance J C J'.
  void to_origin(const double* eta, const double* covariance, double* origin,
                 double* spread) const {
    const NoiseParameters& n = model().boat.noise;
    double arm[2];
    const double c = std::cos(eta[2]);
    const double s = std::sin(eta[2]);
    plane_to_earth(c, s, lever_, arm);
    for (int i = 0; i < 2; ++i) origin[i] = eta[i] - arm[i];
    origin[2] = eta[2];
    for (int i = 0; i < kCells; ++i) {
      const int k = i / kPose;
      const bool diagonal = i % (kPose + 1) == 0;
      const double own = diagonal ? n.white_variance(k) + n.colour_variance(k) : 0.0;
      spread[i] = covariance != nullptr ? covariance[i] : own;
    }
    const double slope[2] = {arm[1], -arm[0]};  // d origin / d psi
    for (int i = 0; i < 2; ++i) {
      for (int j = 0; j < kPose; ++j) spread[kPose * i + j] += slope[i] * spread[kPose * 2 + j];
    }
    for (int i = 0; i < kPose; ++i) {  // columns after rows
      for (int j = 0; j < 2; ++j) spread[kPose * i + j] += slope[j] * spread[kPose * i + 2];
    }
  }

  /// Integrates from the last stamp to this one, where `now` is known; over a long interval the
  /// predictor gives the motion between. A gap beyond its reach is skipped.
  void integrate(std::int64_t stamp, const Estimate& now) {
    if (stamp <= last_stamp_) return;
    const double from = seconds(last_stamp_);
    const double length = seconds(stamp) - from;
    if (!(length <= kReach)) return;
    const int n = steps_for(length, kLongestStep);
    const double h = length / n;
    double memory[kAxes];
    error_memory(stamp, now, memory);
    Estimate before = last_;
    for (int i = 1; i <= n; ++i) {
      const Estimate after = i == n ? now : predictor_.at(from + h * i);
      double nu[kAxes];
      double spread[kAxes][kAxes];
      for (int a = 0; a < kAxes; ++a) {
        nu[a] = 0.5 * (before.velocity[a] + after.velocity[a]);
        std::copy(after.covariance[3 + a] + 3, after.covariance[3 + a] + kStates, spread[a]);
      }
      odom_.advance(h, nu, spread, memory);
      before = after;
    }
  }

  /// Time constants of the velocity's errors [s]. A filter corrects what uncertainty adds: in
  /// steady state it removes the share g / P a second, P the variance and g its growth between
  /// poses. Without poses the errors have the disturbance's time constant.
  void error_memory(std::int64_t stamp, const Estimate& now, double* memory) {
    const Estimate ahead = predictor_.at(seconds(stamp) + kAhead);
    for (int a = 0; a < kAxes; ++a) {
      const double variance = now.covariance[3 + a][3 + a];
      const double growth = (ahead.covariance[3 + a][3 + a] - variance) / kAhead;
      const double most = model().boat.noise.memory;
      memory[a] = growth > 0.0 ? std::clamp(variance / growth, kAhead, most) : most;
    }
  }

  void remember(std::int64_t stamp, const Estimate& now) {
    last_stamp_ = stamp;
    last_ = now;
    moved_ = true;
  }

  BasicPredictor<kCheckpoints, kRows> predictor_;
  OdomIntegrator odom_;
  double lever_[2] = {};  // [m]
  bool begun_ = false;
  bool known_ = false;
  bool moved_ = false;           // last_ is something
  std::int64_t origin_ = 0;      // [ns]
  std::int64_t last_stamp_ = 0;  // [ns]
  Estimate last_;
  std::uint64_t counts_[kSources][kOutcomes] = {};
  int first_ = 0;
  int recents_ = 0;
  Recent recent_[kRecent];
};

/// Of the usual predictor; another model finds the last 1024 inputs, five seconds or more.
using Odometer = BasicOdometer<128, 1024, 1024>;

}  // namespace seatrial
