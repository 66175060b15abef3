#pragma once

/// Tells the processor to fetch memory, while it does something else. Environments are stepped one
/// after the other, and what each has for itself comes from a far cache; it takes long to wait for
/// it whenever it is used.

#include <cstddef>

namespace flatland {

/// Into the second-level cache: the first one can wait for few lines at a time.
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

/// The elements of an array.
template <class Array>
void PrefetchElements(const Array& array) {
  PrefetchBytes(array.data(), array.size() * sizeof(array[0]));
}

}  // namespace flatland
