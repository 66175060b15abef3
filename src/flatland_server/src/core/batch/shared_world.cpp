#include "batch/shared_world.hpp"

#include <algorithm>
#include <cstring>
#include <functional>
#include <utility>

#include "base/box2d_internals.hpp"
#include "base/box2d_limits.hpp"
#include "world/layers.hpp"

namespace flatland {
namespace {

std::byte* BytesOf(void* object) { return static_cast<std::byte*>(object); }

}  // namespace

SharedWorld::SharedWorld(std::unique_ptr<World> world, const std::vector<World::Body>& moved,
                         const std::vector<int>& varied)
    : world_(std::move(world)) {
  for (const World::Body& body : moved) world_->bodies_.AllowMotion(body);
  if (!varied.empty()) CollectVaried(varied);
  beginning_ = WorldState::Of(*world_);
  WorldState::Clear(*world_);
  CollectRanges();
  for (const Range& range : ranges_) {
    std::byte* const begin = BytesOf(range.address);
    empty_.insert(empty_.end(), begin, begin + range.size);
  }
}

void SharedWorld::CollectRanges() {
  b2World& box2d_world = *world_->world_;
  b2ContactManager& contacts = box2d::Contacts(box2d_world);
  // A step puts the bodies of walls in front of this body in Box2D's list. So, of all bodies that
  // are shared, only this one points to them.
  const b2BodyDef last;
  AddRange(*box2d_world.CreateBody(&last));
  AddRange(box2d::BodyList(box2d_world));
  AddRange(box2d::BodyCount(box2d_world));
  AddRange(contacts.m_contactList);
  AddRange(contacts.m_contactCount);
  AddRange(box2d::InverseStep(box2d_world));
  AddRange(box2d::NewContacts(box2d_world));
  world_->bodies_.ForEach([this](World::Body, BodyRecord& record) {
    if (!record.may_move) {
      AddRange(box2d::ContactList(*record.body));
      return;
    }
    AddRange(*record.body);
    for (const BodyRecord::FixtureRecord& each : record.fixtures) {
      AddRange(*box2d::FixtureInternals::Proxies(*each.fixture));
    }
  });
  world_->joints_.ForEach([this](World::Joint, b2Joint* joint) {
    switch (joint->GetType()) {
      case e_weldJoint:
        AddRange(static_cast<b2WeldJoint&>(*joint));
        break;
      case e_frictionJoint:
        AddRange(static_cast<b2FrictionJoint&>(*joint));
        break;
      default:
        AddRange(static_cast<b2RevoluteJoint&>(*joint));
    }
  });
  world_->mechanisms_.ForEachMap([this](auto& map) { AddRanges(map); });
  world_->crowds_.ForEach(
      [this](auto, Crowd& crowd) { crowd.ForEachPart([this](auto& part) { AddParts(part); }); });
  JoinRanges();
}

void SharedWorld::CollectVaried(const std::vector<int>& varied) {
  const std::vector<Setting> settings = SettingsOf(*world_);
  for (const int index : varied) {
    Require(index >= 0 && index < static_cast<int>(settings.size()), "there is no such setting");
    varied_.push_back(settings[index]);
  }
  world_->bodies_.ForEach([this](World::Body, BodyRecord& record) {
    const auto is_varied = [&](const BodyRecord::FixtureRecord& each) {
      return std::any_of(varied_.begin(), varied_.end(), [&](const Setting& setting) {
        return setting.is_density && setting.owner == each.fixture;
      });
    };
    const auto& fixtures = record.fixtures;
    if (record.body->GetType() == b2_dynamicBody &&
        std::any_of(fixtures.begin(), fixtures.end(), is_varied)) {
      weighed_.push_back(&record);
    }
  });
}

/// Joins ranges that are neighbours in memory, with a gap between them too small for another
/// object.
void SharedWorld::JoinRanges() {
  constexpr ptrdiff_t kLeastObject = 16;
  std::sort(ranges_.begin(), ranges_.end(),
            [](const Range& a, const Range& b) { return std::less<>()(a.address, b.address); });
  std::vector<Range> joined;
  for (const Range& range : ranges_) {
    std::byte* const begin = BytesOf(range.address);
    const ptrdiff_t gap = joined.empty() ? kLeastObject
                                         : begin - BytesOf(joined.back().address) -
                                               static_cast<ptrdiff_t>(joined.back().size);
    if (gap < kLeastObject) {
      joined.back().size += gap + range.size;
    } else {
      joined.push_back(range);
    }
  }
  ranges_ = std::move(joined);
}

std::unique_ptr<SharedState> SharedWorld::MakeState(SharedState::Walls walls) {
  const auto& layers = world_->layers_->all();
  if (walls != nullptr) {
    Require(!layers.empty(), "the world has no layer");
    const bool is_at_beginning = std::all_of(
        layers.begin(), layers.end(), [](const auto& each) { return each->IsAtBeginning(); });
    Require(is_at_beginning && beginning_.IsApartFromWalls(),
            "environments begin with bodies near walls");
  }
  auto state = std::make_unique<SharedState>();
  state->bytes_ = empty_;
  state->held_.resize(layers.size());
  state->nearby_.resize(world_->bodies_.Moving().size());
  state->walls_ = std::move(walls);
  for (const Setting& each : varied_) state->settings_.push_back(each.Get());
  const auto add_line = [&](DelayLine&) { state->lines_.emplace_back(); };
  world_->mechanisms_.ForEachActuator([&](auto, Actuator& each) { each.ForEachLine(add_line); });
  beginning_.Restore(Entered(*this, *state).world());
  return state;
}

void SharedWorld::Set(SharedState& state, const double* values) {
  std::vector<b2MassData> masses;
  if (!weighed_.empty()) {
    const Entered entered(*this, state);
    for (size_t i = 0; i < varied_.size(); ++i) varied_[i].Set(values[i]);
    for (const BodyRecord* const record : weighed_) {
      MassSum sum;
      for (const BodyRecord::FixtureRecord& each : record->fixtures) {
        const float density = each.fixture->GetDensity();
        if (density != 0.0f) sum = sum.With(ComputeMass(*each.fixture->GetShape(), density));
      }
      masses.push_back(sum.ToBox2D());
    }
  }
  state.settings_.assign(values, values + varied_.size());
  state.masses_ = std::move(masses);
}

void SharedWorld::Begin(World& world, const SharedState& state) const {
  beginning_.Restore(world);
  for (size_t i = 0; i < state.masses_.size(); ++i) weighed_[i]->SetMass(state.masses_[i]);
}

void SharedWorld::Prefetch(SharedState& state, int distance) {
  if (distance == 4) return PrefetchObject(state);
  if (distance == 3) {
    if (state.walls_ != nullptr) PrefetchObject(*state.walls_);
    return PrefetchElements(state.held_);
  }
  if (distance == 2) {
    PrefetchElements(state.bytes_);
    PrefetchElements(state.nearby_);
    for (const NearbyWalls::Held& held : state.held_) PrefetchElements(held);
    return;
  }
  b2DynamicTree& tree = box2d::Tree(state.broad_phase_);
  PrefetchBytes(box2d::Nodes(tree), box2d::NodeCount(tree) * sizeof(b2TreeNode));
  for (const NearbyWalls::Held& held : state.held_) {
    for (const NearbyWalls::Block& block : held) PrefetchObject(*block.body);
  }
}

void SharedWorld::ExchangeOwn(SharedState& state) {
  std::byte* const present = BytesOf(&box2d::Contacts(*world_->world_).m_broadPhase);
  std::swap_ranges(present, present + sizeof(b2BroadPhase), BytesOf(&state.broad_phase_));
  auto held = state.held_.begin();
  for (const auto& each : world_->layers_->all()) each->Exchange(*held++);
  if (state.walls_ != nullptr) world_->layers_->all().front()->ExchangeWalls(state.walls_);
  auto nearby = state.nearby_.begin();
  for (BodyRecord* const record : world_->bodies_.Moving()) std::swap(record->nearby, *nearby++);
  auto line = state.lines_.begin();
  const auto exchange = [&](DelayLine& each) { std::swap(each, *line++); };
  world_->mechanisms_.ForEachActuator([&](auto, Actuator& each) { each.ForEachLine(exchange); });
}

void SharedWorld::Enter(SharedState& state) {
  ExchangeOwn(state);
  const std::byte* from = state.bytes_.data();
  for (const Range& range : ranges_) {
    std::memcpy(range.address, from, range.size);
    from += range.size;
  }
  for (size_t i = 0; i < varied_.size(); ++i) varied_[i].Set(state.settings_[i]);
  world_->bodies_.ChangePoses();
}

void SharedWorld::Leave(SharedState& state) {
  std::byte* to = state.bytes_.data();
  for (const Range& range : ranges_) {
    std::memcpy(to, range.address, range.size);
    to += range.size;
  }
  ExchangeOwn(state);
}

WorldState SharedWorld::Read(std::string_view bytes, SharedState& state) {
  const Entered entered(*this, state);
  WorldState read = WorldState::Read(bytes, entered.world());
  read.RequireSameStill(entered.world());
  return read;
}

}  // namespace flatland
