// In: the text of an NFF file. Out: its scene. One function for each entity; an entity that is wrong is reported, and
// the parser goes on behind it.
#include "scene/nff/scene_nff.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <future>
#include <glm/vec3.hpp>
#include <utility>
#include <vector>

#include "base/diagnostics.h"
#include "base/errors.h"
#include "base/number.h"
#include "base/reserve.h"
#include "base/text_file.h"
#include "scene/nff/nff_lines.h"
#include "scene/nff/nff_view.h"
#include "scene/nff/primitive_counts.h"
#include "scene/plain_text.h"
#include "scene/polygon/polygon.h"
#include "scene/text_scanner.h"

namespace turner {
namespace {

using nff::Broken, nff::isEntity, nff::kMostFaults, nff::Numbers;

constexpr NoteKind kNoDirection{"polygon has a normal without a direction and is flat",
                                "polygons have a normal without a direction and are flat"};
constexpr NoteKind kFewCorners{"polygon of fewer than 3 corners was dropped",
                               "polygons of fewer than 3 corners were dropped"};
constexpr NoteKind kNoArea{"polygon without area was dropped", "polygons without area were dropped"};
constexpr NoteKind kCrossing{"polygon crosses or overlaps itself and was cut into triangles anyhow",
                             "polygons cross or overlap themselves and were cut into triangles anyhow"};

constexpr const char* kTooFlat =
    "the radii differ by more than 1e5 times the distance of base and apex; a polygon is a disc, and longer cones are "
    "allowed";

class NffParser {
 public:
  // `bytes` are those of the file, `text` is what was read of them.
  NffParser(const std::string& path, std::string_view bytes, std::string_view text) : lines_(path, text) {
    const nff::PrimitiveCounts counts = nff::countPrimitives(text);
    reservePrefaulted(result_.scene.spheres, counts.spheres);
    reservePrefaulted(result_.scene.cones, counts.cones);
    reservePrefaulted(result_.scene.triangles, counts.triangles);
    reservePrefaulted(result_.scene.positions, counts.corners);
    reservePrefaulted(result_.scene.normals, counts.smoothCorners);
    const std::filesystem::path file(path);
    result_.scene.name = file.stem().string();
    result_.scene.sources = {{file.filename().string(), ""}};
    hash_ = std::async(sha256Hex, bytes);  // beside the parser, on another core
  }

  ParsedScene parse() {
    bool more = lines_.nextLine();
    while (more) {
      if (lines_.faults.count() >= kMostFaults) {
        lines_.faults.add(lines_.peek().offset, "too many faults; the rest of the file is not looked at");
        break;
      }
      more = parseEntity() || lines_.skipToEntity();
    }
    if (lines_.firstUnknown && !hasEntities_) refuseUnknown(*lines_.firstUnknown);
    lines_.faults.throwIfAny();
    colorLights();
    result_.scene.notes = lines_.notes.lines();
    result_.scene.sources[0].sha256 = hash_.get();
    return std::move(result_);
  }

 private:
  // Reads the entity that begins on the current line and goes to the line behind it. False if there is none, or if the
  // entity is wrong and leaves open where the next one begins.
  bool parseEntity() {
    const Token word = lines_.next();
    lines_.atLineStart = false;
    hasEntities_ |= isEntity(word.text);
    try {
      if (word.text == "s") {
        parseSphere(word);
      } else if (word.text == "p") {
        parsePolygon(word, false);
      } else if (word.text == "pp") {
        parsePolygon(word, true);
      } else if (word.text == "c") {
        parseCone(word);
      } else if (word.text == "f") {
        parseMaterial();
      } else if (word.text == "l") {
        parseLight();
      } else if (word.text == "b") {
        parseBackground(word);
      } else if (word.text == "v") {
        return nff::parseView(lines_, word,
                              result_);  // it ends where another entity begins, so it has gone to that line already
      } else {
        return passUnknown(word);
      }
    } catch (const Broken&) {
      // Behind an entity of one line the next one stands for itself. What follows a broken polygon or an unknown word
      // may still belong to it, and would only repeat the fault.
      const bool oneLine = isEntity(word.text) && word.text != "p" && word.text != "pp";
      return oneLine && lines_.nextLine();
    }
    return lines_.nextLine();
  }

  void refuseUnknown(const Token& word) {
    lines_.faults.add(word.offset, "unknown entity " + quoted(word.text) +
                                       "; allowed are b, c, f, l, p, pp, s, v and comments with #, of which the file " +
                                       "has none");
  }

