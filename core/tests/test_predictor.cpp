// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <memory>

#include "heap.hpp"
#include "onboard.hpp"

using namespace seatrial;
using boats::Random;
using boats::Worst;
using onboard::drive;
using onboard::fresh;
using onboard::give;
using onboard::Input;

namespace {

/// Inputs with what happens at sea: single false matches, a burst, a stretch without poses.
std::vector<Input> troubled(std::uint64_t seed, double seconds) {
  Random random(seed + 100);
  std::vector<Input> kept;
  int burst = 0;
  for (Input in : drive(seed, seconds)) {
    if (in.pose && in.time > 2.0 && in.time < 3.5) continue;
    if (in.pose && burst == 0 && random(0.0, 1.0) < 0.05) burst = random(0.0, 1.0) < 0.3 ? 14 : 1;
    if (in.pose && burst > 0) {
      in.values[0] += 0.8;
      in.values[1] -= 0.5;
      --burst;
    }
    kept.push_back(in);
  }
  return kept;
}

/// The same inputs as they arrive: each up to `most` [s] late.
std::vector<Input> late(const std::vector<Input>& inputs, std::uint64_t seed, double most) {
  Random random(seed);
  std::vector<std::pair<double, Input>> arriving;
  arriving.reserve(inputs.size());
  for (const Input& in : inputs) arriving.emplace_back(in.time + random(0.0, most), in);
  std::stable_sort(arriving.begin(), arriving.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<Input> out;
  out.reserve(arriving.size());
  for (const auto& [time, in] : arriving) out.push_back(in);
  return out;
}

bool same(const Estimate& a, const Estimate& b) {
  using onboard::same_bits;
  return same_bits(&a.time, &b.time, 1) && same_bits(a.pose, b.pose, kPose) &&
         same_bits(a.velocity, b.velocity, kAxes) &&
         same_bits(&a.covariance[0][0], &b.covariance[0][0], kStates * kStates) &&
         same_bits(a.disturbance, b.disturbance, kAxes) &&
         same_bits(&a.last_pose, &b.last_pose, 1) && a.health == b.health;
}

/// Estimates of the last half second and of what follows; each must be sound.
std::vector<Estimate> looks(Predictor& p, double end) {
  std::vector<Estimate> all;
  for (const double off : {-0.45, -0.2, -0.0137, 0.0, 0.031, 0.5, 3.0}) {
    all.push_back(p.at(end + off));
    CHECK(onboard::sound(all.back()));
  }
  return all;
}

/// Whether a predictor that gets the inputs late ends where one ends that gets them in time.
bool arrival_does_not_matter(const OnboardModel& m, std::uint64_t seed, double seconds,
                             double most) {
  const std::vector<Input> inputs = troubled(seed, seconds);
  auto in_time = fresh(m);
  for (const Input& in : inputs) REQUIRE(give(*in_time, in) == Taken::kUsed);
  auto behind = fresh(m);
  for (const Input& in : late(inputs, seed + 1, most)) {
    REQUIRE(give(*behind, in) == Taken::kUsed);
    if (in.pose) behind->at(in.time + 0.1);  // looking changes nothing
  }
  const double end = inputs.back().time;
  const auto want = looks(*in_time, end);
  const auto got = looks(*behind, end);
  bool equal = true;
  for (std::size_t i = 0; i < want.size(); ++i) equal = equal && same(want[i], got[i]);
  return equal;
}

}  // namespace

TEST_CASE("late and out of order is, to the last bit, what in order is; gate decisions too") {
  // either frame, with and without a time-out of the commands, 5 to 10 s
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    OnboardModel m = onboard::model();
    m.boat.frame = seed % 2 == 0 ? DisturbanceFrame::kEarth : DisturbanceFrame::kBody;
    if (seed % 3 == 0) m.command_timeout = 0.05;
    CHECK(arrival_does_not_matter(m, seed, 4.0 + static_cast<double>(seed), 0.5));
  }
}

TEST_CASE(
    "so it is with a latency for each pair of thrusters, below zero or long, and without lag") {
  for (const double latency : {-0.21, 0.33}) {
    for (const bool lag : {true, false}) {
      OnboardModel m = onboard::model();
      m.chain = boats::full_chain(Scheme::kAlwaysForward, lag);
      auto q = boats::full_constants();
      q[boats::kLatencyA] = latency;
      std::copy(q.begin(), q.end(), m.q);
      CHECK(arrival_does_not_matter(m, 31, 5.0, 0.5));
    }
  }
}

