// SPDX-License-Identifier: MIT
// What of a model's covariance matters on board: the few causes that explain nearly all that errors
// of its parameters do to the velocity. Host side: uses heap.
//
// Along a drive the errors e (covariance C = R R') make the velocity wrong by S e, S = d nu / d
// parameters. With e = R z the causes z are independent; the principal directions U of R' W R, W
// the sum of S' S over the drive, each axis in parts of its own mean square, sort them by what they
// do. Errors that cancel where the boat goes cancel in S.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <vector>

#include "seatrial/belief.hpp"
#include "seatrial/health.hpp"
#include "seatrial/schedule.hpp"

namespace seatrial {

inline constexpr int kMaxParameters = kMaxCoefficients + kMaxConstants;

/// A model, with what is known of its errors and where it was identified.
struct UncertainModel {
  Boat boat;
  Chain chain;
  double q[kMaxConstants] = {};
  double speed[kAxes][2] = {};                             // [m/s, m/s, rad/s] least, most
  double covariance[kMaxParameters][kMaxParameters] = {};  // coefficients, then constants

  int n_parameters() const { return boat.structure.n_coefficients + chain.n_constants; }
};

namespace detail {

inline constexpr double kHold[2] = {1.0, 3.0};    // [s] that a command is held
inline constexpr double kTick = 0.1;              // [s] between the instants that are summed over
inline constexpr int kTicks = 6000;               // ten minutes
inline constexpr int kEnough = kTicks / 10;       // instants that a sum is made of
inline constexpr int kPiece = 100;                // ticks that are scheduled at once
inline constexpr double kGentlest = 1.0 / 64;     // share of full commands
inline constexpr double kScaled[2] = {0.7, 1.0};  // of its reference that a scale signal is

/// Less is not believed, so that the covariance keeps its digits.
inline constexpr MotionNoise kLeastNoise{1e-4, 1e-4, 1e-6, 1e-6, 1e-5, 1e-5, 0.3, 1e-5, 1e-5, 0.02};

/// Splitmix64: the same numbers on every machine.
class Dice {
 public:
  double operator()(double low, double high) {
    std::uint64_t z = state_ += 0x9e3779b97f4a7c15U;
    z = (z ^ (z >> 30U)) * 0xbf58476d1ce4e5b9U;
    z = (z ^ (z >> 27U)) * 0x94d049bb133111ebU;
    z ^= z >> 31U;
    return low + (high - low) * std::ldexp(static_cast<double>(z >> 11U), -53);
  }

 private:
  std::uint64_t state_ = 0;
};

/// Commands and scale signals of a drive, each to any other.
struct Sticks {
  int n_commands;
  int n_scales;
  std::vector<double> time;   // [s]
  std::vector<double> value;  // rows of commands
  std::vector<double> scale;  // rows of scales

  Sticks(const Chain& c, double most) : n_commands(c.allocation.n_commands), n_scales(c.n_scales) {
    Dice dice;
    Dice other;
    double t = 0.0;
    while (t < kTick * kTicks) {
      time.push_back(t);
      for (int j = 0; j < n_commands; ++j) value.push_back(dice(-most, most));
      for (int j = 0; j < n_scales; ++j) {
        scale.push_back(c.scale_reference[j] * other(kScaled[0], kScaled[1]));
      }
      t += dice(kHold[0], kHold[1]);
    }
  }

  Held commands() const {
    return {static_cast<int>(time.size()), n_commands, time.data(), value.data()};
  }
  Held scales() const {
    return {n_scales > 0 ? static_cast<int>(time.size()) : 0, n_scales, time.data(), scale.data()};
  }
};

/// All coefficients and constants.
inline Columns all_columns(const UncertainModel& m) {
  Columns columns;
  columns.n_coefficients = m.boat.structure.n_coefficients;
  columns.n_constants = m.chain.n_constants;
  for (int i = 0; i < columns.n_coefficients; ++i) columns.coefficient[i] = i;
  for (int i = 0; i < columns.n_constants; ++i) columns.constant[i] = i;
  return columns;
}

/// A square matrix on the heap.
class Square {
 public:
  explicit Square(int n) : n_(n), a_(static_cast<std::size_t>(n) * static_cast<std::size_t>(n)) {}
  int size() const { return n_; }
  double& operator()(int i, int j) { return a_[place(i, j)]; }
  double operator()(int i, int j) const { return a_[place(i, j)]; }

