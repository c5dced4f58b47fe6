// SPDX-License-Identifier: MIT
// Inverse of one thruster's static curve: the command for a thrust.
#pragma once
#include <algorithm>
#include <cmath>

#include "seatrial/actuators/chain.hpp"

namespace seatrial {

/// The side of its dead zone on which a thruster without thrust waits.
enum class Side : std::int8_t { kReverse = -1, kOff = 0, kForward = 1 };

/// One thruster's curve, thrust g(command) with its gain, and its inverse. Thrust is in units of
/// the mean thruster's at command 1; commands in command units. `chain` and `q` of all calls are
/// those it is made of.
class ThrusterCurve {
 public:
  ThrusterCurve() = default;

  /// `inverted` false: the curve is left out, and a command is taken for the thrust.
  ThrusterCurve(const Chain& chain, const double* q, int k, bool inverted)
      : k_(k), tabulated_(inverted && chain.actuators[k].tabulated), straight_(!inverted) {
    const Actuator& a = chain.actuators[k];
    gain_ = inverted ? detail::constant(q, a.gain, 1.0) : 1.0;
    ratio_ = inverted ? detail::constant(q, a.reverse_ratio, 1.0) : 1.0;
    power_ = inverted ? detail::constant(q, a.power, 1.0) : 1.0;
    edge_forward_ = detail::constant(q, a.edge_forward, 0.0);
    edge_reverse_ = detail::constant(q, a.edge_reverse, 0.0);
    if (a.tabulated) edges_of_table(chain);
  }

  double edge(Side side) const {
    return side == Side::kForward ? edge_forward_ : side == Side::kReverse ? edge_reverse_ : 0.0;
  }

  /// Thrust at a command, by the chain's own curve.
  double thrust(const Chain& chain, const double* q, double command) const {
    return straight_ ? command : gain_ * detail::single_curve(chain, q, k_, command, 1.0, nullptr);
  }

  /// The command that gives a thrust; for no thrust the edge of the side `waits`, or 0.
  double command(const Chain& chain, double thrust, Side waits) const {
    if (thrust == 0.0) return static_cast<double>(waits) * edge(waits);
    if (straight_) return thrust;
    if (tabulated_) return from_table(chain, thrust / gain_);
    const bool forward = thrust > 0.0;
    const double share = std::abs(thrust) / (forward ? gain_ : gain_ * ratio_);
    const double past = power_ == 1.0 ? share : std::pow(share, 1.0 / power_);
    const double edge = forward ? edge_forward_ : edge_reverse_;
    return (forward ? 1.0 : -1.0) * (edge + (1.0 - edge) * past);
  }

  /// Whether every thrust but 0 has one command: the curve rises outside the dead zone.
  bool invertible(const Chain& chain) const {
    if (!(gain_ > 0.0 && ratio_ > 0.0 && power_ > 0.0)) return false;
    if (!(edge_forward_ < 1.0 && edge_reverse_ < 1.0)) return false;
    if (!tabulated_) return true;
    if (detail::interpolate(chain, 0.0) != 0.0) return false;
    for (int i = 1; i < chain.n_table; ++i) {
      const double below = chain.table_thrust[i - 1];
      const double above = chain.table_thrust[i];
      if (above < below || (above == below && above != 0.0)) return false;
    }
    return true;
  }

 private:
  void edges_of_table(const Chain& chain) {
    edge_forward_ = 0.0;
    edge_reverse_ = 0.0;
    for (int i = 0; i < chain.n_table; ++i) {
      if (chain.table_thrust[i] != 0.0) continue;
      edge_forward_ = std::max(edge_forward_, chain.table_command[i]);
      edge_reverse_ = std::max(edge_reverse_, -chain.table_command[i]);
    }
  }

  static double from_table(const Chain& chain, double thrust) {
    const double* begin = chain.table_thrust;
    const double* end = begin + chain.n_table;
    const auto above = std::lower_bound(begin, end, thrust) - begin;
    if (above == 0) return chain.table_command[0];
    if (above == chain.n_table) return chain.table_command[chain.n_table - 1];
    // the point itself: past a dead zone's far edge, not at its near one
    const double below_thrust = chain.table_thrust[above - 1];
    const double share = (thrust - below_thrust) / (chain.table_thrust[above] - below_thrust);
    const double below = chain.table_command[above - 1];
    return below + share * (chain.table_command[above] - below);
  }

  int k_ = 0;  // actuator
  double gain_ = 1.0;
  double ratio_ = 1.0;  // full reverse over full forward thrust
  double power_ = 1.0;
  double edge_forward_ = 0.0;
  double edge_reverse_ = 0.0;
  bool tabulated_ = false;
  bool straight_ = true;
};

}  // namespace seatrial
