/// Body and Fixture in Python.

#include "bindings.hpp"
#include "fast_method.hpp"

namespace flatland {
namespace {

void RequireOneWorld(const PyBody& a, const PyBody& b) {
  if (a.world != b.world)
    throw std::invalid_argument("the bodies of a joint must be of the same world");
}

std::optional<Vec2> ToPoint(const std::optional<Pair>& point) {
  if (!point) return std::nullopt;
  return ToVec2(*point);
}

DynamicsLimits ToLimits(const Triple& t) {
  return {std::get<0>(t), std::get<1>(t), std::get<2>(t)};
}

PyFixture FixtureOf(const PyBody& self, uint32_t index) {
  const PyFixture fixture{self.world, {self.handle, index}};
  if (index >= static_cast<uint32_t>(self.world->GetFixtureCount(self.handle))) {
    throw py::index_error("the body has no such fixture");
  }
  return fixture;
}

const char* TypeName(b2BodyType type) {
  return type == b2_staticBody ? "static" : type == b2_kinematicBody ? "kinematic" : "dynamic";
}

std::vector<PyFixture> FixturesOf(const PyBody& self) {
  std::vector<PyFixture> fixtures;
  const int count = self.world->GetFixtureCount(self.handle);
  for (int i = 0; i < count; ++i) {
    fixtures.push_back({self.world, {self.handle, static_cast<uint32_t>(i)}});
  }
  return fixtures;
}

PyFixture AddCircle(PyBody& self, const Pair& center, double radius, double density,
                    double friction, double restitution, bool sensor, bool collides, bool visible,
                    LayerBits layers) {
  const FixtureSettings settings{density, friction, restitution, sensor, collides, visible, layers};
  return {self.world, self.world->AddCircle(self.handle, ToVec2(center), radius, settings)};
}

PyFixture AddPolygon(PyBody& self, const std::vector<Pair>& vertices, double density,
                     double friction, double restitution, bool sensor, bool collides, bool visible,
                     LayerBits layers) {
  const FixtureSettings settings{density, friction, restitution, sensor, collides, visible, layers};
  return {self.world, self.world->AddPolygon(self.handle, ToVertices(vertices), settings)};
}

void CheckCircle(FixtureChecker& self, const Pair& center, double radius, double density,
                 double friction, double restitution, bool sensor, bool collides, bool visible,
                 LayerBits layers) {
  self.AddCircle(ToVec2(center), radius,
                 {density, friction, restitution, sensor, collides, visible, layers});
}

void CheckPolygon(FixtureChecker& self, const std::vector<Pair>& vertices, double density,
                  double friction, double restitution, bool sensor, bool collides, bool visible,
                  LayerBits layers) {
  self.AddPolygon(ToVertices(vertices),
                  {density, friction, restitution, sensor, collides, visible, layers});
}

/// Defines a method with the keyword arguments of FixtureSettings after the others.
template <class Class, class Function, class... Arguments>
void DefineWithSettings(Class& cls, const char* name, Function function,
                        const Arguments&... arguments) {
  cls.def(name, function, arguments..., py::kw_only(), py::arg("density"),
          py::arg("friction") = 0.0, py::arg("restitution") = 0.0, py::arg("sensor") = false,
          py::arg("collides") = true, py::arg("visible") = true, py::arg("layers") = kAllLayers);
}

void BindShapes(py::class_<PyBody>& body) {
  DefineWithSettings(body, "add_circle", &AddCircle, py::arg("center"), py::arg("radius"));
  DefineWithSettings(body, "add_polygon", &AddPolygon, py::arg("vertices"));
  body.def_property_readonly("fixtures", &FixturesOf);
  body.def("fixture", &FixtureOf, py::arg("index"));
  body.def_property_readonly("overlapping", [](const PyBody& self) {
    std::vector<PyBody> bodies;
    for (const World::Body& other : self.world->GetOverlappingBodies(self.handle)) {
      bodies.push_back({self.world, other});
    }
    return bodies;
  });
}

void BindJoints(py::class_<PyBody>& body) {
  body.def(
          "add_revolute",
          [](PyBody& self, const PyBody& other, const Pair& anchor, const Pair& other_anchor,
             bool collide_connected, const std::optional<Pair>& limits) {
            RequireOneWorld(self, other);
            RevoluteSettings settings;
            settings.anchor_a = ToVec2(anchor);
            settings.anchor_b = ToVec2(other_anchor);
            settings.collide_connected = collide_connected;
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
            RequireOneWorld(self, other);
            WeldSettings settings;
            settings.anchor_a = ToVec2(anchor);
            settings.anchor_b = ToVec2(other_anchor);
            settings.collide_connected = collide_connected;
            settings.angle = angle;
            settings.frequency = frequency;
            settings.damping = damping;
            return PyJoint{self.world, self.world->AddWeld(self.handle, other.handle, settings)};
          },
          py::arg("other"), py::arg("anchor"), py::arg("other_anchor"), py::kw_only(),
          py::arg("collide_connected") = false, py::arg("angle") = 0.0, py::arg("frequency") = 0.0,
          py::arg("damping") = 0.0);
}

void BindLidar(py::class_<PyBody>& body) {
  body.def(
      "add_lidar",
      [](PyBody& self, const std::shared_ptr<BeamFan>& fan, const Triple& pose, double range,
         LayerBits layers, LayerBits reflectance_layers) {
        const LidarSettings settings{fan, ToPose(pose), {range, layers, reflectance_layers}};
        return PyLidar{self.world, self.world->AddLidar(self.handle, settings)};
      },
      py::arg("fan"), py::arg("pose"), py::arg("range"), py::arg("layers") = kAllLayers,
      py::arg("reflectance_layers") = 0);
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

void BindMechanics(py::class_<PyBody>& body) {
  body.def(
          "add_drive",
          [](PyBody& self, const Triple& linear, const Triple& angular) {
            return PyDrive{self.world,
                           self.world->AddDrive(self.handle, ToLimits(linear), ToLimits(angular))};
          },
          py::arg("linear_limits") = Triple{0.0, 0.0, 0.0},
          py::arg("angular_limits") = Triple{0.0, 0.0, 0.0})
      .def(
          "add_tricycle",
          [](PyBody& self, const PyJoint& front_wheel, const Pair& rear_axle,
             double max_steer_angle, const Triple& linear, const Triple& steering) {
            const TricycleSettings settings{ToVec2(rear_axle), max_steer_angle, ToLimits(linear),
                                            ToLimits(steering)};
            return PyTricycle{self.world,
                              self.world->AddTricycle(self.handle, front_wheel.handle, settings)};
          },
          py::arg("front_wheel"), py::arg("rear_axle"), py::arg("max_steer_angle") = 0.0,
          py::arg("linear_limits") = Triple{0.0, 0.0, 0.0},
          py::arg("steering_limits") = Triple{0.0, 0.0, 0.0})
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
      .def("world_point", &Map<&World::ToWorldPoint>, py::arg("point"))
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
      .def_property_readonly("awake",
                             [](const PyBody& self) { return self.world->IsAwake(self.handle); });
}

void CommandDrive(PyDrive& self, double vx, double vy, double omega) {
  self.world->Get(self.handle).Command({vx, vy, omega});
}

void CommandTricycle(PyTricycle& self, double speed, double steer_angle) {
  self.world->Get(self.handle).Command(speed, steer_angle);
}

}  // namespace

b2BodyType ToBodyType(const std::string& name) {
  if (name == "static") return b2_staticBody;
  if (name == "kinematic") return b2_kinematicBody;
  if (name == "dynamic") return b2_dynamicBody;
  throw std::invalid_argument("a body's type is static, kinematic or dynamic, not " + name);
}

std::vector<Vec2> ToVertices(const std::vector<Pair>& vertices) {
  std::vector<Vec2> points;
  for (const Pair& vertex : vertices) points.push_back(ToVec2(vertex));
  return points;
}

RelativePoses::RelativePoses(const PyBody& reference, const std::vector<PyBody>& bodies)
    : world(reference.world), reference(reference.handle) {
  for (const PyBody& body : bodies) {
    if (body.world != world) throw std::invalid_argument("the bodies must be of the same world");
    this->bodies.push_back(body.handle);
  }
}

std::vector<Triple> RelativePoses::Read() const {
  std::vector<Triple> poses;
  for (const World::Body& body : bodies)
    poses.push_back(ToTuple(world->GetPoseIn(reference, body)));
  return poses;
}

void BindRelativePoses(py::module_& m) {
  py::class_<RelativePoses>(m, "RelativePoses")
      .def(py::init<const PyBody&, const std::vector<PyBody>&>(), py::arg("reference"),
           py::arg("bodies"))
      .def("read", &RelativePoses::Read);
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
            self.world->ListenToContacts(self.handle, events);
          },
          py::arg("events"));
  BindShapes(body);
  BindJoints(body);
  BindMotion(body);
  BindLidar(body);
  BindMechanics(body);
}

