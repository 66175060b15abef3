/// Crowd in Python.

#include "bindings.hpp"

namespace flatland {
namespace {

using Forces = std::tuple<double, double, double, double, double, double>;

PyCrowd AddCrowd(PyWorld& self, uint64_t key, LayerBits layers, double period, double goal_radius,
                 const Forces& forces) {
  SocialForce force;
  std::tie(force.relaxation_time, force.repulsion, force.range, force.evasion,
           force.side_preference, force.noise) = forces;
  const CrowdSettings settings{layers, period * 1e9, goal_radius, force};
  return {self.world, self.world->AddCrowd(settings, key)};
}

void AddPerson(PyCrowd& self, const PyBody& body, const std::vector<Pair>& goals, double radius,
               double speed, const std::vector<PyBody>& legs, const std::optional<PyBody>& circle,
               double leg_offset, double walk_ratio, const Pair& leg_radii) {
  PersonSettings person;
  person.body = body.handle;
  for (const PyBody& leg : legs) person.legs.push_back(leg.handle);
  if (circle) person.circle = circle->handle;
  for (const Pair& goal : goals) person.goals.push_back(ToVec2(goal));
  person.radius = radius;
  person.speed = speed;
  person.leg_offset = leg_offset;
  person.walk_ratio = walk_ratio;
  std::tie(person.leg_radius, person.swing_radius) = leg_radii;
  self.world->AddPerson(self.handle, person);
}

std::vector<Triple> GetRooms(PyCrowd& self) {
  std::vector<Triple> rooms;
  for (const Crowd::Room& room : self.world->GetRooms(self.handle)) {
    rooms.emplace_back(room.wall, room.body, room.person);
  }
  return rooms;
}

}  // namespace

void BindCrowd(py::module_& m) {
  py::class_<PyCrowd>(m, "Crowd")
      .def("add_person", &AddPerson, py::arg("body"), py::kw_only(), py::arg("goals"),
           py::arg("radius"), py::arg("speed"), py::arg("legs") = std::vector<PyBody>{},
           py::arg("circle") = py::none(), py::arg("leg_offset") = 0.0, py::arg("walk_ratio") = 0.0,
           py::arg("leg_radii") = Pair{0.0, 0.0})
      .def(
          "follow",
          [](PyCrowd& self, size_t person, const Pair& point, const Pair& velocity) {
            self.world->Get(self.handle).Follow(person, ToVec2(point), ToVec2(velocity));
          },
          py::arg("person"), py::arg("point"), py::arg("velocity"))
      .def("remove", [](PyCrowd& self) { self.world->RemoveCrowd(self.handle); })
      .def("rooms", &GetRooms);
}

void BindCrowdsOf(py::class_<PyWorld>& world) {
  world.def("add_crowd", &AddCrowd, py::arg("key"), py::kw_only(), py::arg("layers"),
            py::arg("period"), py::arg("goal_radius"), py::arg("forces"));
}

}  // namespace flatland
