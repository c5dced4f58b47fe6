// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include "boats.hpp"
#include "seatrial/rollout.hpp"

using namespace seatrial;
using boats::Random;
using boats::Script;
using boats::Worst;

namespace {

/// A boat on a recording: all that a roll-out depends on.
struct Problem {
  Boat boat;
  Chain chain;
  std::vector<double> q;
  Script commands;
  Script scales;
  std::vector<double> x0;
  std::vector<double> time;
  Columns columns;

  Problem(const Structure& s, const std::vector<double>& coefficients, const Chain& c,
          std::vector<double> constants)
      : chain(c), q(std::move(constants)), x0{0.3, -0.2, 0.5, 0.2, -0.1, 0.3} {
    boat.structure = s;
    std::copy(coefficients.begin(), coefficients.end(), boat.coefficient);
    columns = boats::all_columns(s, c);
  }

  Trace trace() const { return {chain, q.data(), commands.held(), scales.held(), columns}; }

  /// What column c differentiates to.
  double& parameter(int c) {
    if (c < kStates) return x0[static_cast<std::size_t>(c)];
    if (c < columns.first_constant()) return boat.coefficient[columns.coefficient[c - kStates]];
    return q[static_cast<std::size_t>(columns.constant[c - columns.first_constant()])];
  }
};

using Rollout = std::vector<double> (*)(const Problem&, std::vector<double>*);

/// States at all stamps; tangents too where asked.
std::vector<double> simulated(const Problem& p, std::vector<double>* tangent) {
  const Trace trace = p.trace();
  std::vector<double> out(p.time.size() * kStates);
  if (tangent != nullptr) tangent->resize(out.size() * static_cast<std::size_t>(p.columns.size()));
  const int n = static_cast<int>(p.time.size());
  REQUIRE(simulate(p.boat, trace, p.x0.data(), p.time.data(), n, out.data(),
                   tangent == nullptr ? nullptr : tangent->data()) == n);
  return out;
}

/// Predictions of 15 steps from every fifth stamp, all from x0.
std::vector<double> predicted(const Problem& p, std::vector<double>* tangent) {
  const Trace trace = p.trace();
  std::vector<int> start;
  std::vector<double> x0;
  for (int i = 0; i + 15 < static_cast<int>(p.time.size()); i += 5) {
    start.push_back(i);
    x0.insert(x0.end(), p.x0.begin(), p.x0.end());
  }
  std::vector<double> out(x0.size());
  if (tangent != nullptr) tangent->resize(out.size() * static_cast<std::size_t>(p.columns.size()));
  predict(p.boat, trace, p.time.data(), start.data(), x0.data(), static_cast<int>(start.size()), 15,
          1, out.data(), tangent == nullptr ? nullptr : tangent->data());
  return out;
}

struct Compared {
  double value = 0.0;     // tangent path against plain path
  double relative = 0.0;  // tangents against differences, relative to the column's largest
  std::vector<double> largest;
};

enum class Side { kCentral, kLeft };

Compared compare(Problem p, Rollout rollout, double step = 1e-5, Side side = Side::kCentral) {
  std::vector<double> tangent;
  const auto with = rollout(p, &tangent);
  const auto without = rollout(p, nullptr);
  Worst value;
  for (std::size_t i = 0; i < with.size(); ++i) value.see(with[i], without[i]);
  Worst relative;
  Compared result;
  const auto width = static_cast<std::size_t>(p.columns.size());
  for (std::size_t c = 0; c < width; ++c) {
    double& parameter = p.parameter(static_cast<int>(c));
    const double nominal = parameter;
    const double above = side == Side::kCentral ? nominal + step : nominal;
    const double below = nominal - step;
    parameter = above;
    const auto up = rollout(p, nullptr);
    parameter = below;
    const auto down = rollout(p, nullptr);
    parameter = nominal;
    std::vector<double> want(up.size());
    double largest = 0.0;
    for (std::size_t i = 0; i < up.size(); ++i) {
      want[i] = (up[i] - down[i]) / (above - below);
      largest = std::max(largest, std::abs(want[i]));
    }
    // a column of zeros is compared absolutely
    const double scale = std::max(largest, 1e-3);
    for (std::size_t i = 0; i < want.size(); ++i)
      relative.see(tangent[i * width + c], want[i], scale);
    result.largest.push_back(largest);
  }
  result.value = value.value();
  result.relative = relative.value();
  return result;
}

/// The rich recording: 60 commands in about 10 s, a sagging battery, pose stamps off every grid.
Problem driven(const Structure& s, const std::vector<double>& coefficients, Scheme scheme,
               bool lag) {
  Problem p(s, coefficients, boats::full_chain(scheme, lag), boats::full_constants());
  p.commands = boats::random_script(60, 60, 3, 0.05, -1.0, 1.0);
  p.scales.width = 1;
  p.scales.add(0.0, {13.2});
  p.scales.add(1.917, {12.6});
  p.scales.add(4.111, {11.4});
  for (int i = 0; i < 105; ++i) p.time.push_back(0.0137 + i / 15.0 + 0.003 * std::sin(7.0 * i));
  return p;
}

/// A few commands on sixteenths of a second, where pose stamps and both latencies stand too.
Problem coincident(bool lag) {
  Problem p(boats::mallard(), boats::mallard_coefficients(),
            boats::full_chain(Scheme::kMoorePenrose, lag), boats::full_constants());
  p.q[boats::kLatencyA] = 0.125;
  p.q[boats::kLatencyB] = 0.125;
  p.boat.longest_step = 0.013;
  p.commands.width = 3;
  p.commands.add(0.0, {0.3, 0.1, 0.2});
  p.commands.add(0.5, {-0.7, 0.8, -0.1});
  p.commands.add(0.8125, {0.9, -0.4, 0.5});
  p.commands.add(1.25, {0.2, 0.3, -0.9});
  for (int i = 0; i < 30; ++i) p.time.push_back(i / 16.0);
  return p;
}

/// Eq. (12) and the chain written out by hand, classical Runge-Kutta at a grid of 1 ms.
std::vector<double> mallard_in_fine_steps(const Problem& p, double end) {
  const double* c = p.boat.coefficient;
  const auto rate = [&](const std::vector<double>& x, double t) {
    double force[3];
    double nu_dot[3];
    boats::forces_by_hand(p.chain, p.q, p.commands, p.scales, t, force);
    boats::mallard_by_hand(c, x.data() + 3, force, nu_dot);
    return std::vector<double>{std::cos(x[2]) * x[3] - std::sin(x[2]) * x[4],
                               std::sin(x[2]) * x[3] + std::cos(x[2]) * x[4],
                               x[5],
                               nu_dot[0],
                               nu_dot[1],
                               nu_dot[2]};
  };
  const auto moved = [](std::vector<double> x, double h, const std::vector<double>& k) {
    for (std::size_t i = 0; i < x.size(); ++i) x[i] += h * k[i];
    return x;
  };
  std::vector<double> x = p.x0;
  const double h = 1e-3;
  const int n = static_cast<int>(std::lround(end / h));
  for (int i = 0; i < n; ++i) {
    const double t = i * h;
    const auto k1 = rate(x, t);
    const auto k2 = rate(moved(x, 0.5 * h, k1), t + 0.5 * h);
    const auto k3 = rate(moved(x, 0.5 * h, k2), t + 0.5 * h);
    const auto k4 = rate(moved(x, h, k3), t + h);
    for (std::size_t s = 0; s < 6; ++s)
      x[s] += h / 6.0 * (k1[s] + 2.0 * k2[s] + 2.0 * k3[s] + k4[s]);
  }
  return x;
}

}  // namespace

