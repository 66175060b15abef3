#include "people/obstacles.hpp"

#include <algorithm>
#include <cmath>

#include "base/to_box2d.hpp"

namespace flatland {
namespace {

constexpr int kMostSides = 4;
// The cosine of 80 degrees: two points of walls count separately if their directions differ by
// more. On a straight wall, points that differ so much from the nearest one are more than 5 times
// as far away. The two walls of a right-angled corner both count.
constexpr double kAnotherSide = 0.17364817766693036;

/// A point as seen from another: its distance [m], and the direction away from it.
Obstacle Seen(Vec2 from, Vec2 point) {
  const Vec2 away = from - point;
  const double distance = LengthOf(away);
  return {distance, distance > 0.0 ? (1.0 / distance) * away : away};
}

/// The point of a segment that is nearest to another point.
Vec2 Nearest(Vec2 point, Vec2 a, Vec2 b) {
  const Vec2 along = b - a;
  const double square = Dot(along, along);
  const double part = square > 0.0 ? std::clamp(Dot(point - a, along) / square, 0.0, 1.0) : 0.0;
  return a + part * along;
}

}  // namespace

Obstacle Outline::SeenFrom(Vec2 point, Vec2 position, const Rotation& heading) const {
  const Vec2 local = heading.ApplyInverse(point - position);
  Obstacle nearest{HUGE_VAL, {}};
  const auto see = [&](Vec2 at, double radius) {
    Obstacle seen = Seen(local, at);
    seen.gap -= radius;
    if (seen.gap < nearest.gap) nearest = seen;
  };
  for (const b2Shape* shape : shapes) {
    if (shape->GetType() == b2Shape::e_circle) {
      const auto& circle = static_cast<const b2CircleShape&>(*shape);
      see(FromBox2D(circle.m_p), circle.m_radius);
    } else {
      const auto& polygon = static_cast<const b2PolygonShape&>(*shape);
      for (int32 i = 0; i < polygon.m_count; ++i) {
        const b2Vec2 next = polygon.m_vertices[i + 1 < polygon.m_count ? i + 1 : 0];
        see(Nearest(local, FromBox2D(polygon.m_vertices[i]), FromBox2D(next)), 0.0);
      }
    }
  }
  nearest.away = heading.Apply(nearest.away);
  return nearest;
}

std::vector<Outline> FindOutlines(const Bodies& bodies, LayerBits layers,
                                  const std::function<bool(Bodies::Body)>& is_left_out) {
  std::vector<Outline> outlines;
  bodies.ForEach([&](Bodies::Body handle, const BodyRecord& record) {
    if (record.is_layer || is_left_out(handle)) return;
    const bool is_dynamic = record.body->GetType() == b2_dynamicBody;
    Outline outline{record.body, {}, is_dynamic && !record.is_person};
    for (const BodyRecord::FixtureRecord& each : record.fixtures) {
      const b2Fixture& fixture = *each.fixture;
      const bool shares_layer = (fixture.GetFilterData().maskBits & layers) != 0;
      if (shares_layer && !fixture.IsSensor()) outline.shapes.push_back(fixture.GetShape());
    }
    if (!outline.shapes.empty()) outlines.push_back(std::move(outline));
  });
  return outlines;
}

void SeeWalls(const Layers& all, LayerBits layers, Vec2 point, double reach,
              std::vector<Obstacle>& found, std::vector<Obstacle>& seen) {
  found.clear();
  seen.clear();
  const Box box{{point.x - reach, point.y - reach}, {point.x + reach, point.y + reach}};
  for (const auto& layer : all.all()) {
    if ((layer->layers() & layers) == 0) continue;
    const SegmentTree& walls = layer->walls();
    walls.ForEachLeafAt(box, [&](size_t leaf) {
      walls.ForEachWall(leaf, [&](uint32_t index) {
        const Segment& wall = walls.segments()[index];
        const Vec2 nearest = Nearest(point, wall.a, wall.b);
        const Vec2 away = point - nearest;
        if (Dot(away, away) <= reach * reach) found.push_back(Seen(point, nearest));
      });
    });
  }
  while (!found.empty() && seen.size() < kMostSides) {
    const auto nearest =
        std::min_element(found.begin(), found.end(),
                         [](const Obstacle& a, const Obstacle& b) { return a.gap < b.gap; });
    seen.push_back(*nearest);
    found.erase(nearest);  // also a point on the wall, which has no direction
    const Vec2 away = seen.back().away;
    const auto is_same_side = [&](const Obstacle& each) {
      return Dot(each.away, away) > kAnotherSide;
    };
    found.erase(std::remove_if(found.begin(), found.end(), is_same_side), found.end());
  }
}

}  // namespace flatland
