/// Fixture in Python: the shapes of a body.

#include <pybind11/operators.h>

#include "bindings/bindings.hpp"

namespace flatland {
namespace {

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

/// Defines a method that adds a fixture: the settings are keyword arguments after those of the
/// shape.
template <class... Shape, class Add, class... Names>
void DefineAdd(py::class_<PyBody>& body, const char* name, Add add, const Names&... names) {
  body.def(
      name,
      [add](PyBody& self, Shape... shape, double density, double friction, double restitution,
            bool sensor, bool collides, bool visible, LayerBits layers) {
        const FixtureSettings settings{density,  friction, restitution, sensor,
                                       collides, visible,  layers};
        return PyFixture{self.world, ((*self.world).*add)(self.handle, shape..., settings)};
      },
      names..., py::kw_only(), py::arg("density"), py::arg("friction") = 0.0,
      py::arg("restitution") = 0.0, py::arg("sensor") = false, py::arg("collides") = true,
      py::arg("visible") = true, py::arg("layers") = kAllLayers);
}

template <auto setting>
auto GetSetting(const PyFixture& self) {
  return self.world->GetSettings(self.handle).*setting;
}

}  // namespace

void BindFixturesOf(py::class_<PyBody>& body) {
  DefineAdd<Vec2, double>(body, "add_circle", &World::AddCircle, py::arg("center"),
                          py::arg("radius"));
  DefineAdd<const std::vector<Vec2>&>(body, "add_polygon", &World::AddPolygon, py::arg("vertices"));
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
  fixture
      .def_property_readonly("body",
                             [](const PyFixture& self) {
                               return PyBody{self.world, self.handle.body};
                             })
      .def_property_readonly("index", [](const PyFixture& self) { return self.handle.index; })
      .def(py::self == py::self)
      .def("__hash__",
           [](const PyFixture& self) {
             return py::hash(py::make_tuple(IdOf(self.handle.body), self.handle.index));
           })
      .def_property_readonly("density", &GetSetting<&FixtureSettings::density>)
      .def_property("friction", &GetSetting<&FixtureSettings::friction>,
                    OfWorld<&World::SetFriction>())
      .def_property("restitution", &GetSetting<&FixtureSettings::restitution>,
                    OfWorld<&World::SetRestitution>())
      .def_property_readonly("sensor", &GetSetting<&FixtureSettings::sensor>)
      .def_property_readonly("collides", &GetSetting<&FixtureSettings::collides>)
      .def_property("visible", &GetSetting<&FixtureSettings::visible>,
                    OfWorld<&World::SetVisible>())
      .def_property_readonly("layers", &GetSetting<&FixtureSettings::layers>)
      .def_property("seen_radius", OfWorld<&World::GetSeenRadius>(),
                    OfWorld<&World::SetSeenRadius>())
      .def("test_point", OfWorld<&World::TestPoint>(), py::arg("point"))
      .def(
          "set_circle",
          [](PyFixture& self, Vec2 center, double radius, std::optional<LayerBits> layers) {
            self.world->SetCircle(self.handle, center, radius, layers);
            RethrowFromListener(*self.world);
          },
          py::arg("center"), py::arg("radius"), py::kw_only(), py::arg("layers") = py::none())
      .def(
          "set_polygon",
          [](PyFixture& self, const std::vector<Vec2>& vertices, std::optional<LayerBits> layers) {
            self.world->SetPolygon(self.handle, vertices, layers);
            RethrowFromListener(*self.world);
          },
          py::arg("vertices"), py::kw_only(), py::arg("layers") = py::none());
}

}  // namespace flatland
