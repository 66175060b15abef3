/// BodyGroup and RelativePoses: the poses of many bodies in one call.

#include <cmath>

#include "bindings.hpp"

namespace flatland {
namespace {

struct BodyGroup {
  std::shared_ptr<World> world;  // null without bodies
  std::vector<World::Body> bodies;
};

BodyGroup MakeGroup(const std::vector<PyBody>& bodies) {
  BodyGroup group;
  for (const PyBody& body : bodies) {
    if (group.world != nullptr && body.world != group.world) {
      throw std::invalid_argument("the bodies must be of the same world");
    }
    group.world = body.world;
    group.bodies.push_back(body.handle);
  }
  return group;
}

/// An array of shape (n, 3) with `read(body)` in each row.
template <class Read>
py::array_t<double> Rows(const BodyGroup& group, Read read) {
  const auto count = static_cast<py::ssize_t>(group.bodies.size());
  py::array_t<double> rows({count, py::ssize_t{3}});
  double* out = rows.mutable_data();
  for (const World::Body& body : group.bodies) {
    const Triple row = read(*group.world, body);
    *out++ = std::get<0>(row);
    *out++ = std::get<1>(row);
    *out++ = std::get<2>(row);
  }
  return rows;
}

/// Bodies of one world, and the body in the frame of which their poses are read.
struct RelativePoses {
  RelativePoses(const PyBody& reference, const std::vector<PyBody>& bodies)
      : world(reference.world), reference(reference.handle) {
    for (const PyBody& body : bodies) {
      if (body.world != world) throw std::invalid_argument("the bodies must be of the same world");
      this->bodies.push_back(body.handle);
    }
  }

  std::vector<Triple> Read() const {
    std::vector<Triple> poses;
    for (const World::Body& body : bodies) {
      poses.push_back(ToTuple(world->GetPoseIn(reference, body)));
    }
    return poses;
  }

  std::shared_ptr<World> world;
  World::Body reference;
  std::vector<World::Body> bodies;
};

}  // namespace

void BindBodyGroup(py::module_& m) {
  py::class_<BodyGroup>(m, "BodyGroup")
      .def(py::init(&MakeGroup), py::arg("bodies"))
      .def("__len__", [](const BodyGroup& self) { return self.bodies.size(); })
      .def("poses",
           [](const BodyGroup& self) {
             return Rows(self, [](const World& world, World::Body body) {
               const Pose pose = world.GetPose(body);
               return Triple{pose.x, pose.y, std::remainder(pose.yaw, 2.0 * M_PI)};
             });
           })
      .def("velocities",
           [](const BodyGroup& self) {
             return Rows(self, [](const World& world, World::Body body) {
               return ToTuple(world.GetVelocity(body));
             });
           })
      .def(
          "clearance",
          [](const BodyGroup& self, double limit) {
            return self.world ? self.world->GetClearance(self.bodies, limit) : limit;
          },
          py::arg("limit"));
  py::class_<RelativePoses>(m, "RelativePoses")
      .def(py::init<const PyBody&, const std::vector<PyBody>&>(), py::arg("reference"),
           py::arg("bodies"))
      .def("read", &RelativePoses::Read);
}

}  // namespace flatland