TEST_CASE("a simulation agrees with Eq. (12) integrated by hand in fine steps") {
  Problem p(boats::mallard(), boats::mallard_coefficients(),
            boats::full_chain(Scheme::kAlwaysForward), boats::full_constants());
  p.q[boats::kLatencyA] = 0.083;  // on the fine grid
  p.q[boats::kLatencyB] = 0.127;
  p.boat.longest_step = 1.0 / 200.0;
  p.commands.width = 3;
  p.commands.add(0.0, {0.0, 0.0, 0.0});
  p.commands.add(0.2, {0.9, 0.1, -0.4});
  p.commands.add(0.71, {-0.5, 0.8, 0.3});
  p.commands.add(1.3, {-0.5, -0.8, 0.9});
  p.time = {0.0, 0.4, 1.1, 2.0};
  const auto got = simulated(p, nullptr);
  const auto want = mallard_in_fine_steps(p, 2.0);
  Worst worst;
  for (std::size_t i = 0; i < 6; ++i) worst.see(got[18 + i], want[i]);
  CHECK(worst.value() < 2e-7);
}

TEST_CASE("tangents of simulate equal central differences, for every parameter there is") {
  for (const Scheme scheme : {Scheme::kMoorePenrose, Scheme::kAlwaysForward}) {
    const auto got =
        compare(driven(boats::mallard(), boats::mallard_coefficients(), scheme, true), simulated);
    CHECK(got.value < 1e-12);
    CHECK(got.relative < 1e-6);
    // every parameter moves the boat, but the reverse ones under always forward
    for (std::size_t c = 0; c < got.largest.size(); ++c) {
      const int constant = static_cast<int>(c) - kStates - boats::kMallardSize;
      const bool idle = scheme == Scheme::kAlwaysForward &&
                        (constant == boats::kEdgeReverse || constant == boats::kReverseRatio);
      CAPTURE(c);
      CHECK((got.largest[c] > 1e-3) == !idle);
    }
  }
}

