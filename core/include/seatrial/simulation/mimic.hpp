// SPDX-License-Identifier: MIT
// Another robot moves as the boat would (El-MallARD): commands to a virtual boat in, a velocity for
// a holonomic carrier out, and the carrier's poses back in. No heap, no exceptions.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>

#include "seatrial/onboard/input_checks.hpp"
#include "seatrial/simulation/plant.hpp"

namespace seatrial {

/// What the carrier can do, and how it is led. Velocities of its body: forward, left, yaw.
struct Carrier {
  double speed = 0.8;             // [m/s] most, in any direction
  double yaw_rate = 2.0;          // [rad/s]
  double acceleration = 1.5;      // [m/s^2]
  double yaw_acceleration = 6.0;  // [rad/s^2]
  double lag = 0.1;               // [s] delay and time constant together, made up for ahead
  double gain = 2.0;              // [1/s] on the error to the virtual boat's pose
  double pose_timeout = 1.0;      // [s] age of its pose from which it runs open-loop
  double lost = 0.5;              // [m] from the virtual boat it is stopped
};

/// What a carrier is refused for: the first of its numbers that can't be.
struct CarrierFault {
  const char* name = nullptr;  // null: none
  double got = 0.0;
  const char* expected = "";
  const char* advice = "";
};

inline CarrierFault fault(const Carrier& c) {
  const auto above = [](double v) { return v > 0.0; };
  const auto within = [](double v, double most) { return v >= 0.0 && v <= most; };
  if (!above(c.speed)) {
    return {"speed", c.speed, "more than 0 m/s", "give the carrier's highest"};
  }
  if (!above(c.yaw_rate)) {
    return {"yaw_rate", c.yaw_rate, "more than 0 rad/s", "give the carrier's highest"};
  }
  if (!above(c.acceleration)) {
    return {"acceleration", c.acceleration, "more than 0 m/s^2", "give the carrier's highest"};
  }
  if (!above(c.yaw_acceleration)) {
    return {"yaw_acceleration", c.yaw_acceleration, "more than 0 rad/s^2",
            "give the carrier's highest"};
  }
  if (!within(c.lag, 1.0)) {
    return {"lag", c.lag, "0 to 1 s", "measure its delay and time constant, in seconds"};
  }
  if (!within(c.gain, 20.0)) {
    return {"gain", c.gain, "0 to 20 1/s", "a third of one over its delay is as much as it bears"};
  }
  if (!above(c.pose_timeout)) {
    return {"pose_timeout", c.pose_timeout, "more than 0 s", "give some periods of its poses"};
  }
  if (!above(c.lost)) {
    return {"lost", c.lost, "more than 0 m", "give how far from the virtual boat it may be"};
  }
  return {};
}

/// Health flags of a mimic's output; 0: use it.
enum MimicHealth : std::uint32_t {
  kMimicNoPose = 1,               // none yet, or too old: open-loop
  kMimicSpeedLimited = 2,         // the boat exceeds the carrier's speed limit
  kMimicAccelerationLimited = 4,  // the boat gets faster than the carrier can
  kMimicLost = 8,                 // too far from the virtual boat: stopped
  kMimicCommandSilence = 16,      // the boat's thrusters are off until the next command
  kMimicDiverged = 32             // the model is unstable: stopped
};

/// Advice on each flag, to the user.
struct MimicWords {
  MimicHealth flag;
  const char* advice;
};

inline constexpr MimicWords kMimicWords[] = {
    {kMimicNoPose, "no pose of the carrier: its drift is not corrected; check its odometry"},
    {kMimicSpeedLimited,
     "the boat exceeds the carrier's speed limit: it lags behind. Drive slower, or raise the "
     "limit"},
    {kMimicAccelerationLimited,
     "the boat exceeds the carrier's acceleration limit: it lags behind for a while"},
    {kMimicLost,
     "the carrier is too far from the virtual boat and is stopped: put it in place and restart"},
    {kMimicCommandSilence, "no valid command: the virtual boat's thrust is zero"},
    {kMimicDiverged, "the model diverges: the carrier is stopped; identify it again"}};

struct MimicOutput {
  double time = 0.0;               // [s]
  double velocity[3] = {0, 0, 0};  // for the carrier: forward, left [m/s], yaw [rad/s]
  double asked[3] = {0, 0, 0};     // the same before the carrier's limits
  double boat[kStates] = {};       // the virtual boat: x, y, psi, u, v, r
  double mismatch[3] = {0, 0, 0};  // boat minus carrier at its last pose, in the carrier's frame
  std::uint32_t health = kMimicNoPose;
};

class Mimic {
 public:
  /// `timeout` [s] without a command after which the virtual boat's thrusters are off; infinite:
  /// a command holds.
  Mimic(const Plant& boat, const Carrier& carrier, double timeout)
      : plant_(boat), carrier_(carrier) {
    plant_.set_timeout(timeout);
  }

