/// World: fixtures.

#include <box2d/b2_distance.h>

#include <algorithm>

#include "base/box2d_internals.hpp"
#include "base/box2d_limits.hpp"
#include "base/to_box2d.hpp"
#include "world/layers.hpp"
#include "world/world.hpp"

namespace flatland {
namespace {

/// Boxes are compared with this tolerance [m]: far above the rounding of distances.
constexpr float kTolerance = 0.01f;

/// The radius of a circle. Polygons and edges have none: Box2D puts a skin of a centimetre around
/// them.
float RadiusOf(const b2Shape& shape) {
  return shape.GetType() == b2Shape::e_circle ? shape.m_radius : 0.0f;
}

/// The distance of two shapes, without their radii.
float DistanceOfCores(const b2Fixture& a, const b2Shape& b, const b2Transform& transform_of_b) {
  b2DistanceInput input;
  input.proxyA.Set(a.GetShape(), 0);
  input.proxyB.Set(&b, 0);
  input.transformA = a.GetBody()->GetTransform();
  input.transformB = transform_of_b;
  input.useRadii = false;
  b2SimplexCache cache;
  cache.count = 0;
  b2DistanceOutput output;
  b2Distance(&output, &cache, &input);
  return output.distance;
}

/// True if two shapes overlap or touch.
bool Overlap(const b2Fixture& a, const b2Shape& b, const b2Transform& transform_of_b) {
  return DistanceOfCores(a, b, transform_of_b) <=
         RadiusOf(*a.GetShape()) + RadiusOf(b) + 10.0f * b2_epsilon;
}

double Distance(const b2Fixture& a, const b2Shape& b, const b2Transform& transform_of_b) {
  const float cores = DistanceOfCores(a, b, transform_of_b);
  return std::max(0.0f, cores - RadiusOf(*a.GetShape()) - RadiusOf(b));
}

/// A box around a fixture, with a margin [m].
Box BoxOf(const b2Fixture& fixture, float margin = 0.0f) {
  b2AABB bounds;
  fixture.GetShape()->ComputeAABB(&bounds, fixture.GetBody()->GetTransform(), 0);
  return {{bounds.lowerBound.x - margin, bounds.lowerBound.y - margin},
          {bounds.upperBound.x + margin, bounds.upperBound.y + margin}};
}

bool CanTouch(const b2Fixture& a, const b2Fixture& b) {
  const b2Filter& first = a.GetFilterData();
  const b2Filter& second = b.GetFilterData();
  return !a.IsSensor() && !b.IsSensor() && (first.maskBits & second.categoryBits) != 0 &&
         (second.maskBits & first.categoryBits) != 0;
}

/// Makes a fixture that does not count for the body's mass: with a density, Box2D would sum over
/// all fixtures; see MassSum.
b2Fixture* MakeFixture(b2Body& body, uint32_t index, const b2Shape& shape,
                       const FixtureSettings& settings) {
  b2FixtureDef definition;
  definition.userData.pointer = index;
  definition.shape = &shape;
  definition.density = 0.0f;
  definition.friction = static_cast<float>(settings.friction);
  definition.restitution = static_cast<float>(settings.restitution);
  definition.isSensor = settings.sensor;
  definition.filter.categoryBits = settings.layers;
  definition.filter.maskBits = settings.collides ? settings.layers : 0;
  b2Fixture* const fixture = body.CreateFixture(&definition);
  fixture->SetDensity(static_cast<float>(settings.density));
  return fixture;
}

/// True if a fixture of a dynamic body overlaps a wall of a layer that it collides with.
bool OverlapsWall(const BodyRecord& record, const NearbyWalls& layer) {
  if (record.body->GetType() != b2_dynamicBody) return false;
  return std::any_of(record.fixtures.begin(), record.fixtures.end(), [&](const auto& each) {
    const b2Fixture& fixture = *each.fixture;
    const b2Filter& filter = fixture.GetFilterData();
    const LayerBits common = filter.maskBits & filter.categoryBits & layer.layers();
    if (fixture.IsSensor() || common == 0) return false;
    return layer.Overlaps(fixture.GetAABB(0), [&](const b2Shape& wall, const b2Transform& pose) {
      return Overlap(fixture, wall, pose);
    });
  });
}

/// GetClearance for one fixture; `own` are the bodies that do not count.
double ClearanceOf(const b2Fixture& fixture, const Bodies& bodies, const Layers& layers,
                   const std::vector<const b2Body*>& own, double limit) {
  const Box box = BoxOf(fixture, kTolerance);
  double least = limit;
  bodies.ForEach([&](auto, const BodyRecord& record) {
    const bool is_own = std::find(own.begin(), own.end(), record.body) != own.end();
    if (record.is_layer || is_own) return;
    for (const auto& each : record.fixtures) {
      const b2Fixture& other = *each.fixture;
      if (!CanTouch(fixture, other) || box.Distance(BoxOf(other)) >= least) continue;
      const b2Transform& pose = other.GetBody()->GetTransform();
      least = std::min(least, Distance(fixture, *other.GetShape(), pose));
    }
  });
  b2Transform origin;
  origin.SetIdentity();
  for (const auto& layer : layers.all()) {
    if ((fixture.GetFilterData().maskBits & layer->layers()) == 0) continue;
    const SegmentTree& walls = layer->walls();
    least = walls.Least(box, least, [&](uint32_t index) {
      return Distance(fixture, EdgeOf(walls.segments()[index]), origin);
    });
  }
  return least;
}

}  // namespace

Fixture World::AddCircle(Body body, Vec2 center, double radius, const FixtureSettings& settings) {
  return AddFixture(body, MakeCircle(center, radius), settings);
}

Fixture World::AddPolygon(Body body, const std::vector<Vec2>& vertices,
                          const FixtureSettings& settings) {
  return AddFixture(body, MakePolygon(vertices), settings);
}

Fixture World::AddFixture(Body handle, const b2Shape& shape, const FixtureSettings& settings) {
  b2Body& body = Find(handle);
  Require(!bodies_.Get(handle).is_layer, "a layer has no fixtures but its walls");
  RequireMaterial(settings);
  const bool has_mass = body.GetType() == b2_dynamicBody;
  MassSum mass = bodies_.Get(handle).mass;
  if (has_mass) mass = mass.With(ComputeMass(shape, settings.density));
  const AccessGuard guard(*this);
  BodyRecord& record = bodies_.Get(handle);
  const auto index = static_cast<uint32_t>(record.fixtures.size());
  b2Fixture* const fixture = MakeFixture(body, index, shape, settings);
  if (has_mass && settings.density != 0.0) {
    record.mass = mass;
    record.ResetMass();
  }
  record.fixtures.push_back({fixture, settings.visible, BoundingRadius(shape), settings.collides});
  record.nearby.is_current = false;  // it may reach other walls now
  bodies_.ChangeStructure();
  return {handle, index};
}

void World::SetCircle(Fixture fixture, Vec2 center, double radius,
                      std::optional<LayerBits> layers) {
  SetShape(fixture, MakeCircle(center, radius), layers);
}

void World::SetPolygon(Fixture fixture, const std::vector<Vec2>& vertices,
                       std::optional<LayerBits> layers) {
  SetShape(fixture, MakePolygon(vertices), layers);
}

void World::SetShape(Fixture fixture, const b2Shape& shape, std::optional<LayerBits> layers) {
  RequireAccess();
  BodyRecord& record = bodies_.Get(fixture.body);
  Require(!record.is_layer, "the shape of a wall cannot be changed");
  b2Fixture& old = Find(fixture);
  b2Body& body = *record.body;
  MassSum mass;
  std::vector<float> densities;
  for (const BodyRecord::FixtureRecord& each : record.fixtures) {
    densities.push_back(each.fixture->GetDensity());
    const b2Shape& its_shape = each.fixture == &old ? shape : *each.fixture->GetShape();
    if (body.GetType() == b2_dynamicBody)
      mass = mass.With(ComputeMass(its_shape, densities.back()));
  }
  FixtureSettings settings = GetSettings(fixture);
  settings.collides = record.fixtures[fixture.index].collides;
  settings.layers = layers.value_or(settings.layers);
  const AccessGuard guard(*this);
  WakeBodiesNear(body);
  for (b2ContactEdge* edge = body.GetContactList(); edge != nullptr;) {
    b2Contact* const contact = edge->contact;
    edge = edge->next;
    const bool is_its_own = contact->GetFixtureA() == &old || contact->GetFixtureB() == &old;
    if (is_its_own) box2d::Contacts(*world_).Destroy(contact);  // calls the contact listener
  }
  // Without densities, Box2D does not sum up the masses of the remaining fixtures. It would assert
  // that they have an inertia, which may not be so.
  for (const BodyRecord::FixtureRecord& each : record.fixtures) each.fixture->SetDensity(0.0f);
  body.DestroyFixture(&old);
  BodyRecord::FixtureRecord& replaced = record.fixtures[fixture.index];
  replaced.fixture = MakeFixture(body, fixture.index, shape, settings);
  replaced.seen_radius = BoundingRadius(shape);
  for (size_t i = 0; i < densities.size(); ++i) {
    record.fixtures[i].fixture->SetDensity(densities[i]);
  }
  record.mass = mass;
  record.ResetMass();
  record.nearby.is_current = false;
  WakeBodiesNear(body);
  body.SetAwake(true);
  bodies_.ChangeStructure();
  contacts_.RunDeferred();
}

b2Fixture& World::Find(Fixture fixture) const {
  RequireAccess();
  const auto& fixtures = bodies_.Get(fixture.body).fixtures;
  Require(fixture.index < fixtures.size(), "the body has no such fixture");
  return *fixtures[fixture.index].fixture;
}

NearbyWalls* World::FindLayer(Fixture fixture) const {
  RequireAccess();
  NearbyWalls* const layer = layers_->NearbyOf(bodies_.Get(fixture.body));
  Require(layer == nullptr || fixture.index < layer->size(), "the body has no such fixture");
  return layer;
}

int World::GetFixtureCount(Body body) const {
  RequireAccess();
  return static_cast<int>(layers_->FixtureCountOf(bodies_.Get(body)));
}

FixtureSettings World::GetSettings(Fixture fixture) const {
  FixtureSettings settings;
  if (const NearbyWalls* layer = FindLayer(fixture)) {
    const Material& material = layer->GetMaterial(fixture.index);
    settings.friction = material.friction;
    settings.restitution = material.restitution;
    settings.collides = layer->layers() != 0;
    settings.visible = false;
    settings.layers = layer->layers();
    return settings;
  }
  const b2Fixture& found = Find(fixture);
  settings.density = found.GetDensity();
  settings.friction = found.GetFriction();
  settings.restitution = found.GetRestitution();
  settings.sensor = found.IsSensor();
  settings.collides = found.GetFilterData().maskBits != 0;
  settings.visible = bodies_.Get(fixture.body).fixtures[fixture.index].visible;
  settings.layers = found.GetFilterData().categoryBits;
  return settings;
}

void World::SetFriction(Fixture fixture, double friction) {
  RequireNotNegative(friction, "friction must be finite and not negative");
  if (NearbyWalls* layer = FindLayer(fixture)) {
    const float restitution = layer->GetMaterial(fixture.index).restitution;
    layer->SetMaterial(fixture.index, {static_cast<float>(friction), restitution});
    return;
  }
  Find(fixture).SetFriction(static_cast<float>(friction));
}

void World::SetRestitution(Fixture fixture, double restitution) {
  RequireNotNegative(restitution, "restitution must be finite and not negative");
  if (NearbyWalls* layer = FindLayer(fixture)) {
    const float friction = layer->GetMaterial(fixture.index).friction;
    layer->SetMaterial(fixture.index, {friction, static_cast<float>(restitution)});
    return;
  }
  Find(fixture).SetRestitution(static_cast<float>(restitution));
}

void World::SetVisible(Fixture handle, bool visible) {
  Require(!bodies_.Get(handle.body).is_layer, "lidars see all walls");
  Find(handle);
  const AccessGuard guard(*this);
  bodies_.Get(handle.body).fixtures[handle.index].visible = visible;
  bodies_.ChangeStructure();
}

double World::GetSeenRadius(Fixture handle) const {
  Find(handle);
  return bodies_.Get(handle.body).fixtures[handle.index].seen_radius;
}

void World::SetSeenRadius(Fixture handle, double radius) {
  const bool is_layer = bodies_.Get(handle.body).is_layer;
  Require(!is_layer && Find(handle).GetType() == b2Shape::e_circle, "the fixture is no circle");
  MakeCircle({}, radius);  // checks the radius
  const AccessGuard guard(*this);
  bodies_.Get(handle.body).fixtures[handle.index].seen_radius = radius;
  bodies_.ChangeStructure();
}

bool World::TestPoint(Fixture fixture, Vec2 point) const {
  RequirePosition(point);
  return FindLayer(fixture) == nullptr && Find(fixture).TestPoint(ToBox2D(point));
}

std::vector<World::Body> World::GetOverlappingBodies(Body handle) const {
  const b2Body& body = Find(handle);
  const AccessGuard guard(*this);
  const BodyRecord& record = bodies_.Get(handle);
  struct Collector : b2QueryCallback {
    bool ReportFixture(b2Fixture* other) override {
      b2Body* const owner = other->GetBody();
      const bool is_found = std::find(found.begin(), found.end(), owner) != found.end();
      const bool is_wall = bodies->RecordOf(*owner).is_layer;
      if (!is_found && !is_wall && owner != own->GetBody() && PushesOut(*other)) {
        found.push_back(owner);
      }
      return true;
    }
    bool PushesOut(b2Fixture& other) const {
      const bool is_dynamic = own->GetBody()->GetType() == b2_dynamicBody ||
                              other.GetBody()->GetType() == b2_dynamicBody;
      return is_dynamic && CanTouch(*own, other) &&
             Overlap(*own, *other.GetShape(), other.GetBody()->GetTransform());
    }
    const Bodies* bodies = nullptr;
    const b2Fixture* own = nullptr;
    std::vector<b2Body*> found;
  } collector;
  collector.bodies = &bodies_;
  for (const b2Fixture* f = body.GetFixtureList(); f != nullptr; f = f->GetNext()) {
    if (f->IsSensor()) continue;
    collector.own = f;
    world_->QueryAABB(&collector, f->GetAABB(0));
  }
  if (const NearbyWalls* layer = layers_->NearbyOf(record)) {
    bodies_.ForEach([&](Body, const BodyRecord& other) {
      if (OverlapsWall(other, *layer)) collector.found.push_back(other.body);
    });
  }
  for (const auto& layer : layers_->all()) {
    if (OverlapsWall(record, *layer)) {
      collector.found.push_back(bodies_.Get(bodies_.HandleAt(layer->owner())).body);
    }
  }
  std::vector<Body> bodies;
  for (b2Body* other : collector.found) {
    bodies.push_back(bodies_.HandleOf(*other));
  }
  return bodies;
}

double World::GetClearance(const std::vector<Body>& bodies, double limit) const {
  std::vector<const b2Body*> own;
  for (const Body& each : bodies) own.push_back(&Find(each));
  const AccessGuard guard(*this);
  double least = limit;
  for (const b2Body* body : own) {
    for (const b2Fixture* f = body->GetFixtureList(); f != nullptr; f = f->GetNext()) {
      if (!f->IsSensor()) least = ClearanceOf(*f, bodies_, *layers_, own, least);
    }
  }
  return least;
}

}  // namespace flatland
