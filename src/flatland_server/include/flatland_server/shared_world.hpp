#pragma once

/// Many states of one world, which share all that does not change.
///
/// Need. Thousands of environments that begin alike. Each could be a World; but in an office this
/// takes 2 MB and 3 ms, nearly all of it for walls, which are the same everywhere.
///
/// Method. There is one World. What its steps change is exchanged for another state before a step,
/// byte by byte: Box2D's bodies that may move, the boxes of their fixtures, and joints; the heads
/// of the lists of contacts, which stay where they are; drives, tweens and crowds. The objects stay
/// at their places, so all pointers between them stay right. Box2D's tree of bounding boxes has a
/// node for each wall, of which few change: those that have are exchanged (shared_tree.hpp), or
/// all, if many are of bodies that move. So a state makes, bit for bit, the steps that a World of
/// its own makes.

#include <cstddef>
#include <memory>
#include <type_traits>
#include <vector>

#include "flatland_server/world.hpp"

namespace flatland {

class SharedTree;
struct TreeChange;
struct WorldState;

class SharedWorld {
 public:
  /// The part of the world that each environment has for itself.
  class State {
   public:
    ~State();

   private:
    friend class SharedWorld;
    State();
    State& operator=(const State&);
    std::vector<std::byte> bytes_;   // of the ranges, one after the other, and the boxes
    std::vector<int32_t> moves_;     // proxies that may have new contacts
    std::vector<TreeChange> nodes_;  // of the tree, that differ from the beginning
  };

  /// Takes a world, which must not be given to anything else. Nothing may be added to it or removed
  /// any more. Of static bodies, only `moved` may be moved.
  explicit SharedWorld(std::unique_ptr<World> world, const std::vector<World::Body>& moved = {});
  ~SharedWorld();

  /// A new state: that of the world at the beginning. To be destroyed before the SharedWorld.
  std::unique_ptr<State> MakeState();
  /// Tells the processor to fetch a state from memory, while it does something else: in three
  /// steps, each of which uses what the one before has fetched: where the state's arrays are,
  /// these, and the nodes of the tree that they are about.
  static void PrefetchPlaces(const State& state) { __builtin_prefetch(&state); }
  static void Prefetch(const State& state);
  void PrefetchUsed(const State& state) const;
  /// Puts the world into a state, until Leave, which must precede the next call.
  World& Enter(const State& state);
  /// Keeps what has become of the state.
  void Leave(State& state);

  // Not between Enter and Leave:

  /// Puts a state back to the beginning.
  void Restart(State& state) { Replace(*beginning_, state); }
  /// Puts a state into another one of this world.
  void Replace(const State& from, State& state);
  /// Puts a state into a saved one of an equal world.
  void Load(const WorldState& saved, State& state);
  /// Throws std::invalid_argument if Load cannot: something is different that states share.
  void RequireLoadable(const WorldState& saved) const;

 private:
  /// Memory that steps change.
  struct Range {
    void* address;
    size_t size;
  };
  template <class T>
  void AddRange(T& object) {
    AddRange(&object, sizeof(T));
  }
  /// Adds it to the last range, if that ends where it begins.
  void AddRange(void* address, size_t size);
  template <class Mechanism>
  void AddRanges(SlotMap<Mounted<Mechanism>>& mechanisms) {
    static_assert(std::is_trivially_copyable_v<Mechanism>);
    mechanisms.ForEach([this](auto, Mounted<Mechanism>& each) { AddRange(each.mechanism); });
  }
  void CollectRanges();
  void JoinBodies();
  void WriteRanges(const State& state);
  void ReadRanges(State& state) const;
  /// Makes `to`, which has no contacts, a copy with contacts of its own.
  void Copy(const State& from, State& to);
  /// Drops walls from those proxies that Box2D asks for new contacts in the first step.
  void SkipWalls();

  std::unique_ptr<World> world_;
  std::vector<Range> ranges_;
  std::vector<b2AABB*> boxes_;        // of fixtures that may move
  size_t size_ = 0;                   // of all ranges and boxes
  std::unique_ptr<SharedTree> tree_;  // null: its nodes are a range
  std::unique_ptr<State> beginning_;
};

}  // namespace flatland
