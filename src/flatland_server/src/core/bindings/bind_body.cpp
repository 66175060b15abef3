/// Body in Python: where it is and how it moves. Its fixtures are bound in bind_fixture.cpp, its
/// joints, drives, tweens and lidars likewise.

#include <cmath>
#include <tuple>

#include "bindings/bindings.hpp"

namespace flatland {
namespace {

std::optional<Vec2> ToPoint(const std::optional<Pair>& point) {
  if (!point) return std::nullopt;
  return ToVec2(*point);
}

const char* TypeName(b2BodyType type) {
  return type == b2_staticBody ? "static" : type == b2_kinematicBody ? "kinematic" : "dynamic";
}

using Row = py::array_t<double, py::array::c_style>;

template <class Values>
void Fill(Row& row, const char* name, const Values& values) {
  if (row.ndim() != 1 || row.shape(0) != 3) {
    throw std::invalid_argument(std::string("expected an array of 3 numbers: ") + name);
  }
  double* const out = row.mutable_data();  // throws std::domain_error if it is read-only
  std::tie(out[0], out[1], out[2]) = values;
}

void ReadMotion(const PyBody& self, Row pose, Row local_velocity) {
  Fill(pose, "pose", ToTuple(Wrapped(self.world->GetPose(self.handle))));
  Fill(local_velocity, "local_velocity", ToTuple(self.world->GetLocalVelocity(self.handle)));
}

void BindMotion(py::class_<PyBody>& body) {
  body.def_property(
          "pose", [](const PyBody& self) { return ToTuple(self.world->GetPose(self.handle)); },
          [](PyBody& self, const Triple& pose) { self.world->SetPose(self.handle, ToPose(pose)); })
      .def_property(
          "velocity",
          [](const PyBody& self) { return ToTuple(self.world->GetVelocity(self.handle)); },
          [](PyBody& self, const Triple& velocity) {
            self.world->SetVelocity(self.handle, ToTwist(velocity));
          })
      .def_property_readonly(
          "local_velocity",
          [](const PyBody& self) { return ToTuple(self.world->GetLocalVelocity(self.handle)); })
      .def("read_motion", &ReadMotion, py::arg("pose").noconvert(),
           py::arg("local_velocity").noconvert())
      .def(
          "velocity_at",
          [](const PyBody& self, const Pair& point) {
            return ToTuple(self.world->GetVelocityAt(self.handle, ToVec2(point)));
          },
          py::arg("point"))
      .def("halt", [](PyBody& self) { self.world->Halt(self.handle); })
      .def(
          "apply_force",
          [](PyBody& self, const Pair& force, const std::optional<Pair>& point) {
            self.world->ApplyForce(self.handle, ToVec2(force), ToPoint(point));
          },
          py::arg("force"), py::arg("point") = py::none())
      .def(
          "apply_torque",
          [](PyBody& self, double torque) { self.world->ApplyTorque(self.handle, torque); },
          py::arg("torque"))
      .def(
          "apply_linear_impulse",
          [](PyBody& self, const Pair& impulse, const std::optional<Pair>& point) {
            self.world->ApplyLinearImpulse(self.handle, ToVec2(impulse), ToPoint(point));
          },
          py::arg("impulse"), py::arg("point") = py::none())
      .def(
          "apply_angular_impulse",
          [](PyBody& self, double impulse) {
            self.world->ApplyAngularImpulse(self.handle, impulse);
          },
          py::arg("impulse"));
}

using Mapping = Vec2 (World::*)(World::Body, Vec2) const;

template <Mapping map>
Pair Map(const PyBody& self, const Pair& v) {
  return ToTuple((self.world.get()->*map)(self.handle, ToVec2(v)));
}

void BindProperties(py::class_<PyBody>& body) {
  body.def("world_point", &Map<&World::ToWorldPoint>, py::arg("point"))
      .def("local_point", &Map<&World::ToLocalPoint>, py::arg("point"))
      .def("world_vector", &Map<&World::ToWorldVector>, py::arg("vector"))
      .def("local_vector", &Map<&World::ToLocalVector>, py::arg("vector"))
      .def_property_readonly(
          "type", [](const PyBody& self) { return TypeName(self.world->GetType(self.handle)); })
      .def_property_readonly("mass",
                             [](const PyBody& self) { return self.world->GetMass(self.handle); })
      .def_property_readonly("inertia",
                             [](const PyBody& self) { return self.world->GetInertia(self.handle); })
      .def_property_readonly(
          "center", [](const PyBody& self) { return ToTuple(self.world->GetCenter(self.handle)); })
      .def_property_readonly(
          "local_center",
          [](const PyBody& self) { return ToTuple(self.world->GetLocalCenter(self.handle)); })
      .def(
          "set_mass",
          [](PyBody& self, double mass, std::optional<double> inertia,
             const std::optional<Pair>& local_center) {
            self.world->SetMass(self.handle, mass, inertia, ToPoint(local_center));
          },
          py::arg("mass"), py::kw_only(), py::arg("inertia") = py::none(),
          py::arg("local_center") = py::none())
      .def("reset_mass", [](PyBody& self) { self.world->ResetMass(self.handle); })
      .def_property_readonly("awake",
                             [](const PyBody& self) { return self.world->IsAwake(self.handle); });
}

}  // namespace

b2BodyType ToBodyType(const std::string& name) {
  if (name == "static") return b2_staticBody;
  if (name == "kinematic") return b2_kinematicBody;
  if (name == "dynamic") return b2_dynamicBody;
  throw std::invalid_argument("a body's type is static, kinematic or dynamic, not " + name);
}

void BindBody(py::class_<PyBody>& body) {
  body.def_property_readonly("id", [](const PyBody& self) { return IdOf(self.handle); })
      .def(
          "__eq__",
          [](const PyBody& self, const PyBody& other) {
            return self.world == other.world && IdOf(self.handle) == IdOf(other.handle);
          },
          py::is_operator())
      .def("__hash__", [](const PyBody& self) { return IdOf(self.handle); })
      .def_property_readonly("alive",
                             [](const PyBody& self) { return self.world->Contains(self.handle); })
      .def("remove",
           [](PyBody& self) {
             self.world->RemoveBody(self.handle);
             RethrowFromListener(*self.world);
           })
      .def(
          "listen_to_contacts",
          [](PyBody& self, ContactEvents events) {
            self.world->contacts().ListenTo(self.handle, events);
          },
          py::arg("events"));
  BindMotion(body);
  BindProperties(body);
  BindFixturesOf(body);
  BindJointsOf(body);
  BindDrivesOf(body);
  BindLidarsOf(body);
}

}  // namespace flatland
