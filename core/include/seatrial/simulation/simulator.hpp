// SPDX-License-Identifier: MIT
// Boats in a pool, driven live: plants, walls, current and sensors on one clock. Host only.
#pragma once
#include <algorithm>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "seatrial/simulation/contact.hpp"
#include "seatrial/simulation/lidar.hpp"
#include "seatrial/simulation/plant.hpp"
#include "seatrial/simulation/sensors.hpp"

namespace seatrial {

inline constexpr double kContactStep = 0.005;  // [s] at least so often contacts are looked for
inline constexpr double kHullRadius = 0.3;     // [m] of a boat that says none

/// A boat's sensors; none where there is no value.
struct Sensors {
  std::optional<PoseSensor> pose;
  std::optional<Imu> imu;
  std::optional<Lidar> lidar;
};

enum class ReadingKind : std::uint8_t { kPose, kImu, kScan };

/// True poses of the last two seconds, for sensors that are late.
class PastPoses {
 public:
  static constexpr double kLength = 2.0;  // [s]

  void add(double t, const double* eta) {
    past_.push_back({t, {eta[0], eta[1], eta[2]}});
    while (past_.size() > 1 && past_[1].time <= t - kLength) past_.pop_front();
  }

  /// The pose at t [s], between the two around it; before the first, the first.
  void at(double t, double* eta) const {
    std::size_t i = past_.size() - 1;
    while (i > 0 && past_[i].time > t) --i;
    const Past& before = past_[i];
    const Past& after = past_[std::min(i + 1, past_.size() - 1)];
    const double length = after.time - before.time;
    const double share = length > 0.0 ? std::clamp((t - before.time) / length, 0.0, 1.0) : 0.0;
    for (int k = 0; k < 3; ++k) eta[k] = before.eta[k] + share * (after.eta[k] - before.eta[k]);
  }

 private:
  struct Past {
    double time;
    double eta[3];
  };

  std::deque<Past> past_;
};

/// What a sensor said.
struct Reading {
  ReadingKind kind = ReadingKind::kPose;
  int boat = 0;
  double stamp = 0.0;    // [s] of the pose, of the end of an IMU's period, of a scan's first beam
  double arrival = 0.0;  // [s] when it is there to be read
  std::vector<double> values;  // x, y, psi; yaw rate, a_x, a_y; or ranges
};

class Simulator {
 public:
  /// current (2) [m/s] of the water, earth-fixed. The same seed gives the same readings.
  Simulator(Scene scene, const double* current, std::uint64_t seed)
      : scene_(std::move(scene)), seed_(seed) {
    std::copy(current, current + 2, current_);
  }

  Simulator(const Simulator&) = delete;  // it owns its plants
  Simulator& operator=(const Simulator&) = delete;
  Simulator(Simulator&&) = default;
  Simulator& operator=(Simulator&&) = default;
  ~Simulator() = default;

  /// One more boat, at rest in the water at the pose start (3), before the first step. Its number;
  /// -1 where time has begun, or the hull would be in something.
  int add(std::unique_ptr<Plant> plant, const double* start, double radius,
          const Sensors& sensors) {
    if (time_ > 0.0 || !room(start, radius)) return -1;
    plant->set_current(current_[0], current_[1]);
    std::copy(start, start + 3, plant->state());
    boats_.emplace_back(std::move(plant), radius, sensors, seed_,
                        static_cast<std::uint32_t>(boats_.size()));
    boats_.back().begin();
    return static_cast<int>(boats_.size()) - 1;
  }

  /// A command (inputs) to a boat, now. False where too many are under way.
  bool command(int boat, const double* values) { return at(boat).plant->command(time_, values); }

  /// On to t [s]; what the sensors say meanwhile waits for take(). False where a boat diverged.
  bool advance_to(double t) {
    if (!std::isfinite(t)) return false;
    for (BoatIn& b : boats_) b.touched = false;
    while (time_ < t) {
      const double next =
          std::min({t, static_cast<double>(ticks_ + 1) * kContactStep, next_reading()});
      for (BoatIn& b : boats_) {
        if (!b.plant->advance_to(next)) return false;
      }
      time_ = next;
      if (time_ >= static_cast<double>(ticks_ + 1) * kContactStep) ++ticks_;
      touch_all();
      for (BoatIn& b : boats_) {
        if (b.late()) b.past.add(time_, b.plant->state());
        read(b);
      }
    }
    return true;
  }

