// SPDX-License-Identifier: MIT
// Measurement update of the extended Kalman filter by a pose: the same for the estimator and on
// board. No heap, no exceptions.
//
//   e = y - h(x)    S = H P H' + R    K = P H' S^-1    x += K e    P <- (I - K H) P    D -= K (H D)
//
// H picks the pose and adds, where the noise is coloured, its states; of a point off the origin it
// has a share of the heading. Position or heading may be measured alone, or the yaw rate (gyro) in
// the heading's place. An outlier counts as with
// more noise: beyond `outlier` standard deviations its cost grows linearly (Huber).
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>

#include "seatrial/filter/filter_state.hpp"
#include "seatrial/filter/matrix3.hpp"

namespace seatrial {

inline constexpr double kTurn = 6.283185307179586;  // [rad]

/// A pose beside its prediction.
struct Innovation {
  double e[kPose];               // [m, m, rad]
  double s[kPose][kPose];        // its covariance S
  double inverse[kPose][kPose];  // S^-1
  double z[kPose];               // S^-1 e
  double determinant = 0.0;      // of S
  double nis = 0.0;              // e' S^-1 e, the normalised innovation squared
  double weight = 1.0;           // 1; less for an outlier
};

/// Measured parts of a pose.
enum Parts : std::uint8_t {
  kNoPart = 0,
  kPositionPart = 1,
  kHeadingPart = 2,
  kWholePose = 3,
  kRatePart = 4,  // yaw rate, in the place of the heading
};

/// Whether component i of x, y, psi is among the parts.
inline bool has(Parts parts, int i) {
  return (parts & (i < 2 ? kPositionPart : kHeadingPart | kRatePart)) != 0;
}

/// The state that component i measures.
inline int measured_state(Parts parts, int i) {
  return i == 2 && (parts & kRatePart) != 0 ? kStates - 1 : i;
}

/// Whether the sensor's coloured noise adds to component i: a gyro has none.
inline bool has_colour(Parts parts, int i) { return measured_state(parts, i) == i; }

/// A pose as the sensor measures it.
struct Measurement {
  const double* eta;                     // x, y [m], psi [rad]
  double offset[kPose] = {};             // [m, m, rad] of what is measured, earth-fixed
  double turn[kPose] = {0.0, 0.0, 0.0};  // d measured / d psi, beyond the state's
  double noise[kPose][kPose] = {};       // R
  Parts parts = kWholePose;
};

namespace detail {

/// Row `row` times H', column k.
template <int N>
double times_h(const double* row, const Measurement& y, int k) {
  double sum = row[measured_state(y.parts, k)] + row[2] * y.turn[k];
  if constexpr (N > kFilterStates) {
    if (has_colour(y.parts, k)) sum += row[kFilterStates + k];
  }
  return sum;
}

/// Zeroes the rows of what is not measured: of H P and H D.
template <int W>
void leave_out(Parts parts, double (&rows)[kPose][W]) {
  for (int i = 0; i < kPose; ++i) {
    if (!has(parts, i)) std::fill(rows[i], rows[i] + W, 0.0);
  }
}

/// S without what is not measured: unit variance, uncorrelated, no innovation.
inline void leave_out(Parts parts, Innovation& out) {
  for (int i = 0; i < kPose; ++i) {
    if (has(parts, i)) continue;
    for (int j = 0; j < kPose; ++j) out.s[i][j] = out.s[j][i] = 0.0;
    out.s[i][i] = 1.0;
    out.e[i] = 0.0;
  }
}

/// H P.
template <int N, class State>
void measured_covariance(const Measurement& y, const State& b, double (&hp)[kPose][N]) {
  for (int i = 0; i < kPose; ++i) {
    const double* own = b.p[measured_state(y.parts, i)];
    for (int j = 0; j < N; ++j) hp[i][j] = own[j] + y.turn[i] * b.p[2][j];
    if constexpr (N > kFilterStates) {
      if (!has_colour(y.parts, i)) continue;
      for (int j = 0; j < N; ++j) hp[i][j] += b.p[kFilterStates + i][j];
    }
  }
}

/// H D of the first `count` columns.
template <int N, class State>
void measured_columns(const Measurement& y, const State& b, int count,
                      double (&hd)[kPose][State::kColumns]) {
  for (int i = 0; i < kPose; ++i) {
    const double* own = b.d[measured_state(y.parts, i)];
    for (int c = 0; c < count; ++c) hd[i][c] = own[c] + y.turn[i] * b.d[2][c];
    if constexpr (N > kFilterStates) {
      if (!has_colour(y.parts, i)) continue;
      for (int c = 0; c < count; ++c) hd[i][c] += b.d[kFilterStates + i][c];
    }
  }
}

/// The pose beside its prediction. `outlier`: from how many standard deviations on it counts less.
template <int N, class State>
Innovation innovation(const Measurement& y, double outlier, const double (&hp)[kPose][N],
                      const State& b) {
  Innovation out;
  for (int i = 0; i < kPose; ++i) {
    out.e[i] = y.eta[i] - b.x[measured_state(y.parts, i)] - y.offset[i];
    if constexpr (N > kFilterStates) {
      if (has_colour(y.parts, i)) out.e[i] -= b.x[kFilterStates + i];
    }
    for (int j = 0; j < kPose; ++j) {
      out.s[i][j] = times_h<N>(hp[i], y, j);
      out.s[i][j] += y.noise[i][j];
    }
  }
  if (has_colour(y.parts, 2) && std::abs(out.e[2]) > kTurn / 2.0)
    out.e[2] = std::remainder(out.e[2], kTurn);
  if (y.parts != kWholePose) leave_out(y.parts, out);
  out.determinant = inverse3(out.s, out.inverse);
  for (int i = 0; i < kPose; ++i) {
    const double* row = out.inverse[i];
    out.z[i] = row[0] * out.e[0] + row[1] * out.e[1] + row[2] * out.e[2];
    out.nis += out.e[i] * out.z[i];
  }
  const double size = std::sqrt(std::max(0.0, out.nis));
  out.weight = size > outlier ? outlier / size : 1.0;
  return out;
}

/// P -= K H P. Quick, and good enough where the covariance is that of one pass.
struct PlainForm {
  template <int N, class State>
  void operator()(const Innovation&, const double (&gain)[N][kPose], const double (&hp)[kPose][N],
                  State& b) const {
    for (int i = 0; i < N; ++i) {
      for (int j = i; j < N; ++j) {
        b.p[i][j] -= gain[i][0] * hp[0][j] + gain[i][1] * hp[1][j] + gain[i][2] * hp[2][j];
      }
    }
    for (int i = 0; i < N; ++i) {
      for (int j = 0; j < i; ++j) b.p[i][j] = b.p[j][i];
    }
  }
};

/// Joseph's form (I - K H) P (I - K H)' + K R K': positive definite and symmetric whatever the
/// gain's rounding does, for a filter that runs for days.
struct JosephForm {
  const Measurement& y;

