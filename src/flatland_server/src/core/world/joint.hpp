#pragma once

/// Joints: how two bodies are connected.

#include <optional>
#include <utility>

#include "base/geometry.hpp"

namespace flatland {

/// A joint keeps `anchor_a` of body a and `anchor_b` of body b at the same point.
struct JointSettings {
  Vec2 anchor_a;                   ///< in the frame of body a [m]
  Vec2 anchor_b;                   ///< in the frame of body b [m]
  bool collide_connected = false;  ///< true if the two bodies collide with each other
};

/// Lower and upper limit of the angle of b minus that of a [rad].
using JointLimits = std::pair<double, double>;

/// Turns b relative to a, with no more torque than it needs.
struct JointMotor {
  double speed = 0.0;       ///< [rad/s]
  double max_torque = 0.0;  ///< [N m]
};

/// A hinge.
struct RevoluteSettings : JointSettings {
  std::optional<JointLimits> limits;  ///< none: it rotates freely
};

/// Fixes the relative pose of two bodies, rigidly or by a spring.
struct WeldSettings : JointSettings {
  double angle = 0.0;      ///< angle of b minus that of a [rad]
  double frequency = 0.0;  ///< of the spring [Hz]; 0 is rigid
  double damping = 0.0;    ///< damping ratio of the spring; 1 is critical
};

}  // namespace flatland
