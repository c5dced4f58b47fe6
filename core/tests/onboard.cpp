// SPDX-License-Identifier: MIT
// The on-board predictor as a program of its own, as it would run on a small computer:
//   onboard script            a drive with late, wrong and missing inputs; prints estimates
//   onboard time              what a step costs on this machine
//   onboard soak STEPS SEED   random inputs of every kind; fails on whatever is not sound
// With `coloured` after it: by a model whose pose errors are correlated.
#include "onboard.hpp"

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <iterator>
#include <memory>

#include "heap.hpp"

namespace {

using namespace onboard;  // NOLINT(google-build-using-namespace)
using Clock = std::chrono::steady_clock;

double microseconds(Clock::time_point from) {
  return std::chrono::duration<double, std::micro>(Clock::now() - from).count();
}

void print(const Estimate& e) {
  std::printf("%.17g %u", e.time, static_cast<unsigned>(e.health));
  for (const double x : e.pose) std::printf(" %.17g", x);
  for (const double x : e.velocity) std::printf(" %.17g", x);
  for (const auto& row : e.covariance) {
    for (const double x : row) std::printf(" %.17g", x);
  }
  std::printf("\n");
}

/// 20 s: late poses, a burst of false matches, a stretch without poses.
int script(const OnboardModel& m) {
  auto p = std::make_unique<Predictor>(m);
  const std::vector<Input> inputs = drive(5, 20.0);
  std::vector<Input> late;
  int poses = 0;
  for (Input in : inputs) {
    if (in.pose) {
      ++poses;
      if (poses >= 100 && poses < 105) in.values[0] += 0.7;
      if (in.time > 12.0 && in.time < 14.0) continue;
      if (poses % 3 == 0) {
        late.push_back(in);
        continue;
      }
    }
    give(*p, in);
    if (!late.empty() && in.time > late.front().time + 0.2) {
      give(*p, late.front());
      late.erase(late.begin());
    }
    if (!in.pose) print(p->at(in.time + 0.05));
  }
  return 0;
}

/// Shortest of many runs of `work`, which makes `n` steps.
template <class Work>
double shortest(int n, Work work) {
  double best = 1e30;
  for (int i = 0; i < 15; ++i) {
    const auto begin = Clock::now();
    work();
    best = std::min(best, microseconds(begin) / n);
  }
  return best;
}

/// Median and 99th percentile [us] of single steps.
void show(const char* what, std::vector<double>& each) {
  std::sort(each.begin(), each.end());
  const auto at = [&each](double share) {
    return each[static_cast<std::size_t>(share * static_cast<double>(each.size() - 1))];
  };
  std::printf("%-44s %8.2f %8.2f\n", what, at(0.5), at(0.99));
}

int timing(const OnboardModel& m) {
  auto p = std::make_unique<Predictor>(m);
  const std::vector<Input> inputs = drive(6, 120.0);
  std::vector<double> look;
  std::vector<double> command;
  std::vector<double> pose;
  for (const Input& in : inputs) {
    const auto begin = Clock::now();
    give(*p, in);
    (in.pose ? pose : command).push_back(microseconds(begin));
    if (in.pose) continue;
    const auto asked = Clock::now();
    const Estimate e = p->at(in.time);
    look.push_back(microseconds(asked));
    if (!sound(e)) return 1;
  }
  // one step of the filter alone: 10 ms of boat, thrusters and covariance; one pose
  PredictorState now;
  now.initialised = true;
  detail::reset_to_unknown(m, now.state);
  for (int k = 0; k < m.chain.n_actuators(); ++k) {
    now.thrust.multiplier[k] = 1.0;
    now.thrust.target[k] = 0.3;
  }
  PoseSample at_origin;
  for (int i = 0; i < kPose; ++i) at_origin.noise[i][i] = kNoise[i] * kNoise[i];
  const double predict = shortest(10000, [&m, now]() mutable {
    for (int i = 0; i < 10000; ++i) propagate(m, kCommandPeriod, now);
    if (!plausible(now.state)) std::abort();
  });
  const double correct = shortest(10000, [&m, now, &at_origin]() mutable {
    for (int i = 0; i < 10000; ++i) update_by_pose(m, at_origin, now);
    if (!plausible(now.state)) std::abort();
  });
  // a pose that is half a second late: all after it again
  std::vector<double> replay;
  auto q = std::make_unique<Predictor>(m);
  Input kept;
  for (const Input& in : inputs) {
    if (in.pose && kept.time == 0.0) {
      kept = in;
      continue;
    }
    give(*q, in);
    if (kept.time > 0.0 && in.time >= kept.time + 0.49) {
      const auto begin = Clock::now();
      if (give(*q, kept) != Taken::kUsed) return 1;
      replay.push_back(microseconds(begin));
      kept = Input{};
    }
  }
  std::printf("%-44s %8s %8s\n", "[us]", "median", "99 %");
  std::printf("%-44s %8.2f\n", "predict: a step of 10 ms", predict);
  std::printf("%-44s %8.2f\n", "correct: a pose, gate included", correct);
  show("command() at 100 Hz", command);
  show("at() after each command", look);
  show("pose() in order, with the steps to it", pose);
  show("pose() 0.5 s late: all after it again", replay);
  std::printf("%-44s %8.0f\n", "size of the predictor [kB]", sizeof(Predictor) / 1024.0);
  return 0;
}

/// What goes wrong at sea.
struct Trouble {
  boats::Random& random;
  double silent_until = -1.0;  // [s] no poses
  double mute_until = -1.0;    // [s] no commands
  double clock = 0.0;          // [s] added to stamps
  double jump[3] = {};         // [m, m, rad] of false matches
  int jumps = 0;

