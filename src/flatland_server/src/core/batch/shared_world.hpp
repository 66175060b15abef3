#pragma once

/// Many states of one world, which share all that does not change.
///
/// Need. Thousands of environments begin alike. Each could be a World, but stepping one after the
/// other would take twice as long: Box2D spreads a world over 90 KB of memory.
///
/// Method. There is one World. Before a step, another state takes the place of its present one:
///
/// - What every state has is exchanged byte by byte: Box2D's bodies that may move, the boxes of
///   their fixtures, and joints; drives, tweens and crowds. These objects stay at their places, so
///   all pointers between them stay right.
/// - What only one state has, because Box2D made it in this state, stays where it is: contacts, the
///   walls near bodies, the tree of bounding boxes, and delayed commands. Only the pointers to it
///   are exchanged.
///
/// - Walls belong to the world, or to a state that has others in the first layer: a map of its own.
/// - Settings belong to the world, but for those that vary: each state has values of these.
///
/// So a state makes, bit for bit, the steps that a World of its own makes.

#include <cstddef>
#include <memory>
#include <string_view>
#include <type_traits>
#include <vector>

#include "base/prefetch.hpp"
#include "sight/visible_walls.hpp"
#include "world/nearby_walls.hpp"
#include "world/settings.hpp"
#include "world/world.hpp"
#include "world/world_state.hpp"

namespace flatland {

/// The part of a SharedWorld that each environment has for itself.
class SharedState {
 public:
  using Walls = std::shared_ptr<const VisibleWalls>;

  const Walls& walls() const { return walls_; }
  /// Takes the settings of another state of the same world, or of an equal one.
  void TakeSettings(const SharedState& other) {
    settings_ = other.settings_;
    masses_ = other.masses_;
  }

 private:
  friend class SharedWorld;
  std::vector<std::byte> bytes_;            // of the ranges, one after the other
  b2BroadPhase broad_phase_;                // with the tree of bounding boxes
  std::vector<NearbyWalls::Held> held_;     // of each layer
  std::vector<BodyRecord::Nearby> nearby_;  // of each body that may move
  Walls walls_;                             // of the first layer, or null: those of the world
  std::vector<DelayLine> lines_;            // of the drives' actuators
  std::vector<double> settings_;            // values of those that vary
  std::vector<b2MassData> masses_;          // of bodies with densities that vary; empty: those
                                            // at the beginning
};

class SharedWorld {
 public:
  /// Takes a world, which must not be given to anything else. Nothing may be added to it or removed
  /// any more. Of static bodies, only `moved` may be moved; of settings, only those of the indices
  /// `varied` may differ between states. Throws std::invalid_argument for a wrong index.
  explicit SharedWorld(std::unique_ptr<World> world, const std::vector<World::Body>& moved = {},
                       const std::vector<int>& varied = {});

  /// Makes a state: that of the world at the beginning, with `walls` in its first layer unless
  /// null. It must be destroyed before the SharedWorld. Throws std::invalid_argument if the walls
  /// cannot be exchanged.
  std::unique_ptr<SharedState> MakeState(SharedState::Walls walls = nullptr);
  /// Prefetches a state. To be called with a `distance` of kPrefetched down to 1: each call follows
  /// the pointers that the call before has prefetched.
  static constexpr int kPrefetched = 4;
  static void Prefetch(SharedState& state, int distance);
  /// The world while it is in a state, which keeps all changes. Only one may exist at a time.
  class Entered {
   public:
    Entered(SharedWorld& shared, SharedState& state) : shared_(shared), state_(state) {
      shared.Enter(state);
    }
    ~Entered() { shared_.Leave(state_); }
    Entered(const Entered&) = delete;
    Entered& operator=(const Entered&) = delete;
    World& world() const { return *shared_.world_; }

   private:
    SharedWorld& shared_;
    SharedState& state_;
  };

  /// Gives a state other values of the settings that vary. The masses follow when it begins again.
  /// Throws std::invalid_argument, and changes nothing, if a body cannot have its mass.
  void Set(SharedState& state, const double* values);
  /// Puts the entered world, in this state, back to the beginning.
  void Begin(World& world, const SharedState& state) const;
  /// Reads a saved state, which can be restored to the entered world of any state. `state`: any
  /// state of this world. Throws std::invalid_argument if the bytes are damaged, or differ in
  /// something that all states share.
  WorldState Read(std::string_view bytes, SharedState& state);

 private:
  /// Memory that steps change.
  struct Range {
    void* address;
    size_t size;
  };
  template <class T>
  void AddRange(T& object) {
    ranges_.push_back({&object, sizeof(T)});
  }
  template <class... Parts>
  void AddParts(Parts&... parts) {
    static_assert((std::is_trivially_copyable_v<Parts> && ...));
    (AddRange(parts), ...);
  }
  template <class Mechanism>
  void AddRanges(SlotMap<Mounted<Mechanism>>& mechanisms) {
    mechanisms.ForEach([this](auto, Mounted<Mechanism>& each) {
      if constexpr (std::is_trivially_copyable_v<Mechanism>) {
        AddRange(each.mechanism);
      } else {
        each.mechanism.ForEachPart([this](auto&... parts) { AddParts(parts...); });
      }
    });
  }
  void Enter(SharedState& state);
  void Leave(SharedState& state);
  void CollectRanges();
  void CollectVaried(const std::vector<int>& varied);
  void JoinRanges();
  /// Exchanges the pointers to what only this state has.
  void ExchangeOwn(SharedState& state);

  std::unique_ptr<World> world_;
  std::vector<Setting> varied_;
  std::vector<BodyRecord*> weighed_;  // with densities that vary
  WorldState beginning_;
  std::vector<Range> ranges_;
  std::vector<std::byte> empty_;  // the ranges of a state without contacts and walls
};

}  // namespace flatland
