// Reads checked values out of a JSON tree: each function wants one shape, notes a fault where it finds another, and
// says whether it got a value. Goes between json_tree and scene_json; knows nothing of scenes.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

#include "base/diagnostics.h"
#include "scene/json/json_tree.h"
#include "scene/text_scanner.h"

namespace turner {

// What a value is called in messages, such as spheres[3].radius: a link to its container, which must outlive it. Spelt
// out only when there is a fault to tell of.
struct Field {
  static constexpr size_t kNoIndex = SIZE_MAX;
  const Field* container = nullptr;
  std::string_view key;
  size_t index = kNoIndex;

  std::string spell() const;
};

// The numbers that a field may hold, and how a message says so.
struct NumberRule {
  bool (*holds)(double);
  const char* allowed;
};
inline constexpr NumberRule kAnyNumber{[](double x) { return std::abs(x) <= kLargestNumber; },
                                       "a number from -1e30 to 1e30"};

class JsonFields {
 public:
  struct Key {
    std::string_view name;
    bool isRequired;
    std::function<void(size_t at, const Field& field)> read;
  };

  // All three must outlive this object. `at` below is the index of a node of the tree.
  JsonFields(const JsonTree& tree, std::string_view text, Diagnostics& faults)
      : tree_(tree), text_(text), faults_(faults) {}

  const JsonNode& node(size_t at) const { return tree_.nodes[at]; }

  // "scene.json:5:17: error: ", for a message that comes later.
  std::string placeOf(size_t at) const;

  // "FIELD: found THIS; must be ALLOWED"
  void addFault(size_t at, const Field& field, const std::string& allowed);
  // "FIELD: MESSAGE"
  void addMessage(size_t at, const Field& field, const std::string& message);

  // Has each member of an object read by its key; unknown, repeated and missing keys are faults.
  bool readObject(size_t at, const Field& field, std::initializer_list<Key> keys);
  // Likewise where any key may stand.
  bool readMembers(size_t at, const Field& field,
                   const std::function<void(std::string_view key, size_t at, const Field& field)>& read);
  // Has each element of an array read.
  bool readArray(size_t at, const Field& field, const std::function<void(size_t at, const Field& field)>& read);

  bool readNumber(size_t at, const Field& field, const NumberRule& rule, double& value);
  bool readInteger(size_t at, const Field& field, int least, int most, int& value);
  bool readVector(size_t at, const Field& field, const NumberRule& rule, glm::dvec3& value);
  // Three vectors; all faults among them are noted.
  bool readVectors(size_t at, const Field& field, const NumberRule& rule, std::array<glm::dvec3, 3>& value);
  bool readString(size_t at, const Field& field, const char* allowed, std::string& value);

 private:
  std::string describe(size_t at) const;
  size_t countElements(size_t at) const;
  size_t lineOf(size_t offset) const;
  void addRepeatedKey(size_t key, size_t first, const Field& field);
  void addUnknownKey(size_t key, const Field& field, std::initializer_list<Key> known);

  const JsonTree& tree_;
  std::string_view text_;
  Diagnostics& faults_;
};

// A text from outside in double quotes, made fit for a line of a message.
std::string quote(std::string_view text);
// "; did you mean "a"?" where a known name is near, else "; ALLOWED "a", "b", ...".
std::string suggestName(std::string_view misspelt, const std::vector<std::string>& known, const std::string& allowed);

}  // namespace turner
