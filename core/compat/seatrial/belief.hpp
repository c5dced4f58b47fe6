// SPDX-License-Identifier: MIT
// The path of release 0.1. Include "seatrial/filter/ekf_predict.hpp" instead: this one goes after
// the next release.
#pragma once
#include "seatrial/filter/ekf_predict.hpp"
