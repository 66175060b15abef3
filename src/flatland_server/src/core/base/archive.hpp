#pragma once

/// Writes and reads values as bytes, for the state of a World.
///
/// One function lists the fields of an object for both directions: `archive(a, b, c)` appends them
/// to the bytes of a Writer, or sets them to the next bytes of a Reader. An object with a member
/// function template `Serialize(archive)` is a field like others. Numbers are stored as they are in
/// memory, so that they come back bit for bit; of a vector first the number of its elements.

#include <box2d/box2d.h>

#include <cmath>
#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "base/geometry.hpp"

namespace flatland {

template <class Value>
struct IsVector : std::false_type {};
template <class Item>
struct IsVector<std::vector<Item>> : std::true_type {};

/// Splits objects into numbers, which `Derived::Number` writes or reads.
template <class Derived>
class Archive {
 public:
  template <class... Values>
  void operator()(Values&... values) {
    (Field(values), ...);
  }

 private:
  Derived& self() { return static_cast<Derived&>(*this); }

  template <class Value>
  void Field(Value& value) {
    if constexpr (std::is_arithmetic_v<Value>) {
      self().Number(value);
    } else if constexpr (std::is_same_v<Value, Vec2> || std::is_same_v<Value, b2Vec2>) {
      (*this)(value.x, value.y);
    } else if constexpr (std::is_same_v<Value, Pose>) {
      (*this)(value.x, value.y, value.yaw);
    } else if constexpr (std::is_same_v<Value, Twist>) {
      (*this)(value.vx, value.vy, value.omega);
    } else if constexpr (IsVector<Value>::value) {
      auto count = static_cast<uint32_t>(value.size());
      Field(count);
      if constexpr (Derived::kIsReader) {
        if (count > self().remaining() / sizeof(uint32_t)) Derived::Fail();
        value.assign(count, {});
      }
      for (auto& each : value) Field(each);
    } else {
      value.Serialize(self());
    }
  }
};

class Writer : public Archive<Writer> {
 public:
  static constexpr bool kIsReader = false;

  template <class Value>
  void Number(Value& value) {
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  /// Writes a value. A Reader throws unless it finds the same one; `what` names it in the message.
  void Same(uint32_t value, const char*) { Number(value); }

  std::string bytes() && { return std::move(bytes_); }

 private:
  std::string bytes_;
};

/// Throws std::invalid_argument at the first value that is missing or that Box2D cannot compute
/// with.
class Reader : public Archive<Reader> {
 public:
  static constexpr bool kIsReader = true;

  explicit Reader(std::string_view bytes) : rest_(bytes) {}

  template <class Value>
  void Number(Value& value) {
    if (rest_.size() < sizeof value) throw std::invalid_argument("the state is incomplete");
    if constexpr (std::is_same_v<Value, bool>) {
      if (static_cast<unsigned char>(rest_[0]) > 1) Fail();
    }
    std::memcpy(&value, rest_.data(), sizeof value);
    if constexpr (std::is_floating_point_v<Value>) {
      if (!IsUsable(value)) Fail();
    }
    rest_.remove_prefix(sizeof value);
  }
  void Same(uint32_t expected, const char* what) {
    uint32_t found = 0;
    Number(found);
    if (found == expected) return;
    throw std::invalid_argument("the state is of another world: " + std::string(what) +
                                ": expected " + std::to_string(expected) + ", found " +
                                std::to_string(found));
  }
  size_t remaining() const { return rest_.size(); }
  [[noreturn]] static void Fail() { throw std::invalid_argument("the state is damaged"); }

 private:
  std::string_view rest_;
};

/// A checksum of bytes (FNV-1a, by G. Fowler, L. C. Noll and P. Vo).
inline uint64_t Checksum(std::string_view bytes) {
  uint64_t sum = 0xcbf29ce484222325;
  for (const char byte : bytes) sum = (sum ^ static_cast<unsigned char>(byte)) * 0x100000001b3;
  return sum;
}

}  // namespace flatland
