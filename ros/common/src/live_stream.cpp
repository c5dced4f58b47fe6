// SPDX-License-Identifier: MIT
#include "seatrial_ros/live_stream.hpp"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>
#include <yaml-cpp/yaml.h>

#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <stdexcept>

namespace seatrial::ros {

namespace {

constexpr std::size_t kLongest = 8192;  // [bytes] of an answer that is read
constexpr int kAtOnce = 8;              // answers taken by one call
constexpr std::size_t kShown = 200;     // characters of a value that is shown

/// Appends "[1,2,3]"; false where a number is not finite.
bool append(std::string& line, const double* values, std::size_t n) {
  char text[32];
  for (std::size_t i = 0; i < n; ++i) {
    if (!std::isfinite(values[i])) return false;
    std::snprintf(text, sizeof text, "%.17g", values[i]);
    line += i == 0 ? "[" : ",";
    line += text;
  }
  line += n == 0 ? "[]" : "]";
  return true;
}

/// One line of printable ASCII: a message's strings are UTF-8, an answer's bytes may be anything.
std::string shown(const YAML::Node& value) {
  if (!value.IsScalar()) return "";
  std::string text = value.Scalar().substr(0, kShown);
  for (char& c : text) {
    if (c < ' ' || c > '~') c = '?';
  }
  return text;
}

}  // namespace

LiveStream::LiveStream(int port) {
  if (port == 0) return;
  socket_ = ::socket(AF_INET, SOCK_DGRAM, 0);
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_port = htons(static_cast<std::uint16_t>(port));
  to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  // connected: answers of this port alone are received
  const bool open = socket_ >= 0 && ::fcntl(socket_, F_SETFL, O_NONBLOCK) == 0 &&
                    ::fcntl(socket_, F_SETFD, FD_CLOEXEC) == 0 &&
                    ::connect(socket_, reinterpret_cast<const sockaddr*>(&to), sizeof to) == 0;
  if (!open) {
    const std::string why = std::strerror(errno);
    if (socket_ >= 0) ::close(socket_);
    throw std::runtime_error("parameter live_port: UDP port " + std::to_string(port) +
                             " can't be used (" + why + ")");
  }
  buffer_.resize(kLongest);
}

LiveStream::~LiveStream() {
  if (socket_ >= 0) ::close(socket_);
}

void LiveStream::send(const char* kind, std::int64_t stamp, const std::vector<double>& values,
                      const std::vector<double>& covariance) {
  if (!on()) return;
  std::string line = R"({"stamp":)" + std::to_string(stamp) + ",\"" + kind + "\":";
  if (!append(line, values.data(), values.size())) return;
  if (covariance.size() == 9) {
    line += R"(,"covariance":[)";
    for (std::size_t i = 0; i < 9; i += 3) {
      if (i > 0) line += ",";
      if (!append(line, covariance.data() + i, 3)) return;
    }
    line += "]";
  }
  line += "}\n";
  const ssize_t sent = ::send(socket_, line.data(), line.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
  lost_ += sent < 0 ? 1U : 0U;
}

void LiveStream::receive() {
  if (!on()) return;
  for (int i = 0; i < kAtOnce; ++i) {
    const ssize_t size = ::recv(socket_, buffer_.data(), buffer_.size(), MSG_DONTWAIT);
    if (size < 0) return;
    const std::string text(buffer_.data(), static_cast<std::size_t>(size));
    // the longest is cut off, and no answer
    const bool whole = size < static_cast<ssize_t>(kLongest);
    answer_ = whole && text.find("\"change\"") != std::string::npos ? text : "";
  }
}

bool LiveStream::diagnose(Diagnosis& out) const {
  if (answer_.empty()) return false;
  try {
    const YAML::Node found = YAML::Load(answer_.substr(0, answer_.find('\n')));
    const YAML::Node change = found.IsMap() ? found["change"] : YAML::Node();
    if (!change.IsMap() || !change["cause"] || !change["state"]) return false;
    if (!out.message.empty()) out.message += "; ";
    out.message += "boat changed (" + shown(change["state"]) + "): " + shown(change["cause"]);
    for (const char* name : {"state", "cause", "what", "probability", "size", "error"}) {
      if (change[name]) {
        out.values.emplace_back(std::string("change: ") + name, shown(change[name]));
      }
    }
    return true;
  } catch (const YAML::Exception&) {  // no JSON: not an answer
    return false;
  }
}

}  // namespace seatrial::ros
