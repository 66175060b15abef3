// What a lidar sees of a world.

#include "box2d_limits.hpp"
#include "busy_guard.hpp"
#include "flatland_server/world.hpp"

namespace flatland {

void World::Scan(const BeamFan& fan, const Pose& pose, const ScanSettings& settings, float* ranges,
                 float* intensities) const {
  Require(IsUsable(pose), "a lidar's pose must be finite");
  Require(IsUsable(settings.range) && settings.range > 0.0,
          "a lidar's range must be finite and above zero");
  const BusyGuard guard(busy_, IsListening());
  RefreshMovers();
  DepthBuffer& buffer = buffer_;
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
  seen_.clear();
  buffer.FindSeen(discs_, pose, &seen_);
  for (const int place : seen_) {
    const Mover& mover = movers_[place];
    if ((mover.layers & settings.layers) == 0 || !choose(mover.layers)) continue;
    mover.DrawOn(buffer, origin, rotation);
  }
}

/// Gathers what moves and can be seen, once for all the scans between two steps.
void World::RefreshMovers() const {
  if (movers_are_current_) return;
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
  movers_are_current_ = true;
}

}  // namespace flatland
