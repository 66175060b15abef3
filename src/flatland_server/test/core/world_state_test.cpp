/// Saving and restoring a world; test_core_state.py compares whole runs, bit for bit.

#include <gtest/gtest.h>

#include <cstring>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "base/archive.hpp"
#include "test_bodies.hpp"
#include "world/world.hpp"

namespace flatland {
namespace {

/// A box that a driven one pushes against a wall, on two joints, and a door.
class Scene {
 public:
  Scene() {
    world.AddLayer({{{-2, -2}, {-2, 2}}, {{-2, 2}, {3, 2}}}, kAllLayers);
    pusher = AddBox(world, {1.5, 0, 0});
    box = AddBox(world, {0, 0.1, 0.2});
    const World::Body trailer = AddBox(world, {3.0, 0, 0});
    world.AddRevolute(pusher, trailer, {{{0.75, 0}, {-0.75, 0}, false}, std::nullopt});
    drive = world.AddDrive(pusher, {}, {});
    world.Get(drive).Command({-1, 0, 0});
    TweenSettings settings;
    settings.delta = {0, 1, 0};
    tween = world.AddTween(AddBox(world, {0, -3, 0}), settings);
  }

  std::vector<Pose> Run(int steps) {
    std::vector<Pose> poses;
    for (int i = 0; i < steps; ++i) {
      world.Step(0.01);
      poses.push_back(world.GetPose(box));
      poses.push_back(world.GetPose(pusher));
    }
    return poses;
  }

  World world{10, 10};
  World::Body pusher;
  World::Body box;
  World::Drive drive;
  World::Tween tween;
};

TEST(WorldState, BodiesJointsAndDrivesCanBeRemovedAfterwards) {
  Scene scene;
  scene.Run(80);
  scene.world.RestoreState(scene.world.SaveState());

  scene.world.RemoveBody(scene.pusher);

  EXPECT_EQ(scene.world.joint_count(), 0);
  EXPECT_THROW(scene.world.Get(scene.drive), GoneError);
  StepTimes(scene.world, 10);
}

TEST(WorldState, DamagedBytesAreRefusedAndChangeNothing) {
  Scene scene;
  scene.Run(80);
  const std::string state = scene.world.SaveState();
  std::mt19937 draw(1);

  for (int i = 0; i < 500; ++i) {
    std::string damaged = state.substr(0, i % 4 == 0 ? draw() % state.size() : state.size());
    if (!damaged.empty()) damaged[draw() % damaged.size()] ^= static_cast<char>(1 + draw() % 255);
    EXPECT_THROW(scene.world.RestoreState(damaged), std::invalid_argument);
  }

  Scene other;
  other.world.RestoreState(state);
  ExpectSame(scene.Run(100), other.Run(100));
}

TEST(WorldState, ForgedBytesAreRefusedOrRunOn) {
  Scene scene;
  scene.Run(80);
  const std::string state = scene.world.SaveState();
  const std::vector<float> values{0, -1, 1, 100, 1e-9f, 1e5f, 3e8f, 1e9f, -1e9f};
  std::mt19937 draw(1);
  int accepted = 0;

  for (int i = 0; i < 3000; ++i) {
    std::string forged = state.substr(0, state.size() - sizeof(uint64_t));
    char* const place = forged.data() + draw() % (forged.size() - sizeof(float));
    if (i % 2 == 0) {
      *place ^= static_cast<char>(1 + draw() % 255);
    } else {
      std::memcpy(place, &values[draw() % values.size()], sizeof(float));
    }
    const uint64_t sum = Checksum(forged);
    try {
      scene.world.RestoreState(forged.append(reinterpret_cast<const char*>(&sum), sizeof sum));
    } catch (const std::invalid_argument&) {
      continue;
    }
    scene.Run(15);
    ++accepted;
  }

  EXPECT_GT(accepted, 500);
}

TEST(WorldState, ItCannotBeSavedDuringAStep) {
  Scene scene;
  struct Saver : ContactListener {
    explicit Saver(World& world) : world(world) {}
    void OnContact(Contact&) override {
      EXPECT_THROW(world.SaveState(), std::logic_error);
      ++count;
    }
    World& world;
    int count = 0;
  } saver(scene.world);
  scene.world.contacts().SetListener(&saver);
  scene.world.contacts().ListenTo(scene.box, kBeginContact);

  scene.Run(80);

  EXPECT_GT(saver.count, 0);
}

}  // namespace
}  // namespace flatland
