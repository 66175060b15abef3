/// SharedTree: finds all nodes that steps change, without looking at all of them.

#include "../../src/core/shared_tree.hpp"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstring>
#include <random>
#include <vector>

#include "../../src/core/box2d_internals.hpp"

namespace flatland {
namespace {

class SharedTreeTest : public testing::Test {
 protected:
  float Random(float low, float high) {
    return std::uniform_real_distribution<float>(low, high)(engine_);
  }

  void AddWalls(int count, float size) {
    b2Body& ground = AddBody(b2_staticBody, {0.0f, 0.0f});
    for (int i = 0; i < count; ++i) {
      const b2Vec2 a{Random(-size, size), Random(-size, size)};
      b2EdgeShape edge;
      edge.SetTwoSided(a, a + b2Vec2{Random(-1, 1), Random(-1, 1)});
      ground.CreateFixture(&edge, 0.0f);
    }
  }

  b2Body& AddBody(b2BodyType type, b2Vec2 position) {
    b2BodyDef definition;
    definition.type = type;
    definition.position = position;
    return *world_.CreateBody(&definition);
  }

  /// Bodies of a disc and two boxes each, that drive about.
  void AddBodies(int count, float size) {
    for (int i = 0; i < count; ++i) {
      const b2BodyType type = i % 4 == 3 ? b2_kinematicBody : b2_dynamicBody;
      b2Body& body = AddBody(type, {Random(-size, size), Random(-size, size)});
      b2CircleShape disc;
      disc.m_radius = 0.2f;
      moving_.push_back(body.CreateFixture(&disc, 1.0f));
      for (const float x : {-0.3f, 0.3f}) {
        b2PolygonShape box;
        box.SetAsBox(0.1f, 0.2f, {x, 0.0f}, 0.0f);
        moving_.push_back(body.CreateFixture(&box, 1.0f));
      }
      bodies_.push_back(&body);
    }
  }

  /// Steps and jumps; after each, all nodes have to be those of the beginning.
  void DriveAbout(SharedTree& tree, std::vector<TreeChange>& changes, int steps, float size) {
    for (int step = 0; step < steps; ++step) {
      tree.Enter(changes);
      for (b2Body* body : bodies_) {
        if (Random(0, 1) < 0.1f) {
          body->SetLinearVelocity({Random(-8, 8), Random(-8, 8)});
          body->SetAngularVelocity(Random(-3, 3));
        }
        const b2Vec2 position = body->GetPosition();
        const bool is_outside = b2Max(b2Abs(position.x), b2Abs(position.y)) > size;
        if (is_outside || Random(0, 1) < 0.01f) {
          body->SetTransform({Random(-size, size), Random(-size, size)}, Random(-3, 3));
        }
      }
      world_.Step(0.05f, 4, 4);
      tree.Leave(changes);
      ASSERT_TRUE(IsBeginning()) << step;
    }
  }

  /// Free nodes have no content.
  void RememberNodes() {
    const b2TreeNode* const nodes = box2d::Nodes(world_);
    beginning_.assign(nodes, nodes + box2d::NodeCapacity(world_));
  }
  bool IsBeginning() {
    for (size_t i = 0; i < beginning_.size(); ++i) {
      const b2TreeNode& node = box2d::Nodes(world_)[i];
      if (node.height < 0 && beginning_[i].height < 0) continue;
      if (std::memcmp(&node, &beginning_[i], offsetof(b2TreeNode, moved)) != 0) return false;
      if (node.moved != beginning_[i].moved) return false;
    }
    return true;
  }

  b2World world_{b2Vec2_zero};
  std::vector<b2Fixture*> moving_;
  std::vector<b2Body*> bodies_;
  std::vector<b2TreeNode> beginning_;
  std::mt19937 engine_{1};
};

TEST_F(SharedTreeTest, FindsAllNodesThatStepsChange) {
  AddWalls(400, 8.0f);
  AddBodies(12, 8.0f);
  AddWalls(10, 8.0f);
  std::vector<TreeChange> changes;
  SharedTree tree(world_, moving_, changes);
  EXPECT_GE(changes.size(), 446u);  // Box2D is to look for contacts of all of them
  RememberNodes();
  DriveAbout(tree, changes, 1500, 8.0f);
  EXPECT_EQ(tree.comparisons(), 0);
}

TEST_F(SharedTreeTest, FindsThemInASmallTree) {
  AddBodies(1, 2.0f);
  std::vector<TreeChange> changes;
  SharedTree tree(world_, moving_, changes);
  RememberNodes();
  DriveAbout(tree, changes, 200, 2.0f);
  EXPECT_EQ(tree.comparisons(), 0);
}

TEST_F(SharedTreeTest, ComparesAllNodesIfSomethingElseHasMoved) {
  AddWalls(100, 4.0f);
  AddBodies(4, 4.0f);
  std::vector<TreeChange> changes;
  moving_.resize(3);
  SharedTree tree(world_, moving_, changes);
  RememberNodes();
  DriveAbout(tree, changes, 100, 4.0f);
  EXPECT_GT(tree.comparisons(), 0);
}

}  // namespace
}  // namespace flatland
