// SPDX-License-Identifier: Apache-2.0
// Binary form of the values that the program and its worker process exchange (worker_request.h). Both processes run on
// one machine and belong to the same build, so the form has neither version nor byte order.
//
// A structure is packed field by field if a function fields_of(structure) returns a tuple of references to its fields.
#pragma once
#include <concepts>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <typeindex>
#include <utility>
#include <vector>

namespace simplexseg {

/// Thrown by unpack() when the bytes are not a value of the expected type, for example after a crash of the worker
/// process.
class BadPacking : public std::runtime_error {
 public:
  BadPacking() : std::runtime_error("the worker process sent invalid data") {}
};

/// Bytes of packed values.
class Packer {
 public:
  void add(const void* from, std::size_t count) { bytes_.append(static_cast<const char*>(from), count); }
  const std::string& bytes() const { return bytes_; }
  /// Returns true when the same shared object was the last one of its type passed to this function.
  template <class T>
  bool repeats(const T* shared) {
    return std::exchange(last_shared_[typeid(T)], shared) == shared;
  }

 private:
  std::string bytes_;
  std::map<std::type_index, const void*> last_shared_;
};

/// View of packed bytes, which must outlive it.
class Unpacker {
 public:
  explicit Unpacker(std::string_view bytes) : rest_(bytes) {}
  std::size_t left() const { return rest_.size(); }
  /// Returns the next `count` bytes. Throws BadPacking when fewer are left.
  std::string_view take(std::size_t count) {
    if (count > rest_.size()) throw BadPacking();
    const std::string_view taken = rest_.substr(0, count);
    rest_.remove_prefix(count);
    return taken;
  }
  std::map<std::type_index, std::shared_ptr<const void>> last_shared;  ///< last unpacked shared object of each type

 private:
  std::string_view rest_;
};

namespace packing {

template <class T>
inline constexpr bool is_vector = false;
template <class T>
inline constexpr bool is_vector<std::vector<T>> = true;
template <class T>
inline constexpr bool is_optional = false;
template <class T>
inline constexpr bool is_optional<std::optional<T>> = true;
template <class T>
inline constexpr bool is_shared = false;
template <class T>
inline constexpr bool is_shared<std::shared_ptr<const T>> = true;

template <class T>
concept Number = std::is_arithmetic_v<T> || std::is_enum_v<T>;
/// Matrix of Eigen with a fixed size.
template <class T>
concept Matrix = requires(T m) {
  { m.data()[0] } -> std::convertible_to<double>;
  requires int(T::SizeAtCompileTime) > 0;
};
template <class T>
concept Tuple = requires {
  std::tuple_size<T>::value;
};

enum SharedState : std::uint8_t { kNull, kRepeated, kNew };

}  // namespace packing

template <class T>
void pack(Packer& to, const T& value) {
  if constexpr (packing::Number<T>) {
    to.add(&value, sizeof value);
  } else if constexpr (std::is_same_v<T, std::string>) {
    pack(to, std::uint64_t(value.size()));
    to.add(value.data(), value.size());
  } else if constexpr (std::is_same_v<T, std::filesystem::path>) {
    pack(to, value.string());
  } else if constexpr (packing::is_optional<T>) {
    pack(to, value.has_value());
    if (value) pack(to, *value);
  } else if constexpr (packing::is_shared<T>) {
    const bool repeated = value && to.repeats(value.get());
    pack(to, !value ? packing::kNull : repeated ? packing::kRepeated : packing::kNew);
    if (value && !repeated) pack(to, *value);
  } else if constexpr (packing::is_vector<T>) {
    pack(to, std::uint64_t(value.size()));
    if constexpr (packing::Number<typename T::value_type>)
      to.add(value.data(), value.size() * sizeof(typename T::value_type));
    else
      for (const auto& one : value) pack(to, one);
  } else if constexpr (packing::Matrix<T>) {
    to.add(value.data(), sizeof(typename T::Scalar) * T::SizeAtCompileTime);
  } else if constexpr (packing::Tuple<T>) {
    std::apply([&](const auto&... fields) { (pack(to, fields), ...); }, value);
  } else {
    pack(to, fields_of(value));
  }
}

template <class T>
void unpack(Unpacker& from, T& value) {
  const auto fill = [&](void* to, std::size_t count) { from.take(count).copy(static_cast<char*>(to), count); };
  if constexpr (std::is_same_v<T, bool>) {
    const char byte = from.take(1)[0];
    if (byte != 0 && byte != 1) throw BadPacking();
    value = byte == 1;
  } else if constexpr (packing::Number<T>) {
    fill(&value, sizeof value);
  } else if constexpr (std::is_same_v<T, std::string>) {
    std::uint64_t count = 0;
    unpack(from, count);
    value = from.take(count);
  } else if constexpr (std::is_same_v<T, std::filesystem::path>) {
    std::string text;
    unpack(from, text);
    value = text;
  } else if constexpr (packing::is_optional<T>) {
    bool exists = false;
    unpack(from, exists);
    value.reset();
    if (exists) unpack(from, value.emplace());
  } else if constexpr (packing::is_shared<T>) {
    std::uint8_t state = 0;
    unpack(from, state);
    using Object = typename T::element_type;
    std::shared_ptr<const void>& last = from.last_shared[typeid(Object)];
    if (state > packing::kNew || (state == packing::kRepeated && !last)) throw BadPacking();
    if (state == packing::kNew) {
      auto object = std::make_shared<std::remove_const_t<Object>>();
      unpack(from, *object);
      last = std::move(object);
    }
    value = state == packing::kNull ? nullptr : std::static_pointer_cast<Object>(last);
  } else if constexpr (packing::is_vector<T>) {
    using Element = typename T::value_type;
    std::uint64_t count = 0;
    unpack(from, count);
    value.clear();
    if constexpr (packing::Number<Element>) {
      if (count > from.left() / sizeof(Element)) throw BadPacking();
      value.resize(count);
      fill(value.data(), count * sizeof(Element));
    } else {
      if (count > from.left()) throw BadPacking();  // each element has at least one byte
      for (std::uint64_t i = 0; i < count; ++i) unpack(from, value.emplace_back());
    }
  } else if constexpr (packing::Matrix<T>) {
    fill(value.data(), sizeof(typename T::Scalar) * T::SizeAtCompileTime);
  } else if constexpr (packing::Tuple<T>) {
    std::apply([&](auto&... fields) { (unpack(from, fields), ...); }, value);
  } else {
    auto fields = fields_of(value);
    unpack(from, fields);
  }
}

template <class T>
std::string packed(const T& value) {
  Packer to;
  pack(to, value);
  return to.bytes();
}

/// Unpacks a value that all bytes form. Throws BadPacking.
template <class T>
T unpacked(std::string_view bytes) {
  Unpacker from(bytes);
  T value{};
  unpack(from, value);
  if (from.left() > 0) throw BadPacking();
  return value;
}

}  // namespace simplexseg