 private:
  std::size_t place(int i, int j) const {
    return static_cast<std::size_t>(i) * static_cast<std::size_t>(n_) + static_cast<std::size_t>(j);
  }
  int n_;
  std::vector<double> a_;
};

/// Eigenvalues on the diagonal of a symmetric matrix, by Jacobi's rotations (Golub and Van Loan,
/// 8.5); columns of v: the eigenvectors.
inline void diagonalise(Square& a, Square& v) {
  constexpr int kSweeps = 30;
  const int n = a.size();
  for (int i = 0; i < n; ++i) v(i, i) = 1.0;
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    bool turned = false;
    for (int p = 0; p < n; ++p) {
      for (int q = p + 1; q < n; ++q) {
        const double off = a(p, q);
        if (!(std::abs(off) > 1e-15 * std::sqrt(std::abs(a(p, p) * a(q, q))))) continue;
        turned = true;
        const double theta = 0.5 * (a(q, q) - a(p, p)) / off;
        const double t = std::copysign(1.0, theta) / (std::abs(theta) + std::hypot(theta, 1.0));
        const double c = 1.0 / std::hypot(t, 1.0);
        const double s = t * c;
        for (int i = 0; i < n; ++i) {
          const double x = a(i, p);
          a(i, p) = c * x - s * a(i, q);
          a(i, q) = s * x + c * a(i, q);
        }
        for (int i = 0; i < n; ++i) {
          const double x = a(p, i);
          a(p, i) = c * x - s * a(q, i);
          a(q, i) = s * x + c * a(q, i);
          const double y = v(i, p);
          v(i, p) = c * y - s * v(i, q);
          v(i, q) = s * y + c * v(i, q);
        }
      }
    }
    if (!turned) break;
  }
}

/// What a drive adds up to, axis by axis.
struct DriveSums {
  std::vector<Square> slopes;  // S' S
  int instants = 0;            // within the envelope

  explicit DriveSums(int n) : slopes(kStates, Square(n)) {}

  /// False where the numbers are none.
  bool add(const StateTangent& dx, int n) {
    double size = 0.0;
    for (const auto& row : dx.row) {
      for (int i = 0; i < n; ++i) size += std::abs(row[i]);
    }
    if (!std::isfinite(size)) return false;
    for (int state = 0; state < kStates; ++state) {
      const double* s = dx.row[state];
      Square& sum = slopes[static_cast<std::size_t>(state)];
      for (int i = 0; i < n; ++i) {
        for (int j = 0; j < n; ++j) sum(i, j) += s[i] * s[j];
      }
    }
    ++instants;
    return true;
  }
};

/// A drive from rest with commands up to `most`; where it is outside the envelope is not counted.
inline DriveSums random_drive(const UncertainModel& m, double most) {
  const Columns columns = all_columns(m);
  const Sticks sticks(m.chain, most);
  const Trace trace(m.chain, m.q, sticks.commands(), sticks.scales(), columns);
  Boat boat = m.boat;
  boat.integrator = Integrator::kRungeKutta;
  boat.longest_step = kTick;
  std::vector<double> time;
  for (int i = 0; i <= kTicks; ++i) time.push_back(kTick * i);
  DriveSums sum(m.n_parameters());
  double x[kStates] = {};
  StateTangent dx;
  seed(columns, dx);
  for (int i = 0; i < kTicks; i += kPiece) {
    for (int a = 0; a < kSeen; ++a) std::fill(dx.row[a], dx.row[a] + columns.size(), 0.0);
    const Schedule schedule(boat, trace, time.data(), i, i + kPiece, true);
    for (int k = i; k < i + kPiece; ++k) {
      bool good = schedule.run(k, x, dx);
      if (good && !Envelope::outside(x + 3, m.speed, kAxes)) good = sum.add(dx, m.n_parameters());
      if (good) continue;  // else at rest again
      std::fill(x, x + kStates, 0.0);
      seed(columns, dx);
    }
  }
  return sum;
}

/// R with C = R R'.
inline Square root_of(const double (*c)[kMaxParameters], int n) {
  Square values(n);
  Square root(n);
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) values(i, j) = 0.5 * (c[i][j] + c[j][i]);
  }
  diagonalise(values, root);
  for (int k = 0; k < n; ++k) {
    const double length = std::sqrt(std::max(values(k, k), 0.0));
    for (int i = 0; i < n; ++i) root(i, k) *= length;
  }
  return root;
}

