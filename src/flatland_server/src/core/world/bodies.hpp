#pragma once

/// The bodies of a world.

#include <cstdint>
#include <utility>
#include <vector>

#include "base/slot_map.hpp"
#include "world/body.hpp"

namespace flatland {

/// The bodies of a world, layers included, and two counters of their changes: caches compare them.
class Bodies : public SlotMap<BodyRecord> {
 public:
  using Body = Handle<BodyRecord>;

  Bodies() : SlotMap("body") {}

  /// Changes whenever something is added, removed or moved.
  uint64_t revision() const { return revision_; }
  /// Like revision(), except that it ignores movements of bodies that may move.
  uint64_t structure_revision() const { return structure_revision_; }
  /// To be called when bodies that may move are moved.
  void ChangePoses() { ++revision_; }
  /// To be called when anything else is added, removed or moved.
  void ChangeStructure() {
    ++revision_;
    ++structure_revision_;
  }

  Body Add(BodyRecord record) {
    b2Body* const body = record.body;
    const Body handle = SlotMap::Add(std::move(record));
    body->GetUserData().pointer = handle.index;
    ChangeStructure();
    return handle;
  }
  /// From now on the body may move in a step.
  void AllowMotion(Body body) {
    if (Get(body).may_move) return;
    Get(body).may_move = true;
    ChangeStructure();
  }
  /// The bodies that may move, in the order in which they were added.
  const std::vector<BodyRecord*>& Moving() const {
    if (moving_revision_ != structure_revision_) {
      moving_.clear();
      const_cast<Bodies*>(this)->ForEach([this](Body, BodyRecord& record) {
        if (record.may_move) moving_.push_back(&record);
      });
      moving_revision_ = structure_revision_;
    }
    return moving_;
  }

  /// The body of a model, or the layer, to which an object of Box2D belongs.
  Body HandleOf(b2Body& body) const {
    return HandleAt(static_cast<uint32_t>(body.GetUserData().pointer));
  }
  const BodyRecord& RecordOf(b2Body& body) const { return Get(HandleOf(body)); }

 private:
  uint64_t revision_ = 1;
  uint64_t structure_revision_ = 1;
  mutable std::vector<BodyRecord*> moving_;
  mutable uint64_t moving_revision_ = 0;  // structure revision that `moving_` shows
};

}  // namespace flatland
