// Writes JSON, object by object and key by key. The only place that knows RapidJSON's writer.
#pragma once

#include <rapidjson/encodings.h>
#include <rapidjson/memorystream.h>
#include <rapidjson/prettywriter.h>
#include <rapidjson/stringbuffer.h>

#include <cmath>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>

namespace turner {

class JsonWriter {
 public:
  JsonWriter() { writer_.SetIndent(' ', 2); }

  template <class Fill>
  void object(Fill&& fill) {
    writer_.StartObject();
    fill();
    writer_.EndObject();
  }
  template <class Fill>
  void object(const char* key, Fill&& fill) {
    writer_.Key(key);
    object(fill);
  }
  template <class Fill>
  void array(Fill&& fill) {
    writer_.StartArray();
    fill();
    writer_.EndArray();
  }
  template <class Fill>
  void array(const char* key, Fill&& fill) {
    writer_.Key(key);
    array(fill);
  }
  template <class Value>
  void put(const char* key, const Value& value) {
    writer_.Key(key);
    put(value);
  }
  template <class Value>
  void put(const char* key, const std::optional<Value>& value) {
    writer_.Key(key);
    value ? put(*value) : void(writer_.Null());
  }
  void putNull(const char* key) {
    writer_.Key(key);
    writer_.Null();
  }
  // JSON knows neither NaN nor infinity: they become null.
  template <class Value>
  void put(const Value& value) {
    if constexpr (std::is_same_v<Value, bool>)
      writer_.Bool(value);
    else if constexpr (std::is_floating_point_v<Value>)
      std::isfinite(value) ? writer_.Double(value) : writer_.Null();
    else if constexpr (std::is_integral_v<Value> && std::is_signed_v<Value>)
      writer_.Int64(value);
    else if constexpr (std::is_integral_v<Value>)
      writer_.Uint64(value);
    else
      putString(value);
  }
  std::string text() const { return std::string(buffer_.GetString()) + '\n'; }
  // The same without line breaks and indentation. Inside strings there is none: they have \n for it.
  std::string oneLine() const {
    std::string line;
    bool indented = false;
    for (const char c : std::string_view(buffer_.GetString(), buffer_.GetSize())) {
      indented = c == '\n' || (indented && c == ' ');
      if (!indented) line += c;
    }
    return line + '\n';
  }

 private:
  // JSON is UTF-8, and a source may hold anything: a byte that is none becomes U+FFFD.
  void putString(std::string_view text) {
    std::string valid;
    while (!text.empty()) {
      rapidjson::MemoryStream bytes(text.data(), text.size());
      unsigned codepoint = 0;
      const bool decoded = rapidjson::UTF8<>::Decode(bytes, &codepoint) && bytes.Tell() <= text.size();
      valid += decoded ? text.substr(0, bytes.Tell()) : "\uFFFD";
      text.remove_prefix(decoded ? bytes.Tell() : 1);
    }
    writer_.String(valid.data(), rapidjson::SizeType(valid.size()));
  }

  rapidjson::StringBuffer buffer_;
  rapidjson::PrettyWriter<rapidjson::StringBuffer> writer_{buffer_};
};

}  // namespace turner
