// SPDX-License-Identifier: MIT
// The path of release 0.1. Include "seatrial/integration/thrust_trace.hpp" instead: this one goes
// after the next release.
#pragma once
#include "seatrial/integration/thrust_trace.hpp"
#include "seatrial_old_names.hpp"
