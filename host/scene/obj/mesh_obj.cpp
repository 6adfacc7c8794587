// In: the text of an OBJ file. Out: its mesh. What says nothing about the shape is passed over.
#include "scene/obj/mesh_obj.h"

#include <algorithm>
#include <cstdint>
#include <stdexcept>
#include <utility>

#include "base/diagnostics.h"
#include "base/errors.h"
#include "base/number.h"
#include "base/reserve.h"
#include "scene/polygon/polygon.h"
#include "scene/text_scanner.h"

namespace turner {

namespace {

// Statements that do not change the shape of the faces: texture, grouping, display.
const std::vector<std::string> kPassedOver{"vt",     "vp",       "o",        "g",   "s",          "mg",
                                           "usemtl", "mtllib",   "l",        "p",   "bevel",      "usemap",
                                           "maplib", "c_interp", "d_interp", "lod", "shadow_obj", "trace_obj"};
// Statements that do, in ways that Turner does not know: free-form curves and surfaces, also in their older spelling,
// and calls of other files or programs.
const std::vector<std::string> kNotSupported{"cstype", "deg",  "bmat", "step", "curv", "curv2", "surf",
                                             "parm",   "trim", "hole", "scrv", "sp",   "end",   "con",
                                             "bzp",    "bsp",  "cdc",  "cdp",  "res",  "call",  "csh"};

// A file that is not OBJ at all would be wrong in every line; nobody reads further than this.
constexpr size_t kMostFaults = 100;

bool contains(const std::vector<std::string>& words, std::string_view word) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

struct Counts {
  size_t vertices = 0, normals = 0, faces = 0;
};

// How much room the mesh will need: at least, since lines may be indented and faces may have more than three corners.
Counts countStatements(std::string_view text) {
  Counts counts;
  for (size_t at = 0; at + 1 < text.size();) {
    if (text[at] == 'f') {
      ++counts.faces;
    } else if (text[at] == 'v') {
      if (text[at + 1] == 'n') {
        ++counts.normals;
      } else if (text[at + 1] != 't') {
        ++counts.vertices;
      }
    }
    const size_t lineEnd = text.find('\n', at);
    if (lineEnd == std::string_view::npos) break;
    at = lineEnd + 1;
  }
  // A file of lines that are cut off must not take more memory than a right one of its size.
  const size_t most = text.size() / std::string_view("v 0 0 0\n").size();
  return {std::min(counts.vertices, most), std::min(counts.normals, most), std::min(counts.faces, most)};
}

class ObjParser {
 public:
  ObjParser(const std::string& path, std::string_view text)
      : lines_(text, TextScanner::Continuation::backslash), faults_(path, text), size_(text.size()) {
    const Counts counts = countStatements(text);
    reservePrefaulted(mesh_.positions, counts.vertices);
    reservePrefaulted(mesh_.normals, counts.normals);
    reservePrefaulted(mesh_.faces, counts.faces);
  }

  Mesh parse() {
    while (lines_.nextLine()) {
      if (faults_.count() >= kMostFaults) {
        faults_.add(lines_.peek().offset, "too many faults; the rest of the file is not looked at");
        break;
      }
      try {
        parseStatement();
      } catch (const Broken&) {
        // Reported; the next line does not depend on this one.
      }
    }
    if (!hasFaces_ && faults_.empty())
      faults_.add(size_, "the mesh has no faces; at least one 'f' line must stand in it");
    faults_.throwIfAny();
    return std::move(mesh_);
  }

 private:
  // What a fault in a statement throws, to leave it at once.
  struct Broken {};

  struct Corner {
    uint32_t vertex = 0;
    uint32_t normal = UINT32_MAX;
  };

  [[noreturn]] void fail(size_t offset, std::string message) {
    faults_.add(offset, std::move(message));
    throw Broken();
  }

  void parseStatement() {
    const Token word = lines_.next();
    if (word.text == "v") {
      parseVertex();
    } else if (word.text == "vn") {
      parseNormal();
    } else if (word.text == "f") {
      parseFace(word);
    } else if (!contains(kPassedOver, word.text)) {
      failUnknown(word);
    }
  }

