#pragma once

/// People who walk between goals, and give way to walls, bodies and each other.
///
/// A crowd sets the velocities of its people at its updates, several times a second. Between two
/// updates Box2D moves them, and resolves collisions: they are bodies like others, without a drive.
/// The next update starts from the result. In an update, each person chooses a velocity by the
/// forces of what is around it (social_force.hpp, surroundings.hpp) or follows an agent of another
/// program; then turns that way, and its legs step.

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "flatland_server/bodies.hpp"
#include "flatland_server/collision_layers.hpp"
#include "flatland_server/normal_numbers.hpp"
#include "flatland_server/social_force.hpp"

namespace flatland {

class Layers;
struct Outline;

struct CrowdSettings {
  LayerBits layers = kAllLayers;  ///< people avoid the walls and bodies on these
  double period = 0.0;            ///< between two updates [ns]; 0: one before each step
  double goal_radius = 0.3;       ///< distance at which a goal counts as reached [m]
  SocialForce force;
};

struct PersonSettings {
  Bodies::Body body;                   ///< walks
  std::vector<Bodies::Body> legs;      ///< the left and the right one, or none
  std::optional<Bodies::Body> circle;  ///< goes along with the body
  std::vector<Vec2> goals;             ///< [m], visited in turn; with a single one, it stays there
  double radius = 0.25;                ///< [m]
  double speed = 1.34;                 ///< the desired one [m/s]
  double leg_offset = 0.1;             ///< distance of a leg from the middle [m]
  double walk_ratio = 0.384;           ///< a step's length by the steps per second [m s]
  double leg_radius = 0.0;             ///< of a leg on the floor, as lidars see it [m]
  double swing_radius = 0.0;           ///< in the middle of its swing; if equal, radii stay [m]
};

class Crowd {
 public:
  /// The distances [m] of a person's middle from the nearest wall, body and other person; infinite
  /// if there is none, or no wall within reach of the forces.
  struct Room {
    double wall, body, person;
  };

  Crowd();
  ~Crowd();
  Crowd(const Crowd&);
  Crowd& operator=(const Crowd&);
  /// Throws std::invalid_argument if a number is not finite, or negative, or zero for a length.
  Crowd(const CrowdSettings& settings, uint64_t key);

  /// Adds a person, on the way to the first goal. Throws std::invalid_argument as the constructor.
  void Add(const PersonSettings& person);
  /// To be called when a body is removed: its person leaves.
  void RemoveBody(Bodies::Body body);
  /// Begins another series of random numbers.
  void Seed(uint64_t key) { clock_.numbers = NormalNumbers(NormalNumbers::Mixed(key)); }
  /// Lets a person follow an agent at a point [m], of a velocity [m/s], from now on. Throws
  /// std::invalid_argument if they are too large.
  void Follow(size_t person, Vec2 point, Vec2 velocity);

  /// Before a step of `dt` [s]: makes an update, if one is due.
  void BeginStep(Bodies& bodies, const Layers& layers, double dt);
  /// The present room of each person.
  std::vector<Room> Rooms(const Bodies& bodies, const Layers& layers);
  /// Takes what changes of an equal crowd.
  void Take(const Crowd& other) {
    clock_ = other.clock_;
    std::copy(other.progress_.begin(), other.progress_.end(), progress_.begin());
  }
  /// Makes what lidars see follow the state, when that was restored.
  void Restore(Bodies& bodies);

  size_t size() const { return people_.size(); }
  /// Calls `visit` with each part of the state that it keeps from step to step: structures of
  /// numbers with a function Serialize, see archive.hpp.
  template <class Visit>
  void ForEachPart(Visit visit) {
    visit(clock_);
    for (Progress& each : progress_) visit(each);
  }
  /// True if a state that was read can be the crowd's.
  bool IsValid() const;

 private:
  struct Clock {
    int64_t now = 0;  // time of the steps so far [ns]
    int64_t due = 0;  // of the next update [ns]
    NormalNumbers numbers;

    template <class Archive>
    void Serialize(Archive& archive) {
      archive(now, due, numbers);
    }
  };

  /// An agent of another program, in the world's frame.
  struct Agent {
    bool is_followed = false;
    Vec2 point;        // [m]
    Vec2 velocity;     // [m/s]
    double age = 0.0;  // time since its last state [s]

    template <class Archive>
    void Serialize(Archive& archive) {
      archive(is_followed, point, velocity, age);
    }
  };

  /// What changes of a person.
  struct Progress {
    uint32_t goal = 0;     // index of the present goal
    double stride = 0.25;  // completed fraction of a double step: at first, both feet are abreast
    double lifted = 0.0;   // height of the lifted foot, 0 to 1; negative for the right one
    Agent agent;

    template <class Archive>
    void Serialize(Archive& archive) {
      archive(goal, stride, lifted, agent);
    }
  };

  /// A person's motion, or that of another body, at the beginning of an update.
  struct Motion {
    Vec2 point;
    double yaw = 0.0;  // within [-pi, pi]
    Vec2 velocity;
  };

  /// Sums of accelerations [m/s^2].
  struct Forces {
    Vec2 repulsion, evasion;
  };

  static Motion MotionOf(const b2Body& body);
  void Update(Bodies& bodies, const Layers& layers, double dt);
  /// Finds the other bodies again, if any have been added or removed.
  void FindOthers(const Bodies& bodies);
  /// The desired direction, of length 1 at full speed; goes on to the next goal.
  Vec2 WayOf(size_t person);
  /// The forces of all that is around each person.
  void SumForces(const Layers& layers);
  Vec2 ForcedVelocity(size_t person, Vec2 noise, double dt);
  /// The velocity that leads to the agent in `dt` [s]; if that is far, jumps there.
  Vec2 FollowingVelocity(size_t person, Bodies& bodies, double dt);
  void JumpTo(const PersonSettings& person, Vec2 point, Bodies& bodies) const;
  void Walk(size_t person, Vec2 velocity, Bodies& bodies, double dt);
  void Step(size_t person, const Pose& after, const Twist& motion, Bodies& bodies, double dt);
  void Lift(size_t person, double phase, Bodies& bodies);
  double ReachOf(const PersonSettings& person) const;

  CrowdSettings settings_;
  std::vector<PersonSettings> people_;
  Clock clock_;
  std::vector<Progress> progress_;  // of each person

  // What was found around the people, and buffers of an update.
  uint64_t others_revision_ = 0;  // structure revision of `others_`
  std::vector<Outline> others_;
  std::vector<Motion> motions_, motions_of_others_;
  std::vector<Rotation> headings_of_others_;
  std::vector<Forces> forces_;
  std::vector<Obstacle> found_, walls_;
  std::vector<Vec2> new_velocities_;
};

}  // namespace flatland
