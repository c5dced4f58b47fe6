// SPDX-License-Identifier: MIT
// The path of release 0.1. Include "seatrial/filter/noise_parameters.hpp" instead: this one goes
// after the next release.
#pragma once
#include "seatrial/filter/noise_parameters.hpp"
#include "seatrial_old_names.hpp"
