// SPDX-License-Identifier: MIT
// The node's inputs as lines of JSON to a UDP port on loopback, for `seatrial live` and `seatrial
// predict --live`, and the change of the boat that the latter answers with. Nothing here waits: a
// line that has no room is lost, one without a receiver too.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "seatrial_ros/diagnosis.hpp"

namespace seatrial::ros {

class LiveStream {
 public:
  /// port: 0 for none. Throws std::runtime_error where the system has no socket.
  explicit LiveStream(int port);
  ~LiveStream();
  LiveStream(const LiveStream&) = delete;
  LiveStream& operator=(const LiveStream&) = delete;

  /// A line: kind (pose, command, scale), stamp [ns], values in the model file's axes. covariance:
  /// nine values of a pose, or none. Numbers that are not finite are not sent.
  void send(const char* kind, std::int64_t stamp, const std::vector<double>& values,
            const std::vector<double>& covariance = {});

  /// Take the answers that have come, a few at most.
  void receive();

  /// What the newest answer says of a change of the boat, appended; true where it does.
  bool diagnose(Diagnosis& out) const;

  /// Lines that could not be sent: the system's buffer was full, or nobody listens.
  std::uint64_t lost() const { return lost_; }
  bool on() const { return socket_ >= 0; }

 private:
  int socket_ = -1;
  std::uint64_t lost_ = 0;
  std::string answer_;        // the newest, where it tells of a change
  std::vector<char> buffer_;  // of one answer
};

}  // namespace seatrial::ros
