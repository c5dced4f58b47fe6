// SPDX-License-Identifier: MIT
// Surfaces in the plane: where a ray ends, and how far a point is from each. Host only.
#pragma once
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "seatrial/model/frames.hpp"

namespace seatrial {

/// A straight surface from one end to the other [m].
struct Segment {
  double begin[2];
  double end[2];
};

/// A round one.
struct Circle {
  double centre[2];  // [m]
  double radius;     // [m]
};

/// Walls, boxes and posts; earth-fixed.
struct Scene {
  std::vector<Segment> segments;
  std::vector<Circle> circles;
};

/// The sides of a box around a centre (2), turned by `turn` [rad]; one after the other.
inline void box(const double* centre, double length, double width, double turn, Segment* sides) {
  static constexpr double kCorner[4][2] = {{-0.5, -0.5}, {0.5, -0.5}, {0.5, 0.5}, {-0.5, 0.5}};
  double corner[4][2];
  for (int i = 0; i < 4; ++i) {
    const double off[3] = {length * kCorner[i][0], width * kCorner[i][1], 0.0};
    double turned[3];
    body_to_earth(turn, off, turned);
    for (int a = 0; a < 2; ++a) corner[i][a] = centre[a] + turned[a];
  }
  for (int i = 0; i < 4; ++i) {
    std::copy(corner[i], corner[i] + 2, sides[i].begin);
    std::copy(corner[(i + 1) % 4], corner[(i + 1) % 4] + 2, sides[i].end);
  }
}

/// How far a surface is from a point, and which way leads away from it.
struct Clearance {
  double distance = 0.0;    // [m]
  double away[2] = {0, 0};  // unit vector from the surface to the point
};

namespace detail {

inline constexpr double kNowhere = std::numeric_limits<double>::infinity();

inline double cross(const double* a, const double* b) { return a[0] * b[1] - a[1] * b[0]; }

/// Along a unit vector, by Cramer's rule: origin + distance ray = begin + share edge.
inline double ray_to(const Segment& s, const double* origin, const double* ray) {
  const double edge[2] = {s.end[0] - s.begin[0], s.end[1] - s.begin[1]};
  const double off[2] = {s.begin[0] - origin[0], s.begin[1] - origin[1]};
  const double turn = cross(ray, edge);
  if (turn == 0.0) return kNowhere;  // parallel
  const double distance = cross(off, edge) / turn;
  const double share = cross(off, ray) / turn;
  const bool meets = distance > 0.0 && share >= 0.0 && share <= 1.0;
  if (!meets) return kNowhere;
  return distance;
}

/// The nearer intersection; from within there is none.
inline double ray_to(const Circle& c, const double* origin, const double* ray) {
  const double off[2] = {c.centre[0] - origin[0], c.centre[1] - origin[1]};
  const double aside = cross(off, ray);
  const double square = c.radius * c.radius - aside * aside;
  if (square < 0.0) return kNowhere;
  const double distance = off[0] * ray[0] + off[1] * ray[1] - std::sqrt(square);
  if (!(distance > 0.0)) return kNowhere;
  return distance;
}

/// From a point of the surface to a point off it; `side` where both are one.
inline Clearance between(const double* surface, const double* point, const double* side) {
  const double off[2] = {point[0] - surface[0], point[1] - surface[1]};
  Clearance c;
  c.distance = std::hypot(off[0], off[1]);
  for (int i = 0; i < 2; ++i) c.away[i] = c.distance > 0.0 ? off[i] / c.distance : side[i];
  return c;
}

}  // namespace detail

/// Distance [m] from origin (2) along `angle` [rad] to the first surface; infinite: none.
inline double range(const Scene& scene, const double* origin, double angle) {
  const double ray[2] = {std::cos(angle), std::sin(angle)};
  double nearest = detail::kNowhere;
  for (const Segment& s : scene.segments) {
    nearest = std::min(nearest, detail::ray_to(s, origin, ray));
  }
  for (const Circle& c : scene.circles) {
    nearest = std::min(nearest, detail::ray_to(c, origin, ray));
  }
  return nearest;
}

/// Of a point (2) from a straight surface.
inline Clearance clearance(const Segment& s, const double* point) {
  const double edge[2] = {s.end[0] - s.begin[0], s.end[1] - s.begin[1]};
  const double off[2] = {point[0] - s.begin[0], point[1] - s.begin[1]};
  const double square = edge[0] * edge[0] + edge[1] * edge[1];
  const double along = square > 0.0 ? (off[0] * edge[0] + off[1] * edge[1]) / square : 0.0;
  const double share = std::clamp(along, 0.0, 1.0);
  const double nearest[2] = {s.begin[0] + share * edge[0], s.begin[1] + share * edge[1]};
  const double length = std::sqrt(square);
  const double side[2] = {length > 0.0 ? -edge[1] / length : 1.0,
                          length > 0.0 ? edge[0] / length : 0.0};
  return detail::between(nearest, point, side);
}

/// Of a point (2) from a round one; from within, too.
inline Clearance clearance(const Circle& c, const double* point) {
  const double side[2] = {1.0, 0.0};
  Clearance found = detail::between(c.centre, point, side);
  const bool inside = found.distance < c.radius;
  found.distance = std::abs(found.distance - c.radius);
  if (inside) {
    for (double& part : found.away) part = -part;
  }
  return found;
}

/// Distance [m] from a point (2) to the nearest surface; infinite: there is none.
inline double distance(const Scene& scene, const double* point) {
  double nearest = detail::kNowhere;
  for (const Segment& s : scene.segments) {
    nearest = std::min(nearest, clearance(s, point).distance);
  }
  for (const Circle& c : scene.circles) {
    nearest = std::min(nearest, clearance(c, point).distance);
  }
  return nearest;
}

}  // namespace seatrial
