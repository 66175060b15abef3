/// WorldBatch: each environment is a world of its own, bit for bit.

#include "batch/world_batch.hpp"

#include <gtest/gtest.h>

#include <numeric>
#include <vector>

#include "test_bodies.hpp"
#include "test_numbers.hpp"

namespace flatland {
namespace {

constexpr int kBeams = 30;

/// Arrays for the rows of a batch.
struct Rows {
  explicit Rows(int count)
      : ranges(count * kBeams),
        poses(3 * count),
        velocities(3 * count),
        local_velocities(3 * count),
        collided(std::make_unique<bool[]>(count)),
        steps(count) {}

  BatchRows rows() {
    return {ranges.data(),           poses.data(),   velocities.data(),
            local_velocities.data(), collided.get(), steps.data()};
  }

  std::vector<float> ranges;
  std::vector<double> poses, velocities, local_velocities;
  std::unique_ptr<bool[]> collided;
  std::vector<int64_t> steps;
};

class WorldBatchTest : public WorldTest {
 protected:
  void AddWalls() {
    std::vector<Segment> walls;
    for (int i = 0; i < 40; ++i) {  // a wavy corridor
      const double x = i - 20.0, y = std::sin(x), next = std::sin(x + 1);
      walls.push_back({{x, y - 1}, {x + 1, next - 1}});
      walls.push_back({{x, y + 1}, {x + 1, next + 1}});
    }
    world_.AddLayer(walls, kAllLayers);
  }

  void AddBodies() {
    for (int i = 0; i < 6; ++i) AddBox(world_, {3.0 * i - 8, std::sin(3.0 * i - 8), 0.1 * i}, 0.3);
    const World::Body base = AddBox(world_, {0, 0, 0.5}, 0.4);
    const World::Body tail = AddBox(world_, {-0.3, -0.1, 0}, 0.1);
    world_.AddWeld(base, tail, WeldSettings());
    robot_.bodies = {base, tail};
    robot_.drive = world_.AddDrive(base, {2, 2, 3}, {});
    robot_.lidar = world_.lidars().Add(base, LidarOf(-2.0, 0.13, kBeams));
  }

  /// The action of an environment in a round: two numbers.
  static std::vector<double> ActionsOf(int round, int count) {
    std::vector<double> actions;
    for (int k = 0; k < count; ++k) {
      actions.push_back(1.5 + 0.1 * (k % 7));
      actions.push_back(std::sin(0.3 * round + k));
    }
    return actions;
  }

  void ExpectEnvironmentsToBeWorlds() {
    for (const int threads : {1, 3}) {
      WorldBatch batch(world_, {robot_}, 9, threads);
      Rows rows(9);
      for (const int k : {0, 4, 8}) {
        batch.Reset(nullptr, nullptr, rows.rows());
        const std::unique_ptr<World> alone = world_.Copy();
        for (int round = 0; round < 60; ++round) {
          const std::vector<double> actions = ActionsOf(round, 9);
          batch.Step(actions.data(), 7, kStep, rows.rows());
          alone->Get(std::get<World::Drive>(robot_.drive))
              .Command({actions[2 * k], 0.0, actions[2 * k + 1]});
          bool touches = false;
          for (int i = 0; i < 7; ++i) {
            alone->Step(kStep);
            touches = touches || alone->contacts().Touches(robot_.bodies);
          }
          const Pose pose = alone->GetPose(robot_.bodies[0]);
          ASSERT_EQ(rows.poses[3 * k], pose.x);
          ASSERT_EQ(rows.poses[3 * k + 1], pose.y);
          ASSERT_EQ(rows.collided[k], touches);
          const Lidar& lidar = alone->lidars().Scan(robot_.lidar);
          for (int i = 0; i < kBeams; ++i) {
            ASSERT_EQ(rows.ranges[k * kBeams + i], lidar.ranges[i]);
          }
        }
        EXPECT_EQ(rows.steps[k], 420);
      }
    }
  }

