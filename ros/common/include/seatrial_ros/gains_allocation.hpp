// SPDX-License-Identifier: MIT
// The allocator that gains bring along: `allocation` of `gains.yaml`, or the same as parameters.
#pragma once
#include <algorithm>
#include <iterator>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "seatrial/control/allocator.hpp"
#include "seatrial_ros/model_file.hpp"
#include "seatrial_ros/tracking_settings.hpp"

namespace seatrial::ros {

/// The boat allocates by itself.
inline constexpr const char* kVehicleAllocation = "vehicle";

/// A scheme, and what it is set up with. A row a thruster: the wrench by a thrust of 1 (surge,
/// sway, yaw), limit, commands to idle at forward and astern.
struct GivenAllocation {
  std::string scheme;
  std::vector<double> rank;
  double hysteresis = 0.0;
  std::vector<std::vector<double>> thrusters;
};

namespace detail {

/// In the order of AllocatorScheme.
inline const Words kAllocatorSchemes = {"moore-penrose", "always-forward", "null-space",
                                        "sign-pattern", "auto"};
/// Another name of the last one.
inline constexpr const char* kAutomaticName = "fewest-crossings";
inline constexpr std::size_t kThrusterNumbers = kWrenchAxes + 3;

inline std::vector<double> numbers_of(const Value& list) {
  std::vector<double> found;
  for (const Value& item : list.items()) found.push_back(item.number());
  return found;
}

inline GivenAllocation read_allocation(const Value& file) {
  file.only(
      {"scheme", "rank", "hysteresis", "effectiveness", "limits", "idle_forward", "idle_reverse"});
  GivenAllocation out;
  out.scheme = file.at("scheme").text();
  out.rank = numbers_of(file.at("rank"));
  out.hysteresis = file.at("hysteresis").not_negative();
  for (const Value& row : file.at("effectiveness").items()) {
    out.thrusters.push_back(numbers_of(row));
    if (out.thrusters.back().size() != kWrenchAxes) row.refuse("expected surge, sway, yaw");
  }
  for (const char* name : {"limits", "idle_forward", "idle_reverse"}) {
    const std::vector<double> column = numbers_of(file.at(name));
    if (column.size() != out.thrusters.size()) {
      file.at(name).refuse("expected as many numbers as effectiveness has rows");
    }
    for (std::size_t k = 0; k < column.size(); ++k) out.thrusters[k].push_back(column[k]);
  }
  return out;
}

inline GivenAllocation allocation_by_parameters(const TrackingSettings& s) {
  GivenAllocation out;
  out.scheme = s.allocation;
  out.rank = s.allocation_rank;
  out.hysteresis = s.allocation_hysteresis;
  for (auto at = s.allocation_thrusters.begin();
       std::distance(at, s.allocation_thrusters.end()) >= std::ptrdiff_t{kThrusterNumbers};
       at += kThrusterNumbers) {
    out.thrusters.emplace_back(at, at + kThrusterNumbers);
  }
  return out;
}

inline AllocatorScheme scheme_of(const std::string& name) {
  if (name == kAutomaticName) return AllocatorScheme::kAutomatic;
  const auto found = std::find(kAllocatorSchemes.begin(), kAllocatorSchemes.end(), name);
  if (found == kAllocatorSchemes.end()) {
    throw std::runtime_error("allocation is '" + name + "'; expected " + kVehicleAllocation + ", " +
                             joined(kAllocatorSchemes) + " or " + kAutomaticName);
  }
  return static_cast<AllocatorScheme>(std::distance(kAllocatorSchemes.begin(), found));
}

inline std::uint8_t rank_of(double given) {
  if (given != 0.0 && given != 1.0 && given != 2.0) {
    throw std::runtime_error("allocation rank is " + plain(given) +
                             "; expected 0, 1 or 2 for each of surge, sway and yaw");
  }
  return static_cast<std::uint8_t>(given);
}

/// `limit`: of the gains, for each thruster.
inline AllocatorSetup setup_of(const GivenAllocation& given, const OnboardModel& m, double limit) {
  const int n = m.chain.n_actuators();
  if (given.rank.size() != kWrenchAxes || given.thrusters.size() != static_cast<std::size_t>(n)) {
    throw std::runtime_error("the allocation is for " + std::to_string(given.thrusters.size()) +
                             " thrusters, the model has " + std::to_string(n) + "; tune it");
  }
  AllocatorSetup s;
  s.scheme = scheme_of(given.scheme);
  s.chain = m.chain;
  std::copy(m.q, m.q + kMaxConstants, s.q);
  s.hysteresis = given.hysteresis;
  s.effectiveness.n = n;
  for (int k = 0; k < n; ++k) {
    const std::vector<double>& row = given.thrusters[static_cast<std::size_t>(k)];
    std::copy(row.begin(), row.begin() + kWrenchAxes, s.effectiveness.column[k]);
    s.limit[k] = std::min(row[kWrenchAxes], limit);
    s.idle_forward[k] = row[kWrenchAxes + 1];
    s.idle_reverse[k] = row[kWrenchAxes + 2];
  }
  for (std::size_t j = 0; j < kWrenchAxes; ++j) s.rank[j] = rank_of(given.rank[j]);
  return s;
}

/// Throws std::runtime_error where the inputs are not the thrusters.
inline void expect_direct(const OnboardModel& m) {
  const Allocation& a = m.chain.allocation;
  if (a.scheme == Scheme::kDirect && a.n_commands == a.n_actuators) return;
  throw std::runtime_error(
      "allocation: the model's vehicle allocates by itself; expected an input for each thruster "
      "and allocation: {scheme: direct} in its vehicle file, or allocation " +
      std::string(kVehicleAllocation));
}

}  // namespace detail

/// What the settings or else the gains say; nothing: the boat's own.
inline std::optional<AllocatorSetup> allocation_of(const TrackingSettings& settings,
                                                   std::optional<GivenAllocation> given,
                                                   const OnboardModel& m, double limit) {
  const std::string& asked = settings.allocation;
  if (asked == kVehicleAllocation || (asked.empty() && !given)) return std::nullopt;
  if (!given) {
    throw std::runtime_error("allocation is '" + asked +
                             "', the gains have none; expected those of `seatrial tune MODEL "
                             "--allocation " +
                             asked + " -o GAINS`");
  }
  if (!asked.empty()) given->scheme = asked;
  detail::expect_direct(m);
  const AllocatorSetup setup = detail::setup_of(*given, m, limit);
  const auto made = std::make_unique<Allocator>(setup);
  if (made->fault() != AllocatorFault::kOk) {
    throw std::runtime_error("allocation " + given->scheme +
                             ": not possible with these thrusters (fault " +
                             std::to_string(static_cast<int>(made->fault())) +
                             " of AllocatorFault); `seatrial allocate MODEL` shows which are");
  }
  return setup;
}

}  // namespace seatrial::ros
