// What lidars see of a world.

#include "box2d_limits.hpp"
#include "flatland_server/parallel.hpp"
#include "flatland_server/world.hpp"
#include "to_box2d.hpp"

namespace flatland {
namespace {

void RequireRange(double range) {
  Require(IsUsable(range) && range > 0.0, "a lidar's range must be finite and above zero");
}

}  // namespace

void World::Scan(const BeamFan& fan, const Pose& pose, const ScanSettings& settings, float* ranges,
                 float* intensities, const Turn&) const {
  Require(IsUsable(pose), "a lidar's pose must be finite");
  RequireRange(settings.range);
  RefreshMovers();
  ScanInto(fan, pose, settings, ranges, intensities);
}

World::LidarHandle World::AddLidar(Body body, const LidarSettings& settings) {
  Find(body);
  const Turn turn(*this);
  Require(settings.fan != nullptr, "a lidar needs beams");
  Require(IsUsable(settings.pose), "a lidar's pose must be finite");
  RequireRange(settings.scan.range);
  Lidar lidar;
  lidar.settings = settings;
  lidar.ranges.resize(settings.fan->size());
  lidar.intensities.resize(settings.fan->size());
  return lidars_.Add({body, std::move(lidar)});
}

void World::ExpectScan(LidarHandle lidar) {
  const Turn turn(*this);
  Lidar& expected = lidars_.Get(lidar).mechanism;
  if (expected.is_expected) return;
  expected_.push_back(lidar);
  expected.is_expected = true;
}

const Lidar& World::Scan(LidarHandle handle, const Turn&) {
  Lidar& asked = lidars_.Get(handle).mechanism;
  if (asked.seen_at == state_) return asked;
  RefreshMovers();
  due_.clear();
  const auto add = [&](Moved<Lidar>& mounted) {
    mounted.mechanism.is_expected = false;
    if (mounted.mechanism.seen_at == state_) return;
    const b2Body& body = *bodies_.Get(mounted.body).body;
    const Pose& mount = mounted.mechanism.settings.pose;
    const double yaw = std::remainder(double{body.GetAngle()}, 2.0 * M_PI);
    const Vec2 place = FromBox2D(body.GetPosition()) + Rotation(yaw).Apply({mount.x, mount.y});
    due_.push_back({&mounted.mechanism, {place.x, place.y, yaw + mount.yaw}});
    mounted.mechanism.seen_at = state_;
  };
  add(lidars_.Get(handle));
  for (const LidarHandle& each : expected_) {
    if (lidars_.Contains(each)) add(lidars_.Get(each));
  }
  expected_.clear();
  ForEachInParallel(static_cast<int>(due_.size()), [&](int i) noexcept {
    Lidar& lidar = *due_[i].first;
    ScanInto(*lidar.settings.fan, due_[i].second, lidar.settings.scan, lidar.ranges.data(),
             lidar.intensities.data());
  });
  return asked;
}

/// Called by several threads at a time; the movers must be current.
void World::ScanInto(const BeamFan& fan, const Pose& pose, const ScanSettings& settings,
                     float* ranges, float* intensities) const {
  thread_local DepthBuffer buffer;  // keeps its memory from scan to scan
  buffer.Begin(fan, settings.range);
  // What reflects is drawn last, so that it can be told from the rest.
  const auto reflects = [&](LayerBits layers) {
    return (layers & settings.reflectance_layers) != 0;
  };
  DrawOn(buffer, pose, settings, [&](LayerBits layers) { return !reflects(layers); });
  if (settings.reflectance_layers != 0) {
    buffer.BeginReflecting();
    DrawOn(buffer, pose, settings, reflects);
  }
  buffer.GetRanges(ranges);
  buffer.GetIntensities(intensities);
}

template <class Choose>
void World::DrawOn(DepthBuffer& buffer, const Pose& pose, const ScanSettings& settings,
                   Choose choose) const {
  for (const Layer& layer : layers_) {
    if ((layer.bits & settings.layers) != 0 && choose(layer.bits)) buffer.Draw(*layer.walls, pose);
  }
  const Vec2 origin{pose.x, pose.y};
  const Rotation rotation(pose.yaw);
  for (const int place : buffer.FindSeen(discs_, pose)) {
    const Mover& mover = movers_[place];
    if ((mover.layers & settings.layers) == 0 || !choose(mover.layers)) continue;
    mover.DrawOn(buffer, origin, rotation);
  }
}

/// Gathers what moves and can be seen, once for all the scans between two changes.
void World::RefreshMovers() const {
  if (movers_state_ == state_) return;
  movers_.clear();
  discs_.Clear();
  bodies_.ForEach([this](Body, const BodyRecord& record) {
    if (record.is_layer) return;
    for (const BodyRecord::FixtureRecord& each : record.fixtures) {
      const bool is_on_a_layer = each.fixture->GetFilterData().categoryBits != 0;
      if (!each.visible || !is_on_a_layer || each.fixture->IsSensor()) continue;
      const Mover& mover = movers_.emplace_back(*each.fixture, each.reach);
      discs_.Add(mover.middle, mover.reach);
    }
  });
  movers_state_ = state_;
}

}  // namespace flatland
