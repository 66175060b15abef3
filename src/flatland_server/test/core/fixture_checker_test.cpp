/// FixtureChecker refuses the same fixtures as a body of a world, for the same reasons.

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "test_bodies.hpp"
#include "test_numbers.hpp"
#include "world/fixture.hpp"
#include "world/world.hpp"

namespace flatland {
namespace {

// The message of the std::invalid_argument that the call throws; empty if it throws nothing.
std::string Message(const std::function<void()>& call) {
  try {
    call();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

// A body of a world and a checker, which get the same fixtures.
class Twins {
 public:
  explicit Twins(b2BodyType type) : body_(world_.AddBody(At({0, 0, 0}, type))), checker_(type) {}

  // Returns the message of both, and expects that it is the same.
  std::string AddCircle(Vec2 center, double radius, const FixtureSettings& settings) {
    return Compare([&] { world_.AddCircle(body_, center, radius, settings); },
                   [&] { checker_.AddCircle(center, radius, settings); });
  }
  std::string AddPolygon(const std::vector<Vec2>& vertices, const FixtureSettings& settings) {
    return Compare([&] { world_.AddPolygon(body_, vertices, settings); },
                   [&] { checker_.AddPolygon(vertices, settings); });
  }

 private:
  static std::string Compare(const std::function<void()>& to_body,
                             const std::function<void()>& to_checker) {
    const std::string message = Message(to_body);
    EXPECT_EQ(Message(to_checker), message);
    return message;
  }

  World world_{10, 10};
  World::Body body_;
  FixtureChecker checker_;
};

constexpr char kTooSmall[] = "a footprint is too small for its distance from the body's origin";

TEST(FixtureChecker, RefusesWhatABodyRefuses) {
  Twins twins(b2_dynamicBody);
  FixtureSettings dense = Solid(), rough = Solid(), bouncy = Solid();
  dense.density = 1e39;
  rough.friction = -1.0;
  bouncy.restitution = kNaN;

  EXPECT_NE(twins.AddCircle({0, kNaN}, 1.0, Solid()), "");
  EXPECT_NE(twins.AddCircle({0, 0}, 0.0, Solid()), "");
  EXPECT_NE(twins.AddCircle({0, 0}, 1e6, Solid()), "");
  EXPECT_NE(twins.AddPolygon({{0, 0}, {1, 0}}, Solid()), "");
  EXPECT_NE(twins.AddPolygon({{0, 0}, {1, 0}, {2e5, 1}}, Solid()), "");
  EXPECT_NE(twins.AddPolygon({{0, 0}, {1, 1}, {2, 2}}, Solid()), "");
  EXPECT_NE(twins.AddPolygon(Square(1), dense), "");
  EXPECT_NE(twins.AddPolygon(Square(1), rough), "");
  EXPECT_NE(twins.AddPolygon(Square(1), bouncy), "");
  EXPECT_EQ(twins.AddPolygon(Square(1), Solid()), "");
  EXPECT_EQ(twins.AddCircle({0, 0}, 1.0, Solid()), "");
}

TEST(FixtureChecker, RefusesATinyFixtureFarFromTheOriginOfADynamicBody) {
  for (const b2BodyType type : {b2_staticBody, b2_kinematicBody, b2_dynamicBody}) {
    Twins twins(type);

    EXPECT_EQ(twins.AddCircle({1000, 0}, 0.001, {}), "") << "without a density";
    EXPECT_EQ(twins.AddCircle({1000, 0}, 0.001, Solid()), type == b2_dynamicBody ? kTooSmall : "");
  }
}

// The moment of inertia is that of all fixtures together.
TEST(FixtureChecker, TakesTheFixturesBeforeIntoAccount) {
  Twins twins(b2_dynamicBody);

  EXPECT_EQ(twins.AddCircle({1000, 0}, 0.001, Solid()), kTooSmall);
  EXPECT_EQ(twins.AddPolygon(Square(1), Solid()), "");
  EXPECT_EQ(twins.AddCircle({1000, 0}, 0.001, Solid()), "");
}

TEST(FixtureChecker, ForgetsWhatItRefused) {
  Twins twins(b2_dynamicBody);
  FixtureSettings rough = Solid();
  rough.friction = -1.0;

  EXPECT_NE(twins.AddPolygon(Square(1), rough), "");
  EXPECT_EQ(twins.AddCircle({1000, 0}, 0.001, Solid()), kTooSmall);
}

// Near the limit rounding errors decide: the sums must be the same to the last bit.
TEST(FixtureChecker, AgreesWithABodyOnFixturesNearTheLimit) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> exponent(0.0, 1.0);
  int refused = 0, accepted = 0;
  for (int i = 0; i < 300; ++i) {
    Twins twins(b2_dynamicBody);
    for (int k = 0; k < 5; ++k) {
      const double radius = std::pow(10.0, exponent(random) - 3.0);
      const Vec2 center{std::pow(10.0, 2.0 * exponent(random)), 5.0 * exponent(random)};
      (twins.AddCircle(center, radius, Dense(std::pow(10.0, 4.0 * exponent(random) - 2.0))).empty()
           ? accepted
           : refused) += 1;
    }
  }
  EXPECT_GT(refused, 100);
  EXPECT_GT(accepted, 100);
}

}  // namespace
}  // namespace flatland
