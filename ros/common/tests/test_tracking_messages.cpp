// SPDX-License-Identifier: MIT
// Commands into messages, and references out of them.
#include <doctest/doctest.h>

#include <cmath>

#include "seatrial_ros/command_writer.hpp"
#include "seatrial_ros/number_messages.hpp"
#include "seatrial_ros/signal.hpp"
#include "seatrial_ros/target.hpp"

using namespace seatrial;  // NOLINT(google-build-using-namespace)
using ros::Channel;

namespace {

Channel channel(const char* topic, const char* field, int index, double gain, double offset) {
  Channel c;
  c.name = field;
  c.topic = topic;
  c.field = field;
  c.index = index;
  c.gain = gain;
  c.offset = offset;
  return c;
}

/// On a circle of 2 m at 0.5 rad/s, forward along the sensitivities; a frame, and a stamp from 100
/// s on.
ros::MotionMessage on_circle(double t) {
  ros::MotionMessage m;
  const double s = 0.5 * t;
  m.stamp = 100'000'000'000 + std::llround(t * 1e9);
  m.frame = "map";
  m.eta[0] = 2.0 * std::cos(s);
  m.eta[1] = 2.0 * std::sin(s);
  m.eta[2] = s + kPi / 2.0;
  m.nu[0] = 1.0;
  m.nu[2] = 0.5;
  return m;
}

struct Vector {
  double x = 0.0, y = 0.0, z = 0.0;
};

struct Header {
  int stamp = 0;
};

/// With the members of either ROS's messages.
struct Messages {
  struct Joy {
    Header header;
    std::vector<float> axes;
    std::vector<int> buttons;
  };
  struct Wrench {
    Vector force;
    Vector torque;
  };
  struct WrenchStamped {
    Header header;
    Wrench wrench;
  };
  struct Twist {
    Vector linear;
    Vector angular;
  };
  struct TwistStamped {
    Header header;
    Twist twist;
  };
  struct JointState {
    Header header;
    std::vector<double> position, velocity, effort;
  };
  template <class Number>
  struct Data {
    Number data = {};
  };
  using Float32MultiArray = Data<std::vector<float>>;
  using Float64MultiArray = Data<std::vector<double>>;
  using Float32 = Data<float>;
  using Float64 = Data<double>;
};

}  // namespace

TEST_CASE("Every type's numbers are written where they are read, and headers are found") {
  const std::vector<std::pair<const char*, ros::Numbers>> all = {
      {"sensor_msgs/Joy", {{0.5, -0.25}, {}}},
      {"geometry_msgs/Wrench", {{1, 2, 3, 4, 5, 6}}},
      {"geometry_msgs/msg/WrenchStamped", {{1, 2, 3, 4, 5, 6}}},
      {"geometry_msgs/Twist", {{1, 2, 3, 4, 5, 6}}},
      {"geometry_msgs/msg/TwistStamped", {{1, 2, 3, 4, 5, 6}}},
      {"sensor_msgs/JointState", {{0.1, 0.2}, {}, {0.3}}},
      {"std_msgs/Float64MultiArray", {{0.1, 0.2, 0.3}}},
      {"std_msgs/msg/Float32MultiArray", {{0.5, 0.25}}},
      {"std_msgs/Float64", {{0.1}}},
      {"std_msgs/msg/Float32", {{0.75}}}};
  for (const auto& one : all) {
    const std::string name = one.first;
    CAPTURE(name);
    const bool stamped = ros::with_message<Messages>(name, [&one](auto message) {
      ros::put_numbers(one.second, message);
      CHECK(ros::numbers_in(message) == one.second);
      bool found = false;
      ros::with_header(message, [&found](const Header&) { found = true; });
      return found;
    });
    const bool has_one = name.find("Stamped") != std::string::npos || name == "sensor_msgs/Joy" ||
                         name == "sensor_msgs/JointState";
    CHECK(stamped == has_one);
  }
}

TEST_CASE("What is written into messages is read out of them") {
  const std::vector<Channel> inputs = {channel("/joy", "axes", 3, -1.0, 0.0),
                                       channel("/joy", "axes", 1, 2.0, 0.5),
                                       channel("/wrench", "wrench.torque.z", -1, 1.0, 0.0),
                                       channel("/pulses", "data", 2, 1.0 / 400.0, -1500.0 / 400.0)};
  const double values[] = {0.25, -0.75, 0.5, -0.125};
  ros::Signal signal(inputs);
  const auto topics = ros::command_topics(inputs);
  REQUIRE(topics.size() == 3);
  for (const auto& topic : topics) {
    const auto type = topic.name() == "/joy"      ? "sensor_msgs/Joy"
                      : topic.name() == "/wrench" ? "geometry_msgs/WrenchStamped"
                                                  : "std_msgs/Float64MultiArray";
    const ros::Shape* shape = ros::shape_of(type);
    CHECK(topic.kind() == shape->kind);
    signal.set_type(topic.name(), type);
    ros::NumbersMessage message;
    message.topic = topic.name();
    message.numbers = topic.numbers(values);
    const bool last = topic.name() == "/wrench";  // in the order of names
    CHECK(signal.update(message) == last);
  }
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    CHECK(signal.values()[i] == doctest::Approx(values[i]));
  }
}

