// SPDX-License-Identifier: MIT
// Angles as actuators: rudder, outboard, azimuth thruster.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "boats.hpp"
#include "seatrial/filter/schmidt_kalman.hpp"
#include "seatrial/integration/rollout.hpp"
#include "seatrial/simulation/plant.hpp"

using namespace seatrial;
using boats::Random;
using boats::Script;
using boats::Worst;

namespace {

const Chain kSteered = boats::steered_chain();
const std::vector<double> kValues = boats::steered_constants();

/// e' = -clip(e / lag, +-rate) by small steps.
double integrated(double start, double rate, double lag, double h) {
  constexpr int kSteps = 20000;
  double e = start;
  for (int i = 0; i < kSteps; ++i) {
    const double dt = h / kSteps;
    const auto slope = [&](double at) { return -std::clamp(at / lag, -rate, rate); };
    e += dt * slope(e + 0.5 * dt * slope(e));
  }
  return e;
}

/// Angle of the rudder by small steps, from its definition.
struct RudderByHand {
  double angle = 0.0;  // [rad]
  double target(double command) const {
    const double zone = kValues[boats::kRudderZone];
    const double past = std::max(0.0, std::abs(command) - zone) / (1.0 - zone);
    const double share = command < 0.0 ? -past : past;
    return kDegree * (kValues[boats::kRudderAngle] * share + kValues[boats::kRudderTrim]);
  }
  void move(double command, double h) {
    const double most = kDegree * kValues[boats::kRudderRate] * h;
    angle += std::clamp(target(command) - angle, -most, most);
  }
};

}  // namespace

TEST_CASE("a lag with a rate limit is that of its differential equation") {
  for (const double start : {-1.3, -0.02, 0.0, 0.04, 0.4}) {
    for (const double h : {0.003, 0.1, 0.6, 3.0}) {
      const double want = integrated(start, 0.7, 0.12, h);
      CHECK(rate_limited(start, 0.7, 0.12, h).left == doctest::Approx(want).epsilon(1e-6));
    }
  }
  CHECK(rate_limited(0.5, 0.7, 0.0, 0.2).left == doctest::Approx(0.36));
  CHECK(rate_limited(-0.5, 0.7, 0.0, 0.2).left == doctest::Approx(-0.36));
  CHECK(rate_limited(0.5, 0.7, 0.0, 0.8).left == 0.0);
}

TEST_CASE("two stretches of a lag with a rate limit are one of both lengths") {
  for (const double lag : {0.0, 0.12}) {
    for (const double start : {-1.3, 0.05, 0.4}) {
      const double first = rate_limited(start, 0.7, lag, 0.31).left;
      CHECK(rate_limited(first, 0.7, lag, 0.2).left ==
            doctest::Approx(rate_limited(start, 0.7, lag, 0.51).left).epsilon(1e-12));
    }
  }
}

TEST_CASE("slopes of a lag with a rate limit equal central differences") {
  Random random(80);
  Worst worst;
  for (int i = 0; i < 400; ++i) {
    double at[4] = {random(-1.0, 1.0), random(0.2, 1.5), random(0.03, 0.4), random(0.01, 1.5)};
    const auto left = [&at] { return rate_limited(at[0], at[1], at[2], at[3]).left; };
    const Distance d = rate_limited(at[0], at[1], at[2], at[3]);
    const double slopes[4] = {d.dstart, d.drate, d.dlag, d.dtime};
    for (int k = 0; k < 4; ++k) {
      const double own = at[k];
      at[k] = own + 1e-6;
      const double up = left();
      at[k] = own - 1e-6;
      const double down = left();
      at[k] = own;
      worst.see(slopes[k], (up - down) / 2e-6);
    }
  }
  CHECK(worst.value() < 2e-5);  // the second derivative jumps at the knee
}

