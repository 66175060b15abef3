#pragma once

/// The physical world: bodies with fixtures, joints, drives, lidars and contacts, on Box2D.
///
/// Handles. Bodies, joints, drives, tweens and lidars are named by handles. The handle of something
/// that has been removed is recognised: each function throws GoneError for it.
///
/// Values. Each function throws std::invalid_argument, and changes nothing, for a value that Box2D
/// cannot compute with: one that is not finite, a radius of zero, a polygon without area.
///
/// Layers. A fixture belongs to a set of collision layers. Two fixtures collide if they share a
/// layer and both collide at all. A lidar sees the fixtures that share a layer with it, whether
/// they collide or not, but no sensors.
///
/// Threads. A world is used by one thread at a time, marked by an AccessGuard: each function throws
/// std::logic_error if another thread holds one. A contact listener runs on the stepping thread,
/// within the guard of the step; what it may do is said at ContactListener.

#include <box2d/box2d.h>

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/access.hpp"
#include "people/crowd.hpp"
#include "sight/lidars.hpp"
#include "world/bodies.hpp"
#include "world/contacts.hpp"
#include "world/joint.hpp"
#include "world/mechanisms.hpp"

namespace flatland {

class Layers;
struct Setting;
class NearbyWalls;
struct WorldState;

class World : public Access, private b2DestructionListener {
 public:
  using Body = Bodies::Body;
  using Joint = Handle<b2Joint*>;
  using Drive = Handle<Mounted<BodyDrive>>;
  using Tricycle = Handle<Mounted<TricycleDrive>>;
  using Ackermann = Handle<Mounted<AckermannDrive>>;
  using Tween = Handle<Mounted<BodyTween>>;
  using Drift = Handle<Mounted<BodyDrift>>;
  using LidarHandle = Lidars::LidarHandle;
  using CrowdHandle = Handle<Crowd>;

  /// Box2D is given the walls up to this far beyond what a body will reach in its next step [m].
  static constexpr float kRoom = 0.3f;

  /// Solver iterations per step, each 1 or more.
  World(int velocity_iterations, int position_iterations, float room = kRoom);
  ~World();

  /// A world that makes the same steps from here on, bit for bit. Handles name the same things in
  /// both. The copy has no drifts, no contact listener, and no chosen contact events.
  std::unique_ptr<World> Copy() const;

  // ---- Bodies ----

  Body AddBody(const BodySettings& settings);
  /// Adds a static body of two-sided walls [m], one fixture each, that cannot be moved or removed.
  /// Box2D has those near dynamic bodies. `progress` is called with their number so far, about
  /// every 50,000 and at the end.
  Body AddLayer(std::vector<Segment> walls, LayerBits layers,
                const std::function<void(std::size_t added)>& progress = {});
  /// Also removes its fixtures, joints, drives, tweens and lidars.
  void RemoveBody(Body body);
  bool Contains(Body body) const { return bodies_.Contains(body); }
  /// Number of bodies, layers included.
  int body_count() const;
  /// Number of walls that Box2D has at present: those near dynamic bodies.
  int held_wall_count() const;
  b2BodyType GetType(Body body) const { return Find(body).GetType(); }
  /// True if Box2D simulates it; a body at rest falls asleep.
  bool IsAwake(Body body) const { return Find(body).IsAwake(); }

  // Pose of the body's origin.

  /// In the world [m, m, rad]; the yaw is not wrapped to [-pi, pi].
  Pose GetPose(Body body) const;
  /// In the frame of another body [m, m, rad]; the yaw is the difference of two wrapped yaws.
  Pose GetPoseIn(Body reference, Body body) const;
  /// Moves the body [m, m, rad] and wakes it; its velocity stays.
  void SetPose(Body body, const Pose& pose);

  // Velocity of the body's origin.

  /// In the world's frame [m/s, m/s, rad/s].
  Twist GetVelocity(Body body) const;
  void SetVelocity(Body body, const Twist& velocity);
  /// In the body's frame [m/s, m/s, rad/s].
  Twist GetLocalVelocity(Body body) const;
  /// Velocity of the body at a point of the world [m], in the world's frame [m/s].
  Vec2 GetVelocityAt(Body body, Vec2 point) const;
  /// Sets the velocities of the body and its drives, and their commands, to zero.
  void Halt(Body body);

