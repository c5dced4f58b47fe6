// SPDX-License-Identifier: MIT
// Arrays between Python and the core: views in, owned memory out.
#pragma once
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <algorithm>
#include <cstddef>
#include <memory>
#include <stdexcept>
#include <vector>

namespace nb = nanobind;

using Vector = nb::ndarray<const double, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using Matrix = nb::ndarray<const double, nb::ndim<2>, nb::c_contig, nb::device::cpu>;
using Indices = nb::ndarray<const int, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using IndexTable = nb::ndarray<const int, nb::ndim<2>, nb::c_contig, nb::device::cpu>;
using Places = nb::ndarray<const int, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using Flags = nb::ndarray<const signed char, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using Out1 = nb::ndarray<nb::numpy, double, nb::ndim<1>>;
using Out2 = nb::ndarray<nb::numpy, double, nb::ndim<2>>;
using Out3 = nb::ndarray<nb::numpy, double, nb::ndim<3>>;

inline void require(bool condition, const char* message) {
  if (!condition) throw std::invalid_argument(message);
}

/// A fresh numpy array that owns its memory.
template <class Out, std::size_t N>
Out fresh(const std::size_t (&shape)[N], double** data) {
  std::size_t size = 1;
  for (const std::size_t extent : shape) size *= extent;
  auto owned = std::make_unique<double[]>(size == 0 ? 1 : size);
  *data = owned.get();
  nb::capsule owner(owned.release(), [](void* p) noexcept { delete[] static_cast<double*>(p); });
  return Out(*data, N, shape, owner);
}

/// A vector as an array of Python.
template <class T>
Out1 moved1(const std::vector<T>& from) {
  double* out = nullptr;
  auto to = fresh<Out1>({from.size()}, &out);
  std::copy(from.begin(), from.end(), out);
  return to;
}

/// A matrix of this width, row after row, as an array of Python.
template <class T>
Out2 moved2(const std::vector<T>& from, std::size_t width) {
  double* out = nullptr;
  auto to = fresh<Out2>({width == 0 ? 0 : from.size() / width, width}, &out);
  std::copy(from.begin(), from.end(), out);
  return to;
}
