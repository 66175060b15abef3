#include "sight/lines_of_sight.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "sight/visible_walls.hpp"

namespace flatland {
namespace {

constexpr double kPiece = 1.0;      // [m]
constexpr double kPieces = 1000.0;  // at most

/// True if a point is to the left of a line, or on it.
bool IsLeft(const Segment& line, Vec2 point) {
  return Cross(line.b - line.a, point - line.a) >= 0.0;
}

bool Cross(const Segment& a, const Segment& b) {
  return IsLeft(a, b.a) != IsLeft(a, b.b) && IsLeft(b, a.a) != IsLeft(b, a.b);
}

}  // namespace

LinesOfSight::LinesOfSight(std::vector<Segment> walls) {
  const auto shared = VisibleWalls::Share(std::move(walls));  // with the layer of the world
  walls_ = {shared, &shared->all()};
}

/// Tests pieces of the line: many walls in the bounding box of a long line are far from it.
bool LinesOfSight::IsBlocked(const Segment& line) const {
  const Vec2 way = line.b - line.a;
  const double length = std::hypot(way.x, way.y);
  const double pieces = std::ceil(std::clamp(length / kPiece, 1.0, kPieces));
  bool is_blocked = false;
  for (double i = 0.0; i < pieces && !is_blocked; ++i) {
    Box box;
    box.Add(line.a + (i / pieces) * way);
    box.Add(line.a + ((i + 1.0) / pieces) * way);
    walls_->ForEachLeafAt(box, [&](size_t leaf) {
      walls_->ForEachWall(leaf, [&](uint32_t index) {
        is_blocked = is_blocked || Cross(line, walls_->segments()[index]);
      });
    });
  }
  return is_blocked;
}

}  // namespace flatland