  [[noreturn]] void failUnknown(const Token& word) {
    if (contains(kNotSupported, word.text)) {
      fail(word.offset, quoted(word.text) + " is not supported; allowed are meshes of v, vn and f, without free-form " +
                            "curves and surfaces");
    }
    std::vector<std::string> known{"v", "vn", "f"};
    known.insert(known.end(), kPassedOver.begin(), kPassedOver.end());
    const std::string nearest = nearestName(word.text, known);
    fail(word.offset, "unknown statement " + quoted(word.text) +
                          (nearest.empty() ? "" : ", did you mean '" + nearest + "'?") +
                          "; allowed are v, vn, f and what says nothing about the shape (vt, o, g, s, usemtl, ...)");
  }

  glm::dvec3 readVector(const char* form) {
    glm::dvec3 vector;
    for (int i = 0; i < 3; ++i) {
      if (size_t offset; lines_.nextPlainNumber(vector[i], offset)) continue;
      const Token token = lines_.next();
      if (token.text.empty()) {
        fail(token.offset, "found " + std::to_string(i) + (i == 1 ? " number" : " numbers") +
                               ", the line is too short; allowed is " + form);
      }
      std::string wrong = readSceneNumber(token.text, vector[i]);
      if (!wrong.empty()) fail(token.offset, std::move(wrong));
    }
    return vector;
  }

  // The numbers that may stand behind a vertex are passed over: a weight, or a colour, or both.
  void parseVertex() {
    constexpr const char* kForm = "v x y z, a weight or a colour r g b or both behind it";
    mesh_.positions.emplace_back(0);  // even a wrong vertex counts, or the faces would be wrong too
    mesh_.positions.back() = readVector(kForm);
    if (lines_.atLineEnd()) return;
    int extra = 0;
    Token token = lines_.next();
    for (; !token.text.empty() && extra < 4; token = lines_.next(), ++extra) {
      double ignored;
      std::string wrong = readSceneNumber(token.text, ignored);
      if (!wrong.empty()) fail(token.offset, std::move(wrong));
    }
    if (!token.text.empty() || extra == 2) {
      fail(token.offset, std::string("the vertex has too many or too few numbers; allowed is ") + kForm);
    }
  }

  void parseNormal() {
    constexpr const char* kForm = "vn x y z";
    mesh_.normals.emplace_back(0);
    const size_t start = lines_.peek().offset;
    const glm::dvec3 normal = readVector(kForm);
    if (const Token extra = lines_.next(); !extra.text.empty()) {
      fail(extra.offset, "more on the line than expected: " + quoted(extra.text) + "; allowed is " + kForm);
    }
    if (normal == glm::dvec3(0)) fail(start, "a normal must not be 0 0 0");
    mesh_.normals.back() = normal;
  }

  // An index as the file gives it, from 1 or from the end, as an index from 0.
  uint32_t resolve(const Token& place, std::string_view text, size_t count, const char* what) {
    long long index = 0;
    const NumberFault fault = parseInteger(text, index);
    if (fault == NumberFault::notANumber) {
      fail(place.offset,
           quoted(place.text) + " is not a corner; allowed are v, v/vt, v//vn and v/vt/vn, whole numbers");
    }
    const auto known = (long long)count;
    if (fault == NumberFault::none && index != 0 && index >= -known && index <= known) {
      return uint32_t(index > 0 ? index - 1 : known + index);
    }
    const std::string range = known == 0 ? "none stands before this face"
                                         : "allowed are 1 to " + std::to_string(known) + ", and -1 to -" +
                                               std::to_string(known) + " counted back from here";
    fail(place.offset, "there is no " + std::string(what) + " " + quoted(text) + "; " + range);
  }

