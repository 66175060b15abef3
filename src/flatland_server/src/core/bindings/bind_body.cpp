/// Body in Python: where it is and how it moves. Its fixtures are bound in bind_fixture.cpp, its
/// joints, drives, tweens and lidars likewise.

#include <pybind11/operators.h>

#include <cmath>
#include <tuple>

#include "bindings/bindings.hpp"

namespace flatland {
namespace {

const char* TypeName(const PyBody& self) {
  const b2BodyType type = self.world->GetType(self.handle);
  return type == b2_staticBody ? "static" : type == b2_kinematicBody ? "kinematic" : "dynamic";
}

template <class Values>
void Fill(Array<double>& row, const char* name, const Values& values) {
  if (row.ndim() != 1 || row.shape(0) != 3) {
    throw std::invalid_argument(std::string("expected an array of 3 numbers: ") + name);
  }
  double* const out = row.mutable_data();  // throws std::domain_error if it is read-only
  std::tie(out[0], out[1], out[2]) = ToTuple(values);
}

void ReadMotion(const PyBody& self, Array<double> pose, Array<double> local_velocity) {
  Fill(pose, "pose", Wrapped(self.world->GetPose(self.handle)));
  Fill(local_velocity, "local_velocity", self.world->GetLocalVelocity(self.handle));
}

void BindMotion(py::class_<PyBody>& body) {
  body.def_property("pose", OfWorld<&World::GetPose>(), OfWorld<&World::SetPose>())
      .def_property("velocity", OfWorld<&World::GetVelocity>(), OfWorld<&World::SetVelocity>())
      .def_property_readonly("local_velocity", OfWorld<&World::GetLocalVelocity>())
      .def("read_motion", &ReadMotion, py::arg("pose").noconvert(),
           py::arg("local_velocity").noconvert())
      .def("velocity_at", OfWorld<&World::GetVelocityAt>(), py::arg("point"))
      .def("halt", OfWorld<&World::Halt>())
      .def("apply_force", OfWorld<&World::ApplyForce>(), py::arg("force"),
           py::arg("point") = py::none())
      .def("apply_torque", OfWorld<&World::ApplyTorque>(), py::arg("torque"))
      .def("apply_linear_impulse", OfWorld<&World::ApplyLinearImpulse>(), py::arg("impulse"),
           py::arg("point") = py::none())
      .def("apply_angular_impulse", OfWorld<&World::ApplyAngularImpulse>(), py::arg("impulse"));
}

void BindProperties(py::class_<PyBody>& body) {
  body.def("world_point", OfWorld<&World::ToWorldPoint>(), py::arg("point"))
      .def("local_point", OfWorld<&World::ToLocalPoint>(), py::arg("point"))
      .def("world_vector", OfWorld<&World::ToWorldVector>(), py::arg("vector"))
      .def("local_vector", OfWorld<&World::ToLocalVector>(), py::arg("vector"))
      .def_property_readonly("type", &TypeName)
      .def_property_readonly("mass", OfWorld<&World::GetMass>())
      .def_property_readonly("inertia", OfWorld<&World::GetInertia>())
      .def_property_readonly("center", OfWorld<&World::GetCenter>())
      .def_property_readonly("local_center", OfWorld<&World::GetLocalCenter>())
      .def("set_mass", OfWorld<&World::SetMass>(), py::arg("mass"), py::kw_only(),
           py::arg("inertia") = py::none(), py::arg("local_center") = py::none())
      .def("reset_mass", OfWorld<&World::ResetMass>())
      .def_property_readonly("awake", OfWorld<&World::IsAwake>());
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
      .def(py::self == py::self)
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
