/// WorldBatch: many environments in one call.

#include <algorithm>

#include "batch/world_batch.hpp"
#include "bindings/bindings.hpp"
#include "sight/visible_walls.hpp"
#include "world/layers.hpp"

namespace flatland {
namespace {

/// The walls of a layer, with what lidars need of them.
struct PyWalls {
  std::shared_ptr<const VisibleWalls> walls;
};

PyWalls MakeWalls(const Array<double>& segments) {
  std::vector<Segment> converted = ToSegments(segments);
  RequireWalls(converted);
  const ReleasedGil release;
  return {VisibleWalls::Share(std::move(converted))};
}

/// A batch, and the mark that a call is in progress while the GIL is released.
struct PyWorldBatch {
  WorldBatch batch;
  bool is_in_use = false;
};

class Use {
 public:
  explicit Use(PyWorldBatch& batch) : batch_(batch) {
    if (batch.is_in_use) throw std::logic_error("the batch is in use by another thread");
    batch.is_in_use = true;
  }
  ~Use() { batch_.is_in_use = false; }
  Use(const Use&) = delete;
  Use& operator=(const Use&) = delete;

 private:
  PyWorldBatch& batch_;
};

template <class T>
void RequireShape(const Array<T>& array, const char* name, py::ssize_t rows, py::ssize_t columns) {
  const bool fits = columns == 0
                        ? array.ndim() == 1 && array.shape(0) == rows
                        : array.ndim() == 2 && array.shape(0) == rows && array.shape(1) == columns;
  if (!fits) throw std::invalid_argument(std::string("an array has the wrong shape: ") + name);
}

/// The numbers of an array of a shape.
template <class T>
const T* DataOf(const Array<T>& array, const char* name, py::ssize_t rows, py::ssize_t columns) {
  RequireShape(array, name, rows, columns);
  return array.data();
}

/// The same; null without an array.
template <class T>
const T* DataOf(const std::optional<Array<T>>& array, const char* name, py::ssize_t rows,
                py::ssize_t columns = 0) {
  return array ? DataOf(*array, name, rows, columns) : nullptr;
}

using Mask = std::optional<Array<bool>>;

/// Pointers to the arrays (ranges, poses, velocities, local_velocities, collided, steps), which are
/// written to in place.
BatchRows ToRows(const WorldBatch& batch, const py::tuple& out) {
  if (out.size() != 6) throw std::invalid_argument("expected six arrays");
  const auto rows = [&](int i, const char* name, py::ssize_t columns, auto type) {
    using T = decltype(type);
    if (!py::isinstance<Array<T>>(out[i])) {
      throw std::invalid_argument(std::string("an array has the wrong type: ") + name);
    }
    auto array = py::reinterpret_borrow<Array<T>>(out[i]);
    RequireShape(array, name, i == 5 ? batch.count() : batch.row_count(), columns);
    return array.mutable_data();  // throws std::domain_error if it is read-only
  };
  return {rows(0, "ranges", batch.beams(), float()),
          rows(1, "poses", 3, double()),
          rows(2, "velocities", 3, double()),
          rows(3, "local_velocities", 3, double()),
          rows(4, "collided", 0, bool()),
          rows(5, "steps", 0, int64_t())};
}

const double* ActionsOf(const WorldBatch& batch, const Array<double>& actions) {
  return DataOf(actions, "actions", batch.row_count(), batch.action_size());
}

void RequireActions(const PyWorldBatch& self, const Array<double>& actions, const Mask& mask) {
  const double* const numbers = ActionsOf(self.batch, actions);
  self.batch.RequireActions(numbers, DataOf(mask, "mask", self.batch.row_count()));
}

void Step(PyWorldBatch& self, const Array<double>& actions, int substeps, double dt,
          const std::optional<py::tuple>& out, bool goes_on, const Mask& mask) {
  const double* const numbers = ActionsOf(self.batch, actions);
  const bool* const chosen = DataOf(mask, "mask", self.batch.row_count());
  std::optional<BatchRows> rows;
  if (out) rows = ToRows(self.batch, *out);
  const Use use(self);
  const ReleasedGil release;
  if (rows) {
    self.batch.Step(numbers, substeps, dt, *rows, goes_on, chosen);
  } else {
    self.batch.Advance(numbers, substeps, dt, goes_on, chosen);
  }
}

int Reset(PyWorldBatch& self, const Mask& mask, const std::optional<Array<double>>& poses,
          const py::tuple& out, const std::optional<Array<double>>& model_poses) {
  const int count = self.batch.count();
  const bool* const chosen = DataOf(mask, "mask", count);
  const double* const places = DataOf(poses, "poses", self.batch.row_count(), 3);
  const double* const model_places =
      DataOf(model_poses, "model_poses", count, 3 * self.batch.model_count());
  const BatchRows rows = ToRows(self.batch, out);
  const Use use(self);
  const ReleasedGil release;
  return self.batch.Reset(chosen, places, rows, model_places);
}

void SetSettings(PyWorldBatch& self, const Array<double>& values, const Mask& mask) {
  const int count = self.batch.count();
  const double* const numbers =
      DataOf(values, "values", count, std::max(self.batch.varied_count(), 1));
  const bool* const chosen = DataOf(mask, "mask", count);
  const Use use(self);
  self.batch.SetSettings(chosen, numbers);
}

void MoveRobots(PyWorldBatch& self, const Array<double>& poses, const Mask& mask) {
  const double* const places = DataOf(poses, "poses", self.batch.row_count(), 3);
  const bool* const chosen = DataOf(mask, "mask", self.batch.row_count());
  const Use use(self);
  const ReleasedGil release;
  self.batch.MoveRobots(chosen, places);
}

void LoadStates(PyWorldBatch& self, const Mask& mask, const std::vector<std::string_view>& states,
                const std::vector<std::optional<PyWalls>>& walls, const Array<int64_t>& chosen,
                const Array<int64_t>& steps, const py::tuple& out) {
  const int count = self.batch.count();
  const bool* const environments = DataOf(mask, "mask", count);
  RequireShape(chosen, "chosen", count, 0);
  RequireShape(steps, "steps", count, 0);
  const BatchRows rows = ToRows(self.batch, out);
  if (walls.size() != states.size()) throw std::invalid_argument("expected walls for each state");
  std::vector<std::shared_ptr<const VisibleWalls>> of_states;
  for (const auto& each : walls) of_states.push_back(each ? each->walls : nullptr);
  const Use use(self);
  const ReleasedGil release;
  self.batch.LoadStates(environments, states, of_states, chosen.data(), steps.data(), rows);
}

void Observe(PyWorldBatch& self, const py::tuple& out) {
  const BatchRows rows = ToRows(self.batch, out);
  const Use use(self);
  const ReleasedGil release;
  self.batch.Observe(rows);
}

std::vector<World::Body> ToHandles(const std::vector<PyBody>& bodies) {
  std::vector<World::Body> handles;
  for (const PyBody& body : bodies) handles.push_back(body.handle);
  return handles;
}

void Seed(PyWorldBatch& self, const std::variant<PyCrowd, PyDrive, PyAckermann, PyTricycle>& owner,
          const Array<uint64_t>& keys, const Mask& mask) {
  const uint64_t* const numbers = DataOf(keys, "keys", self.batch.count(), 0);
  const bool* const chosen = DataOf(mask, "mask", self.batch.count());
  const Use use(self);
  const ReleasedGil release;
  std::visit([&](const auto& each) { self.batch.Seed(chosen, each.handle, numbers); }, owner);
}

void Scatter(PyWorldBatch& self, const PyCrowd& crowd, const Array<uint64_t>& keys,
             const Mask& mask) {
  const uint64_t* const numbers = DataOf(keys, "keys", self.batch.count(), 0);
  const bool* const chosen = DataOf(mask, "mask", self.batch.count());
  const Use use(self);
  self.batch.Scatter(crowd.handle, chosen, numbers);
}

/// Poses and velocities: two arrays of shape (count, bodies, 3), with zeros where the mask does not
/// choose.
py::tuple GetMotions(PyWorldBatch& self, const std::vector<PyBody>& bodies, const Mask& mask) {
  const bool* const chosen = DataOf(mask, "mask", self.batch.count());
  const std::vector<py::ssize_t> shape{self.batch.count(), static_cast<py::ssize_t>(bodies.size()),
                                       3};
  Array<double> poses(shape), velocities(shape);
  std::fill_n(poses.mutable_data(), poses.size(), 0.0);
  std::fill_n(velocities.mutable_data(), velocities.size(), 0.0);
  const std::vector<World::Body> handles = ToHandles(bodies);
  {
    const Use use(self);
    const ReleasedGil release;
    self.batch.GetMotions(chosen, handles, poses.mutable_data(), velocities.mutable_data());
  }
  return py::make_tuple(poses, velocities);
}

void SetVelocities(PyWorldBatch& self, const std::vector<PyBody>& bodies,
                   const Array<double>& velocities, const Mask& mask) {
  const bool* const chosen = DataOf(mask, "mask", self.batch.count());
  const double* const numbers = DataOf(velocities, "velocities", self.batch.count(),
                                       3 * static_cast<py::ssize_t>(bodies.size()));
  const std::vector<World::Body> handles = ToHandles(bodies);
  const Use use(self);
  const ReleasedGil release;
  self.batch.SetVelocities(chosen, handles, numbers);
}

/// Bodies, base, drive, columns and lidar.
using PyRobot =
    std::tuple<std::vector<PyBody>, Pose, std::variant<PyTricycle, PyAckermann, PyDrive>,
               std::vector<int>, const PyLidar*>;

BatchRobot ToRobot(const PyRobot& values) {
  const auto& [bodies, base, drive, columns, lidar] = values;
  BatchRobot robot;
  robot.bodies = ToHandles(bodies);
  robot.base = base;
  std::visit([&](const auto& owned) { robot.drive = owned.handle; }, drive);
  robot.columns = {-1, -1, -1};
  robot.action_size = static_cast<int>(columns.size());
  for (int i = 0; i < robot.action_size; ++i) {
    if (columns[i] < 0 || columns[i] > 2) throw std::invalid_argument("a column is 0, 1 or 2");
    robot.columns[columns[i]] = i;
  }
  robot.lidar = lidar->handle;
  return robot;
}

using PyModels = std::vector<std::pair<std::vector<PyBody>, Pose>>;

std::vector<BatchModel> ToModels(const PyModels& models) {
  std::vector<BatchModel> converted;
  for (const auto& [bodies, base] : models) converted.push_back({ToHandles(bodies), base});
  return converted;
}

}  // namespace

void BindWorldBatch(py::module_& m) {
  const auto mask = py::arg("mask").noconvert().none(true);
  const auto keys = py::arg("keys").noconvert();
  py::class_<PyWalls>(m, "Walls")
      .def(py::init(&MakeWalls), py::arg("segments"))
      .def("__len__", [](const PyWalls& self) { return self.walls->all().segment_count(); })
      .def_property_readonly("segments", [](const PyWalls& self) {
        const std::vector<Segment>& segments = self.walls->all().segments();
        Array<double> rows({static_cast<py::ssize_t>(segments.size()), py::ssize_t{4}});
        if (!segments.empty()) std::memcpy(rows.mutable_data(), segments.data(), rows.nbytes());
        return rows;
      });
  py::class_<PyWorldBatch>(m, "WorldBatch")
      .def(py::init([](const PyWorld& world, const std::vector<PyRobot>& robots, int count,
                       int threads, const PyModels& models, int64_t steps,
                       const std::vector<int>& varied) {
             std::vector<BatchRobot> converted;
             for (const PyRobot& robot : robots) converted.push_back(ToRobot(robot));
             return std::unique_ptr<PyWorldBatch>(new PyWorldBatch{
                 {*world.world, converted, count, threads, ToModels(models), steps, varied}});
           }),
           py::arg("world"), py::kw_only(), py::arg("robots"), py::arg("count"), py::arg("threads"),
           py::arg("models"), py::arg("steps") = 0, py::arg("varied") = std::vector<int>())
      .def_property_readonly("beams", [](const PyWorldBatch& self) { return self.batch.beams(); })
      .def("require_actions", &RequireActions, py::arg("actions").noconvert(), mask)
      .def("step", &Step, py::arg("actions").noconvert(), py::arg("substeps"), py::arg("dt"),
           py::arg("out").none(true), py::arg("goes_on") = false,
           py::arg("mask").noconvert().none(true) = py::none())
      .def("reset", &Reset, mask, py::arg("poses").noconvert().none(true), py::arg("out"),
           py::arg("model_poses").noconvert().none(true))
      .def("set_settings", &SetSettings, py::arg("values").noconvert(), mask)
      .def("move_robots", &MoveRobots, py::arg("poses").noconvert(), mask)
      .def(
          "save_state",
          [](PyWorldBatch& self, int row) {
            const Use use(self);
            return py::bytes(self.batch.SaveState(row));
          },
          py::arg("row"))
      .def("load_states", &LoadStates, mask, py::arg("states"), py::arg("walls"),
           py::arg("chosen").noconvert(), py::arg("steps").noconvert(), py::arg("out"))
      .def("observe", &Observe, py::arg("out"))
      .def(
          "replace",
          [](PyWorldBatch& self, int row, const PyWorld& world) {
            const Use use(self);
            self.batch.Replace(row, *world.world);
          },
          py::arg("row"), py::arg("world"))
      .def(
          "set_walls",
          [](PyWorldBatch& self, int row, const std::optional<PyWalls>& walls) {
            const Use use(self);
            self.batch.SetWalls(row, walls ? walls->walls : nullptr);
          },
          py::arg("row"), py::arg("walls"))
      .def("scatter", &Scatter, py::arg("crowd"), keys, mask)
      .def("seed", &Seed, py::arg("owner"), keys, mask)
      .def("motions", &GetMotions, py::arg("bodies"), mask)
      .def("set_velocities", &SetVelocities, py::arg("bodies"), py::arg("velocities").noconvert(),
           mask);
}

}  // namespace flatland
