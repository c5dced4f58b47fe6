// SPDX-License-Identifier: MIT
// The path of release 0.1. Include "seatrial/onboard/out_of_sequence.hpp" instead: this one goes
// after the next release.
#pragma once
#include "seatrial/onboard/out_of_sequence.hpp"
#include "seatrial_old_names.hpp"