TEST_CASE("and where pose errors are correlated") {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    CHECK(arrival_does_not_matter(onboard::coloured_model(), seed, 5.0, 0.5));
    CHECK(arrival_does_not_matter(onboard::swinging_model(), seed, 5.0, 0.5));
  }
}

TEST_CASE("and where positions and headings are late, alike or not") {
  for (const auto& [position, heading] :
       {std::pair{0.2, 0.2}, {0.2, 0.0}, {0.05, 0.3}, {-0.1, 0.1}}) {
    for (OnboardModel m : {onboard::model(), onboard::swinging_model()}) {
      m.position_delay = position;
      m.heading_delay = heading;
      CHECK(arrival_does_not_matter(m, 5, 5.0, 0.5));
    }
  }
}

TEST_CASE("a pose's position and heading at two times are those of two whole poses") {
  // at 15 Hz 0.2 s are three poses: each stamp has the position of the third before it
  OnboardModel m = onboard::model();
  m.position_delay = 0.2;
  auto plain = fresh();
  auto split = fresh(m);
  std::vector<Input> poses;
  for (Input in : drive(3, 12.0)) {
    give(*plain, in);
    if (in.pose) {
      poses.push_back(in);
      if (poses.size() < 4) continue;
      const Input& before = poses[poses.size() - 4];
      std::copy(before.values, before.values + 2, in.values);
      in.time = before.time + 0.2;
    }
    REQUIRE(give(*split, in) == Taken::kUsed);
  }
  const double end = poses.back().time;
  const Estimate want = plain->at(end);
  const Estimate got = split->at(end);
  CHECK((got.health & (kNoPose | kGateRejecting | kReinitialised)) == 0U);
  for (int i = 0; i < kPose; ++i) CHECK(got.pose[i] == doctest::Approx(want.pose[i]).epsilon(0.02));
}

TEST_CASE("later inputs do not change the past") {
  const std::vector<Input> inputs = troubled(17, 9.0);
  auto p = fresh();
  auto q = fresh();
  for (const Input& in : inputs) {
    give(*p, in);
    give(*q, in);
    if (!in.pose) continue;
    const Estimate now = p->at(in.time);
    const Estimate again = q->at(in.time);
    CHECK(same(now, again));
    CHECK(now.last_pose <= in.time);
  }
}

TEST_CASE("without poses it moves as the plant: one step, one chain, one latency") {
  const std::vector<Input> inputs = drive(3, 12.0);
  const OnboardModel m = onboard::model();
  auto p = fresh(m);
  const Structure s = boats::mallard();
  const auto coefficients = boats::mallard_coefficients();
  auto plant = std::make_unique<Plant>(s, coefficients.data(), onboard::chain(), m.q, 1.0 / 60.0);
  const double origin[kPose] = {0.0, 0.0, 0.0};
  REQUIRE(p->pose(0.0, origin) == Taken::kUsed);
  Worst worst;
  for (const Input& in : inputs) {
    if (in.pose) continue;
    plant->advance_to(in.time);
    plant->command(in.time, in.values);
    give(*p, in);
    const Estimate e = p->at(in.time);
    const double* x = plant->state();
    worst.see(e.pose[0], x[0]);
    worst.see(e.pose[1], x[1]);
    worst.see(e.pose[2], wrap(x[2]));
    for (int a = 0; a < kAxes; ++a) worst.see(e.velocity[a], x[3 + a]);
  }
  CHECK(worst.value() < 1e-7);  // the steps are cut elsewhere
}