  bool chance(double share) { return random(0.0, 1.0) < share; }

  /// False where the input is lost.
  bool spoil(Input& in) {
    if (chance(2e-5)) silent_until = in.time + std::pow(10.0, random(-1.0, 2.3));
    if (chance(1e-5)) mute_until = in.time + std::pow(10.0, random(-1.0, 2.3));
    if (chance(3e-6)) clock += random(-1.0, 1.0) * std::pow(10.0, random(-1.0, 5.0));
    if (in.pose ? in.time < silent_until : in.time < mute_until) return false;
    in.time += clock;
    if (in.pose) spoil_pose(in);
    if (chance(1e-4)) in.time += random(-2.0, 2.0);
    if (chance(1e-5)) in.time += random(-1.0, 1.0) * std::pow(10.0, random(0.0, 12.0));
    if (chance(1e-5)) in.values[static_cast<int>(random(0.0, 3.0))] = odd();
    if (chance(1e-5)) in.time = odd();
    return true;
  }

 private:
  double odd() {
    const double all[5] = {std::nan(""), std::numeric_limits<double>::infinity(), -1e308, 1e7,
                           1e-310};
    return all[static_cast<int>(random(0.0, 5.0))];
  }

  void spoil_pose(Input& in) {
    if (jumps == 0 && chance(0.01)) {
      jumps = 1 + static_cast<int>(random(0.0, chance(0.02) ? 60.0 : 5.0));
      for (double& j : jump) j = random(-2.0, 2.0);
    }
    if (jumps == 0) return;
    --jumps;
    for (int i = 0; i < 3; ++i) in.values[i] += jump[i];
  }
};

int soak(const OnboardModel& m, long steps, std::uint64_t seed) {
  auto p = std::make_unique<Predictor>(m);
  Sea sea(seed);
  Trouble trouble{sea.random()};
  boats::Random& random = sea.random();
  Input late[3];
  const long before = allocations;
  long unsound = 0;
  long flags[std::size(kHealthWords)] = {};
  long taken[6] = {};
  for (long i = 0; i < steps; ++i) {
    Input in = sea.next();
    if (!trouble.spoil(in)) continue;
    if (trouble.chance(0.15)) std::swap(in, late[static_cast<int>(random(0.0, 3.0))]);
    ++taken[static_cast<int>(give(*p, in))];
    if (trouble.chance(1e-6)) p->forget();
    const Estimate e = p->at(in.time + (trouble.chance(0.01) ? random(-1.0, 5.0) : 0.05));
    for (std::size_t k = 0; k < std::size(flags); ++k) flags[k] += (e.health >> k & 1U) != 0U;
    if (!sound(e) && ++unsound < 10) {
      std::printf("step %ld: ", i);
      print(e);
    }
  }
  const long asked = allocations - before;
  std::printf("%ld steps, %ld estimates that are not sound, %ld allocations\n", steps, unsound,
              asked);
  std::printf("inputs used, not a number, stale, ahead, twice, no room:");
  for (const long n : taken) std::printf(" %ld", n);
  std::printf("\nestimates by flag, from no pose to model doubted:");
  for (const long n : flags) std::printf(" %ld", n);
  std::printf("\n");
  return unsound == 0 && asked == 0 ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  const bool coloured = std::strcmp(argv[argc - 1], "coloured") == 0;
  const OnboardModel m = coloured ? coloured_model() : model();
  if (coloured) --argc;
  if (argc == 2 && std::strcmp(argv[1], "script") == 0) return script(m);
  if (argc == 2 && std::strcmp(argv[1], "time") == 0) return timing(m);
  if (argc == 4 && std::strcmp(argv[1], "soak") == 0) {
    return soak(m, std::strtol(argv[2], nullptr, 10), std::strtoull(argv[3], nullptr, 10));
  }
  std::fprintf(stderr, "onboard script | time | soak STEPS SEED [coloured]\n");
  return 2;
}