  BatchRobot robot_;
};

TEST_F(WorldBatchTest, AnEnvironmentIsAWorld) {
  AddWalls();
  AddBodies();
  ExpectEnvironmentsToBeWorlds();
}

TEST_F(WorldBatchTest, AnEnvironmentIsAWorldWithASmallTreeAndWithWallsThatWereAddedLater) {
  AddBodies();
  ExpectEnvironmentsToBeWorlds();
  AddWalls();
  ExpectEnvironmentsToBeWorlds();
}

TEST_F(WorldBatchTest, EnvironmentsThatAreNotResetGoOn) {
  AddWalls();
  AddBodies();
  WorldBatch batch(world_, {robot_}, 2, 2), other(world_, {robot_}, 2, 1);
  Rows rows(2), expected(2);
  const std::vector<double> poses{1, 1, 1, -3, -0.4, 2};
  for (int round = 0; round < 80; ++round) {
    const std::vector<double> actions = ActionsOf(round, 2);
    batch.Step(actions.data(), 5, kStep, rows.rows());
    other.Step(actions.data(), 5, kStep, expected.rows());
    ASSERT_EQ(rows.poses[0], expected.poses[0]);
    if (round == 20 || round == 37) {
      const bool mask[] = {false, true};
      batch.Reset(mask, poses.data(), rows.rows());
      EXPECT_FLOAT_EQ(rows.poses[3], -3);
      EXPECT_FLOAT_EQ(rows.poses[4], -0.4);
      EXPECT_EQ(rows.steps[1], 0);
    }
  }
}

TEST_F(WorldBatchTest, OnlyChosenEnvironmentsMakeSteps) {
  AddWalls();
  AddBodies();
  for (const int threads : {1, 2}) {
    WorldBatch batch(world_, {robot_}, 7, threads), all(world_, {robot_}, 7, 1);
    Rows rows(7), expected(7);
    for (int round = 0; round < 30; ++round) {
      const std::vector<double> actions = ActionsOf(round, 7);
      all.Step(actions.data(), 5, kStep, expected.rows());
      for (const int part : {0, 1, 2}) {  // two, three and two environments
        bool mask[7];
        std::vector<double> chosen(actions);
        for (int k = 0; k < 7; ++k) {
          mask[k] = (k + 1) / 3 == part;
          if (!mask[k]) chosen[2 * k] = kNaN;
        }
        batch.Step(chosen.data(), 5, kStep, rows.rows(), false, mask);
        EXPECT_EQ(rows.steps[0], 5 * (round + 1));
        EXPECT_EQ(rows.steps[6], 5 * (round + (part == 2 ? 1 : 0)));
      }
      ASSERT_EQ(rows.poses, expected.poses);
      ASSERT_EQ(rows.ranges, expected.ranges);
    }
    const bool none[7] = {};
    const std::vector<double> wrong(14, kNaN);
    batch.Step(wrong.data(), 5, kStep, rows.rows(), false, none);
    EXPECT_EQ(rows.poses, expected.poses);
    const bool one[7] = {false, true};
    EXPECT_THROW(batch.Step(wrong.data(), 5, kStep, rows.rows(), false, one),
                 std::invalid_argument);
  }
}

TEST_F(WorldBatchTest, SeveralRobotsOfAnEnvironmentAreThoseOfAWorld) {
  AddWalls();
  AddBodies();
  BatchRobot second;
  const World::Body disc = AddBox(world_, {1.5, 0.9, 3.0}, 0.3);
  second.bodies = {disc};
  second.drive = world_.AddDrive(disc, {2, 2, 3}, {});
  second.lidar = world_.lidars().Add(disc, LidarOf(-1.0, 0.1, kBeams));
  const std::vector<BatchRobot> robots{robot_, second};
  constexpr int kCount = 5, kAt = 2;  // the environment that is compared
  constexpr int kFirst = 2 * kAt, kSecond = kFirst + 1;
  for (const int threads : {1, 3}) {
    WorldBatch batch(world_, robots, kCount, threads);
    Rows rows(2 * kCount);
    const std::unique_ptr<World> alone = world_.Copy();
    float last = 0.0F;
    bool have_touched = false;
    for (int round = 0; round < 60; ++round) {
      std::vector<double> actions = ActionsOf(round, 2 * kCount);
      bool mask[2 * kCount];
      std::fill(mask, mask + 2 * kCount, true);
      if (round >= 40) {  // the first robot is left out, and so is an environment
        actions[2 * kFirst] = kNaN;
        mask[kFirst] = mask[0] = mask[1] = false;
      }
      batch.Step(actions.data(), 7, kStep, rows.rows(), false, mask);
      for (const int row : {kFirst, kSecond}) {
        const bool stops = round >= 40 && row == kFirst;
        alone->Get(std::get<World::Drive>(robots[row - kFirst].drive))
            .Command({stops ? 0 : actions[2 * row], 0, stops ? 0 : actions[2 * row + 1]});
      }
      bool touches = false;
      for (int i = 0; i < 7; ++i) {
        alone->Step(kStep);
        touches = touches || alone->contacts().Touches(second.bodies);
      }
      have_touched = have_touched || touches;
      ASSERT_EQ(rows.collided[kSecond], touches);
      ASSERT_EQ(rows.poses[3 * kSecond], alone->GetPose(disc).x);
      const float first = alone->lidars().Scan(robot_.lidar).ranges[7];
      if (round < 40) last = first;
      ASSERT_EQ(rows.ranges[kFirst * kBeams + 7], last);  // not written when it is left out
      ASSERT_EQ(rows.ranges[kSecond * kBeams + 7], alone->lidars().Scan(second.lidar).ranges[7]);
    }
    EXPECT_TRUE(have_touched);
    EXPECT_EQ(rows.steps[0], 280);
    EXPECT_EQ(rows.steps[kAt], 420);
  }
  second.action_size = 1;
  EXPECT_THROW(WorldBatch(world_, {robot_, second}, 1, 1), std::invalid_argument);
  EXPECT_THROW(WorldBatch(world_, {}, 1, 1), std::invalid_argument);
}

TEST_F(WorldBatchTest, RefusesWhatBox2DCannotComputeWith) {
  AddWalls();
  AddBodies();
  WorldBatch batch(world_, {robot_}, 2, 1);
  Rows before(2), rows(2);
  batch.Observe(before.rows());
  const std::vector<double> actions{1, 0, 1, kNaN}, poses{0, 0, 0, 1e9, 0, 0}, good(6, 0.0);
  EXPECT_THROW(batch.Step(actions.data(), 1, kStep, rows.rows()), std::invalid_argument);
  EXPECT_THROW(batch.Step(good.data(), 0, kStep, rows.rows()), std::invalid_argument);
  EXPECT_THROW(batch.Step(good.data(), 1, 0.0, rows.rows()), std::invalid_argument);
  EXPECT_THROW(batch.Reset(nullptr, poses.data(), rows.rows()), std::invalid_argument);
  batch.Observe(rows.rows());
  EXPECT_EQ(rows.poses, before.poses);
  EXPECT_EQ(rows.steps, before.steps);
  EXPECT_THROW(WorldBatch(world_, {robot_}, 0, 1), std::invalid_argument);
  EXPECT_THROW(WorldBatch(world_, {robot_}, 1, 0), std::invalid_argument);
}

TEST_F(WorldBatchTest, AReplacedEnvironmentIsAnotherWorld) {
  AddWalls();
  AddBodies();
  const std::unique_ptr<World> other = world_.Copy();
  other->AddLayer({{{1.0, -1.5}, {1.2, 1.5}}}, kAllLayers);
  WorldBatch batch(world_, {robot_}, 3, 2), shared(world_, {robot_}, 3, 1);
  Rows rows(3), expected(3);
  for (const bool is_again : {false, true}) {
    batch.Replace(1, *other);
    batch.Reset(nullptr, nullptr, rows.rows());
    shared.Reset(nullptr, nullptr, expected.rows());
    const std::unique_ptr<World> alone = other->Copy();
    for (int round = 0; round < 40; ++round) {
      const std::vector<double> actions = ActionsOf(round, 3);
      batch.Step(actions.data(), 5, kStep, rows.rows());
      shared.Step(actions.data(), 5, kStep, expected.rows());
      alone->Get(std::get<World::Drive>(robot_.drive)).Command({actions[2], 0.0, actions[3]});
      for (int i = 0; i < 5; ++i) alone->Step(kStep);
      ASSERT_EQ(rows.poses[3], alone->GetPose(robot_.bodies[0]).x) << is_again;
      ASSERT_EQ(rows.ranges[kBeams], alone->lidars().Scan(robot_.lidar).ranges[0]);
      ASSERT_EQ(rows.poses[0], expected.poses[0]);
      ASSERT_EQ(rows.poses[6], expected.poses[6]);
    }
    EXPECT_NE(rows.poses[3], expected.poses[3]);
  }
  EXPECT_THROW(batch.Replace(3, *other), std::invalid_argument);
}

TEST_F(WorldBatchTest, MotionsAreReadAndSet) {
  AddBodies();
  const World::Body box = AddBox(world_, {4, 4, 0}, 0.2);
  const std::vector<World::Body> bodies{box, robot_.bodies[0]};
  WorldBatch batch(world_, {robot_}, 3, 2);
  Rows rows(3);
  const bool mask[] = {false, true, true};
  std::vector<double> set(9, 0.0), poses(18, -1.0), velocities(18, -1.0);
  set[3] = 0.5;
  set[8] = 2.0;
  batch.SetVelocities(mask, {box}, set.data());
  const std::vector<double> actions(6, 0.25);
  batch.Advance(actions.data(), 20, kStep);
  batch.Step(actions.data(), 20, kStep, rows.rows(), true);
  batch.GetMotions(mask, bodies, poses.data(), velocities.data());
  EXPECT_EQ(rows.steps[0], 40);
  EXPECT_EQ(poses[0], -1.0);  // not chosen
  EXPECT_NEAR(poses[6], 4.0 + 40 * kStep * 0.5, 1e-5);
  EXPECT_NEAR(velocities[6], 0.5, 1e-6);
  EXPECT_NEAR(poses[14], 40 * kStep * 2.0, 1e-5);
  EXPECT_EQ(poses[9], rows.poses[3]);
  set[4] = kInfinity;
  EXPECT_THROW(batch.SetVelocities(nullptr, {box}, set.data()), std::invalid_argument);
}

TEST(ThreadTeamTest, SharesWorkInEqualParts) {
  ThreadTeam team(3);
  for (int run = 0; run < 50; ++run) {
    std::vector<int> done(10, 0);
    team.Run([&](int i) {
      for (int item = team.Begin(i, 10); item < team.Begin(i + 1, 10); ++item) ++done[item];
    });
    EXPECT_EQ(done, std::vector<int>(10, 1));
  }
  EXPECT_EQ(ThreadTeam(0).size(), 1);
}

}  // namespace
}  // namespace flatland
