// SPDX-License-Identifier: MIT
// The filter gives the numbers of the two filters that it replaced, the estimator's and that on
// board: golden_filter.hpp has them, in the order in which they are computed here.
#include <doctest/doctest.h>

#include <cstdio>
#include <iterator>
#include <memory>

#include "filter_run.hpp"
#include "golden_filter.hpp"
#include "onboard.hpp"

using namespace seatrial;
using problems::Run;

namespace {

constexpr double kOutlier = 4.0;  // [sigma]
constexpr NoiseParameters kNoises[] = {
    {2e-3, 4e-3, 5e-3, 2e-2, 3e-3, 1e-2, 2.0, 0.0, 0.0, 0.3, 0.0},
    {1e-3, 2e-3, 5e-3, 2e-2, 3e-3, 1e-2, 2.0, 3e-3, 2e-3, 0.3, 0.0},
    {1e-3, 2e-3, 1e-3, 5e-3, 9e-3, 4e-2, 1.0, 3e-3, 2e-3, 1.5, 4.0}};

/// Effects of a sensor off the origin on flowing water, with trim and wind.
Effects all_effects() {
  Effects e;
  e.lever[0] = 0.2, e.lever[1] = -0.1;
  e.current[0] = 0.01, e.current[1] = -0.02;
  e.bias[0] = 0.003, e.bias[1] = -0.002, e.bias[2] = 0.01;
  e.wind[0] = 0.002, e.wind[1] = -0.004;
  e.earth_fixed = true;
  return e;
}

/// The estimator's filter and its repeated passes along one recording.
void estimate(const Run& run, const NoiseParameters& noise, const Effects& effects, bool slopes,
              std::vector<double>& out) {
  const problems::Problem& p = run.problem;
  const FilterRun pass =
      innovations(p.boat, p.trace(), run.poses(), noise, kOutlier, run.start, effects, slopes);
  REQUIRE(pass.good);
  const auto all = static_cast<std::size_t>(pass.parameters);
  const std::size_t n =
      slopes ? all - 6 : all;  // the old: no delays, a wind without moment, alike in both axes
  out.insert(out.end(), {pass.cost, pass.gradient[0], pass.gradient[n / 2], pass.gradient[n - 1],
                         pass.information[0], pass.information[(n / 2) * (all + 1)],
                         pass.information[n - 1], pass.information[(n - 1) * (all + 1)]});
  out.insert(out.end(), pass.state.end() - kFilterStates, pass.state.end());
  NoiseParameters other = noise;
  other.walk_linear *= 2.0;
  out.push_back(repeated(pass, run.poses(), other, kOutlier, run.start));
  const NoiseDerivatives noises = noise_slopes(
      pass, run.poses(), noise, problems::logarithmic_directions(noise), kOutlier, run.start);
  constexpr std::size_t kRow = kNoiseParameters;
  out.insert(out.end(), {noises.cost, noises.gradient[0], noises.gradient[3], noises.gradient[6],
                         noises.gradient[7], noises.information[0],
                         noises.information[4 * kRow + 2], noises.information[9 * kRow + 9]});
}

/// Two boats, three noises; an outlier, a jump for good, a gap; with effects and without.
std::vector<double> of_the_estimator() {
  std::vector<double> out;
  for (const bool rich : {false, true}) {
    Run run = rich ? problems::run_of(boats::rich(), boats::rich_coefficients())
                   : problems::mallard_run();
    run.eta[60] += 0.5;  // [m] x of pose 20
    for (std::size_t k = 50; k < run.problem.time.size(); ++k) run.eta[3 * k] += 0.4;
    run.use[50] = kJumped;
    run.use[70] = kGapped;
    for (const NoiseParameters& noise : kNoises) {
      estimate(run, noise, {}, false, out);
      estimate(run, noise, all_effects(), true, out);
    }
  }
  return out;
}

std::vector<OnboardModel> models() {
  std::vector<OnboardModel> all{onboard::model(), onboard::coloured_model(),
                                onboard::swinging_model(), onboard::coloured_model()};
  all[1].boat.frame = DisturbanceFrame::kBody;
  all[1].boat.current[0] = 0.05;
  all[1].boat.current[1] = -0.02;
  all[3].boat.considered = {};
  all[3].boat.integrator = Integrator::kForwardEuler;
  return all;
}

constexpr std::size_t kMeans = 9;        // pose, velocity, disturbance
constexpr std::size_t kOfEstimate = 18;  // and nine entries of the covariance

/// 12 s with late poses, false matches, a pose too far off to count in full, 1.5 s without poses.
std::vector<double> of_the_board() {
  std::vector<double> out;
  for (const OnboardModel& m : models()) {
    auto p = std::make_unique<Predictor>(m);
    std::vector<onboard::Input> late;
    int poses = 0;
    double next = 2.0;  // [s] at which an estimate is kept
    for (onboard::Input in : onboard::drive(5, 12.0, onboard::kMemory)) {
      if (in.pose) {
        ++poses;
        if (poses >= 60 && poses < 64) in.values[0] += 0.7;
        if (poses == 90) in.values[1] += 0.03;
        if (in.time > 8.0 && in.time < 9.5) continue;
        if (poses % 3 == 0) {
          late.push_back(in);
          continue;
        }
      }
      onboard::give(*p, in);
      if (!late.empty() && in.time > late.front().time + 0.2) {
        onboard::give(*p, late.front());
        late.erase(late.begin());
      }
      if (in.time < next) continue;
      next += 3.2;
      const Estimate e = p->at(in.time + 0.05);
      for (const double* from : {e.pose, e.velocity, e.disturbance}) {
        out.insert(out.end(), from, from + kAxes);
      }
      for (int i = 0; i < kStates; ++i) out.push_back(e.covariance[i][i]);
      out.insert(out.end(), {e.covariance[3][0], e.covariance[4][1], e.covariance[5][2]});
    }
  }
  return out;
}

/// Where multiplication and addition are fused all roundings differ; the slopes of a run that are
/// stored short carry them to some 1e-7 of a derivative.
#ifdef __FP_FAST_FMA
constexpr double kSame = 1e-5;
#else
constexpr double kSame = 1e-12;
#endif

/// The largest relative difference; `least`: of a number as small as that, relative to it.
template <std::size_t N, class Least>
double apart(const std::vector<double>& got, const double (&want)[N], Least least) {
  REQUIRE(got.size() == N);
  boats::Worst worst;
  for (std::size_t i = 0; i < N; ++i) {
    worst.see(got[i], want[i], std::max(std::abs(want[i]), least(i)));
  }
  return worst.value();
}

void print(const char* name, const std::vector<double>& values) {
  std::printf("inline constexpr double %s[] = {\n", name);
  for (const double x : values) std::printf("%a,\n", x);
  std::printf("};\n");
}

}  // namespace

TEST_CASE("the estimator's numbers are those of its own filter") {
  const auto none = [](std::size_t) { return 1e-300; };  // a zero stays one
  CHECK(apart(of_the_estimator(), golden::kEstimator, none) < kSame);
}

/// The filter on board took S^-1 by Cholesky's root, and added in another order: roundings differ.
TEST_CASE("the predictor's numbers are those of the filter on board") {
  const auto least = [](std::size_t i) {  // a velocity that passes zero has its absolute error
    return i % kOfEstimate < kMeans ? 0.01 : 1e-300;  // [m, rad, m/s, rad/s, m/s^2, rad/s^2]
  };
  CHECK(apart(of_the_board(), golden::kBoard, least) < kSame);
}

/// `core_tests --no-skip -tc="golden*"` prints golden_filter.hpp's arrays.
TEST_CASE("golden numbers" * doctest::skip()) {
  print("kEstimator", of_the_estimator());
  print("kBoard", of_the_board());
}
