#pragma once

/// The physical world: static layers of walls, bodies with fixtures, joints, drives; stepping them;
/// hearing of their contacts; and looking at them with a lidar. No Python and no ROS below this
/// line.
///
/// Layers. A fixture belongs to a set of collision layers, a mask of 16 bits. Two fixtures touch if
/// they share a layer and both collide; a lidar sees the fixtures that share a layer with it,
/// whether they collide or not, but no sensors.
///
/// Threads. A world is used by one thread at a time. Step and Scan may run while Python does
/// something else; whoever touches the world meanwhile gets a std::logic_error. A contact listener
/// may, on the stepping thread: it may ask about bodies, set velocities and apply forces.

#include <box2d/box2d.h>

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include "flatland_server/beam_fan.hpp"
#include "flatland_server/body_drive.hpp"
#include "flatland_server/body_tween.hpp"
#include "flatland_server/contact.hpp"
#include "flatland_server/geometry.hpp"
#include "flatland_server/lidar.hpp"
#include "flatland_server/mover.hpp"
#include "flatland_server/segment_tree.hpp"
#include "flatland_server/slot_map.hpp"
#include "flatland_server/tricycle_drive.hpp"

namespace flatland {

struct BodySettings {
  b2BodyType type = b2_dynamicBody;
  Pose pose;
  double linear_damping = 0.0;   ///< [1/s]
  double angular_damping = 0.0;  ///< [1/s]
};

struct FixtureSettings {
  double density = 0.0;      ///< [kg/m^2]
  double friction = 0.0;     ///< Box2D's coefficient, 0 or more
  double restitution = 0.0;  ///< Box2D's coefficient, 0 or more
  bool sensor = false;       ///< notices contacts, does not answer to them
  bool collides = true;      ///< false: passes through everything, still seen by lidars
  bool visible = true;       ///< whether lidars see it
  LayerBits layers = 0xFFFF;
};

/// A joint holds `anchor_a` of body a on `anchor_b` of body b, each in its body's frame [m].
struct JointSettings {
  Vec2 anchor_a;
  Vec2 anchor_b;
  bool collide_connected = false;
};

struct RevoluteSettings : JointSettings {
  std::optional<std::pair<double, double>> limits;  ///< of b's angle less a's [rad]
};

struct WeldSettings : JointSettings {
  double angle = 0.0;      ///< b's angle less a's [rad]
  double frequency = 0.0;  ///< of the spring [Hz]; 0 is rigid
  double damping = 0.0;    ///< ratio, 1 is critical
};

/// What the world keeps about a body, or about the static body of a layer.
struct BodyRecord {
  struct FixtureRecord {
    b2Fixture* fixture = nullptr;
    bool visible = true;
    double reach = 0.0;  // of its shape, for Mover
  };

  b2Body* body = nullptr;
  bool is_layer = false;
  uint8_t hooks = kNoHooks;
  std::vector<FixtureRecord> fixtures;  // by index
};

/// Something on a body: a drive or a tween, which moves it at every step, or a lidar.
template <class Mechanism>
struct Moved {
  Handle<BodyRecord> body;
  Mechanism mechanism;
};

class World : private b2DestructionListener, private b2ContactListener {
 public:
  using Body = Handle<BodyRecord>;
  using Joint = Handle<b2Joint*>;
  using Drive = Handle<Moved<BodyDrive>>;
  using Tricycle = Handle<Moved<TricycleDrive>>;
  using Tween = Handle<Moved<BodyTween>>;
  using LidarHandle = Handle<Moved<Lidar>>;

  /// Marks the world as in use for as long as it lives: other threads are refused meanwhile.
  /// Throws std::logic_error if it is in use already. What adds or removes, puts elsewhere, steps
  /// or scans marks it by itself. For those who share a lock that they let go during a step or a
  /// scan, as Python does: marked while they hold the lock, the world is marked whenever another
  /// thread gets it.
  class Turn {
   public:
    explicit Turn(const World& world) : world_(world) { world_.Begin(); }
    ~Turn() { world_.busy_ = false; }
    Turn(const Turn&) = delete;
    Turn& operator=(const Turn&) = delete;

   private:
    const World& world_;
  };

  /// Solver iterations per step, 1 or more each.
  World(int velocity_iterations, int position_iterations);
  World(const World&) = delete;
  World& operator=(const World&) = delete;

  // Every function below throws GoneError for the handle of something deleted, and
  // std::invalid_argument for a value that Box2D could not digest (not finite, a radius of zero, a
  // polygon without area): such a value would abort the process or stall it for good.

  /// A static body of two-sided walls, each a fixture, there for good. Throws also on a segment of
  /// no length.
  Body AddLayer(const std::vector<Segment>& segments, LayerBits layers);
  Body AddBody(const BodySettings& settings);
  /// Takes its fixtures, joints and drives with it.
  void RemoveBody(Body body);
  bool Contains(Body body) const { return bodies_.Contains(body); }