/// R' W R, W of the axes in parts of what C does to each of them.
inline Square effects(const DriveSums& sum, const Square& root) {
  const int n = root.size();
  Square out(n);
  for (const Square& w : sum.slopes) {
    Square half(n);
    Square own(n);
    double trace = 0.0;
    for (int i = 0; i < n; ++i) {
      for (int k = 0; k < n; ++k) {
        if (w(i, k) == 0.0) continue;
        for (int j = 0; j < n; ++j) half(i, j) += w(i, k) * root(k, j);
      }
    }
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j < n; ++j) {
        for (int k = 0; k < n; ++k) own(i, j) += root(k, i) * half(k, j);
      }
      trace += own(i, i);
    }
    if (!(trace > 0.0)) continue;
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j < n; ++j) out(i, j) += own(i, j) / trace;
    }
  }
  return out;
}

/// R U of the largest eigenvalues.
inline Considered principal(const UncertainModel& m, const DriveSums& sum) {
  const int n = m.n_parameters();
  const int own = m.boat.structure.n_coefficients;
  const Square root = root_of(m.covariance, n);
  Square values = effects(sum, root);
  Square turn(n);
  diagonalise(values, turn);
  std::vector<int> order(static_cast<std::size_t>(n));
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](int i, int j) { return values(i, i) > values(j, j); });
  Considered out;
  for (const int k : order) {
    if (out.n == kMostConsidered || !(values(k, k) > 0.0)) break;
    for (int i = 0; i < n; ++i) {
      double& to = i < own ? out.coefficient[i][out.n] : out.constant[i - own][out.n];
      for (int j = 0; j < n; ++j) to += root(i, j) * turn(j, k);
    }
    ++out.n;
  }
  return out;
}

}  // namespace detail

/// The causes that matter most under random commands up to the stops, or as strong as leave the
/// boat within its envelope for a tenth of the time. None where no such command is found.
inline Considered doubt(const UncertainModel& m) {
  bool doubted = false;
  for (int i = 0; i < m.n_parameters(); ++i) doubted = doubted || m.covariance[i][i] > 0.0;
  for (double most = 1.0; doubted && most >= detail::kGentlest; most *= 0.5) {
    const detail::DriveSums sum = detail::random_drive(m, most);
    if (sum.instants >= detail::kEnough) return detail::principal(m, sum);
  }
  return {};
}

/// The noise that the on-board filter believes: the model's own, as far as it is large enough.
inline MotionNoise believed_noise(const MotionNoise& own) {
  const MotionNoise& least = detail::kLeastNoise;
  MotionNoise n = own;
  n.position = std::max(own.position, least.position);
  n.heading = std::max(own.heading, least.heading);
  n.walk_linear = std::max(own.walk_linear, least.walk_linear);
  n.walk_yaw = std::max(own.walk_yaw, least.walk_yaw);
  n.disturbance_linear = std::max(own.disturbance_linear, least.disturbance_linear);
  n.disturbance_yaw = std::max(own.disturbance_yaw, least.disturbance_yaw);
  n.memory = std::max(own.memory, least.memory);
  if (!own.coloured()) return n;
  n.colour_position = std::max(own.colour_position, least.colour_position);
  n.colour_heading = std::max(own.colour_heading, least.colour_heading);
  n.colour_memory = std::max(own.colour_memory, least.colour_memory);
  return n;
}

}  // namespace seatrial
