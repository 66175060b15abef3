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

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include "flatland_server/beam_fan.hpp"
#include "flatland_server/body.hpp"
#include "flatland_server/body_drive.hpp"
#include "flatland_server/body_tween.hpp"
#include "flatland_server/collision_layers.hpp"
#include "flatland_server/contact.hpp"
#include "flatland_server/fixture.hpp"
#include "flatland_server/geometry.hpp"
#include "flatland_server/joint.hpp"
#include "flatland_server/lidar.hpp"
#include "flatland_server/slot_map.hpp"
#include "flatland_server/tricycle_drive.hpp"
#include "flatland_server/visible_fixture.hpp"
#include "flatland_server/visible_walls.hpp"

namespace flatland {

/// Something that belongs to a body and is removed with it: a drive, a tween or a lidar.
template <class Mechanism>
struct Mounted {
  Handle<BodyRecord> body;
  Mechanism mechanism;
};

struct WorldState;

class NearbyWalls;

/// See shared_world.hpp.
class SharedWorld;

class World : private b2DestructionListener, private b2ContactListener {
 public:
  using Body = Handle<BodyRecord>;
  using Joint = Handle<b2Joint*>;
  using Drive = Handle<Mounted<BodyDrive>>;
  using Tricycle = Handle<Mounted<TricycleDrive>>;
  using Tween = Handle<Mounted<BodyTween>>;
  using LidarHandle = Handle<Mounted<Lidar>>;

  /// Layers of more walls are large: Box2D has only those walls that are near dynamic bodies, which
  /// are few. That saves 400 bytes a wall; but contacts may be found in another order, so that a
  /// step is the same up to rounding.
  static constexpr std::size_t kLargeLayer = SegmentTree::kMaxCopied;

  /// Solver iterations per step, each 1 or more.
  World(int velocity_iterations, int position_iterations, std::size_t large_layer = kLargeLayer);
  World(const World&) = delete;
  World& operator=(const World&) = delete;

  /// A world that makes the same steps, bit for bit, of one that has made none yet. Handles name
  /// the same things in both. It has no contact listener, and nothing has chosen events. Throws
  /// std::invalid_argument if a step was made. No body may have been removed before, and no shape
  /// replaced. In the copy, Box2D has all walls of large layers.
  std::unique_ptr<World> Copy() const;

  /// Marks the world as in use while it exists; throws std::logic_error if it is in use already.
  /// Functions that change the structure of the world, step or scan create one themselves. Callers
  /// that release a lock during a step or a scan, as the Python bindings do with the GIL, create it
  /// before they release the lock: then other threads always find the world marked.
  class AccessGuard {
   public:
    explicit AccessGuard(const World& world) : world_(world) { world_.BeginAccess(); }
    ~AccessGuard() { world_.is_in_use_ = false; }
    AccessGuard(const AccessGuard&) = delete;
    AccessGuard& operator=(const AccessGuard&) = delete;

   private:
    const World& world_;
  };

  // ---- Bodies ----

  Body AddBody(const BodySettings& settings);
  /// Adds a static body of two-sided walls [m], one fixture each, that cannot be moved or removed.
  ///
  /// @param progress  called with the number of walls added so far, about every 50,000 and at the
  /// end
  Body AddLayer(std::vector<Segment> walls, LayerBits layers,
                const std::function<void(std::size_t added)>& progress = {});
  /// Also removes its fixtures, joints, drives, tweens and lidars.
  void RemoveBody(Body body);
  /// Whether the body still exists.
  bool Contains(Body body) const { return bodies_.Contains(body); }
  /// Number of bodies, layers included.
  int body_count() const;
  /// Number of walls of large layers that Box2D has at present.
  int held_wall_count() const;
  /// Static, kinematic or dynamic.
  b2BodyType GetType(Body body) const { return Find(body).GetType(); }
  /// Whether Box2D simulates it; a body at rest falls asleep.
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
  /// In the body's frame [m/s, m/s, rad/s].
  Twist GetLocalVelocity(Body body) const;
  /// In the world's frame [m/s, m/s, rad/s].
  void SetVelocity(Body body, const Twist& velocity);
  /// Velocity of the body at a point of the world [m], in the world's frame [m/s].
  Vec2 GetVelocityAt(Body body, Vec2 point) const;
  /// Sets the velocities of the body and its drives, and their commands, to zero.
  void Halt(Body body);

  // Conversion between the body's frame (local) and the world's.

  Vec2 ToWorldPoint(Body body, Vec2 point) const;
  Vec2 ToLocalPoint(Body body, Vec2 point) const;
  Vec2 ToWorldVector(Body body, Vec2 vector) const;
  Vec2 ToLocalVector(Body body, Vec2 vector) const;

