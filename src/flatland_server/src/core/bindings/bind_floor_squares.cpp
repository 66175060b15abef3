/// FloorSquares in Python: the random numbers are those of a numpy.random.Generator.

#include <algorithm>
#include <array>

#include "batch/floor_squares.hpp"
#include "bindings/bindings.hpp"

namespace flatland {
namespace {

using Numbers = py::array_t<double, py::array::c_style>;

using Discs = std::vector<std::array<double, 3>>;

FloorSquares MakeSquares(const py::array_t<bool, py::array::c_style>& squares,
                         std::array<double, 2> corner, double side) {
  if (squares.ndim() != 2) throw std::invalid_argument("expected squares (rows, columns)");
  return {squares.data(),
          static_cast<int>(squares.shape(0)),
          static_cast<int>(squares.shape(1)),
          {corner[0], corner[1]},
          side};
}

std::vector<Disc> ToDiscs(const Discs& rows) {
  std::vector<Disc> discs;
  for (const auto& [x, y, radius] : rows) discs.push_back({{x, y}, radius});
  return discs;
}

std::optional<Vec2> ToPoint(const std::optional<std::array<double, 2>>& point) {
  return point ? std::optional(Vec2{(*point)[0], (*point)[1]}) : std::nullopt;
}

/// NumPy offers its generators to other C code by a capsule of this name.
const NumberSource& SourceOf(const py::object& generator) {
  const py::object capsule = generator.attr("bit_generator").attr("capsule");
  const void* source = PyCapsule_GetPointer(capsule.ptr(), "BitGenerator");
  if (source == nullptr) throw py::error_already_set();
  return *static_cast<const NumberSource*>(source);
}

void Lower(Numbers squares, const Numbers& walls, double reach, std::array<double, 2> corner,
           double side) {
  if (squares.ndim() != 2) throw std::invalid_argument("expected squares (rows, columns)");
  const std::vector<Segment> segments = ToSegments(walls);
  double* const numbers = squares.mutable_data();
  const int64_t rows = squares.shape(0), columns = squares.shape(1);
  const py::gil_scoped_release release;
  LowerToWalls(segments, reach, {corner[0], corner[1]}, side, rows, columns, numbers);
}

py::array_t<bool> Connected(const py::array_t<bool, py::array::c_style>& free,
                            std::optional<std::array<int64_t, 2>> start) {
  const auto [row, column] = start.value_or(std::array<int64_t, 2>{0, 0});
  const bool is_inside =
      free.ndim() == 2 && row >= 0 && row < free.shape(0) && column >= 0 && column < free.shape(1);
  if (!is_inside) throw std::invalid_argument("expected squares (rows, columns), and one of them");
  const int64_t rows = free.shape(0), columns = free.shape(1);
  py::array_t<bool> reached({rows, columns});
  bool* const marks = reached.mutable_data();
  std::fill_n(marks, rows * columns, false);
  MarkConnected(free.data(), rows, columns, start ? row * columns + column : -1, marks);
  return reached;
}

py::array_t<bool> Crop(const FloorSquares& self, const Numbers& poses, int cells) {
  if (poses.ndim() != 2 || poses.shape(1) != 3 || cells < 1) {
    throw std::invalid_argument("expected poses (n, 3), and a number of cells above 0");
  }
  const py::ssize_t count = poses.shape(0), size = py::ssize_t{cells} * cells;
  py::array_t<bool> crops({count, size});
  const double* pose = poses.data();
  bool* crop = crops.mutable_data();
  const py::gil_scoped_release release;
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
      .def(
          "__contains__",
          [](const FloorSquares& self, std::array<double, 2> point) {
            return self.Contains({point[0], point[1]});
          },
          py::arg("point"))
      .def("crop", &Crop, py::arg("poses"), py::arg("cells"))
      .def(
          "draw",
          [](const FloorSquares& self, const py::object& rng) {
            RequireSquare(self);
            return ToTuple(self.Draw(SourceOf(rng)));
          },
          py::arg("rng"))
      .def(
          "draw_clear",
          [](const FloorSquares& self, const py::object& rng, const Discs& discs, double radius,
             double distance, int count, int tries) {
            RequireSquare(self);
            std::vector<std::optional<Triple>> poses;
            for (const auto& pose :
                 self.DrawClear(SourceOf(rng), ToDiscs(discs), radius, distance, count, tries)) {
              poses.push_back(pose ? std::optional(ToTuple(*pose)) : std::nullopt);
            }
            return poses;
          },
          py::arg("rng"), py::arg("discs"), py::arg("radius"), py::arg("distance"),
          py::arg("count"), py::arg("tries"))
      .def(
          "draw_ends",
          [](const FloorSquares& self, const py::object& rng,
             const std::optional<std::array<double, 2>>& start,
             const std::optional<std::array<double, 2>>& goal, std::array<double, 2> distances,
             double radius, const Discs& at_starts, const Discs& at_goals, int tries) {
            RequireSquare(self);
            const EndsSettings settings{ToPoint(start),   ToPoint(goal), distances[0],
                                        distances[1],     radius,        ToDiscs(at_starts),
                                        ToDiscs(at_goals)};
            const auto ends = self.DrawEnds(SourceOf(rng), settings, tries);
            return ends ? std::optional(
                              std::pair(ToTuple(Pose{ends->start.x, ends->start.y, ends->yaw}),
                                        ToTuple(ends->goal)))
                        : std::nullopt;
          },
          py::arg("rng"), py::arg("start"), py::arg("goal"), py::arg("distances"),
          py::arg("radius"), py::arg("at_starts"), py::arg("at_goals"), py::arg("tries"));
}

}  // namespace flatland