TEST_CASE("a thrust that an angle turns acts along it at its own place") {
  Random random(81);
  Worst worst;
  for (int i = 0; i < 200; ++i) {
    const double f[4] = {random(-1.0, 1.0), random(-0.7, 0.7), random(-1.0, 1.0), random(-3, 3)};
    double force[3];
    mix_forces(kSteered, f, force);
    const double x[2] = {f[0] * std::cos(f[1]), 0.7 * f[2] * std::cos(f[3])};
    const double y[2] = {f[0] * std::sin(f[1]) + 0.4 * std::sin(f[1]), 0.7 * f[2] * std::sin(f[3])};
    worst.see(force[0], x[0] + x[1]);
    worst.see(force[1], y[0] + y[1]);
    worst.see(force[2], -0.6 * y[0] - 0.1 * x[0] + 0.5 * y[1] + 0.2 * x[1]);
  }
  CHECK(worst.value() < 1e-14);
}

TEST_CASE("the rudder of a recording is where its rate limit lets it be") {
  const Script commands = boats::random_script(82, 30, 4, 0.3, -1.0, 1.0);
  const Columns columns = boats::all_columns(boats::mallard(), kSteered);
  const Script none;
  const ThrustTrace trace(kSteered, kValues.data(), commands.held(), none.held(), columns);
  RudderByHand rudder;
  rudder.angle = rudder.target(commands.row(0)[1]);
  constexpr double kStep = 1e-5;  // [s]
  Worst worst;
  double moved = 0.0;
  int next = 0;
  for (int i = 0; i < 600000; ++i) {
    const double t = i * kStep;
    while (next + 1 < commands.size() &&
           commands.time[static_cast<std::size_t>(next) + 1] + kValues[boats::kAngleLatency] <= t) {
      ++next;
    }
    if (i % 1000 == 0) {
      Thrust f;
      trace.at(trace.find(t), t, f);
      worst.see(f.level[1], rudder.angle);
      moved = std::max(moved, std::abs(f.level[1] - f.target[1]));
    }
    rudder.move(commands.row(next)[1], kStep);
  }
  CHECK(worst.value() < 1e-4);
  CHECK(moved > 0.5);
}

TEST_CASE("a plant with a rudder and an azimuth thruster moves as one that replays its commands") {
  const Script commands = boats::random_script(83, 40, 4, 0.2, -1.0, 1.0);
  const auto coefficient = boats::mallard_coefficients();
  Boat boat;
  boat.structure = boats::mallard();
  boat.longest_step = 1.0 / 480.0;  // [s] both break their steps at other times
  std::copy(coefficient.begin(), coefficient.end(), boat.coefficient);
  const Columns columns = boats::all_columns(boat.structure, kSteered);
  const Script none;
  const ThrustTrace trace(kSteered, kValues.data(), commands.held(), none.held(), columns);
  std::vector<double> time(120);
  for (std::size_t i = 0; i < time.size(); ++i) time[i] = 0.0137 + static_cast<double>(i) / 15.0;
  std::vector<double> want(time.size() * kStates);
  const double x0[kStates] = {0.0};
  const int n = static_cast<int>(time.size());
  REQUIRE(simulate(boat, trace, x0, time.data(), n, want.data(), nullptr) == n);
  Plant plant(boat.structure, boat.coefficient, kSteered, kValues.data(), boat.longest_step);
  plant.reset(time[0], commands.row(0));
  Worst worst;
  int next = 1;
  for (int i = 0; i < n; ++i) {
    const double t = time[static_cast<std::size_t>(i)];
    while (next < commands.size() && commands.time[static_cast<std::size_t>(next)] <= t) {
      const double at = commands.time[static_cast<std::size_t>(next)];
      REQUIRE(plant.advance_to(at));
      REQUIRE(plant.command(at, commands.row(next++)));
    }
    REQUIRE(plant.advance_to(t));
    for (int k = 0; k < kStates; ++k) {
      worst.see(plant.state()[k], want[static_cast<std::size_t>(i * kStates + k)]);
    }
  }
  CHECK(worst.value() < 1e-7);
  CHECK(std::abs(plant.state()[0]) + std::abs(plant.state()[1]) > 1e-2);
}

