#include "flatland_server/arc_motion.hpp"

#include <algorithm>

namespace flatland {
namespace {

/// How a body moves in a step: by `translation` at its origin, in its frame, and by a turn of
/// `angle` about it. With a constant twist (vx, vy, omega) in its own frame a frame moves by the
/// exponential map of SE(2): by V (vx, vy) dt, V = [[s, -c], [c, s]] with s = sin(a) / a,
/// c = (1 - cos(a)) / a, a = omega dt (Lynch and Park, "Modern Robotics", 3.3.3).
struct Displacement {
  Displacement(const Twist& twist, double dt) : angle(twist.omega * dt), rotation(angle) {
    const bool straight = std::abs(angle) < 1e-6;
    const double s = straight ? 1.0 : std::sin(angle) / angle;
    const double c = straight ? 0.5 * angle : (1.0 - std::cos(angle)) / angle;
    translation = {(s * twist.vx - c * twist.vy) * dt, (c * twist.vx + s * twist.vy) * dt};
  }

  Vec2 Of(Vec2 point) const { return translation + rotation.Apply(point) - point; }

  double angle;
  Rotation rotation;
  Vec2 translation;
};

/// Whether a joint holds two bodies together without any spring.
bool IsRigid(b2Joint& joint) {
  return joint.GetType() == e_weldJoint && static_cast<b2WeldJoint&>(joint).GetStiffness() == 0.0f;
}

/// Whether a joint lets b turn about its own centre, as a wheel does.
bool IsWheel(b2Joint& joint, const b2Body& b) {
  if (joint.GetType() != e_revoluteJoint) return false;
  const b2Vec2 hub = joint.GetBodyB() == &b ? joint.GetAnchorB() : joint.GetAnchorA();
  return b2DistanceSquared(hub, b.GetWorldCenter()) < 1e-6f;
}

}  // namespace

void ArcMotion::Begin(b2Body& body, const Twist& mean, double dt) {
  const Displacement displacement(mean, dt);
  const Rotation heading(body.GetAngle());
  group_.assign(1, &body);
  const auto move = [&](b2Body& member) {
    const b2Vec2 center = body.GetLocalPoint(member.GetWorldCenter());
    const Vec2 moves = heading.Apply(displacement.Of({center.x, center.y}));
    member.SetLinearVelocity({static_cast<float>(moves.x / dt), static_cast<float>(moves.y / dt)});
  };
  for (size_t i = 0; i < group_.size(); ++i) {
    b2Body& member = *group_[i];
    move(member);
    member.SetAngularVelocity(static_cast<float>(mean.omega));
    for (b2JointEdge* edge = member.GetJointList(); edge != nullptr; edge = edge->next) {
      if (edge->other->GetType() != b2_dynamicBody) continue;
      if (IsRigid(*edge->joint)) {
        if (std::find(group_.begin(), group_.end(), edge->other) == group_.end()) {
          group_.push_back(edge->other);
        }
      } else if (IsWheel(*edge->joint, *edge->other)) {
        move(*edge->other);
      }
    }
  }
  told_velocity_ = body.GetLinearVelocity();
  told_omega_ = body.GetAngularVelocity();
}

void ArcMotion::End(b2Body& body, const Twist& at_end) const {
  const b2Vec2 missed = body.GetLinearVelocity() - told_velocity_;
  const bool is_hindered =
      missed.Length() > 0.1f * told_velocity_.Length() + 1e-3f ||
      std::abs(body.GetAngularVelocity() - told_omega_) > 0.1f * std::abs(told_omega_) + 1e-3f;
  if (is_hindered) return;
  const b2Vec2 arm = body.GetLocalCenter();
  const Vec2 of_center =
      Rotation(body.GetAngle())
          .Apply({at_end.vx - at_end.omega * arm.y, at_end.vy + at_end.omega * arm.x});
  body.SetLinearVelocity({static_cast<float>(of_center.x), static_cast<float>(of_center.y)});
  body.SetAngularVelocity(static_cast<float>(at_end.omega));
}

}  // namespace flatland
