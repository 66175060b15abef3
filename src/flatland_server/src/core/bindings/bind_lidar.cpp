/// BeamFan and Lidar in Python, and scans from any pose. They release the GIL.

#include <algorithm>

#include "bindings/bindings.hpp"
#include "bindings/fast_method.hpp"

namespace flatland {
namespace {

py::tuple Scan(const PyWorld& self, const BeamFan& fan, const Pose& pose, double range,
               LayerBits layers, LayerBits reflectance_layers) {
  Array<float> ranges(fan.size());
  Array<float> intensities(fan.size());
  float* ranges_out = ranges.mutable_data();
  float* intensities_out = intensities.mutable_data();
  {
    const World::AccessGuard guard(*self.world);
    const ReleasedGil release;
    self.world->lidars().Scan(fan, pose, {range, layers, reflectance_layers, 0.0, {}}, ranges_out,
                              intensities_out, guard);
  }
  return py::make_tuple(ranges, intensities);
}

const Lidar& ScanReleased(PyLidar& self, const World::AccessGuard& guard) {
  const ReleasedGil release;
  return self.world->lidars().Scan(self.handle, guard);
}

/// Copied here, since NumPy's own copy would release the GIL, and cost more than a small scan.
Array<float> CopyOf(const std::vector<float>& values) {
  Array<float> array(static_cast<py::ssize_t>(values.size()));
  std::copy(values.begin(), values.end(), array.mutable_data());
  return array;
}

// The guards are held until the arrays are copied: as soon as they are released, another thread may
// change the world.

py::tuple ScanLidar(PyLidar& self) {
  const World::AccessGuard guard(*self.world);
  const Lidar& lidar = ScanReleased(self, guard);
  return py::make_tuple(CopyOf(lidar.ranges), CopyOf(lidar.intensities));
}

Array<float> RangesOf(PyLidar& self) {
  const World::AccessGuard guard(*self.world);
  return CopyOf(ScanReleased(self, guard).ranges);
}

}  // namespace

void BindLidar(py::module_& m) {
  py::class_<BeamFan, std::shared_ptr<BeamFan>>(m, "BeamFan")
      .def(py::init<double, double, int>(), py::arg("angle_min"), py::arg("increment"),
           py::arg("count"))
      .def("__len__", &BeamFan::size);
  py::class_<PyLidar> lidar(m, "Lidar");
  lidar.def("expect_scan", [](PyLidar& self) { self.world->lidars().Expect(self.handle); })
      .def("scan", &ScanLidar);
  DefineFast<&RangesOf>(lidar, "ranges");
}

void BindLidarsOf(py::class_<PyBody>& body) {
  body.def(
      "add_lidar",
      [](PyBody& self, const std::shared_ptr<BeamFan>& fan, const Pose& pose, double range,
         LayerBits layers, LayerBits reflectance_layers, double range_min,
         const std::vector<PyBody>& ignored) {
        LidarSettings settings{fan, pose, {range, layers, reflectance_layers, range_min, {}}};
        for (const PyBody& each : ignored) settings.scan.ignored.push_back(each.handle);
        return PyLidar{self.world, self.world->lidars().Add(self.handle, settings)};
      },
      py::arg("fan"), py::arg("pose"), py::arg("range"), py::arg("layers") = kAllLayers,
      py::arg("reflectance_layers") = 0, py::arg("range_min") = 0.0,
      py::arg("ignored") = std::vector<PyBody>());
}

void BindScansOf(py::class_<PyWorld>& world) {
  world.def("scan", &Scan, py::arg("fan"), py::arg("pose"), py::arg("range"),
            py::arg("layers") = kAllLayers, py::arg("reflectance_layers") = 0);
}

}  // namespace flatland
