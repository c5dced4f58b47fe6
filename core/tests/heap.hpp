// SPDX-License-Identifier: MIT
// Every allocation of the test program is counted, so that code that must not allocate can be
// watched.
#pragma once
#include <atomic>

extern std::atomic<long> allocations;