  // Passes over an unknown entity and the lines of numbers below, which are its own. False at the end of the file.
  bool passUnknown(const Token& word) {
    if (nff::isViewWord(word.text)) {
      lines_.fail(word.offset, quoted(word.text) + " stands outside a view; it belongs below a 'v' line");
    }
    double number;
    const auto isNumber = [&](const Token& token) {
      return parseNumber(token.text, number) != NumberFault::notANumber;
    };
    if (isNumber(word)) {
      lines_.fail(word.offset,
                  "found the number " + quoted(word.text) +
                      " where an entity should begin; allowed are b, c, f, l, p, pp, s, v and comments with #" +
                      " (a polygon above may announce fewer corners than it has)");
    }
    std::string lower(word.text.substr(0, 3));
    std::transform(lower.begin(), lower.end(), lower.begin(), [](unsigned char c) { return char(std::tolower(c)); });
    if (isEntity(lower)) {
      lines_.fail(word.offset, "unknown entity " + quoted(word.text) + ", did you mean '" + lower + "'?");
    }
    lines_.noteUnknown(word);
    while (lines_.nextLine()) {
      if (!isNumber(lines_.peek())) return true;
    }
    return false;
  }

  void parseBackground(const Token& word) {
    const Numbers numbers = lines_.readNumbers({3}, "b r g b");
    if (std::exchange(hasBackground_, true)) lines_.fail(word.offset, "a second background; allowed is one 'b' line");
    result_.scene.background = lines_.readColor(numbers, 0);
  }

  void parseLight() {
    const Numbers numbers = lines_.readNumbers({3, 6}, "l x y z [r g b]");
    Light light;
    light.position = numbers.vector(0);
    if (numbers.count == 6) {
      light.color = lines_.readColor(numbers, 3);
    } else {
      lightsWithoutColor_.push_back(result_.scene.lights.size());
    }
    result_.scene.lights.push_back(light);
  }

  // A light without a colour gets 1/sqrt(number of all lights), which is known only at the end of the file.
  void colorLights() {
    std::vector<Light>& lights = result_.scene.lights;
    for (const size_t i : lightsWithoutColor_) lights[i].color = glm::dvec3(1 / std::sqrt(double(lights.size())));
  }

  void parseMaterial() {
    // Even a wrong material is one: the objects behind it shall not be reported too.
    Material& material = result_.scene.materials.emplace_back();
    material.name = "f" + std::to_string(result_.scene.materials.size());
    const Numbers numbers = lines_.readNumbers(7, 8, "f r g b Kd Ks Shine T ior");
    const glm::dvec3 color = lines_.readColor(numbers, 0);
    const auto readShare = [&](size_t i, const char* name, double most, const char* allowed) {
      if (numbers[i] < 0 || numbers[i] > most) {
        lines_.fail(numbers.offsets[i], std::string(name) + " is out of its range; allowed are values " + allowed);
      }
      return numbers[i];
    };
    material.diffuse = readShare(3, "Kd", kLargestNumber, "from 0") * color;
    material.reflect = readShare(4, "Ks", 1, "from 0 to 1");
    material.specular = glm::dvec3(material.reflect);
    material.shininess = readShare(5, "Shine", kLargestNumber, "from 0");
    material.transmit = readShare(6, "T", 1, "from 0 to 1");
    if (material.transmit > 0) {
      if (!(numbers[7] > 0)) {
        lines_.fail(numbers.offsets[7], "the index of refraction must be a number greater than 0 where T is");
      }
      material.eta = numbers[7];
    }
  }

  // The number of the material that holds for an object.
  uint32_t currentMaterial(const Token& word) {
    const size_t count = result_.scene.materials.size();
    if (count > 0) return uint32_t(count - 1);
    // Once is enough: all objects up to the first material lack it.
    if (!std::exchange(saidNoMaterial_, true)) {
      lines_.faults.add(word.offset, "no material yet: an 'f' line must stand before the objects");
    }
    return 0;
  }

  void parseSphere(const Token& word) {
    const Numbers numbers = lines_.readNumbers({4}, "s x y z radius");
    if (numbers[3] == 0) {
      lines_.fail(numbers.offsets[3], "the radius is 0; allowed are all others, below 0 for a sphere seen from inside");
    }
    result_.scene.spheres.push_back({numbers.vector(0), numbers[3], currentMaterial(word)});
  }

  // The number of corners that a polygon announces.
  size_t readCornerCount(const char* form) {
    const Token token = lines_.next();
    const std::string allowed = std::string("; allowed is ") + form + " with a whole number n";
    if (token.text.empty()) lines_.fail(token.offset, "the number of corners is missing" + allowed);
    long long count = 0;
    if (parseInteger(token.text, count) == NumberFault::notANumber) {
      lines_.fail(token.offset, quoted(token.text) + " is not a number of corners" + allowed);
    }
    if (token.text.starts_with('-')) {
      lines_.fail(token.offset, "a polygon of " + std::string(token.text.substr(0, 20)) + " corners" + allowed);
    }
    const Token extra = lines_.next();
    if (!extra.text.empty())
      lines_.fail(extra.offset, "more on the line than expected: " + quoted(extra.text) + allowed);
    // A corner takes six bytes at least ("0 0 0" and a line end), so that memory never depends on the number alone.
    if (parseInteger(token.text, count) == NumberFault::tooLarge || size_t(count) > lines_.remaining() / 6 + 1) {
      lines_.fail(token.offset, "the file ends inside this polygon: " + quoted(token.text) +
                                    " corners are announced, more than the rest of the file can hold");
    }
    return size_t(count);
  }

