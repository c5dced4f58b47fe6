// SPDX-License-Identifier: MIT
// The path of release 0.1. Include "seatrial/onboard/onboard_filter.hpp" instead: this one goes
// after the next release.
#pragma once
#include "seatrial/onboard/onboard_filter.hpp"
#include "seatrial_old_names.hpp"
