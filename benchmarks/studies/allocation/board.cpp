// SPDX-License-Identifier: MIT
// Time of an allocation on board: random thrusters, wrenches from rest to far beyond the limits.
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <random>
#include <vector>

#include "seatrial/control/allocator.hpp"

namespace {

using namespace seatrial;
using Clock = std::chrono::steady_clock;

constexpr int kBoats = 20;
constexpr int kWrenches = 2000;
constexpr int kRepeats = 10;  // of each call; the fastest counts, so that other programs do not
constexpr int kSetups = 3;    // of each boat
constexpr const char* kNames[] = {"moore-penrose", "always-forward", "null-space", "sign-pattern",
                                  "auto"};

AllocatorSetup random_boat(std::mt19937& random, int n, AllocatorScheme scheme) {
  std::uniform_real_distribution<double> u(-1.0, 1.0);
  AllocatorSetup s;
  s.scheme = scheme;
  s.hysteresis = 0.02;
  s.rank[0] = s.rank[1] = 1;  // yaw first
  s.effectiveness.n = n;
  s.chain.allocation.n_actuators = n;
  s.chain.n_constants = 2;
  s.q[0] = 0.08;
  s.q[1] = 1.5;
  for (int k = 0; k < n; ++k) {
    const double angle = 3.14159 * u(random);
    const double x = u(random);
    const double y = 0.5 * u(random);
    s.effectiveness.column[k][0] = std::cos(angle);
    s.effectiveness.column[k][1] = std::sin(angle);
    s.effectiveness.column[k][2] = x * std::sin(angle) - y * std::cos(angle);
    s.chain.actuators[k].edge_forward = s.chain.actuators[k].edge_reverse = 0;
    s.chain.actuators[k].power = 1;
    s.limit[k] = 1.0;
    s.idle_forward[k] = s.idle_reverse[k] = 0.12;
  }
  return s;
}

/// Microseconds of each call. The whole course is repeated, each time from the same state, so that
/// a call's repeats are far apart.
void time_boat(std::mt19937& random, const Allocator& made, std::vector<double>& out) {
  std::uniform_real_distribution<double> u(-1.5, 1.5);
  std::vector<std::array<double, 3>> wrenches(kWrenches);
  for (auto& wrench : wrenches) wrench = {u(random), u(random), u(random)};
  std::vector<double> best(kWrenches, 1e9);
  for (int r = 0; r < kRepeats; ++r) {
    Allocator a = made;
    for (std::size_t i = 0; i < wrenches.size(); ++i) {
      double command[kMaxActuators];
      const auto begin = Clock::now();
      a.allocate(wrenches[i].data(), command);
      const auto end = Clock::now();
      best[i] = std::min(best[i], std::chrono::duration<double, std::micro>(end - begin).count());
    }
  }
  out.insert(out.end(), best.begin(), best.end());
}

/// Milliseconds to make an allocator, the fastest of some.
double time_setup(const AllocatorSetup& s) {
  double best = 1e9;
  for (int r = 0; r < kSetups; ++r) {
    const auto begin = Clock::now();
    const Allocator made(s);
    const auto end = Clock::now();
    best = std::min(best, std::chrono::duration<double, std::milli>(end - begin).count());
  }
  return best;
}

}  // namespace

int main() {
  std::printf("%-15s %9s %12s %12s %12s %12s\n", "scheme", "thrusters", "median, us", "99.9 %, us",
              "worst, us", "set-up, ms");
  for (const AllocatorScheme scheme :
       {AllocatorScheme::kMoorePenrose, AllocatorScheme::kNullSpace, AllocatorScheme::kSignPattern,
        AllocatorScheme::kAutomatic}) {
    for (const int n : {4, 6, 8}) {
      std::mt19937 random(static_cast<unsigned>(n));
      std::vector<double> times;
      double setup = 0.0;
      for (int boat = 0; boat < kBoats;) {
        const AllocatorSetup s = random_boat(random, n, scheme);
        const Allocator made(s);
        if (made.fault() != AllocatorFault::kOk) continue;
        setup = std::max(setup, time_setup(s));
        time_boat(random, made, times);
        ++boat;
      }
      std::sort(times.begin(), times.end());
      const auto at = [&](double share) {
        return times[static_cast<std::size_t>(share * static_cast<double>(times.size() - 1))];
      };
      std::printf("%-15s %9d %12.2f %12.2f %12.2f %12.1f\n", kNames[static_cast<int>(scheme)], n,
                  at(0.5), at(0.999), at(1.0), setup);
    }
  }
  return 0;
}
