#include "motion/arc_motion.hpp"

#include <algorithm>
#include <limits>
#include <vector>

#include "base/to_box2d.hpp"

namespace flatland {
namespace {

/// Motion of a body in a step: a translation of its origin, in its frame, and a rotation by `angle`
/// about its origin. With a constant twist (vx, vy, omega) in its own frame a frame moves by the
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

/// True if a joint holds two bodies together without a spring.
bool IsRigid(b2Joint& joint) {
  return joint.GetType() == e_weldJoint && static_cast<b2WeldJoint&>(joint).GetStiffness() == 0.0f;
}

/// True if a joint lets b rotate about its own centre, as a wheel does.
bool IsWheel(b2Joint& joint, const b2Body& b) {
  if (joint.GetType() != e_revoluteJoint) return false;
  const b2Vec2 hub = joint.GetBodyB() == &b ? joint.GetAnchorB() : joint.GetAnchorA();
  return b2DistanceSquared(hub, b.GetWorldCenter()) < 1e-6f;
}

/// Difference of a target from the actual value, or 0 if it is too large for a rounding error.
double RoundingError(double target, double actual) {
  const double most = std::numeric_limits<float>::epsilon() * std::max(1.0, std::abs(target));
  return std::abs(target - actual) <= most ? target - actual : 0.0;
}

}  // namespace

void ArcMotion::Begin(b2Body& body, const Twist& mean, double dt, Grip* grip) {
  if (mean.vx == 0.0 && mean.vy == 0.0 && mean.omega == 0.0) rounding_error_ = {};
  const Displacement displacement(mean, dt);
  const Rotation heading(body.GetAngle() + rounding_error_.yaw);
  const auto displacement_of = [&](const b2Body& member) {
    const b2Vec2 center = body.GetLocalPoint(member.GetWorldCenter());
    return Vec2{rounding_error_.x, rounding_error_.y} +
           heading.Apply(displacement.Of(FromBox2D(center)));
  };
  const double rotation = rounding_error_.yaw + displacement.angle;
  double mass = 0.0;
  const auto carry = [&](b2Body& member, bool turns) {
    mass += member.GetMass();
    if (grip != nullptr) return;
    member.SetLinearVelocity(ToBox2D(1.0 / dt * displacement_of(member)));
    if (turns) member.SetAngularVelocity(static_cast<float>(rotation / dt));
  };
  carry(body, true);
  if (body.GetJointList() != nullptr) {
    thread_local std::vector<b2Body*> group;  // keeps its memory
    group.assign(1, &body);
    for (size_t i = 0; i < group.size(); ++i) {
      for (b2JointEdge* edge = group[i]->GetJointList(); edge != nullptr; edge = edge->next) {
        b2Body& other = *edge->other;
        if (other.GetType() != b2_dynamicBody) continue;
        if (IsRigid(*edge->joint)) {
          if (std::find(group.begin(), group.end(), &other) != group.end()) continue;
          group.push_back(&other);
          carry(other, true);
        } else if (IsWheel(*edge->joint, other)) {
          carry(other, false);
        }
      }
    }
  }
  commanded_velocity_ = body.GetLinearVelocity();
  commanded_omega_ = body.GetAngularVelocity();
  if (grip != nullptr) {
    commanded_velocity_ = ToBox2D(1.0 / dt * displacement_of(body));
    commanded_omega_ = static_cast<float>(rotation / dt);
    body.SetLinearVelocity(body.GetLinearVelocity() - shown_);
    body.SetAngularVelocity(body.GetAngularVelocity() - shown_omega_);
    grip->Begin(body, mass, commanded_velocity_, commanded_omega_, dt);
    if (mean.vx != 0.0 || mean.vy != 0.0 || mean.omega != 0.0) body.SetAwake(true);
  }
  const Vec2 target = FromBox2D(body.GetWorldCenter()) + displacement_of(body);
  target_ = {target.x, target.y, body.GetAngle() + rotation};
}

void ArcMotion::End(b2Body& body, const Twist& at_end, Grip* grip) {
  if (grip != nullptr) grip->End();
  const b2Vec2 lost = commanded_velocity_ - body.GetLinearVelocity();
  const float lost_omega = commanded_omega_ - body.GetAngularVelocity();
  const bool is_obstructed = lost.Length() > 0.1f * commanded_velocity_.Length() + 1e-3f ||
                             std::abs(lost_omega) > 0.1f * std::abs(commanded_omega_) + 1e-3f;
  rounding_error_ = {};
  shown_ = b2Vec2_zero;
  shown_omega_ = 0.0f;
  if (is_obstructed) return;
  const b2Vec2 center = body.GetWorldCenter();
  rounding_error_ = {RoundingError(target_.x, center.x), RoundingError(target_.y, center.y),
                     RoundingError(target_.yaw, body.GetAngle())};
  const Vec2 arm = FromBox2D(body.GetLocalCenter());
  const Vec2 of_center =
      Rotation(body.GetAngle())
          .Apply({at_end.vx - at_end.omega * arm.y, at_end.vy + at_end.omega * arm.x});
  if (grip != nullptr) {
    shown_ = ToBox2D(of_center) - commanded_velocity_;
    shown_omega_ = static_cast<float>(at_end.omega) - commanded_omega_;
  }
  body.SetLinearVelocity(ToBox2D(of_center) - lost);
  body.SetAngularVelocity(static_cast<float>(at_end.omega) - lost_omega);
}

}  // namespace flatland