TEST_CASE("Raw numbers by hand") {
  const std::vector<Channel> inputs = {channel("/p", "data", 1, 1.0 / 400.0, -1500.0 / 400.0)};
  const double half = 0.5;
  const auto numbers = ros::command_topics(inputs)[0].numbers(&half);
  REQUIRE(numbers.size() == 1);
  REQUIRE(numbers[0].size() == 2);
  CHECK(numbers[0][0] == 0.0);
  CHECK(numbers[0][1] == doctest::Approx(1700.0));
}

TEST_CASE("Commands that no message carries are refused") {
  const auto refuses = [](const std::vector<Channel>& inputs, const char* words) {
    CHECK_THROWS_WITH_AS(ros::command_topics(inputs), doctest::Contains(words), std::runtime_error);
  };
  refuses({channel("/a", "surge", -1, 1.0, 0.0)}, "no message that is known has a field 'surge'");
  refuses({channel("/joy", "buttons", 0, 1.0, 0.0)}, "commands need an axis");
  refuses({channel("/a", "axes", 0, 1.0, 0.0), channel("/a", "data", 0, 1.0, 0.0)},
          "has no field 'data[0]'");
}

TEST_CASE("A steady turn continues") {
  ros::Target target;
  CHECK_FALSE(target.known());
  target.follow(on_circle(0.0));
  CHECK(target.frame() == "map");
  const auto later = on_circle(0.1);
  CHECK(target.age(later.stamp) == doctest::Approx(0.1));
  const Reference r = target.at(later.stamp);
  double rate[kAxes];
  body_to_earth(later.eta[2], later.nu, rate);
  const double chord = 2.0 * std::pow(0.05, 3) / 24.0;  // [m] chord and arc, R (r t)^3 / 24
  const double inward[kAxes] = {-0.25 * later.eta[0], -0.25 * later.eta[1], 0.0};
  for (int i = 0; i < kAxes; ++i) {
    CHECK(std::abs(r.eta[i] - later.eta[i]) < 1.05 * chord);
    CHECK(std::abs(r.rate[i] - rate[i]) < 1e-12);
    CHECK(std::abs(r.acceleration[i] - inward[i]) < 1e-12);
  }
}

TEST_CASE("An accelerating reference keeps accelerating") {
  const auto speeding = [](double t) {  // 0.3 m/s^2 along y, the heading kept
    ros::MotionMessage m = on_circle(t);
    m.eta[0] = 1.0;
    m.eta[1] = 0.15 * t * t;
    m.eta[2] = kPi / 2.0;
    m.nu[0] = 0.3 * t;
    m.nu[2] = 0.0;
    return m;
  };
  ros::Target target;
  target.follow(speeding(1.0));
  CHECK(target.at(speeding(1.0).stamp).acceleration[1] == 0.0);  // one message knows none
  target.follow(speeding(1.05));
  const Reference r = target.at(speeding(1.2).stamp);
  CHECK(r.eta[1] == doctest::Approx(speeding(1.2).eta[1]));
  CHECK(r.rate[1] == doctest::Approx(0.36));
  CHECK(r.acceleration[1] == doctest::Approx(0.3));
}

TEST_CASE("References that are close together keep the acceleration of those apart") {
  const auto speeding = [](double t, double rounding) {  // 0.3 m/s^2 forward
    ros::MotionMessage m = on_circle(t);
    m.eta[2] = 0.0;
    m.nu[0] = 0.3 * t + rounding;
    m.nu[2] = 0.0;
    return m;
  };
  ros::Target target;
  for (const double t : {1.0, 1.05}) target.follow(speeding(t, 0.0));
  const auto twin = speeding(1.05001, 0.001);
  target.follow(twin);
  CHECK(target.at(twin.stamp).rate[0] == twin.nu[0]);
  CHECK(target.at(twin.stamp).acceleration[0] == doctest::Approx(0.3));
  // a stream at 200 Hz, each rounded to millimetres a second, up or down
  for (int k = 0; k < 40; ++k) target.follow(speeding(1.06 + 0.005 * k, k % 2 == 0 ? 5e-4 : -5e-4));
  CHECK(std::abs(target.at(twin.stamp).acceleration[0] - 0.3) <= 1e-3 / 0.015);
}

TEST_CASE("A goal is held still and does not age, and a reference after it has no difference") {
  ros::Target target;
  target.follow(on_circle(0.0));
  target.hold(on_circle(0.1));
  const std::int64_t later = on_circle(1000.0).stamp;
  CHECK(target.age(later) == 0.0);
  const Reference r = target.at(later);
  CHECK(r.eta[0] == on_circle(0.1).eta[0]);
  CHECK(r.rate[0] == 0.0);
  auto quicker = on_circle(0.2);
  quicker.nu[1] = 0.4;
  target.follow(quicker);
  CHECK(target.at(quicker.stamp).acceleration[0] ==
        doctest::Approx(-0.25 * quicker.eta[0] - 0.5 * 0.4 * std::cos(quicker.eta[2])));
}

TEST_CASE("References far apart are not differentiated, nor those out of order") {
  ros::Target target;
  target.follow(on_circle(0.0));
  for (const double t : {0.6, 0.5}) {
    auto other = on_circle(t);
    other.nu[0] = 0.0;
    other.nu[2] = t;
    target.follow(other);
    CHECK(target.at(other.stamp).acceleration[2] == 0.0);
  }
}
