/// FloorSquares in Python: the random numbers are those of a numpy.random.Generator.

#include <algorithm>
#include <array>

#include "batch/floor_squares.hpp"
#include "bindings/bindings.hpp"

namespace flatland {

inline std::tuple<Pose, Vec2> ToTuple(const Ends& ends) {
  return {Pose{ends.start.x, ends.start.y, ends.yaw}, ends.goal};
}

}  // namespace flatland

namespace pybind11::detail {

template <>
struct type_caster<flatland::Disc> : StructCaster<flatland::Disc, double, double, double> {};
template <>
struct type_caster<flatland::Ends> : StructCaster<flatland::Ends, flatland::Pose, flatland::Vec2> {
};

}  // namespace pybind11::detail

namespace flatland {
namespace {

FloorSquares MakeSquares(const Array<bool>& squares, Vec2 corner, double side) {
  if (squares.ndim() != 2) throw std::invalid_argument("expected squares (rows, columns)");
  return {squares.data(), static_cast<int>(squares.shape(0)), static_cast<int>(squares.shape(1)),
          corner, side};
}

/// NumPy offers its generators to other C code by a capsule of this name.
const NumberSource& SourceOf(const py::object& generator) {
  const py::object capsule = generator.attr("bit_generator").attr("capsule");
  const void* source = PyCapsule_GetPointer(capsule.ptr(), "BitGenerator");
  if (source == nullptr) throw py::error_already_set();
  return *static_cast<const NumberSource*>(source);
}

void Lower(Array<double> squares, const Array<double>& walls, double reach, Vec2 corner,
           double side) {
  if (squares.ndim() != 2) throw std::invalid_argument("expected squares (rows, columns)");
  const std::vector<Segment> segments = ToSegments(walls);
  double* const numbers = squares.mutable_data();
  const int64_t rows = squares.shape(0), columns = squares.shape(1);
  const ReleasedGil release;
  LowerToWalls(segments, reach, corner, side, rows, columns, numbers);
}

Array<bool> Connected(const Array<bool>& free, std::optional<std::array<int64_t, 2>> start) {
  const auto [row, column] = start.value_or(std::array<int64_t, 2>{0, 0});
  const bool is_inside =
      free.ndim() == 2 && row >= 0 && row < free.shape(0) && column >= 0 && column < free.shape(1);
  if (!is_inside) throw std::invalid_argument("expected squares (rows, columns), and one of them");
  const int64_t rows = free.shape(0), columns = free.shape(1);
  Array<bool> reached({rows, columns});
  bool* const marks = reached.mutable_data();
  std::fill_n(marks, rows * columns, false);
  MarkConnected(free.data(), rows, columns, start ? row * columns + column : -1, marks);
  return reached;
}

Array<bool> Crop(const FloorSquares& self, const Array<double>& poses, int cells) {
  if (poses.ndim() != 2 || poses.shape(1) != 3 || cells < 1) {
    throw std::invalid_argument("expected poses (n, 3), and a number of cells above 0");
  }
  const py::ssize_t count = poses.shape(0), size = py::ssize_t{cells} * cells;
  Array<bool> crops({count, size});
  const double* pose = poses.data();
  bool* crop = crops.mutable_data();
  const ReleasedGil release;
  for (py::ssize_t k = 0; k < count; ++k, pose += 3, crop += size) {
    self.Crop({pose[0], pose[1], pose[2]}, cells, crop);
  }
  return crops;
}

void RequireSquare(const FloorSquares& self) {
  if (self.size() == 0) throw std::invalid_argument("there is no square");
}

}  // namespace

void BindFloorSquares(py::module_& m) {
  m.def("lower_to_walls", &Lower, py::arg("squares").noconvert(), py::arg("walls").noconvert(),
        py::arg("reach"), py::arg("corner"), py::arg("side"));
  m.def("connected", &Connected, py::arg("free"), py::arg("start"));
  py::class_<FloorSquares>(m, "FloorSquares")
      .def(py::init(&MakeSquares), py::arg("squares"), py::arg("corner"), py::arg("side"))
      .def("__len__", &FloorSquares::size)
      .def("__contains__", &FloorSquares::Contains, py::arg("point"))
      .def("crop", &Crop, py::arg("poses"), py::arg("cells"))
      .def(
          "draw",
          [](const FloorSquares& self, const py::object& rng) {
            RequireSquare(self);
            return self.Draw(SourceOf(rng));
          },
          py::arg("rng"))
      .def(
          "draw_clear",
          [](const FloorSquares& self, const py::object& rng, const std::vector<Disc>& discs,
             double radius, double distance, int count, int tries) {
            RequireSquare(self);
            return self.DrawClear(SourceOf(rng), discs, radius, distance, count, tries);
          },
          py::arg("rng"), py::arg("discs"), py::arg("radius"), py::arg("distance"),
          py::arg("count"), py::arg("tries"))
      .def(
          "draw_ends",
          [](const FloorSquares& self, const py::object& rng, std::optional<Vec2> start,
             std::optional<Vec2> goal, Vec2 distances, double radius,
             const std::vector<Disc>& at_starts, const std::vector<Disc>& at_goals, int tries) {
            RequireSquare(self);
            return self.DrawEnds(
                SourceOf(rng), {start, goal, distances.x, distances.y, radius, at_starts, at_goals},
                tries);
          },
          py::arg("rng"), py::arg("start"), py::arg("goal"), py::arg("distances"),
          py::arg("radius"), py::arg("at_starts"), py::arg("at_goals"), py::arg("tries"));
}

}  // namespace flatland
