// Writes JSON, object by object and key by key. The only place that knows RapidJSON's writer.
#pragma once

#include <rapidjson/prettywriter.h>
#include <rapidjson/stringbuffer.h>

#include <cmath>
#include <string>
#include <type_traits>

namespace turner {

class JsonText {
 public:
  JsonText() { writer_.SetIndent(' ', 2); }

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
      writer_.String(std::string(value).c_str());
  }
  std::string text() const { return std::string(buffer_.GetString()) + '\n'; }

 private:
  rapidjson::StringBuffer buffer_;
  rapidjson::PrettyWriter<rapidjson::StringBuffer> writer_{buffer_};
};

}  // namespace turner
