#pragma once

/// Making Box2D's objects again.

#include <box2d/box2d.h>

namespace flatland::box2d {

/// The definition of a body at its present pose.
b2BodyDef DefinitionOf(b2Body& body);
/// The definition of a fixture, with its shape.
b2FixtureDef DefinitionOf(b2Fixture& fixture);
/// A joint like another one, between copies `a` and `b` of its bodies; without its impulses.
b2Joint* CopyJoint(b2World& world, b2Joint& old, b2Body* a, b2Body* b);
/// Makes a contact, which becomes Box2D's newest, and wakes its bodies. Null if the two have one
/// already, or cannot collide.
b2Contact* MakeContact(b2World& world, b2Fixture& a, b2Fixture& b);

}  // namespace flatland::box2d
