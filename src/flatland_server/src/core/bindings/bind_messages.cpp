/// RelativePoses, and BodyMessage: the bytes of messages with poses and velocities of bodies.
/// StepMessages writes those of a step, to the queues of subscribers and into the list of
/// transforms.

#include <cmath>
#include <cstring>
#include <optional>
#include <string_view>
#include <tuple>
#include <utility>

#include "bindings/bindings.hpp"
#include "bindings/fast_method.hpp"
#include "sending/message_bytes.hpp"
#include "sending/subscriber_queue.hpp"

namespace flatland {
namespace {

/// Bodies of one world. Their poses are read in the frame of `reference`, if there is one, or else
/// in the world. With a drift, there is one body, and its measured motion is read.
struct RelativePoses {
  RelativePoses(const std::optional<PyBody>& reference, const std::vector<PyBody>& bodies,
                const std::optional<PyDrift>& drift) {
    if (reference) {
      world = reference->world;
      this->reference = reference->handle;
    } else if (!bodies.empty()) {
      world = bodies.front().world;
    }
    for (const PyBody& body : bodies) {
      if (body.world != world) throw std::invalid_argument("the bodies must be of the same world");
      this->bodies.push_back(body.handle);
    }
    if (!drift) return;
    if (reference || bodies.size() != 1 || drift->world != world) {
      throw std::invalid_argument("a drift is of one body, in the world");
    }
    this->drift = drift->handle;
  }

  Pose PoseOf(World::Body body) const {
    if (drift) return world->GetEstimate(*drift);
    if (reference) return world->GetPoseIn(*reference, body);
    return Wrapped(world->GetPose(body));
  }

  Twist VelocityOf(World::Body body) const {
    return drift ? world->Get(*drift).MeasuredVelocity() : world->GetLocalVelocity(body);
  }

  std::vector<Pose> Read() const {
    std::vector<Pose> poses;
    for (const World::Body& body : bodies) poses.push_back(PoseOf(body));
    return poses;
  }

  std::shared_ptr<World> world;  // null without bodies
  std::optional<World::Body> reference;
  std::vector<World::Body> bodies;
  std::optional<World::Drift> drift;
};

/// Offsets of header, pose and twist of a body in a message; without a value, the message has no
/// such field.
using Fields = std::tuple<std::size_t, std::optional<std::size_t>, std::optional<std::size_t>>;

class BodyMessage {
 public:
  BodyMessage(const std::string& data, RelativePoses poses, const std::vector<Fields>& fields,
              bool twist_in_local_frame, bool is_numbered)
      : bytes_(data),
        poses_(std::move(poses)),
        fields_(fields),
        twist_in_local_frame_(twist_in_local_frame),
        is_numbered_(is_numbered) {
    if (fields.size() != poses_.bodies.size()) {
      throw std::invalid_argument("expected the offsets of " +
                                  std::to_string(poses_.bodies.size()) + " bodies, found " +
                                  std::to_string(fields.size()));
    }
    for (const auto& [header, pose, twist] : fields) {
      bytes_.SetHeader(header, 0, 0);
      if (pose) bytes_.SetPose(*pose, {});
      if (twist) bytes_.SetTwist(*twist, {});
    }
  }

  /// The message of a time. The next call overwrites it.
  std::string_view Write(int64_t nanoseconds) {
    if (is_numbered_) ++sequence_;
    for (std::size_t i = 0; i < fields_.size(); ++i) {
      Fill(fields_[i], poses_.bodies[i], nanoseconds);
    }
    return bytes_.data();
  }

  static py::bytes Data(BodyMessage& self, int64_t nanoseconds) {
    const std::string_view data = self.Write(nanoseconds);
    return py::bytes(data.data(), data.size());
  }

  int64_t bodies() const { return static_cast<int64_t>(fields_.size()); }

 private:
  void Fill(const Fields& fields, World::Body body, int64_t nanoseconds) {
    const auto& [header, pose_at, twist_at] = fields;
    const Pose pose = poses_.PoseOf(body);
    bytes_.SetHeader(header, sequence_, nanoseconds);
    if (pose_at) bytes_.SetPose(*pose_at, pose);
    if (!twist_at) return;
    const Twist twist = poses_.VelocityOf(body);
    if (twist_in_local_frame_) {
      bytes_.SetTwist(*twist_at, twist);
    } else {
      bytes_.SetTurnedTwist(*twist_at, twist, pose.yaw);
    }
  }

  MessageBytes bytes_;
  RelativePoses poses_;
  std::vector<Fields> fields_;
  bool twist_in_local_frame_;
  bool is_numbered_;
  uint32_t sequence_ = 0;
};

/// The serialized transforms of a step.
class TransformList {
 public:
  void Add(int64_t count, std::string_view bytes) {
    count_ += static_cast<uint32_t>(count);
    bytes_.append(bytes);
  }

  /// Returns the message with all transforms, and clears it; empty if there are none.
  static py::bytes Take(TransformList& self) {
    if (self.count_ == 0) return {};
    std::memcpy(self.bytes_.data(), &self.count_, sizeof(self.count_));
    py::bytes message(self.bytes_);
    self.bytes_.resize(sizeof(self.count_));
    self.count_ = 0;
    return message;
  }

 private:
  uint32_t count_ = 0;
  std::string bytes_ = std::string(sizeof(count_), '\0');
};

/// A message with its length before it, as it is sent.
std::string Framed(std::string_view message) {
  const auto size = static_cast<uint32_t>(message.size());
  std::string framed;
  framed.reserve(sizeof(size) + message.size());
  framed.append(reinterpret_cast<const char*>(&size), sizeof(size));
  return framed.append(message);
}

/// A message of every step, and where it goes: to subscribers, or into the list of transforms.
struct StepMessage {
  std::shared_ptr<BodyMessage> message;
  std::shared_ptr<Outbox> outbox;
  std::vector<std::shared_ptr<SubscriberQueue>> queues;
  std::shared_ptr<TransformList> transforms;

