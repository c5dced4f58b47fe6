// SPDX-License-Identifier: MIT
// The groups of a vehicle's actuator chain: which constants there are, and which actuator uses
// which. Their values are the model's, under the names that are made here.
#pragma once
#include <algorithm>
#include <utility>

#include "seatrial/actuators/chain.hpp"
#include "seatrial_ros/model_value.hpp"

namespace seatrial::ros {

namespace detail {

/// Where the place of a constant stands in an actuator.
using Stage = std::int8_t Actuator::*;

/// Puts the groups of a chain into the core's actuators.
class ChainReader {
 public:
  /// signs: of the actuators, -1 where the recorded command is turned when it is read.
  ChainReader(Words actuators, Words scales, std::vector<double> signs, Chain& to)
      : actuators_(std::move(actuators)),
        scales_(std::move(scales)),
        signs_(std::move(signs)),
        chain_(to) {}

  /// Angles are known before any group is read: a rate limit of thrust is none of theirs.
  void note_angles(const Value& group) {
    const auto steered = group.find("steered");
    if (!steered) return;
    for (const Value& two : steered->at("of").items()) {
      const std::vector<Value> names = two.items();
      if (names.size() == 2) angles_.push_back(place(names[1]));
    }
  }

  void read(const Value& group) {
    group.only({"name", "actuators", "latency", "dead_zone", "reverse_ratio", "power", "table",
                "pair", "steered", "lag", "slew_rate", "scale", "gains"});
    const std::optional<Value> name = group.find("name");
    suffix_ = name && !name->text().empty() ? "." + name->text() : "";
    const std::vector<int> all = members(group);
    if (const auto table = group.find("table")) read_table(group, *table, all);
    single(group, "latency", "latency", &Actuator::latency, all);
    if (const auto edges = group.find("dead_zone")) {
      if (edges->is_mapping()) edges->only({"forward", "reverse"});
      add(edges->is_mapping() ? edges->at("forward") : *edges, "edge_forward",
          &Actuator::edge_forward, all);
      const Value reverse = edges->is_mapping() ? edges->at("reverse") : *edges;
      if (reverse.is_word() && reverse.text() == "forward") {
        share(reverse, all);
      } else {
        add(reverse, "edge_reverse", &Actuator::edge_reverse, all);
      }
    }
    single(group, "reverse_ratio", "reverse_ratio", &Actuator::reverse_ratio, all);
    single(group, "power", "power", &Actuator::power, all);
    single(group, "lag", "lag", &Actuator::lag, all);
    single(group, "slew_rate", "slew_rate", &Actuator::slew_rate, thrusts(all));
    if (const auto scale = group.find("scale")) read_scale(*scale, all);
    if (const auto pair = group.find("pair")) read_pair(*pair);
    if (const auto steered = group.find("steered")) read_steered(*steered);
    if (const auto gains = group.find("gains")) read_gains(*gains);
  }

  /// The edges of actuators whose commands are turned when they are read change places.
  void turn() {
    for (int k = 0; k < chain_.n_actuators(); ++k) {
      Actuator& a = chain_.actuators[k];
      if (signs_[static_cast<std::size_t>(k)] < 0.0) std::swap(a.edge_forward, a.edge_reverse);
    }
  }

  /// Of all constants, in the order of q.
  const Words& names() const { return names_; }

 private:
  int place(const Value& name) const {
    const int at = place_of(name.text(), actuators_);
    if (at < 0) {
      name.refuse("got '" + name.text() + "'; the actuators are " + joined(actuators_));
    }
    return at;
  }

  std::vector<int> members(const Value& group) const {
    std::vector<int> found;
    if (const auto names = group.find("actuators")) {
      for (const Value& name : names->items()) found.push_back(place(name));
    }
    if (!found.empty()) return found;
    for (int k = 0; k < chain_.n_actuators(); ++k) found.push_back(k);
    return found;
  }

