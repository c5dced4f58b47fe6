// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <algorithm>

#include "boats.hpp"
#include "filter_run.hpp"

using namespace seatrial;
using boats::Worst;
using namespace problems;

namespace {

/// Where the heading is known, so that the covariance does not depend on the path.
constexpr NoiseParameters kStraight{2e-3, 1e-6, 5e-3, 1e-8, 3e-3, 1e-8, 2.0, 0.0, 0.0, 0.3, 0.0};
constexpr NoiseParameters kStraightColoured{2e-3, 1e-6, 5e-3, 1e-8, 3e-3, 1e-8,
                                            2.0,  3e-3, 1e-6, 0.3,  0.0};

/// A boat that goes straight on, under forces that are known: everything is linear.
Structure straight() {
  Structure s;
  s.n_forces = 3;
  boats::add(s, 0, 0, 1.0, {kU});
  boats::add(s, 0, 1, 1.0, {boats::kFu});
  return disturbed(s);
}

Run linear_run() {
  std::vector<double> coefficients{-0.8, 0.5, 0.0, 0.0, 0.0};
  Problem p = driven(straight(), coefficients, Scheme::kMoorePenrose, false);
  p.x0 = {0.3, -0.2, 0.0, 0.2, 0.0, 0.0};
  p.columns.n_coefficients = 0;  // the gain of F_u, and the disturbances
  for (const int c : {1, 2, 3, 4}) p.columns.coefficient[p.columns.n_coefficients++] = c;
  p.columns.n_constants = 0;
  Run run(std::move(p));
  for (std::size_t k = 0; k < run.use.size(); ++k) {  // only x is off: no error turns the boat
    run.eta[3 * k + 1] = run.start.state[1];
    run.eta[3 * k + 2] = 0.0;
  }
  return run;
}

}  // namespace

TEST_CASE("where all is linear the cost is the parabola that gradient and information say") {
  for (const NoiseParameters& noise : {kStraight, kStraightColoured}) {
    Run run = linear_run();
    run.problem.boat.coefficient[1] = 0.45;
    const FilterRun at = run.pass(noise);
    REQUIRE(at.good);
    for (const double step : {-0.1, 0.03, 0.2}) {
      run.problem.boat.coefficient[1] = 0.45 + step;
      const double want = at.cost - 2.0 * step * at.gradient[0] + step * step * at.information[0];
      CHECK(run.pass(noise).cost == doctest::Approx(want).epsilon(1e-7));
    }
    CHECK(std::abs(at.gradient[0]) > 1.0);  // it was not the minimum
  }
}

TEST_CASE("coloured pose noise of nearly zero variance costs what none does") {
  NoiseParameters noise = kWhite;
  const double none = mallard_run().pass(noise).cost;
  noise.colour_position = noise.colour_heading = 1.001 * kNoColour;
  const double hardly = mallard_run().pass(noise).cost;
  CHECK(hardly == doctest::Approx(none).epsilon(1e-9));
  CHECK(hardly != none);  // another filter
}

TEST_CASE("the gradient is the sum of its terms, pose by pose") {
  for (const NoiseParameters& noise : {kWhite, kColoured, kOscillating}) {
    const FilterRun pass = mallard_run().pass(noise);
    const auto p = static_cast<std::size_t>(pass.parameters);
    std::vector<double> sum(p, 0.0);
    for (std::size_t i = 0; i < pass.score.size(); ++i) sum[i % p] += pass.score[i];
    Worst worst;
    for (std::size_t i = 0; i < p; ++i) worst.see(sum[i], pass.gradient[i]);
    CHECK(worst.value() < 1e-6);
  }
}

