// SPDX-License-Identifier: MIT
// A YAML file read strictly: every value knows its place in the file, and says in one line what was
// got and what was expected.
#pragma once
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <initializer_list>
#include <locale>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace seatrial::ros {

using Words = std::vector<std::string>;

inline std::string joined(const Words& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
  return text.empty() ? "none" : text;
}

/// Where a word stands in a list; -1: nowhere.
inline int place_of(const std::string& word, const Words& words) {
  const auto at = std::find(words.begin(), words.end(), word);
  return at == words.end() ? -1 : static_cast<int>(at - words.begin());
}

/// A whole word as a number, whatever the process' locale is.
inline std::optional<double> as_number(const std::string& word) {
  std::istringstream in(word);
  in.imbue(std::locale::classic());
  double value = 0.0;
  in >> std::noskipws >> value;
  if (in.fail() || in.peek() != std::istringstream::traits_type::eof()) return std::nullopt;
  return value;
}

/// A value and its place, for instance `vehicle.pose.topic`. Throws std::runtime_error.
class Value {  // NOLINT(bugprone-exception-escape): YAML::Node is copied where it is moved
 public:
  Value(const YAML::Node& node, std::string place) : node_(node), place_(std::move(place)) {}

  [[noreturn]] void refuse(const std::string& why) const {
    throw std::runtime_error((place_.empty() ? "" : place_ + ": ") + why);
  }

  bool is_mapping() const { return node_.IsMap(); }
  bool is_word() const { return node_.IsScalar(); }

  /// Of a mapping, in the file's order.
  std::vector<std::pair<std::string, Value>> entries() const {
    if (!node_.IsMap()) refuse("got " + shown() + ", expected a mapping");
    std::vector<std::pair<std::string, Value>> found;
    for (const auto& pair : node_) {
      if (!pair.first.IsScalar()) refuse("a key must be a word");
      const std::string& key = pair.first.Scalar();
      for (const auto& before : found) {
        if (before.first == key) refuse("key '" + key + "' stands twice");
      }
      found.emplace_back(key, Value(pair.second, under(key)));
    }
    return found;
  }

  /// Refuses other keys.
  void only(const Words& known) const {
    for (const auto& entry : entries()) {
      if (place_of(entry.first, known) < 0) {
        refuse("unknown key '" + entry.first + "'; expected " + joined(known));
      }
    }
  }

  std::optional<Value> find(const std::string& key) const {
    if (!node_.IsMap()) refuse("got " + shown() + ", expected a mapping");
    const YAML::Node inner = node_[key];
    if (!inner.IsDefined() || inner.IsNull()) return std::nullopt;
    return Value(inner, under(key));
  }

  Value at(const std::string& key) const {
    const std::optional<Value> found = find(key);
    if (!found) refuse("key '" + key + "' is missing; is the file cut off?");
    return *found;
  }

  std::vector<Value> items() const {
    if (!node_.IsSequence()) refuse("got " + shown() + ", expected a list");
    std::vector<Value> found;
    for (const auto& item : node_) {
      found.emplace_back(item, place_ + "[" + std::to_string(found.size()) + "]");
    }
    return found;
  }

  std::string text() const {
    if (!node_.IsScalar()) refuse("got " + shown() + ", expected text");
    return node_.Scalar();
  }

  /// One of several words: its place among them.
  int choice(const Words& allowed) const {
    const int at = place_of(text(), allowed);
    if (at < 0) refuse("got " + shown() + "; expected " + joined(allowed));
    return at;
  }

  double number() const {
    const bool quoted = node_.Tag() == "!";
    const std::optional<double> value =
        node_.IsScalar() && !quoted ? as_number(node_.Scalar()) : std::nullopt;
    if (!value) refuse("got " + shown() + ", expected a finite number");
    return *value;
  }

  double positive() const {
    const double value = number();
    if (!(value > 0.0)) refuse("got " + shown() + ", expected a number above 0");
    return value;
  }

  double not_negative() const {
    const double value = number();
    if (!(value >= 0.0)) refuse("got " + shown() + ", expected a number from 0 on");
    return value;
  }

  Words texts() const {
    Words found;
    for (const Value& item : items()) found.push_back(item.text());
    return found;
  }

 private:
  std::string under(const std::string& key) const {
    return place_.empty() ? key : place_ + "." + key;
  }

  std::string shown() const {
    if (node_.IsMap()) return "a mapping";
    if (node_.IsSequence()) return "a list";
    if (!node_.IsScalar()) return "nothing";
    std::string word = node_.Scalar().substr(0, 60);
    std::replace_if(
        word.begin(), word.end(), [](unsigned char c) { return c < ' '; }, ' ');
    return "'" + word + "'";
  }

  YAML::Node node_;
  std::string place_;
};

/// A YAML mapping. Throws std::runtime_error.
inline Value read_yaml(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream content;
  if (file && file.peek() != std::ifstream::traits_type::eof()) content << file.rdbuf();
  if (!file || file.bad()) throw std::runtime_error("no such file, or it can't be read");
  const std::string text = content.str();
  if (text.find('\0') != std::string::npos) {
    throw std::runtime_error("is not text; expected a YAML file: is it a recording?");
  }
  try {
    const YAML::Node node = YAML::Load(text);
    if (!node.IsMap()) throw std::runtime_error("expected 'key: value' lines; is it another file?");
    return {node, ""};
  } catch (const YAML::Exception& error) {
    throw std::runtime_error("line " + std::to_string(error.mark.line + 1) +
                             " is not YAML: " + error.msg);
  }
}

}  // namespace seatrial::ros
