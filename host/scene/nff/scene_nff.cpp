// In: the text of an NFF file. Out: its scene, spheres and triangles only. One function for each entity; an entity that
// is wrong is reported, and the parser goes on behind it.
#include "scene/nff/scene_nff.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <future>
#include <glm/geometric.hpp>
#include <initializer_list>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <utility>
#include <vector>

#include "base/diagnostics.h"
#include "base/errors.h"
#include "base/number.h"
#include "base/reserve.h"
#include "base/text_file.h"
#include "scene/polygon/polygon.h"
#include "scene/text_scanner.h"

namespace turner {

namespace {

constexpr std::array<std::string_view, 8> kEntities{"b", "c", "f", "l", "p", "pp", "s", "v"};
constexpr std::array<std::string_view, 6> kViewWords{"from", "at", "up", "angle", "hither", "resolution"};

// A file that is not NFF at all would be wrong in every line; nobody reads further than this.
constexpr size_t kMostFaults = 100;

bool isEntity(std::string_view word) {
  // Almost every line of a large file begins with a number.
  return word.size() <= 2 && std::find(kEntities.begin(), kEntities.end(), word) != kEntities.end();
}
size_t viewWordIndex(std::string_view word) {
  return size_t(std::find(kViewWords.begin(), kViewWords.end(), word) - kViewWords.begin());
}

// The numbers of one line, each with its place.
struct Numbers {
  static constexpr size_t kMost = 9;
  std::array<double, kMost> values{};
  std::array<size_t, kMost> offsets{};
  size_t count = 0;

  double operator[](size_t i) const { return values[i]; }
  glm::dvec3 vector(size_t first) const { return {values[first], values[first + 1], values[first + 2]}; }
};

// Unit vectors e1, e2 that form a right-handed frame with a unit vector.
std::pair<glm::dvec3, glm::dvec3> frameAround(const glm::dvec3& axis) {
  const glm::dvec3 size = glm::abs(axis);
  const glm::dvec3 across = size.x <= size.y && size.x <= size.z ? glm::dvec3(1, 0, 0)
                            : size.y <= size.z                   ? glm::dvec3(0, 1, 0)
                                                                 : glm::dvec3(0, 0, 1);
  const glm::dvec3 e1 = glm::normalize(glm::cross(axis, across));
  return {e1, glm::cross(axis, e1)};
}

// Cosine and sine of the angles of a cone's edges (even) and of the middles between them (odd).
constexpr int kConeSteps = 2 * kConeSegments;
const std::array<std::pair<double, double>, kConeSteps>& coneAngles() {
  static const auto angles = [] {
    std::array<std::pair<double, double>, kConeSteps> table;
    for (int i = 0; i < kConeSteps; ++i) {
      const double angle = 2 * std::numbers::pi * i / kConeSteps;
      table[size_t(i)] = {std::cos(angle), std::sin(angle)};
    }
    return table;
  }();
  return angles;
}

double lengthOf(const glm::dvec3& v) {
  return std::hypot(v.x, v.y, v.z);
}  // without overflow or underflow

struct Counts {
  size_t spheres = 0, triangles = 0, smooth = 0, cones = 0;
};

// How much room the scene will need if each entity begins at the start of its line; `triangles` without those of cones.
Counts countPrimitives(std::string_view text) {
  Counts counts;
  // The least text that a corner and a sphere may have; a file that announces more must not get the memory for it.
  const size_t mostCorners = text.size() / std::string_view("0 0 0\n").size();
  const size_t mostSpheres = text.size() / std::string_view("s 0 0 0 1\n").size();
  for (size_t at = 0; at < text.size();) {
    if (text[at] == 's') {
      ++counts.spheres;
    } else if (text[at] == 'c') {
      ++counts.cones;
    } else if (text[at] == 'p') {
      const bool smooth = at + 1 < text.size() && text[at + 1] == 'p';
      size_t corners = 0;
      for (size_t digit = at + (smooth ? 3 : 2); digit < text.size() && corners <= mostCorners; ++digit) {
        if (text[digit] < '0' || text[digit] > '9') break;
        corners = 10 * corners + size_t(text[digit] - '0');
      }
      if (corners > 2) (smooth ? counts.smooth : counts.triangles) += std::min(corners, mostCorners) - 2;
    }
    const size_t lineEnd = text.find('\n', at);
    if (lineEnd == std::string_view::npos) break;
    at = lineEnd + 1;
  }
  counts.triangles += counts.smooth;
  return {std::min(counts.spheres, mostSpheres), std::min(counts.triangles, mostCorners),
          std::min(counts.smooth, mostCorners), counts.cones};
}

class NffParser {
 public:
  NffParser(const std::string& path, std::string_view text) : lines_(text), faults_(path, text) {
    const Counts counts = countPrimitives(text);
    conesToCome_ = double(counts.cones);
    reservePrefaulted(result_.scene.spheres, counts.spheres);
    reservePrefaulted(result_.scene.triangles, counts.triangles);
    reservePrefaulted(result_.scene.normals, counts.smooth);
    const std::filesystem::path file(path);
    result_.scene.name = file.stem().string();
    result_.scene.sources = {{file.filename().string(), ""}};
    hash_ = std::async(sha256Hex, text);  // beside the parser, on another core
  }

