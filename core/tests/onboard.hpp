// SPDX-License-Identifier: MIT
// A boat on the water for the tests and timings of the on-board predictor: the truth, its commands,
// its noisy poses. Same numbers on every machine but for the last bits of sin, cos and exp.
#pragma once
#include <cmath>
#include <cstdint>
#include <cstring>
#include <memory>
#include <vector>

#include "boats.hpp"
#include "seatrial/onboard/predictor.hpp"
#include "seatrial/simulation/plant.hpp"

namespace onboard {

using namespace seatrial;  // NOLINT(google-build-using-namespace)

inline constexpr double kCommandPeriod = 0.01;           // [s]
inline constexpr double kPosePeriod = 1.0 / 15.0;        // [s]
inline constexpr double kNoise[3] = {4e-3, 4e-3, 4e-3};  // [m, m, rad]

/// Constants of the chain.
enum { kLatency, kEdge, kLag, kConstants };

inline Chain chain() {
  Chain c = boats::plain_chain(Scheme::kMoorePenrose);
  c.n_constants = kConstants;
  for (int k = 0; k < c.n_actuators(); ++k) {
    Actuator& a = c.actuators[k];
    a.latency = kLatency;
    a.edge_forward = a.edge_reverse = kEdge;
    a.lag = kLag;
  }
  return c;
}

/// Errors of a hundredth of each coefficient, and of 1 ms or 0.001, as many causes as there may be.
inline void add_errors(OnboardModel& m) {
  boats::Random random(77);
  PrincipalErrors& d = m.boat.considered;
  d.n = kMostConsidered;
  for (int i = 0; i < m.boat.structure.n_coefficients - kAxes; ++i) {
    const double most = 0.01 * std::abs(m.boat.coefficient[i]);
    random.fill(d.coefficient[i], d.n, -most, most);
  }
  for (int i = 0; i < kConstants; ++i) random.fill(d.constant[i], d.n, -1e-3, 1e-3);
}

/// The paper's boat with dead zone, lag and latency, none of them known to the last digit.
inline OnboardModel model() {
  OnboardModel m;
  m.boat.structure = boats::mallard();
  const auto coefficients = boats::mallard_coefficients();
  std::copy(coefficients.begin(), coefficients.end(), m.boat.coefficient);
  add_disturbance(m.boat.structure);
  m.chain = chain();
  const double q[kConstants] = {0.03, 0.08, 0.08};
  std::copy(q, q + kConstants, m.q);
  m.boat.noise = {kNoise[0], kNoise[2], 1e-3, 3e-3, 5e-3, 2e-2, 2.0};
  add_errors(m);
  return m;
}

inline constexpr double kMemory = 0.3;  // [s] of correlated pose errors
inline constexpr double kSwing = 2.5;   // [rad/s] of such that swing

/// The same told that all but a tenth of its pose noise is correlated.
inline OnboardModel coloured_model() {
  OnboardModel m = model();
  NoiseParameters& n = m.boat.noise;
  n.position = 0.1 * kNoise[0];
  n.heading = 0.1 * kNoise[2];
  n.colour_position = kNoise[0];
  n.colour_heading = kNoise[2];
  n.colour_memory = kMemory;
  return m;
}

/// The same told that what is correlated swings, as waves make it.
inline OnboardModel swinging_model() {
  OnboardModel m = coloured_model();
  m.boat.noise.colour_memory = 3.0;
  m.boat.noise.colour_turn = kSwing;
  return m;
}

/// Sum of twelve: nearly normal, without a function that machines compute differently.
inline double normal(boats::Random& random) {
  double sum = -6.0;
  for (int i = 0; i < 12; ++i) sum += random(0.0, 1.0);
  return sum;
}

/// An input of the predictor.
struct Input {
  double time = 0.0;
  bool pose = false;
  double values[3] = {};
};

inline Taken give(Predictor& p, const Input& in) {
  return in.pose ? p.pose(in.time, in.values) : p.command(in.time, in.values);
}

/// The truth, driven by random pulses: it makes the inputs of a drive, in the order of their
/// stamps. memory: [s] of the poses' errors; 0: white.
class Sea {
 public:
  explicit Sea(std::uint64_t seed, double memory = 0.0)
      : stays_(memory > 0.0 ? std::exp(-kPosePeriod / memory) : 0.0),
        random_(seed),
        structure_(boats::mallard()),
        coefficients_(boats::mallard_coefficients()),
        plant_(structure_, coefficients_.data(), chain(), model().q, 1.0 / 60.0) {}

