#include "four_occluders.hpp"

#include <algorithm>
#include <cmath>

#include "doubles.hpp"
#include "draw_walls.hpp"

namespace flatland {
namespace {

/// The lines a to b of occluders.
struct FourLines {
  FLATLAND_INLINE explicit FourLines(const FourOccluders& four)
      : ax(Load(four.ax)), ay(Load(four.ay)), bx(Load(four.bx)), by(Load(four.by)) {}

  /// Of b - a and the way from a to a point: Cross is above zero to the left.
  FLATLAND_INLINE Doubles Cross(Vec2 point) const {
    return (bx - ax) * (point.y - ay) - (by - ay) * (point.x - ax);
  }
  FLATLAND_INLINE Doubles Dot(Vec2 point) const {
    return (bx - ax) * (point.x - ax) + (by - ay) * (point.y - ay);
  }

  Doubles ax, ay, bx, by;
};

/// Those that cross the line from a to b before its end, or touch it.
FLATLAND_INLINE Mask Meet(const FourLines& walls, Vec2 a, Vec2 b) {
  const Vec2 way = b - a;
  const Doubles right = way.x * (walls.ay - a.y) - way.y * (walls.ax - a.x);
  const Doubles left = way.x * (walls.by - a.y) - way.y * (walls.bx - a.x);
  const Doubles before = walls.Cross(a), behind = walls.Cross(b);
  const Mask are_ends_apart = (Min(right, left) <= 0.0) & (Max(right, left) >= 0.0);
  const Mask from_left = (before > 0.0) & (behind < -kEndTolerance * before);
  const Mask from_right = (before < 0.0) & (behind > -kEndTolerance * before);
  return are_ends_apart & (from_left | from_right);
}

/// Those that cross all lines. They all cross an occluder's line between the points where those
/// from corner to end do. A wall may touch one that it hides, as at the edges of a pillar, but not
/// lie in its line.
FLATLAND_INLINE Mask CrossAll(const FourOccluders& four, const FourLines& walls,
                              const SightLines& lines) {
  const Doubles along_x = walls.bx - walls.ax, along_y = walls.by - walls.ay;
  const Doubles square_length = along_x * along_x + along_y * along_y;
  const Doubles tolerance = kEndTolerance * square_length;
  Doubles heights[4];  // of the corners above the lines of the walls, times their lengths
  for (int i = 0; i < 4; ++i) heights[i] = walls.Cross(lines.corners[i]);
  const Doubles side = heights[0] > 0.0 ? Fill(1.0) : Fill(-1.0);
  for (Doubles& height : heights) height *= side;
  const Vec2 ends[] = {lines.to.a, lines.to.b};
  const Doubles depths[] = {-side * walls.Cross(ends[0]), -side * walls.Cross(ends[1])};
  Mask cross = (Min(Min(heights[0], heights[1]), Min(heights[2], heights[3])) > tolerance) &
               (Min(depths[0], depths[1]) >= 0.0) & (Max(depths[0], depths[1]) > tolerance);
  if (!Any(cross)) return cross;
  const Doubles past_ends = Load(four.past_ends);
  Doubles corner_places[4];
  for (int i = 0; i < 4; ++i) corner_places[i] = walls.Dot(lines.corners[i]);
  for (int end = 0; end < 2 && Any(cross); ++end) {
    const Doubles end_place = walls.Dot(ends[end]);
    for (int i = 0; i < 4; ++i) {
      // Where the line from corner i to this end crosses, from 0 to `whole` along the wall.
      const Doubles place = heights[i] * end_place + depths[end] * corner_places[i];
      const Doubles whole = (heights[i] + depths[end]) * square_length;
      const Doubles margin = past_ends * whole;
      cross &= (place >= -margin) & (place <= whole + margin);
    }
  }
  return cross;
}

/// Those that have a point in a shaft, or are near it.
FLATLAND_INLINE Mask Meet(const FourLines& walls, const Shaft& shaft) {
  Mask meet = (Min(walls.ax, walls.bx) <= shaft.bounds.high.x) &
              (Max(walls.ax, walls.bx) >= shaft.bounds.low.x) &
              (Min(walls.ay, walls.by) <= shaft.bounds.high.y) &
              (Max(walls.ay, walls.by) >= shaft.bounds.low.y);
  for (const Shaft::Side& side : shaft.sides) {
    const Doubles a = side.normal.x * walls.ax + side.normal.y * walls.ay;
    const Doubles b = side.normal.x * walls.bx + side.normal.y * walls.by;
    meet &= Min(a, b) <= side.limit;
  }
  return meet;
}

/// Those that the line from a to b meets, of four boxes.
FLATLAND_INLINE Mask Meet(const FourBoxes& boxes, Vec2 a, Vec2 b) {
  const Vec2 way = b - a, middle = 0.5 * (a + b);
  const Doubles x = Load(boxes.x), half_x = Load(boxes.half_x);
  const Doubles y = Load(boxes.y), half_y = Load(boxes.half_y);
  const Doubles across = way.x * (y - a.y) - way.y * (x - a.x);
  return (Abs(across) <= std::abs(way.x) * half_y + std::abs(way.y) * half_x) &
         (Abs(x - middle.x) <= half_x + 0.5 * std::abs(way.x)) &
         (Abs(y - middle.y) <= half_y + 0.5 * std::abs(way.y));
}

/// Those that a shaft meets, and perhaps more.
FLATLAND_INLINE Mask Meet(const FourBoxes& boxes, const Shaft& shaft) {
  const Vec2 middle = Middle(shaft.bounds), half = shaft.bounds.high - middle;
  const Doubles x = Load(boxes.x), half_x = Load(boxes.half_x);
  const Doubles y = Load(boxes.y), half_y = Load(boxes.half_y);
  Mask meet = (Abs(x - middle.x) <= half_x + half.x) & (Abs(y - middle.y) <= half_y + half.y);
  for (const auto& [normal, limit] : shaft.sides) {
    const Doubles reach = std::abs(normal.x) * half_x + std::abs(normal.y) * half_y;
    meet &= normal.x * x + normal.y * y - reach <= limit;
  }
  return meet;
}

/// The places of four, as bits.
FLATLAND_INLINE uint32_t BitsOf(const Mask& mask) {
  return static_cast<uint32_t>((mask[0] & 1) | (mask[1] & 2) | (mask[2] & 4) | (mask[3] & 8));
}

/// Of places, as bits, those with an occluder that blocks the lines that it meets.
uint32_t Blocking(const FourOccluders& four, uint32_t places, const SightLines& lines) {
  for (int place = 0; place < kGroup; ++place) {
    if (!lines.AreBlockedAt(four.chains[place])) places &= ~(1u << place);
  }
  return places;
}

FLATLAND_INLINE bool BlockAll(const FourOccluders& four, const SightLines& lines) {
  const FourLines walls(four);
  if (!Any(Meet(walls, Middle(lines.from), Middle(lines.to)))) return false;
  const uint32_t places = BitsOf(CrossAll(four, walls, lines));
  return places != 0 && Blocking(four, places, lines) != 0;
}

/// The index of the first one of some fours of which an occluder blocks all lines, or -1.
FLATLAND_CLONES int FindBlocking(const FourOccluders* fours, const std::vector<uint32_t>& some,
                                 const SightLines& lines) {
  for (const uint32_t four : some) {
    if (BlockAll(fours[four], lines)) return static_cast<int>(four);
  }
  return -1;
}

/// The same of those fours with a box that the middle line meets.
FLATLAND_CLONES int FindBlocking(const FourOccluders* fours, const std::vector<FourBoxes>& boxes,
                                 const SightLines& lines) {
  const Vec2 from = Middle(lines.from), to = Middle(lines.to);
  int four = 0;
  for (const FourBoxes& each : boxes) {
    const Mask meet = Meet(each, from, to);
    for (int k = 0; Any(meet) && k < kGroup; ++k) {
      if (meet[k] != 0 && BlockAll(fours[four + k], lines)) return four + k;
    }
    four += kGroup;
  }
  return -1;
}

FLATLAND_CLONES void CollectIn(const FourOccluders* fours, const std::vector<FourBoxes>& boxes,
                               const Shaft& shaft, const SightLines& lines,
                               std::vector<OccluderField::Some>* found) {
  uint32_t four = 0;
  for (const FourBoxes& each : boxes) {
    const Mask meet = Meet(each, shaft);
    for (uint32_t k = 0; Any(meet) && k < kGroup; ++k) {
      if (meet[k] == 0) continue;
      const uint32_t met = BitsOf(Meet(FourLines(fours[four + k]), shaft));
      const uint32_t places = met == 0 ? 0 : Blocking(fours[four + k], met, lines);
      if (places != 0) found->push_back({four + k, places});
    }
    four += kGroup;
  }
}

/// Writes those of some occluders that a shaft meets; returns how many fours that are.
FLATLAND_CLONES size_t Narrow(const FourOccluders* fours, const OccluderField::Some* some,
                              size_t count, const Shaft& shaft, OccluderField::Some* narrowed) {
  size_t left = 0;
  for (size_t i = 0; i < count; ++i) {
    const uint32_t places = some[i].places & BitsOf(Meet(FourLines(fours[some[i].four]), shaft));
    narrowed[left] = {some[i].four, places};
    left += places != 0;
  }
  return left;
}

FLATLAND_CLONES OccluderField::Crossed CrossBy(const FourOccluders* fours, const SightLines& lines,
                                               const OccluderField::Some* begin,
                                               const OccluderField::Some* end) {
  const Vec2 from = Middle(lines.from), to = Middle(lines.to);
  auto crossed = OccluderField::Crossed::kNone;
  for (const OccluderField::Some* some = begin; some != end; ++some) {
    const FourOccluders& four = fours[some->four];
    const FourLines walls(four);
    if ((BitsOf(Meet(walls, from, to)) & some->places) == 0) continue;
    if ((BitsOf(CrossAll(four, walls, lines)) & some->places) != 0) {
      return OccluderField::Crossed::kAll;
    }
    crossed = OccluderField::Crossed::kMiddle;
  }
  return crossed;
}

}  // namespace

FourOccluders::FourOccluders() {
  for (double* each : {ax, ay, bx, by, past_ends}) std::fill_n(each, kGroup, NAN);
  std::fill_n(chains, kGroup, nullptr);
}

void FourOccluders::Set(int place, const Occluder& occluder) {
  ax[place] = occluder.line.a.x;
  ay[place] = occluder.line.a.y;
  bx[place] = occluder.line.b.x;
  by[place] = occluder.line.b.y;
  // Lines may pass a wall just past its ends, but a chord only before them.
  past_ends[place] = occluder.chain == nullptr ? kEndTolerance : -kEndTolerance;
  chains[place] = occluder.chain;
}

FourBoxes::FourBoxes() {
  for (double* each : {x, y, half_x, half_y}) std::fill_n(each, kGroup, NAN);
}

void FourBoxes::Set(int place, const Box& box) {
  const Vec2 middle = Middle(box), half = box.high - middle;
  x[place] = middle.x;
  y[place] = middle.y;
  half_x[place] = half.x;
  half_y[place] = half.y;
}

void OccluderField::Add(const Occluder& occluder) {
  if (used_ == kGroup) {
    if (fours_.size() % kGroup == 0) boxes_.emplace_back();
    fours_.emplace_back();
    box_ = Box();
    used_ = 0;
  }
  fours_.back().Set(used_++, occluder);
  box_.Add(occluder.line);
  boxes_.back().Set(static_cast<int>((fours_.size() - 1) % kGroup), box_);
}

bool OccluderField::Block(const SightLines& lines) {
  int found = FindBlocking(fours_.data(), recent_, lines);
  const bool is_recent = found >= 0;
  if (!is_recent) found = FindBlocking(fours_.data(), boxes_, lines);
  if (found < 0) return false;
  const auto four = static_cast<uint32_t>(found);
  if (is_recent) {
    recent_.erase(std::find(recent_.begin(), recent_.end(), four));
  } else if (recent_.size() == kRecent) {
    recent_.pop_back();
  }
  recent_.insert(recent_.begin(), four);
  return true;
}

void OccluderField::Collect(const Shaft& shaft, const SightLines& lines,
                            std::vector<Some>* found) const {
  CollectIn(fours_.data(), boxes_, shaft, lines, found);
}

void OccluderField::Narrow(const Shaft& shaft, size_t begin, std::vector<Some>* some) const {
  const size_t end = some->size();
  some->resize(end + end - begin);
  some->resize(end + flatland::Narrow(fours_.data(), some->data() + begin, end - begin, shaft,
                                      some->data() + end));
}

OccluderField::Crossed OccluderField::Cross(const SightLines& lines, const std::vector<Some>& some,
                                            size_t begin, size_t end) const {
  return CrossBy(fours_.data(), lines, some.data() + begin, some.data() + end);
}

}  // namespace flatland
