// SPDX-License-Identifier: MIT
// Declarations of the part of rclcpp that the nodes for ROS 2 use, after its documentation (Humble;
// https://docs.ros2.org). Enough for a compiler to check calls; there is nothing behind them.
#pragma once
#include <builtin_interfaces/msg/time.hpp>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <functional>
#include <map>
#include <memory>
#include <rcl_interfaces/msg/parameter_descriptor.hpp>
#include <string>
#include <type_traits>
#include <vector>

#define RCLCPP_INFO(logger, ...) (void)(logger), std::printf(__VA_ARGS__)
#define RCLCPP_ERROR(logger, ...) (void)(logger), std::printf(__VA_ARGS__)
// the clock is asked, so that it must be one
#define RCLCPP_ERROR_THROTTLE(logger, clock, duration, ...) \
  (void)(logger), (void)(clock).now(), (void)(duration), std::printf(__VA_ARGS__)
#define RCLCPP_WARN_THROTTLE(logger, clock, duration, ...) \
  (void)(logger), (void)(clock).now(), (void)(duration), std::printf(__VA_ARGS__)

// of rcl/time.h
enum rcl_clock_type_t { RCL_CLOCK_UNINITIALIZED, RCL_ROS_TIME, RCL_SYSTEM_TIME, RCL_STEADY_TIME };

namespace rclcpp {

class Time {
 public:
  explicit Time(std::int64_t nanoseconds = 0, rcl_clock_type_t clock = RCL_SYSTEM_TIME);
  Time(const builtin_interfaces::msg::Time& message);  // NOLINT(google-explicit-constructor)
  std::int64_t nanoseconds() const;
  operator builtin_interfaces::msg::Time() const;  // NOLINT(google-explicit-constructor)
};

class Duration {
 public:
  static Duration from_seconds(double seconds);
};

class QoS {
 public:
  QoS(std::size_t depth);  // NOLINT(google-explicit-constructor)
  QoS& keep_last(std::size_t depth);
};

class SensorDataQoS : public QoS {
 public:
  SensorDataQoS();
};

class ClockQoS : public QoS {
 public:
  ClockQoS();
};

class Logger {};

class Clock {
 public:
  using SharedPtr = std::shared_ptr<Clock>;
  explicit Clock(rcl_clock_type_t type = RCL_SYSTEM_TIME);
  Time now();
};

class TimerBase {
 public:
  using SharedPtr = std::shared_ptr<TimerBase>;
  void cancel();
};

class SubscriptionBase {
 public:
  using SharedPtr = std::shared_ptr<SubscriptionBase>;
};

template <class Message>
class Subscription : public SubscriptionBase {
 public:
  using SharedPtr = std::shared_ptr<Subscription>;
};

template <class Message>
class Publisher {
 public:
  using SharedPtr = std::shared_ptr<Publisher>;
  void publish(const Message& message);
};

template <class Kind>
class Service {
 public:
  using SharedPtr = std::shared_ptr<Service>;
};

namespace node_interfaces {
class NodeTopicsInterface {
 public:
  using SharedPtr = std::shared_ptr<NodeTopicsInterface>;
  virtual ~NodeTopicsInterface() = default;
  virtual std::string resolve_topic_name(const std::string& name,
                                         bool only_expand = false) const = 0;
};
}  // namespace node_interfaces

/// The types of parameters that the nodes have, of those that ParameterValue knows.
template <class T>
inline constexpr bool is_parameter =
    std::is_same_v<T, bool> || std::is_same_v<T, std::int64_t> || std::is_same_v<T, double> ||
    std::is_same_v<T, std::string> || std::is_same_v<T, std::vector<double>>;

class Node {
 public:
  explicit Node(const std::string& name);
  virtual ~Node() = default;

  template <class T>
  T declare_parameter(const std::string& name, const T& value,
                      const rcl_interfaces::msg::ParameterDescriptor& descriptor,
                      bool ignore_override = false) {
    static_assert(is_parameter<T>);
    return declare<T>(name, value, descriptor, ignore_override);
  }
  template <class Message>
  typename Publisher<Message>::SharedPtr create_publisher(const std::string& topic, const QoS& qos);
  template <class Message, class Callback>
  typename Subscription<Message>::SharedPtr create_subscription(const std::string& topic,
                                                                const QoS& qos, Callback&& take) {
    // a callback that takes a shared pointer to a message, one of those that rclcpp knows
    std::function<void(std::shared_ptr<const Message>)> checked = std::forward<Callback>(take);
    return keep<Message>(topic, qos, checked);
  }
  template <class Kind, class Callback>
  typename Service<Kind>::SharedPtr create_service(const std::string& name, Callback&& answer) {
    std::function<void(std::shared_ptr<typename Kind::Request>,
                       std::shared_ptr<typename Kind::Response>)>
        checked = std::forward<Callback>(answer);
    return serve<Kind>(name, checked);
  }
  template <class Rep, class Period, class Callback>
  TimerBase::SharedPtr create_wall_timer(std::chrono::duration<Rep, Period> period,
                                         Callback callback) {
    std::function<void()> checked = callback;
    return time(std::chrono::duration<double>(period), checked);
  }

  Time now() const;
  Clock::SharedPtr get_clock();
  Logger get_logger() const;
  const char* get_fully_qualified_name() const;
  std::map<std::string, std::vector<std::string>> get_topic_names_and_types() const;
  node_interfaces::NodeTopicsInterface::SharedPtr get_node_topics_interface();

 private:
  template <class T>
  T declare(const std::string&, const T&, const rcl_interfaces::msg::ParameterDescriptor&, bool);
  template <class Message, class Function>
  typename Subscription<Message>::SharedPtr keep(const std::string&, const QoS&, Function);
  template <class Kind, class Function>
  typename Service<Kind>::SharedPtr serve(const std::string&, Function);
  TimerBase::SharedPtr time(std::chrono::duration<double>, std::function<void()>);
};

TimerBase::SharedPtr timer_of(Clock::SharedPtr, Duration, std::function<void()>);

template <class NodeT, class Callback>
TimerBase::SharedPtr create_timer(NodeT, Clock::SharedPtr clock, Duration period,
                                  Callback&& callback) {
  std::function<void()> checked = std::forward<Callback>(callback);
  return timer_of(clock, period, checked);
}

class Context;

class InitOptions {};

enum class SignalHandlerOptions { All, SigInt, SigTerm, None };

void init(int argc, const char* const argv[], const InitOptions& options = InitOptions(),
          SignalHandlerOptions signals = SignalHandlerOptions::All);
void spin(std::shared_ptr<Node> node);
bool shutdown(std::shared_ptr<Context> context = nullptr,
              const std::string& reason = "user called rclcpp::shutdown()");
bool sleep_for(const std::chrono::nanoseconds& span, std::shared_ptr<Context> context = nullptr);

}  // namespace rclcpp
