#pragma once

/// People who walk between goals, and give way to walls, bodies and each other.
///
/// A crowd sets the velocities of its people at its updates, several times a second. Between two
/// updates Box2D moves them, and resolves collisions: they are bodies like others, without a drive.
/// The next update starts from the result. In an update, each person chooses a velocity by the
/// forces of what is around it (social_force.hpp, obstacles.hpp), or by ORCA (orca.hpp), or
/// follows an agent of another program; then turns that way, and its legs step.
///
/// Dynamic bodies that are no people are robots. A person may give way to them late, or not at all:
/// that is decided by chance at the beginning of an encounter, when a robot comes near. It does not
/// walk into a robot that stands in its view, unless it sees none at all.
///
/// A body may follow recorded people (recording.hpp). While there is none, it is far away.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "base/collision_layers.hpp"
#include "base/normal_numbers.hpp"
#include "people/orca.hpp"
#include "people/recording.hpp"
#include "people/social_force.hpp"
#include "world/bodies.hpp"

namespace flatland {

class Layers;
struct Outline;

struct CrowdSettings {
  LayerBits layers = kAllLayers;  ///< people avoid the walls and bodies on these
  double period = 0.0;            ///< between two updates [ns]; 0: one before each step
  double goal_radius = 0.3;       ///< distance at which a goal counts as reached [m]
  SocialForce force;
  std::optional<OrcaSettings> orca;  ///< moves the people instead of the forces
  double begin = 0.0;                ///< of the recordings that people follow, at time 0 [ns]
};

/// A rectangle [m].
struct Area {
  Vec2 low, high;
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
  bool sees_robots = true;             ///< false: it takes no notice of them
  double yields = 1.0;                 ///< probability that it gives way in an encounter
  double reaction_time = 0.0;          ///< from seeing a robot to giving way [s]
  double field_of_view = 2.0 * M_PI;   ///< in which it sees people and robots [rad]
  int group = -1;                      ///< number of its group, which keeps together; -1: none
  std::shared_ptr<const Recording> recording;  ///< followed instead of `goals`
  std::optional<Area> area;  ///< in which places and goals are drawn, instead of `goals`
  bool stands = false;       ///< at its drawn place
};

class Crowd {
 public:
  /// The distances [m] of a person's middle from the nearest wall, body and other person; infinite
  /// if there is none, or no wall within reach of the forces.
  struct Clearances {
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
  /// Puts people with areas at drawn places, away from walls, bodies and each other: one for which
  /// none is found stays. Puts those that follow a recording where it begins. Returns whether
  /// those who stay have room there.
  bool Scatter(Bodies& bodies, const Layers& layers);
  /// The distances around each person at present.
  std::vector<Clearances> GetClearances(const Bodies& bodies, const Layers& layers);
  /// Copies the changing state of an equal crowd.
  void Take(const Crowd& other) {
    clock_ = other.clock_;
    std::copy(other.progress_.begin(), other.progress_.end(), progress_.begin());
  }
  /// Updates what lidars see after the state was restored.
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
    int64_t begin = 0;  // of recordings, at time 0 [ns]

    template <class Archive>
    void Serialize(Archive& archive) {
      archive(now, due, numbers, begin);
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
    uint32_t goal = 0;       // index of the present goal
    bool has_met = false;    // a robot is near
    bool gives_way = true;   // to the robots of this encounter
    bool has_drawn = false;  // a goal
    double stride = 0.25;    // completed fraction of a double step: at first, both feet are abreast
    double lifted = 0.0;     // height of the lifted foot, 0 to 1; negative for the right one
    Agent agent;
    double seen_for = 0.0;  // time for which it has seen robots in this encounter [s]
    Vec2 drawn_goal;        // [m]
    int32_t walk = -1;      // of the recording; -1: it is away

    template <class Archive>
    void Serialize(Archive& archive) {
      archive(goal, stride, lifted, agent, has_met, gives_way, seen_for, has_drawn, drawn_goal,
              walk);
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
  /// Looks for the other bodies again if any have been added or removed.
  void FindOthers(const Bodies& bodies);
  /// The desired direction, of length 1 at full speed. Switches to the next goal at a goal.
  Vec2 DesiredDirection(size_t person, const Layers& layers);
  /// Draws a point of a person's area that is clear of walls and for which `is_free(point)` is
  /// true; none if that fails several times.
  template <class IsFree>
  std::optional<Vec2> DrawPoint(size_t person, const Layers& layers, IsFree is_free);
  /// Decides which people give way to robots.
  void UpdateEncounters(double dt);
  /// True if something in this direction, of length 1, is in a person's field of view.
  bool Sees(size_t person, Vec2 direction) const;
  Obstacle SeenOther(size_t person, size_t other) const;
  /// True if a person avoids another body that is in view. Everybody avoids what is no robot.
  bool Avoids(size_t person, size_t other) const;
  /// The forces of all that is around each person.
  void SumForces(const Layers& layers);
  Vec2 GroupForce(size_t person) const;
  /// For `left`, see SocialForce::Relax.
  Vec2 ForcedVelocity(size_t person, Vec2 way, Vec2 noise, double left);
  Vec2 OrcaVelocity(size_t person, Vec2 way, Vec2 noise, const Layers& layers, double dt);
  void SortByX();
  /// Finds the nearest people whom a person sees, of those within the distance of ORCA.
  void FindNeighbors(size_t person);
  /// The velocity that leads to the agent in `dt` [s]; if that is far, jumps there.
  Vec2 FollowingVelocity(size_t person, Bodies& bodies, double dt);
  /// Puts a person where its recording is at the present time, if it cannot walk there.
  void Replay(size_t person, Bodies& bodies);
  /// The velocity that leads to where the recording is after `dt` [s].
  Vec2 ReplayedVelocity(size_t person, Bodies& bodies, double dt);
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
  Walkers walkers_;
  std::vector<uint32_t> near_walkers_;
  std::vector<Obstacle> found_, walls_;
  std::vector<Vec2> new_velocities_;
  std::vector<char> gives_way_;  // of each person, to robots
  std::vector<uint32_t> by_x_;   // people in the order of their x
  std::vector<uint32_t> rank_;   // of each person in `by_x_`
  std::vector<std::pair<double, uint32_t>> near_;
  std::vector<OrcaNeighbor> neighbors_;
  std::vector<HalfPlane> planes_;
};

}  // namespace flatland
