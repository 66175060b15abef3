#pragma once

/// Prefetches memory into the cache. A batch steps its environments one after the other, and the
/// state of each is only in a distant cache by then. Prefetching the next one meanwhile saves the
/// waiting.

#include <cstddef>

namespace flatland {

/// Prefetches into the second-level cache: the first level can wait for only a few lines at a time.
inline void PrefetchBytes(const void* begin, size_t size) {
  constexpr size_t kCacheLine = 64;
  constexpr int kToRead = 0, kSecondLevel = 2;
  const auto* const bytes = static_cast<const std::byte*>(begin);
  for (size_t i = 0; i < size; i += kCacheLine) {
    __builtin_prefetch(bytes + i, kToRead, kSecondLevel);
  }
  if (size > 0) __builtin_prefetch(bytes + size - 1, kToRead, kSecondLevel);
}

template <class T>
void PrefetchObject(const T& object) {
  PrefetchBytes(&object, sizeof object);
}

/// Prefetches the elements of an array.
template <class Array>
void PrefetchElements(const Array& array) {
  PrefetchBytes(array.data(), array.size() * sizeof(array[0]));
}

}  // namespace flatland
