#pragma once

/// A container of objects that are named by handles, which may outlive the objects.
///
/// Python code may keep a reference to a body that has been removed, and that Box2D has freed. So
/// code outside the core holds Handles instead of pointers. A handle has the index of a slot, and
/// the slot's generation when the handle was made. Removing the object increments the generation.
/// An outdated handle is recognised by its old generation: using it throws GoneError instead of
/// crashing.

#include <cstdint>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace flatland {

/// Thrown for the handle of an object that has been removed.
class GoneError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Names a T in a SlotMap. A default-constructed handle names nothing.
template <class T>
struct Handle {
  uint32_t index = 0;
  uint32_t generation = 0;

  bool operator==(Handle other) const {
    return index == other.index && generation == other.generation;
  }
};

template <class T>
class SlotMap {
 public:
  /// `noun` is the word for a T in error messages.
  explicit SlotMap(std::string noun) : noun_(std::move(noun)) {}

  Handle<T> Add(T value) {
    if (free_.empty()) {
      free_.push_back(static_cast<uint32_t>(slots_.size()));
      slots_.emplace_back();
    }
    const uint32_t index = free_.back();
    free_.pop_back();
    Slot& slot = slots_[index];
    slot.value = std::move(value);
    slot.in_use = true;
    slot.previous = last_;
    slot.next = kNone;
    (last_ == kNone ? first_ : slots_[last_].next) = index;
    last_ = index;
    return {index, slot.generation};
  }

  void Remove(Handle<T> handle) {
    Get(handle);
    Slot& slot = slots_[handle.index];
    slot.value = T();
    slot.in_use = false;
    (slot.previous == kNone ? first_ : slots_[slot.previous].next) = slot.next;
    (slot.next == kNone ? last_ : slots_[slot.next].previous) = slot.previous;
    ++slot.generation;
    free_.push_back(handle.index);
  }

  /// The handle of the present object of a slot, which must be in use.
  Handle<T> HandleAt(uint32_t index) const { return {index, slots_[index].generation}; }

  size_t size() const { return slots_.size() - free_.size(); }
  /// Number of slots; the index of every handle is below it.
  size_t slot_count() const { return slots_.size(); }

  bool Contains(Handle<T> handle) const {
    return handle.index < slots_.size() && slots_[handle.index].in_use &&
           slots_[handle.index].generation == handle.generation;
  }

  /// The object of a handle. Throws GoneError if it has been removed.
  T& Get(Handle<T> handle) {
    if (!Contains(handle)) throw GoneError("this " + noun_ + " has been deleted");
    return slots_[handle.index].value;
  }
  const T& Get(Handle<T> handle) const { return const_cast<SlotMap*>(this)->Get(handle); }

  /// Calls `visit(handle, value)` for each object, in the order in which they were added, whatever
  /// slots they got. `visit` may remove the object that it is called with.
  template <class Visit>
  void ForEach(Visit visit) {
    for (uint32_t i = first_, next; i != kNone; i = next) {
      next = slots_[i].next;
      visit(Handle<T>{i, slots_[i].generation}, slots_[i].value);
    }
  }
  template <class Visit>
  void ForEach(Visit visit) const {
    const_cast<SlotMap*>(this)->ForEach(
        [&](Handle<T> handle, T& value) { visit(handle, static_cast<const T&>(value)); });
  }

 private:
  static constexpr uint32_t kNone = UINT32_MAX;

  struct Slot {
    T value = T();
    uint32_t generation = 1;
    bool in_use = false;
    uint32_t previous = kNone;  // of those in use, in the order in which they were added
    uint32_t next = kNone;
  };

  std::string noun_;
  std::vector<Slot> slots_;
  std::vector<uint32_t> free_;
  uint32_t first_ = kNone;
  uint32_t last_ = kNone;
};

}  // namespace flatland
