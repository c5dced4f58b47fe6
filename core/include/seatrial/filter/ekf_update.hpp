// SPDX-License-Identifier: MIT
// What a pose tells the on-board predictor: how far it is from what was believed, and Kalman's
// update by it, outliers held back. No heap, no exceptions.
#pragma once
#include <algorithm>
#include <cmath>
#include <limits>

#include "seatrial/filter/ekf_predict.hpp"
#include "seatrial/model/frames.hpp"

namespace seatrial {

namespace detail {

/// l l' = s; false where s is not positive definite. Only the lower half of s is read.
inline bool lower_root(const double s[kSeen][kSeen], double l[kSeen][kSeen]) {
  for (int i = 0; i < kSeen; ++i) {
    for (int j = 0; j <= i; ++j) {
      double sum = s[i][j];
      for (int k = 0; k < j; ++k) sum -= l[i][k] * l[j][k];
      if (i == j && !(sum > 0.0)) return false;
      l[i][j] = i == j ? std::sqrt(sum) : sum / l[j][j];
    }
  }
  return true;
}

/// x = (l l')^-1 x.
inline void solve_root(const double l[kSeen][kSeen], double* x) {
  for (int i = 0; i < kSeen; ++i) {
    for (int k = 0; k < i; ++k) x[i] -= l[i][k] * x[k];
    x[i] /= l[i][i];
  }
  for (int i = kSeen - 1; i >= 0; --i) {
    for (int k = i + 1; k < kSeen; ++k) x[i] -= l[k][i] * x[k];
    x[i] /= l[i][i];
  }
}

/// Covariance of the pose as it is predicted to be measured, but for its white error: of H P H'.
inline double predicted(const Belief& b, int i, int j) {
  if (!b.coloured()) return b.p[i][j];
  return b.p[i][j] + b.p[i][kBelieved + j] + b.p[kBelieved + i][j] +
         b.p[kBelieved + i][kBelieved + j];
}

}  // namespace detail

/// A pose beside its prediction.
struct Surprise {
  double e[kSeen] = {};            // [m, m, rad] pose less prediction
  double root[kSeen][kSeen] = {};  // of its covariance, lower
  double square = 0.0;             // e' S^-1 e; infinite where S has no root
};

/// noise: covariance of the pose's white error.
inline Surprise surprise(const Belief& b, const double* eta, const double noise[kSeen][kSeen]) {
  Surprise out;
  double s[kSeen][kSeen];
  double z[kSeen];
  for (int i = 0; i < kSeen; ++i) {
    const double off = b.coloured() ? eta[i] - b.x[i] - b.x[kBelieved + i] : eta[i] - b.x[i];
    out.e[i] = z[i] = i < 2 ? off : wrap(off);
    for (int j = 0; j < kSeen; ++j) s[i][j] = detail::predicted(b, i, j) + noise[i][j];
  }
  out.square = std::numeric_limits<double>::infinity();
  if (!detail::lower_root(s, out.root)) return out;
  detail::solve_root(out.root, z);
  out.square = out.e[0] * z[0] + out.e[1] * z[1] + out.e[2] * z[2];
  return out;
}

namespace detail {

/// Of N states; H picks the pose and, in more than kBelieved, adds the correlated errors.
template <int N>
void correct(const Surprise& by, const double noise[kSeen][kSeen], Belief& b) {
  const auto seen = [](const double* row, int k) {  // of a row times H'
    return N > kBelieved ? row[k] + row[kBelieved + k] : row[k];
  };
  double gain[N][kSeen];
  double hp[kSeen][N];
  double left[N][N];  // (I - K H) P
  Causes hb[kSeen];   // H B
  for (int k = 0; k < kSeen; ++k) {
    std::copy(b.by[k], b.by[k] + kMostConsidered, hb[k]);
    if constexpr (N > kBelieved) add_causes(1.0, b.by[kBelieved + k], hb[k]);
  }
  for (int i = 0; i < N; ++i) {
    for (int k = 0; k < kSeen; ++k) gain[i][k] = hp[k][i] = seen(b.p[i], k);
    solve_root(by.root, gain[i]);
    for (int k = 0; k < kSeen; ++k) add_causes(-gain[i][k], hb[k], b.by[i]);
    b.x[i] += gain[i][0] * by.e[0] + gain[i][1] * by.e[1] + gain[i][2] * by.e[2];
  }
  for (int i = 0; i < N; ++i) {
    for (int j = 0; j < N; ++j) {
      left[i][j] =
          b.p[i][j] - (gain[i][0] * hp[0][j] + gain[i][1] * hp[1][j] + gain[i][2] * hp[2][j]);
    }
  }
  for (int i = 0; i < N; ++i) {
    double more[kSeen];  // K R - (I - K H) P H'
    for (int k = 0; k < kSeen; ++k) {
      more[k] = gain[i][0] * noise[0][k] + gain[i][1] * noise[1][k] + gain[i][2] * noise[2][k] -
                seen(left[i], k);
    }
    for (int j = i; j < N; ++j) {
      b.p[i][j] = b.p[j][i] =
          left[i][j] + more[0] * gain[j][0] + more[1] * gain[j][1] + more[2] * gain[j][2];
    }
  }
}

}  // namespace detail

/// Kalman's update in Joseph's form, (I - K H) P (I - K H)' + K R K': positive definite and
/// symmetric whatever the gain's rounding does.
inline void correct(const Surprise& by, const double noise[kSeen][kSeen], Belief& b) {
  if (b.swinging()) {
    detail::correct<kMostBelieved>(by, noise, b);
  } else if (b.coloured()) {
    detail::correct<kColoured>(by, noise, b);
  } else {
    detail::correct<kBelieved>(by, noise, b);
  }
}

/// The same with an outlier, which is believed less, as the estimator's filter does: its distance
/// counts linearly beyond `outlier` standard deviations.
inline void correct_robustly(const Surprise& by, const double noise[kSeen][kSeen], double outlier,
                             Belief& b) {
  const double more = by.square / (outlier * outlier);  // S is taken so many times as large
  if (!(more > 1.0)) {
    correct(by, noise, b);
    return;
  }
  Surprise less = by;
  double larger[kSeen][kSeen];
  for (int i = 0; i < kSeen; ++i) {
    for (int j = 0; j < kSeen; ++j) {
      less.root[i][j] *= std::sqrt(more);
      larger[i][j] = more * noise[i][j] + (more - 1.0) * detail::predicted(b, i, j);
    }
  }
  correct(less, larger, b);
}

}  // namespace seatrial