  // Mass.

  /// Mass [kg]; 0 unless dynamic.
  double GetMass(Body body) const;
  /// Moment of inertia about the centre of mass [kg m^2]; 0 unless dynamic.
  double GetInertia(Body body) const;
  /// Centre of mass, in the world [m].
  Vec2 GetCenter(Body body) const;

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
  /// Sets the coefficient of friction for new contacts; existing ones keep theirs.
  void SetFriction(Fixture fixture, double friction);
  /// Sets the coefficient of restitution for new contacts; existing ones keep theirs.
  void SetRestitution(Fixture fixture, double restitution);
  /// Sets whether lidars see it; not for walls.
  void SetVisible(Fixture fixture, bool visible);
  /// The radius of a circle as lidars see it [m]; its own, until it is set.
  double GetSeenRadius(Fixture fixture) const;
  void SetSeenRadius(Fixture fixture, double radius);
  /// Whether a point of the world [m] is within the shape; always false for a wall.
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
  /// Whether the joint still exists: until one of its bodies is removed.
  bool Contains(Joint joint) const { return joints_.Contains(joint); }
  int joint_count() const { return world_->GetJointCount(); }
  /// Angle of b minus that of a, minus a weld's reference angle, within [-pi, pi] [rad].
  double GetJointAngle(Joint joint) const;

  // ---- Drives and tweens ----

  /// Drives the body at commanded velocities. The limits are in m/s and m/s^2, rad/s and rad/s^2.
  Drive AddDrive(Body body, const DynamicsLimits& linear, const DynamicsLimits& angular);
  /// Drives the body as a tricycle. `front_wheel`, a revolute joint of the body, holds the body of
  /// the front wheel, which is rotated to show the steering angle.
  Tricycle AddTricycle(Body body, Joint front_wheel, const TricycleSettings& settings);
  /// Moves the body along a prescribed path, starting at its present pose.
  Tween AddTween(Body body, const TweenSettings& settings);
  BodyDrive& Get(Drive drive) { return GetMechanism(drives_, drive); }
  TricycleDrive& Get(Tricycle tricycle) { return GetMechanism(tricycles_, tricycle); }
  BodyTween& Get(Tween tween) { return GetMechanism(tweens_, tween); }

  // ---- Lidars and scanning ----

  LidarHandle AddLidar(Body body, const LidarSettings& settings);
  /// Announces a call of Scan. The first Scan computes all announced scans, on all processor cores.
  void ExpectScan(LidarHandle lidar);
  /// The lidar with its scan of the present world. Its arrays are valid until the world changes.
  const Lidar& Scan(LidarHandle lidar) { return Scan(lidar, AccessGuard(*this)); }
  const Lidar& Scan(LidarHandle lidar, const AccessGuard& guard);
  /// The number of beams of a lidar.
  int GetBeamCount(LidarHandle lidar) const;
  /// Writes a lidar's scan of the present world to an array of GetBeamCount values.
  void ScanInto(LidarHandle lidar, float* ranges, const AccessGuard& guard) const;
  /// Scans from a pose in the world [m, m, rad]. Writes fan.size() values to each array: the
  /// distance [m] to what each beam meets first, or +infinity (REP 117), and its intensity, 0 or
  /// 255. Shapes that contain the lidar are not seen.
  void Scan(const BeamFan& fan, const Pose& pose, const ScanSettings& settings, float* ranges,
            float* intensities) const {
    Scan(fan, pose, settings, ranges, intensities, AccessGuard(*this));
  }
  void Scan(const BeamFan& fan, const Pose& pose, const ScanSettings& settings, float* ranges,
            float* intensities, const AccessGuard& guard) const;

  // ---- Contacts ----

  /// Sets the listener that receives contact events, or null. The caller keeps it alive as long as
  /// the world, or until another one is set.
  void SetContactListener(ContactListener* listener);
  ContactListener* contact_listener() const { return listener_; }
  /// Chooses the events of a body's contacts that the listener receives; none at first. A contact's
  /// event is reported if either of its two bodies has chosen it.
  void ListenToContacts(Body body, ContactEvents events);
  /// The fixtures that touch, as the last step has found them, ordered by their bodies and indices.
  std::vector<Touch> GetTouches() const;
  /// Whether a solid fixture of one of these bodies touches a solid fixture of another body, as the
  /// last step has found it.
  bool Touches(const std::vector<Body>& bodies) const;

  // ---- Stepping ----

