/// Drive, Tricycle, Tween and Drift in Python.

#include <array>
#include <optional>

#include "bindings/bindings.hpp"
#include "bindings/fast_method.hpp"

namespace flatland {
namespace {

DynamicsLimits ToLimits(const Triple& t) {
  return {std::get<0>(t), std::get<1>(t), std::get<2>(t)};
}

/// Each axis as (delay, time_constant, dead_band, noise); command_timeout; the key of the noise;
/// and (max_force, max_torque, friction).
using Axis = std::array<double, 4>;
using Actuators = std::tuple<Axis, Axis, double, uint64_t, Triple>;

AxisSettings ToAxis(const Axis& axis) { return {axis[0], axis[1], axis[2], axis[3]}; }

std::optional<ActuatorSettings> ToActuator(const std::optional<Actuators>& given) {
  if (!given) return std::nullopt;
  const auto& [linear, angular, timeout, key, force] = *given;
  const auto [max_force, max_torque, friction] = force;
  return ActuatorSettings{
      ToAxis(linear), ToAxis(angular), timeout, key, {max_force, max_torque, friction}};
}

void CommandDrive(PyDrive& self, double vx, double vy, double omega) {
  self.world->Get(self.handle).Command({vx, vy, omega});
}

void CommandTricycle(PyTricycle& self, double speed, double steer_angle) {
  self.world->Get(self.handle).Command(speed, steer_angle);
}

}  // namespace

void BindDrive(py::module_& m) {
  py::class_<PyDrive> drive(m, "Drive");
  DefineFast<&CommandDrive>(drive, "command", "vx", "vy", "omega");
  drive
      .def_property_readonly(
          "target",
          [](const PyDrive& self) { return ToTuple(self.world->Get(self.handle).target()); })
      .def_property_readonly("velocity", [](const PyDrive& self) {
        return ToTuple(self.world->Get(self.handle).velocity());
      });
  py::class_<PyTricycle> tricycle(m, "Tricycle");
  DefineFast<&CommandTricycle>(tricycle, "command", "speed", "steer_angle");
  tricycle
      .def_property_readonly(
          "speed", [](const PyTricycle& self) { return self.world->Get(self.handle).speed(); })
      .def_property_readonly("steer_angle", [](const PyTricycle& self) {
        return self.world->Get(self.handle).steer_angle();
      });
  py::class_<PyTween>(m, "Tween")
      .def(
          "trigger",
          [](PyTween& self, bool forward) { self.world->Get(self.handle).Trigger(forward); },
          py::arg("forward"))
      .def_property_readonly(
          "progress", [](const PyTween& self) { return self.world->Get(self.handle).progress(); });
  py::class_<PyDrift>(m, "Drift")
      .def_property_readonly(
          "pose", [](const PyDrift& self) { return ToTuple(self.world->GetEstimate(self.handle)); })
      .def_property_readonly("velocity", [](const PyDrift& self) {
        return ToTuple(self.world->Get(self.handle).MeasuredVelocity());
      });
  m.attr("EASINGS") = py::tuple(py::cast(kEasingNames));
  m.attr("TWEEN_MODES") = py::tuple(py::cast(kTweenModeNames));
}

void BindDrivesOf(py::class_<PyBody>& body) {
  body.def(
          "add_drive",
          [](PyBody& self, const Triple& linear, const Triple& angular,
             const std::optional<Actuators>& actuators) {
            return PyDrive{self.world,
                           self.world->AddDrive(self.handle, ToLimits(linear), ToLimits(angular),
                                                ToActuator(actuators))};
          },
          py::arg("linear_limits") = Triple{0.0, 0.0, 0.0},
          py::arg("angular_limits") = Triple{0.0, 0.0, 0.0}, py::arg("actuators") = py::none())
      .def(
          "add_tricycle",
          [](PyBody& self, const PyJoint& front_wheel, const Pair& rear_axle,
             double max_steer_angle, const Triple& linear, const Triple& steering,
             const std::optional<Actuators>& actuators) {
            const TricycleSettings settings{ToVec2(rear_axle), max_steer_angle, ToLimits(linear),
                                            ToLimits(steering), ToActuator(actuators)};
            return PyTricycle{self.world,
                              self.world->AddTricycle(self.handle, front_wheel.handle, settings)};
          },
          py::arg("front_wheel"), py::arg("rear_axle"), py::arg("max_steer_angle") = 0.0,
          py::arg("linear_limits") = Triple{0.0, 0.0, 0.0},
          py::arg("steering_limits") = Triple{0.0, 0.0, 0.0}, py::arg("actuators") = py::none())
      .def(
          "add_tween",
          [](PyBody& self, const Triple& delta, double duration, const std::string& mode,
             const std::string& easing) {
            const auto found_mode = FindTweenMode(mode);
            const auto found_easing = FindEasing(easing);
            if (!found_mode) throw std::invalid_argument("there is no tween mode " + mode);
            if (!found_easing) throw std::invalid_argument("there is no easing " + easing);
            return PyTween{self.world,
                           self.world->AddTween(
                               self.handle, {ToPose(delta), duration, *found_mode, *found_easing})};
          },
          py::arg("delta"), py::arg("duration"), py::arg("mode") = "yoyo",
          py::arg("easing") = "linear")
      .def(
          "add_drift",
          [](PyBody& self, uint64_t key, const Pair& translation, const Pair& rotation,
             const Triple& per_second, const Triple& biases, double period) {
            const auto [radius, track_width, curvature] = biases;
            const DriftVariances variances{translation.first,  translation.second,
                                           rotation.first,     rotation.second,
                                           ToPose(per_second), {radius, track_width, curvature}};
            return PyDrift{self.world, self.world->AddDrift(self.handle, variances, period, key)};
          },
          py::arg("key"), py::arg("translation") = Pair{0.0, 0.0},
          py::arg("rotation") = Pair{0.0, 0.0}, py::arg("per_second") = Triple{0.0, 0.0, 0.0},
          py::arg("biases") = Triple{0.0, 0.0, 0.0}, py::arg("period") = 0.0);
}

}  // namespace flatland
