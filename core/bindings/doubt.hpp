// SPDX-License-Identifier: MIT
// Python's view of what a model's covariance amounts to on board.
#pragma once
#include <nanobind/stl/pair.h>

#include <utility>

#include "arrays.hpp"
#include "predictor.hpp"
#include "seatrial/doubt.hpp"
#include "seatrial/schedule.hpp"

namespace {

using namespace seatrial;

/// disturbance, walk.
std::pair<Out1, Out1> run_doubt(const Boat& boat, const Chain& chain, Vector q, Matrix speeds,
                                Matrix covariance) {
  require(boat.structure.n_forces == chain.n_forces, "structure and chain differ in forces");
  require(static_cast<int>(q.shape(0)) == chain.n_constants, "one value for each chain constant");
  require(speeds.shape(0) == kAxes && speeds.shape(1) == 2, "speeds: 3 x 2");
  UncertainModel m;
  m.structure = boat.structure;
  std::copy(boat.coefficient, boat.coefficient + kMaxCoefficients, m.coefficient);
  m.chain = chain;
  std::copy(q.data(), q.data() + chain.n_constants, m.q);
  std::copy(speeds.data(), speeds.data() + std::ptrdiff_t{2} * kAxes, &m.speed[0][0]);
  const auto n = static_cast<std::size_t>(m.n_parameters());
  require(covariance.shape(0) == n && covariance.shape(1) == n,
          "covariance: one row and column a coefficient and constant");
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < n; ++j) m.covariance[i][j] = covariance(i, j);
  }
  const Doubt found = doubt(m);
  return {row(found.disturbance), row(found.walk)};
}

/// Noise (10,) in the order of MotionNoise.
Out1 run_believed_noise(Vector own, Vector disturbance, Vector walk) {
  require(disturbance.shape(0) == kAxes && walk.shape(0) == kAxes, "disturbance: 3, walk: 3");
  Doubt d;
  std::copy(disturbance.data(), disturbance.data() + kAxes, d.disturbance);
  std::copy(walk.data(), walk.data() + kAxes, d.walk);
  const MotionNoise n = believed_noise(make_noise(own), d);
  const double all[10] = {n.position,           n.heading,         n.walk_linear, n.walk_yaw,
                          n.disturbance_linear, n.disturbance_yaw, n.memory,      n.colour_position,
                          n.colour_heading,     n.colour_memory};
  return row(all);
}

void bind_doubt(nb::module_& m) {
  using namespace nb::literals;
  m.def("doubt", &run_doubt, "boat"_a, "chain"_a, "q"_a, "speeds"_a, "covariance"_a);
  m.def("believed_noise", &run_believed_noise, "own"_a, "disturbance"_a, "walk"_a);
}

}  // namespace
