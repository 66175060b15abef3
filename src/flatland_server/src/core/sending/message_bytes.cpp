#include "sending/message_bytes.hpp"

#include <cmath>
#include <cstring>
#include <stdexcept>
#include <string>

namespace flatland {

static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "numbers are copied as they are");

template <class Number, std::size_t kCount>
void MessageBytes::Set(std::size_t at, const Number (&numbers)[kCount]) {
  if (at > data_.size() || sizeof(numbers) > data_.size() - at) {
    throw std::out_of_range("expected " + std::to_string(at) + " + " +
                            std::to_string(sizeof(numbers)) +
                            " bytes of a message or more, found " + std::to_string(data_.size()));
  }
  std::memcpy(data_.data() + at, numbers, sizeof(numbers));
}

void MessageBytes::SetHeader(std::size_t at, uint32_t sequence, int64_t nanoseconds) {
  const int64_t stamp = nanoseconds + stamp_offset;
  Set<uint32_t, 3>(at, {sequence, static_cast<uint32_t>(stamp / 1000000000),
                        static_cast<uint32_t>(stamp % 1000000000)});
}

void MessageBytes::SetPose(std::size_t at, const Pose& pose) {
  const double half = pose.yaw / 2;
  Set<double, 7>(at, {pose.x, pose.y, 0.0, 0.0, 0.0, std::sin(half), std::cos(half)});
}

void MessageBytes::SetTwist(std::size_t at, const Twist& twist) {
  Set<double, 6>(at, {twist.vx, twist.vy, 0.0, 0.0, 0.0, twist.omega});
}

void MessageBytes::SetTurnedTwist(std::size_t at, const Twist& twist, double yaw) {
  const Vec2 turned = Rotation(yaw).Apply({twist.vx, twist.vy});
  SetTwist(at, {turned.x, turned.y, twist.omega});
}

}  // namespace flatland
