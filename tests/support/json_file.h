// Writes the figures of a benchmark as JSON.
#pragma once

#include <rapidjson/prettywriter.h>
#include <rapidjson/stringbuffer.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/spread.h"
#include "image/settings.h"

namespace turner::test {

class JsonFile {
 public:
  JsonFile() { writer_.SetIndent(' ', 2); }
  template <class Fill>
  void object(const char* key, Fill&& fill) {
    if (key) writer_.Key(key);
    writer_.StartObject();
    fill();
    writer_.EndObject();
  }
  template <class Fill>
  void array(const char* key, Fill&& fill) {
    writer_.Key(key);
    writer_.StartArray();
    fill();
    writer_.EndArray();
  }
  void put(const char* key, double value) {
    writer_.Key(key);
    writer_.Double(value);
  }
  void put(const char* key, uint64_t value) {
    writer_.Key(key);
    writer_.Uint64(value);
  }
  void put(const char* key, const std::string& value) {
    writer_.Key(key);
    writer_.String(value.c_str());
  }
  void put(const char* key, const std::optional<double>& value) {
    writer_.Key(key);
    value ? writer_.Double(*value) : writer_.Null();
  }
  void put(const char* key, const Spread& spread) {
    object(key, [&] {
      put("median", spread.median);
      put("min", spread.least);
      put("max", spread.most);
    });
  }
  void put(const char* key, const RayCounts& rays) {
    object(key, [&] {
      put("eye", rays.eye);
      put("reflected", rays.reflected);
      put("refracted", rays.refracted);
      put("shadow", rays.shadow);
    });
  }
  void put(const char* key, const std::vector<double>& values) {
    array(key, [&] {
      for (const double value : values) writer_.Double(value);
    });
  }
  void put(const char* key, const std::vector<std::string>& values) {
    array(key, [&] {
      for (const std::string& value : values) writer_.String(value.c_str());
    });
  }
  std::string text() const { return std::string(buffer_.GetString()) + '\n'; }

 private:
  rapidjson::StringBuffer buffer_;
  rapidjson::PrettyWriter<rapidjson::StringBuffer> writer_{buffer_};
};

}  // namespace turner::test
