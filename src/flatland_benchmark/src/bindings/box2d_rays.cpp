/// flatland_benchmark._box2d_rays: lidar scans by b2World::RayCast, beam by beam, the baseline of
/// the benchmark's ray cases. Uses nothing of Flatland.

#include <box2d/box2d.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <array>
#include <cmath>
#include <limits>
#include <vector>

namespace py = pybind11;

namespace {

using Rows = py::array_t<double, py::array::c_style | py::array::forcecast>;
using Point = std::array<double, 2>;
using Pose = std::array<double, 3>;

b2Vec2 ToBox2D(double x, double y) { return {static_cast<float>(x), static_cast<float>(y)}; }

/// Keeps the nearest fixture on a ray; Box2D reports them in any order.
class Nearest : public b2RayCastCallback {
 public:
  float ReportFixture(b2Fixture* fixture, const b2Vec2&, const b2Vec2&, float fraction) override {
    if (fixture->IsSensor()) return -1.0f;
    fraction_ = fraction;
    return fraction;
  }
  float fraction() const { return fraction_; }

 private:
  float fraction_ = std::numeric_limits<float>::infinity();
};

class World {
 public:
  /// Adds walls, each a two-sided edge of one static body, in this order.
  void AddWalls(const Rows& segments) {
    const auto rows = segments.unchecked<2>();
    const b2BodyDef definition;
    b2Body* body = world_.CreateBody(&definition);
    for (py::ssize_t i = 0; i < rows.shape(0); ++i) {
      b2EdgeShape edge;
      edge.SetTwoSided(ToBox2D(rows(i, 0), rows(i, 1)), ToBox2D(rows(i, 2), rows(i, 3)));
      body->CreateFixture(&edge, 0.0f);
    }
  }

  size_t AddBody(const Pose& pose) {
    b2BodyDef definition;
    definition.type = b2_dynamicBody;
    definition.position = ToBox2D(pose[0], pose[1]);
    definition.angle = static_cast<float>(pose[2]);
    bodies_.push_back(world_.CreateBody(&definition));
    return bodies_.size() - 1;
  }

  void AddCircle(size_t body, const Point& center, double radius) {
    b2CircleShape shape;
    shape.m_p = ToBox2D(center[0], center[1]);
    shape.m_radius = static_cast<float>(radius);
    bodies_.at(body)->CreateFixture(&shape, 1.0f);
  }

  void AddPolygon(size_t body, const std::vector<Point>& vertices) {
    std::vector<b2Vec2> points;
    for (const Point& vertex : vertices) points.push_back(ToBox2D(vertex[0], vertex[1]));
    b2PolygonShape shape;
    shape.Set(points.data(), static_cast<int32>(points.size()));
    bodies_.at(body)->CreateFixture(&shape, 1.0f);
  }

  /// Casts one ray of length `range` after the other. Directions are unit vectors in the lidar's
  /// frame.
  py::array_t<double> Scan(const Rows& directions, const Pose& pose, double range) const {
    const auto rows = directions.unchecked<2>();
    py::array_t<double> ranges(rows.shape(0));
    double* out = ranges.mutable_data();
    const py::gil_scoped_release release;
    const double cos = std::cos(pose[2]) * range;
    const double sin = std::sin(pose[2]) * range;
    const b2Vec2 from = ToBox2D(pose[0], pose[1]);
    for (py::ssize_t i = 0; i < rows.shape(0); ++i) {
      const double x = rows(i, 0);
      const double y = rows(i, 1);
      const b2Vec2 to = ToBox2D(pose[0] + cos * x - sin * y, pose[1] + sin * x + cos * y);
      Nearest nearest;
      world_.RayCast(&nearest, from, to);
      out[i] = nearest.fraction() * range;
    }
    return ranges;
  }

 private:
  b2World world_{b2Vec2_zero};
  std::vector<b2Body*> bodies_;
};

}  // namespace

PYBIND11_MODULE(_box2d_rays, m) {
  m.doc() = "Lidar scans by b2World::RayCast: the reference of the benchmark.";
  py::class_<World>(m, "World")
      .def(py::init<>())
      .def("add_walls", &World::AddWalls, py::arg("segments"))
      .def("add_body", &World::AddBody, py::arg("pose"))
      .def("add_circle", &World::AddCircle, py::arg("body"), py::arg("center"), py::arg("radius"))
      .def("add_polygon", &World::AddPolygon, py::arg("body"), py::arg("vertices"))
      .def("scan", &World::Scan, py::arg("directions"), py::arg("pose"), py::arg("range"));
}
