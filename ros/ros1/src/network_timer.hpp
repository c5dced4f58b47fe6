// SPDX-License-Identifier: MIT
// A timer of roscpp's network thread: what its callback publishes goes out without waking another
// thread. ros::Timer's thread wakes the spinning one, which wakes the network's.
#pragma once
#include <poll.h>
#include <ros/poll_manager.h>
#include <ros/time.h>
#include <sys/timerfd.h>
#include <unistd.h>

#include <algorithm>
#include <functional>
#include <stdexcept>
#include <utility>

#include "network_queue.hpp"

namespace seatrial::ros {

class NetworkTimer {
 public:
  /// Calls at a rate [Hz] by ros::Time, while it holds the queue; instants that were missed are
  /// left out. Throws std::runtime_error where the system gives no timer.
  NetworkTimer(double rate, NetworkQueue& queue, std::function<void()> call)
      : queue_(&queue), call_(std::move(call)), period_(1.0 / rate) {
    file_ = timerfd_create(CLOCK_MONOTONIC, TFD_NONBLOCK | TFD_CLOEXEC);
    if (file_ < 0) throw std::runtime_error("the system gives no timer (timerfd_create)");
    const double wake = ::ros::Time::isSimTime() ? std::min(kSimulated, 1.0 / rate) : 1.0 / rate;
    itimerspec spec{};
    spec.it_interval.tv_sec = static_cast<time_t>(wake);
    spec.it_interval.tv_nsec =
        static_cast<long>(1e9 * (wake - static_cast<double>(spec.it_interval.tv_sec)));
    spec.it_value = spec.it_interval;
    timerfd_settime(file_, 0, &spec, nullptr);
    ::ros::PollSet& polled = ::ros::PollManager::instance()->getPollSet();
    polled.addSocket(file_, [this](int) { on_expiry(); });
    polled.addEvents(file_, POLLIN);
  }

  /// After ros::shutdown(): no call is under way then.
  ~NetworkTimer() {
    ::ros::PollManager::instance()->getPollSet().delSocket(file_);
    close(file_);
  }

  NetworkTimer(const NetworkTimer&) = delete;
  NetworkTimer& operator=(const NetworkTimer&) = delete;

 private:
  static constexpr double kSimulated = 0.001;  // between two looks at simulated time [s]

  void on_expiry() {
    const auto held = queue_->hold();
    std::uint64_t expired = 0;
    if (read(file_, &expired, sizeof expired) != sizeof expired) return;
    if (!::ros::Time::isSimTime() || due(::ros::Time::now())) call_();
  }

  bool due(::ros::Time now) {
    if (next_.isZero() || now + period_ < next_)
      next_ = now;  // first, or a clock that was set back
    if (now < next_) return false;
    next_ += period_;
    if (next_ <= now) next_ = now + period_;
    return true;
  }

  NetworkQueue* queue_;
  std::function<void()> call_;
  ::ros::Duration period_;
  ::ros::Time next_;
  int file_ = -1;
};

}  // namespace seatrial::ros