  // Conversion between the body's frame (local) and the world's.

  Vec2 ToWorldPoint(Body body, Vec2 point) const;
  Vec2 ToLocalPoint(Body body, Vec2 point) const;
  Vec2 ToWorldVector(Body body, Vec2 vector) const;
  Vec2 ToLocalVector(Body body, Vec2 vector) const;

  // Mass [kg], and moment of inertia about the centre of mass [kg m^2]; 0 unless dynamic.

  double GetMass(Body body) const;
  double GetInertia(Body body) const;
  /// Centre of mass, in the world [m].
  Vec2 GetCenter(Body body) const;
  /// The same in the body's frame.
  Vec2 GetLocalCenter(Body body) const;
  /// Gives a dynamic body another mass than that of its fixtures, until it gets a fixture or
  /// another shape. Without `center`, that stays where it is in the body's frame [m]; without
  /// `inertia`, that grows in proportion to the mass. The velocity of the origin stays. If a
  /// contact listener calls this, it takes effect at the end of the step.
  void SetMass(Body body, double mass, std::optional<double> inertia = std::nullopt,
               std::optional<Vec2> center = std::nullopt);
  /// Gives a dynamic body the mass of its fixtures.
  void ResetMass(Body body);

  // Forces, at a point of the world [m] or else at the centre of mass. They wake the body.

  /// Force during the next step [N].
  void ApplyForce(Body body, Vec2 force, std::optional<Vec2> point = std::nullopt);
  /// Torque during the next step [N m].
  void ApplyTorque(Body body, double torque);
  /// Immediate change of momentum [N s].
  void ApplyLinearImpulse(Body body, Vec2 impulse, std::optional<Vec2> point = std::nullopt);
  /// Immediate change of angular momentum [N m s].
  void ApplyAngularImpulse(Body body, double impulse);

  // ---- Fixtures ----

  /// Adds a disc, in the body's frame; centre and radius in m.
  Fixture AddCircle(Body body, Vec2 center, double radius, const FixtureSettings& settings);
  /// Adds the convex hull of 3 to 8 vertices, in the body's frame [m].
  Fixture AddPolygon(Body body, const std::vector<Vec2>& vertices, const FixtureSettings& settings);
  /// Replaces the shape of a body's fixture by a disc, in the body's frame [m], and its layers if
  /// they are given. The material stays, and the body's mass follows. The fixture's contacts end,
  /// and the next step finds the new ones. Throws std::invalid_argument for a wall.
  void SetCircle(Fixture fixture, Vec2 center, double radius,
                 std::optional<LayerBits> layers = std::nullopt);
  /// The same by the convex hull of 3 to 8 vertices.
  void SetPolygon(Fixture fixture, const std::vector<Vec2>& vertices,
                  std::optional<LayerBits> layers = std::nullopt);
  /// Number of fixtures of a body; their indices are 0 to count - 1.
  int GetFixtureCount(Body body) const;
  FixtureSettings GetSettings(Fixture fixture) const;
  /// Sets a coefficient for new contacts; existing ones keep theirs.
  void SetFriction(Fixture fixture, double friction);
  void SetRestitution(Fixture fixture, double restitution);
  /// Sets whether lidars see it; not for walls.
  void SetVisible(Fixture fixture, bool visible);
  /// The radius of a circle as lidars see it [m]; its own, until it is set.
  double GetSeenRadius(Fixture fixture) const;
  void SetSeenRadius(Fixture fixture, double radius);
  /// True if a point of the world [m] is within the shape; always false for a wall.
  bool TestPoint(Fixture fixture, Vec2 point) const;
  /// The other bodies with a fixture that overlaps one of this body, and that Box2D would push out
  /// of it: both collide, share a layer and are no sensors, and one of the bodies is dynamic. Each
  /// body once; shapes that touch overlap.
  std::vector<Body> GetOverlappingBodies(Body body) const;
  /// The distance of these bodies from the nearest wall or other body that a fixture of them can
  /// touch [m], or `limit` if none is nearer: both collide, share a layer and are no sensors.
  double GetClearance(const std::vector<Body>& bodies, double limit) const;

  // ---- Joints ----

