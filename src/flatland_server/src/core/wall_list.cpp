#include "flatland_server/wall_list.hpp"

#include <algorithm>

namespace flatland {

WallList::WallList(const std::vector<Segment>& walls, const std::vector<uint32_t>& indices,
                   Vec2 place)
    : walls_(walls.data()), size_(indices.size()) {
  for (size_t begin = 0; begin < indices.size(); begin += kBlockSize) {
    Block& block = blocks_.emplace_back();
    for (size_t i = 0; i < kBlockSize; ++i) {
      block.indices[i] = indices[std::min(begin + i, indices.size() - 1)];
      block.box.Add(walls[block.indices[i]]);
    }
  }
  std::stable_sort(blocks_.begin(), blocks_.end(), [&](const Block& a, const Block& b) {
    return a.box.SquareDistance(place) < b.box.SquareDistance(place);
  });
}

}  // namespace flatland
