#pragma once

/// Reference scans: random walls, and the nearest one on a beam, found by testing all of them.

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "base/geometry.hpp"
#include "test_numbers.hpp"

namespace flatland {

/// Beyond every wall [m].
inline constexpr double kFar = 1e6;

inline Vec2 Towards(double angle) { return {std::cos(angle), std::sin(angle)}; }

inline Vec2 RandomPoint(std::mt19937& random, Vec2 low, Vec2 high) {
  return {std::uniform_real_distribution<double>(low.x, high.x)(random),
          std::uniform_real_distribution<double>(low.y, high.y)(random)};
}

inline Vec2 RandomDirection(std::mt19937& random) {
  return Towards(std::uniform_real_distribution<double>(-M_PI, M_PI)(random));
}

/// Distance to the nearest wall, each extended at both ends by `longer` times its length [m].
inline double TryEveryWall(const std::vector<Segment>& walls, Vec2 origin, Vec2 direction,
                           double longer) {
  double nearest = kInfinity;
  for (const Segment& wall : walls) {
    // Distances of the wall's ends to the left of the ray.
    const double left_a = Cross(direction, wall.a - origin);
    const double left_b = Cross(direction, wall.b - origin);
    if (left_a == left_b) continue;
    const double part = left_a / (left_a - left_b);
    if (part < -longer || part > 1.0 + longer) continue;
    const double ahead =
        Dot(direction, wall.a - origin) * (1.0 - part) + Dot(direction, wall.b - origin) * part;
    if (ahead >= 0.0) nearest = std::min(nearest, ahead);
  }
  return nearest;
}

inline std::vector<Segment> RandomWalls(int count, double longest) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> length(0.01, longest);
  std::vector<Segment> walls;
  for (int i = 0; i < count; ++i) {
    const Vec2 a = RandomPoint(random, {0, 0}, {20, 10});
    const Vec2 direction = RandomDirection(random);
    const double l = length(random);
    walls.push_back({a, {a.x + l * direction.x, a.y + l * direction.y}});
  }
  return walls;
}

/// The outlines of random unit pixels, as they are made from a map image: a wall along every border
/// between black and white.
inline std::vector<Segment> PixelWalls(int columns, int rows) {
  std::mt19937 random(3);
  std::vector<std::vector<bool>> black(columns + 2, std::vector<bool>(rows + 2, false));
  for (int x = 1; x <= columns; ++x) {
    for (int y = 1; y <= rows; ++y) black[x][y] = random() % 5 == 0;
  }
  std::vector<Segment> walls;
  for (int x = 0; x <= columns; ++x) {
    for (int y = 0; y <= rows; ++y) {
      const double left = x, bottom = y, right = x + 1, top = y + 1;
      if (black[x][y] != black[x + 1][y]) walls.push_back({{right, bottom}, {right, top}});
      if (black[x][y] != black[x][y + 1]) walls.push_back({{left, top}, {right, top}});
    }
  }
  return walls;
}

}  // namespace flatland
