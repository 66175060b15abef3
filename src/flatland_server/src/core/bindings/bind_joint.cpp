/// Joint in Python.

#include "bindings/bindings.hpp"

namespace flatland {
namespace {

/// The settings that joints of all types have.
template <typename Settings>
Settings MakeSettings(const PyBody& a, const PyBody& b, const Pair& anchor,
                      const Pair& other_anchor, bool collide_connected) {
  if (a.world != b.world)
    throw std::invalid_argument("the bodies of a joint must be of the same world");
  Settings settings;
  settings.anchor_a = ToVec2(anchor);
  settings.anchor_b = ToVec2(other_anchor);
  settings.collide_connected = collide_connected;
  return settings;
}

}  // namespace

void BindJoint(py::module_& m) {
  py::class_<PyJoint>(m, "Joint")
      .def_property_readonly("alive",
                             [](const PyJoint& self) { return self.world->Contains(self.handle); })
      .def_property_readonly(
          "angle", [](const PyJoint& self) { return self.world->GetJointAngle(self.handle); })
      .def_property_readonly(
          "speed", [](const PyJoint& self) { return self.world->GetJointSpeed(self.handle); })
      .def_property(
          "limits", [](const PyJoint& self) { return self.world->GetLimits(self.handle); },
          [](PyJoint& self, const std::optional<Pair>& limits) {
            self.world->SetLimits(self.handle, limits);
          })
      .def_property(
          "motor",
          [](const PyJoint& self) -> std::optional<Pair> {
            const std::optional<JointMotor> motor = self.world->GetMotor(self.handle);
            if (!motor) return std::nullopt;
            return Pair(motor->speed, motor->max_torque);
          },
          [](PyJoint& self, const std::optional<Pair>& motor) {
            std::optional<JointMotor> value;
            if (motor) value = {motor->first, motor->second};
            self.world->SetMotor(self.handle, value);
          })
      .def_property_readonly("motor_torque", [](const PyJoint& self) {
        return self.world->GetMotorTorque(self.handle);
      });
}

void BindJointsOf(py::class_<PyBody>& body) {
  body.def(
          "add_revolute",
          [](PyBody& self, const PyBody& other, const Pair& anchor, const Pair& other_anchor,
             bool collide_connected, const std::optional<Pair>& limits) {
            auto settings = MakeSettings<RevoluteSettings>(self, other, anchor, other_anchor,
                                                           collide_connected);
            settings.limits = limits;
            return PyJoint{self.world,
                           self.world->AddRevolute(self.handle, other.handle, settings)};
          },
          py::arg("other"), py::arg("anchor"), py::arg("other_anchor"), py::kw_only(),
          py::arg("collide_connected") = false, py::arg("limits") = py::none())
      .def(
          "add_weld",
          [](PyBody& self, const PyBody& other, const Pair& anchor, const Pair& other_anchor,
             bool collide_connected, double angle, double frequency, double damping) {
            auto settings =
                MakeSettings<WeldSettings>(self, other, anchor, other_anchor, collide_connected);
            settings.angle = angle;
            settings.frequency = frequency;
            settings.damping = damping;
            return PyJoint{self.world, self.world->AddWeld(self.handle, other.handle, settings)};
          },
          py::arg("other"), py::arg("anchor"), py::arg("other_anchor"), py::kw_only(),
          py::arg("collide_connected") = false, py::arg("angle") = 0.0, py::arg("frequency") = 0.0,
          py::arg("damping") = 0.0);
}

}  // namespace flatland