  Fixture AddCircle(Body body, Vec2 center, double radius, const FixtureSettings& settings);
  /// 3 to 8 vertices; Box2D takes their convex hull.
  Fixture AddPolygon(Body body, const std::vector<Vec2>& vertices, const FixtureSettings& settings);
  /// How many fixtures a body has; their indices are 0 to one less.
  int GetFixtureCount(Body body) const;
  FixtureSettings GetSettings(Fixture fixture) const;
  // Contacts that exist already keep their friction and restitution.
  void SetFriction(Fixture fixture, double friction);
  void SetRestitution(Fixture fixture, double restitution);
  /// Whether a point of the world is within its shape.
  bool TestPoint(Fixture fixture, Vec2 point) const;

  Joint AddRevolute(Body a, Body b, const RevoluteSettings& settings);
  Joint AddWeld(Body a, Body b, const WeldSettings& settings);
  bool Contains(Joint joint) const { return joints_.Contains(joint); }
  /// Angle of b less that of a, less the weld's own [rad].
  double JointAngle(Joint joint) const;

  Drive AddDrive(Body body, const DynamicsLimits& linear, const DynamicsLimits& angular);
  BodyDrive& Get(Drive drive) { return GetMechanism(drives_, drive); }
  /// `front_wheel`, a revolute joint of the body, holds the wheel that is turned for show.
  Tricycle AddTricycle(Body body, Joint front_wheel, const TricycleSettings& settings);
  TricycleDrive& Get(Tricycle tricycle) { return GetMechanism(tricycles_, tricycle); }
  Tween AddTween(Body body, const TweenSettings& settings);
  BodyTween& Get(Tween tween) { return GetMechanism(tweens_, tween); }

  /// The yaw counts whole turns, as joints do.
  Pose GetPose(Body body) const;
  /// Of a body's origin in another's frame: the yaw is the difference of the two bodies' own, which
  /// lie within [-pi, pi].
  Pose GetPoseIn(Body reference, Body body) const;
  /// Puts the body there at once, awake; its velocity stays. Not while contacts are told of.
  void SetPose(Body body, const Pose& pose);
  /// Velocity of the body's origin, in the world's frame.
  Twist GetVelocity(Body body) const;
  void SetVelocity(Body body, const Twist& velocity);
  /// Velocity of the body's origin, in the body's frame.
  Twist GetLocalVelocity(Body body) const;
  /// Velocity of the body's matter at a point of the world, in the world's frame.
  Vec2 GetVelocityAt(Body body, Vec2 point) const;
  /// Stops the body and its drives.
  void Halt(Body body);

  // Points and directions from the body's frame to the world's, and back.
  Vec2 ToWorldPoint(Body body, Vec2 point) const;
  Vec2 ToLocalPoint(Body body, Vec2 point) const;
  Vec2 ToWorldVector(Body body, Vec2 vector) const;
  Vec2 ToLocalVector(Body body, Vec2 vector) const;

  b2BodyType GetType(Body body) const { return Find(body).GetType(); }
  /// [kg]; 0 for a body that is not dynamic
  double GetMass(Body body) const;
  /// Moment of inertia about the centre of mass [kg m^2]; 0 for a body that is not dynamic
  double GetInertia(Body body) const;
  /// Centre of mass, in the world.
  Vec2 GetCenter(Body body) const;
  bool IsAwake(Body body) const { return Find(body).IsAwake(); }

  // For the coming step [N], [N m], of a contact listener for the next one; at once [N s], [N m s].
  // At the centre of mass, or at a point of the world. They wake the body up.
  void ApplyForce(Body body, Vec2 force, std::optional<Vec2> point = std::nullopt);
  void ApplyTorque(Body body, double torque);
  void ApplyLinearImpulse(Body body, Vec2 impulse, std::optional<Vec2> point = std::nullopt);
  void ApplyAngularImpulse(Body body, double impulse);

  /// Who hears of contacts, or null. It is the caller's, and must live as long as the world or
  /// until another is set.
  void SetContactListener(ContactListener* listener);
  ContactListener* contact_listener() const { return listener_; }
  /// At which moments the listener hears of the contacts of a body, be it a layer's: a contact is
  /// told of if either side is listened to. Nothing else costs anything.
  void ListenTo(Body body, uint8_t hooks);

  /// Moves everything on by `dt` seconds.
  void Step(double dt) { Step(dt, Turn(*this)); }
  void Step(double dt, const Turn& turn);

