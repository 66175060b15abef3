#pragma once

/// Many environments, each with a state of the same world and one robot or several, stepped in one
/// call.
///
/// Environments do not influence each other, and each makes the steps that a World of its own
/// makes: whatever their number, and on however many threads.
///
/// The functions are for one thread at a time. They write to arrays of the caller, and keep none.

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "base/parallel.hpp"
#include "world/world.hpp"

namespace flatland {

/// A robot of each environment, named by handles of the world.
struct BatchRobot {
  std::vector<World::Body> bodies;  ///< all of its bodies; poses and velocities are of the first
  Pose base;                        ///< pose of the first body in the robot's frame [m, m, rad]
  std::variant<World::Drive, World::Tricycle, World::Ackermann> drive;
  /// Index in an action of each number of the drive: vx, vy and omega, or speed and steering angle.
  /// With -1, 0 is commanded.
  std::array<int, 3> columns{0, -1, 1};
  int action_size = 2;  ///< number of numbers in an action
  World::LidarHandle lidar;
};

/// A model that Reset puts elsewhere.
struct BatchModel {
  std::vector<World::Body> bodies;  ///< all of its bodies
  Pose base;                        ///< pose of the first body in the model's frame [m, m, rad]
};

/// Where observations are written to: an array each, with a row for each robot of each environment.
struct BatchRows {
  float* ranges;             ///< [m], or +infinity; as many as the lidar has beams
  double* poses;             ///< x, y [m] and yaw in [-pi, pi] [rad], in the world
  double* velocities;        ///< vx, vy [m/s] and omega [rad/s] of the origin, in the world's frame
  double* local_velocities;  ///< the same in the body's frame
  bool* collided;            ///< true if the robot has touched something solid since the last row
  int64_t* steps;            ///< made since the beginning or the last reset; for each environment
};

class SharedState;
class VisibleWalls;
class SharedWorld;

class WorldBatch {
 public:
  /// Environments that begin as copies of a world that has made `steps` steps. Throws
  /// std::invalid_argument if there is no environment or thread, if the robots do not have equally
  /// many beams and numbers in an action, and GoneError for a wrong handle. `models` are those that
  /// Reset may put elsewhere, `varied` the indices of the settings (settings.hpp) that SetSettings
  /// may set.
  WorldBatch(const World& world, const std::vector<BatchRobot>& robots, int count, int threads,
             const std::vector<BatchModel>& models = {}, int64_t steps = 0,
             const std::vector<int>& varied = {});
  ~WorldBatch();

  int count() const { return static_cast<int>(environments_.size()); }
  int beams() const { return beams_; }
  int action_size() const { return robots_[0].action_size; }
  int robot_count() const { return static_cast<int>(robots_.size()); }
  /// The number of robots in all environments.
  int row_count() const { return count() * robot_count(); }
  int varied_count() const { return static_cast<int>(varied_.size()); }
  int model_count() const { return static_cast<int>(models_.size()); }

  /// Throws std::invalid_argument, with the place, unless all actions that `mask` (count x robots;
  /// null: all) chooses are finite.
  void RequireActions(const double* actions, const bool* mask = nullptr) const;
  /// Commands the robots that `mask` (count x robots; null: all) chooses with their rows of
  /// `actions` (count x robots x action_size), makes `substeps` steps of `dt` [s] in their
  /// environments, and writes their rows. Other robots of these environments are commanded to stop,
  /// their actions are not read and their rows not written; other environments stay as they are.
  /// With `goes_on`, collisions in the steps of the last call of Advance count, too. Throws
  /// std::invalid_argument, and changes nothing, if an action is not finite.
  void Step(const double* actions, int substeps, double dt, const BatchRows& rows,
            bool goes_on = false, const bool* mask = nullptr) {
    Advance(mask, actions, substeps, dt, &rows, goes_on);
  }
  /// Like Step, but writes no rows: for the caller to look at bodies between steps.
  void Advance(const double* actions, int substeps, double dt, bool goes_on = false,
               const bool* mask = nullptr) {
    Advance(mask, actions, substeps, dt, nullptr, goes_on);
  }
  /// From now on, a Reset begins the random numbers of a crowd by the key of the environment, and
  /// lets its people draw their places (Crowd::Scatter). `keys` (count) are of the environments
  /// that `mask` (null: all) chooses; others keep theirs, which are 0 at first.
  void Scatter(World::CrowdHandle crowd, const bool* mask, const uint64_t* keys);
  /// Puts the environments that `mask` (count; null: all) chooses back to the beginning, moves
  /// their robots to `poses` (count x robots x 3: x, y [m], yaw [rad]; null: they stay) and then
  /// the models to `model_poses` (count x models x 3; null: they stay), and writes their rows.
  /// Throws std::invalid_argument, and changes nothing, for a pose that Box2D cannot compute with.
  /// Returns the first environment in which people have found no places, or -1.
  int Reset(const bool* mask, const double* poses, const BatchRows& rows,
            const double* model_poses = nullptr);
  /// Moves the robots that `mask` (count x robots; null: all) chooses to `poses` (count x robots x
  /// 3), and stops them; their commands hold. Throws as Reset does. No row is written.
  void MoveRobots(const bool* mask, const double* poses);
  /// Lets an environment begin as a copy of another world from now on. That world must have made no
  /// step, and the same handles must name the same things in it, as in the same world with other
  /// walls. The copy is not shared with other environments. Its row is not written.
  void Replace(int row, const World& world);
  /// Lets an environment begin again with other walls in the first layer, or with those of the
  /// world (null). Its row is not written. Throws std::invalid_argument, and changes nothing, in a
  /// world without a layer, or where environments begin near walls.
  void SetWalls(int row, std::shared_ptr<const VisibleWalls> walls);
  /// Gives the environments that `mask` chooses (count; null: all) their values (count x varied) of
  /// the settings that vary; masses follow with the next Reset. Throws std::invalid_argument, and
  /// changes nothing in further environments, if a body cannot have its mass.
  void SetSettings(const bool* mask, const double* values);
  /// The state of an environment, equal to what World::SaveState returns for an equal world.
  std::string SaveState(int row);
  /// Puts each environment that `mask` chooses (null: all) into a saved state, and writes its row.
  /// `chosen` (count) has the index of each environment's state in `states`, and `steps` (count)
  /// the number of steps that it has made. `walls` are those of each state (see SetWalls). Throws
  /// std::invalid_argument, and changes nothing, if a state is damaged, or of another world.
  void LoadStates(const bool* mask, const std::vector<std::string_view>& states,
                  const std::vector<std::shared_ptr<const VisibleWalls>>& walls,
                  const int64_t* chosen, const int64_t* steps, const BatchRows& rows);
  /// Writes all rows; `collided` as in the last row.
  void Observe(const BatchRows& rows);