  /// A command (inputs) stamped t [s]; it acts then, or at once where that has passed. False, and
  /// not used: a number is none or absurdly large; t is before a command that has acted, or leaps
  /// ahead, and the stamps before do not agree that the clock was set; too many are under way.
  bool command(double t, const double* values, int n) {
    if (!all_within(values, n, kStrongest) || !accept(commands_, t)) return false;
    // by a clock that is set beyond the reach: at once
    const double now = plant_.time();
    return plant_.command(t > now + kReach ? now : std::max(t, now), values);
  }

  /// The carrier's own pose (3), stamped t [s]. The first places the virtual boat. False, and not
  /// used: a number is none or absurdly large; t is before the last pose, or leaps ahead, as of a
  /// command; the virtual boat's pose at t is not remembered, or beyond the reach.
  bool pose(double t, const double* eta) {
    const bool sound = all_within(eta, 2, kFarthest) && std::isfinite(eta[2]);
    if (!sound || !accept(poses_, t)) return false;
    double there[3];
    if (!placed_) place(t, eta);
    if (!boat_at(t, there)) return false;
    const double off[3] = {there[0] - eta[0], there[1] - eta[1], 0.0};
    earth_to_body(eta[2], off, mismatch_);
    mismatch_[2] = wrap(there[2] - eta[2]);
    last_pose_ = t;
    return true;
  }

  /// What the carrier is to do from t [s] on. t rises from call to call; where it falls, or leaps
  /// by more than the reach, the clock was set: the virtual boat goes on from where it is, after a
  /// leap with its thrusters off.
  MimicOutput at(double t) {
    if (!(std::abs(t) <= kLatest)) t = time_;
    begin(t);
    if (t < time_ || t > time_ + kReach) set_clock(t);
    const double dt = t - time_;
    const bool moved = plant_.advance_to(std::max(t, plant_.time()));
    remember();
    MimicOutput out;
    out.time = t;
    std::copy(plant_.state(), plant_.state() + kStates, out.boat);
    std::copy(mismatch_, mismatch_ + 3, out.mismatch);
    const bool seen = placed_ && std::abs(t - last_pose_) <= carrier_.pose_timeout;
    const bool lost = seen && std::hypot(mismatch_[0], mismatch_[1]) > carrier_.lost;
    out.health = (seen ? 0U : kMimicNoPose) | (lost ? kMimicLost : 0U) |
                 (plant_.silent() ? kMimicCommandSilence : 0U) | (moved ? 0U : kMimicDiverged);
    double wanted[3] = {0.0, 0.0, 0.0};
    if (moved && !lost) lead(seen, wanted);
    std::copy(wanted, wanted + 3, out.asked);
    limit(wanted, dt, out.health);
    std::copy(wanted, wanted + 3, out.velocity);
    std::copy(wanted, wanted + 3, given_);
    time_ = t;
    newest_ = std::max(newest_, t);
    return out;
  }

  /// The newest stamp of all inputs and answers [s]; it falls where the clock was set back.
  double newest() const { return newest_; }

 private:
  static constexpr int kRemembered = 512;  // poses of the virtual boat

  struct Moment {
    double time = 0.0;
    double eta[3] = {};
  };

  /// Stamps of the inputs of one kind.
  struct Stamps {
    StampCheck check;
    double newest = -std::numeric_limits<double>::infinity();  // [s]
  };

  /// Whether an input stamped t [s] is in its place, or others agree that the clock was set. One
  /// before the newest is, while that has not acted.
  bool accept(Stamps& of, double t) {
    if (!(std::abs(t) <= kLatest)) return false;
    begin(t);
    const bool ahead = t > std::max(of.newest, time_) + kLeap;
    if (ahead && !of.check.agrees_ahead(t)) return false;
    const bool late = t < of.newest;
    const bool set_back = late && of.check.agrees_behind(t);
    if (late && !set_back) return t >= time_;
    of.check.in_place();
    of.newest = t;
    newest_ = set_back ? t : std::max(newest_, t);
    return true;
  }

  /// The virtual boat's clock starts with the first input.
  void begin(double t) {
    if (begun_) return;
    begun_ = true;
    time_ = newest_ = t;
    const double still[kMaxCommands] = {0.0};
    plant_.reset(t, still);
    remember();
  }