TEST_CASE("without a lag the latency's derivative comes from the moving breaks alone") {
  const auto got =
      compare(driven(boats::mallard(), boats::mallard_coefficients(), Scheme::kMoorePenrose, false),
              simulated);
  CHECK(got.value < 1e-12);
  CHECK(got.relative < 1e-6);
  const std::size_t first = kStates + boats::kMallardSize;
  CHECK(got.largest[first + boats::kLatencyA] > 0.01);
  CHECK(got.largest[first + boats::kLatencyB] > 0.01);
  CHECK(got.largest[first + boats::kLag] == 0.0);
}

TEST_CASE("tangents of the rich boat equal central differences") {
  for (const bool lag : {true, false}) {
    const auto got = compare(
        driven(boats::rich(), boats::rich_coefficients(), Scheme::kMoorePenrose, lag), simulated);
    CHECK(got.value < 1e-12);
    CHECK(got.relative < 1e-6);
  }
}

TEST_CASE("tangents of predict equal central differences") {
  for (const bool lag : {true, false}) {
    const auto got =
        compare(driven(boats::mallard(), boats::mallard_coefficients(), Scheme::kMoorePenrose, lag),
                predicted);
    CHECK(got.value < 1e-12);
    CHECK(got.relative < 1e-6);
  }
}

TEST_CASE("tangents of the paper's Euler integrator equal central differences") {
  for (const Structure& s : {boats::mallard(), boats::rich()}) {
    const bool rich = s.n_coefficients == boats::kRichSize;
    Problem p = driven(s, rich ? boats::rich_coefficients() : boats::mallard_coefficients(),
                       Scheme::kMoorePenrose, true);
    p.boat.integrator = Integrator::kForwardEuler;
    for (const Rollout rollout : {simulated, predicted}) {
      const auto got = compare(p, rollout);
      CHECK(got.value < 1e-12);
      CHECK(got.relative < 1e-6);
    }
  }
}

TEST_CASE("tangents of five direct actuators with a table equal central differences") {
  Problem p(boats::mallard(), boats::mallard_coefficients(), boats::direct_chain(),
            boats::direct_constants());
  p.commands = boats::random_script(61, 40, 5, 0.02, -1.0, 1.0);
  for (int i = 0; i < 70; ++i) p.time.push_back(0.0137 + i / 15.0);
  const auto got = compare(p, simulated);
  CHECK(got.value < 1e-12);
  CHECK(got.relative < 1e-6);
  for (const double largest : got.largest) CHECK(largest > 1e-3);
}

TEST_CASE("tangents hold where latencies are negative and the groups overtake each other") {
  Problem p = driven(boats::mallard(), boats::mallard_coefficients(), Scheme::kMoorePenrose, true);
  p.q[boats::kLatencyA] = -0.2117;
  p.q[boats::kLatencyB] = 0.3319;
  const auto got = compare(p, simulated);
  CHECK(got.value < 1e-12);
  CHECK(got.relative < 1e-6);
}

