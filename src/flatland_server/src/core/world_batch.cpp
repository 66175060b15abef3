#include "flatland_server/world_batch.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <stdexcept>

#include "box2d_limits.hpp"

namespace flatland {
namespace {

/// Twice as far as it may be: bodies are beside their model's origin.
void RequirePose(const double* pose) {
  RequirePosition({2.0 * pose[0], 2.0 * pose[1]});
  Require(IsUsable(pose[2]), "a heading must be finite");
}

void Put(double* row, double a, double b, double c) {
  row[0] = a;
  row[1] = b;
  row[2] = c;
}

}  // namespace

WorldBatch::WorldBatch(const World& world, const BatchRobot& robot, int count, int threads,
                       const std::vector<BatchModel>& models)
    : robot_(robot), models_(models), team_(std::min(threads, count)) {
  Require(count >= 1, "a batch needs an environment");
  Require(threads >= 1, "a batch needs a thread");
  Require(!robot.bodies.empty(), "a robot needs a body");
  for (const BatchModel& model : models) Require(!model.bodies.empty(), "a model needs a body");
  moved_ = robot.bodies;
  for (const BatchModel& model : models) {
    moved_.insert(moved_.end(), model.bodies.begin(), model.bodies.end());
  }
  for (int i = 0; i < team_.size(); ++i) {
    worlds_.push_back(std::make_unique<SharedWorld>(world.Copy(), moved_));
  }
  environments_.resize(count);
  for (int i = 0; i < team_.size(); ++i) {
    for (int row = team_.Begin(i, count); row < team_.Begin(i + 1, count); ++row) {
      environments_[row].state = worlds_[i]->MakeState();
    }
  }
  World& first = worlds_[0]->Enter(*environments_[0].state);
  beams_ = first.lidars().GetBeamCount(robot.lidar);
  for (const World::Body& body : robot.bodies) first.GetPose(body);
  for (const BatchModel& model : models) {
    for (const World::Body& body : model.bodies) first.GetPose(body);
  }
  std::visit([&](auto drive) { first.Get(drive); }, robot.drive);
  worlds_[0]->Leave(*environments_[0].state);
}

WorldBatch::~WorldBatch() = default;

template <class Visit>
void WorldBatch::ForEach(const bool* mask, Visit visit) {
  team_.Run([&](int i) noexcept {
    const int end = team_.Begin(i + 1, count());
    const auto first_from = [mask, end](int row) {
      while (mask != nullptr && row < end && !mask[row]) ++row;
      return row;
    };
    int row = first_from(team_.Begin(i, count()));
    int next = first_from(row + 1);
    while (row < end) {
      const int later = first_from(next + 1);
      if (next < end) SharedWorld::Prefetch(*environments_[next].state);
      if (later < end) SharedWorld::PrefetchPlaces(*environments_[later].state);
      Environment& environment = environments_[row];
      visit(environment.own ? *environment.own : *worlds_[i], environment, row);
      row = next;
      next = later;
    }
  });
}

void WorldBatch::RequireActions(const double* actions, const bool* mask) const {
  const int64_t width = robot_.action_size;
  for (int row = 0; row < count(); ++row) {
    if (mask != nullptr && !mask[row]) continue;
    const double* const begin = actions + width * row;
    if (std::all_of(begin, begin + width, [](double value) { return IsUsable(value); })) continue;
    std::ostringstream message;
    message << "expected actions of finite numbers, found [";
    for (int64_t i = 0; i < width; ++i) message << (i > 0 ? ", " : "") << begin[i];
    message << "] for environment " << row;
    throw std::invalid_argument(message.str());
  }
}

void WorldBatch::Advance(const bool* mask, const double* actions, int substeps, double dt,
                         const BatchRows* rows, bool goes_on) {
  Require(substeps >= 1, "expected 1 step or more");
  Require(IsUsable(dt) && dt >= kMinStep, "a step must be finite and longer than zero");
  RequireActions(actions, mask);
  const int64_t width = robot_.action_size;
  ForEach(mask, [&](SharedWorld& shared, Environment& environment, int row) {
    World& world = shared.Enter(*environment.state);
    Command(world, actions + width * row);
    environment.collided = environment.collided && goes_on;
    for (int i = 0; i < substeps; ++i) {
      world.Step(dt);
      environment.collided = environment.collided || world.contacts().Touches(robot_.bodies);
    }
    environment.steps += substeps;
    if (rows != nullptr) Write(world, environment, row, *rows);
    shared.Leave(*environment.state);
  });
}

void WorldBatch::Reset(const bool* mask, const double* poses, const BatchRows& rows,
                       const double* model_poses) {
  const int64_t numbers = 3 * int64_t{model_count()};  // of a row of model_poses
  for (int row = 0; row < count(); ++row) {
    if (mask != nullptr && !mask[row]) continue;
    if (poses != nullptr) RequirePose(poses + 3 * int64_t{row});
    for (int64_t i = 0; model_poses != nullptr && i < numbers; i += 3) {
      RequirePose(model_poses + numbers * row + i);
    }
  }
  ForEach(mask, [&](SharedWorld& shared, Environment& environment, int row) {
    shared.Restart(*environment.state);
    World& world = shared.Enter(*environment.state);
    if (poses != nullptr) Move(world, robot_.bodies, robot_.base, poses + 3 * int64_t{row});
    for (int i = 0; model_poses != nullptr && i < model_count(); ++i) {
      Move(world, models_[i].bodies, models_[i].base, model_poses + numbers * row + 3 * i);
    }
    environment.steps = 0;
    environment.collided = false;
    Write(world, environment, row, rows);
    shared.Leave(*environment.state);
  });
}

void WorldBatch::Observe(const BatchRows& rows) {
  ForEach(nullptr, [&](SharedWorld& shared, Environment& environment, int row) {
    Write(shared.Enter(*environment.state), environment, row, rows);
    shared.Leave(*environment.state);
  });
}

void WorldBatch::Replace(int row, const World& world) {
  Require(row >= 0 && row < count(), "there is no such environment");
  auto own = std::make_unique<SharedWorld>(world.Copy(), moved_);
  Environment& environment = environments_[row];
  environment.state = own->MakeState();  // the former one is destroyed before its world
  environment.own = std::move(own);
  environment.steps = 0;
  environment.collided = false;
}

void WorldBatch::SeedCrowd(const bool* mask, World::CrowdHandle crowd, const uint64_t* keys) {
  ForEach(mask, [&](SharedWorld& shared, Environment& environment, int row) {
    shared.Enter(*environment.state).Get(crowd).Seed(keys[row]);
    shared.Leave(*environment.state);
  });
}

void WorldBatch::GetMotions(const bool* mask, const std::vector<World::Body>& bodies, double* poses,
                            double* velocities) {
  const auto width = static_cast<int64_t>(3 * bodies.size());
  ForEach(mask, [&](SharedWorld& shared, Environment& environment, int row) {
    const World& world = shared.Enter(*environment.state);
    int64_t at = width * row;
    for (const World::Body& body : bodies) {
      const Pose pose = Wrapped(world.GetPose(body));
      const Twist velocity = world.GetVelocity(body);
      Put(poses + at, pose.x, pose.y, pose.yaw);
      Put(velocities + at, velocity.vx, velocity.vy, velocity.omega);
      at += 3;
    }
    shared.Leave(*environment.state);
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
  ForEach(mask, [&](SharedWorld& shared, Environment& environment, int row) {
    World& world = shared.Enter(*environment.state);
    const double* velocity = velocities + width * row;
    for (const World::Body& body : bodies) {
      world.SetVelocity(body, {velocity[0], velocity[1], velocity[2]});
      velocity += 3;
    }
    shared.Leave(*environment.state);
  });
}

void WorldBatch::Command(World& world, const double* action) const {
  double values[3];
  for (int i = 0; i < 3; ++i) values[i] = robot_.columns[i] < 0 ? 0.0 : action[robot_.columns[i]];
  if (const auto* drive = std::get_if<World::Drive>(&robot_.drive)) {
    world.Get(*drive).Command({values[0], values[1], values[2]});
  } else {
    world.Get(std::get<World::Tricycle>(robot_.drive)).Command(values[0], values[1]);
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

void WorldBatch::Write(World& world, const Environment& environment, int row,
                       const BatchRows& rows) const {
  const World::Body body = robot_.bodies.front();
  const Pose pose = Wrapped(world.GetPose(body));
  const Twist velocity = world.GetVelocity(body);
  const Twist local = world.GetLocalVelocity(body);
  world.lidars().ScanInto(robot_.lidar, rows.ranges + int64_t{row} * beams_,
                          World::AccessGuard(world));
  Put(rows.poses + 3 * row, pose.x, pose.y, pose.yaw);
  Put(rows.velocities + 3 * row, velocity.vx, velocity.vy, velocity.omega);
  Put(rows.local_velocities + 3 * row, local.vx, local.vy, local.omega);
  rows.collided[row] = environment.collided;
  rows.steps[row] = environment.steps;
}

}  // namespace flatland
