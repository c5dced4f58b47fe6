// SPDX-License-Identifier: MIT
// Noise parameters between Python and the core: arrays (12,) in the order of NoiseParameters.
#pragma once
#include "arrays.hpp"
#include "seatrial/filter/noise_parameters.hpp"

namespace {

using namespace seatrial;

inline NoiseParameters make_noise(const double* from) {
  NoiseParameters noise;
  for (int i = 0; i < kNoiseParameters; ++i) noise.parameter(i) = from[i];
  return noise;
}

inline NoiseParameters make_noise(const Vector& row) {
  require(row.shape(0) == kNoiseParameters,
          "noise: 12 values expected: position, heading, random walks (2), disturbances (2), their "
          "time constant, coloured pose noise (2), its time constant and angular frequency, sway "
          "ratio");
  return make_noise(row.data());
}

inline Out1 noise_row(NoiseParameters noise) {
  double* out = nullptr;
  auto row = fresh<Out1>({std::size_t{kNoiseParameters}}, &out);
  for (int i = 0; i < kNoiseParameters; ++i) out[i] = noise.parameter(i);
  return row;
}

}  // namespace
