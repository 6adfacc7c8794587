// Values as bytes and back, for messages between two processes of one program: no versions, no byte order.
// A struct lists its fields once, for both ways: template <class Bytes> void fields(Bytes& b) { b(x, y, z); }
#pragma once

#include <cstddef>
#include <cstring>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

namespace turner::watch {

// Appends values.
class ByteWriter {
 public:
  std::string bytes;

  template <class... Values>
  void operator()(const Values&... values) {
    (put(values), ...);
  }

 private:
  template <class Value>
  void put(const Value& value) {
    if constexpr (std::is_trivially_copyable_v<Value>)
      bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
    else
      const_cast<Value&>(value).fields(*this);  // which only reads here
  }
  void put(const std::string& text) { putElements(text); }
  template <class Value>
  void put(const std::vector<Value>& values) {
    putElements(values);
  }
  template <class Value>
  void put(const std::optional<Value>& value) {
    put(value.has_value());
    if (value) put(*value);
  }
  template <class List>
  void putElements(const List& list) {
    using Element = typename List::value_type;
    put(list.size());
    if constexpr (std::is_trivially_copyable_v<Element>)
      bytes.append(reinterpret_cast<const char*>(list.data()), list.size() * sizeof(Element));
    else
      for (const Element& element : list) put(element);
  }
};

// Takes them in the same order. Throws std::length_error where the bytes end too early.
class ByteReader {
 public:
  explicit ByteReader(std::string_view bytes) : rest_(bytes) {}

  template <class... Values>
  void operator()(Values&... values) {
    (take(values), ...);
  }

 private:
  void takeBytes(void* target, size_t size) {
    if (size > rest_.size()) throw std::length_error("a message ends too early");
    if (size > 0) std::memcpy(target, rest_.data(), size);
    rest_.remove_prefix(size);
  }
  template <class Value>
  void take(Value& value) {
    if constexpr (std::is_trivially_copyable_v<Value>)
      takeBytes(&value, sizeof value);
    else
      value.fields(*this);
  }
  void take(std::string& text) { takeElements(text); }
  template <class Value>
  void take(std::vector<Value>& values) {
    takeElements(values);
  }
  template <class Value>
  void take(std::optional<Value>& value) {
    bool there = false;
    take(there);
    value.reset();
    if (there) take(value.emplace());
  }
  template <class List>
  void takeElements(List& list) {
    using Element = typename List::value_type;
    size_t count = 0;
    take(count);
    if (count > rest_.size()) throw std::length_error("a message ends too early");  // no element is without a byte
    list.resize(count);
    if constexpr (std::is_trivially_copyable_v<Element>)
      takeBytes(list.data(), count * sizeof(Element));
    else
      for (Element& element : list) take(element);
  }

  std::string_view rest_;
};

}  // namespace turner::watch