  /// Something in the core that draws random numbers.
  using Random = std::variant<World::CrowdHandle, World::Drive, World::Tricycle, World::Ackermann>;
  /// Seeds its random numbers anew, with a key for each environment that `mask` chooses (null:
  /// all).
  void Seed(const bool* mask, const Random& random, const uint64_t* keys);
  /// Writes the poses of bodies (x, y [m] and yaw in [-pi, pi] [rad]) and the velocities of their
  /// origins [m/s, m/s, rad/s], in the world's frame, to the rows (count x bodies x 3) of the
  /// environments that `mask` chooses (null: all).
  void GetMotions(const bool* mask, const std::vector<World::Body>& bodies, double* poses,
                  double* velocities);
  /// Sets the velocities of bodies (count x bodies x 3) in the environments that `mask` chooses
  /// (null: all). Throws std::invalid_argument, and changes nothing, if one is not finite.
  void SetVelocities(const bool* mask, const std::vector<World::Body>& bodies,
                     const double* velocities);

 private:
  struct Environment {
    std::shared_ptr<SharedWorld> world;  // that of its thread, or its own
    std::unique_ptr<SharedState> state;
    int64_t steps = 0;
  };

  /// Replaces an environment, and forgets the collisions and scans of the former one.
  void Begin(int row, Environment environment);
  /// Forgets what was seen of walls that may be gone now.
  void ForgetScans(int row);
  /// Calls `visit(world, environment, row)`, with the world in the environment's state, for each
  /// environment with a true among its `width` values of `mask` (null: all). Works on all threads;
  /// each has a world and some of the environments.
  template <class Visit>
  void ForEach(const bool* mask, int width, Visit visit);
  /// Prefetches what a visit of an environment will need, as SharedWorld::Prefetch: `distance` is
  /// how many visits come before it.
  void Prefetch(int row, int distance) const;
  void Advance(const bool* mask, const double* actions, int substeps, double dt,
               const BatchRows* rows, bool goes_on);
  /// Commands a robot to stop if its action is null.
  static void Command(World& world, const BatchRobot& robot, const double* action);
  /// Moves a model as Model.move does: with the same arithmetic.
  static void Move(World& world, const std::vector<World::Body>& bodies, const Pose& base,
                   const double* pose);
  /// Makes the rows of environment `to` equal to those of `from`.
  void CopyRows(const BatchRows& rows, int from, int to) const;
  /// Writes the rows of an environment's robots, of those that `mask` (count x robots) chooses.
  void Write(World& world, int row, const bool* mask, const BatchRows& rows);

  std::vector<BatchRobot> robots_;
  std::vector<BatchModel> models_;
  std::vector<World::Body> moved_;  // those of the robots and the models
  std::vector<int> varied_;
  std::optional<World::CrowdHandle> scattered_;
  std::vector<uint64_t> crowd_keys_;  // of each environment
  int beams_ = 0;
  int64_t first_step_ = 0;  // steps that the copied world had made
  std::vector<Environment> environments_;
  std::vector<char> collided_;   // for each robot of each environment
  std::vector<SeenWalls> seen_;  // the same: the walls in its last scan
  ThreadTeam team_;
};

}  // namespace flatland
