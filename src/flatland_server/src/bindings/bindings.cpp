/// flatland_server._core: the physical world for Python. The only C++ that knows Python.
///
/// A Python Body, Joint or Drive is a handle and the world it belongs to; using one whose object is
/// gone raises GoneError. Step and scan release the GIL.

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <memory>
#include <string>

#include "flatland_server/world.hpp"

namespace py = pybind11;

namespace flatland {
namespace {

using Pair = std::pair<double, double>;
using Triple = std::tuple<double, double, double>;
using Doubles = py::array_t<double, py::array::c_style | py::array::forcecast>;

Vec2 ToVec2(const Pair& pair) { return {pair.first, pair.second}; }
Pose ToPose(const Triple& t) { return {std::get<0>(t), std::get<1>(t), std::get<2>(t)}; }
Twist ToTwist(const Triple& t) { return {std::get<0>(t), std::get<1>(t), std::get<2>(t)}; }
Triple ToTuple(const Pose& pose) { return {pose.x, pose.y, pose.yaw}; }
Triple ToTuple(const Twist& twist) { return {twist.vx, twist.vy, twist.omega}; }

DynamicsLimits ToLimits(const Triple& t) {
  return {std::get<0>(t), std::get<1>(t), std::get<2>(t)};
}

b2BodyType ToBodyType(const std::string& name) {
  if (name == "static") return b2_staticBody;
  if (name == "kinematic") return b2_kinematicBody;
  if (name == "dynamic") return b2_dynamicBody;
  throw std::invalid_argument("a body's type is static, kinematic or dynamic, not " + name);
}

struct PyWorld {
  PyWorld(int velocity_iterations, int position_iterations)
      : world(std::make_shared<World>(velocity_iterations, position_iterations)) {}
  std::shared_ptr<World> world;
};

template <class Handle>
struct Owned {
  std::shared_ptr<World> world;
  Handle handle;
};
using PyBody = Owned<World::Body>;
using PyJoint = Owned<World::Joint>;
using PyDrive = Owned<World::Drive>;

std::vector<Segment> ToSegments(const Doubles& rows) {
  if (rows.ndim() != 2 || rows.shape(1) != 4) {
    throw std::invalid_argument("segments must be an array of shape (n, 4): x1, y1, x2, y2");
  }
  const auto values = rows.unchecked<2>();
  std::vector<Segment> segments(values.shape(0));
  for (py::ssize_t i = 0; i < values.shape(0); ++i) {
    segments[i] = {{values(i, 0), values(i, 1)}, {values(i, 2), values(i, 3)}};
  }
  return segments;
}

FixtureSettings ToFixture(double density, double friction, double restitution, bool sensor,
                          bool collides, LayerBits layers) {
  return {density, friction, restitution, sensor, collides, layers};
}

py::tuple Scan(const PyWorld& self, const BeamFan& fan, const Triple& pose, double range,
               LayerBits layers, LayerBits reflectance_layers) {
  py::array_t<float> ranges(fan.size());
  py::array_t<float> intensities(fan.size());
  float* ranges_out = ranges.mutable_data();
  float* intensities_out = intensities.mutable_data();
  {
    const py::gil_scoped_release release;
    self.world->Scan(fan, ToPose(pose), {range, layers, reflectance_layers}, ranges_out,
                     intensities_out);
  }
  return py::make_tuple(ranges, intensities);
}

void BindWorld(py::module_& m) {
  py::class_<PyWorld>(m, "World")
      .def(py::init<int, int>(), py::arg("velocity_iterations") = 10,
           py::arg("position_iterations") = 10)
      .def(
          "add_layer",
          [](PyWorld& self, const Doubles& segments, LayerBits layers) {
            self.world->AddLayer(ToSegments(segments), layers);
          },
          py::arg("segments"), py::arg("layers"))
      .def(
          "add_body",
          [](PyWorld& self, const std::string& type, const Triple& pose, double linear_damping,
             double angular_damping) {
            return PyBody{self.world, self.world->AddBody({ToBodyType(type), ToPose(pose),
                                                           linear_damping, angular_damping})};
          },
          py::arg("type"), py::arg("pose"), py::arg("linear_damping") = 0.0,
          py::arg("angular_damping") = 0.0)
      .def(
          "step", [](PyWorld& self, double dt) { self.world->Step(dt); }, py::arg("dt"),
          py::call_guard<py::gil_scoped_release>())
      .def("scan", &Scan, py::arg("fan"), py::arg("pose"), py::arg("range"),
           py::arg("layers") = 0xFFFF, py::arg("reflectance_layers") = 0)
      .def_property_readonly("body_count",
                             [](const PyWorld& self) { return self.world->body_count(); })
      .def_property_readonly("joint_count",
                             [](const PyWorld& self) { return self.world->joint_count(); });
}

void BindBody(py::module_& m) {
  py::class_<PyBody>(m, "Body")
      .def(
          "add_circle",
          [](PyBody& self, const Pair& center, double radius, double density, double friction,
             double restitution, bool sensor, bool collides, LayerBits layers) {
            self.world->AddCircle(
                self.handle, ToVec2(center), radius,
                ToFixture(density, friction, restitution, sensor, collides, layers));
          },
          py::arg("center"), py::arg("radius"), py::kw_only(), py::arg("density"),
          py::arg("friction") = 0.0, py::arg("restitution") = 0.0, py::arg("sensor") = false,
          py::arg("collides") = true, py::arg("layers") = 0xFFFF)
      .def(
          "add_polygon",
          [](PyBody& self, const std::vector<Pair>& vertices, double density, double friction,
             double restitution, bool sensor, bool collides, LayerBits layers) {
            std::vector<Vec2> points;
            for (const Pair& vertex : vertices) points.push_back(ToVec2(vertex));
            self.world->AddPolygon(
                self.handle, points,
                ToFixture(density, friction, restitution, sensor, collides, layers));
          },
          py::arg("vertices"), py::kw_only(), py::arg("density"), py::arg("friction") = 0.0,
          py::arg("restitution") = 0.0, py::arg("sensor") = false, py::arg("collides") = true,
          py::arg("layers") = 0xFFFF)
      .def(
          "add_revolute",
          [](PyBody& self, const PyBody& other, const Pair& anchor, const Pair& other_anchor,
             bool collide_connected, const std::optional<Pair>& limits) {
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
          py::arg("damping") = 0.0)
      .def(
          "add_drive",
          [](PyBody& self, const Triple& linear, const Triple& angular) {
            return PyDrive{self.world,
                           self.world->AddDrive(self.handle, ToLimits(linear), ToLimits(angular))};
          },
          py::arg("linear_limits") = Triple{0.0, 0.0, 0.0},
          py::arg("angular_limits") = Triple{0.0, 0.0, 0.0})
      .def("remove", [](PyBody& self) { self.world->RemoveBody(self.handle); })
      .def_property_readonly("alive",
                             [](const PyBody& self) { return self.world->Contains(self.handle); })
      .def_property(
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
      .def_property_readonly("mass",
                             [](const PyBody& self) { return self.world->GetMass(self.handle); })
      .def(
          "apply_force",
          [](PyBody& self, const Pair& force, double torque) {
            self.world->ApplyForce(self.handle, ToVec2(force), torque);
          },
          py::arg("force"), py::arg("torque") = 0.0)
      .def("halt", [](PyBody& self) { self.world->Halt(self.handle); });
}

}  // namespace

PYBIND11_MODULE(_core, m) {
  m.doc() = "Flatland's physics and ray casting on Box2D.";
  py::register_exception<GoneError>(m, "GoneError", PyExc_ReferenceError);

  py::class_<BeamFan>(m, "BeamFan")
      .def(py::init<double, double, int>(), py::arg("angle_min"), py::arg("increment"),
           py::arg("count"))
      .def("__len__", &BeamFan::size);
  BindWorld(m);
  BindBody(m);
  py::class_<PyJoint>(m, "Joint")
      .def_property_readonly("alive",
                             [](const PyJoint& self) { return self.world->Contains(self.handle); })
      .def_property_readonly(
          "angle", [](const PyJoint& self) { return self.world->JointAngle(self.handle); });
  py::class_<PyDrive>(m, "Drive")
      .def(
          "command",
          [](PyDrive& self, double vx, double vy, double omega) {
            self.world->GetDrive(self.handle).Command({vx, vy, omega});
          },
          py::arg("vx"), py::arg("vy"), py::arg("omega"))
      .def_property_readonly(
          "target",
          [](const PyDrive& self) { return ToTuple(self.world->GetDrive(self.handle).target()); })
      .def_property_readonly("velocity", [](const PyDrive& self) {
        return ToTuple(self.world->GetDrive(self.handle).velocity());
      });
}

}  // namespace flatland
