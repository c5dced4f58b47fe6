// SPDX-License-Identifier: MIT
// A message as a line: name=value of each member, numbers in full (hexadecimal), and back.
#pragma once
#include <cstdio>
#include <cstdlib>
#include <sstream>
#include <stdexcept>
#include <string>
#include <type_traits>

#include "dds.hpp"

namespace seatrial::wire {

namespace detail {

inline std::string below(const std::string& path, const char* name) {
  return path.empty() ? name : path + '.' + name;
}

inline std::string at(const std::string& path, std::size_t i) {
  return path + '[' + std::to_string(i) + ']';
}

/// std::array has its size, std::vector can have another.
template <class T, class = void>
struct IsSequence : std::false_type {};
template <class T>
struct IsSequence<T, std::void_t<decltype(std::declval<T&>().resize(0))>> : std::true_type {};

template <class T>
void print(T& value, const std::string& path, std::string& line) {
  if constexpr (IsMessage<T>::value) {
    value.each([&](const char* name, auto& member) { print(member, below(path, name), line); });
  } else if constexpr (std::is_same_v<T, std::string>) {
    line += ' ' + path + '=' + value;
  } else if constexpr (std::is_integral_v<T>) {
    line += ' ' + path + '=' + std::to_string(value);
  } else if constexpr (std::is_floating_point_v<T>) {
    char number[32];
    std::snprintf(number, sizeof(number), "%a", static_cast<double>(value));
    line += ' ' + path + '=' + number;
  } else {
    if constexpr (IsSequence<T>::value) {
      line += ' ' + path + ".size=" + std::to_string(value.size());
    }
    for (std::size_t i = 0; i < value.size(); ++i) print(value[i], at(path, i), line);
  }
}

/// What follows NAME= in the next word.
inline std::string value_of(const std::string& name, std::istream& words) {
  std::string word;
  words >> word;
  const std::string start = name + '=';
  if (word.compare(0, start.size(), start) != 0) {
    throw std::runtime_error("got '" + word + "', expected " + start + "...");
  }
  return word.substr(start.size());
}

template <class T>
T number(const std::string& name, std::istream& words) {
  const std::string text = value_of(name, words);
  char* end = nullptr;
  const T found = std::is_integral_v<T> ? static_cast<T>(std::strtoll(text.c_str(), &end, 10))
                                        : static_cast<T>(std::strtod(text.c_str(), &end));
  if (text.empty() || *end != '\0') {
    throw std::runtime_error("got '" + name + '=' + text + "', expected a number");
  }
  return found;
}

template <class T>
void parse(std::istream& words, const std::string& path, T& value) {
  if constexpr (IsMessage<T>::value) {
    value.each([&](const char* name, auto& member) { parse(words, below(path, name), member); });
  } else if constexpr (std::is_same_v<T, std::string>) {
    value = value_of(path, words);
  } else if constexpr (std::is_arithmetic_v<T>) {
    value = number<T>(path, words);
  } else {
    if constexpr (IsSequence<T>::value) {
      value.resize(number<std::uint16_t>(path + ".size", words));
    }
    for (std::size_t i = 0; i < value.size(); ++i) parse(words, at(path, i), value[i]);
  }
}

}  // namespace detail

/// " name=value name=value ..."
template <class Message>
std::string text(Message& message) {
  std::string line;
  detail::print(message, "", line);
  return line;
}

/// Reads what `text` writes. Throws std::runtime_error with the word that is wrong.
template <class Message>
Message parse(std::istream& words) {
  Message message;
  detail::parse(words, "", message);
  return message;
}

}  // namespace seatrial::wire