  ParsedScene parse() {
    bool more = lines_.nextLine();
    while (more) {
      if (faults_.count() >= kMostFaults) {
        faults_.add(lines_.peek().offset, "too many faults; the rest of the file is not looked at");
        break;
      }
      more = parseEntity() || skipToEntity();
    }
    faults_.throwIfAny();
    colorLights();
    noteDroppedPolygons();
    result_.scene.sources[0].sha256 = hash_.get();
    return std::move(result_);
  }

 private:
  // What a fault inside an entity throws, to leave it at once.
  struct Broken {};

  [[noreturn]] void fail(size_t offset, std::string message) {
    faults_.add(offset, std::move(message));
    throw Broken();
  }

  // Goes on at the current line, if it begins an entity, or at the next one that does. False at the end of the file.
  bool skipToEntity() {
    if (atLineStart_ && isEntity(lines_.peek().text)) return true;
    atLineStart_ = true;
    while (lines_.nextLine()) {
      if (isEntity(lines_.peek().text)) return true;
    }
    return false;
  }

  // Reads the entity that begins on the current line and goes to the line behind it. False if there is none, or if the
  // entity is wrong and leaves open where the next one begins.
  bool parseEntity() {
    const Token word = lines_.next();
    atLineStart_ = false;
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
        return parseView(word);  // it ends where another entity begins, so it has gone to that line already
      } else {
        failUnknown(word);
      }
    } catch (const Broken&) {
      // Behind an entity of one line the next one stands for itself. What follows a broken polygon or an unknown word
      // may still belong to it, and would only repeat the fault.
      const bool oneLine = isEntity(word.text) && word.text != "p" && word.text != "pp";
      return oneLine && lines_.nextLine();
    }
    return lines_.nextLine();
  }

  [[noreturn]] void failUnknown(const Token& word) {
    if (viewWordIndex(word.text) < kViewWords.size()) {
      fail(word.offset, quoted(word.text) + " stands outside a view; it belongs below a 'v' line");
    }
    double number;
    if (parseNumber(word.text, number) != NumberFault::notANumber) {
      fail(word.offset, "found the number " + quoted(word.text) +
                            " where an entity should begin; allowed are b, c, f, l, p, pp, s, v and comments with #" +
                            " (a polygon above may announce fewer corners than it has)");
    }
    fail(word.offset,
         "unknown entity " + quoted(word.text) + "; allowed are b, c, f, l, p, pp, s, v and comments with #");
  }

  // Reads all numbers that the line still holds; their count must be one of the allowed. `form` shows them in the
  // message, as "s x y z radius".
  Numbers readNumbers(std::initializer_list<size_t> allowed, std::string_view form) {
    Numbers numbers;
    const size_t most = std::max(allowed);
    while (numbers.count < most &&
           lines_.nextPlainNumber(numbers.values[numbers.count], numbers.offsets[numbers.count])) {
      ++numbers.count;
    }
    for (Token token = lines_.next(); !token.text.empty(); token = lines_.next()) {
      if (numbers.count == most) {
        fail(token.offset, "more on the line than expected: " + quoted(token.text) + "; allowed is " +
                               std::string(form) + ", one entity a line");
      }
      std::string wrong = readSceneNumber(token.text, numbers.values[numbers.count]);
      if (!wrong.empty()) fail(token.offset, std::move(wrong));
      numbers.offsets[numbers.count++] = token.offset;
    }
    if (std::find(allowed.begin(), allowed.end(), numbers.count) == allowed.end()) {
      fail(lines_.peek().offset, "found " + std::to_string(numbers.count) +
                                     (numbers.count == 1 ? " number" : " numbers") +
                                     ", the line is too short; allowed is " + std::string(form));
    }
    return numbers;
  }

