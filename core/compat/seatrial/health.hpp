// SPDX-License-Identifier: MIT
// The path of release 0.1. Include "seatrial/onboard/health.hpp" instead: this one goes after the
// next release.
#pragma once
#include "seatrial/onboard/health.hpp"
