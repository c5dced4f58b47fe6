// SPDX-License-Identifier: MIT
// The vehicle inside a model file: its signals, its thrusters, its allocation, its actuator chain.
#pragma once
#include "seatrial_ros/chain_file.hpp"
#include "seatrial_ros/chain_thrusters.hpp"
#include "seatrial_ros/model_signals.hpp"
#include "seatrial_ros/structure_text.hpp"

namespace seatrial::ros {

inline const Words kAxesSystems = {"forward-left-up", "forward-right-down"};

/// A vehicle in forward-left-up axes.
struct BoardVehicle {
  bool from_right_down = false;  // the file's axes
  std::vector<Channel> inputs;
  std::vector<Channel> scales;
  CommandSource commands;
  PoseSource pose;
  double command_timeout = std::numeric_limits<double>::infinity();  // [s]
  std::vector<Force> forces;                                         // that terms may use
  Chain chain;
  Words constants;  // of the chain, in the order of q
};

namespace detail {

inline const Words kWrench = {"F_u", "F_v", "F_r"};  // Eq. (9), one an axis
inline const Words kSchemes = {"direct", "moore-penrose", "always-forward"};  // of Scheme

inline Words names_of(const std::vector<Channel>& channels) {
  Words names;
  for (const Channel& c : channels) names.push_back(c.name);
  return names;
}

/// Puts the parts of a vehicle file together.
class VehicleReader {
 public:
  explicit VehicleReader(const Value& file) : file_(file) {
    file.only({"seatrial", "name", "axes", "pose", "commands", "command_timeout", "scales",
               "thrusters", "forces", "allocation", "chain"});
    out_.from_right_down = file.at("axes").choice(kAxesSystems) == 1;
    read_signals();
    read_allocation();
    read_mix();
    read_stages();
  }

  const BoardVehicle& vehicle() const { return out_; }

 private:
  void read_signals() {
    const Value commands = file_.at("commands");
    commands.only({"inputs", "stamp", "file", "topic", "clock", "sampled"});
    out_.pose = read_pose_source(file_.at("pose"), out_.from_right_down);
    out_.commands.topic = text_or(commands, "topic", "");
    out_.commands.clock = read_clock(commands);
    for (const auto& [name, column] : commands.at("inputs").entries()) {
      const bool turns = out_.from_right_down && (name == kWrench[1] || name == kWrench[2]);
      signs_.push_back(turns ? -1.0 : 1.0);
      out_.inputs.push_back(read_channel(column, name, out_.commands.topic, kUnits, signs_.back()));
    }
    inputs_ = names_of(out_.inputs);
    if (inputs_.empty() || inputs_.size() > kMaxCommands) {
      commands.refuse(std::to_string(inputs_.size()) + " inputs; expected 1 to " +
                      std::to_string(kMaxCommands));
    }
    if (const auto timeout = file_.find("command_timeout")) {
      out_.command_timeout = timeout->positive();
    }
    const auto scales = file_.find("scales");
    if (!scales) return;
    for (const auto& [name, scale] : scales->entries()) {
      scale.only({"column", "reference"});
      if (out_.scales.size() == kMaxScales) {
        scales->refuse("more than " + std::to_string(kMaxScales) + " scale signals");
      }
      out_.chain.scale_reference[out_.scales.size()] = scale.at("reference").positive();
      out_.scales.push_back(
          read_channel(scale.at("column"), name, out_.commands.topic, kUnits, 1.0));
    }
    out_.chain.n_scales = static_cast<int>(out_.scales.size());
  }

  void read_allocation() {
    Allocation& a = out_.chain.allocation;
    a.n_commands = static_cast<int>(inputs_.size());
    thrusters_ = file_.find("thrusters");
    if (const auto given = file_.find("allocation")) {
      given->only({"scheme", "F_os", "limit"});
      if (const auto scheme = given->find("scheme")) {
        a.scheme = static_cast<Scheme>(scheme->choice(kSchemes));
      }
      if (const auto offset = given->find("F_os")) a.offset = offset->not_negative();
      if (const auto limit = given->find("limit")) a.limit = limit->positive();
      if (a.scheme == Scheme::kAlwaysForward && a.offset >= a.limit) {
        given->refuse("F_os leaves no room under the limit");
      }
    }
    actuators_ = inputs_;
    if (a.scheme == Scheme::kDirect) {
      for (int k = 0; k < a.n_commands; ++k) a.inverse[k][k] = 1.0;
    } else {
      if (!thrusters_ || !same(inputs_, kWrench)) {
        file_.refuse("allocation " + kSchemes[static_cast<std::size_t>(a.scheme)] +
                     " needs thrusters, and inputs named " + joined(kWrench) + "; got inputs " +
                     joined(inputs_));
      }
      actuators_.clear();
      for (const auto& entry : thrusters_->entries()) actuators_.push_back(entry.first);
      if (actuators_.size() > kMaxActuators) {
        thrusters_->refuse("more than " + std::to_string(kMaxActuators) + " thrusters");
      }
    }
    a.n_actuators = static_cast<int>(actuators_.size());
  }

