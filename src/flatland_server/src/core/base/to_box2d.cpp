#include "base/to_box2d.hpp"

#include <algorithm>
#include <vector>

namespace flatland {

// Joints compare the angles of their bodies, and would react if only one of them made a whole
// rotation. So a rotation of more than half a turn is replaced by the equivalent one of less. Half
// a turn itself, up to rounding, keeps its direction.
void Place(b2Body& body, const Pose& pose) {
  constexpr double kRoundingMargin = 1e-3;  // [rad]
  double rotation = pose.yaw - body.GetAngle();
  if (std::abs(rotation) > M_PI + kRoundingMargin) {
    rotation = std::remainder(rotation, 2.0 * M_PI);
  }
  body.SetTransform(ToBox2D({pose.x, pose.y}), static_cast<float>(body.GetAngle() + rotation));
}

void AddRotations(b2Body& body, float count) {
  std::vector<b2Body*> group{&body};
  for (size_t i = 0; i < group.size(); ++i) {
    b2Body& member = *group[i];
    member.SetTransform(member.GetPosition(), member.GetAngle() + count * kFullRotation);
    for (b2JointEdge* edge = member.GetJointList(); edge != nullptr; edge = edge->next) {
      const b2JointType type = edge->joint->GetType();
      const bool compares =
          type == e_weldJoint ||
          (type == e_revoluteJoint && static_cast<b2RevoluteJoint*>(edge->joint)->IsLimitEnabled());
      const bool is_new = std::find(group.begin(), group.end(), edge->other) == group.end();
      if (compares && is_new) group.push_back(edge->other);
    }
  }
}

void WakeBodiesNear(const b2Body& body) {
  if (body.GetType() != b2_staticBody) return;
  struct Waker : b2QueryCallback {
    bool ReportFixture(b2Fixture* fixture) override {
      fixture->GetBody()->SetAwake(true);
      return true;
    }
  } waker;
  for (const b2Fixture* f = body.GetFixtureList(); f != nullptr; f = f->GetNext()) {
    body.GetWorld()->QueryAABB(&waker, f->GetAABB(0));
  }
}

}  // namespace flatland