  /// A constant of some actuators.
  void add(const Value& given, const std::string& stage, Stage at, const std::vector<int>& whose) {
    if (given.is_word() && given.text() != "estimate") given.number();
    if (!given.is_word()) given.refuse("expected a number, or estimate");
    add_named(given, stage + suffix_, at, whose);
  }

  void add_named(const Value& given, const std::string& name, Stage at,
                 const std::vector<int>& whose) {
    if (place_of(name, names_) >= 0) {
      given.refuse("a second constant '" + name + "'; name the groups apart");
    }
    if (chain_.n_constants == kMaxConstants) {
      given.refuse("more than " + std::to_string(kMaxConstants) + " constants");
    }
    for (const int k : whose) {
      if (chain_.actuators[k].*at >= 0) given.refuse("two groups give an actuator's " + name);
      chain_.actuators[k].*at = static_cast<std::int8_t>(chain_.n_constants);
    }
    names_.push_back(name);
    ++chain_.n_constants;
  }

  /// The edge at positive commands is the other one, too.
  void share(const Value& given, const std::vector<int>& whose) {
    for (const int k : whose) {
      Actuator& a = chain_.actuators[k];
      if (a.edge_reverse >= 0) given.refuse("two groups give an actuator's edge_reverse");
      a.edge_reverse = a.edge_forward;
    }
  }

  /// Without the angles.
  std::vector<int> thrusts(const std::vector<int>& all) const {
    std::vector<int> found;
    for (const int k : all) {
      if (std::find(angles_.begin(), angles_.end(), k) == angles_.end()) found.push_back(k);
    }
    return found;
  }

  void single(const Value& group, const std::string& key, const std::string& stage, Stage at,
              const std::vector<int>& whose) {
    if (const auto given = group.find(key)) add(*given, stage, at, whose);
  }

  void read_scale(const Value& use, const std::vector<int>& whose) {
    use.only({"signal", "power"});
    const Value signal = use.at("signal");
    const int at = place_of(signal.text(), scales_);
    if (at < 0) signal.refuse("got '" + signal.text() + "'; scales has " + joined(scales_));
    for (const int k : whose) chain_.actuators[k].scale = static_cast<std::int8_t>(at);
    const auto power = use.find("power");
    if (power) {
      add(*power, "scale_power", &Actuator::scale_power, whose);
    } else {
      add_named(use, "scale_power" + suffix_, &Actuator::scale_power, whose);
    }
  }

  void read_table(const Value& group, const Value& table, const std::vector<int>& whose) {
    if (group.find("dead_zone") || group.find("power") || group.find("reverse_ratio")) {
      group.refuse("a table stands instead of dead_zone, power and reverse_ratio");
    }
    const std::vector<Value> rows = table.items();
    if (chain_.n_table > 0) table.refuse("one table at most, for one group");
    bool rising = rows.size() >= 2 && rows.size() <= kMaxTable;
    for (std::size_t i = 0; i < rows.size() && rising; ++i) {
      const std::vector<Value> point = rows[i].items();
      if (point.size() != 2) rows[i].refuse("expected two numbers: command, thrust");
      chain_.table_command[i] = point[0].number();
      chain_.table_thrust[i] = point[1].number();
      rising = i == 0 || chain_.table_command[i] > chain_.table_command[i - 1];
    }
    if (!rising) {
      table.refuse("expected 2 to " + std::to_string(kMaxTable) + " points with rising commands");
    }
    chain_.n_table = static_cast<int>(rows.size());
    if (!(std::abs(seatrial::detail::interpolate(chain_, 1.0) - 1.0) <= 1e-9)) {
      table.refuse("must give thrust 1 at command 1; divide it by that value");
    }
    for (const int k : whose) chain_.actuators[k].tabulated = true;
  }

