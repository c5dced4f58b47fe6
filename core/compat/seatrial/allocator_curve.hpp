// SPDX-License-Identifier: MIT
// The path of release 0.1. Include "seatrial/control/allocator_curve.hpp" instead: this one goes
// after the next release.
#pragma once
#include "seatrial/control/allocator_curve.hpp"
