#pragma once

/// The bytes of a message in which only times, poses and velocities change.
///
/// Need: a robot sends odometry and transforms at every step. Most of their bytes are constant:
/// names of frames, covariances, zeros. Python takes microseconds to fill in the rest.
///
/// Data: little-endian, as messages are sent and recorded. A header begins with three uint32:
/// sequence number, seconds, nanoseconds. A pose is seven doubles: position and quaternion. A twist
/// is six: linear and angular velocity.

#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>

#include "base/geometry.hpp"

namespace flatland {

/// The difference between stamps and simulated time [ns], of all messages of this process.
inline int64_t stamp_offset = 0;

class MessageBytes {
 public:
  explicit MessageBytes(std::string data) : data_(std::move(data)) {}

  const std::string& data() const { return data_; }

  // Each throws std::out_of_range if the data ends before the field does. The time is simulated.
  void SetHeader(std::size_t at, uint32_t sequence, int64_t nanoseconds);
  void SetPose(std::size_t at, const Pose& pose);
  void SetTwist(std::size_t at, const Twist& twist);
  /// The same with a twist in the frame of a body, turned into the frame in which its yaw is given.
  void SetTurnedTwist(std::size_t at, const Twist& twist, double yaw);

 private:
  template <class Number, std::size_t kCount>
  void Set(std::size_t at, const Number (&numbers)[kCount]);

  std::string data_;
};

}  // namespace flatland
