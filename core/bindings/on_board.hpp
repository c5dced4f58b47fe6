// SPDX-License-Identifier: MIT
// What runs on the boat, and its simulators: a file of its own, so that both halves compile at
// once.
#pragma once
#include <nanobind/nanobind.h>

/// Predictor, odometer, allocator, tracking controller, simulator and mimic.
void bind_on_board(nanobind::module_& m);
