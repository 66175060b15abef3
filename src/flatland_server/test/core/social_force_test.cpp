/// The social force model: each term against its formula.

#include "people/social_force.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <cstdint>
#include <random>
#include <vector>

namespace flatland {
namespace {

using Complex = std::complex<double>;

constexpr double kA = 25.0, kB = 0.08, kTau = 0.5;  // 2000 N on 80 kg: Helbing et al., 2000

Complex ToComplex(Vec2 v) { return {v.x, v.y}; }

Obstacle ObstacleAt(double gap, double bearing) {
  return {gap, {-std::cos(bearing), -std::sin(bearing)}};
}

TEST(SocialForceTest, RelaxesWithinTheRelaxationTime) {
  for (const double dt : {0.005, 0.05, 0.3}) {
    Vec2 velocity;
    for (int update = 1; update < 20; ++update) {
      velocity = SocialForce().Relax(velocity, {0.8, -1.0}, {}, SocialForce().LeftAfter(dt));
      const double reached = 1.0 - std::exp(-update * dt / kTau);
      EXPECT_NEAR(velocity.x, 0.8 * reached, 1e-12);
      EXPECT_NEAR(velocity.y, -1.0 * reached, 1e-12);
    }
  }
}

TEST(SocialForceTest, SettlesWhereBothForcesAreEqual) {
  const double left = SocialForce().LeftAfter(20.0);
  const Vec2 settled = SocialForce().Relax({1.0, 2.0}, {1.0, 0.0}, {-1.5, 0.4}, left);
  EXPECT_NEAR(settled.x, 1.0 - 1.5 * kTau, 1e-9);
  EXPECT_NEAR(settled.y, 0.4 * kTau, 1e-9);
}

TEST(SocialForceTest, RepelsExponentially) {
  for (const double gap : {0.0, 0.05, 0.2, 0.5}) {
    const Complex push = ToComplex(SocialForce().Repel(ObstacleAt(gap, 0.7)));
    EXPECT_NEAR(std::abs(push + std::polar(kA * std::exp(-gap / kB), 0.7)), 0.0, 1e-9);
  }
}

TEST(SocialForceTest, RepelsWhatOverlapsAsByATouch) {
  EXPECT_NEAR(SocialForce().Repel(ObstacleAt(-0.3, M_PI)).x, kA, 1e-9);
}

/// The formula of Moussaid et al., 2009, in the complex plane: see SocialForce::Evade.
Complex Evasion(double gap, double bearing, Complex velocity, double epsilon) {
  const Complex direction = std::polar(1.0, bearing);
  const Complex interaction = 2.0 * velocity + direction;
  const double reach = 0.35 * std::abs(interaction);
  const double theta = std::arg(direction / interaction) + epsilon * reach;
  const double slower = std::exp(-std::pow(3.0 * reach * theta, 2));
  const double aside = std::copysign(std::exp(-std::pow(2.0 * reach * theta, 2)), theta);
  return -4.5 * std::exp(-gap / reach) * Complex(slower, aside) * interaction /
         std::abs(interaction);
}

TEST(SocialForceTest, EvadesAsItWasMeasured) {
  for (const double epsilon : {0.005, -0.005}) {
    SocialForce force;
    force.side_preference = epsilon;
    for (const double gap : {0.0, 0.5, 3.0}) {
      for (const double bearing : {0.0, 0.3, -0.3, 2.0, M_PI}) {
        for (const Complex velocity : {Complex(1.3), Complex(2.6, 0.2), Complex(-0.5, 1.0)}) {
          const Vec2 found =
              force.Evade(ObstacleAt(gap, bearing), {velocity.real(), velocity.imag()});
          const Complex expected = Evasion(gap, bearing, velocity, epsilon);
          EXPECT_NEAR(std::abs(ToComplex(found) - expected), 0.0, 2e-6);
        }
      }
    }
  }
}

TEST(SocialForceTest, EvadesToThePreferredSide) {
  SocialForce force;
  EXPECT_LT(force.Evade(ObstacleAt(1.0, 0.0), {1.3, 0.0}).y, -1.0);
  force.side_preference = -force.side_preference;
  EXPECT_GT(force.Evade(ObstacleAt(1.0, 0.0), {1.3, 0.0}).y, 1.0);
}

/// Two people avoid each other with opposite forces, which Crowd relies on.
TEST(SocialForceTest, IsOppositeForTheOtherPerson) {
  for (const double bearing : {0.0, 0.4, -2.9, 1.7}) {
    const Obstacle one = ObstacleAt(0.4, bearing);
    const Obstacle other{0.4, {-one.away.x, -one.away.y}};
    for (const Vec2 velocity : {Vec2{1.3, 0.1}, Vec2{-0.2, 0.9}, Vec2{}}) {
      const Vec2 a = SocialForce().Evade(one, velocity);
      const Vec2 b = SocialForce().Evade(other, {-velocity.x, -velocity.y});
      EXPECT_EQ(a.x, -b.x);
      EXPECT_EQ(a.y, -b.y);
    }
  }
}

TEST(SocialForceTest, FindsAllBetweenWhomThereAreForces) {
  std::mt19937 engine(1);
  const auto draw = [&](double most) {
    return std::uniform_real_distribution<double>(-most, most)(engine);
  };
  for (const double range : {0.08, 1e-12, 0.5}) {
    SocialForce force;
    force.range = range;
    Walkers people;
    people.Resize(203);
    for (size_t i = 0; i < people.count; ++i) {
      people.Set(i, {draw(15.0), draw(15.0)}, {draw(1.0), draw(1.0)}, 0.3 + draw(0.2));
    }
    people.Set(100, {people.x[50], people.y[50]}, {}, 0.2);
    size_t count = 0, in_vain = 0;
    std::vector<uint32_t> near;
    for (size_t i = 0; i < people.count; ++i) {
      force.FindNear(people, i, near);
      auto next = near.begin();
      for (size_t j = i + 1; j < people.count; ++j) {
        const Vec2 away{people.x[i] - people.x[j], people.y[i] - people.y[j]};
        const double distance = LengthOf(away);
        const Obstacle other{distance - people.radius[i] - people.radius[j],
                             distance > 0.0 ? (1.0 / distance) * away : away};
        const Vec2 velocity{people.vx[i] - people.vx[j], people.vy[i] - people.vy[j]};
        const Vec2 push = force.Repel(other), evasion = force.Evade(other, velocity);
        const bool is_forced =
            push.x != 0.0 || push.y != 0.0 || evasion.x != 0.0 || evasion.y != 0.0;
        const bool is_near = next != near.end() && *next == j;
        ASSERT_TRUE(is_near || !is_forced) << i << " " << j;
        if (is_near) ++next;
        count += is_forced;
        in_vain += is_near && !is_forced;
      }
      ASSERT_EQ(next, near.end());
    }
    EXPECT_GT(count, 1000u);
    EXPECT_LT(in_vain, 10u);
  }
}

TEST(SocialForceTest, ScattersAsAStationaryProcess) {
  SocialForce force;
  force.noise = 0.1;
  for (const double dt : {0.01, 0.2}) {
    double variance = 0.0;
    for (int i = 0; i < 2000; ++i) {
      const double kept = force.Relax({1.0, 0.0}, {}, {}, force.LeftAfter(dt)).x;
      variance = kept * kept * variance + std::pow(force.ScatterAfter(dt), 2);
    }
    EXPECT_NEAR(variance, 0.01, 1e-9);
  }
}

}  // namespace
}  // namespace flatland