TEST_CASE("the score of a block is the sum of its poses'") {
  const Run run = mallard_run();
  const Problem& p = run.problem;
  std::vector<int> block;
  for (std::size_t k = 0; k < p.time.size(); ++k) block.push_back(static_cast<int>(k / 20));
  const FilterRun each = run.pass(kWhite);
  const FilterRun sums = innovations(p.boat, p.trace(), run.poses(), kWhite, kNever, run.start, {},
                                     false, nullptr, block.data(), false);
  CHECK(sums.transition.empty());
  const auto wide = static_cast<std::size_t>(each.parameters);
  REQUIRE(sums.score.size() == (static_cast<std::size_t>(block.back()) + 1) * wide);
  std::vector<double> want(sums.score.size(), 0.0);
  for (std::size_t i = 0; i < each.score.size(); ++i) {
    want[static_cast<std::size_t>(block[i / wide]) * wide + i % wide] += each.score[i];
  }
  Worst worst;
  for (std::size_t i = 0; i < want.size(); ++i) worst.see(sums.score[i], want[i]);
  CHECK(worst.value() < 1e-9);
}

TEST_CASE("a run that is repeated with the same noise is the same") {
  const Run run = mallard_run();
  for (const NoiseParameters& noise : {kWhite, kColoured, kOscillating}) {
    const FilterRun first = run.pass(noise);
    const double again = repeated(first, run.poses(), noise, kNever, run.start);
    CHECK(again == doctest::Approx(first.cost).epsilon(1e-9));  // its slopes are stored short
  }
}

TEST_CASE("with other noise the repeated run is a full one where all is linear") {
  const Run run = linear_run();
  const FilterRun first = run.pass(kStraight);
  for (const int i : {0, 2, 4, 6, 7, 9}) {  // the others are of the heading
    NoiseParameters other = i < 7 ? kStraight : kStraightColoured;
    other.parameter(i) *= 3.0;
    const double again = repeated(first, run.poses(), other, kNever, run.start);
    CHECK(again == doctest::Approx(run.pass(other).cost).epsilon(1e-9));
    CHECK(std::abs(again - first.cost) > 1e-6);
  }
}

TEST_CASE("derivatives to the noise are the cost's differences") {
  const Run run = mallard_run();
  for (const NoiseParameters& noise : {kWhite, kColoured, kOscillating}) {
    const FilterRun first = run.pass(noise);
    const std::vector<NoiseDirection> directions = problems::logarithmic_directions(noise);
    const NoiseDerivatives slopes =
        noise_slopes(first, run.poses(), noise, directions, kNever, run.start);
    const auto cost = [&](int i, double logarithm) {
      NoiseParameters moved = noise;
      moved.parameter(i) *= std::exp(logarithm);
      return repeated(first, run.poses(), moved, kNever, run.start);
    };
    const double here = cost(0, 0.0);
    for (int i = 0; i < kNoiseParameters; ++i) {
      const double slope = (cost(i, 1e-4) - cost(i, -1e-4)) / 2e-4;
      const auto at = static_cast<std::size_t>(i);
      const double step = directions[at].step;
      const double information = slopes.information[at * (kNoiseParameters + 1)];
      const double bend = (cost(i, step) - 2.0 * here + cost(i, -step)) / (step * step);
      // a forward quotient with its second-order share taken off as it is expected to be
      const double want = 0.5 * slope + 0.5 * step * (0.5 * bend - information);
      CHECK(slopes.gradient[at] == doctest::Approx(want).epsilon(0.01).scale(1.0));
      CHECK(information >= 0.0);
    }
  }
}

TEST_CASE("a run relinearised where it was has its gradient, information and scores") {
  const Run run = mallard_run();
  for (const NoiseParameters& noise : {kWhite, kColoured, kOscillating}) {
    const FilterRun first = run.pass(noise);
    const FilterRun again = relinearised(first, run.poses(), noise, kNever, run.start);
    CHECK(again.cost == doctest::Approx(first.cost).epsilon(1e-9));
    Worst worst;
    const double gradient = *std::max_element(first.gradient.begin(), first.gradient.end());
    for (std::size_t i = 0; i < first.gradient.size(); ++i) {
      worst.see(again.gradient[i] / gradient, first.gradient[i] / gradient);
      const std::size_t own = i * (first.gradient.size() + 1);
      worst.see(again.information[own] / first.information[own], 1.0);
    }
    CHECK(worst.value() < 1e-4);  // the kept sensitivities are short
  }
}

