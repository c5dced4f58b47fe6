// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <algorithm>
#include <utility>

#include "boats.hpp"
#include "filter_run.hpp"

using namespace seatrial;
using namespace problems;

namespace {

/// Poses without noise whose positions and headings are `late` [s] older than their stamps.
struct LateRun {
  Run run = mallard_run();
  double late[2];

  LateRun(double position, double heading) : late{position, heading} {
    Problem& p = run.problem;
    const std::vector<double> all = p.time;
    const std::size_t first = 6;  // the boat's motion is known before it
    std::vector<double> state[2];
    for (int part = 0; part < 2; ++part) {
      p.time.assign(1, all[0]);
      for (std::size_t k = first; k < all.size(); ++k) p.time.push_back(all[k] - late[part]);
      state[part] = problems::simulated(p, nullptr);
    }
    p.time.assign(all.begin() + first, all.end());
    run.eta.clear();
    for (std::size_t k = 1; k <= p.time.size(); ++k) {
      run.eta.insert(run.eta.end(),
                     {state[0][k * kStates], state[0][k * kStates + 1], state[1][k * kStates + 2]});
    }
    run.use.assign(p.time.size(), kMeasured);
    run.use[40] = kNotMeasured;
    std::copy(run.eta.begin(), run.eta.begin() + std::ptrdiff_t{kPose}, run.start.state);
    for (int i = kPose; i < kStates; ++i) run.start.state[i] = state[0][kStates + i];
  }

  Effects effects() const {
    Effects e;
    e.position_delay = late[0];
    e.heading_delay = late[1];
    return e;
  }

  FilterRun pass(const Effects& effects, const NoiseParameters& noise) const {
    const Problem& p = run.problem;
    return innovations(p.boat, p.trace(), run.poses(), noise, kNever, run.start, effects, true);
  }

  /// The largest innovation [m, rad] after the first second.
  double worst(const FilterRun& pass) const {
    double most = 0.0;
    for (std::size_t i = 15 * std::size_t{kPose}; i < pass.innovation.size(); ++i) {
      if (run.use[i / kPose] != kNotMeasured) most = std::max(most, std::abs(pass.innovation[i]));
    }
    return most;
  }
};

}  // namespace

TEST_CASE("positions and headings of two times are predicted each at its own") {
  for (const auto& [position, heading] :
       {std::pair{0.2, 0.0}, {0.0, 0.2}, {0.15, 0.15}, {0.1, 0.23}, {-0.1, 0.05}}) {
    const LateRun late(position, heading);
    for (const NoiseParameters& noise : {kWhite, kColoured, kOscillating}) {
      const FilterRun right = late.pass(late.effects(), noise);
      REQUIRE(right.good);
      CHECK(late.worst(right) < 2e-4);
      CHECK(late.worst(late.pass({}, noise)) > 4e-3);
      // what is known of the series and what is an effect add up
      const Problem& p = late.run.problem;
      PoseSeries poses = late.run.poses();
      poses.position_delay = position - heading;
      Effects rest;
      rest.position_delay = rest.heading_delay = heading;
      const FilterRun known =
          innovations(p.boat, p.trace(), poses, noise, kNever, late.run.start, rest, true);
      CHECK(known.cost == doctest::Approx(right.cost));
      // the same run again, on its linearisation
      CHECK(repeated(right, late.run.poses(), noise, kNever, late.run.start) ==
            doctest::Approx(right.cost).epsilon(1e-6));
      const auto directions = problems::logarithmic_directions(noise);
      CHECK(noise_slopes(right, late.run.poses(), noise, directions, kNever, late.run.start).cost ==
            doctest::Approx(right.cost).epsilon(1e-6));
    }
  }
}

TEST_CASE("a step of the delays on the linearisation is nearly that of a run") {
  for (const auto& [position, heading] : {std::pair{0.0, 0.0}, {0.2, 0.0}, {0.0, 0.2}}) {
    const LateRun late(position, heading);
    const FilterRun first = late.pass(late.effects(), kWhite);
    for (int part = 0; part < 2; ++part) {
      std::vector<double> step(static_cast<std::size_t>(first.parameters), 0.0);
      step[step.size() - 2 + static_cast<std::size_t>(part)] = 0.02;
      Effects moved = late.effects();
      (part == 0 ? moved.position_delay : moved.heading_delay) += 0.02;
      const double want = late.pass(moved, kWhite).cost - first.cost;
      REQUIRE(want > 1.0);
      const PoseSeries poses = late.run.poses();
      const double got =
          repeated(first, poses, kWhite, kNever, late.run.start, step.data(), true) - first.cost;
      CHECK(got == doctest::Approx(want).epsilon(0.25));
      CHECK(relinearised(first, poses, kWhite, kNever, late.run.start, step.data(), true).cost ==
            doctest::Approx(first.cost + got));
    }
  }
}

TEST_CASE("a jump for good of late positions is followed, whatever the heading's delay") {
  for (const auto& [position, heading] : {std::pair{0.2, 0.0}, {0.0, 0.2}}) {
    LateRun late(position, heading);
    for (std::size_t k = 50; k < late.run.use.size(); ++k) late.run.eta[3 * k] += 0.4;
    for (const Use use : {kJumped, kGapped}) {
      late.run.use[50] = use;
      const FilterRun pass = late.pass(late.effects(), kWhite);
      REQUIRE(pass.good);
      CHECK(std::abs(pass.innovation[kPose * 50 + 2]) < 1e-3);  // the heading did not jump
      for (std::size_t k = 51; k < 60; ++k) CHECK(std::abs(pass.innovation[kPose * k]) < 5e-3);
    }
  }
}

TEST_CASE("delays bend the cost as the information says") {
  NoiseParameters calm = kWhite;  // so that the times of updates do not bend the determinant, too
  calm.walk_linear = calm.walk_yaw = calm.disturbance_linear = calm.disturbance_yaw = 1e-8;
  for (const auto& [position, heading] : {std::pair{0.2, 0.0}, {0.0, 0.2}, {0.1, 0.23}}) {
    const LateRun late(position, heading);
    Effects at = late.effects();
    const FilterRun here = late.pass(at, calm);
    const int own = here.parameters - kEffects;
    const double step = 1e-4;
    double* const moved[2] = {&at.position_delay, &at.heading_delay};
    for (int i = 0; i < 2; ++i) {
      double sum = -2.0 * here.cost;
      for (const double d : {step, -step}) {
        *moved[i] += d;
        sum += late.pass(at, calm).cost;
        *moved[i] -= d;
      }
      const auto entry = static_cast<std::size_t>((own + kDelay + i) * (here.parameters + 1));
      CHECK(0.5 * sum / (step * step) == doctest::Approx(here.information[entry]).epsilon(0.03));
    }
  }
}
