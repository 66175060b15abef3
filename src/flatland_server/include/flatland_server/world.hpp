#pragma once

/// The physical world: static layers of walls, bodies with fixtures, joints, drives; stepping them;
/// and looking at them with a lidar. No Python and no ROS below this line.
///
/// Layers. A fixture belongs to a set of collision layers, a mask of 16 bits. Two fixtures touch if
/// they share a layer and both collide; a lidar sees the fixtures that share a layer with it,
/// whether they collide or not, but no sensors.
///
/// Threads. A world is used by one thread at a time. Step and Scan may run while Python does
/// something else; whoever touches the world meanwhile gets a std::logic_error.

#include <box2d/box2d.h>

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "flatland_server/beam_fan.hpp"
#include "flatland_server/body_drive.hpp"
#include "flatland_server/geometry.hpp"
#include "flatland_server/segment_grid.hpp"
#include "flatland_server/slot_map.hpp"

namespace flatland {

using LayerBits = uint16_t;

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

/// What a lidar looks for.
struct ScanSettings {
  double range = 0.0;                ///< farthest return [m]
  LayerBits layers = 0xFFFF;         ///< what it sees
  LayerBits reflectance_layers = 0;  ///< what returns intensity 255 instead of 0
};

class World : private b2DestructionListener {
 public:
  struct DrivenBody {
    Handle<b2Body*> body;
    BodyDrive drive;
  };
  using Body = Handle<b2Body*>;
  using Joint = Handle<b2Joint*>;
  using Drive = Handle<DrivenBody>;

  /// Solver iterations per step, 1 or more each.
  World(int velocity_iterations, int position_iterations);
  World(const World&) = delete;
  World& operator=(const World&) = delete;

  // Every function below throws GoneError for the handle of something deleted, and
  // std::invalid_argument for a value that Box2D could not digest (not finite, a radius of zero, a
  // polygon without area): such a value would abort the process or stall it for good.

  /// A static body of two-sided walls, there for good. Throws also on a segment of no length.
  void AddLayer(const std::vector<Segment>& segments, LayerBits layers);
  Body AddBody(const BodySettings& settings);
  /// Takes its fixtures, joints and drives with it.
  void RemoveBody(Body body);
  bool Contains(Body body) const { return bodies_.Contains(body); }

  void AddCircle(Body body, Vec2 center, double radius, const FixtureSettings& settings);
  /// 3 to 8 vertices; Box2D takes their convex hull.
  void AddPolygon(Body body, const std::vector<Vec2>& vertices, const FixtureSettings& settings);

  Joint AddRevolute(Body a, Body b, const RevoluteSettings& settings);
  Joint AddWeld(Body a, Body b, const WeldSettings& settings);
  bool Contains(Joint joint) const { return joints_.Contains(joint); }
  /// Angle of b less that of a, less the weld's own [rad].
  double JointAngle(Joint joint) const;

  Drive AddDrive(Body body, const DynamicsLimits& linear, const DynamicsLimits& angular);
  BodyDrive& GetDrive(Drive drive);

  /// The yaw counts whole turns, as joints do.
  Pose GetPose(Body body) const;
  /// Puts the body there at once, awake; its velocity stays.
  void SetPose(Body body, const Pose& pose);
  /// Velocity of the body's origin, in the world's frame.
  Twist GetVelocity(Body body) const;
  void SetVelocity(Body body, const Twist& velocity);
  /// Velocity of the body's origin over the last step, in the body's frame halfway through it: on a
  /// steady arc exactly the arc's twist, with nothing sideways.
  Twist GetLocalVelocity(Body body) const;
  /// Stops the body and its drives.
  void Halt(Body body);
  /// [kg]; 0 for a body that is not dynamic
  double GetMass(Body body) const;
  void ApplyForce(Body body, Vec2 force, double torque);

  /// Moves everything on by `dt` seconds.
  void Step(double dt);

  /// Casts the fan from `pose`. Writes fan.size() values to each array: the distance of the first
  /// thing seen [m] or +infinity (REP 117), and its intensity. A shape around the lidar itself is
  /// not seen.
  void Scan(const BeamFan& fan, const Pose& pose, const ScanSettings& settings, float* ranges,
            float* intensities) const;

  int body_count() const { return world_.GetBodyCount(); }
  int joint_count() const { return world_.GetJointCount(); }

 private:
  struct Layer {
    std::shared_ptr<const SegmentGrid> grid;
    LayerBits bits;
  };

  void SayGoodbye(b2Joint* joint) override;
  void SayGoodbye(b2Fixture*) override {}

  void RequireIdle() const;
  b2Body& Find(Body body) const;
  Joint AddJoint(const b2JointDef& definition);
  void AddFixture(b2Body& body, const b2Shape& shape, const FixtureSettings& settings);

  b2World world_;
  int velocity_iterations_;
  int position_iterations_;
  double last_dt_ = 0.0;
  SlotMap<b2Body*> bodies_{"body"};
  SlotMap<b2Joint*> joints_{"joint"};
  SlotMap<DrivenBody> drives_{"drive"};
  std::vector<Layer> layers_;
  mutable std::atomic<bool> busy_{false};
};

}  // namespace flatland
