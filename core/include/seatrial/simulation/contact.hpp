// SPDX-License-Identifier: MIT
// A hull that touches: a disc round the boat's origin. What it touches pushes it out along the
// normal and takes the velocity into it, but for a share that bounces back; no friction, no moment.
#pragma once
#include "seatrial/model/frames.hpp"
#include "seatrial/simulation/scene.hpp"

namespace seatrial {

inline constexpr double kBounce = 0.3;  // share of the normal velocity that comes back

/// A boat's place and velocity over ground while contacts are solved.
struct Hull {
  double place[2];     // [m] earth-fixed
  double velocity[2];  // [m/s] over ground, earth-fixed
  double radius;       // [m]
};

namespace detail {

inline double inner(const double* a, const double* b) { return a[0] * b[0] + a[1] * b[1]; }

/// Out of the surface, and no longer into it.
inline bool push(Hull& hull, const Clearance& found) {
  const double deep = hull.radius - found.distance;
  if (!(deep > 0.0)) return false;
  const double into = std::min(0.0, inner(hull.velocity, found.away));
  for (int i = 0; i < 2; ++i) {
    hull.place[i] += deep * found.away[i];
    hull.velocity[i] -= (1.0 + kBounce) * into * found.away[i];
  }
  return true;
}

}  // namespace detail

/// Against everything in the scene. True where something was touched.
inline bool touch(const Scene& scene, Hull& hull) {
  bool touched = false;
  for (const Segment& s : scene.segments) {
    touched = detail::push(hull, clearance(s, hull.place)) || touched;
  }
  for (const Circle& c : scene.circles) {
    touched = detail::push(hull, clearance(c, hull.place)) || touched;
  }
  return touched;
}

/// Two boats of equal mass (a model per unit mass knows no other).
inline bool touch(Hull& a, Hull& b) {
  const double side[2] = {1.0, 0.0};
  const Clearance apart = detail::between(b.place, a.place, side);
  const double deep = a.radius + b.radius - apart.distance;
  if (!(deep > 0.0)) return false;
  const double relative[2] = {a.velocity[0] - b.velocity[0], a.velocity[1] - b.velocity[1]};
  const double into = std::min(0.0, detail::inner(relative, apart.away));
  for (int i = 0; i < 2; ++i) {
    const double shift = 0.5 * deep * apart.away[i];
    const double impulse = -0.5 * (1.0 + kBounce) * into * apart.away[i];
    a.place[i] += shift;
    b.place[i] -= shift;
    a.velocity[i] += impulse;
    b.velocity[i] -= impulse;
  }
  return true;
}

}  // namespace seatrial
