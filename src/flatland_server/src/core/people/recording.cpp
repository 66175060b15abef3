#include "people/recording.hpp"

#include <algorithm>

#include "base/box2d_limits.hpp"

namespace flatland {

void Recording::Require() const {
  const int64_t* last = nullptr;
  for (const Walk& walk : walks) {
    flatland::Require(!walk.times.empty() && walk.times.size() == walk.points.size(),
                      "a walk needs a point for each of its times");
    for (const Vec2& point : walk.points) RequirePosition(point);
    for (const int64_t& time : walk.times) {
      flatland::Require(last == nullptr || *last < time, "times must ascend");
      last = &time;
    }
  }
}

int Recording::WalkAt(int64_t time) const {
  const auto found = std::partition_point(
      walks.begin(), walks.end(), [time](const Walk& walk) { return walk.times.back() < time; });
  if (found == walks.end() || found->times.front() > time) return -1;
  return static_cast<int>(found - walks.begin());
}

Vec2 Recording::PointAt(int index, int64_t time) const {
  const auto& [times, points] = walks[static_cast<size_t>(index)];
  const auto next = std::upper_bound(times.begin(), times.end(), time);
  if (next == times.begin()) return points.front();
  if (next == times.end()) return points.back();
  const auto i = static_cast<size_t>(next - times.begin());
  const double part =
      static_cast<double>(time - times[i - 1]) / static_cast<double>(times[i] - times[i - 1]);
  return points[i - 1] + part * (points[i] - points[i - 1]);
}

}  // namespace flatland
