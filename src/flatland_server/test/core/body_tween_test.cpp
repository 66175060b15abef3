#include "motion/body_tween.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

#include "test_bodies.hpp"
#include "test_numbers.hpp"

namespace flatland {
namespace {

// The documentation's: x += 2, y += 3, angle += 1.1.
constexpr Pose kStart{10.0, -20.0, 0.5};
constexpr Pose kDelta{2.0, 3.0, 1.1};
constexpr Pose kEnd{12.0, -17.0, 1.6};

BodyTween MakeTween(TweenMode mode, double duration, Easing easing = Easing::kLinear) {
  return BodyTween({kDelta, duration, mode, easing}, kStart);
}

// A tween of x alone, from 0 to 1.
BodyTween MakeUnitTween(TweenMode mode, double duration, Easing easing = Easing::kLinear) {
  return BodyTween({{1.0, 0.0, 0.0}, duration, mode, easing}, {});
}

// Durations, and steps of which a whole number makes them, and does not.
struct Pace {
  double duration;
  double dt;
  int steps;  // after which the duration is over
};
const std::vector<Pace> kPaces = {
    {1.0, 0.005, 200}, {1.0, 0.007, 143}, {0.7, 0.007, 100}, {10.0, 0.005, 2000},
    {0.3, 0.1, 3},     {1.1, 0.1, 11},    {2.1, 0.007, 300}, {1.0, 1.0 / 3.0, 3},
};

TEST(FindTweenMode, KnowsTheDocumentedNames) {
  EXPECT_EQ(FindTweenMode("yoyo"), TweenMode::kYoyo);
  EXPECT_EQ(FindTweenMode("once"), TweenMode::kOnce);
  EXPECT_EQ(FindTweenMode("loop"), TweenMode::kLoop);
  EXPECT_EQ(FindTweenMode("trigger"), TweenMode::kTrigger);
  EXPECT_FALSE(FindTweenMode(""));
  EXPECT_FALSE(FindTweenMode("Yoyo"));
}

TEST(BodyTween, RefusesWhatIsNotFiniteAndADurationOfNothing) {
  for (double bad : {kNaN, kInfinity, -kInfinity}) {
    EXPECT_THROW(BodyTween({{bad, 0.0, 0.0}}, {}), std::invalid_argument);
    EXPECT_THROW(BodyTween({{0.0, bad, 0.0}}, {}), std::invalid_argument);
    EXPECT_THROW(BodyTween({{0.0, 0.0, bad}}, {}), std::invalid_argument);
    EXPECT_THROW(BodyTween({}, {0.0, 0.0, bad}), std::invalid_argument);
    EXPECT_THROW(BodyTween({kDelta, bad}, {}), std::invalid_argument);
  }
  for (double bad : {0.0, -0.0, -1.0}) {
    EXPECT_THROW(BodyTween({kDelta, bad}, {}), std::invalid_argument);
  }
}

TEST(BodyTween, StandsAtItsStartBeforeTheFirstStep) {
  for (TweenMode mode :
       {TweenMode::kYoyo, TweenMode::kOnce, TweenMode::kLoop, TweenMode::kTrigger}) {
    const BodyTween tween = MakeTween(mode, 1.0, Easing::kExponentialIn);

    EXPECT_EQ(tween.target(), kStart);
    EXPECT_EQ(tween.progress(), 0.0);
    EXPECT_FALSE(tween.teleports());
  }
}

TEST(TweenOnce, IsAtItsTargetAtItsDurationExactlyAndStays) {
  for (const auto& [duration, dt, steps] : kPaces) {
    BodyTween tween = MakeTween(TweenMode::kOnce, duration, Easing::kElasticOut);

    for (int step = 1; step < steps; ++step) tween.Advance(dt);
    EXPECT_LT(tween.progress(), 1.0) << duration << " s by " << dt << " s";

    for (int step = 0; step < 100; ++step) {
      EXPECT_EQ(tween.Advance(dt), kEnd);
      ASSERT_EQ(tween.progress(), 1.0) << duration << " s by " << dt << " s";
    }
  }
}

TEST(TweenOnce, IsWhereTheFormulaSaysOnTheWay) {
  for (double dt : {0.005, 0.007}) {
    BodyTween tween = MakeTween(TweenMode::kOnce, 10.0, Easing::kQuarticInOut);

    for (int step = 1; step * dt < 10.0; ++step) {
      const double t = step * dt / 10.0;
      const double part = t < 0.5 ? 8.0 * std::pow(t, 4) : 1.0 - std::pow(2.0 - 2.0 * t, 4) / 2.0;
      SCOPED_TRACE(step);
      ExpectPose(tween.Advance(dt), {10 + 2 * part, -20 + 3 * part, 0.5 + 1.1 * part}, 1e-12);
    }
  }
}

TEST(TweenOnce, LosesNoTimeInRounding) {
  BodyTween tween = MakeUnitTween(TweenMode::kOnce, 3600.0);

  for (int step = 0; step < 1'000'000; ++step) tween.Advance(0.0035);

  EXPECT_NEAR(tween.target().x, 3500.0 / 3600.0, 1e-15);
}

TEST(TweenYoyo, TurnsAtItsTargetAndAtItsStartExactly) {
  for (const auto& [duration, dt, steps] : kPaces) {
    if (std::abs(steps * dt - duration) > 1e-12) continue;
    BodyTween tween = MakeTween(TweenMode::kYoyo, duration, Easing::kExponentialIn);

    for (int turn = 0; turn < 100; ++turn) {
      for (int step = 0; step < steps; ++step) tween.Advance(dt);
      EXPECT_EQ(tween.target(), turn % 2 == 0 ? kEnd : kStart);
      ASSERT_EQ(tween.progress(), turn % 2 == 0 ? 1.0 : 0.0) << turn;
    }
  }
}

TEST(TweenYoyo, ComesBackTheWayItWent) {
  BodyTween tween = MakeTween(TweenMode::kYoyo, 1.0, Easing::kBounceOut);

  std::vector<Pose> there;
  for (int step = 0; step < 200; ++step) there.push_back(tween.Advance(0.005));
  for (int step = 1; step < 200; ++step) {
    ExpectPose(tween.Advance(0.005), there[199 - step], 1e-12);
  }
}

TEST(TweenYoyo, IsATriangleWaveForHours) {
  for (const auto& [duration, dt, steps] : kPaces) {
    BodyTween tween = MakeUnitTween(TweenMode::kYoyo, duration);

    for (int step = 1; step <= 1'000'000; ++step) {
      tween.Advance(dt);
      if (step % 997 != 0 && step < 999'000) continue;
      const double turns = step * dt / (2.0 * duration);
      const double wave = 2.0 * std::abs(turns - std::round(turns));
      ASSERT_NEAR(tween.target().x, wave, 1e-9) << duration << " s, step " << step << " of " << dt;
      ASSERT_FALSE(tween.teleports());
    }
  }
}

TEST(TweenLoop, IsAtItsEndAtEveryDurationAndThenStartsAgain) {
  for (const auto& [duration, dt, steps] : kPaces) {
    if (std::abs(steps * dt - duration) > 1e-12) continue;
    BodyTween tween = MakeUnitTween(TweenMode::kLoop, duration);

    for (int loop = 0; loop < 1000; ++loop) {
      for (int step = 1; step <= steps; ++step) {
        const double x = tween.Advance(dt).x;
        ASSERT_NEAR(x, step * dt / duration, 1e-9) << "loop " << loop << " step " << step;
        ASSERT_EQ(tween.teleports(), loop > 0 && step == 1) << "loop " << loop << " step " << step;
      }
      ASSERT_EQ(tween.target().x, 1.0) << loop;
      ASSERT_EQ(tween.progress(), 1.0) << loop;
    }
  }
}

TEST(TweenLoop, StartsAgainInTheMiddleOfAStep) {
  BodyTween tween = MakeUnitTween(TweenMode::kLoop, 1.0);

  int teleports = 0;
  for (int step = 1; step <= 1'000'000; ++step) {
    const double before = tween.target().x;
    const double x = tween.Advance(0.007).x;
    const long long milliseconds = 7LL * step;
    const double expected = static_cast<double>((milliseconds - 1) % 1000 + 1) / 1000.0;
    ASSERT_NEAR(x, expected, 1e-9) << step;
    ASSERT_EQ(tween.teleports(), x < before) << step;
    teleports += tween.teleports() ? 1 : 0;
  }

  EXPECT_EQ(teleports, 6999);  // 7000 s; at the end of the last one it has not jumped yet
}

TEST(TweenTrigger, GoesToItsTargetAndBackInADurationEach) {
  for (const auto& [duration, dt, steps] : kPaces) {
    BodyTween tween = MakeTween(TweenMode::kTrigger, duration, Easing::kExponentialInOut);

    for (int round = 0; round < 10; ++round) {
      for (bool forward : {true, false}) {
        tween.Trigger(forward);
        for (int step = 1; step < steps; ++step) tween.Advance(dt);
        EXPECT_NE(tween.progress(), forward ? 1.0 : 0.0) << duration << " s by " << dt << " s";
        for (int step = 0; step < 10; ++step) {
          EXPECT_EQ(tween.Advance(dt), forward ? kEnd : kStart);
          EXPECT_FALSE(tween.teleports());
        }
      }
    }
  }
}

TEST(TweenTrigger, TurnsRoundOnItsWay) {
  BodyTween tween = MakeUnitTween(TweenMode::kTrigger, 1.0, Easing::kQuadraticIn);

  tween.Trigger(true);
  for (int step = 0; step < 120; ++step) tween.Advance(0.005);
  EXPECT_NEAR(tween.target().x, 0.36, 1e-12);

  tween.Trigger(false);
  for (int step = 0; step < 40; ++step) tween.Advance(0.005);
  EXPECT_NEAR(tween.target().x, 0.16, 1e-12);
  EXPECT_NEAR(tween.progress(), 0.4, 1e-12);

  tween.Trigger(true);
  for (int step = 0; step < 20; ++step) tween.Advance(0.005);
  EXPECT_NEAR(tween.target().x, 0.25, 1e-12);
}

TEST(TweenTrigger, HasNoEffectInOtherModes) {
  for (TweenMode mode : {TweenMode::kYoyo, TweenMode::kOnce, TweenMode::kLoop}) {
    BodyTween triggered = MakeUnitTween(mode, 1.0);
    BodyTween other = MakeUnitTween(mode, 1.0);
    for (int step = 0; step < 500; ++step) {
      triggered.Trigger(step % 3 == 0);
      EXPECT_EQ(triggered.Advance(0.007).x, other.Advance(0.007).x);
    }
  }
}

TEST(LongStep, EndsWhereSmallOnesWouldHave) {
  const double duration = 0.01;

  EXPECT_EQ(MakeUnitTween(TweenMode::kOnce, duration).Advance(1.0).x, 1.0);
  EXPECT_NEAR(MakeUnitTween(TweenMode::kYoyo, duration).Advance(0.013).x, 0.7, 1e-9);
  EXPECT_NEAR(MakeUnitTween(TweenMode::kYoyo, duration).Advance(0.024).x, 0.4, 1e-9);
  EXPECT_EQ(MakeUnitTween(TweenMode::kYoyo, duration).Advance(0.03).x, 1.0);
  EXPECT_EQ(MakeUnitTween(TweenMode::kYoyo, duration).Advance(0.04).x, 0.0);

  BodyTween loop = MakeUnitTween(TweenMode::kLoop, duration);
  EXPECT_NEAR(loop.Advance(0.023).x, 0.3, 1e-9);
  EXPECT_TRUE(loop.teleports());
  EXPECT_EQ(loop.Advance(0.027).x, 1.0);  // 5 durations
  EXPECT_TRUE(loop.teleports());
  EXPECT_NEAR(loop.Advance(0.001).x, 0.1, 1e-9);
  EXPECT_TRUE(loop.teleports());
  EXPECT_NEAR(loop.Advance(0.001).x, 0.2, 1e-9);
  EXPECT_FALSE(loop.teleports());

  for (int loops = 2; loops < 100; ++loops) {
    EXPECT_EQ(MakeUnitTween(TweenMode::kLoop, 0.25).Advance(0.25 * loops).x, 1.0) << loops;
    EXPECT_EQ(MakeUnitTween(TweenMode::kLoop, 0.7).Advance(0.7 * loops).x, 1.0) << loops;
  }

  BodyTween trigger = MakeUnitTween(TweenMode::kTrigger, duration);
  trigger.Trigger(true);
  EXPECT_EQ(trigger.Advance(1.0).x, 1.0);
  trigger.Trigger(false);
  EXPECT_EQ(trigger.Advance(1.0).x, 0.0);
}

TEST(LongStep, IsAnyBesideTheShortestDuration) {
  const double shortest = std::numeric_limits<double>::denorm_min();

  EXPECT_EQ(MakeUnitTween(TweenMode::kOnce, shortest).Advance(0.005).x, 1.0);
  for (TweenMode mode : {TweenMode::kYoyo, TweenMode::kLoop}) {
    BodyTween tween = MakeUnitTween(mode, shortest);
    for (int step = 0; step < 10; ++step) {
      const double x = tween.Advance(0.005).x;
      EXPECT_TRUE(x >= 0.0 && x <= 1.0);
    }
  }
}

TEST(Rebase, GoesOnFromWhereTheBodyWasPut) {
  BodyTween tween = MakeTween(TweenMode::kYoyo, 1.0);
  for (int step = 0; step < 50; ++step) tween.Advance(0.005);

  tween.Rebase({-1.0, 5.0, 3.0});

  ExpectPose(tween.target(), {-1.0, 5.0, 3.0}, 1e-12);
  EXPECT_DOUBLE_EQ(tween.progress(), 0.25);
  // The other three quarters of the way, and all of it back.
  for (int step = 0; step < 150; ++step) tween.Advance(0.005);
  ExpectPose(tween.target(), {0.5, 7.25, 3.825}, 1e-12);
  for (int step = 0; step < 200; ++step) tween.Advance(0.005);
  ExpectPose(tween.target(), {-1.5, 4.25, 2.725}, 1e-12);
}

TEST(Rebase, LeavesABodyThatHasArrivedWhereItWasPut) {
  BodyTween tween = MakeTween(TweenMode::kOnce, 1.0);
  for (int step = 0; step < 300; ++step) tween.Advance(0.005);

  tween.Rebase({1.0, 2.0, 3.0});

  for (int step = 0; step < 300; ++step) ExpectPose(tween.Advance(0.005), {1.0, 2.0, 3.0}, 1e-12);
}

}  // namespace
}  // namespace flatland
