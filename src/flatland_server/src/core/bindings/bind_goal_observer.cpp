/// GoalObserver in Python: the observations of n robots in one call.

#include "bindings/bindings.hpp"
#include "batch/goal_observer.hpp"

namespace flatland {
namespace {

template <class T>
using Array = py::array_t<T, py::array::c_style>;

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
  const py::gil_scoped_release release;
  for (py::ssize_t k = 0; k < count; ++k) {
    self.Observe(range, pose, velocity, goal, row);
    range += self.beams(), pose += 3, velocity += 3, goal += 2, row += self.size();
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
}

}  // namespace flatland
