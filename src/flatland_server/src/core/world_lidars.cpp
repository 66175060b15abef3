/// World: lidars and scanning. Decides what is scanned from where; the ray casting itself is in
/// depth_buffer.cpp.

#include "box2d_limits.hpp"
#include "flatland_server/parallel.hpp"
#include "flatland_server/world.hpp"
#include "to_box2d.hpp"

namespace flatland {
namespace {

void RequireRange(double range) {
  Require(IsUsable(range) && range > 0.0, "a lidar's range must be finite and above zero");
}

/// Pose of a lidar in the world, mounted at a pose of the body's frame.
Pose LidarPose(const b2Body& body, const Pose& mount) {
  const double yaw = std::remainder(double{body.GetAngle()}, 2.0 * M_PI);
  const Vec2 position = FromBox2D(body.GetPosition()) + Rotation(yaw).Apply({mount.x, mount.y});
  return {position.x, position.y, yaw + mount.yaw};
}

}  // namespace

World::LidarHandle World::AddLidar(Body body, const LidarSettings& settings) {
  Find(body);
  const AccessGuard guard(*this);
  Require(settings.fan != nullptr, "a lidar needs beams");
  Require(IsUsable(settings.pose), "a lidar's pose must be finite");
  RequireRange(settings.scan.range);
  Lidar lidar;
  lidar.settings = settings;
  lidar.ranges.resize(settings.fan->size());
  for (const Layer& layer : layers_) {
    if ((layer.bits & settings.scan.layers) != 0) layer.walls->Prepare();
  }
  if (settings.scan.reflectance_layers != 0) lidar.intensities.resize(settings.fan->size());
  return lidars_.Add({body, std::move(lidar)});
}

void World::ExpectScan(LidarHandle handle) {
  const AccessGuard guard(*this);
  Lidar& lidar = lidars_.Get(handle).mechanism;
  if (lidar.is_expected) return;
  expected_lidars_.push_back(handle);
  lidar.is_expected = true;
}

const Lidar& World::Scan(LidarHandle handle, const AccessGuard&) {
  Lidar& requested = lidars_.Get(handle).mechanism;
  if (requested.scanned_revision == revision_) return requested;
  RefreshVisibleFixtures();
  scanning_.clear();
  const auto add = [&](Mounted<Lidar>& mounted) {
    Lidar& lidar = mounted.mechanism;
    lidar.is_expected = false;
    if (lidar.scanned_revision == revision_) return;
    const b2Body& body = *bodies_.Get(mounted.body).body;
    scanning_.push_back({&lidar, LidarPose(body, lidar.settings.pose)});
    lidar.scanned_revision = revision_;
  };
  add(lidars_.Get(handle));
  for (const LidarHandle& each : expected_lidars_) {
    if (lidars_.Contains(each)) add(lidars_.Get(each));
  }
  expected_lidars_.clear();
  ForEachInParallel(static_cast<int>(scanning_.size()), [&](int i) noexcept {
    Lidar& lidar = *scanning_[i].first;
    ScanInto(*lidar.settings.fan, scanning_[i].second, lidar.settings.scan, lidar.ranges.data(),
             lidar.intensities.empty() ? nullptr : lidar.intensities.data());
  });
  return requested;
}

int World::GetBeamCount(LidarHandle lidar) const {
  RequireAccess();
  return lidars_.Get(lidar).mechanism.settings.fan->size();
}

void World::ScanInto(LidarHandle handle, float* ranges, const AccessGuard&) const {
  const Mounted<Lidar>& mounted = lidars_.Get(handle);
  const LidarSettings& settings = mounted.mechanism.settings;
  RefreshVisibleFixtures();
  ScanInto(*settings.fan, LidarPose(*bodies_.Get(mounted.body).body, settings.pose), settings.scan,
           ranges, nullptr);
}

void World::Scan(const BeamFan& fan, const Pose& pose, const ScanSettings& settings, float* ranges,
                 float* intensities, const AccessGuard&) const {
  Require(IsUsable(pose), "a lidar's pose must be finite");
  RequireRange(settings.range);
  RefreshVisibleFixtures();
  ScanInto(fan, pose, settings, ranges, intensities);
}

void World::RefreshVisibleFixtures() const {
  if (visible_revision_ == revision_) return;
  RefreshMovingBodies();
  visible_fixtures_.erase(visible_fixtures_.begin() + static_cast<ptrdiff_t>(staying_fixtures_),
                          visible_fixtures_.end());
  bounding_circles_.count = static_cast<int>(staying_fixtures_);
  for (const BodyRecord* record : moving_) AddVisibleFixtures(*record);
  visible_revision_ = revision_;
}

void World::RefreshMovingBodies() const {
  if (moving_revision_ == structure_revision_) return;
  moving_.clear();
  visible_fixtures_.clear();
  bounding_circles_.Clear();
  bodies_.ForEach([this](Body, const BodyRecord& record) {
    if (record.may_move) {
      moving_.push_back(&record);
    } else {
      AddVisibleFixtures(record);
    }
  });
  staying_fixtures_ = visible_fixtures_.size();
  moving_revision_ = structure_revision_;
}

void World::AddVisibleFixtures(const BodyRecord& record) const {
  if (record.is_layer) return;
  for (const BodyRecord::FixtureRecord& each : record.fixtures) {
    const bool is_on_a_layer = each.fixture->GetFilterData().categoryBits != 0;
    if (!each.visible || !is_on_a_layer || each.fixture->IsSensor()) continue;
    const VisibleFixture& fixture = visible_fixtures_.emplace_back(*each.fixture, each.seen_radius);
    bounding_circles_.Add(fixture.center, fixture.bounding_radius);
  }
}

void World::ScanInto(const BeamFan& fan, const Pose& pose, const ScanSettings& settings,
                     float* ranges, float* intensities) const {
  thread_local DepthBuffer buffer;  // keeps its memory from scan to scan
  buffer.Begin(fan, settings.range);
  // What reflects is drawn last, so that the buffer can tell it from the rest.
  const auto reflects = [&](LayerBits layers) {
    return (layers & settings.reflectance_layers) != 0;
  };
  DrawOn(buffer, pose, settings, [&](LayerBits layers) { return !reflects(layers); });
  if (settings.reflectance_layers != 0) {
    buffer.BeginReflecting();
    DrawOn(buffer, pose, settings, reflects);
  }
  buffer.GetRanges(ranges);
  if (intensities != nullptr) buffer.GetIntensities(intensities);
}

template <class Choose>
void World::DrawOn(DepthBuffer& buffer, const Pose& pose, const ScanSettings& settings,
                   Choose choose) const {
  const Vec2 origin{pose.x, pose.y};
  for (const Layer& layer : layers_) {
    if ((layer.bits & settings.layers) == 0 || !choose(layer.bits)) continue;
    if (const WallList* seen = layer.walls->SeenFrom(origin)) {
      buffer.Draw(*seen, pose);
    } else {
      buffer.Draw(layer.walls->all(), pose);
    }
  }
  const Rotation rotation(pose.yaw);
  for (const int index : buffer.FindVisible(bounding_circles_, pose)) {
    const VisibleFixture& fixture = visible_fixtures_[index];
    if ((fixture.layers & settings.layers) == 0 || !choose(fixture.layers)) continue;
    fixture.DrawOn(buffer, origin, rotation);
  }
}

}  // namespace flatland
