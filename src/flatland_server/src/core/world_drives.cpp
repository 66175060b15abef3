/// World: drives and tweens.

#include "box2d_limits.hpp"
#include "flatland_server/world.hpp"
#include "to_box2d.hpp"

namespace flatland {
namespace {

constexpr char kNotALayer[] = "a layer cannot be moved";

}  // namespace

World::Drive World::AddDrive(Body body, const DynamicsLimits& linear,
                             const DynamicsLimits& angular) {
  Find(body);
  const AccessGuard guard(*this);
  Require(!bodies_.Get(body).is_layer, kNotALayer);
  return drives_.Add({body, BodyDrive(linear, angular)});
}

World::Tricycle World::AddTricycle(Body body, Joint front_wheel, const TricycleSettings& settings) {
  const b2Body& base = Find(body);
  const AccessGuard guard(*this);
  b2Joint* joint = joints_.Get(front_wheel);
  Require(joint->GetType() == e_revoluteJoint &&
              (joint->GetBodyA() == &base || joint->GetBodyB() == &base),
          "the front wheel's joint must be a revolute joint of the driven body");
  return tricycles_.Add({body, TricycleDrive(settings, static_cast<b2RevoluteJoint*>(joint))});
}

World::Tween World::AddTween(Body body, const TweenSettings& settings) {
  const Pose start = GetPose(body);
  const AccessGuard guard(*this);
  Require(!bodies_.Get(body).is_layer, kNotALayer);
  LetMove(body);
  return tweens_.Add({body, BodyTween(settings, start)});
}

/// Before the solver: gives the body the velocity that leads to the tween's next pose, so that the
/// solver lets it push others. A jump back to the start has none.
void World::AdvanceTween(BodyTween& tween, b2Body& body, double dt) {
  const Pose from = tween.target();
  const Pose to = tween.Advance(dt);
  const Twist velocity = tween.teleports()
                             ? Twist{}
                             : Twist{(to.x - body.GetPosition().x) / dt,
                                     (to.y - body.GetPosition().y) / dt, (to.yaw - from.yaw) / dt};
  SetOriginVelocity(body, velocity);
}

/// After the solver: places the body at the tween's pose exactly.
void World::FinishTween(BodyTween& tween, b2Body& body, double dt) {
  const double omega = body.GetAngularVelocity();
  const Vec2 of_center = FromBox2D(body.GetLinearVelocity());
  const Vec2 arm = Rotation(body.GetAngle() - omega * dt).Apply(FromBox2D(body.GetLocalCenter()));
  Place(body, tween.target());
  SetOriginVelocity(body, {of_center.x + omega * arm.y, of_center.y - omega * arm.x, omega});
  WakeBodiesNear(body);
}

}  // namespace flatland
