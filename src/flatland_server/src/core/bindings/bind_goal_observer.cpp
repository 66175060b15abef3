/// GoalObserver and LinesOfSight in Python: the observations of n robots in one call.

#include <algorithm>

#include "base/normal_numbers.hpp"
#include "batch/goal_observer.hpp"
#include "bindings/bindings.hpp"
#include "sight/lines_of_sight.hpp"

namespace flatland {
namespace {

Array<float> Observe(const GoalObserver& self, const Array<float>& ranges,
                     const Array<double>& poses, const Array<double>& velocities,
                     const Array<double>& goals) {
  const py::ssize_t count = ranges.ndim() == 2 ? ranges.shape(0) : -1;
  const auto fits = [&](const auto& array, py::ssize_t columns) {
    return array.ndim() == 2 && array.shape(0) == count && array.shape(1) == columns;
  };
  if (!fits(ranges, self.beams()) || !fits(poses, 3) || !fits(velocities, 3) || !fits(goals, 2)) {
    throw std::invalid_argument(
        "expected ranges (n, beams), poses and velocities (n, 3), and goals (n, 2)");
  }
  Array<float> result({count, static_cast<py::ssize_t>(self.size())});
  const float* range = ranges.data();
  const double *pose = poses.data(), *velocity = velocities.data(), *goal = goals.data();
  float* row = result.mutable_data();
  const ReleasedGil release;
  for (py::ssize_t k = 0; k < count; ++k) {
    self.Observe(range, pose, velocity, goal, row);
    range += self.beams(), pose += 3, velocity += 3, goal += 2, row += self.size();
  }
  return result;
}

LinesOfSight MakeLines(const Array<double>& walls) { return LinesOfSight(ToSegments(walls)); }

void RequireLines(const Array<double>& lines) {
  if (lines.ndim() != 2 || lines.shape(1) != 4) {
    throw std::invalid_argument("expected lines (n, 4)");
  }
}

/// `walls_of(k)` are those of line k, or null.
template <class WallsOf>
Array<bool> AreBlocked(const Array<double>& lines, WallsOf walls_of) {
  Array<bool> result(lines.shape(0));
  const double* end = lines.data();
  bool* const blocked = result.mutable_data();
  const ReleasedGil release;
  for (py::ssize_t k = 0; k < lines.shape(0); ++k, end += 4) {
    const LinesOfSight* const walls = walls_of(k);
    blocked[k] = walls != nullptr && walls->IsBlocked({{end[0], end[1]}, {end[2], end[3]}});
  }
  return result;
}

Array<bool> AreBlockedBy(const LinesOfSight& self, const Array<double>& lines) {
  RequireLines(lines);
  return AreBlocked(lines, [&](py::ssize_t) { return &self; });
}

Array<bool> AreBlockedByTheirs(const std::vector<const LinesOfSight*>& walls,
                               const Array<int64_t>& which, const Array<double>& lines) {
  RequireLines(lines);
  const auto count = static_cast<int64_t>(walls.size());
  const int64_t *const first = which.data(), *const end = first + which.size();
  if (which.size() != lines.shape(0) ||
      std::any_of(first, end, [&](int64_t each) { return each < -1 || each >= count; })) {
    throw std::invalid_argument("expected an index of walls for each line, or -1");
  }
  return AreBlocked(lines, [&](py::ssize_t k) { return first[k] < 0 ? nullptr : walls[first[k]]; });
}

Array<double> NormalRows(const Array<uint64_t>& keys, int count) {
  if (keys.ndim() != 1 || count < 0) throw std::invalid_argument("expected keys (n,)");
  Array<double> result({keys.shape(0), static_cast<py::ssize_t>(count)});
  double* number = result.mutable_data();
  for (py::ssize_t k = 0; k < keys.shape(0); ++k) {
    NormalNumbers numbers(NormalNumbers::Mixed(keys.data()[k]));
    for (int i = 0; i < count; ++i) *number++ = numbers.Draw();
  }
  return result;
}

}  // namespace

void BindGoalObserver(py::module_& m) {
  py::class_<GoalObserver>(m, "GoalObserver")
      .def(py::init<int, double, const std::vector<double>&>(), py::arg("beams"),
           py::arg("max_range"), py::arg("velocity_limits"))
      .def("observe", &Observe, py::arg("ranges").noconvert(), py::arg("poses").noconvert(),
           py::arg("velocities").noconvert(), py::arg("goals").noconvert());
  py::class_<LinesOfSight>(m, "LinesOfSight")
      .def(py::init(&MakeLines), py::arg("walls"))
      .def("blocked", &AreBlockedBy, py::arg("lines"));
  m.def("blocked_lines", &AreBlockedByTheirs, py::arg("walls"), py::arg("which"), py::arg("lines"));
  m.def("normal_rows", &NormalRows, py::arg("keys"), py::arg("count"));
}

}  // namespace flatland