  /// Readings that have arrived by now, by arrival.
  std::vector<Reading> take() {
    const auto arrived = [this](const Reading& r) { return r.arrival <= time_; };
    const auto split = std::stable_partition(waiting_.begin(), waiting_.end(), arrived);
    std::vector<Reading> found(std::make_move_iterator(waiting_.begin()),
                               std::make_move_iterator(split));
    waiting_.erase(waiting_.begin(), split);
    std::stable_sort(found.begin(), found.end(),
                     [](const Reading& a, const Reading& b) { return a.arrival < b.arrival; });
    return found;
  }

  double time() const { return time_; }
  int n_boats() const { return static_cast<int>(boats_.size()); }

  /// x, y [m], psi [rad] (unwrapped), u, v [m/s], r [rad/s]: over ground, the truth.
  void state(int boat, double* x) const { boats_[static_cast<std::size_t>(boat)].over_ground(x); }

  /// Generalised forces F of a boat now.
  void forces(int boat, double* force) const {
    boats_[static_cast<std::size_t>(boat)].plant->forces(force);
  }

  /// Whether a boat touched something during the last advance_to().
  bool touched(int boat) const { return boats_[static_cast<std::size_t>(boat)].touched; }

 private:
  struct BoatIn {
    std::unique_ptr<Plant> plant;
    double radius;
    Sensors sensors;
    int number;
    std::optional<PoseReader> pose;
    std::optional<ImuReader> imu;
    PastPoses past;
    Random beams;
    long poses = 1;  // number of the next reading of each sensor
    long imus = 1;
    long scans = 1;
    bool touched = false;

    BoatIn(std::unique_ptr<Plant> own, double hull, const Sensors& s, std::uint64_t seed,
           std::uint32_t boat)
        : plant(std::move(own)),
          radius(hull),
          sensors(s),
          number(static_cast<int>(boat)),
          beams(seed, boat, 2) {
      if (s.pose) pose.emplace(*s.pose, Random(seed, boat, 0));
      if (s.imu) imu.emplace(*s.imu, Random(seed, boat, 1));
    }

    bool late() const {
      return sensors.pose &&
             (sensors.pose->position_delay != 0.0 || sensors.pose->heading_delay != 0.0);
    }

    /// The inertial unit starts from the boat as it lies there.
    void begin() {
      past.add(0.0, plant->state());
      if (!imu) return;
      const Hull hull = as_hull();
      imu->begin(plant->state()[2], hull.velocity);
    }

    Hull as_hull() const {
      const double* x = plant->state();
      double rate[3];
      body_to_earth(x[2], x + 3, rate);
      const double* c = plant->current();
      return {{x[0], x[1]}, {rate[0] + c[0], rate[1] + c[1]}, radius};
    }

    // it moves the plant, which is its own
    // NOLINTNEXTLINE(readability-make-member-function-const)
    void take(const Hull& hull) {
      double* x = plant->state();
      const double* c = plant->current();
      const double rate[3] = {hull.velocity[0] - c[0], hull.velocity[1] - c[1], x[5]};
      std::copy(hull.place, hull.place + 2, x);
      earth_to_body(x[2], rate, x + 3);
    }

    void over_ground(double* out) const {
      const double* x = plant->state();
      const Hull hull = as_hull();
      const double rate[3] = {hull.velocity[0], hull.velocity[1], x[5]};
      std::copy(x, x + 3, out);
      earth_to_body(x[2], rate, out + 3);
    }
  };

  BoatIn& at(int boat) { return boats_[static_cast<std::size_t>(boat)]; }

  bool room(const double* place, double radius) const {
    if (distance(scene_, place) < radius) return false;
    return std::all_of(boats_.begin(), boats_.end(), [place, radius](const BoatIn& b) {
      const double* x = b.plant->state();
      return std::hypot(x[0] - place[0], x[1] - place[1]) >= b.radius + radius;
    });
  }

