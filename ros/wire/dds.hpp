// SPDX-License-Identifier: MIT
// Fast DDS as ROS 2 uses it: plain CDR, the type support of each message by its members, the same
// qualities of service. Over the loopback interface only.
#pragma once
#include <fastcdr/Cdr.h>
#include <fastcdr/FastBuffer.h>
#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>

#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/TopicDataType.hpp>
#include <fastdds/dds/topic/TypeSupport.hpp>
#include <memory>
#include <stdexcept>
#include <string>
#include <type_traits>

namespace seatrial::wire {

namespace fastdds = eprosima::fastdds::dds;
namespace rtps = eprosima::fastrtps::rtps;
using eprosima::fastcdr::Cdr;
using eprosima::fastcdr::FastBuffer;

namespace detail {

struct Ignore {
  template <class T>
  void operator()(const char* /*name*/, T& /*member*/) const {}
};

/// A message has members to visit; all else is a number, a text, or many numbers.
template <class T, class = void>
struct IsMessage : std::false_type {};
template <class T>
struct IsMessage<T, std::void_t<decltype(std::declval<T&>().each(Ignore{}))>> : std::true_type {};

template <class T>
void put(Cdr& cdr, T& value) {
  if constexpr (IsMessage<T>::value) {
    value.each([&cdr](const char*, auto& member) { put(cdr, member); });
  } else {
    cdr.serialize(value);
  }
}

template <class T>
void get(Cdr& cdr, T& value) {
  if constexpr (IsMessage<T>::value) {
    value.each([&cdr](const char*, auto& member) { get(cdr, member); });
  } else {
    cdr.deserialize(value);
  }
}

/// Length [bytes] of what was written.
template <class Message>
std::uint32_t write(Message& message, FastBuffer& buffer) {
  Cdr cdr(buffer, Cdr::LITTLE_ENDIANNESS, Cdr::DDS_CDR);
  cdr.serialize_encapsulation();
  put(cdr, message);
  return static_cast<std::uint32_t>(cdr.getSerializedDataLength());
}

}  // namespace detail

/// How Fast DDS handles a message type: XCDR1, little endian, without a key.
template <class Message>
class TypeSupport final : public fastdds::TopicDataType {
 public:
  TypeSupport() {
    setName(Message::kType);
    Message empty;
    m_typeSize = length(empty);  // payloads grow where texts and sequences do
    m_isGetKeyDefined = false;
  }

  bool serialize(void* data, rtps::SerializedPayload_t* payload) override {
    FastBuffer buffer(reinterpret_cast<char*>(payload->data), payload->max_size);
    try {
      payload->length = detail::write(*static_cast<Message*>(data), buffer);
    } catch (const std::exception&) {  // no room
      return false;
    }
    payload->encapsulation = CDR_LE;
    return true;
  }

  bool deserialize(rtps::SerializedPayload_t* payload, void* data) override {
    FastBuffer buffer(reinterpret_cast<char*>(payload->data), payload->length);
    Cdr cdr(buffer, Cdr::DEFAULT_ENDIAN, Cdr::DDS_CDR);
    try {
      cdr.read_encapsulation();
      detail::get(cdr, *static_cast<Message*>(data));
    } catch (const std::exception&) {  // not such a message
      return false;
    }
    return true;
  }

  std::function<std::uint32_t()> getSerializedSizeProvider(void* data) override {
    return [data] { return length(*static_cast<Message*>(data)); };
  }

  void* createData() override { return new Message; }
  void deleteData(void* data) override { delete static_cast<Message*>(data); }
  bool getKey(void*, rtps::InstanceHandle_t*, bool) override { return false; }

 private:
  static std::uint32_t length(Message& message) {
    FastBuffer growing;
    return detail::write(message, growing);
  }
};

/// ROS 2's profiles: rclcpp::QoS(10), rclcpp::SensorDataQoS().
enum class Profile { kDefault, kSensorData };

/// Sets reliability and depth of a writer or reader; volatile, as both profiles are.
template <class Qos>
Qos with(Profile profile, Qos qos) {
  const bool reliable = profile == Profile::kDefault;
  qos.reliability().kind =
      reliable ? fastdds::RELIABLE_RELIABILITY_QOS : fastdds::BEST_EFFORT_RELIABILITY_QOS;
  qos.durability().kind = fastdds::VOLATILE_DURABILITY_QOS;
  qos.history().kind = fastdds::KEEP_LAST_HISTORY_QOS;
  qos.history().depth = reliable ? 10 : 5;
  qos.endpoint().history_memory_policy = rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
  qos.data_sharing().off();
  return qos;
}

/// A participant in a domain, over 127.0.0.1 and nothing else. Owns its writers and readers.
class Participant {
 public:
  explicit Participant(std::uint32_t domain) {
    fastdds::DomainParticipantQos qos = fastdds::PARTICIPANT_QOS_DEFAULT;
    auto loopback = std::make_shared<eprosima::fastdds::rtps::UDPv4TransportDescriptor>();
    loopback->interfaceWhiteList = {"127.0.0.1"};
    qos.transport().use_builtin_transports = false;
    qos.transport().user_transports.push_back(loopback);
    participant_ = made(factory().create_participant(domain, qos), "participant");
    publisher_ = made(participant_->create_publisher(fastdds::PUBLISHER_QOS_DEFAULT), "publisher");
    subscriber_ =
        made(participant_->create_subscriber(fastdds::SUBSCRIBER_QOS_DEFAULT), "subscriber");
  }
  Participant(const Participant&) = delete;
  Participant& operator=(const Participant&) = delete;
  ~Participant() {
    participant_->delete_contained_entities();
    factory().delete_participant(participant_);
  }

  template <class Message>
  fastdds::DataWriter& writer(const char* topic, Profile profile) {
    const auto qos = with(profile, fastdds::DATAWRITER_QOS_DEFAULT);
    return *made(publisher_->create_datawriter(&about<Message>(topic), qos), topic);
  }

  template <class Message>
  fastdds::DataReader& reader(const char* topic, Profile profile) {
    const auto qos = with(profile, fastdds::DATAREADER_QOS_DEFAULT);
    return *made(subscriber_->create_datareader(&about<Message>(topic), qos), topic);
  }

 private:
  static fastdds::DomainParticipantFactory& factory() {
    return *fastdds::DomainParticipantFactory::get_instance();
  }

  template <class T>
  static T* made(T* entity, const char* what) {
    if (entity == nullptr) throw std::runtime_error(std::string("DDS: can't make ") + what);
    return entity;
  }

  template <class Message>
  fastdds::Topic& about(const char* topic) {
    const fastdds::TypeSupport type(new TypeSupport<Message>);
    type.register_type(participant_);
    return *made(participant_->create_topic(topic, Message::kType, fastdds::TOPIC_QOS_DEFAULT),
                 topic);
  }

  fastdds::DomainParticipant* participant_ = nullptr;
  fastdds::Publisher* publisher_ = nullptr;
  fastdds::Subscriber* subscriber_ = nullptr;
};

}  // namespace seatrial::wire