TEST_CASE("tangents hold where breaks fall on stamps and on each other, with a lag") {
  // the state is smooth in the latencies there, but only once: hence the small step
  const auto got = compare(coincident(true), simulated, 1e-7);
  CHECK(got.value < 1e-12);
  CHECK(got.relative < 1e-5);
  const auto ahead = compare(coincident(true), predicted, 1e-7);
  CHECK(ahead.value < 1e-12);
  CHECK(ahead.relative < 1e-5);
}

TEST_CASE("tangents hold where two latencies are equal, without a lag") {
  Problem p = coincident(false);
  for (double& t : p.time) t += 0.0211;
  const auto got = compare(p, simulated, 1e-6);
  CHECK(got.value < 1e-12);
  CHECK(got.relative < 1e-5);
}

TEST_CASE("where a jump falls on a stamp the latency's derivative is the one from the left") {
  const auto got = compare(coincident(false), simulated, 1e-7, Side::kLeft);
  CHECK(got.value < 1e-12);
  CHECK(got.relative < 1e-5);
}

TEST_CASE("a simulation may be stopped and taken up anywhere, at a break or between") {
  Problem p = driven(boats::mallard(), boats::mallard_coefficients(), Scheme::kMoorePenrose, true);
  p.boat.longest_step = 1.0 / 500.0;
  const Trace trace = p.trace();
  const double end = 5.0;
  const double whole_time[2] = {0.0, end};
  double whole[2 * kStates];
  REQUIRE(simulate(p.boat, trace, p.x0.data(), whole_time, 2, whole, nullptr) == 2);
  Random random(62);
  Worst worst;
  for (int n = 0; n < 30; ++n) {
    const double t1 = n % 2 == 0 ? trace.time(1 + n) : random(0.0, end);
    REQUIRE(t1 < end);
    const double first_time[2] = {0.0, t1};
    const double second_time[2] = {t1, end};
    double first[2 * kStates] = {};
    double second[2 * kStates] = {};
    REQUIRE(simulate(p.boat, trace, p.x0.data(), first_time, 2, first, nullptr) == 2);
    REQUIRE(simulate(p.boat, trace, first + kStates, second_time, 2, second, nullptr) == 2);
    for (int i = 0; i < kStates; ++i) worst.see(second[kStates + i], whole[kStates + i]);
  }
  CHECK(worst.value() < 1e-9);
}

TEST_CASE("a prediction is a simulation from its own start") {
  const Problem p =
      driven(boats::mallard(), boats::mallard_coefficients(), Scheme::kAlwaysForward, true);
  const Trace trace = p.trace();
  const int start[2] = {7, 40};
  std::vector<double> x0(p.x0);
  x0.insert(x0.end(), {1.0, 2.0, -0.4, 0.1, 0.2, -0.3});
  double got[2 * kStates];
  predict(p.boat, trace, p.time.data(), start, x0.data(), 2, 20, 1, got, nullptr);
  for (int j = 0; j < 2; ++j) {
    double rows[21 * kStates];
    REQUIRE(simulate(p.boat, trace, x0.data() + static_cast<std::ptrdiff_t>(j) * kStates,
                     p.time.data() + start[j], 21, rows, nullptr) == 21);
    for (int i = 0; i < kStates; ++i) CHECK(got[j * kStates + i] == rows[20 * kStates + i]);
  }
}

TEST_CASE("one thread and more predict the same bits") {
  Problem p = driven(boats::mallard(), boats::mallard_coefficients(), Scheme::kMoorePenrose, true);
  const Trace trace = p.trace();
  Random random(63);
  const int m = 300;
  std::vector<int> start(m);
  std::vector<double> x0(start.size() * kStates);
  for (int& s : start) s = static_cast<int>(random(0.0, 89.0));
  random.fill(x0.data(), m * kStates, -0.5, 0.5);
  const auto width = static_cast<std::size_t>(p.columns.size());
  std::vector<double> one(x0.size());
  std::vector<double> one_tangent(x0.size() * width);
  predict(p.boat, trace, p.time.data(), start.data(), x0.data(), m, 15, 1, one.data(),
          one_tangent.data());
  for (const int threads : {2, 3, 4}) {
    std::vector<double> more(x0.size(), std::nan(""));
    std::vector<double> more_tangent(one_tangent.size(), std::nan(""));
    predict(p.boat, trace, p.time.data(), start.data(), x0.data(), m, 15, threads, more.data(),
            more_tangent.data());
    CHECK(more == one);
    CHECK(more_tangent == one_tangent);
  }
}

