// SPDX-License-Identifier: MIT
// Numbers of commands and scale signals in messages, both ways. Templates, as the messages of ROS 1
// and ROS 2 are types of their own with the same members, which tell them apart.
#pragma once
#include <type_traits>
#include <vector>

#include "seatrial_ros/fields.hpp"

namespace seatrial::ros {

/// Calls act(an empty message) of a kind, as Messages names the types; single: of single precision.
template <class Messages, class Act>
auto with_message(Kind kind, bool single, const Act& act)
    -> decltype(act(typename Messages::Joy())) {
  switch (kind) {
    case Kind::kJoy:
      return act(typename Messages::Joy());
    case Kind::kWrench:
      return act(typename Messages::Wrench());
    case Kind::kWrenchStamped:
      return act(typename Messages::WrenchStamped());
    case Kind::kTwist:
      return act(typename Messages::Twist());
    case Kind::kTwistStamped:
      return act(typename Messages::TwistStamped());
    case Kind::kJointState:
      return act(typename Messages::JointState());
    case Kind::kArray:
      return single ? act(typename Messages::Float32MultiArray())
                    : act(typename Messages::Float64MultiArray());
    case Kind::kNumber:
      break;
  }
  return single ? act(typename Messages::Float32()) : act(typename Messages::Float64());
}

/// The same of a type that `shape_of` knows.
template <class Messages, class Act>
auto with_message(const std::string& type, const Act& act) {
  const bool single = type.find("Float32") != std::string::npos;
  return with_message<Messages>(shape_of(type)->kind, single, act);
}

namespace detail {

template <class Message, class Act>
auto with_header(Message& m, const Act& act, int) -> decltype(void(m.header)) {
  act(m.header);
}
template <class Message, class Act>
void with_header(Message&, const Act&, long) {}

template <class Array>
std::vector<double> copied(const Array& array) {
  return {array.begin(), array.end()};
}

template <class Vector>
void put_six(const std::vector<double>& n, Vector& first, Vector& second) {
  first.x = n[0];
  first.y = n[1];
  first.z = n[2];
  second.x = n[3];
  second.y = n[4];
  second.z = n[5];
}

}  // namespace detail

/// Calls act(header) where the message has one.
template <class Message, class Act>
void with_header(Message& m, const Act& act) {
  detail::with_header(m, act, 0);
}

/// A message's numbers, in the groups of its shape.
template <class Joy>
auto numbers_in(const Joy& m) -> decltype(void(m.axes), Numbers()) {
  return {detail::copied(m.axes), detail::copied(m.buttons)};
}
template <class Wrench>
auto numbers_in(const Wrench& m) -> decltype(void(m.force), Numbers()) {
  return {{m.force.x, m.force.y, m.force.z, m.torque.x, m.torque.y, m.torque.z}};
}
template <class Twist>
auto numbers_in(const Twist& m) -> decltype(void(m.linear), Numbers()) {
  return {{m.linear.x, m.linear.y, m.linear.z, m.angular.x, m.angular.y, m.angular.z}};
}
template <class Stamped>
auto numbers_in(const Stamped& m) -> decltype(numbers_in(m.wrench)) {
  return numbers_in(m.wrench);
}
template <class Stamped>
auto numbers_in(const Stamped& m) -> decltype(numbers_in(m.twist)) {
  return numbers_in(m.twist);
}
template <class Joints>
auto numbers_in(const Joints& m) -> decltype(void(m.effort), Numbers()) {
  return {detail::copied(m.position), detail::copied(m.velocity), detail::copied(m.effort)};
}
template <class Array>
auto numbers_in(const Array& m) -> decltype(void(m.data.begin()), Numbers()) {
  return {detail::copied(m.data)};
}
template <class Number>
auto numbers_in(const Number& m) -> decltype(void(static_cast<double>(m.data)), Numbers()) {
  return {{static_cast<double>(m.data)}};
}

/// The other way round; what the numbers do not say stays.
template <class Joy>
auto put_numbers(const Numbers& from, Joy& out) -> decltype(void(out.axes)) {
  out.axes.assign(from[0].begin(), from[0].end());
}
template <class Wrench>
auto put_numbers(const Numbers& from, Wrench& out) -> decltype(void(out.force)) {
  detail::put_six(from[0], out.force, out.torque);
}
template <class Twist>
auto put_numbers(const Numbers& from, Twist& out) -> decltype(void(out.linear)) {
  detail::put_six(from[0], out.linear, out.angular);
}
template <class Stamped>
auto put_numbers(const Numbers& from, Stamped& out) -> decltype(void(out.wrench)) {
  put_numbers(from, out.wrench);
}
template <class Stamped>
auto put_numbers(const Numbers& from, Stamped& out) -> decltype(void(out.twist)) {
  put_numbers(from, out.twist);
}
template <class Joints>
auto put_numbers(const Numbers& from, Joints& out) -> decltype(void(out.effort)) {
  out.position = from[0];
  out.velocity = from[1];
  out.effort = from[2];
}
template <class Array>
auto put_numbers(const Numbers& from, Array& out) -> decltype(void(out.data.begin())) {
  out.data.assign(from[0].begin(), from[0].end());
}
template <class Number>
auto put_numbers(const Numbers& from, Number& out)
    -> decltype(void(static_cast<double>(out.data))) {
  out.data = static_cast<std::decay_t<decltype(out.data)>>(from[0][0]);
}

}  // namespace seatrial::ros