  template <int N, class State>
  void operator()(const Innovation& seen, const double (&gain)[N][kPose],
                  const double (&hp)[kPose][N], State& b) const {
    // R of an outlier: S / weight^2 less H P H'
    const double more = 1.0 / (seen.weight * seen.weight) - 1.0;
    double noise[kPose][kPose];
    for (int i = 0; i < kPose; ++i) {
      for (int j = 0; j < kPose; ++j) noise[i][j] = y.noise[i][j] + more * seen.s[i][j];
    }
    double left[N][N];  // (I - K H) P
    for (int i = 0; i < N; ++i) {
      for (int j = 0; j < N; ++j) {
        left[i][j] =
            b.p[i][j] - (gain[i][0] * hp[0][j] + gain[i][1] * hp[1][j] + gain[i][2] * hp[2][j]);
      }
    }
    for (int i = 0; i < N; ++i) {
      double rest[kPose];  // K R - (I - K H) P H'
      for (int k = 0; k < kPose; ++k) {
        rest[k] = gain[i][0] * noise[0][k] + gain[i][1] * noise[1][k] + gain[i][2] * noise[2][k] -
                  times_h<N>(left[i], y, k);
      }
      for (int j = i; j < N; ++j) {
        b.p[i][j] = b.p[j][i] =
            left[i][j] + rest[0] * gain[j][0] + rest[1] * gain[j][1] + rest[2] * gain[j][2];
      }
    }
  }
};

}  // namespace detail

/// One update. `hp`: H P; `hd`: the first `count` columns of H D and, of sensitivities, the
/// measurement's own; `form`: how the covariance is updated.
template <int N, class State, class Form>
void ekf_update(const Innovation& seen, const double (&hp)[kPose][N],
                const double (&hd)[kPose][State::kColumns], int count, Form form, State& b) {
  // an outlier: S counts as 1 / weight^2 times as large
  double inverse[kPose][kPose];
  const double less = seen.weight * seen.weight;
  for (int i = 0; i < kPose; ++i) {
    for (int j = 0; j < kPose; ++j) inverse[i][j] = seen.inverse[i][j] * less;
  }
  // K = P H' S^-1
  double gain[N][kPose];
  for (int i = 0; i < N; ++i) {
    for (int j = 0; j < kPose; ++j) {
      gain[i][j] = hp[0][i] * inverse[0][j] + hp[1][i] * inverse[1][j] + hp[2][i] * inverse[2][j];
    }
  }
  // mean and columns, the gain held
  for (int i = 0; i < N; ++i) {
    for (int m = 0; m < kPose; ++m) b.x[i] += gain[i][m] * seen.e[m];
    for (int c = 0; c < count; ++c) {
      b.d[i][c] -= gain[i][0] * hd[0][c] + gain[i][1] * hd[1][c] + gain[i][2] * hd[2][c];
    }
  }
  // covariance
  form(seen, gain, hp, b);
}

}  // namespace seatrial
