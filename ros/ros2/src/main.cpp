// SPDX-License-Identifier: MIT
// A node as a program of its own: SEATRIAL_NODE is its name.
#include "run.hpp"

int main(int argc, char** argv) { return seatrial_odometry::run(SEATRIAL_NODE, argc, argv); }
