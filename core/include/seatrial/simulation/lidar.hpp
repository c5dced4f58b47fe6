// SPDX-License-Identifier: MIT
// A scanning LiDAR, simulated: every beam has its own time, as the boat moves on during a turn of
// the mirror. Host only.
#pragma once
#include <vector>

#include "seatrial/model/frames.hpp"
#include "seatrial/simulation/random.hpp"
#include "seatrial/simulation/scene.hpp"

namespace seatrial {

/// By default like a SICK TiM571, with a third of its beams.
struct Lidar {
  double rate = 15.0;           // [Hz] turns of the mirror
  double field = 1.5 * kPi;     // [rad] from the first beam to the last, symmetric to forward
  int beams = 271;              //
  double nearest = 0.05;        // [m]
  double farthest = 25.0;       // [m] what is farther is not seen
  double noise = 0.02;          // [m] standard deviation, of each beam
  double bias = 0.0;            // [m] of all
  double mount[3] = {0, 0, 0};  // forward, left of the origin [m]; where it looks [rad]
};

inline constexpr int kMostBeams = 4096;

/// Why it is refused, in one line; null: it is not.
inline const char* fault(const Lidar& s) {
  if (!(s.rate > 0.0 && s.rate <= 200.0)) return "lidar: rate: expected up to 200 Hz";
  if (!(s.field > 0.0 && s.field <= 2.0 * kPi)) return "lidar: field: expected up to 2 pi rad";
  if (s.beams < 2 || s.beams > kMostBeams) return "lidar: beams: expected 2 to 4096";
  if (!(s.nearest >= 0.0 && s.farthest > s.nearest)) {
    return "lidar: nearest: expected from 0 m to farthest";
  }
  return s.noise >= 0.0 ? nullptr : "lidar: noise: expected 0 m or more";
}

/// Direction of a beam [rad] from where the sensor looks; the first is to starboard.
inline double beam_angle(const Lidar& s, int beam) {
  return s.field * (static_cast<double>(beam) / (s.beams - 1) - 0.5);
}

/// Time [s] from the first beam to the last.
inline double sweep(const Lidar& s) { return s.field / (2.0 * kPi * s.rate); }

/// Ranges (beams) [m] of a turn whose last beam is now: pose eta (3) and its rate (3), which is
/// taken to have been the same during the turn. Infinite: nothing is seen.
inline void scan(const Lidar& s, const Scene& scene, const double* eta, const double* eta_dot,
                 Random& random, std::vector<double>& ranges) {
  ranges.resize(static_cast<std::size_t>(s.beams));
  for (int k = 0; k < s.beams; ++k) {
    const double ago = sweep(s) * (1.0 - static_cast<double>(k) / (s.beams - 1));
    const double psi = eta[2] - ago * eta_dot[2];
    const double lever[3] = {s.mount[0], s.mount[1], 0.0};
    double arm[3];
    body_to_earth(psi, lever, arm);
    const double origin[2] = {eta[0] - ago * eta_dot[0] + arm[0],
                              eta[1] - ago * eta_dot[1] + arm[1]};
    double& found = ranges[static_cast<std::size_t>(k)];
    found = range(scene, origin, psi + s.mount[2] + beam_angle(s, k)) + s.bias +
            s.noise * random.normal();
    if (!(found >= s.nearest && found <= s.farthest)) found = detail::kNowhere;
  }
}

}  // namespace seatrial