  glm::dvec3 readColor(const Numbers& numbers, size_t first) {
    for (size_t i = first; i < first + 3; ++i) {
      if (numbers[i] < 0) fail(numbers.offsets[i], "a colour must not be negative; allowed are values from 0");
    }
    return numbers.vector(first);
  }

  void parseBackground(const Token& word) {
    const Numbers numbers = readNumbers({3}, "b r g b");
    if (std::exchange(hasBackground_, true)) fail(word.offset, "a second background; allowed is one 'b' line");
    result_.scene.background = readColor(numbers, 0);
  }

  void parseLight() {
    const Numbers numbers = readNumbers({3, 6}, "l x y z [r g b]");
    Light light;
    light.position = numbers.vector(0);
    if (numbers.count == 6) {
      light.color = readColor(numbers, 3);
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
    const Numbers numbers = readNumbers({8}, "f r g b Kd Ks Shine T ior");
    const glm::dvec3 color = readColor(numbers, 0);
    const auto readShare = [&](size_t i, const char* name, double most, const char* allowed) {
      if (numbers[i] < 0 || numbers[i] > most) {
        fail(numbers.offsets[i], std::string(name) + " is out of its range; allowed are values " + allowed);
      }
      return numbers[i];
    };
    material.diffuse = readShare(3, "Kd", kLargestNumber, "from 0") * color;
    material.reflect = readShare(4, "Ks", 1, "from 0 to 1");
    material.specular = glm::dvec3(material.reflect);
    material.shininess = readShare(5, "Shine", kLargestNumber, "from 0");
    material.transmit = readShare(6, "T", 1, "from 0 to 1");
    if (material.transmit > 0) {
      if (numbers[7] <= 0) fail(numbers.offsets[7], "the index of refraction must be greater than 0 where T is");
      material.eta = numbers[7];
    }
  }

  // The number of the material that holds for an object.
  uint32_t currentMaterial(const Token& word) {
    const size_t count = result_.scene.materials.size();
    if (count > 0) return uint32_t(count - 1);
    // Once is enough: all objects up to the first material lack it.
    if (!std::exchange(saidNoMaterial_, true)) {
      faults_.add(word.offset, "no material yet: an 'f' line must stand before the objects");
    }
    return 0;
  }

  void parseSphere(const Token& word) {
    const Numbers numbers = readNumbers({4}, "s x y z radius");
    if (numbers[3] == 0) {
      fail(numbers.offsets[3], "the radius is 0; allowed are all others, below 0 for a sphere seen from inside");
    }
    result_.scene.spheres.push_back({numbers.vector(0), numbers[3], currentMaterial(word)});
  }

  void addTriangle(const std::array<glm::dvec3, 3>& vertices, uint32_t material) {
    result_.scene.triangles.push_back({vertices, material, kNoNormals});
  }
  void addTriangle(const std::array<glm::dvec3, 3>& vertices, const std::array<glm::dvec3, 3>& normals,
                   uint32_t material) {
    result_.scene.triangles.push_back({vertices, material, uint32_t(result_.scene.normals.size())});
    result_.scene.normals.push_back(normals);
  }

  // The number of corners that a polygon announces.
  size_t readCornerCount(const char* form) {
    const Token token = lines_.next();
    const std::string allowed = std::string("; allowed is ") + form + " with a whole number n from 3";
    if (token.text.empty()) fail(token.offset, "the number of corners is missing" + allowed);
    long long count = 0;
    if (parseInteger(token.text, count) == NumberFault::notANumber) {
      fail(token.offset, quoted(token.text) + " is not a number of corners" + allowed);
    }
    if (token.text.starts_with('-') ||
        (count < 3 && count >= 0 && parseInteger(token.text, count) == NumberFault::none)) {
      fail(token.offset, "a polygon of " + std::string(token.text.substr(0, 20)) + " corners" + allowed);
    }
    const Token extra = lines_.next();
    if (!extra.text.empty()) fail(extra.offset, "more on the line than expected: " + quoted(extra.text) + allowed);
    // A corner takes six bytes at least ("0 0 0" and a line end), so that memory never depends on the number alone.
    if (parseInteger(token.text, count) == NumberFault::tooLarge || size_t(count) > lines_.remaining() / 6 + 1) {
      fail(token.offset, "the file ends inside this polygon: " + quoted(token.text) +
                             " corners are announced, more than the rest of the file can hold");
    }
    return size_t(count);
  }

  // Goes to the line of a polygon's corner.
  void goToCorner(const Token& word, size_t given, size_t count) {
    const auto found = [&] {
      return "the polygon has " + std::to_string(given) + " of its " + std::to_string(count) + " corners";
    };
    if (!lines_.nextLine()) fail(word.offset, "the file ends inside this polygon: " + found());
    const Token first = lines_.peek();
    if (isEntity(first.text)) {
      atLineStart_ = true;
      fail(first.offset, "found " + quoted(first.text) + " where a corner should stand; " + found());
    }
  }

  void parsePolygon(const Token& word, bool smooth) {
    const size_t count = readCornerCount(smooth ? "pp n" : "p n");
    std::vector<glm::dvec3>& corners = corners_;
    std::vector<glm::dvec3>& normals = cornerNormals_;
    corners.clear();
    normals.clear();
    for (size_t i = 0; i < count; ++i) {
      goToCorner(word, i, count);
      const Numbers numbers = smooth ? readNumbers({6}, "x y z nx ny nz") : readNumbers({3}, "x y z");
      corners.push_back(numbers.vector(0));
      if (!smooth) continue;
      normals.push_back(numbers.vector(3));
      if (normals.back() == glm::dvec3(0)) fail(numbers.offsets[3], "a normal must not be 0 0 0");
    }

    const uint32_t material = currentMaterial(word);
    const auto triangles = triangulate(word);
    if (triangles.empty()) ++polygonsWithoutArea_;
    for (const auto& [a, b, c] : triangles) {
      if (smooth) {
        addTriangle({corners[a], corners[b], corners[c]}, {normals[a], normals[b], normals[c]}, material);
      } else {
        addTriangle({corners[a], corners[b], corners[c]}, material);
      }
    }
  }

  std::vector<std::array<uint32_t, 3>> triangulate(const Token& word) {
    try {
      return triangulatePolygon(corners_);
    } catch (const std::invalid_argument& reason) {
      fail(word.offset, std::string(reason.what()) + "; allowed are polygons whose edges meet at corners only");
    }
  }

  void noteDroppedPolygons() {
    if (polygonsWithoutArea_ == 0) return;
    result_.scene.notes.push_back(std::to_string(polygonsWithoutArea_) + (polygonsWithoutArea_ == 1
                                                                              ? " polygon without area was dropped"
                                                                              : " polygons without area were dropped"));
  }

  // Its two ends stand on the line of the `c`, or on the two lines below.
  Numbers readCone(const Token& word) {
    Numbers numbers = readNumbers({0, 8}, "c x y z radius x y z radius");
    if (numbers.count == 8) return numbers;
    while (numbers.count < 8) {
      if (!lines_.nextLine()) fail(word.offset, "the file ends inside this cone");
      const Token first = lines_.peek();
      if (isEntity(first.text)) {
        atLineStart_ = true;
        fail(first.offset, "found " + quoted(first.text) + " where an end of the cone should stand");
      }
      const Numbers end = readNumbers({4}, "x y z radius");
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
    if (baseRadius == 0 && apexRadius == 0) fail(numbers.offsets[3], "both radii are 0; allowed is one of them");
    if ((baseRadius < 0 && apexRadius > 0) || (baseRadius > 0 && apexRadius < 0)) {
      fail(numbers.offsets[7],
           "one radius is negative, the other positive; allowed are both negative (seen from inside) or none");
    }
    if (base == apex) fail(numbers.offsets[4], "base and apex are the same point; a cone needs a length");
    addCone(base, std::abs(baseRadius), apex, std::abs(apexRadius), baseRadius < 0 || apexRadius < 0,
            currentMaterial(word));
  }

  // Makes room for the triangles of a cone and, if they are like those so far, of all that follow.
  void makeRoomForCone(size_t count) {
    ++conesSoFar_;
    coneTriangles_ += double(count);
    conesToCome_ = std::max(0.0, conesToCome_ - 1);
    std::vector<Triangle>& triangles = result_.scene.triangles;
    if (triangles.capacity() - triangles.size() >= count) return;
    // The first cones may be unlike the rest: beyond a few MiB, room grows with what is there.
    const double most = 65536 + 16 * double(triangles.size());
    const size_t room = count + size_t(std::min(most, coneTriangles_ / conesSoFar_ * conesToCome_));
    reservePrefaulted(triangles, room);
    reservePrefaulted(result_.scene.normals, room);
  }

  // Strips of the cone's side between neighbouring angles, smooth by the normals of the cone itself.
  void addCone(const glm::dvec3& base, double baseRadius, const glm::dvec3& apex, double apexRadius, bool inward,
               uint32_t material) {
    const double length = lengthOf(apex - base);
    const glm::dvec3 axis = (apex - base) / length;
    const auto [e1, e2] = frameAround(axis);
    // The normal stands on the slant: as the side moves outwards by the radii's difference along the length, it tilts.
    const double difference = apexRadius - baseRadius, slant = std::hypot(length, difference);
    const double outwards = (inward ? -1 : 1) * length / slant, along = (inward ? 1 : -1) * difference / slant;

    struct Ray {
      glm::dvec3 direction, normal;
    };
    // The last strip ends at the very points where the first began.
    const auto rayAt = [&, e1 = e1, e2 = e2](int step) {
      const auto [cosine, sine] = coneAngles()[size_t(step % kConeSteps)];
      const glm::dvec3 direction = cosine * e1 + sine * e2;
      return Ray{direction, outwards * direction + along * axis};
    };
    const auto add = [&](std::array<glm::dvec3, 3> vertices, std::array<glm::dvec3, 3> normals) {
      if (inward) {
        std::swap(vertices[1], vertices[2]);
        std::swap(normals[1], normals[2]);
      }
      addTriangle(vertices, normals, material);
    };

    const int pieces = conePieces(length, std::max(baseRadius, apexRadius));
    makeRoomForCone(size_t(pieces) * 2 * kConeSegments);
    for (int piece = 0; piece < pieces; ++piece) {
      // Neighbouring pieces compute their common rim alike, so that it has no cracks.
      const double from = double(piece) / pieces, to = double(piece + 1) / pieces;
      const glm::dvec3 lower = base + from * (apex - base), upper = to < 1 ? base + to * (apex - base) : apex;
      const double lowerRadius = baseRadius + from * difference,
                   upperRadius = to < 1 ? baseRadius + to * difference : apexRadius;
      Ray ray = rayAt(0);
      for (int i = 0; i < kConeSegments; ++i) {
        const Ray next = rayAt(2 * i + 2);
        const glm::dvec3 lower0 = lower + lowerRadius * ray.direction, lower1 = lower + lowerRadius * next.direction;
        const glm::dvec3 upper0 = upper + upperRadius * ray.direction, upper1 = upper + upperRadius * next.direction;
        // A tip has no normal of its own: it takes the one in the middle of the strip.
        if (upperRadius == 0) {
          add({lower0, lower1, upper}, {ray.normal, next.normal, rayAt(2 * i + 1).normal});
        } else if (lowerRadius == 0) {
          add({lower, upper1, upper0}, {rayAt(2 * i + 1).normal, next.normal, ray.normal});
        } else {
          add({lower0, lower1, upper1}, {ray.normal, next.normal, next.normal});
          add({lower0, upper1, upper0}, {ray.normal, next.normal, ray.normal});
        }
        ray = next;
      }
    }
  }

  // A view's lines in the order of kViewWords.
  using ViewLines = std::array<std::optional<Numbers>, kViewWords.size()>;

  // The lines below `v`, in any order. Goes to the line behind them; false at the end of the file.
  bool parseView(const Token& word) {
    ViewLines given;
    bool broken = false;
    const Token extra = lines_.next();
    if (!extra.text.empty()) {
      faults_.add(extra.offset, "more on the line than expected: " + quoted(extra.text) + "; allowed is 'v' alone");
      broken = true;
    }
    const bool more = readViewLines(given, broken);
    if (std::exchange(result_.hasCamera, true)) {
      faults_.add(word.offset, "a second view; allowed is one 'v'");
    } else if (isComplete(word, given, more) && !broken) {
      setView(given);
    }
    return more;
  }

  // Reads up to the next entity. False at the end of the file; `broken` becomes true where a line is wrong.
  bool readViewLines(ViewLines& given, bool& broken) {
    bool saidUnknown = false;
    while (lines_.nextLine() && faults_.count() < kMostFaults) {
      if (isEntity(lines_.peek().text)) return true;
      const Token name = lines_.next();
      const size_t index = viewWordIndex(name.text);
      try {
        if (index == kViewWords.size()) {
          if (std::exchange(saidUnknown, true)) continue;
          fail(name.offset,
               "found " + quoted(name.text) +
                   " in a view; allowed are from, at, up, angle, hither, resolution and entities behind them");
        }
        if (given[index]) fail(name.offset, quoted(name.text) + " stands twice in this view; allowed is once");
        given[index] = readViewLine(index);
      } catch (const Broken&) {
        broken = true;
        if (index < given.size() && !given[index]) given[index].emplace();  // wrong, but not missing
      }
    }
    return false;
  }

  Numbers readViewLine(size_t index) {
    switch (index) {
      case 0:
        return readNumbers({3}, "from x y z");
      case 1:
        return readNumbers({3}, "at x y z");
      case 2:
        return readNumbers({3}, "up x y z");
      case 3:
        return readNumbers({1}, "angle degrees");
      case 4:
        return readNumbers({1}, "hither distance");
      default:
        return readNumbers({2}, "resolution width height");
    }
  }

  bool isComplete(const Token& word, const ViewLines& given, bool more) {
    std::string missing;
    for (size_t i = 0; i < kViewWords.size(); ++i) {
      if (given[i] || kViewWords[i] == "hither") continue;  // hither is not looked at, so it need not be there
      missing += (missing.empty() ? "'" : ", '") + std::string(kViewWords[i]) + "'";
    }
    if (missing.empty()) return true;
    faults_.add(word.offset, (more ? "the view lacks " : "the file ends inside this view: it lacks ") + missing);
    return false;
  }

  void setView(const ViewLines& given) {
    const auto& [from, at, up, angle, hither, resolution] = given;
    Camera& camera = result_.scene.camera;
    camera.eye = from->vector(0);
    camera.target = at->vector(0);
    camera.up = up->vector(0);
    camera.fov = (*angle)[0];
    const double distance = lengthOf(camera.target - camera.eye), upLength = lengthOf(camera.up);
    if (distance == 0) {
      faults_.add(at->offsets[0], "'from' and 'at' are the same point; the view needs a direction");
    } else if (upLength == 0) {
      faults_.add(up->offsets[0], "'up' must not be 0 0 0");
    } else {
      // The sine of the angle between them, below which the picture's axes would be rounding noise in float32.
      const double sine = lengthOf(glm::cross((camera.target - camera.eye) / distance, camera.up / upLength));
      if (sine < 1e-6) faults_.add(up->offsets[0], "'up' is parallel to the view; allowed is any other direction");
    }
    if (camera.fov <= 0 || camera.fov >= 180) {
      faults_.add(angle->offsets[0], "the angle is out of its range; allowed is more than 0 and less than 180 degrees");
    }
    result_.scene.width = readSize(*resolution, 0);
    result_.scene.height = readSize(*resolution, 1);
  }

  int readSize(const Numbers& numbers, size_t i) {
    if (numbers[i] >= 1 && numbers[i] <= kMaxSize && numbers[i] == std::floor(numbers[i])) return int(numbers[i]);
    faults_.add(numbers.offsets[i],
                "not a size in pixels; allowed are whole numbers from 1 to " + std::to_string(kMaxSize));
    return 1;
  }

  TextScanner lines_;
  Diagnostics faults_;
  ParsedScene result_;
  std::future<std::string> hash_;
  bool atLineStart_ = false;  // whether the current line is still to be looked at
  bool hasBackground_ = false;
  bool saidNoMaterial_ = false;
  size_t polygonsWithoutArea_ = 0;
  double conesSoFar_ = 0, conesToCome_ = 0, coneTriangles_ = 0;
  std::vector<size_t> lightsWithoutColor_;
  std::vector<glm::dvec3> corners_, cornerNormals_;  // of the polygon being read; kept for their memory
};

}  // namespace

// Pieces of a cone along its axis. Its strips are slivers, and a sliver that runs across the axes of the world has a
// box as large as the whole cone. Shorter pieces keep the tree of boxes sharp: SPD's rings trace 2.8 times faster by
// four.
int conePieces(double length, double radius) {
  return int(std::clamp(std::round(length / (4 * radius)), 1.0, 8.0));
}

ParsedScene parseNffScene(const std::string& path, std::string_view text) {
  return NffParser(path, text).parse();
}

}  // namespace turner