  // Goes to the line of a polygon's corner.
  void goToCorner(const Token& word, size_t given, size_t count) {
    const auto found = [&] {
      return "the polygon has " + std::to_string(given) + " of its " + std::to_string(count) + " corners";
    };
    if (!lines_.nextLine()) lines_.fail(word.offset, "the file ends inside this polygon: " + found());
    const Token first = lines_.peek();
    if (isEntity(first.text)) {
      lines_.atLineStart = true;
      lines_.fail(first.offset, "found " + quoted(first.text) + " where a corner should stand; " + found());
    }
  }

  void parsePolygon(const Token& word, bool smooth) {
    const size_t count = readCornerCount(smooth ? "pp n" : "p n");
    std::vector<glm::dvec3>& corners = corners_;
    std::vector<glm::dvec3>& normals = cornerNormals_;
    corners.clear();
    normals.clear();
    bool haveDirections = true;
    for (size_t i = 0; i < count; ++i) {
      goToCorner(word, i, count);
      const Numbers numbers = smooth ? lines_.readNumbers(3, 6, "x y z nx ny nz") : lines_.readNumbers({3}, "x y z");
      corners.push_back(numbers.vector(0));
      if (!smooth) continue;
      const glm::dvec3 normal = normals.emplace_back(numbers.vector(3));
      haveDirections &= normal == normal && normal != glm::dvec3(0);  // NaN equals nothing
    }

    const uint32_t material = currentMaterial(word);
    CountedNotes& notes = lines_.notes;
    if (count < 3) return notes.add(kFewCorners, word.offset);
    const CutPolygon polygon = triangulatePolygon(corners);
    if (polygon.triangles.empty()) return notes.add(kNoArea, word.offset);
    if (polygon.crossesItself) notes.add(kCrossing, word.offset);
    if (!haveDirections) {
      notes.add(kNoDirection, word.offset);
      normals.clear();
    }
    Scene& scene = result_.scene;
    const uint32_t position = uint32_t(scene.positions.size()), normal = uint32_t(scene.normals.size());
    for (const auto& [a, b, c] : polygon.triangles) {
      Triangle triangle{.positions = {position + a, position + b, position + c}, .material = material};
      if (!normals.empty()) triangle.normals = {normal + a, normal + b, normal + c};
      scene.triangles.push_back(triangle);
    }
    scene.positions.insert(scene.positions.end(), corners.begin(), corners.end());
    scene.normals.insert(scene.normals.end(), normals.begin(), normals.end());
  }

  // Its two ends stand on the line of the `c`, or on the two lines below.
  Numbers readCone(const Token& word) {
    Numbers numbers = lines_.readNumbers({0, 8}, "c x y z radius x y z radius");
    if (numbers.count == 8) return numbers;
    while (numbers.count < 8) {
      if (!lines_.nextLine()) lines_.fail(word.offset, "the file ends inside this cone");
      const Token first = lines_.peek();
      if (isEntity(first.text)) {
        lines_.atLineStart = true;
        lines_.fail(first.offset, "found " + quoted(first.text) + " where an end of the cone should stand");
      }
      const Numbers end = lines_.readNumbers({4}, "x y z radius");
      for (size_t i = 0; i < 4; ++i) {
        numbers.offsets[numbers.count] = end.offsets[i];
        numbers.values[numbers.count++] = end[i];
      }
    }
    return numbers;
  }

  void parseCone(const Token& word) {
    const Numbers numbers = readCone(word);
    const glm::dvec3 base = numbers.vector(0), apex = numbers.vector(4);
    const double baseRadius = numbers[3], apexRadius = numbers[7];
    if (baseRadius == 0 && apexRadius == 0) lines_.fail(numbers.offsets[3], "both radii are 0; allowed is one of them");
    if ((baseRadius < 0 && apexRadius > 0) || (baseRadius > 0 && apexRadius < 0)) {
      lines_.fail(numbers.offsets[7],
                  "one radius is negative, the other positive; allowed are both negative (seen from inside) or none");
    }
    if (base == apex) lines_.fail(numbers.offsets[4], "base and apex are the same point; a cone needs a length");
    const Cone cone{base, baseRadius, apex, apexRadius, currentMaterial(word)};
    if (isTooFlat(cone)) lines_.fail(numbers.offsets[4], kTooFlat);
    result_.scene.cones.push_back(cone);
  }

  nff::Lines lines_;
  ParsedScene result_;
  std::future<std::string> hash_;
  bool hasEntities_ = false;
  bool hasBackground_ = false;
  bool saidNoMaterial_ = false;
  std::vector<size_t> lightsWithoutColor_;
  std::vector<glm::dvec3> corners_, cornerNormals_;  // of the polygon being read; kept for their memory
};

}  // namespace

ParsedScene parseNffScene(const std::string& path, std::string_view bytes) {
  const PlainText text(path, bytes);
  return NffParser(path, bytes, text.view()).parse();
}

}  // namespace turner