  void read_pair(const Value& pair) {
    pair.only({"of", "mirrored", "offset", "dead_zone"});
    Words mirrored;
    if (const auto given = pair.find("mirrored")) mirrored = given->texts();
    Words paired;
    std::vector<int> whose;
    for (const Value& two : pair.at("of").items()) {
      const std::vector<Value> names = two.items();
      if (names.size() != 2) two.refuse("expected two actuators: along, across");
      const int ends[2] = {place(names[0]), place(names[1])};
      for (int i = 0; i < 2; ++i) {
        const std::string name = names[static_cast<std::size_t>(i)].text();
        Actuator& a = chain_.actuators[ends[i]];
        if (a.partner >= 0) two.refuse(name + " is in two pairs");
        a.partner = static_cast<std::int8_t>(ends[1 - i]);
        a.across = i == 1;
        // offset and mirror are of the commands as the file has them
        a.mirrored =
            (place_of(name, mirrored) >= 0) != (signs_[static_cast<std::size_t>(ends[i])] < 0.0);
        paired.push_back(name);
        whose.push_back(ends[i]);
      }
    }
    for (const std::string& name : mirrored) {
      if (place_of(name, paired) < 0) {
        pair.refuse("mirrored names '" + name + "'; the pair has " + joined(paired));
      }
    }
    if (const auto offset = pair.find("offset")) {
      offset->only({"along", "across"});
      single(*offset, "along", "pair_offset_along", &Actuator::offset_along, whose);
      single(*offset, "across", "pair_offset_across", &Actuator::offset_across, whose);
    }
    single(pair, "dead_zone", "pair_dead_zone", &Actuator::pair_dead_zone, whose);
  }

  /// Thrusters that an angle turns; constants in the order of the Python reader.
  void read_steered(const Value& steered) {
    steered.only({"of", "angle_deg", "offset_deg", "rate_deg", "dead_zone"});
    std::vector<int> angles;
    for (const Value& two : steered.at("of").items()) {
      const std::vector<Value> names = two.items();
      if (names.size() != 2) two.refuse("expected two actuators: thrust, angle");
      const int angle = place(names[1]);
      if (signs_[static_cast<std::size_t>(angle)] < 0.0) {
        two.refuse("the angle's input has the opposite sign in these axes; give it another name");
      }
      Actuator& a = chain_.actuators[angle];
      if (a.steers >= 0) two.refuse("an angle turns two thrusts");
      a.steers = static_cast<std::int8_t>(place(names[0]));
      a.scale = -1;
      angles.push_back(angle);
    }
    if (const auto zone = steered.find("dead_zone")) {
      add(*zone, "steer_dead_zone", &Actuator::edge_forward, angles);
      share(*zone, angles);
    }
    add(steered.at("angle_deg"), "steer_angle", &Actuator::full_angle, angles);
    single(steered, "offset_deg", "steer_offset", &Actuator::angle_offset, angles);
    single(steered, "rate_deg", "steer_rate", &Actuator::slew_rate, angles);
  }

  void read_gains(const Value& gains) {
    for (const auto& [name, gain] : gains.entries()) {
      const int at = place_of(name, actuators_);
      if (at < 0) gain.refuse("no actuator '" + name + "'; there are " + joined(actuators_));
      gain.number();
      add_named(gain, "gain." + name, &Actuator::gain, {at});
    }
  }

  Words actuators_;
  Words scales_;
  std::vector<double> signs_;
  Chain& chain_;
  std::string suffix_;
  std::vector<int> angles_;
  Words names_;
};

}  // namespace detail

/// Reads `vehicle.chain` into the core's chain, whose actuators are known; the names of its
/// constants in the order of q. Throws std::runtime_error.
inline Words read_chain(const Value& groups, const Words& actuators, const Words& scales,
                        const std::vector<double>& signs, Chain& to) {
  detail::ChainReader reader(actuators, scales, signs, to);
  for (const Value& group : groups.items()) reader.note_angles(group);
  for (const Value& group : groups.items()) reader.read(group);
  reader.turn();
  if (!pairs_are_whole(to)) {
    groups.refuse(
        "a pair stands instead of dead_zone, power, reverse_ratio and table; all of a pair's "
        "constants are for both of its actuators");
  }
  if (!angles_are_whole(to)) {
    groups.refuse("steered: an angle turns one other actuator's thrust, and has no gain or scale");
  }
  return reader.names();
}

}  // namespace seatrial::ros
