/// flatland_server._core: the physical world for Python. The only C++ that knows Python.
///
/// A Python Body, Joint or Drive is a handle and the world it belongs to; after the removal of the
/// body its use raises GoneError. Steps and scans release the GIL; the contact listener acquires it
/// for each event.

#include "bindings/bindings.hpp"

#include "bindings/fast_method.hpp"
#include "world/box2d_timer.hpp"
#include "world/settings.hpp"

namespace flatland {
namespace {

void Step(PyWorld& self, double dt) {
  {
    const World::AccessGuard guard(*self.world);
    const ReleasedGil release;
    self.world->Step(dt, guard);
  }
  RethrowFromListener(*self.world);
}

int StepUntilContact(PyWorld& self, double dt, int count) {
  int completed = 0;
  {
    const World::AccessGuard guard(*self.world);
    const ReleasedGil release;
    completed = self.world->StepUntilContact(dt, count, guard);
  }
  RethrowFromListener(*self.world);
  return completed;
}

py::list Touches(const PyWorld& self) {
  py::list touches;
  for (const Touch& touch : self.world->contacts().GetTouches()) {
    touches.append(py::make_tuple(PyFixture{self.world, touch.a}, PyFixture{self.world, touch.b},
                                  touch.points, touch.normal));
  }
  return touches;
}

void SetContactListener(PyWorld& self, py::object callback) {
  ContactListener* listener = callback.is_none() ? nullptr : &self.owner->listener;
  self.world->contacts().SetListener(listener);
  self.owner->listener.SetCallback(self.world, std::move(callback));
}

void BindWorld(py::module_& m) {
  py::class_<PyWorld> world(m, "World");
  DefineFast<&Step>(world, "step", "dt");
  DefineFast<&StepUntilContact>(world, "step_until_contact", "dt", "count");
  world
      .def(py::init([](int velocity_iterations, int position_iterations) {
             return PyWorld(
                 std::make_shared<ListenedWorld>(velocity_iterations, position_iterations));
           }),
           py::arg("velocity_iterations") = 10, py::arg("position_iterations") = 10)
      .def(
          "add_layer",
          [](PyWorld& self, const Doubles& segments, LayerBits layers,
             const std::optional<py::function>& progress) {
            std::function<void(std::size_t)> report;
            if (progress) report = [&](std::size_t added) { (*progress)(added); };
            return PyBody{self.world, self.world->AddLayer(ToSegments(segments), layers, report)};
          },
          py::arg("segments"), py::arg("layers"), py::arg("progress") = py::none())
      .def(
          "add_body",
          [](PyWorld& self, const std::string& type, const Pose& pose, double linear_damping,
             double angular_damping) {
            return PyBody{self.world, self.world->AddBody({ToBodyType(type), pose, linear_damping,
                                                           angular_damping})};
          },
          py::arg("type"), py::arg("pose"), py::arg("linear_damping") = 0.0,
          py::arg("angular_damping") = 0.0)
      .def_property_readonly("completed_steps",
                             [](const PyWorld& self) { return self.world->completed_steps(); })
      .def("save_state", [](PyWorld& self) { return py::bytes(self.world->SaveState()); })
      .def(
          "restore_state",
          [](PyWorld& self, const py::bytes& state) {
            self.world->RestoreState(std::string_view(state));
          },
          py::arg("state"))
      .def_property_readonly(
          "settings",
          [](const PyWorld& self) {
            const std::vector<Setting> settings = SettingsOf(*self.world);
            py::array_t<double> values(static_cast<py::ssize_t>(settings.size()));
            double* value = values.mutable_data();
            for (const Setting& each : settings) *value++ = each.Get();
            return values;
          })
      .def("set_contact_listener", &SetContactListener, py::arg("listener"))
      .def_property_readonly("touches", &Touches)
      .def_property_readonly("body_count",
                             [](const PyWorld& self) { return self.world->body_count(); })
      .def_property_readonly("joint_count",
                             [](const PyWorld& self) { return self.world->joint_count(); })
      .def_property_readonly("grip_count",
                             [](const PyWorld& self) { return self.world->grip_count(); });
  BindScansOf(world);
  BindCrowdsOf(world);
}

}  // namespace

std::vector<Segment> ToSegments(const Doubles& rows) {
  if (rows.ndim() != 2 || rows.shape(1) != 4) {
    throw std::invalid_argument("segments must be an array of shape (n, 4): x1, y1, x2, y2");
  }
  static_assert(sizeof(Segment) == 4 * sizeof(double));
  std::vector<Segment> segments(rows.shape(0));
  if (!segments.empty())
    std::memcpy(static_cast<void*>(segments.data()), rows.data(), rows.nbytes());
  return segments;
}

#if PYBIND11_VERSION_MAJOR > 2 || PYBIND11_VERSION_MINOR >= 12
constexpr bool kSupportsNumPy2 = true;
#else
constexpr bool kSupportsNumPy2 = false;  // it would read the strides of arrays at a wrong place
#endif

void RequireNumPy() {
  const auto version = py::module_::import("numpy").attr("__version__").cast<std::string>();
  if (std::stoi(version) < 2 || kSupportsNumPy2) return;
  throw py::import_error("flatland_server was built with pybind11 " +
                         std::to_string(PYBIND11_VERSION_MAJOR) + "." +
                         std::to_string(PYBIND11_VERSION_MINOR) +
                         ", which supports NumPy before 2, found NumPy " + version);
}

PYBIND11_MODULE(_core, m) {
  RequireNumPy();
  m.attr("supports_numpy_2") = kSupportsNumPy2;
  m.attr("__version__") = FLATLAND_VERSION;
  py::register_exception<GoneError>(m, "GoneError", PyExc_ReferenceError);

  BindLidar(m);
  // Both are declared before any function that has them in its signature.
  py::class_<PyBody> body(m, "Body");
  py::class_<PyFixture> fixture(m, "Fixture");
  BindJoint(m);
  BindDrive(m);
  BindCrowd(m);
  BindBody(body);
  BindFixture(fixture);
  BindBodyGroup(m);
  BindMessages(m);
  BindContacts(m);
  BindWorld(m);
  BindWorldBatch(m);
  m.def("box2d_reads_clock", &Box2DReadsClock);
  BindPriorityGuard(m);
  BindRangeNoise(m);
  BindFloorSquares(m);
  BindGoalObserver(m);
  if (!SetDocs(m.ptr())) throw py::error_already_set();
}

}  // namespace flatland
