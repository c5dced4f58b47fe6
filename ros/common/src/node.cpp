// SPDX-License-Identifier: MIT
#include "seatrial_ros/node.hpp"

#include <sys/stat.h>

#include <utility>

namespace seatrial::ros {

namespace {

constexpr std::size_t kRecent = 1024;  // messages that another model reads again
constexpr double kSilence = 1.0;       // [s] between commands that odometry after each can bear
constexpr double kLateShown = 5.0;     // [s] for which a pose that came too late is reported

/// When a file was written [ns]; 0: there is none.
std::int64_t written(const std::string& path) {
  struct stat found {};
  if (path.empty() || ::stat(path.c_str(), &found) != 0) return 0;
  return std::int64_t{found.st_mtim.tv_sec} * 1000000000 + found.st_mtim.tv_nsec;
}

/// Values (n) forward-left-up in the axes of the model file.
std::vector<double> in_file_axes(const double* values, const std::vector<Channel>& channels) {
  std::vector<double> found(channels.size());
  for (std::size_t i = 0; i < channels.size(); ++i) found[i] = channels[i].turn * values[i];
  return found;
}

Settings checked(Settings settings) {
  check(settings);
  return settings;
}

double seconds(std::int64_t span) { return 1e-9 * static_cast<double>(span); }

std::int64_t chosen(std::int64_t header, std::int64_t arrival, Clock clock) {
  return header == 0 || clock == Clock::kBag ? arrival : header;
}

/// Of commands and scale signals, each once.
std::set<std::string> number_topics_of(const BoardModel& board) {
  std::set<std::string> topics;
  for (const auto* channels : {&board.inputs, &board.scales}) {
    for (const Channel& c : *channels) topics.insert(c.topic);
  }
  return topics;
}

/// Those of the subscriptions: the pose's, then the others.
Words topics_of(const BoardModel& board) {
  Words found = {board.pose.topic};
  for (const std::string& topic : number_topics_of(board)) found.push_back(topic);
  return found;
}

void expect_same_topics(const BoardModel& before, const BoardModel& now) {
  const Words old = topics_of(before);
  const Words own = topics_of(now);
  if (old != own) {
    throw std::runtime_error("the new model has other topics: " + joined(own) + "; expected " +
                             joined(old) + " as before; restart the node");
  }
}

}  // namespace

Node::Node(Settings settings)
    : settings_(checked(std::move(settings))),
      path_(settings_.model),
      adapted_(written(settings_.adapted_model)),
      live_(static_cast<int>(settings_.live_port)) {
  BoardModel board = load(path_);
  apply_topics(board);
  if (board.pose.topic.empty()) {
    throw std::runtime_error("neither the vehicle nor the parameter pose_topic names a topic");
  }
  odometer_ = std::make_unique<Odometer>(board.model, board.pose.lever);
  board_ = std::move(board);
  command_ = Signal(board_.inputs, board_.model.command_timeout);
  scale_ = Signal(board_.scales);
  map_frame_ = settings_.map_frame;
}

std::set<std::string> Node::number_topics() const { return number_topics_of(board_); }

void Node::refuse_own_topic(const std::string& name) {
  throw std::runtime_error("topic " + name +
                           " is what this node publishes; expected: poses and commands of others; "
                           "give pose_topic or remap");
}

void Node::set_type(const std::string& topic, const std::string& type) {
  known_shape(topic, type);
  for (Signal* signal : {&command_, &scale_}) signal->set_type(topic, type);
  types_[topic] = type;
}

void Node::pose(const PoseMessage& in) {
  keep(in);
  take(in, true);
}

void Node::numbers(const NumbersMessage& in) {
  numbers_at_ = in.arrival;
  keep(in);
  take(in, true);
}

template <class Message>
void Node::keep(const Message& in) {
  recent_.emplace_back(in);
  if (recent_.size() > kRecent) recent_.pop_front();
}

void Node::take(const PoseMessage& in, bool first) {
  const PoseSource& source = board_.pose;
  if (!source.parent.empty() && !in.frame.empty() && in.frame != source.parent) return;
  if (!source.child.empty() && !in.child.empty() && in.child != source.child) return;
  if (settings_.map_frame.empty() && !in.frame.empty()) map_frame_ = in.frame;
  const double eta[kPose] = {source.x.value(in.eta[0]), source.y.value(in.eta[1]),
                             source.heading.value(in.eta[2])};
  const double gain[kPose] = {source.x.gain, source.y.gain, source.heading.gain};
  double covariance[kPose * kPose];
  for (int i = 0; i < kPose; ++i) {
    for (int j = 0; j < kPose; ++j) {
      covariance[kPose * i + j] = gain[i] * gain[j] * in.covariance[kPose * i + j];
    }
  }
  const bool own = settings_.pose_covariance && in.has_covariance;
  const std::int64_t stamp = chosen(in.stamp, in.arrival, source.clock);
  const double behind = seconds(odometer_->newest() - stamp);
  if (odometer_->pose(stamp, eta, own ? covariance : nullptr) == Taken::kStale) {
    late_ = behind;
    late_at_ = in.arrival;
  }
  if (first) send_pose(stamp, eta, own ? covariance : nullptr);
}

void Node::send_pose(std::int64_t stamp, const double* eta, const double* covariance) {
  if (!live_.on()) return;
  const std::vector<Channel> channels = {board_.pose.x, board_.pose.y, board_.pose.heading};
  std::vector<double> spread;
  for (int i = 0; covariance != nullptr && i < kPose * kPose; ++i) {
    spread.push_back(channels[i / kPose].turn * channels[i % kPose].turn * covariance[i]);
  }
  live_.send("pose", stamp, in_file_axes(eta, channels), spread);
}

void Node::take(const NumbersMessage& in, bool first) {
  const std::int64_t stamp = chosen(in.stamp, in.arrival, board_.commands.clock);
  if (command_.update(in)) {
    odometer_->command(stamp, command_.values());
    if (first) live_.send("command", stamp, in_file_axes(command_.values(), command_.channels()));
  }
  if (scale_.update(in)) {
    odometer_->scale(stamp, scale_.values());
    if (first) live_.send("scale", stamp, in_file_axes(scale_.values(), scale_.channels()));
  }
}

Odometry Node::tick(std::int64_t now) {
  live_.receive();
  if (ahead(now) <= settings_.window) return odometer_->at(now);
  Odometry none;
  none.stamp = now;
  return none;
}

double Node::ahead(std::int64_t now) const {
  const std::int64_t newest = odometer_->newest();
  return newest == 0 ? 0.0 : seconds(newest - now);
}

Diagnosis Node::diagnose(std::int64_t now) {
  Diagnosis out;
  const std::string fault = timing_fault(now);
  if (!fault.empty()) out.message = fault;
  Estimate motion;
  motion.health = kNoPose;
  if (ahead(now) <= settings_.window) motion = odometer_->look(now);
  const std::uint32_t health = motion.health;
  for (const HealthWords& words : kHealthWords) {
    if ((health & words.flag) == 0U) continue;
    out.values.emplace_back(words.name, "yes");
    const bool said = words.flag == kNoPose && !fault.empty();
    if (!said) out.message += (out.message.empty() ? "" : "; ") + std::string(words.advice);
  }
  const std::string silence = silence_fault(now);
  if (!silence.empty()) out.message += (out.message.empty() ? "" : "; ") + silence;
  const bool changed = live_.diagnose(out);
  if (out.message.empty()) out.message = "odometry by the model and poses";
  const bool faulty = health != 0U || !fault.empty() || !silence.empty() || changed;
  out.level =
      (health & kNoPose) != 0U ? Diagnosis::kError : (faulty ? Diagnosis::kWarn : Diagnosis::kOk);
  out.values.emplace_back("model", board_.name + " (" + path_ + ")");
  const double age = motion.time - motion.last_pose;
  out.values.emplace_back("age of the last pose used [s]",
                          std::abs(age) < 1e9 ? std::to_string(age) : "none yet");
  if (live_.lost() != 0) {
    out.values.emplace_back("lines to live_port without a receiver", std::to_string(live_.lost()));
  }
  static constexpr const char* kNames[kSources] = {"commands", "scales", "poses"};
  for (int s = 0; s < kSources; ++s) {
    for (int o = 0; o < kOutcomes; ++o) {
      const auto n = odometer_->count(static_cast<Source>(s), static_cast<Taken>(o));
      if (n == 0 && o != 0) continue;
      out.values.emplace_back(std::string(kNames[s]) + " " + kTakenWords[o], std::to_string(n));
    }
  }
  return out;
}

std::string Node::silence_fault(std::int64_t now) const {
  const double silent = seconds(now - numbers_at_);
  if (settings_.rate > 0.0 || (numbers_at_ != 0 && silent <= kSilence)) return "";
  return "no odometry: it follows each command (rate: 0), and " +
         (numbers_at_ == 0 ? "none has come" : "none has come for " + plain(silent) + " s") +
         ". Check that commands arrive, or give a rate";
}

std::string Node::timing_fault(std::int64_t now) const {
  const std::string window = plain(settings_.window) + " s";
  if (ahead(now) > settings_.window) {
    return "no odometry: the newest input is stamped " + plain(ahead(now)) +
           " s ahead of this node's clock; the parameter window allows " + window +
           ". Synchronise the clocks, or let the vehicle file say clock: bag for that signal";
  }
  if (late_at_ == 0 || seconds(now - late_at_) > kLateShown) return "";
  return "a pose is not used: its stamp is " + plain(late_) +
         " s before the newest input's; the parameter window allows " + window +
         ". Raise window, or find what delays the poses or stamps the commands early";
}

std::string Node::reload() { return change_to(settings_.model); }

std::string Node::adopt() {
  const std::int64_t found = written(settings_.adapted_model);
  if (found == 0 || found == adapted_) return "";
  adapted_ = found;  // one that can't be used is tried once
  return change_to(settings_.adapted_model);
}

std::string Node::change_to(const std::string& path) {
  try {
    BoardModel board = load(path);
    apply_topics(board);
    expect_same_topics(board_, board);
    Signal command(board.inputs, board.model.command_timeout);
    Signal scale(board.scales);
    for (Signal* signal : {&command, &scale}) {
      for (const auto& [topic, type] : types_) signal->set_type(topic, type);
    }
    odometer_->forget_inputs();
    odometer_->reload(board.model, board.pose.lever);
    board_ = std::move(board);
    command_ = std::move(command);
    scale_ = std::move(scale);
    path_ = path;
    // recent messages once more, as the new model reads them
    for (const auto& message : recent_) {
      std::visit([this](const auto& in) { take(in, false); }, message);
    }
    return "";
  } catch (const std::runtime_error& error) {
    return error.what();
  }
}

BoardModel Node::load(const std::string& path) const {
  BoardModel board = load_model(path);
  board.model.window = settings_.window;
  board.model.boat.frame =
      settings_.body_fixed_disturbance ? DisturbanceFrame::kBody : DisturbanceFrame::kEarth;
  board.model.boat.current[0] = settings_.current_x;
  board.model.boat.current[1] = settings_.current_y;
  return board;
}

void Node::apply_topics(BoardModel& board) const {
  if (!settings_.pose_topic.empty()) board.pose.topic = settings_.pose_topic;
  for (Channel& c : board.inputs) {
    const bool own = c.topic.empty() || c.topic == board.commands.topic;
    if (own && !settings_.command_topic.empty()) c.topic = settings_.command_topic;
  }
  expect_named(board, settings_.model);
}

}  // namespace seatrial::ros
