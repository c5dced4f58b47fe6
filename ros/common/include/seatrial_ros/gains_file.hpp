// SPDX-License-Identifier: MIT
// Gains of the tracking controller: `gains.yaml`, or the same as parameters. What Python's
// `seatrial.TrackingController` reads.
#pragma once
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "seatrial/control/tracking.hpp"
#include "seatrial_ros/gains_allocation.hpp"
#include "seatrial_ros/model_file.hpp"
#include "seatrial_ros/tracking_settings.hpp"

namespace seatrial::ros {

struct BoardGains {
  TrackingGains gains;
  double rate = 0.0;  // [Hz] that they are for
  double lead = 0.0;  // [s]
  std::optional<GivenAllocation> given;
  std::optional<AllocatorSetup> allocation;  // nothing: the boat's own
};

namespace detail {

inline void read_three(const Value& list, double* to) {
  const std::vector<Value> items = list.items();
  if (items.size() != kAxes) list.refuse("expected three numbers: surge, sway, yaw");
  for (int i = 0; i < kAxes; ++i) to[i] = items[static_cast<std::size_t>(i)].number();
}

inline void read_mix(const Value& file, const Words& inputs, TrackingGains& g) {
  const Words given = file.at("inputs").texts();
  if (given != inputs) {
    file.at("inputs").refuse("the gains are for " + joined(given) + ", the model has " +
                             joined(inputs) + "; tune it");
  }
  const std::vector<Value> rows = file.at("mix").items();
  if (rows.size() != inputs.size()) file.at("mix").refuse("expected one row an input");
  for (std::size_t k = 0; k < rows.size(); ++k) read_three(rows[k], g.mix[k]);
}

/// Of a boat without sway thrust.
inline GuidanceSettings read_guidance(const Value& file) {
  file.only({"time", "radius", "slowest", "fastest", "approach"});
  return {file.at("time").positive(), file.at("radius").positive(), file.at("slowest").positive(),
          file.at("fastest").positive(), file.at("approach").positive()};
}

inline BoardGains read_gains(const Value& file, const Words& inputs) {
  const auto format = file.find("seatrial");
  if (!format || format->text() != "gains 1") {
    file.refuse("expected 'seatrial: gains 1', as `seatrial tune MODEL -o GAINS` writes it");
  }
  file.only({"seatrial", "model",        "axes",     "inputs",     "knob",      "action",
             "rate",     "proportional", "integral", "derivative", "authority", "mix",
             "lead",     "limit",        "delay",    "dead_zone",  "margins",   "worst",
             "draws",    "seed",         "version",  "allocation", "guidance"});
  file.at("axes").choice({"forward-left-up"});
  BoardGains out;
  TrackingGains& g = out.gains;
  read_mix(file, inputs, g);
  read_three(file.at("proportional"), g.proportional);
  read_three(file.at("integral"), g.integral);
  read_three(file.at("derivative"), g.derivative);
  read_three(file.at("authority"), g.authority);
  if (const auto limit = file.find("limit")) g.limit = limit->positive();
  out.rate = file.at("rate").positive();
  out.lead = file.at("lead").not_negative();
  if (const auto own = file.find("allocation")) out.given = read_allocation(*own);
  if (const auto own = file.find("guidance")) g.guidance = read_guidance(*own);
  return out;
}

/// Throws std::runtime_error where a list has not so many finite numbers.
inline void take_list(const std::string& name, const std::vector<double>& from, std::size_t n,
                      double* to) {
  const bool finite =
      std::all_of(from.begin(), from.end(), [](double x) { return std::isfinite(x); });
  if (from.size() != n || !finite) {
    throw std::runtime_error(
        "parameter " + name + " has " + std::to_string(from.size()) + " numbers; expected " +
        std::to_string(n) +
        " finite ones: give gains the path of a gains.yaml, or rosparam load what `seatrial tune "
        "MODEL --ros FILE` writes");
  }
  std::copy(from.begin(), from.end(), to);
}

inline BoardGains gains_by_parameters(const TrackingSettings& s, std::size_t n_inputs) {
  BoardGains out;
  TrackingGains& g = out.gains;
  take_list("proportional", s.proportional, kAxes, g.proportional);
  take_list("integral", s.integral, kAxes, g.integral);
  take_list("derivative", s.derivative, kAxes, g.derivative);
  take_list("authority", s.authority, kAxes, g.authority);
  take_list("mix", s.mix, kAxes * n_inputs, &g.mix[0][0]);
  g.limit = s.limit;
  out.rate = s.rate;
  out.lead = s.lead;
  if (!s.guidance.empty()) {
    double own[5];
    take_list("guidance", s.guidance, 5, own);
    const bool positive = std::all_of(own, own + 5, [](double x) { return x > 0.0; });
    if (!positive) throw std::runtime_error("parameter guidance: expected five numbers above 0");
    g.guidance = {own[0], own[1], own[2], own[3], own[4]};
  }
  if (!s.allocation_thrusters.empty()) out.given = allocation_by_parameters(s);
  return out;
}

/// Accelerations at rest by thrusts (actuators).
inline void push_by(const OnboardModel& m, const double* thrust, double* push) {
  const Chain& c = m.chain;
  double force[kMaxForces] = {};
  for (int k = 0; k < c.n_actuators(); ++k) {
    for (int j = 0; j < c.n_forces; ++j) force[j] += c.mix[j][k] * thrust[k];
  }
  const double rest[kAxes] = {};
  const double none[kMaxForces] = {};
  double free[kAxes];
  acceleration(m.boat.structure, m.boat.coefficient, rest, force, push);
  acceleration(m.boat.structure, m.boat.coefficient, rest, none, free);
  for (int i = 0; i < kAxes; ++i) push[i] -= free[i];
}

/// Accelerations at rest per axis command `axis`, with the thrusters' curves as their chords.
inline void push_of(const OnboardModel& m, const TrackingGains& gains, int axis, double* push) {
  constexpr double kSmall = 1e-3;  // of a command: within every limit
  const Chain& c = m.chain;
  double given[kMaxActuators];
  double command[2][kMaxCommands];
  double thruster[2][kMaxActuators];
  for (int side = 0; side < 2; ++side) {
    const double size = side == 0 ? kSmall : -kSmall;
    for (int j = 0; j < c.allocation.n_commands; ++j) command[side][j] = size * gains.mix[j][axis];
    allocate(c.allocation, command[side], thruster[side]);
  }
  for (int k = 0; k < c.n_actuators(); ++k) {
    double full[kMaxActuators] = {};
    full[k] = 1.0;
    const double chord = curve(c, m.q, k, full, nullptr);
    given[k] = chord * (thruster[0][k] - thruster[1][k]) / (2.0 * kSmall);
  }
  push_by(m, given, push);
}

/// An axis that the gains drive: all but the sway of a boat with guidance.
inline bool drives(const TrackingGains& gains, int axis) {
  return axis != 1 || !gains.guidance.on();
}

/// Throws std::runtime_error where an axis has no authority, or sway and guidance contradict.
inline void expect_authority(const TrackingGains& gains) {
  for (int axis = 0; axis < kAxes; ++axis) {
    if ((gains.authority[axis] > 0.0) == drives(gains, axis)) continue;
    throw std::runtime_error("authority is " + plain(gains.authority[axis]) + " in " +
                             kAxisNames[static_cast<std::size_t>(axis)] +
                             "; expected more than 0, and 0 in sway with guidance: tune it");
  }
}

/// Of a boat with angles; nothing: it has none. Throws std::runtime_error where it has others than
/// one that turns the thrust of its only thruster.
inline std::unique_ptr<Steering> steering_of(const OnboardModel& m, double limit) {
  const Actuator* all = m.chain.actuators;
  const bool steers = std::any_of(all, all + m.chain.n_actuators(),
                                  [](const Actuator& a) { return a.steers >= 0; });
  if (!steers) return nullptr;
  auto found =
      std::make_unique<Steering>(m.boat.structure, m.boat.coefficient, m.chain, m.q, limit);
  if (found->fault() != SteeringFault::kOk) {
    throw std::runtime_error(
        "chain: steered: the tracking controller takes one thruster with one angle, inputs of "
        "their own, and thrust ahead that gives surge; `seatrial tune` says which is missing");
  }
  return found;
}

/// Throws std::runtime_error where the gains were tuned for another boat with an angle.
inline void expect_steered(const Steering& steering, const TrackingGains& gains) {
  constexpr double kSame = 1e-6;
  double own[kAxes] = {};
  steering.authority(gains.guidance.fastest, &own[0], &own[2]);
  for (const int axis : {0, 2}) {
    if (std::abs(own[axis] - gains.authority[axis]) <= kSame * std::abs(own[axis])) continue;
    throw std::runtime_error("the gains are for a boat with an authority of " +
                             plain(gains.authority[axis]) + " in " +
                             kAxisNames[static_cast<std::size_t>(axis)] + "; this model has " +
                             plain(own[axis]) + ": tune it");
  }
}

/// Throws std::runtime_error where the gains were tuned for another boat.
inline void expect_belong(const OnboardModel& m, const TrackingGains& gains) {
  constexpr double kSame = 1e-6;  // by which two authorities may differ
  expect_authority(gains);
  if (const auto steering = steering_of(m, gains.limit)) return expect_steered(*steering, gains);
  for (int axis = 0; axis < kAxes; ++axis) {
    if (!drives(gains, axis)) continue;
    double push[kAxes];
    push_of(m, gains, axis, push);
    for (int i = 0; i < kAxes; ++i) {
      if (!drives(gains, i)) continue;
      const double wanted = i == axis ? gains.authority[i] : 0.0;
      if (std::abs(push[i] - wanted) <= kSame * std::abs(gains.authority[i])) continue;
      throw std::runtime_error("the gains are for a boat that a full command in " +
                               kAxisNames[static_cast<std::size_t>(axis)] + " gives " +
                               std::to_string(wanted) + " in " +
                               kAxisNames[static_cast<std::size_t>(i)] + "; this model gives " +
                               std::to_string(push[i]) + ": tune it");
    }
  }
}

/// Throws std::runtime_error where the allocator does not give what the gains ask for: another
/// boat's. Without sides and idling, so that nothing is held.
inline void expect_gives(const OnboardModel& m, const AllocatorSetup& setup,
                         const TrackingGains& gains) {
  constexpr double kSome = 0.1;  // of an axis command
  constexpr double kSame = 1e-6;
  AllocatorSetup plain_setup = setup;
  plain_setup.scheme = AllocatorScheme::kMoorePenrose;
  const auto allocator = std::make_unique<Allocator>(plain_setup);
  AxisCommands commands(*allocator, gains.mix);
  for (int axis = 0; axis < kAxes; ++axis) {
    if (!drives(gains, axis)) continue;
    double asked[kAxes] = {};
    asked[axis] = kSome;
    const double rest[kAxes] = {};
    double command[kMaxCommands] = {};
    if (!commands.command(asked, rest, 0.0, command)) continue;  // beyond the limits: less is given
    double thrust[kMaxActuators];
    for (int k = 0; k < m.chain.n_actuators(); ++k) thrust[k] = allocator->thrust(k, command[k]);
    double push[kAxes];
    push_by(m, thrust, push);
    for (int i = 0; i < kAxes; ++i) {
      if (!drives(gains, i)) continue;
      const double wanted = gains.authority[i] * asked[i];
      if (std::abs(push[i] - wanted) <= kSame * std::abs(gains.authority[i])) continue;
      throw std::runtime_error("the allocation is for another boat's thrusters: in " +
                               kAxisNames[static_cast<std::size_t>(i)] + " it gives " +
                               plain(push[i]) + " where " + plain(wanted) + " is asked: tune it");
    }
  }
}

}  // namespace detail

/// The gains that the settings name, for a model's inputs. Throws std::runtime_error with one line.
inline BoardGains load_gains(const TrackingSettings& settings, const BoardModel& board) {
  const Words inputs = detail::names_of(board.inputs);
  BoardGains found;
  if (settings.gains.empty()) {
    found = detail::gains_by_parameters(settings, inputs.size());
  } else {
    try {
      found = detail::read_gains(read_yaml(settings.gains), inputs);
    } catch (const std::runtime_error& error) {
      throw std::runtime_error(settings.gains + ": " + error.what());
    }
    if (settings.rate > 0.0) found.rate = settings.rate;
  }
  if (!(found.rate > 0.0)) throw std::runtime_error("rate is 0; expected that of the gains [Hz]");
  found.gains.feed_forward = settings.feed_forward;
  detail::expect_belong(board.model, found.gains);
  found.allocation = allocation_of(settings, found.given, board.model, found.gains.limit);
  if (found.allocation) detail::expect_gives(board.model, *found.allocation, found.gains);
  return found;
}

}  // namespace seatrial::ros
