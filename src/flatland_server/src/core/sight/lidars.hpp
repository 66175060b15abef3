#pragma once

/// The lidars of a world, and scans from any pose in it.
///
/// Decides what is scanned from where; the rays are cast by DepthBuffer.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "base/access.hpp"
#include "base/collision_layers.hpp"
#include "base/geometry.hpp"
#include "sight/beam_fan.hpp"
#include "sight/depth_buffer.hpp"
#include "sight/visible_fixture.hpp"
#include "world/bodies.hpp"
#include "world/mechanisms.hpp"

namespace flatland {

class Layers;

struct ScanSettings {
  double range = 0.0;                ///< largest distance that is measured [m]
  LayerBits layers = kAllLayers;     ///< sees the fixtures and walls on any of these
  LayerBits reflectance_layers = 0;  ///< what is on any of these returns intensity 255, not 0
  double range_min = 0.0;  ///< what is nearer returns -infinity (REP 117) [m]; 0 is no minimum
  std::vector<Bodies::Body> ignored{};  ///< bodies that are not seen
};

struct LidarSettings {
  std::shared_ptr<const BeamFan> fan;  ///< the directions of its beams
  Pose pose;                           ///< of the lidar, in the body's frame [m, m, rad]
  ScanSettings scan;
};

/// A lidar on a body.
struct Lidar {
  LidarSettings settings;
  // The latest scan, by beam; see Lidars::Scan.
  std::vector<float> ranges;       // [m]
  std::vector<float> intensities;  // 0 or 255; empty without reflectance layers
  uint64_t scanned_revision = 0;   // revision of the world that it shows
  SeenWalls seen;                  // in the latest scan
  bool is_expected = false;        // Lidars::Expect has been called since
};

class Lidars {
 public:
  using LidarHandle = Handle<Mounted<Lidar>>;

  /// The world's access, bodies and layers must live as long.
  Lidars(const Access& access, const Bodies& bodies, const Layers& layers)
      : access_(access), bodies_(bodies), layers_(layers) {}
  Lidars(const Lidars&) = delete;
  Lidars& operator=(const Lidars&) = delete;
  /// Takes the lidars of an equal world, with their handles.
  void CopyFrom(const Lidars& other) { lidars_ = other.lidars_; }

  LidarHandle Add(Bodies::Body body, const LidarSettings& settings);
  void RemoveFrom(Bodies::Body body) { lidars_.RemoveFrom(body); }
  /// Announces a call of Scan. The first Scan computes all announced scans, on all processor cores.
  void Expect(LidarHandle lidar);
  /// The lidar with its scan of the present world. Its arrays are valid until the world changes.
  const Lidar& Scan(LidarHandle lidar) { return Scan(lidar, AccessGuard(access_)); }
  const Lidar& Scan(LidarHandle lidar, const AccessGuard& guard);
  /// Calls `visit` with each setting of each lidar: its place, and its ranges.
  template <class Visit>
  void ForEachSetting(Visit visit) {
    lidars_.ForEach([&](auto, Mounted<Lidar>& mounted) {
      auto& [fan, pose, scan] = mounted.mechanism.settings;
      visit(pose.x, pose.y, pose.yaw, scan.range, scan.range_min);
    });
  }
  /// The number of beams of a lidar.
  int GetBeamCount(LidarHandle lidar) const;
  /// For batches: writes a lidar's scan of the present world to an array of GetBeamCount values.
  /// `seen` is of this lidar's last scan in the same environment.
  void ScanInto(LidarHandle lidar, float* ranges, SeenWalls& seen, const AccessGuard& guard) const;
  /// Scans from a pose in the world [m, m, rad]. Writes fan.size() values to each array: the
  /// distance [m] to what each beam meets first, or +infinity (REP 117), and its intensity, 0 or
  /// 255. Shapes that contain the lidar, or are within a millimetre of it, are not seen.
  void Scan(const BeamFan& fan, const Pose& pose, const ScanSettings& settings, float* ranges,
            float* intensities) const {
    Scan(fan, pose, settings, ranges, intensities, AccessGuard(access_));
  }
  void Scan(const BeamFan& fan, const Pose& pose, const ScanSettings& settings, float* ranges,
            float* intensities, const AccessGuard& guard) const;

 private:
  Pose PoseOf(const Mounted<Lidar>& mounted) const;
  /// Collects the fixtures that lidars may see, once per revision; those of bodies that stay, once
  /// per structure revision.
  void RefreshVisibleFixtures() const;
  void AddVisibleFixtures(const BodyRecord& record) const;
  /// Called by several threads at a time; the visible fixtures must be up to date. `intensities`
  /// and `seen` may be null.
  void ScanInto(const BeamFan& fan, const Pose& pose, const ScanSettings& settings, float* ranges,
                float* intensities, SeenWalls* seen) const;
  /// Draws the walls and fixtures on layers that the lidar sees and that `choose(layers)` accepts.
  template <class Choose>
  void DrawOn(DepthBuffer& buffer, const Pose& pose, const ScanSettings& settings, SeenWalls* seen,
              Choose choose) const;

  const Access& access_;
  const Bodies& bodies_;
  const Layers& layers_;
  MountedMap<Lidar> lidars_{"lidar"};
  std::vector<LidarHandle> expected_;              // those that Expect was called for
  std::vector<std::pair<Lidar*, Pose>> scanning_;  // lidars of the present scan, and their poses
  mutable std::vector<VisibleFixture> visible_fixtures_;  // first those that stay
  mutable BoundingCircles bounding_circles_;              // of visible_fixtures_
  mutable uint64_t visible_revision_ = 0;                 // revision that these two show
  mutable size_t staying_fixtures_ = 0;                   // number of those that stay
  mutable uint64_t staying_revision_ = 0;                 // structure revision that they show
};

}  // namespace flatland
