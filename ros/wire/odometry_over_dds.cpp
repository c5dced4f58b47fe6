// SPDX-License-Identifier: MIT
// The odometer on DDS with ROS 2's names, types and qualities of service, without ROS 2:
//   odometry_over_dds script PROFILE MODEL   messages from lines of the standard input
//   odometry_over_dds serve PROFILE MODEL    messages from rt/pose and rt/joy
// PROFILE: default or sensor-data, quality of service. MODEL: a model file of axes of a joypad.
// Publishes rt/odom, one message for each that comes in after the first pose, at its stamp. Prints
// "ready" once others listen (and send), then each message: what it got, what it published. Ends at
// the end of the standard input.
#include <poll.h>
#include <unistd.h>

#include <cstdio>
#include <fastdds/dds/core/condition/WaitSet.hpp>
#include <iostream>
#include <memory>
#include <thread>

#include "messages.hpp"
#include "seatrial_ros/messages.hpp"
#include "seatrial_ros/model_file.hpp"
#include "text.hpp"

namespace {

using namespace seatrial::wire;  // NOLINT(google-build-using-namespace)
using builtin_interfaces::msg::Time;
using geometry_msgs::msg::PoseStamped;
using sensor_msgs::msg::Joy;
using Clock = std::chrono::steady_clock;

constexpr std::uint32_t kDomain = 0;                  // ROS_DOMAIN_ID
constexpr auto kPatience = std::chrono::seconds(20);  // to find the others
constexpr std::int64_t kSecond = 1000000000;          // [ns]

std::int64_t nanoseconds(const Time& t) { return kSecond * t.sec + t.nanosec; }

/// Axes that the model's inputs are read from: as many as the last of them needs.
std::size_t axes_of(const seatrial::ros::BoardModel& board) {
  int most = 0;
  for (const seatrial::ros::Channel& input : board.inputs) {
    if (input.field != "axes" || input.index < 0) {
      throw std::runtime_error("input " + input.name + ": read from '" + input.field +
                               "', expected axes[...] of a sensor_msgs/Joy");
    }
    most = std::max(most, input.index + 1);
  }
  return static_cast<std::size_t>(most);
}

/// The odometer between messages.
class Boat {
 public:
  Boat(const seatrial::ros::BoardModel& board, fastdds::DataWriter& odometry)
      : board_(board),
        axes_(axes_of(board)),
        odometry_(odometry),
        odometer_(std::make_unique<seatrial::Odometer>(board.model, board.pose.lever)) {}

  void take(PoseStamped& message) {
    show("pose", message);
    double raw[seatrial::kPose];
    seatrial::ros::read(message.pose, raw);
    const seatrial::ros::PoseSource& source = board_.pose;
    const double eta[seatrial::kPose] = {source.x.value(raw[0]), source.y.value(raw[1]),
                                         source.heading.value(raw[2])};
    odometer_->pose(nanoseconds(message.header.stamp), eta);
    publish(message.header.stamp);
  }

  void take(Joy& message) {
    show("joy", message);
    if (message.axes.size() < axes_) {
      throw std::runtime_error("joy: got " + std::to_string(message.axes.size()) +
                               " axes, expected " + std::to_string(axes_) +
                               " or more, as the model file reads them");
    }
    std::vector<double> values;
    for (const seatrial::ros::Channel& input : board_.inputs) {
      values.push_back(input.value(message.axes[static_cast<std::size_t>(input.index)]));
    }
    odometer_->command(nanoseconds(message.header.stamp), values.data());
    publish(message.header.stamp);
  }

 private:
  template <class Message>
  static void show(const char* what, Message& message) {
    std::cout << what << text(message) << std::endl;
  }

  void publish(const Time& stamp) {
    const seatrial::Odometry found = odometer_->at(nanoseconds(stamp));
    if (!found.known) return;
    nav_msgs::msg::Odometry message;
    seatrial::ros::fill(found, seatrial::ros::Frames{}, message);
    message.header.stamp = stamp;
    show("odometry", message);
    if (!odometry_.write(&message)) throw std::runtime_error("rt/odom: could not be written");
  }

