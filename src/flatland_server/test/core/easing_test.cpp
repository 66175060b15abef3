#include "motion/easing.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <set>
#include <string>
#include <vector>

namespace flatland {
namespace {

constexpr std::array<double, 6> kTimes = {0.1, 0.3, 0.45, 0.6, 0.8, 0.95};

struct Reference {
  std::string name;
  std::array<double, 6> values;  // at kTimes
};

// In the documentation's order. The values are those of the functions that R. Penner published,
// Math.easeInQuad to Math.easeInOutBounce (ActionScript, 2002), for b = 0, c = 1, d = 1, worked out
// apart from this program to 13 digits.
const std::vector<Reference> kReferences = {
    {"linear", {0.1, 0.3, 0.45, 0.6, 0.8, 0.95}},
    {"quadraticIn", {0.01, 0.09, 0.2025, 0.36, 0.64, 0.9025}},
    {"quadraticOut", {0.19, 0.51, 0.6975, 0.84, 0.96, 0.9975}},
    {"quadraticInOut", {0.02, 0.18, 0.405, 0.68, 0.92, 0.995}},
    {"cubicIn", {0.001, 0.027, 0.091125, 0.216, 0.512, 0.857375}},
    {"cubicOut", {0.271, 0.657, 0.833625, 0.936, 0.992, 0.999875}},
    {"cubicInOut", {0.004, 0.108, 0.3645, 0.744, 0.968, 0.9995}},
    {"quarticIn", {0.0001, 0.0081, 0.04100625, 0.1296, 0.4096, 0.81450625}},
    {"quarticOut", {0.3439, 0.7599, 0.90849375, 0.9744, 0.9984, 0.99999375}},
    {"quarticInOut", {0.0008, 0.0648, 0.32805, 0.7952, 0.9872, 0.99995}},
    {"quinticIn", {1e-05, 0.00243, 0.0184528125, 0.07776, 0.32768, 0.7737809375}},
    {"quinticOut", {0.40951, 0.83193, 0.9496715625, 0.98976, 0.99968, 0.9999996875}},
    {"quinticInOut", {0.00016, 0.03888, 0.295245, 0.83616, 0.99488, 0.999995}},
    {"exponentialIn", {0.001953125, 0.0078125, 0.02209708691208, 0.0625, 0.25, 0.7071067811865}},
    {"exponentialOut", {0.5, 0.875, 0.9558058261758, 0.984375, 0.99609375, 0.998618932068}},
    {"exponentialInOut", {0.001953125, 0.03125, 0.25, 0.875, 0.9921875, 0.9990234375}},
    {"circularIn",
     {0.00501256289338, 0.04606079858305, 0.1069714450254, 0.2, 0.4, 0.6877501000801}},
    {"circularOut",
     {0.4358898943541, 0.7141428428543, 0.8351646544245, 0.9165151389912, 0.9797958971133,
      0.9987492177719}},
    {"circularInOut",
     {0.01010205144336, 0.1, 0.282055052823, 0.8, 0.9582575694956, 0.9974937185533}},
    {"backIn", {-0.01431422, -0.08019954, -0.0983884725, -0.02902752, 0.29419776, 0.7805912025}},
    {"backOut", {0.40882798, 0.90713226, 1.0652525775, 1.09935168, 1.04645056, 1.0039162525}},
    {"backInOut",
     {-0.037518552, -0.078833484, 0.25940616525, 0.910074208, 1.092555656, 1.01117709275}},
    {"elasticIn", {0.001953125, -0.00390625, 0.01104854345604, -0.03125, -0.125, 0.3535533905933}},
    {"elasticOut", {1.25, 0.875, 1.044194173824, 0.984375, 1.001953125, 0.999309466034}},
    {"elasticInOut",
     {0.0003391565970057, 0.02393888884747, 0.04341204441673, 1.117461577598, 1.00390625,
      0.9990234375}},
    {"bounceIn", {0.011875, 0.069375, 0.24984375, 0.09, 0.6975, 0.98109375}},
    {"bounceOut", {0.075625, 0.680625, 0.81890625, 0.7725, 0.94, 0.98453125}},
    {"bounceInOut", {0.03, 0.045, 0.4621875, 0.65125, 0.88625, 0.9940625}},
};

TEST(FindEasing, KnowsTheDocumentedNamesInTheirOrder) {
  ASSERT_EQ(kReferences.size(), 28u);
  for (size_t i = 0; i < kReferences.size(); ++i) {
    EXPECT_EQ(FindEasing(kReferences[i].name), static_cast<Easing>(i)) << kReferences[i].name;
    EXPECT_EQ(kEasingNames.at(i), kReferences[i].name);
  }
  EXPECT_EQ(FindEasing("linear"), Easing::kLinear);
  EXPECT_EQ(FindEasing("elasticInOut"), Easing::kElasticInOut);
  EXPECT_EQ(FindEasing("bounceInOut"), Easing::kBounceInOut);
}

TEST(FindEasing, KnowsNoOthers) {
  for (const char* name : {"", "Linear", "cubic", "cubicInOu", "cubicInOut ", "sinusoidalIn"}) {
    EXPECT_FALSE(FindEasing(name)) << name;
  }
}

TEST(Ease, FollowsThePublishedFormulas) {
  for (const auto& [name, values] : kReferences) {
    for (size_t i = 0; i < kTimes.size(); ++i) {
      EXPECT_NEAR(Ease(*FindEasing(name), kTimes[i]), values[i], 1e-12)
          << name << " at " << kTimes[i];
    }
  }
}

TEST(Ease, StartsAtZeroAndEndsAtOneExactly) {
  for (const auto& [name, values] : kReferences) {
    const Easing easing = *FindEasing(name);

    EXPECT_EQ(Ease(easing, 0.0), 0.0) << name;
    EXPECT_EQ(Ease(easing, 1.0), 1.0) << name;
    EXPECT_EQ(Ease(easing, -0.1), 0.0) << name;
    EXPECT_EQ(Ease(easing, 1.1), 1.0) << name;
  }
}

// Only the exponential and elastic families jump, at their ends, by 2^-10 of the way at most.
TEST(Ease, HasNoJumps) {
  constexpr double kLittle = 1e-7;
  for (const auto& [name, values] : kReferences) {
    const Easing easing = *FindEasing(name);
    const bool jumps = name.find("exponential") == 0 || name.find("elastic") == 0;
    // Circular begins, or ends, as steeply as the root of the time.
    const double little_way = 2.0 * std::sqrt(kLittle);
    const double most = little_way + (jumps ? 1.0 / 1024.0 : 0.0);

    EXPECT_NEAR(Ease(easing, kLittle), 0.0, most) << name;
    EXPECT_NEAR(Ease(easing, 1.0 - kLittle), 1.0, most) << name;
    for (double seam : {0.5, 1.0 / 2.75, 2.0 / 2.75, 2.5 / 2.75}) {
      EXPECT_NEAR(Ease(easing, seam - kLittle), Ease(easing, seam + kLittle), little_way) << name;
      EXPECT_NEAR(Ease(easing, 1.0 - seam - kLittle), Ease(easing, 1.0 - seam + kLittle),
                  little_way)
          << name;
    }
  }
}

TEST(Ease, OutIsInBackwardsAndInOutIsSymmetric) {
  for (int family = 0; family < 9; ++family) {
    const auto in = static_cast<Easing>(1 + 3 * family);
    const auto out = static_cast<Easing>(2 + 3 * family);
    const auto in_out = static_cast<Easing>(3 + 3 * family);
    for (double t = 0.01; t < 1.0; t += 0.01) {
      EXPECT_NEAR(Ease(out, t), 1.0 - Ease(in, 1.0 - t), 1e-12) << family << " at " << t;
      EXPECT_NEAR(Ease(in_out, t), 1.0 - Ease(in_out, 1.0 - t), 1e-12) << family << " at " << t;
    }
    EXPECT_NEAR(Ease(in_out, 0.5), 0.5, 1e-12) << family;
  }
}

}  // namespace
}  // namespace flatland