  void Write(int64_t nanoseconds) const {
    const std::string_view data = message->Write(nanoseconds);
    if (transforms) transforms->Add(message->bodies(), data);
    for (const auto& queue : queues) outbox->Add(queue, Framed(data));
  }
};

class StepMessages {
 public:
  void Add(int64_t order, const StepMessage& message) { messages_.emplace_back(order, message); }

  /// Begins a step.
  static void Begin(StepMessages& self, int64_t nanoseconds) {
    self.nanoseconds_ = nanoseconds;
    self.next_ = 0;
  }

  /// Writes the messages that come before a place in the order.
  static void WriteUntil(StepMessages& self, int64_t order) {
    for (; self.next_ < self.messages_.size(); ++self.next_) {
      const auto& [place, message] = self.messages_[self.next_];
      if (place >= order) return;
      message.Write(self.nanoseconds_);
    }
  }

  static void Write(StepMessages& self, int64_t nanoseconds) {
    for (const auto& [_, message] : self.messages_) message.Write(nanoseconds);
  }

 private:
  std::vector<std::pair<int64_t, StepMessage>> messages_;  // by their order
  int64_t nanoseconds_ = 0;
  std::size_t next_ = 0;
};

bool IsEmpty(Outbox& outbox) { return outbox.is_empty(); }
bool IsDue(Outbox& outbox) { return outbox.IsDue(); }

void BindQueues(py::module_& m) {
  using Queue = SubscriberQueue;
  py::class_<Queue, std::shared_ptr<Queue>>(m, "SubscriberQueue")
      .def(py::init([](int socket, std::size_t limit, double patience) {
             return std::make_shared<Queue>(socket, limit, Queue::Seconds(patience));
           }),
           py::arg("socket"), py::arg("limit"), py::arg("patience"))
      .def(
          "send",
          [](Queue& self, std::string data) {
            self.Add(std::move(data));
            const ReleasedGil release;
            return self.Send();
          },
          py::arg("data"))
      .def("close", &Queue::Close)
      .def_property_readonly("error", [](const Queue& self) { return self.status().error; })
      .def_property_readonly("bytes_sent", [](const Queue& self) { return self.status().bytes; })
      .def_property_readonly("messages_sent",
                             [](const Queue& self) { return self.status().messages; });
  py::class_<Outbox, std::shared_ptr<Outbox>> outbox(m, "Outbox");
  outbox
      .def(py::init([](double period, std::size_t most) {
             return std::make_shared<Outbox>(Outbox::Seconds(period), most);
           }),
           py::arg("period"), py::arg("most"))
      .def("add", &Outbox::Add, py::arg("queue"), py::arg("data"))
      .def("send", &Outbox::Send, py::call_guard<ReleasedGil>());
  DefineFast<&IsEmpty>(outbox, "is_empty");  // asked in each step
  DefineFast<&IsDue>(outbox, "is_due");
}

}  // namespace

void BindMessages(py::module_& m) {
  m.def(
      "set_stamp_offset", [](int64_t nanoseconds) { stamp_offset = nanoseconds; },
      py::arg("nanoseconds"));
  py::class_<RelativePoses>(m, "RelativePoses")
      .def(py::init<const std::optional<PyBody>&, const std::vector<PyBody>&,
                    const std::optional<PyDrift>&>(),
           py::arg("reference").none(true), py::arg("bodies"), py::arg("drift") = py::none())
      .def("__iter__", [](const RelativePoses& self) { return py::iter(py::cast(self.Read())); })
      .def("read", &RelativePoses::Read);
  py::class_<BodyMessage, std::shared_ptr<BodyMessage>> message(m, "BodyMessage");
  message.def(py::init<const py::bytes&, RelativePoses, const std::vector<Fields>&, bool, bool>(),
              py::arg("data"), py::arg("poses"), py::arg("fields"),
              py::arg("twist_in_local_frame") = true, py::arg("is_numbered") = true);
  DefineFast<&BodyMessage::Data>(message, "data", "nanoseconds");
  BindQueues(m);
  py::class_<TransformList, std::shared_ptr<TransformList>> transforms(m, "TransformList");
  transforms.def(py::init<>()).def("add", &TransformList::Add, py::arg("count"), py::arg("data"));
  DefineFast<&TransformList::Take>(transforms, "take");
  py::class_<StepMessage>(m, "StepMessage")
      .def(py::init([](std::shared_ptr<BodyMessage> message, std::shared_ptr<Outbox> outbox,
                       std::vector<std::shared_ptr<SubscriberQueue>> queues) {
             return StepMessage{std::move(message), std::move(outbox), std::move(queues), nullptr};
           }),
           py::arg("message"), py::arg("outbox"), py::arg("queues"))
      .def(py::init(
               [](std::shared_ptr<BodyMessage> message, std::shared_ptr<TransformList> transforms) {
                 return StepMessage{std::move(message), nullptr, {}, std::move(transforms)};
               }),
           py::arg("message"), py::arg("transforms"));
  py::class_<StepMessages> messages(m, "StepMessages");
  messages.def(py::init<>()).def("add", &StepMessages::Add, py::arg("order"), py::arg("message"));
  DefineFast<&StepMessages::Begin>(messages, "begin", "nanoseconds");
  DefineFast<&StepMessages::WriteUntil>(messages, "write_until", "order");
  DefineFast<&StepMessages::Write>(messages, "write", "nanoseconds");
}

}  // namespace flatland
