/// WorldBatch: many environments in one call.

#include "bindings.hpp"
#include "flatland_server/world_batch.hpp"

namespace flatland {
namespace {

template <class T>
using Array = py::array_t<T, py::array::c_style>;

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
    RequireShape(array, name, batch.count(), columns);
    return array.mutable_data();  // throws std::domain_error if it is read-only
  };
  return {rows(0, "ranges", batch.beams(), float()),
          rows(1, "poses", 3, double()),
          rows(2, "velocities", 3, double()),
          rows(3, "local_velocities", 3, double()),
          rows(4, "collided", 0, bool()),
          rows(5, "steps", 0, int64_t())};
}

void Step(PyWorldBatch& self, const Array<double>& actions, int substeps, double dt,
          const py::tuple& out) {
  RequireShape(actions, "actions", self.batch.count(), self.batch.robot().action_size);
  const BatchRows rows = ToRows(self.batch, out);
  const Use use(self);
  const py::gil_scoped_release release;
  self.batch.Step(actions.data(), substeps, dt, rows);
}

void Reset(PyWorldBatch& self, const std::optional<Array<bool>>& mask,
           const std::optional<Array<double>>& poses, const py::tuple& out) {
  if (mask) RequireShape(*mask, "mask", self.batch.count(), 0);
  if (poses) RequireShape(*poses, "poses", self.batch.count(), 3);
  const BatchRows rows = ToRows(self.batch, out);
  const Use use(self);
  const py::gil_scoped_release release;
  self.batch.Reset(mask ? mask->data() : nullptr, poses ? poses->data() : nullptr, rows);
}

void Observe(PyWorldBatch& self, const py::tuple& out) {
  const BatchRows rows = ToRows(self.batch, out);
  const Use use(self);
  const py::gil_scoped_release release;
  self.batch.Observe(rows);
}

BatchRobot ToRobot(const std::vector<PyBody>& bodies, const Triple& base, const py::object& drive,
                   const std::vector<int>& columns, const PyLidar& lidar) {
  BatchRobot robot;
  for (const PyBody& body : bodies) robot.bodies.push_back(body.handle);
  robot.base = ToPose(base);
  if (py::isinstance<PyTricycle>(drive)) {
    robot.drive = drive.cast<const PyTricycle&>().handle;
  } else {
    robot.drive = drive.cast<const PyDrive&>().handle;
  }
  robot.columns = {-1, -1, -1};
  robot.action_size = static_cast<int>(columns.size());
  for (int i = 0; i < robot.action_size; ++i) {
    if (columns[i] < 0 || columns[i] > 2) throw std::invalid_argument("a column is 0, 1 or 2");
    robot.columns[columns[i]] = i;
  }
  robot.lidar = lidar.handle;
  return robot;
}

}  // namespace

void BindWorldBatch(py::module_& m) {
  py::class_<PyWorldBatch>(m, "WorldBatch")
      .def(py::init([](const PyWorld& world, const std::vector<PyBody>& bodies, const Triple& base,
                       const py::object& drive, const std::vector<int>& columns,
                       const PyLidar& lidar, int count, int threads) {
             const BatchRobot robot = ToRobot(bodies, base, drive, columns, lidar);
             return std::unique_ptr<PyWorldBatch>(
                 new PyWorldBatch{{*world.world, robot, count, threads}});
           }),
           py::arg("world"), py::kw_only(), py::arg("bodies"), py::arg("base"), py::arg("drive"),
           py::arg("columns"), py::arg("lidar"), py::arg("count"), py::arg("threads"))
      .def_property_readonly("beams", [](const PyWorldBatch& self) { return self.batch.beams(); })
      .def("step", &Step, py::arg("actions").noconvert(), py::arg("substeps"), py::arg("dt"),
           py::arg("out"))
      .def("reset", &Reset, py::arg("mask").noconvert().none(true),
           py::arg("poses").noconvert().none(true), py::arg("out"))
      .def("observe", &Observe, py::arg("out"));
}

}  // namespace flatland
