// SPDX-License-Identifier: MIT
// The terms of a model file, for instance `X_uu * |u| * u`, as the core takes them: in
// forward-left-up axes, whatever the file's are.
#pragma once
#include "seatrial/model/structure.hpp"
#include "seatrial_ros/model_value.hpp"

namespace seatrial::ros {

inline const Words kAxisNames = {"surge", "sway", "yaw"};

/// A generalised force F_j in command units, and the axis that it acts along.
struct Force {
  std::string name;
  int axis = 0;  // 0 surge, 1 sway, 2 yaw
};

/// A structure with the names of its coefficients.
struct NamedStructure {
  Structure structure;
  Words coefficients;
  std::vector<bool> flips;  // whether a coefficient changes sign between the axis systems
};

namespace detail {

inline const Words kVelocities = {"u", "v", "r", "|u|", "|v|", "|r|"};  // in the order of Signal
inline const Words kAccelerations = {"u_dot", "v_dot", "r_dot"};

/// Words between blanks, * and the middle dot.
inline Words factors_of(std::string line) {
  for (std::size_t at = line.find("\u00b7"); at != std::string::npos; at = line.find("\u00b7")) {
    line.replace(at, 2, " ");
  }
  std::replace(line.begin(), line.end(), '*', ' ');
  std::istringstream in(line);
  Words found;
  for (std::string word; in >> word;) found.push_back(word);
  return found;
}

/// X_..., Y_... or N_...
inline bool is_coefficient(const std::string& word) {
  const bool begins =
      word.size() > 2 && word[1] == '_' && (word[0] == 'X' || word[0] == 'Y' || word[0] == 'N');
  return begins && std::all_of(word.begin(), word.end(), [](unsigned char c) {
           return c == '_' || c >= 0x80 || (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') ||
                  (c >= 'a' && c <= 'z');
         });
}

/// Reads the lines of a structure, one after the other.
class TermReader {
 public:
  TermReader(const std::vector<Force>& forces, bool from_right_down)
      : forces_(forces), from_right_down_(from_right_down) {
    for (const Force& force : forces) signals_.push_back(force.name);
    out_.structure.n_forces = static_cast<int>(forces.size());
  }

  void read(int axis, const Value& line) {
    Term term;
    term.axis = static_cast<std::uint8_t>(axis);
    bool first = true;
    bool flips = axis > 0;
    const Words words = factors_of(line.text());
    if (words.empty()) line.refuse("is empty; expected a term, for instance X_u * u");
    for (const std::string& word : words) {
      if (word == "+" || word == "-") {
        if (!first) line.refuse("'" + line.text() + "' is a sum; write one term a line");
        term.number *= word == "-" ? -1.0 : 1.0;
      } else {
        add_word(word, line, term, flips);
      }
      first = false;
    }
    keep(term, flips, line);
  }

  const NamedStructure& structure() const { return out_; }

 private:
  void add_word(const std::string& word, const Value& line, Term& term, bool& flips) {
    const std::string plain = word.size() == 4 && word.substr(1) == "dot"
                                  ? word.substr(0, 1) + "_dot"  // udot
                                  : word;
    const int moved = place_of(plain, kAccelerations);
    if (moved >= 0) {
      if (term.acceleration >= 0) one_only(line, "accelerations");
      term.acceleration = static_cast<std::int8_t>(moved);
      flips = flips != (moved > 0);
    } else if (is_coefficient(word)) {
      if (term.coefficient >= 0) one_only(line, "coefficients");
      term.coefficient = static_cast<std::int8_t>(number_of(word, line));
    } else if (const std::optional<double> number = as_number(word)) {
      term.number *= *number;
    } else {
      add_factor(word, line, term, flips);
    }
  }

  void add_factor(const std::string& word, const Value& line, Term& term, bool& flips) const {
    const int signal = place_of(word, signals_);
    if (signal < 0) {
      line.refuse("term '" + line.text() + "' has factor '" + word + "'; known are " +
                  joined(signals_) + ", coefficients X_.., Y_.., N_.., and " +
                  joined(kAccelerations));
    }
    if (term.n_factors == kMaxFactors) {
      line.refuse("'" + line.text() + "' has more than " + std::to_string(kMaxFactors) +
                  " factors");
    }
    term.factors[term.n_factors++] = static_cast<std::uint8_t>(signal);
    const bool odd =
        signal == kV || signal == kR ||
        (signal >= kForce0 && forces_[static_cast<std::size_t>(signal - kForce0)].axis > 0);
    flips = flips != odd;
  }

  void keep(Term term, bool flips, const Value& line) {
    Structure& s = out_.structure;
    if (term.acceleration == term.axis) {
      line.refuse("term '" + line.text() +
                  "' has its own axis' acceleration; divide the equation by it instead");
    }
    if (s.n_terms == kMaxTerms) {
      line.refuse("more than " + std::to_string(kMaxTerms) + " terms");
    }
    if (term.coefficient >= 0) {
      const auto at = static_cast<std::size_t>(term.coefficient);
      if (at == out_.flips.size()) out_.flips.push_back(flips);
      if (out_.flips[at] != flips) {
        line.refuse(out_.coefficients[at] +
                    " stands in two terms of which only one changes sign between axis systems; "
                    "name them apart");
      }
    } else if (from_right_down_ && flips) {
      term.number = -term.number;
    }
    s.has_acceleration = s.has_acceleration || term.acceleration >= 0;
    s.terms[s.n_terms++] = term;
  }

  int number_of(const std::string& coefficient, const Value& line) {
    const int known = place_of(coefficient, out_.coefficients);
    if (known >= 0) return known;
    if (out_.structure.n_coefficients == kMaxCoefficients) {
      line.refuse("more than " + std::to_string(kMaxCoefficients) + " coefficients");
    }
    out_.coefficients.push_back(coefficient);
    return out_.structure.n_coefficients++;
  }

  [[noreturn]] static void one_only(const Value& line, const std::string& what) {
    line.refuse("'" + line.text() + "' has two " + what + "; one is possible");
  }

  const std::vector<Force>& forces_;
  bool from_right_down_;
  Words signals_ = kVelocities;
  NamedStructure out_;
};

}  // namespace detail

/// `lines`: the terms by axis. Throws std::runtime_error.
inline NamedStructure read_structure(const Value& lines, const std::vector<Force>& forces,
                                     bool from_right_down) {
  if (forces.size() > kMaxForces) {
    lines.refuse(std::to_string(forces.size()) + " forces; at most " + std::to_string(kMaxForces));
  }
  lines.only(kAxisNames);
  detail::TermReader reader(forces, from_right_down);
  for (int axis = 0; axis < kAxes; ++axis) {
    const std::optional<Value> own = lines.find(kAxisNames[static_cast<std::size_t>(axis)]);
    if (!own) continue;
    for (const Value& line : own->items()) reader.read(axis, line);
  }
  const NamedStructure& found = reader.structure();
  if (found.coefficients.empty()) lines.refuse("no coefficient; expected terms such as X_u * u");
  return found;
}

}  // namespace seatrial::ros