  /// Advances the simulation by `dt` [s], 1e-9 or more.
  void Step(double dt) { Step(dt, AccessGuard(*this)); }
  void Step(double dt, const AccessGuard& guard);
  /// Makes at most `count` steps of `dt` [s] each, and at least one. Ends after a step in which the
  /// contact listener was called, so that the caller can react before the next one. Returns the
  /// number of steps.
  int StepUntilContact(double dt, int count) {
    return StepUntilContact(dt, count, AccessGuard(*this));
  }
  int StepUntilContact(double dt, int count, const AccessGuard& guard);
  /// Number of steps that the last call of StepUntilContact has completed; during a call of the
  /// contact listener, those before the step that is being made.
  int completed_steps() const {
    RequireAccess();
    return completed_steps_;
  }

  // ---- State ----

  /// The state of all that moves, as bytes: poses, velocities, pending forces, contacts with the
  /// solver's impulses, joints, drives and tweens. What the construction of the world determines,
  /// such as shapes, is not included, even if they were replaced.
  ///
  /// It also puts this world into the form that RestoreState gives to another one, with a new tree
  /// of bounding boxes: Box2D finds new contacts in the order of that tree, and solves them in this
  /// order. So from here on the two make the same steps, bit for bit.
  std::string SaveState();
  /// Puts a world that was constructed in the same way, in the same order, into a saved state.
  /// Handles stay valid, and no contact event is reported. Throws std::invalid_argument, and
  /// changes nothing, if the state is damaged or is of a world of other bodies, fixtures, joints,
  /// drives or tweens.
  void RestoreState(std::string_view bytes);

 private:
  friend class SharedWorld;

  struct Layer {
    std::shared_ptr<const VisibleWalls> walls;
    LayerBits bits;
  };

  /// A force or torque applied by a contact listener. Box2D clears all forces at the end of the
  /// step, so these are applied after it.
  struct DeferredForce {
    Body body;
    Vec2 force;                 // [N]
    std::optional<Vec2> point;  // in the world [m]; none is the centre of mass
    double torque;              // [N m]
  };

  // Access.

  /// Marks the world as in use; throws std::logic_error if it is in use already.
  void BeginAccess() const;
  /// Throws std::logic_error if the world is in use, except for a contact listener on this thread.
  void RequireAccess() const;
  /// Whether this thread is within a call of the contact listener.
  bool IsInListener() const;

  // Bodies and fixtures.

  /// To be called when something but a body that may move is added, removed or moved.
  void ChangeStructure() {
    ++revision_;
    ++structure_revision_;
  }
  /// From now on the body may move in a step.
  void LetMove(Body body) {
    if (bodies_.Get(body).may_move) return;
    bodies_.Get(body).may_move = true;
    ChangeStructure();
  }
  b2Body& Find(Body body) const;
  b2Fixture& Find(Fixture fixture) const;
  /// The model's body, or the layer, that something in Box2D belongs to.
  Body HandleOf(b2Body& body) const {
    return bodies_.HandleAt(static_cast<uint32_t>(body.GetUserData().pointer));
  }
  const BodyRecord& RecordOf(b2Body& body) const { return bodies_.Get(HandleOf(body)); }
  /// The large layer that a fixture is a wall of, or null.
  NearbyWalls* FindLargeLayer(Fixture fixture) const;
  Body AddRecord(BodyRecord record);
  Fixture AddFixture(Body body, const b2Shape& shape, const FixtureSettings& settings);
  void SetShape(Fixture fixture, const b2Shape& shape, std::optional<LayerBits> layers);
  /// Moves a body; adds the multiple of 2 pi that keeps its angle nearest to the present one.
  static void Place(b2Body& body, const Pose& pose);
  /// Wakes the bodies that a static body may touch; Box2D does not do so.
  void WakeBodiesNear(const b2Body& body);
  void ApplyDeferredForces();

  // Large layers.

  /// That of a layer's record, or null if it is not a large layer's.
  NearbyWalls* LargeLayerOf(const BodyRecord& record) const;
  /// The number of a body's fixtures, or of a layer's walls.
  std::size_t FixtureCountOf(const BodyRecord& record) const;
  /// A fixture of a body, or null for a wall that Box2D does not have at present.
  b2Fixture* FixtureOrNull(const BodyRecord& record, uint32_t index) const;
  /// Makes sure that Box2D has all walls that a dynamic body may reach in the next step.
  void HoldWallsNearBodies();
  void HoldWallsNear(BodyRecord& record);
  void ReleaseWallsNear(BodyRecord& record);
  /// The same, when Box2D's world is replaced by one without them.
  void ForgetHeldWalls();
  /// Whether a fixture of a dynamic body overlaps a wall of a large layer that it collides with.
  bool OverlapsWall(const BodyRecord& record, const NearbyWalls& layer) const;
  /// `GetClearance` of one fixture; `own` are the bodies that are left out.
  double ClearanceOf(const b2Fixture& fixture, const std::vector<const b2Body*>& own,
                     double limit) const;