TEST_CASE("after a small step of the parameters it is a full run of these parameters") {
  const Run run = mallard_run();
  const FilterRun first = run.pass(kWhite);
  const auto p = static_cast<std::size_t>(first.parameters);
  std::vector<double> step(p, 0.0);
  step[0] = 1e-4 * run.problem.boat.coefficient[0];
  const double there =
      relinearised(first, run.poses(), kWhite, kNever, run.start, step.data()).cost;
  CHECK(there == repeated(first, run.poses(), kWhite, kNever, run.start, step.data()));
  const double slope = -2.0 * first.gradient[0];
  const double bend = 2.0 * first.information[0];
  const double foretold = first.cost + step[0] * slope + 0.5 * step[0] * step[0] * bend;
  CHECK(there - first.cost == doctest::Approx(foretold - first.cost).epsilon(1e-3));
}

TEST_CASE("an outlier has less weight, and costs less than its square") {
  Run run = mallard_run();
  const double plain = run.pass(kWhite, 4.0).cost;
  run.eta[120] += 1.0;  // [m] x of pose 40
  const FilterRun robust = run.pass(kWhite, 4.0);
  CHECK(robust.weight[40] < 0.05);
  CHECK(robust.weight[39] == 1.0);
  CHECK(robust.cost - plain < 0.05 * (run.pass(kWhite).cost - plain));
}

TEST_CASE("after a permanent jump the filter restarts from the pose, with its velocity") {
  Run run = mallard_run();
  for (std::size_t k = 50; k < run.problem.time.size(); ++k) run.eta[3 * k] += 0.4;
  run.use[50] = kJumped;
  const FilterRun pass = run.pass(kWhite);
  REQUIRE(pass.good);
  CHECK(pass.weight[50] == 1.0);
  CHECK(std::abs(pass.state[450] - run.eta[150]) < 1e-4);
  CHECK(std::abs(pass.innovation[153]) < 0.05);
}

TEST_CASE("after a gap the filter restarts only where the poses jumped in it") {
  Run run = mallard_run();
  run.use[50] = kMeasured;
  const double whole = run.pass(kWhite).cost;
  run.use[50] = kGapped;
  CHECK(run.pass(kWhite).cost == whole);
  for (std::size_t k = 50; k < run.problem.time.size(); ++k) run.eta[3 * k] += 0.4;
  const double allowed = run.pass(kWhite).cost;
  run.use[50] = kJumped;
  CHECK(allowed == run.pass(kWhite).cost);
  CHECK(allowed < whole + 50.0);
  const FilterRun first = run.pass(kWhite);
  run.use[50] = kGapped;
  CHECK(repeated(first, run.poses(), kWhite, kNever, run.start) ==
        doctest::Approx(first.cost).epsilon(1e-6));
}

TEST_CASE("whole turns of the heading in a gap change nothing") {
  Run run = mallard_run();
  const double whole = run.pass(kWhite).cost;
  for (std::size_t k = 60; k < run.problem.time.size(); ++k) run.eta[3 * k + 2] += 2.0 * kTurn;
  CHECK(run.pass(kWhite).cost == doctest::Approx(whole).epsilon(1e-9));
}

TEST_CASE("a divergence is reported") {
  Run run = mallard_run();
  run.problem.boat.coefficient[boats::kXu] = 4000.0;
  CHECK_FALSE(run.pass(kWhite).good);
}

