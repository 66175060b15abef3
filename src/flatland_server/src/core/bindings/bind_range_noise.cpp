/// RangeNoise in Python: for one scan, and for those of many environments.

#include <algorithm>
#include <array>
#include <optional>

#include "bindings/bindings.hpp"
#include "sight/range_noise.hpp"

namespace flatland {
namespace {

Array<float> WithNoise(const RangeNoise& self, const Array<float>& ranges, int64_t nanoseconds) {
  Array<float> result(ranges.size());
  std::copy(ranges.data(), ranges.data() + ranges.size(), result.mutable_data());
  self.AddTo(result.mutable_data(), static_cast<int>(result.size()), nanoseconds);
  return result;
}

void AddToRows(const RangeNoise& self, Array<float> ranges, const Array<uint64_t>& keys,
               const Array<int64_t>& nanoseconds, const std::optional<Array<bool>>& mask,
               const std::optional<Array<double>>& settings) {
  const py::ssize_t rows = ranges.ndim() == 2 ? ranges.shape(0) : -1;
  if (rows != keys.size() || rows != nanoseconds.size() || (mask && mask->size() != rows) ||
      (settings && settings->size() != 3 * rows)) {
    throw std::invalid_argument(
        "expected ranges (n, beams), n keys, times and booleans, and settings (n, 3)");
  }
  float* row = ranges.mutable_data();
  const auto beams = static_cast<int>(ranges.shape(1));
  const ReleasedGil release;
  for (py::ssize_t k = 0; k < rows; ++k, row += beams) {
    if (mask && !mask->data()[k]) continue;
    const uint64_t key = keys.data()[k];
    const double* const own = settings ? settings->data() + 3 * k : nullptr;
    const RangeNoise noise = own ? RangeNoise(key, own[0], own[1], own[2]) : self.WithKey(key);
    noise.AddTo(row, beams, nanoseconds.data()[k]);
  }
}

}  // namespace

void BindRangeNoise(py::module_& m) {
  py::class_<RangeNoise>(m, "RangeNoise")
      .def(py::init<uint64_t, double, double, double>(), py::arg("key"), py::arg("std_dev"),
           py::arg("max_range"), py::arg("min_range") = 0.0)
      .def_property_readonly("key", &RangeNoise::key)
      .def_property_readonly(
          "settings",
          [](const RangeNoise& self) {
            return std::array<double, 3>{self.std_dev(), self.max_range(), self.min_range()};
          })
      .def("__call__", &WithNoise, py::arg("ranges").noconvert(), py::arg("nanoseconds"))
      .def("add_to_rows", &AddToRows, py::arg("ranges").noconvert(), py::arg("keys").noconvert(),
           py::arg("nanoseconds").noconvert(), py::arg("mask").noconvert().none(true),
           py::arg("settings").noconvert() = py::none());
}

}  // namespace flatland
