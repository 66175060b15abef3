#include "flatland_server/shared_world.hpp"

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <functional>

#include "box2d_copies.hpp"
#include "box2d_internals.hpp"
#include "box2d_limits.hpp"
#include "prefetch.hpp"
#include "shared_tree.hpp"
#include "tree_order.hpp"
#include "world_state.hpp"

namespace flatland {
namespace {

/// Up to so many nodes of the tree for each fixture that moves, it takes longer to find those that
/// have changed than to copy all.
constexpr size_t kFewNodes = 8;

std::byte* EndOf(void* begin, size_t size) { return static_cast<std::byte*>(begin) + size; }

}  // namespace

SharedWorld::State::State() = default;
SharedWorld::State& SharedWorld::State::operator=(const State&) = default;
SharedWorld::State::~State() = default;

SharedWorld::SharedWorld(std::unique_ptr<World> world, const std::vector<World::Body>& moved)
    : world_(std::move(world)) {
  b2World& box2d_world = *world_->world_;
  for (const World::Body& body : moved) world_->bodies_.LetMove(body);
  SkipWalls();
  std::vector<b2Fixture*> moving;
  world_->bodies_.ForEach([&](World::Body, const BodyRecord& record) {
    if (!record.may_move) return;
    for (const BodyRecord::FixtureRecord& each : record.fixtures) moving.push_back(each.fixture);
  });
  beginning_.reset(new State());
  if (SharedTree::CountNodes(box2d_world) > kFewNodes * moving.size()) {
    tree_ = std::make_unique<SharedTree>(box2d_world, moving, beginning_->nodes_);
    tree_->Enter(beginning_->nodes_);
  }
  CollectRanges();
  beginning_->bytes_.resize(size_);
  Leave(*beginning_);
}

// Box2D frees contacts with the memory that they are in.
SharedWorld::~SharedWorld() = default;

/// At first each fixture is to be tested for contacts with the others. Box2D finds a pair when it
/// tests the later one of two such fixtures. So a wall finds nothing if all fixtures before it are
/// walls: two walls have no contact.
void SharedWorld::SkipWalls() {
  b2World& box2d_world = *world_->world_;
  b2TreeNode* const nodes = box2d::Nodes(box2d_world);
  const auto is_wall = [&](int32 proxy) { return box2d::IsWall(nodes[proxy]); };
  int32* const begin = box2d::Moves(box2d_world);
  int32* const end = begin + box2d::MoveCount(box2d_world);
  int32 first_body = INT32_MAX;
  for (const int32* proxy = begin; proxy != end; ++proxy) {
    if (*proxy >= 0 && !is_wall(*proxy)) first_body = std::min(first_body, *proxy);
  }
  int32* const kept = std::stable_partition(
      begin, end, [&](int32 proxy) { return proxy < 0 || !is_wall(proxy) || proxy > first_body; });
  for (const int32* proxy = kept; proxy != end; ++proxy) nodes[*proxy].moved = false;
  box2d::MoveCount(box2d_world) = static_cast<int32>(kept - begin);
}

void SharedWorld::AddRange(void* address, size_t size) {
  if (!ranges_.empty() && EndOf(ranges_.back().address, ranges_.back().size) == address) {
    ranges_.back().size += size;
  } else {
    ranges_.push_back({address, size});
  }
}

void SharedWorld::CollectRanges() {
  b2World& box2d_world = *world_->world_;
  b2ContactManager& contacts = box2d::Contacts(box2d_world);
  world_->bodies_.ForEach([this](World::Body, BodyRecord& record) {
    if (record.may_move) AddRange(*record.body);
  });
  JoinBodies();
  AddRange(contacts.m_contactList);
  AddRange(contacts.m_contactCount);
  AddRange(box2d::InverseStep(box2d_world));
  AddRange(box2d::NewContacts(box2d_world));
  AddRange(box2d::Tree(box2d_world));
  if (!tree_) {
    AddRange(box2d::Nodes(box2d_world), SharedTree::CountNodes(box2d_world) * sizeof(b2TreeNode));
  }
  world_->bodies_.ForEach([this](World::Body, BodyRecord& record) {
    if (!record.may_move) {
      AddRange(box2d::ContactList(*record.body));
      return;
    }
    for (const BodyRecord::FixtureRecord& each : record.fixtures) {
      b2FixtureProxy* proxies = box2d::FixtureInternals::Proxies(*each.fixture);
      const int32 count = box2d::FixtureInternals::ProxyCount(*each.fixture);
      for (int32 i = 0; i < count; ++i) boxes_.push_back(&proxies[i].aabb);
    }
  });
  world_->joints_.ForEach([this](World::Joint, b2Joint* joint) {
    if (joint->GetType() == e_weldJoint) {
      AddRange(static_cast<b2WeldJoint&>(*joint));
    } else {
      AddRange(static_cast<b2RevoluteJoint&>(*joint));
    }
  });
  world_->mechanisms_.ForEachMap([this](auto& map) { AddRanges(map); });
  world_->crowds_.ForEach([this](auto, Crowd& crowd) {
    crowd.ForEachPart([this](auto& part) {
      static_assert(std::is_trivially_copyable_v<std::decay_t<decltype(part)>>);
      AddRange(part);
    });
  });
  size_ = boxes_.size() * sizeof(b2AABB);
  for (const Range& range : ranges_) size_ += range.size;
}

/// Box2D's bodies are mostly neighbours in memory, with padding between them in which no other
/// object fits.
void SharedWorld::JoinBodies() {
  constexpr ptrdiff_t kLeastObject = 16;
  const auto begin_of = [](const Range& range) { return static_cast<std::byte*>(range.address); };
  std::sort(ranges_.begin(), ranges_.end(), [&](const Range& a, const Range& b) {
    return std::less<>()(begin_of(a), begin_of(b));
  });
  std::vector<Range> joined;
  for (const Range& range : ranges_) {
    const ptrdiff_t gap = joined.empty()
                              ? kLeastObject
                              : begin_of(range) - EndOf(joined.back().address, joined.back().size);
    if (gap < kLeastObject) {
      joined.back().size += gap + range.size;
    } else {
      joined.push_back(range);
    }
  }
  ranges_ = std::move(joined);
}

std::unique_ptr<SharedWorld::State> SharedWorld::MakeState() {
  std::unique_ptr<State> state(new State());
  Copy(*beginning_, *state);
  return state;
}

void SharedWorld::Prefetch(const State& state) {
  PrefetchElements(state.bytes_);
  PrefetchElements(state.nodes_);
}

void SharedWorld::PrefetchUsed(const State& state) const {
  if (tree_) tree_->Prefetch(state.nodes_);
}

void SharedWorld::WriteRanges(const State& state) {
  const std::byte* from = state.bytes_.data();
  for (const Range& range : ranges_) {
    std::memcpy(range.address, from, range.size);
    from += range.size;
  }
  for (b2AABB* const box : boxes_) {
    std::memcpy(box, from, sizeof *box);
    from += sizeof *box;
  }
}

World& SharedWorld::Enter(const State& state) {
  b2World& box2d_world = *world_->world_;
  WriteRanges(state);
  if (tree_) tree_->Enter(state.nodes_);
  std::copy(state.moves_.begin(), state.moves_.end(), box2d::Moves(box2d_world));
  box2d::MoveCount(box2d_world) = static_cast<int32>(state.moves_.size());
  world_->bodies_.ChangePoses();
  return *world_;
}

void SharedWorld::ReadRanges(State& state) const {
  std::byte* to = state.bytes_.data();
  for (const Range& range : ranges_) {
    std::memcpy(to, range.address, range.size);
    to += range.size;
  }
  for (const b2AABB* const box : boxes_) {
    std::memcpy(to, box, sizeof *box);
    to += sizeof *box;
  }
}

void SharedWorld::Leave(State& state) {
  b2World& box2d_world = *world_->world_;
  ReadRanges(state);
  const int32* moves = box2d::Moves(box2d_world);
  state.moves_.assign(moves, moves + box2d::MoveCount(box2d_world));
  if (tree_) tree_->Leave(state.nodes_);
}

void SharedWorld::Replace(const State& from, State& state) {
  b2ContactManager& contacts = box2d::Contacts(*world_->world_);
  WriteRanges(state);
  while (contacts.m_contactList != nullptr) contacts.Destroy(contacts.m_contactList);
  Copy(from, state);
}

void SharedWorld::Copy(const State& from, State& to) {
  to = from;
  WriteRanges(from);
  b2World& box2d_world = *world_->world_;
  b2ContactManager& manager = box2d::Contacts(box2d_world);
  if (manager.m_contactCount == 0) return;
  std::vector<b2Contact*> contacts;
  for (b2Contact* c = manager.m_contactList; c != nullptr; c = c->GetNext()) contacts.push_back(c);
  manager.m_contactList = nullptr;
  manager.m_contactCount = 0;
  world_->bodies_.ForEach(
      [](auto, BodyRecord& record) { box2d::ContactList(*record.body) = nullptr; });
  for (auto each = contacts.rbegin(); each != contacts.rend(); ++each) {
    box2d::CopyContact(box2d_world, **each);
  }
  // A new contact wakes its bodies, so all but the lists of contacts is that of before.
  b2Contact* const first = manager.m_contactList;
  std::vector<b2ContactEdge*> edges;
  world_->bodies_.ForEach(
      [&](auto, BodyRecord& record) { edges.push_back(box2d::ContactList(*record.body)); });
  WriteRanges(from);
  manager.m_contactList = first;
  auto edge = edges.begin();
  world_->bodies_.ForEach(
      [&](auto, BodyRecord& record) { box2d::ContactList(*record.body) = *edge++; });
  ReadRanges(to);
}

void SharedWorld::Load(const WorldState& saved, State& state) {
  saved.Restore(Enter(state));
  Leave(state);
}

void SharedWorld::RequireLoadable(const WorldState& saved) const {
  saved.RequireSameStill(*world_);
  Require(saved.tree.size() <= SharedTree::CountNodes(*world_->world_),
          "the state is of another world: models were deleted and others added");
}

}  // namespace flatland
