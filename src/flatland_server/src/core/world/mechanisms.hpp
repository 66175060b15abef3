#pragma once

/// Mechanisms: drives, tweens, drifts and lidars, which the core moves or reads at every step.

#include <tuple>

#include "base/slot_map.hpp"
#include "motion/ackermann_drive.hpp"
#include "motion/body_drift.hpp"
#include "motion/body_drive.hpp"
#include "motion/body_tween.hpp"
#include "motion/tricycle_drive.hpp"
#include "world/bodies.hpp"

namespace flatland {

/// Something that belongs to a body and is removed with it: a drive, a tween, a drift or
/// a lidar.
template <class Mechanism>
struct Mounted {
  Bodies::Body body;
  Mechanism mechanism;
};

/// The mechanisms of a type.
template <class Mechanism>
class MountedMap : public SlotMap<Mounted<Mechanism>> {
 public:
  using SlotMap<Mounted<Mechanism>>::SlotMap;

  /// Calls `visit(handle, mechanism)` for each mechanism on the body.
  template <class Visit>
  void ForEachOn(Bodies::Body body, Visit visit) {
    this->ForEach([&](auto handle, Mounted<Mechanism>& mounted) {
      if (mounted.body.index == body.index) visit(handle, mounted.mechanism);
    });
  }
  void RemoveFrom(Bodies::Body body) {
    ForEachOn(body, [this](auto handle, Mechanism&) { this->Remove(handle); });
  }
};

/// The drives, tweens and drifts of a world.
struct Mechanisms {
  MountedMap<BodyDrive> drives{"drive"};
  MountedMap<TricycleDrive> tricycles{"drive"};
  MountedMap<AckermannDrive> cars{"drive"};
  MountedMap<BodyTween> tweens{"tween"};
  MountedMap<BodyDrift> drifts{"drift"};

  /// All maps; drifts come last, since tweens move bodies.
  auto All() { return std::tie(drives, tricycles, cars, tweens, drifts); }
  template <class Mechanism>
  Mechanism& Get(Handle<Mounted<Mechanism>> handle) {
    return std::get<MountedMap<Mechanism>&>(All()).Get(handle).mechanism;
  }
  /// Calls `visit` with each map.
  template <class Visit>
  void ForEachMap(Visit visit) {
    std::apply([&](auto&... maps) { (visit(maps), ...); }, All());
  }
  /// Calls `visit(body, drive)` for each drive, of any type.
  template <class Visit>
  void ForEachDrive(Visit visit) {
    const auto visit_one = [&](auto, auto& mounted) { visit(mounted.body, mounted.mechanism); };
    drives.ForEach(visit_one);
    tricycles.ForEach(visit_one);
    cars.ForEach(visit_one);
  }
  /// The same for those on a body.
  template <class Visit>
  void ForEachDriveOn(Bodies::Body body, Visit visit) {
    ForEachDrive([&](Bodies::Body driven, auto& drive) {
      if (driven.index == body.index) visit(drive);
    });
  }
  /// Calls `visit(body, actuator)` for each drive that has actuators.
  template <class Visit>
  void ForEachActuator(Visit visit) {
    ForEachDrive([&](Bodies::Body body, auto& drive) {
      if (drive.actuator()) visit(body, *drive.actuator().get());
    });
  }
  /// To be called when a joint has taken the place of another one, or null: it is destroyed.
  void ReplaceJoint(const b2Joint* joint, b2Joint* other) {
    ForEachDrive([&](auto, auto& drive) { drive.Replace(joint, other); });
  }
};

}  // namespace flatland
