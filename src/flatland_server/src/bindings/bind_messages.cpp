/// RelativePoses, and BodyMessage: the bytes of messages with poses and velocities of bodies.

#include <cmath>
#include <optional>
#include <tuple>
#include <utility>

#include "bindings.hpp"
#include "fast_method.hpp"
#include "flatland_server/message_bytes.hpp"

namespace flatland {
namespace {

/// Bodies of one world, and the body in the frame of which their poses are read, if any.
struct RelativePoses {
  RelativePoses(const std::optional<PyBody>& reference, const std::vector<PyBody>& bodies) {
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
  }

  Pose PoseOf(World::Body body) const {
    if (reference) return world->GetPoseIn(*reference, body);
    const Pose pose = world->GetPose(body);
    return {pose.x, pose.y, std::remainder(pose.yaw, 2.0 * M_PI)};
  }

  std::vector<Triple> Read() const {
    std::vector<Triple> poses;
    for (const World::Body& body : bodies) poses.push_back(ToTuple(PoseOf(body)));
    return poses;
  }

  std::shared_ptr<World> world;  // null without bodies
  std::optional<World::Body> reference;
  std::vector<World::Body> bodies;
};

/// Offsets of the fields of a body in a message; without a value, the message has no such field.
struct Fields {
  std::size_t header = 0;
  std::optional<std::size_t> pose;
  std::optional<std::size_t> twist;
};

class BodyMessage {
 public:
  using Offsets = std::tuple<std::size_t, std::optional<std::size_t>, std::optional<std::size_t>>;

  BodyMessage(const std::string& data, RelativePoses poses, const std::vector<Offsets>& fields,
              bool twist_in_local_frame)
      : bytes_(data), poses_(std::move(poses)), twist_in_local_frame_(twist_in_local_frame) {
    if (fields.size() != poses_.bodies.size()) {
      throw std::invalid_argument("expected the offsets of " +
                                  std::to_string(poses_.bodies.size()) + " bodies, found " +
                                  std::to_string(fields.size()));
    }
    for (const auto& [header, pose, twist] : fields) {
      bytes_.SetHeader(header, 0, 0);
      if (pose) bytes_.SetPose(*pose, {});
      if (twist) bytes_.SetTwist(*twist, {});
      fields_.push_back({header, pose, twist});
    }
  }

  static py::bytes Data(BodyMessage& self, int64_t sequence, int64_t nanoseconds) {
    for (std::size_t i = 0; i < self.fields_.size(); ++i) {
      self.Fill(self.fields_[i], self.poses_.bodies[i], static_cast<uint32_t>(sequence),
                nanoseconds);
    }
    return py::bytes(self.bytes_.data());
  }

 private:
  void Fill(const Fields& fields, World::Body body, uint32_t sequence, int64_t nanoseconds) {
    const Pose pose = poses_.PoseOf(body);
    bytes_.SetHeader(fields.header, sequence, nanoseconds);
    if (fields.pose) bytes_.SetPose(*fields.pose, pose);
    if (!fields.twist) return;
    const Twist twist = poses_.world->GetLocalVelocity(body);
    if (twist_in_local_frame_) {
      bytes_.SetTwist(*fields.twist, twist);
    } else {
      bytes_.SetTurnedTwist(*fields.twist, twist, pose.yaw);
    }
  }

  MessageBytes bytes_;
  RelativePoses poses_;
  std::vector<Fields> fields_;
  bool twist_in_local_frame_;
};

}  // namespace

void BindMessages(py::module_& m) {
  py::class_<RelativePoses>(m, "RelativePoses")
      .def(py::init<const std::optional<PyBody>&, const std::vector<PyBody>&>(),
           py::arg("reference").none(true), py::arg("bodies"))
      .def("__iter__", [](const RelativePoses& self) { return py::iter(py::cast(self.Read())); })
      .def("read", &RelativePoses::Read);
  py::class_<BodyMessage> message(m, "BodyMessage");
  message.def(
      py::init<const py::bytes&, RelativePoses, const std::vector<BodyMessage::Offsets>&, bool>(),
      py::arg("data"), py::arg("poses"), py::arg("fields"), py::arg("twist_in_local_frame") = true);
  DefineFast<&BodyMessage::Data>(message, "data", "sequence", "nanoseconds");
}

}  // namespace flatland