  /// The next command or pose.
  Input next() {
    const double command = kCommandPeriod * commands_;
    const double pose = 0.0137 + kPosePeriod * poses_;
    Input in;
    in.pose = pose < command;
    in.time = in.pose ? pose : command;
    plant_.advance_to(in.time);
    if (in.pose) {
      ++poses_;
      for (int i = 0; i < 3; ++i) {
        error_[i] = stays_ * error_[i] + std::sqrt(1.0 - stays_ * stays_) * normal(random_);
        in.values[i] = plant_.state()[i] + kNoise[i] * error_[i];
      }
      return in;
    }
    if (commands_++ % 70 == 0) random_.fill(stick_, 3, -1.0, 1.0);
    if (commands_ % 70 > 40) std::fill(stick_, stick_ + 3, 0.0);
    std::copy(stick_, stick_ + 3, in.values);
    plant_.command(in.time, in.values);
    return in;
  }

  /// x, y, psi, u, v, r at the time of the last input.
  const double* truth() const { return plant_.state(); }
  boats::Random& random() { return random_; }

 private:
  double stays_;          // of an error until the next pose
  double error_[3] = {};  // in standard deviations
  boats::Random random_;
  Structure structure_;
  std::vector<double> coefficients_;
  Plant plant_;
  double stick_[3] = {};
  int commands_ = 0;
  int poses_ = 0;
};

/// The inputs of so many seconds.
inline std::vector<Input> drive(std::uint64_t seed, double seconds, double memory = 0.0) {
  std::vector<Input> all;
  for (Sea sea(seed, memory);;) {
    all.push_back(sea.next());
    if (all.back().time >= seconds) return all;
  }
}

/// Whether the first n rows and columns are symmetric with a Cholesky root.
template <int N>
bool positive(const double (&p)[N][N], int n = N) {
  double l[N][N];
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j <= i; ++j) {
      if (p[i][j] != p[j][i]) return false;
      double sum = p[i][j];
      for (int k = 0; k < j; ++k) sum -= l[i][k] * l[j][k];
      if (i == j && !(sum > 0.0)) return false;
      l[i][j] = i == j ? std::sqrt(sum) : sum / l[j][j];
    }
  }
  return true;
}

/// Whether numbers are the same to the last bit.
inline bool same_bits(const double* a, const double* b, int n) {
  for (int i = 0; i < n; ++i) {
    std::uint64_t x = 0;
    std::uint64_t y = 0;
    std::memcpy(&x, a + i, sizeof(x));
    std::memcpy(&y, b + i, sizeof(y));
    if (x != y) return false;
  }
  return true;
}

/// Whether an estimate is numbers, with a covariance.
inline bool sound(const Estimate& e) {
  const auto good = [](double x) { return std::isfinite(x); };
  return std::isfinite(e.time) && std::all_of(e.pose, e.pose + kPose, good) &&
         std::all_of(e.velocity, e.velocity + kAxes, good) &&
         std::all_of(e.disturbance, e.disturbance + kAxes, good) && positive(e.covariance);
}

/// A predictor that has heard nothing.
inline std::unique_ptr<Predictor> fresh(const OnboardModel& m = model()) {
  return std::make_unique<Predictor>(m);
}

inline bool has(const Estimate& e, Health flag) { return (e.health & flag) != 0U; }

/// From the truth [m].
inline double away(const Estimate& e, const double* truth) {
  return std::hypot(e.pose[0] - truth[0], e.pose[1] - truth[1]);
}

/// Drives until t [s]; `spoil` may change a pose.
template <class Spoil>
void until(Predictor& p, Sea& sea, double t, Spoil spoil) {
  for (;;) {
    Input in = sea.next();
    if (in.pose) spoil(in);
    give(p, in);
    if (in.time >= t) return;
  }
}

inline void until(Predictor& p, Sea& sea, double t) {
  until(p, sea, t, [](const Input& in) { (void)in; });
}

}  // namespace onboard