  // Joints.

  Joint AddJoint(const b2JointDef& definition);
  void SayGoodbye(b2Joint* joint) override;
  void SayGoodbye(b2Fixture*) override {}

  // Drives, tweens and lidars.

  template <class Mechanism>
  Mechanism& GetMechanism(SlotMap<Mounted<Mechanism>>& map, Handle<Mounted<Mechanism>> handle) {
    RequireAccess();
    return map.Get(handle).mechanism;
  }
  /// Calls `visit(handle, mechanism)` for each mechanism of a map that is mounted on the body.
  template <class Map, class Visit>
  static void ForEachOn(Body body, Map& map, Visit visit) {
    map.ForEach([&](auto handle, auto& mounted) {
      if (mounted.body.index == body.index) visit(handle, mounted.mechanism);
    });
  }
  void AdvanceTween(BodyTween& tween, b2Body& body, double dt);
  void FinishTween(BodyTween& tween, b2Body& body, double dt);

  // Scanning.

  /// Collects the fixtures that lidars may see, once per revision.
  void RefreshVisibleFixtures() const;
  /// Collects the bodies that may move, and the visible fixtures of the others, once per structure
  /// revision.
  void RefreshMovingBodies() const;
  void AddVisibleFixtures(const BodyRecord& record) const;
  /// Called by several threads at a time; the visible fixtures must be up to date. `intensities`
  /// may be null.
  void ScanInto(const BeamFan& fan, const Pose& pose, const ScanSettings& settings, float* ranges,
                float* intensities) const;
  /// Draws the walls and fixtures on layers that the lidar sees and that `choose(layers)` accepts.
  template <class Choose>
  void DrawOn(DepthBuffer& buffer, const Pose& pose, const ScanSettings& settings,
              Choose choose) const;

  // Contacts.

  void BeginContact(b2Contact* contact) override;
  void EndContact(b2Contact* contact) override;
  void PreSolve(b2Contact* contact, const b2Manifold* old_manifold) override;
  void PostSolve(b2Contact* contact, const b2ContactImpulse* impulse) override;
  /// Whether there is a listener and one of the two bodies has chosen the event.
  bool IsListenedTo(b2Contact& contact, ContactEvent event) const;
  Contact MakeContact(b2Contact& contact, ContactEvent event) const;
  void CallListener(Contact& contact);
  /// Makes Box2D report contacts if a body has chosen an event.
  void ChooseContactReports();

  // State.

  WorldState CollectState() const;
  template <class Archive>
  void Serialize(Archive& archive, WorldState& state) const;
  /// Replaces Box2D's world by a new one in this state; handles name the same bodies as before.
  void Rebuild(const WorldState& state);

  std::unique_ptr<b2World> world_;
  int velocity_iterations_;
  int position_iterations_;
  mutable std::atomic<bool> is_in_use_{false};
  uint64_t revision_ = 1;            // changes whenever something is added, removed or moved
  uint64_t structure_revision_ = 1;  // the same, but for bodies that may move

  SlotMap<BodyRecord> bodies_{"body"};
  std::vector<Layer> layers_;
  std::size_t large_layer_;
  std::vector<std::shared_ptr<NearbyWalls>> large_layers_;
  std::vector<DeferredForce> deferred_forces_;
  SlotMap<b2Joint*> joints_{"joint"};
  SlotMap<Mounted<BodyDrive>> drives_{"drive"};
  SlotMap<Mounted<TricycleDrive>> tricycles_{"drive"};
  SlotMap<Mounted<BodyTween>> tweens_{"tween"};

  SlotMap<Mounted<Lidar>> lidars_{"lidar"};
  std::vector<LidarHandle> expected_lidars_;       // those that ExpectScan was called for
  std::vector<std::pair<Lidar*, Pose>> scanning_;  // lidars of the present scan, and their poses
  mutable std::vector<VisibleFixture> visible_fixtures_;  // first those that stay
  mutable BoundingCircles bounding_circles_;              // of visible_fixtures_
  mutable uint64_t visible_revision_ = 0;                 // revision that these two show
  mutable size_t staying_fixtures_ = 0;                   // number of those that stay
  mutable std::vector<const BodyRecord*> moving_;         // the bodies that may move
  mutable uint64_t moving_revision_ = 0;                  // structure revision that these two show

  ContactListener* listener_ = nullptr;
  std::atomic<std::thread::id> listener_thread_{};  // set during a call of the listener
  bool has_called_listener_ = false;                // since the call of StepUntilContact
  int completed_steps_ = 0;                         // since the call of StepUntilContact
};

}  // namespace flatland
