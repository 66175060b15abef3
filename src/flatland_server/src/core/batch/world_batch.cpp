#include "batch/world_batch.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <map>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "base/box2d_limits.hpp"
#include "base/prefetch.hpp"
#include "batch/shared_world.hpp"
#include "world/world_state.hpp"

namespace flatland {
namespace {

/// Throws unless Box2D can compute with a model at this pose. Its position is doubled for the
/// check, as a body may be farther out than the origin of its model.
void RequirePose(const double* pose) {
  RequirePosition({2.0 * pose[0], 2.0 * pose[1]});
  Require(IsUsable(pose[2]), "a heading must be finite");
}

/// True if a row of the mask contains a true value. A null mask chooses all rows.
bool IsChosen(const bool* mask, int width, int row) {
  const bool* const begin = mask + int64_t{row} * width;
  return mask == nullptr || std::find(begin, begin + width, true) != begin + width;
}

void Put(double* row, double a, double b, double c) {
  row[0] = a;
  row[1] = b;
  row[2] = c;
}

}  // namespace

WorldBatch::WorldBatch(const World& world, const std::vector<BatchRobot>& robots, int count,
                       int threads, const std::vector<BatchModel>& models, int64_t steps,
                       const std::vector<int>& varied)
    : robots_(robots),
      models_(models),
      varied_(varied),
      first_step_(steps),
      team_(std::min(threads, count)) {
  Require(count >= 1, "a batch needs an environment");
  Require(threads >= 1, "a batch needs a thread");
  Require(!robots.empty(), "a batch needs a robot");
  for (const BatchRobot& robot : robots) {
    Require(!robot.bodies.empty(), "a robot needs a body");
    Require(robot.action_size == action_size(), "robots need equally many numbers in an action");
    moved_.insert(moved_.end(), robot.bodies.begin(), robot.bodies.end());
  }
  for (const BatchModel& model : models) {
    Require(!model.bodies.empty(), "a model needs a body");
    moved_.insert(moved_.end(), model.bodies.begin(), model.bodies.end());
  }
  environments_.resize(count);
  collided_.resize(static_cast<size_t>(row_count()));
  seen_.resize(collided_.size());
  for (int i = 0; i < team_.size(); ++i) {
    const auto shared = std::make_shared<SharedWorld>(world.Copy(), moved_, varied_);
    for (int row = team_.Begin(i, count); row < team_.Begin(i + 1, count); ++row) {
      environments_[row] = {shared, shared->MakeState(), steps};
    }
  }
  Environment& first = environments_[0];
  const SharedWorld::Entered entered(*first.world, *first.state);
  World& of_first = entered.world();
  beams_ = of_first.lidars().GetBeamCount(robots[0].lidar);
  for (const BatchRobot& robot : robots) {
    std::visit([&](auto drive) { of_first.Get(drive); }, robot.drive);
    Require(of_first.lidars().GetBeamCount(robot.lidar) == beams_,
            "robots need equally many beams");
  }
}

WorldBatch::~WorldBatch() = default;

template <class Visit>
void WorldBatch::ForEach(const bool* mask, int width, Visit visit) {
  team_.Run([&](int i) noexcept {
    const int end = team_.Begin(i + 1, count());
    const auto first_from = [mask, width, end](int row) {
      while (row < end && !IsChosen(mask, width, row)) ++row;
      return row;
    };
    // The present row, and the next ones, which are prefetched meanwhile.
    std::array<int, SharedWorld::kPrefetched + 1> rows;
    int row = team_.Begin(i, count());
    for (int& each : rows) row = (each = first_from(row)) + 1;
    while (rows[0] < end) {
      for (int k = 1; k <= SharedWorld::kPrefetched; ++k) {
        if (rows[k] < end) Prefetch(rows[k], k);
      }
      Environment& environment = environments_[rows[0]];
      visit(SharedWorld::Entered(*environment.world, *environment.state).world(), environment,
            rows[0]);
      std::move(rows.begin() + 1, rows.end(), rows.begin());
      rows.back() = first_from(rows.back() + 1);
    }
  });
}

void WorldBatch::Prefetch(int row, int distance) const {
  SharedState& state = *environments_[row].state;
  SharedWorld::Prefetch(state, distance);
  for (int i = 0; i < robot_count(); ++i) {
    const SeenWalls& seen = seen_[int64_t{row} * robot_count() + i];
    if (distance == 3) PrefetchBytes(&seen, offsetof(SeenWalls, walls));
    if (distance > 2 || seen.segments == nullptr) continue;
    const WallList next =
        seen.known.indices != nullptr ? seen.known : WallList{seen.walls, size_t(seen.count)};
    if (distance == 2) {
      if (seen.cell != nullptr) PrefetchBytes(seen.cell, 1);
      PrefetchBytes(next.indices, next.count * sizeof(uint32_t));
      continue;
    }
    if (state.walls() == nullptr) continue;  // the walls of all environments stay in the cache
    for (size_t k = 0; k < next.count; ++k) PrefetchBytes(&seen.segments[next.indices[k]], 1);
  }
}

void WorldBatch::RequireActions(const double* actions, const bool* mask) const {
  const int64_t width = action_size();
  for (int row = 0; row < row_count(); ++row) {
    if (mask != nullptr && !mask[row]) continue;
    const double* const begin = actions + width * row;
    if (std::all_of(begin, begin + width, [](double value) { return IsUsable(value); })) continue;
    std::ostringstream message;
    message << "expected actions of finite numbers, found [";
    for (int64_t i = 0; i < width; ++i) message << (i > 0 ? ", " : "") << begin[i];
    message << "] for ";
    if (robot_count() > 1) message << "robot " << row % robot_count() << " of ";
    message << "environment " << row / robot_count();
    throw std::invalid_argument(message.str());
  }
}

void WorldBatch::Advance(const bool* mask, const double* actions, int substeps, double dt,
                         const BatchRows* rows, bool goes_on) {
  Require(substeps >= 1, "expected 1 step or more");
  Require(IsUsable(dt) && dt >= kMinStep, "a step must be finite and longer than zero");
  RequireActions(actions, mask);
  const int robots = robot_count();
  ForEach(mask, robots, [&](World& world, Environment& environment, int row) {
    const int64_t first = int64_t{row} * robots;
    for (int i = 0; i < robots; ++i) {
      const bool is_driven = mask == nullptr || mask[first + i];
      Command(world, robots_[i], is_driven ? actions + (first + i) * action_size() : nullptr);
      if (!goes_on) collided_[first + i] = false;
    }
    for (int step = 0; step < substeps; ++step) {
      world.Step(dt);
      for (int i = 0; i < robots; ++i) {
        char& collided = collided_[first + i];
        collided = collided || world.contacts().Touches(robots_[i].bodies);
      }
    }
    environment.steps += substeps;
    if (rows != nullptr) Write(world, row, mask, *rows);
  });
}

void WorldBatch::Scatter(World::CrowdHandle crowd, const bool* mask, const uint64_t* keys) {
  scattered_ = crowd;
  crowd_keys_.resize(count());
  for (int row = 0; row < count(); ++row) {
    if (mask == nullptr || mask[row]) crowd_keys_[row] = keys[row];
  }
}

int WorldBatch::Reset(const bool* mask, const double* poses, const BatchRows& rows,
                      const double* model_poses) {
  const int64_t numbers = 3 * int64_t{model_count()};  // of a row of model_poses
  const int robots = robot_count();
  for (int row = 0; row < count(); ++row) {
    if (mask != nullptr && !mask[row]) continue;
    for (int i = 0; poses != nullptr && i < robots; ++i) {
      RequirePose(poses + 3 * (int64_t{row} * robots + i));
    }
    for (int64_t i = 0; model_poses != nullptr && i < numbers; i += 3) {
      RequirePose(model_poses + numbers * row + i);
    }
  }
  std::atomic<int> crowded = count();
  ForEach(mask, 1, [&](World& world, Environment& environment, int row) {
    environment.world->Begin(world, *environment.state);
    if (scattered_) {
      world.Get(*scattered_).Seed(crowd_keys_[row]);
      if (!world.ScatterCrowd(*scattered_)) {
        int least = crowded;
        while (row < least && !crowded.compare_exchange_weak(least, row)) {
        }
      }
    }
    const int64_t first = int64_t{row} * robots;
    for (int i = 0; poses != nullptr && i < robots; ++i) {
      Move(world, robots_[i].bodies, robots_[i].base, poses + 3 * (first + i));
    }
    for (int i = 0; model_poses != nullptr && i < model_count(); ++i) {
      Move(world, models_[i].bodies, models_[i].base, model_poses + numbers * row + 3 * i);
    }
    environment.steps = first_step_;
    std::fill_n(collided_.begin() + first, robots, false);
    Write(world, row, nullptr, rows);
  });
  return crowded < count() ? crowded.load() : -1;
}

void WorldBatch::MoveRobots(const bool* mask, const double* poses) {
  for (int row = 0; row < row_count(); ++row) {
    if (mask == nullptr || mask[row]) RequirePose(poses + 3 * int64_t{row});
  }
  const int robots = robot_count();
  ForEach(mask, robots, [&](World& world, Environment&, int row) {
    for (int i = 0; i < robots; ++i) {
      const int64_t at = int64_t{row} * robots + i;
      if (mask != nullptr && !mask[at]) continue;
      Move(world, robots_[i].bodies, robots_[i].base, poses + 3 * at);
    }
  });
}

std::string WorldBatch::SaveState(int row) {
  Require(row >= 0 && row < count(), "there is no such environment");
  const auto& [shared, state, steps] = environments_[row];
  return SharedWorld::Entered(*shared, *state).world().SaveState();
}

void WorldBatch::LoadStates(const bool* mask, const std::vector<std::string_view>& states,
                            const std::vector<std::shared_ptr<const VisibleWalls>>& walls,
                            const int64_t* chosen, const int64_t* steps, const BatchRows& rows) {
  /// A state as read for the environments that share a world, and the first of these environments.
  struct Read {
    WorldState state;
    int first;
  };
  std::map<std::pair<const SharedWorld*, int64_t>, Read> read;
  std::vector<const Read*> of(count());
  std::vector<std::unique_ptr<SharedState>> others(count());  // new states, where the walls change
  for (int row = 0; row < count(); ++row) {                   // first everything that may throw
    if (mask != nullptr && !mask[row]) continue;
    const int64_t index = chosen[row];
    Require(index >= 0 && index < static_cast<int64_t>(states.size()), "there is no such state");
    const auto& [shared, state, _] = environments_[row];
    if (state->walls() != walls[index]) {
      others[row] = shared->MakeState(walls[index]);
      others[row]->TakeSettings(*state);
    }
    const std::pair key(shared.get(), index);
    auto found = read.find(key);
    if (found == read.end()) {
      SharedState& reading = others[row] != nullptr ? *others[row] : *state;
      found = read.insert({key, {shared->Read(states[index], reading), row}}).first;
    }
    of[row] = &found->second;
  }
  for (int row = 0; row < count(); ++row) {
    if (others[row] == nullptr) continue;
    environments_[row].state = std::move(others[row]);
    ForgetScans(row);
  }
  ForEach(mask, 1, [&](World& world, Environment& environment, int row) {
    of[row]->state.Restore(world);
    environment.steps = steps[row];
    std::fill_n(collided_.begin() + int64_t{row} * robot_count(), robot_count(), false);
    if (of[row]->first == row) Write(world, row, nullptr, rows);
  });
  for (int row = 0; row < count(); ++row) {
    if (of[row] != nullptr && of[row]->first != row) CopyRows(rows, of[row]->first, row);
  }
}

void WorldBatch::Observe(const BatchRows& rows) {
  ForEach(nullptr, 1,
          [&](World& world, Environment&, int row) { Write(world, row, nullptr, rows); });
}

void WorldBatch::Replace(int row, const World& world) {
  Require(row >= 0 && row < count(), "there is no such environment");
  const auto own = std::make_shared<SharedWorld>(world.Copy(), moved_, varied_);
  Begin(row, {own, own->MakeState(), 0});
}

void WorldBatch::SetWalls(int row, std::shared_ptr<const VisibleWalls> walls) {
  Require(row >= 0 && row < count(), "there is no such environment");
  const auto& [shared, state, steps] = environments_[row];
  if (state->walls() != walls) Begin(row, {shared, shared->MakeState(std::move(walls)), 0});
}

void WorldBatch::SetSettings(const bool* mask, const double* values) {
  for (int row = 0; row < count(); ++row) {
    if (mask != nullptr && !mask[row]) continue;
    const auto& [shared, state, steps] = environments_[row];
    shared->Set(*state, values + int64_t{row} * varied_count());
  }
}

void WorldBatch::Begin(int row, Environment environment) {
  environment.state->TakeSettings(*environments_[row].state);
  environments_[row] = std::move(environment);
  const int64_t first = int64_t{row} * robot_count();
  std::fill_n(collided_.begin() + first, robot_count(), false);
  ForgetScans(row);
}

void WorldBatch::ForgetScans(int row) {
  std::fill_n(seen_.begin() + int64_t{row} * robot_count(), robot_count(), SeenWalls{});
}

void WorldBatch::Seed(const bool* mask, const Random& random, const uint64_t* keys) {
  ForEach(mask, 1, [&](World& world, Environment&, int row) {
    std::visit([&](auto handle) { world.Get(handle).Seed(keys[row]); }, random);
  });
}

void WorldBatch::GetMotions(const bool* mask, const std::vector<World::Body>& bodies, double* poses,
                            double* velocities) {
  const auto width = static_cast<int64_t>(3 * bodies.size());
  ForEach(mask, 1, [&](World& world, Environment&, int row) {
    int64_t at = width * row;
    for (const World::Body& body : bodies) {
      const Pose pose = Wrapped(world.GetPose(body));
      const Twist velocity = world.GetVelocity(body);
      Put(poses + at, pose.x, pose.y, pose.yaw);
      Put(velocities + at, velocity.vx, velocity.vy, velocity.omega);
      at += 3;
    }
  });
}

void WorldBatch::SetVelocities(const bool* mask, const std::vector<World::Body>& bodies,
                               const double* velocities) {
  const auto width = static_cast<int64_t>(3 * bodies.size());
  for (int row = 0; row < count(); ++row) {
    if (mask != nullptr && !mask[row]) continue;
    for (int64_t i = width * row; i < width * (row + 1); ++i) {
      Require(IsUsable(velocities[i]), "a velocity must be finite");
    }
  }
  ForEach(mask, 1, [&](World& world, Environment&, int row) {
    const double* velocity = velocities + width * row;
    for (const World::Body& body : bodies) {
      world.SetVelocity(body, {velocity[0], velocity[1], velocity[2]});
      velocity += 3;
    }
  });
}

void WorldBatch::Command(World& world, const BatchRobot& robot, const double* action) {
  double values[3];
  for (int i = 0; i < 3; ++i) {
    values[i] = action == nullptr || robot.columns[i] < 0 ? 0.0 : action[robot.columns[i]];
  }
  if (const auto* drive = std::get_if<World::Drive>(&robot.drive)) {
    world.Get(*drive).Command({values[0], values[1], values[2]});
  } else if (const auto* tricycle = std::get_if<World::Tricycle>(&robot.drive)) {
    world.Get(*tricycle).Command(values[0], values[1]);
  } else {
    world.Get(std::get<World::Ackermann>(robot.drive)).Command({values[0], values[1]});
  }
}

void WorldBatch::Move(World& world, const std::vector<World::Body>& bodies, const Pose& base,
                      const double* pose) {
  const Pose first = Wrapped(world.GetPose(bodies.front()));
  const Pose present = Wrapped(Compose(first, Inverse(base)));
  const Pose displacement = Wrapped(Compose({pose[0], pose[1], pose[2]}, Inverse(present)));
  for (const World::Body& body : bodies) {
    world.SetPose(body, Compose(displacement, world.GetPose(body)));
  }
  for (const World::Body& body : bodies) world.Halt(body);
}

void WorldBatch::CopyRows(const BatchRows& rows, int from, int to) const {
  const int64_t robots = robot_count();
  const auto copy = [&](auto* values, int64_t width) {
    std::copy_n(values + from * robots * width, robots * width, values + to * robots * width);
  };
  copy(rows.ranges, beams_);
  for (double* each : {rows.poses, rows.velocities, rows.local_velocities}) copy(each, 3);
  copy(rows.collided, 1);
  rows.steps[to] = environments_[to].steps;
}

void WorldBatch::Write(World& world, int row, const bool* mask, const BatchRows& rows) {
  for (int i = 0; i < robot_count(); ++i) {
    const int64_t at = int64_t{row} * robot_count() + i;
    if (mask != nullptr && !mask[at]) continue;
    const World::Body body = robots_[i].bodies.front();
    const Pose pose = Wrapped(world.GetPose(body));
    const Twist velocity = world.GetVelocity(body);
    const Twist local = world.GetLocalVelocity(body);
    world.lidars().ScanInto(robots_[i].lidar, rows.ranges + at * beams_, seen_[at],
                            World::AccessGuard(world));
    Put(rows.poses + 3 * at, pose.x, pose.y, pose.yaw);
    Put(rows.velocities + 3 * at, velocity.vx, velocity.vy, velocity.omega);
    Put(rows.local_velocities + 3 * at, local.vx, local.vy, local.omega);
    rows.collided[at] = collided_[at];
  }
  rows.steps[row] = environments_[row].steps;
}

}  // namespace flatland