  static double due(long k, double rate) { return static_cast<double>(k) / rate; }

  double next_reading() const {
    double next = detail::kNowhere;
    for (const BoatIn& b : boats_) {
      if (b.pose) next = std::min(next, due(b.poses, b.sensors.pose->rate));
      if (b.imu) next = std::min(next, due(b.imus, b.sensors.imu->rate));
      if (b.sensors.lidar) next = std::min(next, due(b.scans, b.sensors.lidar->rate));
    }
    return next;
  }

  /// Each boat with the scene, and each pair.
  void touch_all() {
    std::vector<Hull> hulls;
    for (const BoatIn& b : boats_) hulls.push_back(b.as_hull());
    std::vector<bool> moved(hulls.size(), false);
    for (std::size_t i = 0; i < hulls.size(); ++i) {
      for (std::size_t j = i + 1; j < hulls.size(); ++j) {
        if (!touch(hulls[i], hulls[j])) continue;
        moved[i] = moved[j] = true;
      }
    }
    for (std::size_t i = 0; i < hulls.size(); ++i) {
      moved[i] = touch(scene_, hulls[i]) || moved[i];
      if (!moved[i]) continue;
      boats_[i].touched = true;
      boats_[i].take(hulls[i]);
    }
  }

  void read(BoatIn& b) {
    double x[kStates];
    b.over_ground(x);
    if (b.pose && time_ >= due(b.poses, b.sensors.pose->rate)) {
      ++b.poses;
      Reading r{ReadingKind::kPose, b.number, time_, 0.0, std::vector<double>(3)};
      double seen[kPoses];
      const double swing = seen_pose(b, x, seen);
      if (b.pose->read(time_, seen, swing, &r.stamp, r.values.data())) {
        keep(r, b.sensors.pose->delay);
      }
    }
    if (b.imu && time_ >= due(b.imus, b.sensors.imu->rate)) {
      ++b.imus;
      Reading r{ReadingKind::kImu, b.number, time_, 0.0, std::vector<double>(3)};
      const Hull hull = b.as_hull();
      b.imu->read(1.0 / b.sensors.imu->rate, x[2], hull.velocity, r.values.data());
      keep(r, 0.0);
    }
    if (b.sensors.lidar && time_ >= due(b.scans, b.sensors.lidar->rate)) {
      ++b.scans;
      look(b, x);
    }
  }

  /// Position and heading as the pose sensor sees them; the heading of the position's time.
  double seen_pose(const BoatIn& b, const double* x, double* seen) const {
    std::copy(x, x + kPoses, seen);
    if (!b.late()) return x[2];
    const PoseSensor& s = *b.sensors.pose;
    double before[kPoses];
    b.past.at(time_ - (s.position_delay - s.stamp_offset()), before);
    std::copy(before, before + 2, seen);
    const double swing = before[2];
    b.past.at(time_ - (s.heading_delay - s.stamp_offset()), before);
    seen[2] = before[2];
    return swing;
  }

  /// A scan; other boats are seen as their discs.
  void look(BoatIn& b, const double* x) {
    const Lidar& lidar = *b.sensors.lidar;
    Scene seen = scene_;
    for (const BoatIn& other : boats_) {
      if (other.number == b.number) continue;
      const double* o = other.plant->state();
      seen.circles.push_back({{o[0], o[1]}, other.radius});
    }
    double rate[3];
    body_to_earth(x[2], x + 3, rate);
    Reading r{ReadingKind::kScan, b.number, time_ - sweep(lidar), 0.0, {}};
    scan(lidar, seen, x, rate, b.beams, r.values);
    keep(r, 0.0);
  }

  static constexpr int kPoses = 3;  // x, y, psi

  void keep(Reading& r, double delay) {
    r.arrival = time_ + delay;
    waiting_.push_back(std::move(r));
  }

  Scene scene_;
  double current_[2];
  std::uint64_t seed_;
  double time_ = 0.0;
  long ticks_ = 0;
  std::vector<BoatIn> boats_;
  std::vector<Reading> waiting_;
};

}  // namespace seatrial
