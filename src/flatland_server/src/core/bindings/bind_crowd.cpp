/// Crowd in Python.

#include "bindings/bindings.hpp"
#include "people/orca.hpp"

namespace pybind11::detail {

using namespace flatland;

template <>
struct type_caster<SocialForce>
    : StructCaster<SocialForce, double, double, double, double, double, double> {};
template <>
struct type_caster<OrcaSettings> : StructCaster<OrcaSettings, double, double, double, int> {};
template <>
struct type_caster<Area> : StructCaster<Area, Vec2, Vec2> {};

}  // namespace pybind11::detail

namespace flatland {
namespace {

using Attention = std::tuple<bool, double, double, double>;

PyCrowd AddCrowd(PyWorld& self, uint64_t key, LayerBits layers, double period, double goal_radius,
                 const SocialForce& forces, const std::optional<OrcaSettings>& orca, double begin) {
  return {self.world, self.world->AddCrowd(
                          {layers, period * 1e9, goal_radius, forces, orca, begin * 1e9}, key)};
}

std::shared_ptr<const Recording> ToRecording(const std::vector<Array<double>>& walks) {
  auto recording = std::make_shared<Recording>();
  for (const Array<double>& rows : walks) {
    if (rows.ndim() != 2 || rows.shape(1) != 3) {
      throw std::invalid_argument("expected walks of shape (n, 3)");
    }
    Recording::Walk walk;
    const double* row = rows.data();
    for (py::ssize_t i = 0; i < rows.shape(0); ++i, row += 3) {
      if (!(std::abs(row[0]) < 1e9)) throw std::invalid_argument("expected times below 1e9 s");
      walk.times.push_back(std::llround(row[0] * 1e9));
      walk.points.push_back({row[1], row[2]});
    }
    recording->walks.push_back(std::move(walk));
  }
  recording->Require();
  return recording;
}

void AddPerson(PyCrowd& self, const PyBody& body, const std::vector<Vec2>& goals, double radius,
               double speed, const std::vector<PyBody>& legs, const std::optional<PyBody>& circle,
               double leg_offset, double walk_ratio, Vec2 leg_radii, const Attention& attention,
               int group, const std::optional<Area>& area, bool stands,
               const std::vector<Array<double>>& recording) {
  PersonSettings person;
  person.body = body.handle;
  for (const PyBody& leg : legs) person.legs.push_back(leg.handle);
  if (circle) person.circle = circle->handle;
  person.goals = goals;
  person.radius = radius;
  person.speed = speed;
  person.leg_offset = leg_offset;
  person.walk_ratio = walk_ratio;
  person.leg_radius = leg_radii.x;
  person.swing_radius = leg_radii.y;
  std::tie(person.sees_robots, person.yields, person.reaction_time, person.field_of_view) =
      attention;
  person.group = group;
  person.area = area;
  person.stands = stands;
  if (!recording.empty()) person.recording = ToRecording(recording);
  self.world->AddPerson(self.handle, person);
}

std::vector<Triple> GetClearances(PyCrowd& self) {
  std::vector<Triple> rows;
  for (const Crowd::Clearances& each : self.world->GetClearances(self.handle)) {
    rows.emplace_back(each.wall, each.body, each.person);
  }
  return rows;
}

Vec2 ChooseOrcaVelocity(Vec2 velocity, Vec2 preferred, const Array<double>& neighbors,
                        const Array<double>& walls, double most, double horizon,
                        double wall_horizon, double dt) {
  if (neighbors.ndim() != 2 || neighbors.shape(1) != 6) {
    throw std::invalid_argument("expected neighbors of shape (n, 6)");
  }
  if (walls.ndim() != 2 || walls.shape(1) != 3) {
    throw std::invalid_argument("expected walls of shape (n, 3)");
  }
  OrcaSettings{horizon, wall_horizon, 1.0, 1}.Require();
  if (!(dt > 0.0 && most >= 0.0)) {
    throw std::invalid_argument("expected a time above zero and a speed of zero or more");
  }
  std::vector<HalfPlane> planes;
  const double* wall = walls.data();
  for (py::ssize_t i = 0; i < walls.shape(0); ++i, wall += 3) {
    planes.push_back(AvoidWall({wall[0], {wall[1], wall[2]}}, wall_horizon));
  }
  const double* each = neighbors.data();
  for (py::ssize_t i = 0; i < neighbors.shape(0); ++i, each += 6) {
    planes.push_back(AvoidNeighbor({{each[0], each[1]}, {each[2], each[3]}, each[4], each[5]},
                                   velocity, horizon, dt));
  }
  return ChooseVelocity(planes, static_cast<size_t>(walls.shape(0)), preferred, most);
}

}  // namespace

void BindCrowd(py::module_& m) {
  m.attr("AWAY") = kAway;
  py::class_<PyCrowd>(m, "Crowd")
      .def("add_person", &AddPerson, py::arg("body"), py::kw_only(), py::arg("goals"),
           py::arg("radius"), py::arg("speed"), py::arg("legs") = std::vector<PyBody>{},
           py::arg("circle") = py::none(), py::arg("leg_offset") = 0.0, py::arg("walk_ratio") = 0.0,
           py::arg("leg_radii") = Vec2{},
           py::arg("attention") = Attention{true, 1.0, 0.0, 2.0 * M_PI}, py::arg("group") = -1,
           py::arg("area") = py::none(), py::arg("stands") = false,
           py::arg("recording") = std::vector<Array<double>>{})
      .def(
          "follow",
          [](PyCrowd& self, size_t person, Vec2 point, Vec2 velocity) {
            self.world->Get(self.handle).Follow(person, point, velocity);
          },
          py::arg("person"), py::arg("point"), py::arg("velocity"))
      .def("remove", OfWorld<&World::RemoveCrowd>())
      .def("clearances", &GetClearances)
      .def("scatter", [](PyCrowd& self) { self.world->ScatterCrowd(self.handle); });
  m.def("orca_velocity", &ChooseOrcaVelocity, py::arg("velocity"), py::arg("preferred"),
        py::arg("neighbors").noconvert(), py::arg("walls").noconvert(), py::kw_only(),
        py::arg("most"), py::arg("horizon"), py::arg("wall_horizon"), py::arg("dt"));
}

void BindCrowdsOf(py::class_<PyWorld>& world) {
  world.def("add_crowd", &AddCrowd, py::arg("key"), py::kw_only(), py::arg("layers"),
            py::arg("period"), py::arg("goal_radius"), py::arg("forces"),
            py::arg("orca") = py::none(), py::arg("begin") = 0.0);
}

}  // namespace flatland
