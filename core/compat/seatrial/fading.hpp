// SPDX-License-Identifier: MIT
// The path of release 0.1. Include "seatrial/filter/gauss_markov.hpp" instead: this one goes after
// the next release.
#pragma once
#include "seatrial/filter/gauss_markov.hpp"
