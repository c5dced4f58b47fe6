// SPDX-License-Identifier: MIT
// Callbacks in roscpp's network thread: a message is used, and answered, in the thread that read it
// off the socket. roscpp's own queue hands each to the thread that spins, which hands the answer
// back: two wake-ups a message, most of what a small node costs. For callbacks of microseconds
// only.
#pragma once
#include <ros/callback_queue_interface.h>

#include <mutex>

namespace seatrial::ros {

class NetworkQueue final : public ::ros::CallbackQueueInterface {
 public:
  /// One callback at a time; none while it is held.
  std::unique_lock<std::mutex> hold() { return std::unique_lock<std::mutex>(mutex_); }

  void addCallback(const ::ros::CallbackInterfacePtr& callback, std::uint64_t) override {
    const auto held = hold();
    callback->call();
  }

  void removeByID(std::uint64_t) override {}  // nothing waits here

 private:
  std::mutex mutex_;
};

}  // namespace seatrial::ros