TEST_CASE("rows at equal stamps are equal") {
  Problem p = driven(boats::mallard(), boats::mallard_coefficients(), Scheme::kMoorePenrose, true);
  p.time = {0.0, 0.5, 0.5, 1.0};
  for (const bool euler : {false, true}) {
    p.boat.integrator = euler ? Integrator::kForwardEuler : Integrator::kRungeKutta;
    std::vector<double> tangent;
    const auto out = simulated(p, &tangent);
    for (std::size_t i = 0; i < 6; ++i) CHECK(out[6 + i] == out[12 + i]);
    CHECK(out[6] != out[0]);
    const auto width = 6 * static_cast<std::size_t>(p.columns.size());
    for (std::size_t i = 0; i < width; ++i) CHECK(tangent[width + i] == tangent[2 * width + i]);
  }
}

TEST_CASE("a boat that runs away ends in rows of NaN, tangents too, and is counted so") {
  Problem p = driven(boats::mallard(), boats::mallard_coefficients(), Scheme::kMoorePenrose, true);
  p.boat.coefficient[boats::kXuu] = 40.0;  // quadratic drag of the wrong sign
  p.boat.coefficient[boats::kXu] = 5.0;
  p.x0[3] = 0.5;
  const Trace trace = p.trace();
  const int n = static_cast<int>(p.time.size());
  const auto width = static_cast<std::size_t>(p.columns.size());
  for (const bool euler : {false, true}) {
    p.boat.integrator = euler ? Integrator::kForwardEuler : Integrator::kRungeKutta;
    std::vector<double> plain(p.time.size() * kStates);
    std::vector<double> with(plain.size());
    std::vector<double> tangent(plain.size() * width);
    const int reached =
        simulate(p.boat, trace, p.x0.data(), p.time.data(), n, plain.data(), nullptr);
    CHECK(reached > 0);
    CHECK(reached < n);
    CHECK(simulate(p.boat, trace, p.x0.data(), p.time.data(), n, with.data(), tangent.data()) ==
          reached);
    for (int i = 0; i < n * kStates; ++i) {
      const bool good = i < reached * kStates;
      REQUIRE(std::isfinite(plain[static_cast<std::size_t>(i)]) == good);
      REQUIRE(std::isfinite(with[static_cast<std::size_t>(i)]) == good);
      for (std::size_t c = 0; c < width && !good; ++c) {
        REQUIRE(std::isnan(tangent[static_cast<std::size_t>(i) * width + c]));
      }
    }
    const int start[1] = {0};
    double out[kStates];
    std::vector<double> slopes(kStates * width);
    predict(p.boat, trace, p.time.data(), start, p.x0.data(), 1, 60, 1, out, nullptr);
    for (const double value : out) CHECK(std::isnan(value));
    std::fill(out, out + kStates, 0.0);
    predict(p.boat, trace, p.time.data(), start, p.x0.data(), 1, 60, 1, out, slopes.data());
    for (const double value : out) CHECK(std::isnan(value));
    for (const double value : slopes) CHECK(std::isnan(value));
  }
}

TEST_CASE("a boat whose accelerations hold each other up stops at its first row") {
  Structure s = boats::mallard();
  boats::add(s, 0, -1, 1.0, {}, 2);  // u_dot = ... + r_dot, and r_dot = ... + N_ud u_dot
  auto c = boats::mallard_coefficients();
  c[boats::kNud] = 1.0;
  Problem p = driven(s, c, Scheme::kMoorePenrose, true);
  const Trace trace = p.trace();
  std::vector<double> out(p.time.size() * kStates);
  std::vector<double> tangent(out.size() * static_cast<std::size_t>(p.columns.size()));
  const int n = static_cast<int>(p.time.size());
  for (const bool euler : {false, true}) {
    p.boat.integrator = euler ? Integrator::kForwardEuler : Integrator::kRungeKutta;
    for (double* slopes : {static_cast<double*>(nullptr), tangent.data()}) {
      CHECK(simulate(p.boat, trace, p.x0.data(), p.time.data(), n, out.data(), slopes) == 1);
      CHECK(out[3] == p.x0[3]);
      CHECK(std::isnan(out[6]));
      CHECK(std::isnan(out.back()));
    }
  }
}