  /// The clock was set to t [s]. A command in force goes on; after a leap ahead nobody knows how
  /// old it is.
  void set_clock(double t) {
    plant_.shift_clock(t - time_);
    if (t > time_) plant_.drop_commands();
    time_ = newest_ = t;
    last_pose_ = -std::numeric_limits<double>::infinity();
    commands_ = poses_ = Stamps();
    n_moments_ = 0;
    remember();
  }

  /// The virtual boat is where the carrier is at t, and has gone on from there since.
  void place(double t, const double* eta) {
    double there[3];
    if (!boat_at(t, there)) return;
    placed_ = true;
    for (int i = 0; i < n_moments_; ++i) shift(there, eta, moment(i).eta);
    shift(there, eta, plant_.state());
  }

  /// A pose (3) by the motion that takes `from` to `to`.
  static void shift(const double* from, const double* to, double* pose) {
    const double way[3] = {pose[0] - from[0], pose[1] - from[1], pose[2] - from[2]};
    double turned[3];
    body_to_earth(to[2] - from[2], way, turned);
    for (int i = 0; i < 3; ++i) pose[i] = to[i] + turned[i];
  }

  Moment& moment(int i) { return moments_[(first_ + i) % kRemembered]; }

  void remember() {
    if (n_moments_ > 0 && moment(n_moments_ - 1).time >= plant_.time()) return;
    if (n_moments_ == kRemembered) {
      first_ = (first_ + 1) % kRemembered;
      --n_moments_;
    }
    Moment& m = moment(n_moments_++);
    m.time = plant_.time();
    std::copy(plant_.state(), plant_.state() + 3, m.eta);
  }

  /// Where the virtual boat was; ahead of the last step it moves on as then.
  bool boat_at(double t, double* eta) {
    if (n_moments_ == 0 || t < moment(0).time) return false;
    const Moment& last = moment(n_moments_ - 1);
    if (t > last.time + kReach) return false;
    if (t >= last.time) {
      double rate[3];
      body_to_earth(last.eta[2], plant_.state() + 3, rate);
      for (int i = 0; i < 3; ++i) eta[i] = last.eta[i] + (t - last.time) * rate[i];
      return true;
    }
    int above = n_moments_ - 1;
    while (moment(above - 1).time > t) --above;
    const Moment& a = moment(above - 1);
    const Moment& b = moment(above);
    const double share = (t - a.time) / (b.time - a.time);
    for (int i = 0; i < 3; ++i) eta[i] = a.eta[i] + share * (b.eta[i] - a.eta[i]);
    return true;
  }

  /// The boat's velocity, ahead by the carrier's lag, in the carrier's frame, and the correction.
  void lead(bool seen, double* wanted) const {
    const double* x = plant_.state();
    double rate[kStates];
    const bool solved = plant_.rate(rate);
    double ahead[3];
    for (int i = 0; i < 3; ++i) ahead[i] = x[3 + i] + (solved ? carrier_.lag * rate[3 + i] : 0.0);
    body_to_earth(seen ? mismatch_[2] : 0.0, ahead, wanted);
    if (!seen) return;
    for (int i = 0; i < 3; ++i) wanted[i] += carrier_.gain * mismatch_[i];
  }

  /// Keeps the direction; speed first, then what can be reached since the last call, dt [s] ago.
  void limit(double* wanted, double dt, std::uint32_t& health) const {
    const double fast = std::max(std::hypot(wanted[0], wanted[1]) / carrier_.speed,
                                 std::abs(wanted[2]) / carrier_.yaw_rate);
    if (fast > 1.0) {
      for (int i = 0; i < 3; ++i) wanted[i] /= fast;
      health |= kMimicSpeedLimited;
    }
    double change[3];
    for (int i = 0; i < 3; ++i) change[i] = wanted[i] - given_[i];
    const double push = std::hypot(change[0], change[1]);
    const double turn = std::abs(change[2]);
    const double most = carrier_.acceleration * dt;
    const double most_turn = carrier_.yaw_acceleration * dt;
    if (push > most) {
      for (int i = 0; i < 2; ++i) wanted[i] = given_[i] + change[i] * most / push;
    }
    if (turn > most_turn) wanted[2] = given_[2] + change[2] * most_turn / turn;
    if (push > most || turn > most_turn) health |= kMimicAccelerationLimited;
  }

  Plant plant_;
  Carrier carrier_;
  bool begun_ = false;
  bool placed_ = false;
  double time_ = 0.0;    // [s] of the last answer
  double newest_ = 0.0;  // [s]
  Stamps commands_;
  Stamps poses_;
  double last_pose_ = -std::numeric_limits<double>::infinity();
  double mismatch_[3] = {0, 0, 0};
  double given_[3] = {0, 0, 0};
  int first_ = 0;
  int n_moments_ = 0;
  Moment moments_[kRemembered];
};

}  // namespace seatrial