TEST_CASE("errors of the forces by errors of the constants are those of other constants") {
  constexpr double kOff = 1e-4;
  constexpr double kStep = 0.02;  // [s]
  PrincipalErrors errors;
  const int own[6] = {boats::kThrustLag,  boats::kAngleLag,     boats::kRudderAngle,
                      boats::kRudderRate, boats::kAzimuthAngle, boats::kAzimuthRate};
  errors.n = 6;
  for (int i = 0; i < 6; ++i)
    errors.constant[own[i]][i] = kValues[static_cast<std::size_t>(own[i])];
  Random random(84);
  Worst worst;
  double largest = 0.0;
  ThrustErrors e;
  Thrust f[13];  // the model's, and each constant more and less
  std::vector<double> q[13];
  for (int i = 0; i < 13; ++i) {
    q[i] = kValues;
    if (i > 0)
      q[i][static_cast<std::size_t>(own[(i - 1) / 2])] *= 1.0 + (i % 2 == 1 ? kOff : -kOff);
    std::fill(f[i].multiplier, f[i].multiplier + 4, 1.0);
  }
  for (int step = 0; step < 400; ++step) {
    if (step % 40 == 0) {
      double row[4];
      random.fill(row, 4, -1.0, 1.0);
      for (int k = 0; k < 4; ++k) {
        const double before = f[0].target[k];
        double slope[kMaxConstants] = {0.0};
        f[0].target[k] = curve(kSteered, kValues.data(), k, row, slope);
        retarget(kSteered, kValues.data(), errors, k, before, f[0].target[k], slope, e);
        for (int i = 1; i < 13; ++i) f[i].target[k] = curve(kSteered, q[i].data(), k, row, nullptr);
      }
    }
    double force[13][3];  // mean over the step
    LagDecay decays[kMaxActuators];
    ErrorDecay error_decay[kMaxActuators];
    Loadings found[kMaxForces];
    error_decays(kSteered, kValues.data(), kStep, decays, error_decay);
    force_errors(kSteered, errors, decays, error_decay, f[0], e, found);
    for (int i = 0; i < 13; ++i) {
      double nodes[3][kMaxForces];
      lag_decays(kSteered, q[i].data(), kStep, decays);
      step_forces(kSteered, decays, f[i], nodes);
      for (int j = 0; j < 3; ++j) {
        force[i][j] = (nodes[0][j] + 4.0 * nodes[1][j] + nodes[2][j]) / 6.0;
      }
    }
    for (int i = 0; i < 6; ++i) {
      for (int j = 0; j < 3; ++j) {
        const double want = (force[2 * i + 1][j] - force[2 * i + 2][j]) / (2.0 * kOff);
        worst.see(found[j][i], want);
        largest = std::max(largest, std::abs(want));
      }
    }
  }
  CHECK(largest > 0.3);
  CHECK(worst.value() < 0.01 * largest);
}

TEST_CASE("an incomplete angle is distinguished from one") {
  CHECK(angles_are_whole(kSteered));
  const auto broken = [](auto change) {
    Chain c = kSteered;
    change(c.actuators);
    return !angles_are_whole(c);
  };
  CHECK(broken([](Actuator* a) { a[1].steers = -1; }));
  CHECK(broken([](Actuator* a) { a[1].steers = 1; }));
  CHECK(broken([](Actuator* a) { a[1].steers = 2; }));
  CHECK(broken([](Actuator* a) { a[1].steers = 3; }));
  CHECK(broken([](Actuator* a) { a[1].steers = 4; }));
  CHECK(broken([](Actuator* a) { a[1].full_angle = -1; }));
  CHECK(broken([](Actuator* a) { a[1].gain = boats::kThrustEdge; }));
  CHECK(broken([](Actuator* a) { a[1].scale = 0; }));
}
