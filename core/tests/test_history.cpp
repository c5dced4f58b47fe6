// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include "boats.hpp"
#include "seatrial/onboard/history.hpp"

using namespace seatrial;

TEST_CASE("rows stand in the order of their stamps, whatever order they came in") {
  History<8, 2> h(2);
  const double a[2] = {1.0, 10.0};
  const double b[2] = {2.0, 20.0};
  const double c[2] = {3.0, 30.0};
  CHECK(h.insert(2.0, b));
  CHECK(h.insert(1.0, a));
  CHECK(h.insert(2.0, c));  // the same stamp: after it
  CHECK(h.size() == 3);
  CHECK(h.values(0.9, 0.0) == nullptr);
  CHECK(h.values(1.0, 0.0)[1] == 10.0);
  CHECK(h.values(2.0, 0.0)[0] == 3.0);
  CHECK(h.values(2.2, 0.5)[0] == 1.0);
  CHECK(h.next(0.0, 0.5) == 1.5);
  CHECK(h.next(1.5, 0.5) == 2.5);
  CHECK(h.next(2.5, 0.5) == std::numeric_limits<double>::infinity());
}

TEST_CASE("a row expires at the time that was predicted") {
  History<8, 1> h(1, 0.3);
  const double one = 1.0;
  CHECK(h.insert(0.1, &one));
  CHECK(h.insert(1.7, &one));
  for (const double delay : {0.0, 0.07, -0.11}) {
    const double begins = h.next(-1.0, delay);
    CHECK(h.values(std::nextafter(begins, -1.0), delay) == nullptr);
    CHECK(h.values(begins, delay) != nullptr);
    const double expires = h.next(begins, delay);
    CHECK(expires == doctest::Approx(0.4 + delay));
    CHECK(h.values(std::nextafter(expires, -1.0), delay) != nullptr);
    CHECK(h.values(expires, delay) == nullptr);
    CHECK(h.next(expires, delay) == doctest::Approx(1.7 + delay));
  }
}

TEST_CASE("rows that can't be in force any more make room") {
  History<4, 1> h(1);
  for (int i = 0; i < 4; ++i) {
    const double value = i;
    CHECK(h.insert(i, &value));
  }
  const double value = 4.0;
  CHECK_FALSE(h.insert(4.0, &value));
  h.forget(2.5, 0.6);  // the one of 2 s takes effect at 2.6 s: that of 1 s is in force
  CHECK(h.size() == 3);
  CHECK(h.values(2.5, 0.6)[0] == 1.0);
  CHECK(h.insert(4.0, &value));
  CHECK(h.values(9.0, 0.0)[0] == 4.0);
  h.clear();
  CHECK(h.values(9.0, 0.0) == nullptr);
}
