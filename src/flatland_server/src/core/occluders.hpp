#pragma once

/// Occluders, which hide walls of a layer from a place, for VisibleWalls: walls, and chords.
///
/// Need. Outlines from map images have steps of a pixel. Lines that cross such an outline near a
/// step cross one wall or the other, so that no single wall is met by all of them.
///
/// Method. A chain is a number of walls, each of which begins where the last one ends. Its chord is
/// the line from its first point to its last one. A line that crosses the chord, and begins and
/// ends outside of the chain's bounding box, crosses the chain: chain and chord together are a
/// closed curve, which it crosses an even number of times. So a chord hides what is behind it as a
/// wall does, if both the place and what is hidden are outside of that box. These are the "virtual
/// occluders" of Koltun, Chrysanthou and Cohen-Or, "Virtual Occluders: An Efficient Intermediate
/// PVS Representation", 2000.

#include <cstdint>
#include <memory>
#include <vector>

#include "flatland_server/geometry.hpp"
#include "flatland_server/segment_tree.hpp"

namespace flatland {

/// A wall or a chord.
struct Occluder {
  Segment line;
  const Box* chain = nullptr;  ///< bounding box of the chord's chain; null for a wall
};

class Occluders {
 public:
  /// The chain of a chord.
  struct Chain {
    Box box;
    size_t begin, end;  ///< of its walls, in an order of all walls in which they are neighbours
  };

  /// The occluders of a layer. They refer to its walls, which must live as long.
  explicit Occluders(const SegmentTree& walls);

  /// The tree of their lines, and the occluder with an index in its segments().
  const SegmentTree& tree() const { return tree_; }
  Occluder Get(uint32_t index) const {
    return {tree_.segments()[index],
            chains_.empty() || index < long_.size() ? nullptr : &chains_[index - long_.size()].box};
  }

  /// A chain that ends where it begins and does not cross itself: a wall of it that turns its back
  /// on a place is hidden by others of it.
  struct Outline {
    size_t begin, end;  ///< of its walls, in in_order()
  };
  const std::vector<Outline>& outlines() const { return outlines_; }
  /// All walls, chain by chain; empty if there are too many.
  const std::vector<uint32_t>& in_order() const { return in_order_; }
  /// The side of a wall of an outline.
  struct Side {
    int32_t outline = -1;  ///< none
    bool is_inside_left =
        false;  ///< the inside of the outline is to the left of the way from a to b
  };
  Side SideOf(uint32_t wall) const { return sides_.empty() ? Side() : sides_[wall]; }

  /// For each occluder, whether it is one of these walls, or its chain has one.
  std::vector<bool> AreOf(const std::vector<uint32_t>& walls) const;

  struct Walk;

  /// With more walls there are no chords: it takes too long to sort them.
  static constexpr size_t kMaxWalls = 100'000;

 private:
  std::unique_ptr<const SegmentTree> AddChains(const SegmentTree& walls);
  void AddOutline(const Walk& chain, const std::vector<Segment>& walls);

  size_t wall_count_;
  std::vector<Chain> chains_;       // of the chords, which come after the walls
  std::vector<uint32_t> long_;      // those walls that are occluders, if there are chords
  std::vector<uint32_t> in_order_;  // all walls, chain by chain
  std::vector<Outline> outlines_;
  std::vector<Side> sides_;  // of each wall
  std::unique_ptr<const SegmentTree> with_chords_;
  const SegmentTree& tree_;
};

}  // namespace flatland
