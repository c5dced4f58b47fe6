// SPDX-License-Identifier: MIT
// The path of release 0.1. Include "seatrial/filter/innovations.hpp" or what else you need of
// "seatrial/filter" instead: this one goes after the next release.
#pragma once
#include "seatrial/filter/noise_derivatives.hpp"
#include "seatrial_old_names.hpp"
