// SPDX-License-Identifier: MIT
// The path of release 0.1. Include "seatrial/filter/matrix3.hpp" instead: this one goes after the
// next release.
#pragma once
#include "seatrial/filter/matrix3.hpp"
