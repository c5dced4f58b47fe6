// SPDX-License-Identifier: MIT
// The path of release 0.1. Include "seatrial/filter/schmidt_kalman.hpp" instead: this one goes
// after the next release.
#pragma once
#include "seatrial/filter/schmidt_kalman.hpp"
#include "seatrial_old_names.hpp"