void BindFixture(py::class_<PyFixture>& fixture) {
  const auto settings = [](const PyFixture& self) { return self.world->GetSettings(self.handle); };
  fixture
      .def_property_readonly("body",
                             [](const PyFixture& self) {
                               return PyBody{self.world, self.handle.body};
                             })
      .def_property_readonly("index", [](const PyFixture& self) { return self.handle.index; })
      .def(
          "__eq__",
          [](const PyFixture& self, const PyFixture& other) {
            return self.world == other.world && self.handle.index == other.handle.index &&
                   IdOf(self.handle.body) == IdOf(other.handle.body);
          },
          py::is_operator())
      .def("__hash__",
           [](const PyFixture& self) {
             return py::hash(py::make_tuple(IdOf(self.handle.body), self.handle.index));
           })
      .def_property_readonly("density",
                             [=](const PyFixture& self) { return settings(self).density; })
      .def_property(
          "friction", [=](const PyFixture& self) { return settings(self).friction; },
          [](PyFixture& self, double value) { self.world->SetFriction(self.handle, value); })
      .def_property(
          "restitution", [=](const PyFixture& self) { return settings(self).restitution; },
          [](PyFixture& self, double value) { self.world->SetRestitution(self.handle, value); })
      .def_property_readonly("sensor", [=](const PyFixture& self) { return settings(self).sensor; })
      .def_property_readonly("collides",
                             [=](const PyFixture& self) { return settings(self).collides; })
      .def_property_readonly("visible",
                             [=](const PyFixture& self) { return settings(self).visible; })
      .def_property_readonly("layers", [=](const PyFixture& self) { return settings(self).layers; })
      .def(
          "test_point",
          [](const PyFixture& self, const Pair& point) {
            return self.world->TestPoint(self.handle, ToVec2(point));
          },
          py::arg("point"));
}

void BindFixtureChecker(py::module_& m) {
  py::class_<FixtureChecker> checker(m, "FixtureChecker");
  checker.def(py::init([](const std::string& type) { return FixtureChecker(ToBodyType(type)); }),
              py::arg("body_type"));
  DefineWithSettings(checker, "add_circle", &CheckCircle, py::arg("center"), py::arg("radius"));
  DefineWithSettings(checker, "add_polygon", &CheckPolygon, py::arg("vertices"));
}

void BindMechanisms(py::module_& m) {
  py::class_<PyJoint>(m, "Joint")
      .def_property_readonly("alive",
                             [](const PyJoint& self) { return self.world->Contains(self.handle); })
      .def_property_readonly(
          "angle", [](const PyJoint& self) { return self.world->GetJointAngle(self.handle); });
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
  m.attr("EASINGS") = py::tuple(py::cast(kEasingNames));
  m.attr("TWEEN_MODES") = py::tuple(py::cast(kTweenModeNames));
}

}  // namespace flatland
