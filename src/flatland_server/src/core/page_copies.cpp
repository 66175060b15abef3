#include "page_copies.hpp"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <new>
#include <vector>

#ifdef __linux__
#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>
#endif

namespace flatland {

#ifdef __linux__

namespace {

const size_t kPage = static_cast<size_t>(sysconf(_SC_PAGESIZE));

void* Map(int file, size_t size, int protection) {
  void* data = mmap(nullptr, size, protection, MAP_PRIVATE, file, 0);
  if (data == MAP_FAILED) throw std::bad_alloc();
  return data;
}

/// What the kernel tells about the pages of this process (Linux, admin-guide/mm/pagemap).
class PageMap {
 public:
  /// Reads an entry for each page of a block; false if the kernel does not tell.
  static bool Read(const void* data, size_t count, uint64_t* entries) {
    thread_local PageMap map;
    if (map.process_ != getpid()) map.Open();
    const auto first = reinterpret_cast<uintptr_t>(data) / kPage;
    const size_t size = count * sizeof(uint64_t);
    return map.file_ >= 0 &&
           pread(map.file_, entries, size, static_cast<off_t>(first * sizeof(uint64_t))) ==
               static_cast<ssize_t>(size);
  }
  /// Whether a page of a private mapping of a file is no longer that of the file.
  static bool IsOwn(uint64_t entry) {
    constexpr uint64_t kPresent = uint64_t{1} << 63, kSwapped = uint64_t{1} << 62;
    constexpr uint64_t kOfFile = uint64_t{1} << 61;
    return (entry & kSwapped) != 0 || ((entry & kPresent) != 0 && (entry & kOfFile) == 0);
  }

 private:
  PageMap() = default;
  ~PageMap() { Close(); }
  /// A forked child process needs its own: the parent's is about the parent's pages.
  void Open() {
    Close();
    file_ = open("/proc/self/pagemap", O_RDONLY | O_CLOEXEC);
    process_ = getpid();
  }
  void Close() const {
    if (file_ >= 0) close(file_);
  }

  int file_ = -1;
  pid_t process_ = -1;
};

}  // namespace

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
  try {
    data_ = Map(file_, size, PROT_READ);
  } catch (...) {
    close(file_);
    throw;
  }
}

PageImage::~PageImage() {
  munmap(data_, size_);
  close(file_);
}

PageCopy::PageCopy(const PageImage& image)
    : image_(image), data_(Map(image.file_, image.size_, PROT_READ | PROT_WRITE)) {}

PageCopy::~PageCopy() { munmap(data_, image_.size_); }

// A page that is given back is that of the file when it is next read.
void PageCopy::Restore() {
  thread_local std::vector<uint64_t> entries;
  entries.resize((image_.size_ + kPage - 1) / kPage);
  if (!PageMap::Read(data_, entries.size(), entries.data())) {
    madvise(data_, image_.size_, MADV_DONTNEED);
    return;
  }
  const auto own =
      static_cast<size_t>(std::count_if(entries.begin(), entries.end(), PageMap::IsOwn));
  size_t kept = 0;
  for (size_t i = 0; i < entries.size(); ++i) {
    if (!PageMap::IsOwn(entries[i])) continue;
    std::byte* const page = static_cast<std::byte*>(data_) + i * kPage;
    const std::byte* const original = static_cast<const std::byte*>(image_.data_) + i * kPage;
    const size_t size = std::min(kPage, image_.size_ - i * kPage);
    const bool is_changed = std::memcmp(page, original, size) != 0;
    if (kept < kKeptPages && (is_changed || own <= kKeptPages)) {
      if (is_changed) std::memcpy(page, original, size);
      ++kept;
    } else {
      madvise(page, kPage, MADV_DONTNEED);
    }
  }
}

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
