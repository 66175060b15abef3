#include "world/settings.hpp"

#include <box2d/box2d.h>

#include "world/world.hpp"

namespace flatland {
namespace {

Setting NumberAt(double& number) {
  return {&number, [](const void* owner) { return *static_cast<const double*>(owner); },
          [](void* owner, double value) { *static_cast<double*>(owner) = value; }};
}

/// A number that Box2D has in single precision, with its functions.
template <auto get, auto set, class Owner>
Setting NumberOf(Owner& owner) {
  return {&owner,
          [](const void* object) -> double { return (static_cast<const Owner*>(object)->*get)(); },
          [](void* object, double value) {
            (static_cast<Owner*>(object)->*set)(static_cast<float>(value));
          }};
}

}  // namespace

std::vector<Setting> SettingsOf(World& world) {
  std::vector<Setting> settings;
  const auto add = [&](auto&... numbers) { (settings.push_back(NumberAt(numbers)), ...); };
  world.mechanisms_.ForEachDrive([&](auto, auto& drive) { drive.ForEachSetting(add); });
  world.lidars_.ForEachSetting(add);
  world.bodies_.ForEach([&](auto, BodyRecord& record) {
    if (record.is_layer) return;
    b2Body& body = *record.body;
    settings.push_back(NumberOf<&b2Body::GetLinearDamping, &b2Body::SetLinearDamping>(body));
    settings.push_back(NumberOf<&b2Body::GetAngularDamping, &b2Body::SetAngularDamping>(body));
    for (const BodyRecord::FixtureRecord& each : record.fixtures) {
      using F = b2Fixture;
      F& fixture = *each.fixture;
      settings.push_back(NumberOf<&F::GetDensity, &F::SetDensity>(fixture));
      settings.back().is_density = true;
      settings.push_back(NumberOf<&F::GetFriction, &F::SetFriction>(fixture));
      settings.push_back(NumberOf<&F::GetRestitution, &F::SetRestitution>(fixture));
    }
  });
  return settings;
}

}  // namespace flatland
