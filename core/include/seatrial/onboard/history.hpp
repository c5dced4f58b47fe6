// SPDX-License-Identifier: MIT
// Recent rows of a piecewise-constant signal, sorted by stamp in whatever order they arrive. Fixed
// capacity, no heap, no exceptions.
#pragma once
#include <algorithm>
#include <limits>

#include "seatrial/model/structure.hpp"

namespace seatrial {

/// Rows of up to kWidth values; a row holds until the next, or for `timeout` [s].
template <int kRows, int kWidth>
class History {
 public:
  explicit History(int width, double timeout = std::numeric_limits<double>::infinity())
      : width_(width), timeout_(timeout) {}

  int size() const { return size_; }
  bool full() const { return size_ == kRows; }
  double time(int i) const { return row(i).time; }
  void clear() { size_ = 0; }

  /// After those of the same stamp. False where there is no room.
  bool insert(double t, const double* values) {
    if (full()) return false;
    int i = size_++;
    for (; i > 0 && row(i - 1).time > t; --i) row(i) = row(i - 1);
    row(i).time = t;
    std::copy(values, values + width_, row(i).values);
    return true;
  }

  /// The values in force at t [s] if each row takes effect `delay` [s] after its stamp; null: none.
  const double* values(double t, double delay) const {
    const int i = holding(t, delay);
    if (i < 0 || row(i).time + delay + timeout_ <= t) return nullptr;
    return row(i).values;
  }

  /// When that changes next; infinite: never. Exactly the time at which `values` changes.
  double next(double t, double delay) const {
    const int i = holding(t, delay);
    double at = std::numeric_limits<double>::infinity();
    if (i + 1 < size_) at = row(i + 1).time + delay;
    if (i >= 0) {
      const double expires = row(i).time + delay + timeout_;
      if (expires > t) at = std::min(at, expires);
    }
    return at;
  }

  /// Forgets rows that are not in force at t or later, with delays up to `longest`.
  void forget(double t, double longest) {
    while (size_ > 1 && row(1).time + longest <= t) {
      first_ = (first_ + 1) % kRows;
      --size_;
    }
  }

 private:
  struct Row {
    double time = 0.0;
    double values[kWidth] = {};
  };

  Row& row(int i) { return rows_[(first_ + i) % kRows]; }
  const Row& row(int i) const { return rows_[(first_ + i) % kRows]; }

  /// The last row that took effect by t; -1: none.
  int holding(double t, double delay) const {
    int low = 0;
    int high = size_;
    while (low < high) {
      const int middle = (low + high) / 2;
      if (row(middle).time + delay <= t) {
        low = middle + 1;
      } else {
        high = middle;
      }
    }
    return low - 1;
  }

  int width_;
  double timeout_;
  int first_ = 0;
  int size_ = 0;
  Row rows_[kRows];
};

}  // namespace seatrial