  Joint AddRevolute(Body a, Body b, const RevoluteSettings& settings);
  Joint AddWeld(Body a, Body b, const WeldSettings& settings);
  /// True if the joint still exists: until one of its bodies is removed.
  bool Contains(Joint joint) const { return joints_.Contains(joint); }
  int joint_count() const { return world_->GetJointCount() - grip_count(); }
  /// The number of drives of limited force.
  int grip_count() const {
    int count = 0;
    ForEachGrip([&](Body, const Grip&) { ++count; });
    return count;
  }
  /// Angle of b minus that of a, minus a weld's reference angle, within [-pi, pi] [rad].
  double GetJointAngle(Joint joint) const;
  /// The rate of that angle [rad/s].
  double GetJointSpeed(Joint joint) const;

  // Of a revolute joint: each throws std::invalid_argument for a weld. What a contact listener sets
  // counts from the end of the step on. Both bodies wake if something changes.

  std::optional<JointLimits> GetLimits(Joint joint) const;
  /// Sets the limits of the angle of b minus that of a; without, it rotates freely. If it did so
  /// before, whole rotations are removed from its angle, which is then that of GetJointAngle. If
  /// the limits do not contain that angle, it is the equivalent angle that is nearest to their
  /// middle.
  void SetLimits(Joint joint, const std::optional<JointLimits>& limits);
  std::optional<JointMotor> GetMotor(Joint joint) const;
  void SetMotor(Joint joint, const std::optional<JointMotor>& motor);
  /// The torque of its motor on b in the last step [N m].
  double GetMotorTorque(Joint joint) const;

  // ---- Drives, tweens and drifts ----

  /// Drives the body at commanded velocities. The limits are in m/s and m/s^2, rad/s and rad/s^2.
  Drive AddDrive(Body body, const DynamicsLimits& linear, const DynamicsLimits& angular,
                 const std::optional<ActuatorSettings>& actuator = std::nullopt);
  /// Drives the body as a tricycle. `front_wheel`, a revolute joint of the body, holds the body of
  /// the front wheel, which is rotated to show the steering angle.
  Tricycle AddTricycle(Body body, Joint front_wheel, const TricycleSettings& settings);
  /// Drives the body as a car. `wheels`, revolute joints of the body, hold the bodies of the
  /// steered wheels, which are rotated to show their angles: 2 at most.
  Ackermann AddAckermann(Body body, const std::vector<Joint>& wheels,
                         const AckermannSettings& settings);
  /// Moves the body along a prescribed path, starting at its present pose.
  Tween AddTween(Body body, const TweenSettings& settings);
  /// Measures the body's motion with errors, and adds it up to an estimate of its pose. The first
  /// estimate is right. Equal keys and motions give equal errors. `period`: of updates [s].
  Drift AddDrift(Body body, const DriftVariances& variances, double period, uint64_t key);
  /// The estimated pose in the world [m, m, rad], the yaw within [-pi, pi].
  Pose GetEstimate(Drift drift) const;
  /// The drive, tween or drift of a handle.
  template <class Mechanism>
  Mechanism& Get(Handle<Mounted<Mechanism>> handle) {
    RequireAccess();
    return mechanisms_.Get(handle);
  }

  // ---- Crowds ----

  /// Adds a crowd without people. Equal keys give equal random numbers.
  CrowdHandle AddCrowd(const CrowdSettings& settings, uint64_t key);
  /// Adds a person to a crowd; its bodies are not static. It leaves when one of them is removed.
  void AddPerson(CrowdHandle crowd, const PersonSettings& person);
  /// Removes a crowd. The bodies of its people stay, and move like others.
  void RemoveCrowd(CrowdHandle crowd);
  /// See Crowd::Scatter.
  bool ScatterCrowd(CrowdHandle crowd);
  /// See Crowd::GetClearances.
  std::vector<Crowd::Clearances> GetClearances(CrowdHandle crowd);
  Crowd& Get(CrowdHandle handle) {
    RequireAccess();
    return crowds_.Get(handle);
  }

  // ---- Lidars and contacts ----

  Lidars& lidars() { return lidars_; }
  Contacts& contacts() { return contacts_; }

  // ---- Stepping ----

