#pragma once

/// Copies of a block of memory that share what has not been written to.
///
/// A copy is a private mapping of one file in memory: the processor's memory management copies a
/// page of 4 KiB when it is first written to. So a copy costs what it changes, and nothing has to
/// keep track of that. Without Linux, each copy is a whole one.

#include <cstddef>
#include <vector>

namespace flatland {

/// The block that copies begin as.
class PageImage {
 public:
  /// Copies `size` bytes. Throws std::bad_alloc if the system refuses memory.
  PageImage(const void* data, size_t size);
  ~PageImage();
  PageImage(const PageImage&) = delete;
  PageImage& operator=(const PageImage&) = delete;

 private:
  friend class PageCopy;
  size_t size_;
  int file_ = -1;
  std::vector<std::byte> bytes_;  // without such files
};

/// A copy of an image, which must outlive it.
class PageCopy {
 public:
  /// Throws std::bad_alloc if the system refuses memory.
  explicit PageCopy(const PageImage& image);
  ~PageCopy();
  PageCopy(const PageCopy&) = delete;
  PageCopy& operator=(const PageCopy&) = delete;

  void* data() const { return data_; }
  /// Makes it equal to the image again; its address stays.
  void Restore();

 private:
  const PageImage& image_;
  void* data_ = nullptr;
};

}  // namespace flatland