  // Reads a corner without signs whose indices exist, as almost all are. False for any other.
  bool readPlainCorner(std::string_view text, Corner& corner) const {
    const char* at = text.data();
    const char* const end = at + text.size();
    // An index of a few digits; 0 if there is none.
    const auto readIndex = [&] {
      constexpr std::ptrdiff_t kMostDigits = 9;
      const char* const last = at + std::min(kMostDigits, end - at);
      uint32_t index = 0;
      for (; at != last && *at >= '0' && *at <= '9'; ++at) index = 10 * index + uint32_t(*at - '0');
      return index;
    };
    const uint32_t vertex = readIndex();
    if (vertex == 0 || vertex > mesh_.positions.size()) return false;
    corner = {vertex - 1, UINT32_MAX};
    if (at == end) return true;
    if (*at++ != '/') return false;
    readIndex();  // the texture coordinate is not used
    if (at == end) return true;
    if (*at++ != '/') return false;
    if (at == end) return true;
    const uint32_t normal = readIndex();
    if (at != end || normal == 0 || normal > mesh_.normals.size()) return false;
    corner.normal = normal - 1;
    return true;
  }

  Corner readCorner(const Token& token) {
    if (Corner corner; readPlainCorner(token.text, corner)) return corner;
    std::array<std::string_view, 3> parts;
    size_t count = 0;
    for (std::string_view rest = token.text;; ++count) {
      if (count == parts.size()) {
        fail(token.offset, quoted(token.text) + " is not a corner; allowed are v, v/vt, v//vn and v/vt/vn");
      }
      const size_t slash = rest.find('/');
      parts[count] = rest.substr(0, slash);
      if (slash == std::string_view::npos) break;
      rest.remove_prefix(slash + 1);
    }
    Corner corner;
    corner.vertex = resolve(token, parts[0], mesh_.positions.size(), "vertex");
    // The texture coordinate is not used, but it must be one.
    long long ignored;
    if (!parts[1].empty() && parseInteger(parts[1], ignored) == NumberFault::notANumber) {
      fail(token.offset,
           quoted(token.text) + " is not a corner; allowed are v, v/vt, v//vn and v/vt/vn, whole numbers");
    }
    if (!parts[2].empty()) corner.normal = resolve(token, parts[2], mesh_.normals.size(), "normal");
    return corner;
  }

  void parseFace(const Token& word) {
    hasFaces_ = true;
    corners_.clear();
    for (Token token = lines_.next(); !token.text.empty(); token = lines_.next()) {
      corners_.push_back(readCorner(token));
      if ((corners_.back().normal == UINT32_MAX) != (corners_.front().normal == UINT32_MAX)) {
        fail(token.offset, "some corners of this face have a normal and some have none; allowed is all or none");
      }
    }
    if (corners_.size() < 3) {
      fail(word.offset, "a face of " + std::to_string(corners_.size()) +
                            (corners_.size() == 1 ? " corner" : " corners") + "; allowed are 3 and more");
    }
    if (corners_.size() == 3) {
      addFace(0, 1, 2);
    } else {
      for (const auto& [a, b, c] : triangulate(word)) addFace(a, b, c);
    }
  }

  void addFace(uint32_t a, uint32_t b, uint32_t c) {
    const Corner &first = corners_[a], &second = corners_[b], &third = corners_[c];
    mesh_.faces.push_back({{first.vertex, second.vertex, third.vertex}, {first.normal, second.normal, third.normal}});
  }

  std::vector<std::array<uint32_t, 3>> triangulate(const Token& word) {
    positions_.clear();
    for (const Corner& corner : corners_) positions_.push_back(mesh_.positions[corner.vertex]);
    try {
      return triangulatePolygon(positions_);
    } catch (const std::invalid_argument& reason) {
      // A vertex that is wrong itself stands at the origin for now: what becomes of its faces says nothing.
      if (!faults_.empty()) throw Broken();
      fail(word.offset, std::string(reason.what()) + "; allowed are polygons whose edges meet at corners only");
    }
  }

  TextScanner lines_;
  Diagnostics faults_;
  size_t size_;
  bool hasFaces_ = false;
  Mesh mesh_;
  std::vector<Corner> corners_;        // of the face being read; kept for their memory
  std::vector<glm::dvec3> positions_;  // likewise
};

}  // namespace

Mesh parseObj(const std::string& path, std::string_view text) {
  return ObjParser(path, text).parse();
}

}  // namespace turner
