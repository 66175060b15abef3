#pragma once

/// Handles that outlive what they name.
///
/// Python keeps references for as long as it likes, and Box2D frees bodies when their model is
/// deleted. So nothing outside the core holds a pointer: it holds a Handle, the index of a slot and
/// the generation that was current when the handle was made. Freeing a slot raises its generation;
/// a handle of an older one is recognised, and its use throws GoneError instead of crashing.

#include <cstdint>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace flatland {

/// The object that a handle names is not there any more.
class GoneError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Names a T in its SlotMap. The default handle names nothing.
template <class T>
struct Handle {
  uint32_t index = 0;
  uint32_t generation = 0;
};

template <class T>
class SlotMap {
 public:
  /// `noun` is what error messages call a T.
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
    slot.used = true;
    return {index, slot.generation};
  }

  void Remove(Handle<T> handle) {
    Get(handle);
    Slot& slot = slots_[handle.index];
    slot.value = T();
    slot.used = false;
    ++slot.generation;
    free_.push_back(handle.index);
  }

  /// The handle of what is at an index now; `index` must be that of a used slot.
  Handle<T> HandleAt(uint32_t index) const { return {index, slots_[index].generation}; }

  bool Contains(Handle<T> handle) const {
    return handle.index < slots_.size() && slots_[handle.index].used &&
           slots_[handle.index].generation == handle.generation;
  }

  /// Throws GoneError if the handle's object has been removed.
  T& Get(Handle<T> handle) {
    if (!Contains(handle)) throw GoneError("this " + noun_ + " has been deleted");
    return slots_[handle.index].value;
  }
  const T& Get(Handle<T> handle) const { return const_cast<SlotMap*>(this)->Get(handle); }

  /// Calls `visit(handle, value)` for each object, in the order of their slots.
  template <class Visit>
  void ForEach(Visit visit) {
    for (uint32_t i = 0; i < slots_.size(); ++i) {
      if (slots_[i].used) visit(Handle<T>{i, slots_[i].generation}, slots_[i].value);
    }
  }
  template <class Visit>
  void ForEach(Visit visit) const {
    const_cast<SlotMap*>(this)->ForEach(
        [&](Handle<T> handle, T& value) { visit(handle, static_cast<const T&>(value)); });
  }

 private:
  struct Slot {
    T value = T();
    uint32_t generation = 1;
    bool used = false;
  };

  std::string noun_;
  std::vector<Slot> slots_;
  std::vector<uint32_t> free_;
};

}  // namespace flatland
