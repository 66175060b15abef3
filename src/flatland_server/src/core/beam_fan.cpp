#include "flatland_server/beam_fan.hpp"

#include <stdexcept>

namespace flatland {

BeamFan::BeamFan(double angle_min, double increment, int count)
    : angle_min_(angle_min), increment_(increment) {
  if (!IsUsable(angle_min) || !IsUsable(increment)) {
    throw std::invalid_argument("a beam's angle must be finite");
  }
  if (count < 1) throw std::invalid_argument("a fan needs at least one beam");
  if (count > 1 && increment == 0.0) {
    throw std::invalid_argument("the angle between beams must not be zero");
  }
  directions_.reserve(count);
  for (int beam = 0; beam < count; ++beam) {
    const double angle = angle_min + beam * increment;
    directions_.push_back({std::cos(angle), std::sin(angle)});
  }
}

}  // namespace flatland
