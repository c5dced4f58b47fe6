// SPDX-License-Identifier: MIT
#include "seatrial_ros/model_file.hpp"

#include "seatrial/onboard/parameter_uncertainty.hpp"

namespace seatrial::ros {

namespace {

const Words kSpeeds = {"u", "v", "r"};
constexpr double kLeastSpread[kAxes] = {0.1, 0.1, 0.2};  // [m/s, m/s, rad/s]
constexpr double kFirstShare = 0.5;                      // of the largest speed, at the first pose

/// Values by name, each name once: of coefficients or constants.
void read_values(const Value& entries, const Words& names, double* to) {
  Words got;
  for (const auto& [name, entry] : entries.entries()) {
    const int at = place_of(name, names);
    if (at < 0) entries.refuse("'" + name + "' is not in the structure; expected " + joined(names));
    entry.only({"value", "standard_error", "unit"});
    to[at] = entry.at("value").number();
    got.push_back(name);
  }
  for (const std::string& name : names) {
    if (place_of(name, got) < 0) entries.refuse("'" + name + "' is missing");
  }
}

/// Of coefficients, then constants; sign: -1 where one changes sign between the axis systems.
void read_covariance(const Value& rows, const std::vector<double>& sign,
                     double (*to)[kMaxParameters]) {
  const std::size_t n = sign.size();
  const std::string size = std::to_string(n) + " x " + std::to_string(n);
  const std::vector<Value> lines = rows.items();
  if (lines.size() != n) rows.refuse("must be " + size);
  for (std::size_t i = 0; i < n; ++i) {
    const std::vector<Value> line = lines[i].items();
    if (line.size() != n) rows.refuse("must be " + size);
    for (std::size_t j = 0; j < n; ++j) to[i][j] = sign[i] * sign[j] * line[j].number();
  }
  for (std::size_t i = 0; i < n; ++i) {
    bool sound = to[i][i] >= 0.0;
    for (std::size_t j = 0; j < i; ++j) {
      sound = sound && std::abs(to[i][j] - to[j][i]) <= 1e-6 * std::abs(to[j][i]);
    }
    if (!sound) rows.refuse("must be symmetric with variances >= 0");
  }
}

/// Standard deviations and memory as the file has them; without `process` the estimator's start.
NoiseParameters read_noise(const Value& noise) {
  noise.only({"position", "heading", "process", "correlated"});
  NoiseParameters n;
  n.position = noise.at("position").not_negative();
  n.heading = noise.at("heading").not_negative();
  if (const auto coloured = noise.find("correlated")) {
    coloured->only({"position", "heading", "memory", "period"});
    n.colour_position = coloured->at("position").not_negative();
    n.colour_heading = coloured->at("heading").not_negative();
    n.colour_memory = coloured->at("memory").positive();
    if (const auto swings = coloured->find("period")) {
      n.colour_turn = 2.0 * kPi / swings->positive();
    }
  }
  if (const auto p = noise.find("process")) {
    p->only({"walk_linear", "walk_yaw", "disturbance_linear", "disturbance_yaw", "memory",
             "sway_ratio", "earth_fixed"});  // on board the node's own parameter says so
    n.walk_linear = p->at("walk_linear").not_negative();
    n.walk_yaw = p->at("walk_yaw").not_negative();
    n.disturbance_linear = p->at("disturbance_linear").not_negative();
    n.disturbance_yaw = p->at("disturbance_yaw").not_negative();
    n.memory = p->at("memory").positive();
    if (const auto ratio = p->find("sway_ratio")) n.sway_ratio = ratio->positive();
  }
  return n;
}

/// A range by name; odd: it changes sign. False: the file has none.
bool read_range(const Value& ranges, const std::string& name, bool odd, double* to) {
  const auto given = ranges.find(name);
  if (!given) return false;
  const std::vector<Value> ends = given->items();
  if (ends.size() != 2) given->refuse("expected two numbers: least, most");
  const double low = ends[0].number();
  const double high = ends[1].number();
  to[0] = odd ? -high : low;
  to[1] = odd ? -low : high;
  return true;
}

/// Ranges, and the velocity's spread at the first pose. True where all speeds are known.
bool read_envelope(const Value& envelope, const BoardVehicle& vehicle, OnboardModel& m) {
  envelope.only({"speeds", "forces"});
  bool known = true;
  for (int a = 0; a < kAxes; ++a) {
    double* range = m.envelope.speed[a];
    const bool odd = vehicle.from_right_down && a > 0;
    const bool given =
        read_range(envelope.at("speeds"), kSpeeds[static_cast<std::size_t>(a)], odd, range);
    const double most = given ? std::max(std::abs(range[0]), std::abs(range[1])) : 1.0;
    m.velocity_spread[a] = std::max(kFirstShare * most, kLeastSpread[a]);
    known = known && given;
  }
  for (std::size_t j = 0; j < vehicle.forces.size(); ++j) {
    const Force& force = vehicle.forces[j];
    const bool odd = vehicle.from_right_down && force.axis > 0;
    read_range(envelope.at("forces"), force.name, odd, m.envelope.force[j]);
  }
  return known;
}

/// Whether structure and noise explain what the model was identified from.
bool explained(const Value& estimator) {
  const auto settings = estimator.find("settings");
  const auto belief = settings ? settings->find("belief") : std::nullopt;
  if (!belief || !belief->is_word()) return false;
  const std::string text = belief->text();
  char* end = nullptr;
  return std::strtod(text.c_str(), &end) == 0.0 && end != text.c_str();
}

/// Coefficients with what is known of their errors, and the noise that follows.
void read_parameters(const Value& file, const BoardVehicle& vehicle, const NamedStructure& named,
                     OnboardModel& m) {
  UncertainModel uncertain;
  Boat& boat = uncertain.boat;
  boat.structure = named.structure;
  uncertain.chain = vehicle.chain;
  read_values(file.at("coefficients"), named.coefficients, boat.coefficient);
  read_values(file.at("constants"), vehicle.constants, uncertain.q);
  std::vector<double> sign;
  for (const bool flips : named.flips) {
    sign.push_back(flips && vehicle.from_right_down ? -1.0 : 1.0);
  }
  for (std::size_t i = 0; i < sign.size(); ++i) boat.coefficient[i] *= sign[i];
  sign.resize(sign.size() + vehicle.constants.size(), 1.0);
  read_covariance(file.at("covariance"), sign, uncertain.covariance);
  if (!read_envelope(file.at("envelope"), vehicle, m)) {  // then nothing says how fast it may go
    for (auto& row : uncertain.covariance) std::fill(row, row + kMaxParameters, 0.0);
  }
  std::copy(&m.envelope.speed[0][0], &m.envelope.speed[0][0] + std::ptrdiff_t{2} * kAxes,
            &uncertain.speed[0][0]);
  set_uncertainty(uncertain, read_noise(file.at("noise")), explained(file.at("estimator")), m.boat);
  std::copy(boat.coefficient, boat.coefficient + kMaxCoefficients, m.boat.coefficient);
  std::copy(uncertain.q, uncertain.q + kMaxConstants, m.q);
}

void read_integration(const Value& integration, OnboardBoat& boat) {
  integration.only({"scheme", "step"});
  const int scheme = integration.at("scheme").choice({"runge-kutta", "forward-euler"});
  boat.integrator = scheme == 0 ? Integrator::kRungeKutta : Integrator::kForwardEuler;
  boat.longest_step = integration.at("step").positive();
}

/// "model 2" has the estimator's findings as sentences; a node reads neither.
void expect_format(const Value& file) {
  const auto format = file.find("seatrial");
  if (format && format->is_word() && (format->text() == "model 3" || format->text() == "model 2")) {
    return;
  }
  const std::string said = format && format->is_word() ? "says 'seatrial: " + format->text() + "'"
                                                       : "has no line 'seatrial: ...'";
  file.refuse(said +
              "; expected 'seatrial: model 3': is it another file, or from another version of "
              "seatrial?");
}

BoardModel read_model(const Value& file) {
  expect_format(file);
  file.only({"seatrial", "version", "name", "axes", "structure", "coefficients", "constants",
             "covariance", "integration", "noise", "envelope", "recordings", "estimator",
             "warnings", "vehicle"});
  const BoardVehicle vehicle = read_vehicle(file.at("vehicle"));
  if ((file.at("axes").choice(kAxesSystems) == 1) != vehicle.from_right_down) {
    file.at("axes").refuse("differ from vehicle.axes");
  }
  const NamedStructure named =
      read_structure(file.at("structure"), vehicle.forces, vehicle.from_right_down);
  BoardModel out;
  out.name = file.at("name").text();
  out.inputs = vehicle.inputs;
  out.scales = vehicle.scales;
  out.commands = vehicle.commands;
  out.pose = vehicle.pose;
  OnboardModel& m = out.model;
  m.chain = vehicle.chain;
  m.command_timeout = vehicle.command_timeout;
  m.position_delay = vehicle.pose.position_delay;
  m.heading_delay = vehicle.pose.heading_delay;
  m.boat.structure = named.structure;
  if (!add_disturbance(m.boat.structure)) {
    file.at("structure").refuse("too many terms: no room for the disturbance of the filter");
  }
  read_parameters(file, vehicle, named, m);
  read_integration(file.at("integration"), m.boat);
  return out;
}

}  // namespace

BoardModel load_model(const std::string& path) {
  try {
    return read_model(read_yaml(path));
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(path + ": " + error.what());
  }
}

}  // namespace seatrial::ros