TEST_CASE("lever arm, current, trim and wind bend the cost as the information says") {
  Run run = mallard_run();
  NoiseParameters sharp = kWhite;  // so that the lever arm does not bend the determinant, too
  sharp.heading = 2e-4;
  sharp.walk_yaw = 2e-3;
  Effects at;
  at.lever[0] = 0.2, at.lever[1] = -0.1;
  at.current[0] = 0.01, at.current[1] = -0.02;
  const std::vector<double> states = problems::simulated(run.problem, nullptr);
  for (std::size_t k = 0; k < run.problem.time.size(); ++k) {  // poses without noise
    const double* x = &states[k * kStates];
    const double c = std::cos(x[2]);
    const double s = std::sin(x[2]);
    const double t = run.problem.time[k];
    run.eta[3 * k] = x[0] + c * at.lever[0] - s * at.lever[1] + at.current[0] * t;
    run.eta[3 * k + 1] = x[1] + s * at.lever[0] + c * at.lever[1] + at.current[1] * t;
    run.eta[3 * k + 2] = x[2];
  }
  std::copy(run.eta.begin(), run.eta.begin() + std::ptrdiff_t{kPose},
            run.start.state);  // the measured point, and its velocity over ground
  const double c = std::cos(states[2]);
  const double s = std::sin(states[2]);
  run.start.state[3] += c * at.current[0] + s * at.current[1] - states[5] * at.lever[1];
  run.start.state[4] += c * at.current[1] - s * at.current[0] + states[5] * at.lever[0];
  const auto pass = [&](const Effects& effects) {
    const Problem& p = run.problem;
    return innovations(p.boat, p.trace(), run.poses(), sharp, kNever, run.start, effects, true);
  };
  double* const moved[kDelay] = {&at.lever[0], &at.lever[1], &at.current[0], &at.current[1],
                                 &at.bias[0],  &at.bias[1],  &at.bias[2],    &at.wind[0],
                                 &at.wind[1],  &at.wind[2],  &at.wind[3],    &at.wind[4],
                                 &at.wind[5]};
  const FilterRun here = pass(at);
  REQUIRE(here.good);
  const int own = here.parameters - kEffects;
  const double step = 1e-5;
  const auto bend = [&](int i, int j) {  // of the cost along both together
    const double is = *moved[i];
    const double js = *moved[j];
    double sum = -2.0 * here.cost;
    for (const double d : {step, -step}) {
      *moved[i] = is + d;
      *moved[j] = (i == j ? is : js) + d;
      sum += pass(at).cost;
      *moved[i] = is;
      *moved[j] = js;
    }
    return 0.5 * sum / (step * step);
  };
  const auto entry = [&](int i, int j) {
    return here.information[static_cast<std::size_t>((own + i) * here.parameters + own + j)];
  };
  for (int i = 0; i < kDelay; ++i) {
    CHECK(std::abs(here.gradient[static_cast<std::size_t>(own + i)]) * step < 1e-3);
    CHECK(bend(i, i) == doctest::Approx(entry(i, i)).epsilon(1e-3));
    for (int j = 0; j < i; ++j) {
      const double want = entry(i, i) + entry(j, j) + 2.0 * entry(i, j);
      CHECK(bend(i, j) == doctest::Approx(want).epsilon(1e-3));
    }
  }
}

TEST_CASE("a pose that counts twice counts twice") {
  const Run run = mallard_run();
  const Problem& p = run.problem;
  const std::vector<double> twice(p.time.size(), 2.0);
  const FilterRun once = run.pass(kWhite);
  const FilterRun both = innovations(p.boat, p.trace(), run.poses(), kWhite, kNever, run.start, {},
                                     false, twice.data());
  CHECK(both.cost == doctest::Approx(2.0 * once.cost));
  CHECK(both.gradient[0] == doctest::Approx(2.0 * once.gradient[0]));
  CHECK(both.information[0] == doctest::Approx(2.0 * once.information[0]));
  CHECK(both.state == once.state);
}
