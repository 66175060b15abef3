#include "page_copies.hpp"

#include <cstring>
#include <new>

#ifdef __linux__
#include <sys/mman.h>
#include <unistd.h>
#endif

namespace flatland {

#ifdef __linux__

PageImage::PageImage(const void* data, size_t size) : size_(size) {
  file_ = memfd_create("flatland", MFD_CLOEXEC);
  const auto* bytes = static_cast<const std::byte*>(data);
  for (size_t written = 0; written < size;) {
    const ssize_t count = file_ < 0 ? -1 : write(file_, bytes + written, size - written);
    if (count <= 0) {
      if (file_ >= 0) close(file_);
      throw std::bad_alloc();
    }
    written += static_cast<size_t>(count);
  }
}

PageImage::~PageImage() { close(file_); }

PageCopy::PageCopy(const PageImage& image) : image_(image) {
  data_ = mmap(nullptr, image.size_, PROT_READ | PROT_WRITE, MAP_PRIVATE, image.file_, 0);
  if (data_ == MAP_FAILED) throw std::bad_alloc();
}

PageCopy::~PageCopy() { munmap(data_, image_.size_); }

// Drops the pages that were written to: the next access finds those of the file.
void PageCopy::Restore() { madvise(data_, image_.size_, MADV_DONTNEED); }

#else

PageImage::PageImage(const void* data, size_t size)
    : size_(size),
      bytes_(static_cast<const std::byte*>(data), static_cast<const std::byte*>(data) + size) {}

PageImage::~PageImage() = default;

PageCopy::PageCopy(const PageImage& image) : image_(image), data_(::operator new(image.size_)) {
  Restore();
}

PageCopy::~PageCopy() { ::operator delete(data_); }

void PageCopy::Restore() { std::memcpy(data_, image_.bytes_.data(), image_.size_); }

#endif

}  // namespace flatland
