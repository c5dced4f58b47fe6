// SPDX-License-Identifier: MIT
// What the programs that are driven by scripts have in common: parameters as NAME=VALUE, and a
// message's numbers.
#pragma once
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "seatrial_ros/fields.hpp"
#include "seatrial_ros/settings.hpp"

namespace seatrial::ros {

/// "V V V | V V": groups as in seatrial_ros/fields.hpp.
inline Numbers numbers_of(std::istringstream& words) {
  Numbers numbers(1);
  for (std::string word; words >> word;) {
    if (word == "|") {
      numbers.emplace_back();
    } else {
      numbers.back().push_back(std::strtod(word.c_str(), nullptr));
    }
  }
  return numbers;
}

namespace detail {

inline void read_word(const std::string& text, std::string& to) { to = text; }
inline void read_word(const std::string& text, double& to) { to = std::stod(text); }
inline void read_word(const std::string& text, bool& to) { to = text == "true"; }
inline void read_word(const std::string& text, std::vector<double>& to) {
  std::istringstream in(text);
  to.clear();
  for (std::string item; std::getline(in, item, ',');) to.push_back(std::stod(item));
}

}  // namespace detail

/// A node's parameters, lists by commas. Throws std::runtime_error where there is no such one.
template <class Given>
Given settings_of(int argc, char** argv) {
  std::map<std::string, std::string> given;
  for (int i = 1; i < argc; ++i) {
    const std::string pair = argv[i];
    const std::size_t at = pair.find('=');
    if (at == std::string::npos) throw std::runtime_error(pair + ": expected NAME=VALUE");
    given[pair.substr(0, at)] = pair.substr(at + 1);
  }
  Given settings;
  each_parameter(settings, [&given](const Parameter& p, auto& value) {
    const auto found = given.find(p.name);
    if (found == given.end()) return;
    detail::read_word(found->second, value);
    given.erase(found);
  });
  if (!given.empty()) throw std::runtime_error("no parameter " + given.begin()->first);
  return settings;
}

}  // namespace seatrial::ros
