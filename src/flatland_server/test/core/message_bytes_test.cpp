#include "sending/message_bytes.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <stdexcept>
#include <string>
#include <vector>

namespace flatland {
namespace {

template <class Number>
std::vector<Number> NumbersAt(const std::string& data, std::size_t at, std::size_t count) {
  std::vector<Number> numbers(count);
  std::memcpy(numbers.data(), data.data() + at, count * sizeof(Number));
  return numbers;
}

TEST(MessageBytes, OnlyFieldsChange) {
  MessageBytes message(std::string(200, 'x'));

  message.SetHeader(1, 7, 3'000'000'005);
  message.SetPose(20, {1.5, -2.5, 0.7});
  message.SetTwist(100, {0.25, 0.5, -3.0});

  const std::string& data = message.data();
  EXPECT_EQ(NumbersAt<uint32_t>(data, 1, 3), (std::vector<uint32_t>{7, 3, 5}));
  EXPECT_EQ(NumbersAt<double>(data, 20, 7),
            (std::vector<double>{1.5, -2.5, 0.0, 0.0, 0.0, std::sin(0.35), std::cos(0.35)}));
  EXPECT_EQ(NumbersAt<double>(data, 100, 6), (std::vector<double>{0.25, 0.5, 0.0, 0.0, 0.0, -3.0}));
  std::string rest = data;
  rest.replace(100, 48, "").replace(20, 56, "").replace(1, 12, "");
  EXPECT_EQ(rest, std::string(200 - 48 - 56 - 12, 'x'));
}

TEST(MessageBytes, ATwistIsTurnedIntoTheFrameOfTheYaw) {
  MessageBytes message(std::string(48, '\0'));

  message.SetTurnedTwist(0, {2.0, 1.0, 0.5}, M_PI / 2);

  const std::vector<double> numbers = NumbersAt<double>(message.data(), 0, 6);
  EXPECT_NEAR(numbers[0], -1.0, 1e-12);
  EXPECT_NEAR(numbers[1], 2.0, 1e-12);
  EXPECT_EQ(numbers[5], 0.5);
}

TEST(MessageBytes, FieldsBeyondTheEndAreRefused) {
  MessageBytes message(std::string(56, 'x'));

  EXPECT_THROW(message.SetPose(1, {}), std::out_of_range);
  EXPECT_THROW(message.SetTwist(9, {}), std::out_of_range);
  EXPECT_THROW(message.SetHeader(static_cast<std::size_t>(-4), 0, 0), std::out_of_range);
  EXPECT_EQ(message.data(), std::string(56, 'x'));
}

}  // namespace
}  // namespace flatland
