#pragma once

/// The body of a steered wheel, which is rotated to show the steering angle.

#include <box2d/box2d.h>

namespace flatland {

/// Places the wheel that a joint holds to `body` at an angle to it [rad], as far as the joint's
/// limits allow, moving with the body.
void PlaceSteeredWheel(b2RevoluteJoint& joint, const b2Body& body, double angle);

}  // namespace flatland
