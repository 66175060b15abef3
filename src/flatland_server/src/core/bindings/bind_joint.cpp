/// Joint in Python.

#include "bindings/bindings.hpp"

namespace flatland {
namespace {

/// Adds a joint by AddRevolute or AddWeld.
template <class Settings>
PyJoint AddJoint(const PyBody& a, const PyBody& b, const Settings& settings,
                 World::Joint (World::*add)(World::Body, World::Body, const Settings&)) {
  if (a.world != b.world)
    throw std::invalid_argument("the bodies of a joint must be of the same world");
  return {a.world, ((*a.world).*add)(a.handle, b.handle, settings)};
}

}  // namespace

void BindJoint(py::module_& m) {
  py::class_<PyJoint>(m, "Joint")
      .def_property_readonly("alive",
                             [](const PyJoint& self) { return self.world->Contains(self.handle); })
      .def_property_readonly("angle", OfWorld<&World::GetJointAngle>())
      .def_property_readonly("speed", OfWorld<&World::GetJointSpeed>())
      .def_property("limits", OfWorld<&World::GetLimits>(), OfWorld<&World::SetLimits>())
      .def_property("motor", OfWorld<&World::GetMotor>(), OfWorld<&World::SetMotor>())
      .def_property_readonly("motor_torque", OfWorld<&World::GetMotorTorque>());
}

void BindJointsOf(py::class_<PyBody>& body) {
  body.def(
          "add_revolute",
          [](PyBody& self, const PyBody& other, Vec2 anchor, Vec2 other_anchor,
             bool collide_connected, const std::optional<JointLimits>& limits) {
            const RevoluteSettings settings{{anchor, other_anchor, collide_connected}, limits};
            return AddJoint(self, other, settings, &World::AddRevolute);
          },
          py::arg("other"), py::arg("anchor"), py::arg("other_anchor"), py::kw_only(),
          py::arg("collide_connected") = false, py::arg("limits") = py::none())
      .def(
          "add_weld",
          [](PyBody& self, const PyBody& other, Vec2 anchor, Vec2 other_anchor,
             bool collide_connected, double angle, double frequency, double damping) {
            const WeldSettings settings{
                {anchor, other_anchor, collide_connected}, angle, frequency, damping};
            return AddJoint(self, other, settings, &World::AddWeld);
          },
          py::arg("other"), py::arg("anchor"), py::arg("other_anchor"), py::kw_only(),
          py::arg("collide_connected") = false, py::arg("angle") = 0.0, py::arg("frequency") = 0.0,
          py::arg("damping") = 0.0);
}

}  // namespace flatland