  /// Casts the fan from `pose`. Writes fan.size() values to each array: the distance of the first
  /// thing seen [m] or +infinity (REP 117), and its intensity. A shape around the lidar itself is
  /// not seen.
  void Scan(const BeamFan& fan, const Pose& pose, const ScanSettings& settings, float* ranges,
            float* intensities) const {
    Scan(fan, pose, settings, ranges, intensities, Turn(*this));
  }
  void Scan(const BeamFan& fan, const Pose& pose, const ScanSettings& settings, float* ranges,
            float* intensities, const Turn& turn) const;

  /// The lidar is there as long as its body.
  LidarHandle AddLidar(Body body, const LidarSettings& settings);
  /// Says that Scan will be asked for soon: then all that are expected scan together, on all cores.
  void ExpectScan(LidarHandle lidar);
  /// What a lidar sees now. The values are valid until the world changes.
  const Lidar& Scan(LidarHandle lidar) { return Scan(lidar, Turn(*this)); }
  const Lidar& Scan(LidarHandle lidar, const Turn& turn);

  int body_count() const { return world_.GetBodyCount(); }
  int joint_count() const { return world_.GetJointCount(); }

 private:
  struct Layer {
    std::shared_ptr<const SegmentTree> walls;
    LayerBits bits;
  };

  /// What a contact listener asked for: Box2D has spent this step's forces by then, and drops more.
  struct LateForce {
    Body body;
    Vec2 force;
    std::optional<Vec2> point;
    double torque;
  };

  void SayGoodbye(b2Joint* joint) override;
  void SayGoodbye(b2Fixture*) override {}
  void BeginContact(b2Contact* contact) override;
  void EndContact(b2Contact* contact) override;
  void PreSolve(b2Contact* contact, const b2Manifold* old_manifold) override;
  void PostSolve(b2Contact* contact, const b2ContactImpulse* impulse) override;
  bool IsHeard(b2Contact& contact, ContactHooks moment) const;
  Contact MakeContact(b2Contact& contact, ContactHooks moment) const;
  void Tell(Contact& contact);

  /// Whether this thread is in a contact listener.
  bool IsListening() const;
  /// Throws std::logic_error if the world is in use, unless by a contact listener on this thread.
  void RequireAccess() const;
  /// Marks the world as in use; throws std::logic_error if it is already.
  void Begin() const;
  b2Body& Find(Body body) const;
  b2Fixture& Find(Fixture fixture) const;
  Joint AddJoint(const b2JointDef& definition);
  Fixture AddFixture(Body body, const b2Shape& shape, const FixtureSettings& settings);
  void ApplyLateForces();
  void RefreshMovers() const;
  void ScanInto(const BeamFan& fan, const Pose& pose, const ScanSettings& settings, float* ranges,
                float* intensities) const;
  /// Draws the layers and movers that the lidar sees and whose layers `choose` says yes to.
  template <class Choose>
  void DrawOn(DepthBuffer& buffer, const Pose& pose, const ScanSettings& settings,
              Choose choose) const;
  static void Place(b2Body& body, const Pose& pose);
  /// Box2D does not look at what touches a static body while both rest.
  void WakeThoseNear(const b2Body& body);

  template <class Mechanism>
  Mechanism& GetMechanism(SlotMap<Moved<Mechanism>>& map, Handle<Moved<Mechanism>> handle) {
    RequireAccess();
    return map.Get(handle).mechanism;
  }
  /// Calls `visit(handle, mechanism)` for each of a map's that move the body.
  template <class Map, class Visit>
  static void ForEachOf(Map& map, Body body, Visit visit) {
    map.ForEach([&](auto handle, auto& moved) {
      if (moved.body.index == body.index) visit(handle, moved.mechanism);
    });
  }

  b2World world_;
  int velocity_iterations_;
  int position_iterations_;
  SlotMap<BodyRecord> bodies_{"body"};
  SlotMap<b2Joint*> joints_{"joint"};
  SlotMap<Moved<BodyDrive>> drives_{"drive"};
  SlotMap<Moved<TricycleDrive>> tricycles_{"drive"};
  SlotMap<Moved<BodyTween>> tweens_{"tween"};
  SlotMap<Moved<Lidar>> lidars_{"lidar"};
  std::vector<LidarHandle> expected_;         // to scan soon
  std::vector<std::pair<Lidar*, Pose>> due_;  // those that scan now, and where they are
  uint64_t state_ = 1;  // another number whenever something has come, gone or moved
  std::vector<Layer> layers_;
  mutable std::vector<Mover> movers_;  // what moves and can be seen
  mutable Discs discs_;                // their bounding circles
  mutable uint64_t movers_state_ = 0;  // of which state_ they are
  std::vector<LateForce> late_forces_;
  ContactListener* listener_ = nullptr;
  mutable std::atomic<bool> busy_{false};
  std::atomic<std::thread::id> listening_thread_{};  // while the listener is called
};

}  // namespace flatland
