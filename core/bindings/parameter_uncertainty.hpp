// SPDX-License-Identifier: MIT
// Python's view of what the on-board filter believes of a model.
#pragma once
#include <nanobind/stl/pair.h>

#include <utility>

#include "arrays.hpp"
#include "predictor.hpp"
#include "seatrial/onboard/parameter_uncertainty.hpp"

namespace {

using namespace seatrial;

/// Noise (12,) in the order of NoiseParameters; errors (coefficients and constants, causes).
std::pair<Out1, Out2> run_onboard_uncertainty(const Boat& boat, const Chain& chain, Vector q,
                                              Matrix speeds, Matrix covariance, Vector noise,
                                              bool explained) {
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
  OnboardBoat believed;
  const NoiseParameters own = make_noise(noise);
  {
    nb::gil_scoped_release released;
    set_uncertainty(m, own, explained, believed);
  }
  const PrincipalErrors& found = believed.considered;
  double* out = nullptr;
  auto to = fresh<Out2>({n, static_cast<std::size_t>(found.n)}, &out);
  const int first = boat.structure.n_coefficients;
  for (int i = 0; i < m.n_parameters(); ++i) {
    const Loadings& causes = i < first ? found.coefficient[i] : found.constant[i - first];
    out = std::copy(causes, causes + found.n, out);
  }
  return {noise_row(believed.noise), to};
}

void bind_parameter_uncertainty(nb::module_& m) {
  using namespace nb::literals;
  m.def("onboard_uncertainty", &run_onboard_uncertainty, "boat"_a, "chain"_a, "q"_a, "speeds"_a,
        "covariance"_a, "noise"_a, "explained"_a);
}

}  // namespace