namespace {

/// A minute along the truth.
struct Followed {
  int n = 0;              // poses
  double largest = 0.0;   // [m] error of the position
  double position = 0.0;  // [m] RMS error of x
  double velocity = 0.0;  // [m/s] RMS error of u
  double nees = 0.0;      // mean
};

/// memory: [s] of the poses' errors.
Followed follow(const OnboardModel& m, std::uint64_t seed, double memory = 0.0) {
  auto p = fresh(m);
  onboard::Sea sea(seed, memory);
  Followed out;
  for (;;) {
    const Input in = sea.next();
    if (in.time > 60.0) break;
    REQUIRE(give(*p, in) == Taken::kUsed);
    if (!in.pose || in.time < 5.0) continue;
    const Estimate e = p->at(in.time);
    const double* x = sea.truth();
    double off[kStates];
    double l[kStates][kStates];
    for (int i = 0; i < kStates; ++i) {
      off[i] = i < kPose ? e.pose[i] - x[i] : e.velocity[i - kPose] - x[i];
    }
    off[2] = wrap(off[2]);
    out.position += off[0] * off[0];
    out.velocity += off[3] * off[3];
    out.largest = std::max(out.largest, std::hypot(off[0], off[1]));
    for (int i = 0; i < kStates; ++i) {  // NEES by Cholesky
      for (int j = 0; j <= i; ++j) {
        double left = e.covariance[i][j];
        for (int k = 0; k < j; ++k) left -= l[i][k] * l[j][k];
        l[i][j] = i == j ? std::sqrt(left) : left / l[j][j];
      }
      for (int k = 0; k < i; ++k) off[i] -= l[i][k] * off[k];
      off[i] /= l[i][i];
      out.nees += off[i] * off[i];
    }
    ++out.n;
  }
  out.nees /= out.n;
  out.position = std::sqrt(out.position / out.n);
  out.velocity = std::sqrt(out.velocity / out.n);
  return out;
}

}  // namespace

TEST_CASE("it follows a noisy drive within what it says, and better than its poses") {
  const Followed got = follow(onboard::model(), 8);
  CHECK(got.n > 800);
  CHECK(got.position < 0.6 * onboard::kNoise[0]);
  CHECK(got.largest < 0.01);
  CHECK(got.nees < 6.5);  // the truth has no disturbance: it may be more careful than need be
  CHECK(got.nees > 1.0);
}

TEST_CASE("correlated pose errors are not taken for motion, nor for news") {
  for (std::uint64_t seed = 8; seed < 11; ++seed) {
    const Followed told = follow(onboard::coloured_model(), seed, onboard::kMemory);
    const Followed not_told = follow(onboard::model(), seed, onboard::kMemory);
    CHECK(told.nees < 6.5);
    CHECK(told.nees > 1.0);
    CHECK(not_told.nees > 10.0);
    CHECK(told.velocity < not_told.velocity);
    CHECK(told.position < onboard::kNoise[0]);
  }
}

TEST_CASE("no input makes it allocate on the heap") {
  const auto inputs = late(troubled(5, 8.0), 6, 0.5);
  auto p = fresh();
  const long before = allocations;
  double sum = 0.0;
  for (const Input& in : inputs) {
    give(*p, in);
    sum += p->at(in.time).pose[0];
  }
  p->forget();
  CHECK(allocations == before);
  CHECK(std::isfinite(sum));
}

TEST_CASE("a current moves the boat over ground, and is in its velocity") {
  OnboardModel m = onboard::model();
  m.boat.current[0] = 0.2;
  m.boat.current[1] = -0.1;
  auto p = fresh(m);
  const double start[kPose] = {1.0, 2.0, kPi / 2.0};
  const double still[kMaxCommands] = {};
  p->command(0.0, still);
  REQUIRE(p->pose(0.0, start) == Taken::kUsed);
  const Estimate e = p->at(5.0);
  CHECK(e.pose[0] == doctest::Approx(2.0));
  CHECK(e.pose[1] == doctest::Approx(1.5));
  CHECK(e.velocity[0] == doctest::Approx(-0.1));
  CHECK(e.velocity[1] == doctest::Approx(-0.2));
  CHECK(onboard::sound(e));
  m.boat.current[0] = m.boat.current[1] = 0.0;
  auto q = fresh(m);
  q->command(0.0, still);
  q->pose(0.0, start);
  const double turned = e.covariance[2][2];
  const Estimate without = q->at(5.0);  // an unsure heading makes the velocity over ground unsure
  CHECK(e.covariance[3][3] - without.covariance[3][3] ==
        doctest::Approx(0.2 * 0.2 * turned + 2.0 * -0.2 * without.covariance[2][3]));
}
