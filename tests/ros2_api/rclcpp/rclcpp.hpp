// SPDX-License-Identifier: MIT
// Declarations of the part of rclcpp that the node for ROS 2 uses, after its documentation (Humble;
// https://docs.ros2.org). Enough for a compiler to check calls; there is nothing behind them.
#pragma once
#include <builtin_interfaces/msg/time.hpp>
#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <rcl_interfaces/msg/parameter_descriptor.hpp>
#include <string>
#include <vector>

#define RCLCPP_INFO(logger, ...) (void)(logger), std::printf(__VA_ARGS__)
#define RCLCPP_ERROR(logger, ...) (void)(logger), std::printf(__VA_ARGS__)
#define RCLCPP_ERROR_THROTTLE(logger, clock, duration, ...) \
  (void)(logger), (void)(clock), (void)(duration), std::printf(__VA_ARGS__)

namespace rclcpp {

class Time {
 public:
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

class Logger {};

class Clock {
 public:
  using SharedPtr = std::shared_ptr<Clock>;
};

class TimerBase {
 public:
  using SharedPtr = std::shared_ptr<TimerBase>;
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

class Node {
 public:
  explicit Node(const std::string& name);
  virtual ~Node() = default;

  template <class T>
  T declare_parameter(const std::string& name, const T& value,
                      const rcl_interfaces::msg::ParameterDescriptor& descriptor,
                      bool ignore_override = false);
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

void init(int argc, const char* const* argv);
void spin(std::shared_ptr<Node> node);
bool shutdown();

}  // namespace rclcpp