  /// Box2D moves no body by more than 2 m in a step, and turns none by more than pi / 2. A step in
  /// which one will be faster is divided into equal parts, kMostParts at most.
  static constexpr int kMostParts = 32;
  /// Advances the simulation by `dt` [s], 1e-9 or more.
  void Step(double dt) { Step(dt, AccessGuard(*this)); }
  void Step(double dt, const AccessGuard& guard);
  /// Makes at most `count` steps of `dt` [s] each, and at least one. Ends after a step in which the
  /// contact listener was called, so that the caller can react before the next one. Returns the
  /// number of steps.
  int StepUntilContact(double dt, int count);
  int StepUntilContact(double dt, int count, const AccessGuard& guard);
  /// Number of steps that the last call of StepUntilContact has completed; during a call of the
  /// contact listener, those before the step that is being made.
  int completed_steps() const;

  // ---- State ----

  /// The state of all that moves, as bytes: poses, velocities, pending forces, masses, contacts
  /// with the solver's impulses, joints with limits and motors, drives and tweens. What is
  /// determined by the construction of the world, such as shapes, is not included, even if shapes
  /// were replaced.
  std::string SaveState() const;
  /// Puts a world that was constructed in the same way, in the same order, into a saved state. Both
  /// make the same steps, bit for bit. Handles stay valid, and no contact event is reported. Throws
  /// std::invalid_argument, and changes nothing, if the state is damaged or is of a world of other
  /// bodies, fixtures, joints, drives or tweens.
  void RestoreState(std::string_view bytes);

 private:
  friend class SharedWorld;
  friend class WorldBatch;
  friend struct WorldState;
  friend std::vector<Setting> SettingsOf(World& world);

  /// The number of parts of a step.
  int PartsOf(double dt);
  void StepOnce(double dt);
  b2Body& Find(Body body) const;
  b2Fixture& Find(Fixture fixture) const;
  /// The layer that a fixture is a wall of, or null.
  NearbyWalls* FindLayer(Fixture fixture) const;
  Fixture AddFixture(Body body, const b2Shape& shape, const FixtureSettings& settings);
  void SetShape(Fixture fixture, const b2Shape& shape, std::optional<LayerBits> layers);
  /// Calls `apply(b2Body&)` now or, in the contact listener, after the step.
  template <class Apply>
  void ApplyOrDefer(Body body, Apply apply) {
    b2Body& found = Find(body);
    if (IsInCallback()) {
      contacts_.Defer(body, apply);
    } else {
      apply(found);
    }
  }
  void SetMassData(Body body, const b2MassData& data);
  b2RevoluteJoint& FindHinge(Joint joint) const;
  /// The joint of a steered wheel of a body.
  b2RevoluteJoint* FindWheel(Body body, Joint wheel) const;
  /// The same with `apply(b2RevoluteJoint&)`: Box2D removes a body's joints before it calls the
  /// contact listener, so the hinge still exists then.
  template <class Apply>
  void ApplyOrDefer(Joint joint, Apply apply) {
    b2RevoluteJoint& hinge = FindHinge(joint);
    ApplyOrDefer(bodies_.HandleOf(*hinge.GetBodyB()), [&hinge, apply](b2Body&) { apply(hinge); });
  }
  Joint AddJoint(const b2JointDef& definition);
  /// Adds a belt for a drive of limited force; null if it has no limits.
  b2FrictionJoint* AddBelt(Body body, const std::optional<ActuatorSettings>& actuator);
  /// Calls `visit(body, grip)` for each drive of limited force.
  template <class Visit>
  void ForEachGrip(Visit visit) const {
    const_cast<Mechanisms&>(mechanisms_).ForEachActuator([&](Body body, Actuator& actuator) {
      if (const Grip* grip = actuator.grip()) visit(body, *grip);
    });
  }
  /// A copy that is in a state of this world.
  std::unique_ptr<World> Copy(const WorldState& state) const;
  void SayGoodbye(b2Joint* joint) override;
  void SayGoodbye(b2Fixture*) override {}

  std::unique_ptr<b2World> world_;
  int velocity_iterations_;
  int position_iterations_;
  Bodies bodies_;
  std::unique_ptr<Layers> layers_;
  Lidars lidars_;
  Contacts contacts_;
  SlotMap<b2Joint*> joints_{"joint"};
  Mechanisms mechanisms_;
  SlotMap<Crowd> crowds_{"crowd"};
  int completed_steps_ = 0;  // since the call of StepUntilContact
};

}  // namespace flatland
