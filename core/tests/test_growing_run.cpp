// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <memory>
#include <vector>

#include "filter_run.hpp"
#include "seatrial/filter/growing_run.hpp"

using namespace seatrial;
using namespace problems;

namespace {

constexpr double kOutlier = 3.0;  // [sigma]

/// Poses `first` to `last` - 1 of a run, on the same clock.
PoseSeries part(const PoseSeries& whole, int first, int last) {
  PoseSeries out = whole;
  out.n = last - first;
  out.time += first;
  out.eta += static_cast<std::ptrdiff_t>(first) * kPose;
  out.use += first;
  if (out.velocity != nullptr) out.velocity += static_cast<std::ptrdiff_t>(first) * kAxes;
  return out;
}

std::unique_ptr<GrowingRun> begun(const Run& run, const NoiseParameters& noise,
                                  const Effects& effects, bool slopes, const PoseSeries& poses) {
  return growing_run(run.problem.boat, run.problem.trace().columns(), noise, kOutlier, run.start,
                     effects, poses.position_delay, slopes);
}

void check_same(const GrowingRun& parts, const FilterRun& whole) {
  const FilterRun sums = parts.sums();
  REQUIRE(parts.good());
  CHECK(sums.cost == whole.cost);
  CHECK(sums.gradient == whole.gradient);
  CHECK(sums.information == whole.information);
  const auto last = whole.state.end() - kFilterStates;
  CHECK(std::equal(last, whole.state.end(), parts.state()));
}

}  // namespace

TEST_CASE("a run in parts has the sums of the whole, to the last bit") {
  const Run run = mallard_run();
  const PoseSeries poses = run.poses();
  for (const NoiseParameters& noise : {kWhite, kColoured, kOscillating}) {
    for (const bool slopes : {false, true}) {
      Effects effects;
      effects.lever[0] = 0.1;
      effects.current[1] = 0.02;
      const FilterRun whole = innovations(run.problem.boat, run.problem.trace(), poses, noise,
                                          kOutlier, run.start, effects, slopes);
      const auto parts = begun(run, noise, effects, slopes, poses);
      const int overlap = 5;
      for (int from = 0, to = 40; from < poses.n; from = to, to += 40) {
        const int end = std::min(poses.n, to);
        const PoseSeries now = part(poses, std::max(0, from - overlap), end);
        parts->advance(run.problem.trace(), now, poses.time[end - 1]);
      }
      check_same(*parts, whole);
    }
  }
}

TEST_CASE("with a delay the later half of a pose waits for its time") {
  const Run run = mallard_run();
  PoseSeries poses = run.poses();
  poses.position_delay = 0.08;
  const FilterRun whole = innovations(run.problem.boat, run.problem.trace(), poses, kWhite,
                                      kOutlier, run.start, {}, true);
  const auto parts = begun(run, kWhite, {}, true, poses);
  for (int i = 0; 0.37 * i < poses.time[poses.n - 1] + 1.0; ++i) {
    parts->advance(run.problem.trace(), poses, 0.3 + 0.37 * i);
  }
  check_same(*parts, whole);
}

TEST_CASE("gaps, jumps and restarts are those of the whole") {
  Run run = mallard_run();
  run.use[30] = kGapped;
  run.use[60] = kJumped;
  run.use[80] = kBeginning;
  std::vector<double> velocity(run.use.size() * kAxes, 0.01);
  PoseSeries poses = run.poses();
  poses.velocity = velocity.data();
  const FilterRun whole =
      innovations(run.problem.boat, run.problem.trace(), poses, kWhite, kOutlier, run.start);
  const auto parts = begun(run, kWhite, {}, false, poses);
  for (const int to : {30, 31, 60, 61, 80, 81, poses.n}) {
    parts->advance(run.problem.trace(), poses, poses.time[to - 1]);
  }
  check_same(*parts, whole);
}

TEST_CASE("nothing new changes nothing, and memory does not grow") {
  const Run run = mallard_run();
  const PoseSeries poses = run.poses();
  const auto parts = begun(run, kWhite, {}, false, poses);
  parts->advance(run.problem.trace(), poses, poses.time[50]);
  const double cost = parts->sums().cost;
  CHECK(parts->advance(run.problem.trace(), poses, poses.time[50]));
  CHECK(parts->advance(run.problem.trace(), poses, poses.time[20]));
  CHECK(parts->sums().cost == cost);
  CHECK(parts->time() == poses.time[50]);
  parts->advance(run.problem.trace(), poses, poses.time[poses.n - 1]);
  const FilterRun sums = parts->sums();
  CHECK(sums.state.empty());
  CHECK(sums.innovation.empty());
  CHECK(sums.transition.empty());
  CHECK(sums.score.size() == static_cast<std::size_t>(sums.parameters));
}

TEST_CASE("a boat that diverges says so, and stays so") {
  Run run = mallard_run();
  for (int i = 0; i < run.problem.boat.structure.n_coefficients - kAxes; ++i) {
    run.problem.boat.coefficient[i] = 1e6;
  }
  const PoseSeries poses = run.poses();
  const auto parts = begun(run, kWhite, {}, false, poses);
  CHECK_FALSE(parts->advance(run.problem.trace(), poses, poses.time[poses.n - 1]));
  CHECK_FALSE(parts->advance(run.problem.trace(), poses, poses.time[poses.n - 1] + 1.0));
  CHECK_FALSE(parts->sums().good);
}
