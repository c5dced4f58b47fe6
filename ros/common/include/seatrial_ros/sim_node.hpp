// SPDX-License-Identifier: MIT
// The simulator's node without ROS: what the shells for ROS 1 and ROS 2 do with commands and time.
#pragma once
#include <functional>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "seatrial_ros/signal.hpp"
#include "seatrial_ros/sim_scene.hpp"
#include "seatrial_ros/sim_settings.hpp"

namespace seatrial::ros {

class SimNode {
 public:
  using Accepted = std::function<void(int boat, const Signal& command)>;
  using Arrived = std::function<void(const Reading& reading)>;
  using Truth = std::function<void(int boat)>;

  /// Throws std::runtime_error, with one line for whoever starts it.
  explicit SimNode(SimSettings settings);

  const SimSettings& settings() const { return settings_; }
  const Sensors& sensors() const { return sensors_; }
  int n_boats() const { return static_cast<int>(boats_.size()); }
  double time() const { return simulator_->time(); }

  /// A name below the boat's own, where there are several: /joy is /name/joy.
  std::string named(int boat, const std::string& name) const { return at(boat).under(name); }

  /// Where a boat's poses go, and the frame that they are in.
  std::string pose_topic(int boat) const;
  const std::string& pose_frame(int boat) const;

  std::set<std::string> number_topics() const;

  /// As of `Node`.
  void set_type(const std::string& topic, const std::string& type);

  /// A command acts when it comes, and is told: accepted(boat, command). Empty, or in one line why
  /// it was left out.
  std::string numbers(const NumbersMessage& in, const Accepted& accepted);

  /// On to where the machine's clock is, that had `passed` [s] since simulated time 0: what arrives
  /// on the way, and every boat when its truth is due. False where the machine is too slow for real
  /// time: what it is behind is lost. Throws std::runtime_error where a boat diverges.
  bool follow(double passed, const Arrived& arrived, const Truth& truth);

  /// Truth: x, y [m], psi [rad], u, v [m/s], r [rad/s] over ground.
  void state(int boat, double* x) const { simulator_->state(boat, x); }

  /// A pose (3) as the vehicle's messages have it: x, y, and the heading of the quaternion.
  void as_message(int boat, const double* pose, double* raw) const;

 private:
  struct Boat {
    std::string name;  // empty: the only one
    BoardModel model;
    Signal command;

    std::string under(const std::string& topic) const;
  };

  void advance_to(double t, const Arrived& arrived);
  void add(const std::string& path, bool several, const SceneSetup& setup);
  std::string free_name(const std::string& given) const;
  const Boat& at(int boat) const { return boats_[static_cast<std::size_t>(boat)]; }

  SimSettings settings_;
  Sensors sensors_;
  std::unique_ptr<Simulator> simulator_;
  std::vector<Boat> boats_;
  double lost_ = 0.0;  // [s] of the machine's clock that were not made up for
  long truths_ = 0;    // number of the next
};

}  // namespace seatrial::ros
