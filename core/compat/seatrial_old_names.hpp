// SPDX-License-Identifier: MIT
// Type names of release 0.1, for programs that include its paths; they go with these.
#pragma once

namespace seatrial {

struct NoiseParameters;
using MotionNoise = NoiseParameters;
using FilterNoise = NoiseParameters;
struct OnboardBoat;
using DrivenBoat = OnboardBoat;
struct StateEstimate;
using Belief = StateEstimate;
struct PrincipalErrors;
using Considered = PrincipalErrors;
class OdomIntegrator;
using Way = OdomIntegrator;
class ThrustTrace;
using Trace = ThrustTrace;
class StepSchedule;
using Schedule = StepSchedule;
struct FilterRun;
using FilterPass = FilterRun;

}  // namespace seatrial
