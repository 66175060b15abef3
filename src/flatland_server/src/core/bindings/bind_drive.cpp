/// Drive, Tricycle, Ackermann, Tween and Drift in Python.

#include <optional>

#include "bindings/bindings.hpp"
#include "bindings/fast_method.hpp"

namespace pybind11::detail {

using namespace flatland;

template <>
struct type_caster<DynamicsLimits> : StructCaster<DynamicsLimits, double, double, double> {};
template <>
struct type_caster<AxisSettings> : StructCaster<AxisSettings, double, double, double, double> {};
template <>
struct type_caster<ForceLimits> : StructCaster<ForceLimits, double, double, double> {};
template <>
struct type_caster<ActuatorSettings>
    : StructCaster<ActuatorSettings, AxisSettings, AxisSettings, double, uint64_t, ForceLimits> {};
template <>
struct type_caster<SingleTrack>
    : StructCaster<SingleTrack, double, double, double, double, double, double, double> {};
template <>
struct type_caster<WheelBiases> : StructCaster<WheelBiases, double, double, double> {};

}  // namespace pybind11::detail

namespace flatland {
namespace {

void CommandDrive(PyDrive& self, double vx, double vy, double omega) {
  self.world->Get(self.handle).Command({vx, vy, omega});
}

void CommandTricycle(PyTricycle& self, double speed, double steer_angle) {
  self.world->Get(self.handle).Command(speed, steer_angle);
}

void CommandAckermann(PyAckermann& self, double speed, double steer_angle) {
  self.world->Get(self.handle).Command({speed, steer_angle});
}

}  // namespace

void BindDrive(py::module_& m) {
  py::class_<PyDrive> drive(m, "Drive");
  DefineFast<&CommandDrive>(drive, "command", "vx", "vy", "omega");
  drive.def_property_readonly("target", OfPart<&BodyDrive::target>())
      .def_property_readonly("velocity", OfPart<&BodyDrive::velocity>());
  py::class_<PyTricycle> tricycle(m, "Tricycle");
  DefineFast<&CommandTricycle>(tricycle, "command", "speed", "steer_angle");
  tricycle.def_property_readonly("speed", OfPart<&TricycleDrive::speed>())
      .def_property_readonly("steer_angle", OfPart<&TricycleDrive::steer_angle>());
  py::class_<PyAckermann> car(m, "Ackermann");
  DefineFast<&CommandAckermann>(car, "command", "speed", "steer_angle");
  car.def(
         "command_within",
         [](PyAckermann& self, double speed, double steer_angle, double steering_rate,
            double acceleration, double jerk) {
           self.world->Get(self.handle)
               .Command({speed, steer_angle, steering_rate, acceleration, jerk});
         },
         py::arg("speed"), py::arg("steer_angle"), py::arg("steering_rate"),
         py::arg("acceleration"), py::arg("jerk"))
      .def_property_readonly("speed", OfPart<&AckermannDrive::speed>())
      .def_property_readonly("steer_angle", OfPart<&AckermannDrive::steer_angle>())
      .def_property_readonly("slip_angle", OfPart<&AckermannDrive::slip_angle>());
  py::class_<PyTween>(m, "Tween")
      .def(
          "trigger",
          [](PyTween& self, bool forward) { self.world->Get(self.handle).Trigger(forward); },
          py::arg("forward"))
      .def_property_readonly("progress", OfPart<&BodyTween::progress>());
  py::class_<PyDrift>(m, "Drift")
      .def_property_readonly("pose", OfWorld<&World::GetEstimate>())
      .def_property_readonly("velocity", OfPart<&BodyDrift::MeasuredVelocity>());
  m.attr("EASINGS") = py::tuple(py::cast(kEasingNames));
  m.attr("TWEEN_MODES") = py::tuple(py::cast(kTweenModeNames));
}

void BindDrivesOf(py::class_<PyBody>& body) {
  body.def(
          "add_drive",
          [](PyBody& self, const DynamicsLimits& linear, const DynamicsLimits& angular,
             const std::optional<ActuatorSettings>& actuators) {
            return PyDrive{self.world,
                           self.world->AddDrive(self.handle, linear, angular, actuators)};
          },
          py::arg("linear_limits") = Triple{}, py::arg("angular_limits") = Triple{},
          py::arg("actuators") = py::none())
      .def(
          "add_tricycle",
          [](PyBody& self, const PyJoint& front_wheel, Vec2 rear_axle, double max_steer_angle,
             const DynamicsLimits& linear, const DynamicsLimits& steering,
             const std::optional<ActuatorSettings>& actuators) {
            return PyTricycle{self.world, self.world->AddTricycle(self.handle, front_wheel.handle,
                                                                  {rear_axle, max_steer_angle,
                                                                   linear, steering, actuators})};
          },
          py::arg("front_wheel"), py::arg("rear_axle"), py::arg("max_steer_angle") = 0.0,
          py::arg("linear_limits") = Triple{}, py::arg("steering_limits") = Triple{},
          py::arg("actuators") = py::none())
      .def(
          "add_ackermann",
          [](PyBody& self, double wheelbase, double max_steer_angle,
             const std::vector<PyJoint>& wheels, const DynamicsLimits& linear, double jerk,
             const DynamicsLimits& steering, const std::optional<SingleTrack>& single_track,
             const std::optional<ActuatorSettings>& actuators) {
            std::vector<World::Joint> joints;
            for (const PyJoint& each : wheels) joints.push_back(each.handle);
            return PyAckermann{self.world,
                               self.world->AddAckermann(self.handle, joints,
                                                        {wheelbase, max_steer_angle, linear, jerk,
                                                         steering, single_track, actuators})};
          },
          py::arg("wheelbase"), py::arg("max_steer_angle"), py::kw_only(),
          py::arg("wheels") = std::vector<PyJoint>(), py::arg("linear_limits") = Triple{},
          py::arg("jerk_limit") = 0.0, py::arg("steering_limits") = Triple{},
          py::arg("single_track") = py::none(), py::arg("actuators") = py::none())
      .def(
          "add_tween",
          [](PyBody& self, const Pose& delta, double duration, const std::string& mode,
             const std::string& easing) {
            const auto found_mode = FindTweenMode(mode);
            const auto found_easing = FindEasing(easing);
            if (!found_mode) throw std::invalid_argument("there is no tween mode " + mode);
            if (!found_easing) throw std::invalid_argument("there is no easing " + easing);
            return PyTween{
                self.world,
                self.world->AddTween(self.handle, {delta, duration, *found_mode, *found_easing})};
          },
          py::arg("delta"), py::arg("duration"), py::arg("mode") = "yoyo",
          py::arg("easing") = "linear")
      .def(
          "add_drift",
          [](PyBody& self, uint64_t key, Vec2 translation, Vec2 rotation, const Pose& per_second,
             const WheelBiases& biases, double period) {
            return PyDrift{self.world,
                           self.world->AddDrift(self.handle,
                                                {translation.x, translation.y, rotation.x,
                                                 rotation.y, per_second, biases},
                                                period, key)};
          },
          py::arg("key"), py::arg("translation") = Vec2{}, py::arg("rotation") = Vec2{},
          py::arg("per_second") = Pose{}, py::arg("biases") = Triple{}, py::arg("period") = 0.0);
}

}  // namespace flatland
