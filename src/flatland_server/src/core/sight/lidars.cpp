#include "sight/lidars.hpp"

#include <algorithm>
#include <limits>

#include "base/box2d_limits.hpp"
#include "base/parallel.hpp"
#include "base/to_box2d.hpp"
#include "world/layers.hpp"

namespace flatland {
namespace {

void RequireRange(double range) {
  Require(IsUsable(range) && range > 0.0, "a lidar's range must be finite and above zero");
}

}  // namespace

Pose Lidars::PoseOf(const Mounted<Lidar>& mounted) const {
  const b2Body& body = *bodies_.Get(mounted.body).body;
  const Pose& mount = mounted.mechanism.settings.pose;
  const double yaw = WrappedAngle(body.GetAngle());
  const Vec2 position = FromBox2D(body.GetPosition()) + Rotation(yaw).Apply({mount.x, mount.y});
  return {position.x, position.y, yaw + mount.yaw};
}

Lidars::LidarHandle Lidars::Add(Bodies::Body body, const LidarSettings& settings) {
  const AccessGuard guard(access_);
  bodies_.Get(body);
  Require(settings.fan != nullptr, "a lidar needs beams");
  Require(IsUsable(settings.pose), "a lidar's pose must be finite");
  RequireRange(settings.scan.range);
  Require(settings.scan.range_min >= 0.0 && settings.scan.range_min < settings.scan.range,
          "a lidar's least range must be from 0 to less than its range");
  for (const Bodies::Body body : settings.scan.ignored) bodies_.Get(body);
  Lidar lidar;
  lidar.settings = settings;
  lidar.ranges.resize(settings.fan->size());
  if (settings.scan.reflectance_layers != 0) lidar.intensities.resize(settings.fan->size());
  return lidars_.Add({body, std::move(lidar)});
}

void Lidars::Expect(LidarHandle handle) {
  const AccessGuard guard(access_);
  Lidar& lidar = lidars_.Get(handle).mechanism;
  if (lidar.is_expected) return;
  expected_.push_back(handle);
  lidar.is_expected = true;
}

const Lidar& Lidars::Scan(LidarHandle handle, const AccessGuard&) {
  Lidar& requested = lidars_.Get(handle).mechanism;
  if (requested.scanned_revision == bodies_.revision()) return requested;
  RefreshVisibleFixtures();
  scanning_.clear();
  const auto add = [&](Mounted<Lidar>& mounted) {
    Lidar& lidar = mounted.mechanism;
    lidar.is_expected = false;
    if (lidar.scanned_revision == bodies_.revision()) return;
    scanning_.push_back({&lidar, PoseOf(mounted)});
    lidar.scanned_revision = bodies_.revision();
  };
  add(lidars_.Get(handle));
  for (const LidarHandle& each : expected_) {
    if (lidars_.Contains(each)) add(lidars_.Get(each));
  }
  expected_.clear();
  ForEachInParallel(static_cast<int>(scanning_.size()), [&](int i) noexcept {
    Lidar& lidar = *scanning_[i].first;
    ScanInto(*lidar.settings.fan, scanning_[i].second, lidar.settings.scan, lidar.ranges.data(),
             lidar.intensities.empty() ? nullptr : lidar.intensities.data(), &lidar.seen);
  });
  return requested;
}

int Lidars::GetBeamCount(LidarHandle lidar) const {
  access_.RequireAccess();
  return lidars_.Get(lidar).mechanism.settings.fan->size();
}

void Lidars::ScanInto(LidarHandle handle, float* ranges, SeenWalls& seen,
                      const AccessGuard&) const {
  const Mounted<Lidar>& mounted = lidars_.Get(handle);
  const LidarSettings& settings = mounted.mechanism.settings;
  RefreshVisibleFixtures();
  ScanInto(*settings.fan, PoseOf(mounted), settings.scan, ranges, nullptr, &seen);
}

void Lidars::Scan(const BeamFan& fan, const Pose& pose, const ScanSettings& settings, float* ranges,
                  float* intensities, const AccessGuard&) const {
  Require(IsUsable(pose), "a lidar's pose must be finite");
  RequireRange(settings.range);
  RefreshVisibleFixtures();
  ScanInto(fan, pose, settings, ranges, intensities, nullptr);
}

void Lidars::RefreshVisibleFixtures() const {
  if (visible_revision_ == bodies_.revision()) return;
  if (staying_revision_ != bodies_.structure_revision()) {
    visible_fixtures_.clear();
    bounding_circles_.Clear();
    bodies_.ForEach([this](auto, const BodyRecord& record) {
      if (!record.may_move) AddVisibleFixtures(record);
    });
    staying_fixtures_ = visible_fixtures_.size();
    staying_revision_ = bodies_.structure_revision();
  }
  visible_fixtures_.erase(visible_fixtures_.begin() + static_cast<ptrdiff_t>(staying_fixtures_),
                          visible_fixtures_.end());
  bounding_circles_.count = static_cast<int>(staying_fixtures_);
  for (const BodyRecord* record : bodies_.Moving()) AddVisibleFixtures(*record);
  visible_revision_ = bodies_.revision();
}

void Lidars::AddVisibleFixtures(const BodyRecord& record) const {
  if (record.is_layer) return;
  for (const BodyRecord::FixtureRecord& each : record.fixtures) {
    const bool is_on_a_layer = each.fixture->GetFilterData().categoryBits != 0;
    if (!each.visible || !is_on_a_layer || each.fixture->IsSensor()) continue;
    const VisibleFixture& fixture = visible_fixtures_.emplace_back(*each.fixture, each.seen_radius);
    bounding_circles_.Add(fixture.center, fixture.bounding_radius);
  }
}

void Lidars::ScanInto(const BeamFan& fan, const Pose& pose, const ScanSettings& settings,
                      float* ranges, float* intensities, SeenWalls* seen) const {
  thread_local DepthBuffer buffer;  // keeps its memory from scan to scan
  buffer.Begin(fan, settings.range);
  // Reflecting layers are drawn last, so that the buffer can tell them from the rest.
  const auto reflects = [&](LayerBits layers) {
    return (layers & settings.reflectance_layers) != 0;
  };
  DrawOn(buffer, pose, settings, seen, [&](LayerBits layers) { return !reflects(layers); });
  if (settings.reflectance_layers != 0) {
    buffer.BeginReflecting();
    DrawOn(buffer, pose, settings, seen, reflects);
  }
  buffer.GetRanges(ranges);
  if (settings.range_min > 0.0) {
    for (int i = 0; i < fan.size(); ++i) {
      if (ranges[i] < settings.range_min) ranges[i] = -std::numeric_limits<float>::infinity();
    }
  }
  if (intensities != nullptr) buffer.GetIntensities(intensities);
}

template <class Choose>
void Lidars::DrawOn(DepthBuffer& buffer, const Pose& pose, const ScanSettings& settings,
                    SeenWalls* seen, Choose choose) const {
  // Only for the layer with most walls, the walls that were seen last are kept.
  const auto is_seen = [&](const auto& layer) { return (layer->layers() & settings.layers) != 0; };
  size_t most = 0;
  for (const auto& layer : layers_.all()) {
    if (is_seen(layer)) most = std::max(most, layer->size());
  }
  for (const auto& layer : layers_.all()) {
    if (!is_seen(layer) || !choose(layer->layers())) continue;
    const SegmentTree& walls = layer->walls();
    SeenWalls* const last = walls.segment_count() == most ? seen : nullptr;
    const void* cell = nullptr;
    const WallList visible = layer->visible().From({pose.x, pose.y}, settings.range, cell);
    if (last != nullptr) {
      last->known = visible;
      last->segments = walls.segments().data();
      last->cell = cell;
    }
    if (visible.indices != nullptr) {
      buffer.Draw(walls, visible, pose);
    } else {
      buffer.Draw(walls, pose, last);
    }
  }
  const auto is_ignored = [&](const b2Fixture& fixture) {
    const Bodies::Body body = bodies_.HandleOf(const_cast<b2Body&>(*fixture.GetBody()));
    return std::find(settings.ignored.begin(), settings.ignored.end(), body) !=
           settings.ignored.end();
  };
  const Vec2 origin{pose.x, pose.y};
  const Rotation rotation(pose.yaw);
  for (const int index : buffer.FindVisible(bounding_circles_, pose)) {
    const VisibleFixture& fixture = visible_fixtures_[index];
    if ((fixture.layers & settings.layers) == 0 || !choose(fixture.layers)) continue;
    if (!settings.ignored.empty() && is_ignored(*fixture.fixture)) continue;
    fixture.DrawOn(buffer, origin, rotation);
  }
}

}  // namespace flatland
