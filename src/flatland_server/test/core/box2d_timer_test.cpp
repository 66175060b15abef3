/// Box2D steps without reading the clock.

#include "world/box2d_timer.hpp"

#include <gtest/gtest.h>

namespace flatland {
namespace {

TEST(Box2DTimerTest, Box2DDoesNotReadTheClock) { EXPECT_FALSE(Box2DReadsClock()); }

}  // namespace
}  // namespace flatland
