/// PageCopy: a copy is restored to the image, whatever was written to it.

#include "../../src/core/page_copies.hpp"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstring>
#include <random>
#include <vector>

namespace flatland {
namespace {

constexpr size_t kPages = 60;
constexpr size_t kPage = 4096;
constexpr size_t kSize = kPages * kPage - 1000;  // the last page is not full

class PageCopiesTest : public testing::Test {
 protected:
  PageCopiesTest() : bytes_(kSize) {
    for (size_t i = 0; i < kSize; ++i) bytes_[i] = static_cast<char>(i * 31 + i / 997);
  }

  void Write(PageCopy& copy, int count) {
    for (int i = 0; i < count; ++i) ++static_cast<char*>(copy.data())[engine_() % kSize];
  }
  bool IsImage(const PageCopy& copy) const {
    return std::memcmp(copy.data(), bytes_.data(), kSize) == 0;
  }

  std::vector<char> bytes_;
  std::mt19937 engine_{1};
};

TEST_F(PageCopiesTest, RestoredCopiesAreTheImage) {
  const PageImage image(bytes_.data(), kSize);
  PageCopy copy(image), other(image);
  for (const int count : {1, 5, 10, 14, 20, 40, 200, 0, 3, 12, 300, 2}) {
    Write(copy, count);
    Write(other, 1);
    copy.Restore();
    ASSERT_TRUE(IsImage(copy)) << count;
    ASSERT_FALSE(IsImage(other));
  }
  other.Restore();
  EXPECT_TRUE(IsImage(other));
}

TEST_F(PageCopiesTest, AForkedProcessRestoresItsOwn) {
  const PageImage image(bytes_.data(), kSize);
  PageCopy copy(image);
  Write(copy, 3);
  copy.Restore();
  const pid_t child = fork();
  if (child == 0) {
    Write(copy, 30);
    copy.Restore();
    _exit(IsImage(copy) ? 0 : 1);
  }
  int status = -1;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  EXPECT_EQ(status, 0);
  EXPECT_TRUE(IsImage(copy));
}

}  // namespace
}  // namespace flatland
