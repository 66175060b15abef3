#pragma once

/// Tells the processor to fetch memory, while it does something else. Environments are stepped one
/// after the other, and what each has for itself comes from a far cache; it takes long to wait for
/// it whenever it is used.

#include <cstddef>

namespace flatland {

inline void PrefetchBytes(const void* begin, size_t size) {
  constexpr size_t kCacheLine = 64;
  const auto* const bytes = static_cast<const std::byte*>(begin);
  for (size_t i = 0; i < size; i += kCacheLine) __builtin_prefetch(bytes + i);
  if (size > 0) __builtin_prefetch(bytes + size - 1);
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