  const seatrial::ros::BoardModel& board_;
  std::size_t axes_;
  fastdds::DataWriter& odometry_;
  std::unique_ptr<seatrial::Odometer> odometer_;  // too large for a stack
};

/// Waits for something. Throws where that takes too long.
template <class True>
void until(const std::string& what, True true_now) {
  const auto end = Clock::now() + kPatience;
  while (!true_now()) {
    if (Clock::now() > end) {
      throw std::runtime_error(what + " within " + std::to_string(kPatience.count()) + " s");
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
}

void until_heard(fastdds::DataWriter& writer) {
  const std::string topic = writer.get_topic()->get_name();
  until(topic + ": nobody subscribed", [&writer, &topic] {
    fastdds::OfferedIncompatibleQosStatus refused;
    writer.get_offered_incompatible_qos_status(refused);
    if (refused.total_count > 0) {
      const bool reliable = refused.last_policy_id == fastdds::RELIABILITY_QOS_POLICY_ID;
      throw std::runtime_error(
          topic + (reliable ? ": a subscriber asks for reliable, offered is best effort; publish "
                              "as 'default', or subscribe as best effort"
                            : ": a subscriber asks for more than is offered in DDS's policy " +
                                  std::to_string(refused.last_policy_id)));
    }
    fastdds::PublicationMatchedStatus matched;
    writer.get_publication_matched_status(matched);
    return matched.current_count > 0;
  });
}

void until_sent(fastdds::DataReader& reader) {
  until(reader.get_topicdescription()->get_name() + ": nobody publishes", [&reader] {
    fastdds::SubscriptionMatchedStatus matched;
    reader.get_subscription_matched_status(matched);
    return matched.current_count > 0;
  });
}

void ready() { std::cout << "ready" << std::endl; }

void script(Boat& boat) {
  for (std::string line; std::getline(std::cin, line);) {
    std::istringstream words(line);
    std::string kind;
    words >> kind;
    if (kind == "pose") {
      auto message = parse<PoseStamped>(words);
      boat.take(message);
    } else if (kind == "joy") {
      auto message = parse<Joy>(words);
      boat.take(message);
    } else {
      throw std::runtime_error("got a line that begins with '" + kind + "', expected pose or joy");
    }
  }
}

/// Whether nobody can write to the standard input any more.
bool input_ended() {
  pollfd input{STDIN_FILENO, POLLIN, 0};
  char ignored = 0;
  return poll(&input, 1, 0) > 0 && read(STDIN_FILENO, &ignored, 1) <= 0;
}

template <class Message>
void take_all(fastdds::DataReader& reader, Boat& boat) {
  Message message;
  fastdds::SampleInfo info;
  while (reader.take_next_sample(&message, &info) ==
         eprosima::fastrtps::types::ReturnCode_t::RETCODE_OK) {
    if (info.valid_data) boat.take(message);
  }
}

void serve(Boat& boat, fastdds::DataReader& poses, fastdds::DataReader& commands) {
  fastdds::WaitSet news;
  for (fastdds::DataReader* reader : {&poses, &commands}) {
    reader->get_statuscondition().set_enabled_statuses(fastdds::StatusMask::data_available());
    news.attach_condition(reader->get_statuscondition());
  }
  while (!input_ended()) {
    fastdds::ConditionSeq active;
    news.wait(active, eprosima::fastrtps::Duration_t(0, 50000000));  // [ns]
    take_all<PoseStamped>(poses, boat);
    take_all<Joy>(commands, boat);
  }
}

int run(const std::string& verb, Profile profile, const char* path) {
  const seatrial::ros::BoardModel board = seatrial::ros::load_model(path);
  Participant participant(kDomain);
  fastdds::DataWriter& odometry = participant.writer<nav_msgs::msg::Odometry>("rt/odom", profile);
  Boat boat(board, odometry);
  if (verb == "script") {
    until_heard(odometry);
    ready();
    script(boat);
    return 0;
  }
  fastdds::DataReader& poses = participant.reader<PoseStamped>("rt/pose", profile);
  fastdds::DataReader& commands = participant.reader<Joy>("rt/joy", profile);
  until_heard(odometry);
  until_sent(poses);
  until_sent(commands);
  ready();
  serve(boat, poses, commands);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  const std::string verb = argc == 4 ? argv[1] : "";
  const std::string profile = argc == 4 ? argv[2] : "";
  if ((verb != "script" && verb != "serve") || (profile != "default" && profile != "sensor-data")) {
    std::cerr << "odometry_over_dds script|serve default|sensor-data MODEL" << std::endl;
    return 2;
  }
  try {
    return run(verb, profile == "default" ? Profile::kDefault : Profile::kSensorData, argv[3]);
  } catch (const std::exception& error) {
    std::cerr << error.what() << std::endl;
    return 1;
  }
}
