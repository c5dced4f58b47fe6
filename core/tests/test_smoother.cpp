// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include "filter_run.hpp"
#include "seatrial/filter/lookahead.hpp"
#include "seatrial/filter/smoother.hpp"

using namespace seatrial;
using namespace problems;

namespace {

SmootherRun smooth(const Run& run, const FilterRun& first, const NoiseParameters& noise) {
  return smoothed(first, run.poses(), noise, kNever, run.start);
}

}  // namespace

TEST_CASE("the last smoothed state is the filter's, and those before are better known") {
  for (const NoiseParameters& noise : {kWhite, kColoured, kOscillating}) {
    const Run run = mallard_run();
    const FilterRun first = run.pass(noise);
    const SmootherRun found = smooth(run, first, noise);
    const std::size_t last = run.use.size() - 1;
    for (std::size_t i = 0; i < kFilterStates; ++i) {
      CHECK(found.state[last * kFilterStates + i] ==
            doctest::Approx(first.state[last * kFilterStates + i]).epsilon(1e-9));
    }
    for (std::size_t k = 0; k < last; ++k) {
      for (std::size_t axis = 0; axis < kAxes; ++axis) {
        const std::size_t at = k * kAxes + axis;
        CHECK(found.deviation[at] > 0.0F);
        CHECK(found.deviation[at] < 1.00001F * first.deviation[at]);
      }
    }
  }
}

TEST_CASE("poses act on each other's smoothed poses alike, by their noise") {
  // d smoothed k / d measured j = covariance of both / variance of the measurement
  const Run run = mallard_run();
  const FilterRun first = run.pass(kWhite);
  const SmootherRun before = smooth(run, first, kWhite);
  const std::size_t pairs[][4] = {{20, 0, 27, 0}, {20, 0, 22, 1}, {30, 2, 21, 0}, {40, 1, 25, 2}};
  for (const auto& [j, a, k, b] : pairs) {
    double effect[2];
    for (const bool there : {true, false}) {
      Run moved = mallard_run();
      const std::size_t pose = there ? j : k;
      const std::size_t axis = there ? a : b;
      REQUIRE(run.use[pose] == 1);
      moved.eta[pose * kPose + axis] += 1e-3;
      const SmootherRun after = smooth(moved, first, kWhite);
      const std::size_t seen = there ? k * kFilterStates + b : j * kFilterStates + a;
      const double variance = kWhite.white_variance(static_cast<int>(axis));
      effect[there ? 0 : 1] = (after.state[seen] - before.state[seen]) * variance;
    }
    CHECK(effect[0] == doctest::Approx(effect[1]).epsilon(1e-4));
    CHECK(effect[0] != 0.0);
  }
}

TEST_CASE("coloured pose noise of nearly zero variance is smoothed as none is") {
  NoiseParameters noise = kWhite;
  const Run run = mallard_run();
  const FilterRun first = run.pass(noise);
  const SmootherRun none = smooth(run, first, noise);
  noise.colour_position = noise.colour_heading = 1.001 * kNoColour;
  const SmootherRun hardly = smooth(run, first, noise);
  noise.colour_turn = 4.0;
  const SmootherRun swing = smooth(run, first, noise);
  for (std::size_t i = 0; i < none.deviation.size(); ++i) {
    CHECK(hardly.deviation[i] == doctest::Approx(none.deviation[i]).epsilon(1e-5));
    CHECK(swing.deviation[i] == doctest::Approx(none.deviation[i]).epsilon(1e-5));
  }
}

TEST_CASE("a prediction that has just begun is as uncertain as the filter, and then more so") {
  const Run run = mallard_run();
  const FilterRun first = run.pass(kWhite);
  const std::vector<int> from{10, 10, 10, 30};
  const std::vector<int> to{10, 15, 25, 31};
  const auto variance = [&](bool disturbed) {
    return lookahead_variance(first, run.poses(), kWhite, kNever, run.start, from, to, disturbed);
  };
  constexpr std::size_t kFar = std::size_t{2} * kAxes;  // the third prediction
  const std::vector<double> alone = variance(false);
  const std::vector<double> with = variance(true);
  REQUIRE(alone.size() == from.size() * kAxes);
  for (std::size_t axis = 0; axis < kAxes; ++axis) {
    const double own = first.deviation[std::size_t{10} * kAxes + axis];
    for (const std::vector<double>& found : {alone, with}) {
      CHECK(found[axis] == doctest::Approx(own * own).epsilon(1e-4));
      CHECK(found[kAxes + axis] > found[axis]);
    }
    CHECK(with[kFar + axis] < alone[kFar + axis]);  // what is known of the disturbance
  }
}
