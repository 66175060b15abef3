/// Fixture in Python: the shapes of a body.

#include "bindings/bindings.hpp"

namespace flatland {
namespace {

std::vector<Vec2> ToVertices(const std::vector<Pair>& vertices) {
  std::vector<Vec2> points;
  for (const Pair& vertex : vertices) points.push_back(ToVec2(vertex));
  return points;
}

PyFixture FixtureOf(const PyBody& self, uint32_t index) {
  const PyFixture fixture{self.world, {self.handle, index}};
  if (index >= static_cast<uint32_t>(self.world->GetFixtureCount(self.handle))) {
    throw py::index_error("the body has no such fixture");
  }
  return fixture;
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

}  // namespace

void BindFixturesOf(py::class_<PyBody>& body) {
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
      .def_property(
          "visible", [=](const PyFixture& self) { return settings(self).visible; },
          [](PyFixture& self, bool value) { self.world->SetVisible(self.handle, value); })
      .def_property_readonly("layers", [=](const PyFixture& self) { return settings(self).layers; })
      .def_property(
          "seen_radius",
          [](const PyFixture& self) { return self.world->GetSeenRadius(self.handle); },
          [](PyFixture& self, double value) { self.world->SetSeenRadius(self.handle, value); })
      .def(
          "test_point",
          [](const PyFixture& self, const Pair& point) {
            return self.world->TestPoint(self.handle, ToVec2(point));
          },
          py::arg("point"))
      .def(
          "set_circle",
          [](PyFixture& self, const Pair& center, double radius, std::optional<LayerBits> layers) {
            self.world->SetCircle(self.handle, ToVec2(center), radius, layers);
            RethrowFromListener(*self.world);
          },
          py::arg("center"), py::arg("radius"), py::kw_only(), py::arg("layers") = py::none())
      .def(
          "set_polygon",
          [](PyFixture& self, const std::vector<Pair>& vertices, std::optional<LayerBits> layers) {
            self.world->SetPolygon(self.handle, ToVertices(vertices), layers);
            RethrowFromListener(*self.world);
          },
          py::arg("vertices"), py::kw_only(), py::arg("layers") = py::none());
}

void BindFixtureChecker(py::module_& m) {
  py::class_<FixtureChecker> checker(m, "FixtureChecker");
  checker.def(py::init([](const std::string& type) { return FixtureChecker(ToBodyType(type)); }),
              py::arg("body_type"));
  DefineWithSettings(checker, "add_circle", &CheckCircle, py::arg("center"), py::arg("radius"));
  DefineWithSettings(checker, "add_polygon", &CheckPolygon, py::arg("vertices"));
}

}  // namespace flatland