  void read_mix() {
    const auto forces = file_.find("forces");
    if (forces && thrusters_) file_.refuse("give thrusters or forces, not both");
    if (forces) {
      read_forces(*forces);
    } else if (thrusters_) {
      read_thrusters();
    } else {
      read_wrench();
    }
    out_.chain.n_forces = static_cast<int>(out_.forces.size());
  }

  /// Forces as weighted sums of the inputs.
  void read_forces(const Value& forces) {
    for (const auto& [name, force] : forces.entries()) {
      force.only({"axis", "of", "deflection"});
      if (out_.forces.size() == kMaxForces) {
        forces.refuse("more than " + std::to_string(kMaxForces) + " forces");
      }
      if (name.rfind("F_", 0) != 0) force.refuse("names begin with F_");
      const int axis = force.at("axis").choice(kAxisNames);
      const double flip = out_.from_right_down && axis > 0 ? -1.0 : 1.0;
      double* row = out_.chain.mix[out_.forces.size()];
      for (const auto& [k, weight] : weights(force, "of")) {
        // a wrench input has been turned itself when it was read
        row[k] = flip * weight * signs_[static_cast<std::size_t>(k)];
      }
      double* sines = out_.chain.deflection[out_.forces.size()];
      for (const auto& [k, weight] : weights(force, "deflection")) sines[k] = flip * weight;
      out_.forces.push_back({name, axis});
    }
  }

  /// Actuators and weights of one key of a force; none without the key.
  std::vector<std::pair<int, double>> weights(const Value& force, const std::string& key) const {
    std::vector<std::pair<int, double>> found;
    const auto given = force.find(key);
    if (!given) return found;
    for (const auto& [actuator, weight] : given->entries()) {
      const int k = place_of(actuator, actuators_);
      if (k < 0) {
        weight.refuse("no actuator '" + actuator + "'; there are " + joined(actuators_));
      }
      found.emplace_back(k, weight.number());
    }
    return found;
  }

  void read_thrusters() {
    Words given;
    for (const auto& entry : thrusters_->entries()) given.push_back(entry.first);
    if (!same(actuators_, given)) {
      thrusters_->refuse("allocation is direct, so the inputs must be the thrusters " +
                         joined(given) + "; got " + joined(inputs_));
    }
    const double turn = out_.from_right_down ? -1.0 : 1.0;
    std::vector<Thruster> thrusters;
    for (const std::string& name : actuators_) {
      const Value own = thrusters_->at(name);
      own.only({"x", "y", "angle_deg"});
      thrusters.push_back({own.at("x").number(), turn * own.at("y").number(),
                           turn * (own.at("angle_deg").number() * (kPi / 180.0))});
    }
    Chain& c = out_.chain;
    thruster_matrix(thrusters, *thrusters_, c.mix);
    double inverse[kMaxActuators][kMaxCommands] = {};
    pseudo_inverse(c.mix, c.n_actuators(), *thrusters_, inverse);
    for (int i = 0; i < kAxes; ++i)
      out_.forces.push_back({kWrench[static_cast<std::size_t>(i)], i});
    if (c.allocation.scheme == Scheme::kDirect) return;
    if (c.allocation.scheme == Scheme::kAlwaysForward &&
        !runs_always_forward(c.mix, c.n_actuators(), inverse)) {
      thrusters_->refuse(
          "always-forward needs pushes that cancel when all thrusters run alike; "
          "use moore-penrose");
    }
    for (int k = 0; k < c.n_actuators(); ++k) {
      for (std::size_t j = 0; j < inputs_.size(); ++j) {
        c.allocation.inverse[k][j] = inverse[k][place_of(inputs_[j], kWrench)];
      }
    }
  }

  /// The inputs are the wrench, or what the boat has of it.
  void read_wrench() {
    for (int i = 0; i < kAxes; ++i) {
      const int k = place_of(kWrench[static_cast<std::size_t>(i)], inputs_);
      if (k < 0) continue;
      out_.chain.mix[out_.forces.size()][k] = 1.0;
      out_.forces.push_back({kWrench[static_cast<std::size_t>(i)], i});
    }
    if (out_.forces.size() != inputs_.size()) {
      file_.refuse("inputs are " + joined(inputs_) + "; without thrusters or forces they must be " +
                   joined(kWrench) + ", or those of them that there are");
    }
  }

  void read_stages() {
    const auto groups = file_.find("chain");
    if (!groups) return;
    const std::vector<double> signs =
        thrusters_ ? std::vector<double>(actuators_.size(), 1.0) : signs_;
    out_.constants = read_chain(*groups, actuators_, names_of(out_.scales), signs, out_.chain);
  }

  static bool same(Words a, Words b) {
    std::sort(a.begin(), a.end());
    std::sort(b.begin(), b.end());
    return a == b;
  }

  const Value& file_;
  BoardVehicle out_;
  Words inputs_;
  Words actuators_;
  std::optional<Value> thrusters_;
  std::vector<double> signs_;  // of the inputs, to forward-left-up
};

}  // namespace detail

/// `vehicle` of a model file. Throws std::runtime_error.
inline BoardVehicle read_vehicle(const Value& file) {
  return detail::VehicleReader(file).vehicle();
}

}  // namespace seatrial::ros
