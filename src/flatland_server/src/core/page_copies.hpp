#pragma once

/// Copies of a block of memory that share what has not been written to.
///
/// A copy is a private mapping of one file in memory: the processor's memory management copies a
/// page of 4 KiB when it is first written to. So a copy costs what it changes, and nothing has to
/// keep track of that. Without Linux, each copy is a whole one.
///
/// A page that is given back and written to again costs two calls of the kernel, 3 us; to write the
/// image's content to it, 0.15 us. So Restore keeps some of a copy's own pages. It learns from the
/// kernel which these are (/proc/self/pagemap); where that is not allowed, it gives back all.

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
  void* data_ = nullptr;          // the file, to read
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

  /// The number of its own pages that Restore keeps: those that were written to since the last
  /// Restore are preferred.
  static constexpr size_t kKeptPages = 12;

  void* data() const { return data_; }
  /// Makes it equal to the image again; its address stays.
  void Restore();

 private:
  const PageImage& image_;
  void* data_ = nullptr;
};

}  // namespace flatland
