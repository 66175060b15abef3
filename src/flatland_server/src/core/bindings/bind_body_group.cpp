/// BodyGroup: the poses of many bodies in one call.

#include <algorithm>
#include <cmath>
#include <utility>

#include "bindings/bindings.hpp"

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
Array<double> Rows(const BodyGroup& group, Read read) {
  Array<double> rows({static_cast<py::ssize_t>(group.bodies.size()), py::ssize_t{3}});
  double* out = rows.mutable_data();
  for (const World::Body& body : group.bodies) {
    std::tie(out[0], out[1], out[2]) = ToTuple(read(*group.world, body));
    out += 3;
  }
  return rows;
}

/// Selects the collisions that one of the bodies takes part in.
py::list Select(const BodyGroup& group, const std::vector<Collision>& collisions, double dt) {
  const auto is_own = [&](Fixture fixture) {
    return std::find(group.bodies.begin(), group.bodies.end(), fixture.body) != group.bodies.end();
  };
  py::list selected;
  for (const Collision& each : collisions) {
    if (!is_own(each.a) && !is_own(each.b)) continue;
    std::vector<double> forces(each.points.size());
    for (std::size_t i = 0; i < each.impulses.size(); ++i) forces[i] = each.impulses[i] / dt;
    selected.append(py::make_tuple(each.number, PyFixture{group.world, each.a},
                                   PyFixture{group.world, each.b}, each.has_sensor, each.points,
                                   each.normal, forces));
  }
  return selected;
}

void RestoreCollision(BodyGroup& group, uint64_t number, const PyFixture& a, const PyFixture& b,
                      bool has_sensor, const std::vector<Vec2>& points, Vec2 normal) {
  group.world->contacts().collisions().Restore(
      {number, a.handle, b.handle, has_sensor, points, normal, {}});
}

}  // namespace

void BindBodyGroup(py::module_& m) {
  py::class_<BodyGroup>(m, "BodyGroup")
      .def(py::init(&MakeGroup), py::arg("bodies"))
      .def("__len__", [](const BodyGroup& self) { return self.bodies.size(); })
      .def("poses",
           [](const BodyGroup& self) {
             return Rows(self, [](const World& world, World::Body body) {
               return Wrapped(world.GetPose(body));
             });
           })
      .def("velocities",
           [](const BodyGroup& self) {
             return Rows(self, [](const World& world, World::Body body) {
               return world.GetVelocity(body);
             });
           })
      .def(
          "clearance",
          [](const BodyGroup& self, double limit) {
            return self.world ? self.world->GetClearance(self.bodies, limit) : limit;
          },
          py::arg("limit"))
      .def("record_collisions",
           [](const BodyGroup& self) {
             for (const World::Body& body : self.bodies) self.world->contacts().Record(body);
           })
      .def("last_collisions",
           [](const BodyGroup& self) {
             if (!self.world) return py::list();
             const Collisions& collisions = self.world->contacts().collisions();
             return Select(self, collisions.last(), collisions.last_step());
           })
      .def("present_collisions",
           [](const BodyGroup& self) {
             if (!self.world) return py::list();
             const Collisions& collisions = self.world->contacts().collisions();
             return Select(self, collisions.present(), collisions.last_step());
           })
      .def("restore_collision", &RestoreCollision, py::arg("number"), py::arg("fixture_a"),
           py::arg("fixture_b"), py::arg("has_sensor"), py::arg("points"), py::arg("normal"));
}

}  // namespace flatland
