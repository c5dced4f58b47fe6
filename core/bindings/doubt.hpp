// SPDX-License-Identifier: MIT
// Python's view of what a model's covariance amounts to on board.
#pragma once
#include <nanobind/stl/tuple.h>

#include <tuple>
#include <utility>

#include "arrays.hpp"
#include "predictor.hpp"
#include "seatrial/doubt.hpp"

namespace {

using namespace seatrial;

/// disturbance, memory, walk.
std::tuple<Out1, Out1, Out1> run_doubt(const Boat& boat, const Chain& chain, Vector q,
                                       Matrix speeds, Matrix covariance) {
  require(boat.structure.n_forces == chain.n_forces, "structure and chain differ in forces");
  require(static_cast<int>(q.shape(0)) == chain.n_constants, "one value for each chain constant");
  UncertainModel m;
  m.boat = boat;
  m.chain = chain;
  std::copy(q.data(), q.data() + chain.n_constants, m.q);
  make_ranges(speeds, kAxes, m.speed);
  const auto n = static_cast<std::size_t>(m.n_parameters());
  require(covariance.shape(0) == n && covariance.shape(1) == n,
          "covariance: one row and column a coefficient and constant");
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < n; ++j) m.covariance[i][j] = covariance(i, j);
  }
  Doubt found;
  {
    nb::gil_scoped_release released;
    found = doubt(m);
  }
  return {row_of(found.disturbance), row_of(found.memory), row_of(found.walk)};
}

/// Noise (10,) in the order of MotionNoise.
Out1 run_believed_noise(Vector own, Vector disturbance, Vector memory, Vector walk) {
  Doubt d;
  for (const auto& [from, to] : {std::pair{&disturbance, d.disturbance},
                                 std::pair{&memory, d.memory}, std::pair{&walk, d.walk}}) {
    require(from->shape(0) == kAxes, "disturbance, memory, walk: 3 each");
    std::copy(from->data(), from->data() + kAxes, to);
  }
  const MotionNoise n = believed_noise(make_noise(own), d);
  const double row[10] = {n.position,           n.heading,         n.walk_linear, n.walk_yaw,
                          n.disturbance_linear, n.disturbance_yaw, n.memory,      n.colour_position,
                          n.colour_heading,     n.colour_memory};
  return row_of(row);
}

void bind_doubt(nb::module_& m) {
  using namespace nb::literals;
  m.def("doubt", &run_doubt, "boat"_a, "chain"_a, "q"_a, "speeds"_a, "covariance"_a);
  m.def("believed_noise", &run_believed_noise, "own"_a, "disturbance"_a, "memory"_a, "walk"_a);
}

}  // namespace
