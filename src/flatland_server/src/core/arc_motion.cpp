#include "flatland_server/arc_motion.hpp"

#include <algorithm>
#include <limits>

#include "to_box2d.hpp"

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

/// How far something is from where it is due, or 0 if that is more than rounding can have done.
double LostByRounding(double due, double is) {
  const double most = std::numeric_limits<float>::epsilon() * std::max(1.0, std::abs(due));
  return std::abs(due - is) <= most ? due - is : 0.0;
}

}  // namespace

void ArcMotion::Begin(b2Body& body, const Twist& mean, double dt) {
  if (mean.vx == 0.0 && mean.vy == 0.0 && mean.omega == 0.0) behind_ = {};
  const Displacement displacement(mean, dt);
  const Rotation heading(body.GetAngle() + behind_.yaw);
  const auto way_of = [&](const b2Body& member) {
    const b2Vec2 center = body.GetLocalPoint(member.GetWorldCenter());
    return Vec2{behind_.x, behind_.y} + heading.Apply(displacement.Of(FromBox2D(center)));
  };
  const double turn = behind_.yaw + displacement.angle;
  group_.assign(1, &body);
  for (size_t i = 0; i < group_.size(); ++i) {
    b2Body& member = *group_[i];
    member.SetLinearVelocity(ToBox2D(1.0 / dt * way_of(member)));
    member.SetAngularVelocity(static_cast<float>(turn / dt));
    for (b2JointEdge* edge = member.GetJointList(); edge != nullptr; edge = edge->next) {
      b2Body& other = *edge->other;
      if (other.GetType() != b2_dynamicBody) continue;
      if (IsRigid(*edge->joint)) {
        if (std::find(group_.begin(), group_.end(), &other) == group_.end()) {
          group_.push_back(&other);
        }
      } else if (IsWheel(*edge->joint, other)) {
        other.SetLinearVelocity(ToBox2D(1.0 / dt * way_of(other)));
      }
    }
  }
  told_velocity_ = body.GetLinearVelocity();
  told_omega_ = body.GetAngularVelocity();
  const Vec2 due = FromBox2D(body.GetWorldCenter()) + way_of(body);
  due_ = {due.x, due.y, body.GetAngle() + turn};
}

void ArcMotion::End(b2Body& body, const Twist& at_end) {
  const b2Vec2 lost = told_velocity_ - body.GetLinearVelocity();
  const float lost_omega = told_omega_ - body.GetAngularVelocity();
  const bool is_hindered = lost.Length() > 0.1f * told_velocity_.Length() + 1e-3f ||
                           std::abs(lost_omega) > 0.1f * std::abs(told_omega_) + 1e-3f;
  behind_ = {};
  if (is_hindered) return;
  const b2Vec2 center = body.GetWorldCenter();
  behind_ = {LostByRounding(due_.x, center.x), LostByRounding(due_.y, center.y),
             LostByRounding(due_.yaw, body.GetAngle())};
  const Vec2 arm = FromBox2D(body.GetLocalCenter());
  const Vec2 of_center =
      Rotation(body.GetAngle())
          .Apply({at_end.vx - at_end.omega * arm.y, at_end.vy + at_end.omega * arm.x});
  body.SetLinearVelocity(ToBox2D(of_center) - lost);
  body.SetAngularVelocity(static_cast<float>(at_end.omega) - lost_omega);
}

}  // namespace flatland
