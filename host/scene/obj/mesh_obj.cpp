// In: the text of an OBJ file. Out: its mesh. What says nothing about the shape is passed over; what is wrong and only
// shades, or belongs to no face, is counted in notes.
#include "scene/obj/mesh_obj.h"

#include <algorithm>
#include <cstdint>
#include <optional>
#include <utility>

#include "base/diagnostics.h"
#include "base/errors.h"
#include "base/number.h"
#include "base/reserve.h"
#include "scene/counted_notes.h"
#include "scene/obj/face_corner.h"
#include "scene/obj/obj_notes.h"
#include "scene/obj/obj_words.h"
#include "scene/obj/statement_counts.h"
#include "scene/plain_text.h"
#include "scene/polygon/polygon.h"
#include "scene/text_scanner.h"

namespace turner {

using namespace obj;

namespace {

// A file that is not OBJ at all would be wrong in every line; nobody reads further than this.
constexpr size_t kMostFaults = 100;

class ObjParser {
 public:
  ObjParser(const std::string& path, std::string_view text)
      : text_(text), lines_(text, kContinuation), faults_(path, text), notes_(path, text) {
    const StatementCounts counts = countStatements(text);
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
    if (!hasFaces_ && faults_.empty()) failWithoutFaces();
    faults_.throwIfAny();
    for (const UnusableVertex& vertex : unusable_) {
      if (!vertex.isTold) notes_.add(kUnusedVertices, vertex.offset);
    }
    mesh_.notes = notes_.lines();
    return std::move(mesh_);
  }

 private:
  static constexpr TextScanner::Continuation kContinuation = TextScanner::Continuation::backslash;

  // What a fault in a statement throws, to leave it at once.
  struct Broken {};
  struct Fault {
    size_t offset;
    std::string message;
  };

  // A vertex that is no three numbers: a fault once a face has it.
  struct UnusableVertex {
    size_t offset;  // of its statement
    uint32_t index;
    bool isTold = false;
  };

  [[noreturn]] void fail(size_t offset, std::string message) {
    faults_.add(offset, std::move(message));
    throw Broken();
  }

  void failWithoutFaces() {
    if (firstUnknown_) {
      faults_.add(firstUnknown_->offset, "unknown statement " + quoted(firstUnknown_->text) +
                                             ", and no faces in the whole file; a mesh has lines v x y z and f 1 2 3");
    } else {
      faults_.add(text_.size(), "the mesh has no faces; at least one 'f' line of 3 corners must stand in it");
    }
  }

  void parseStatement() {
    const Token word = lines_.next();
    const bool continues = std::exchange(passedOverContinues_, false);
    if (word.text == "v") {
      parseVertex(word);
    } else if (word.text == "vn") {
      parseNormal(word);
    } else if (word.text == "f" || word.text == "fo") {  // fo: the same in old files
      parseFace(word);
    } else {
      passOver(word, continues);
    }
  }

  // What is passed over ends with its line. A backslash at its end may belong to a name; where it does not, the next
  // line is unknown, and belongs to this one.
  void passOver(const Token& word, bool continuesLast) {
    switch (kindOf(word.text)) {
      case WordKind::passedOver:
        break;
      case WordKind::material:
        notes_.add(kMaterialLines, word.offset);
        break;
      case WordKind::notSupported:
        fail(word.offset, quoted(word.text) +
                              " is not supported; allowed are meshes of v, vn and f, without free-form " +
                              "curves and surfaces");
      case WordKind::miswritten:
        fail(word.offset, "unknown statement " + quoted(word.text) + ", did you mean '" + nearestWord(word.text) +
                              "'?; capital letters count");
      case WordKind::unknown:
        if (!continuesLast) noteUnknown(word);
    }
    passedOverContinues_ = lines_.passRest();
  }

  void noteUnknown(const Token& word) {
    if (firstUnknown_) return notes_.add(kUnknown, word.offset);
    firstUnknown_ = word;
    const std::string nearest = nearestWord(word.text);
    notes_.add(kUnknown, word.offset, quoted(word.text) + (nearest.empty() ? "" : ", did you mean '" + nearest + "'?"));
  }

  // Reads three numbers; what is wrong with them, if anything is.
  static std::optional<Fault> readVector(TextScanner& lines, const char* form, glm::dvec3& vector) {
    for (int i = 0; i < 3; ++i) {
      if (size_t offset; lines.nextPlainNumber(vector[i], offset)) continue;
      const Token token = lines.next();
      if (token.text.empty()) {
        return Fault{token.offset, "found " + std::to_string(i) + (i == 1 ? " number" : " numbers") +
                                       ", the line is too short; allowed is " + form};
      }
      std::string wrong = readSceneNumber(token.text, vector[i]);
      if (!wrong.empty()) return Fault{token.offset, std::move(wrong)};
    }
    return std::nullopt;
  }

  static constexpr const char* kVertexForm = "v x y z, a weight or a colour r g b or both behind it";

  void parseVertex(const Token& word) {
    mesh_.positions.emplace_back(0);  // even a wrong vertex counts, or the faces would be wrong too
    if (readVector(lines_, kVertexForm, mesh_.positions.back())) {
      unusable_.push_back({word.offset, uint32_t(mesh_.positions.size() - 1)});
      return;
    }
    if (!lines_.atLineEnd()) passVertexExtras(word);
  }

  // The numbers that may stand behind a vertex are passed over: a weight, or a colour, or both.
  void passVertexExtras(const Token& vertex) {
    int extra = 0;
    bool areNumbers = true;
    for (Token token = lines_.next(); !token.text.empty(); token = lines_.next(), ++extra) {
      if (token.text == "v" || token.text == "vn" || token.text == "f") {
        fail(token.offset, quoted(token.text) + " begins a statement; it must stand on a line of its own");
      }
      double ignored;
      areNumbers &= parseNumber(token.text, ignored) == NumberFault::none;
    }
    if (!areNumbers || extra == 2 || extra > 4) notes_.add(kVertexExtras, vertex.offset);
  }

  void parseNormal(const Token& word) {
    mesh_.normals.emplace_back(0);
    glm::dvec3 normal;
    if (readVector(lines_, "vn x y z", normal) || normal == glm::dvec3(0)) {
      hasNormalsWithoutDirection_ = true;
      notes_.add(kNoDirection, word.offset);
      return;
    }
    mesh_.normals.back() = normal;
    if (!lines_.atLineEnd()) notes_.add(kNormalExtras, word.offset);
  }

  static constexpr const char* kCornerForms = " is not a corner; allowed are v, v/vt, v//vn and v/vt/vn, whole numbers";

  uint32_t resolveVertex(const Token& place, std::string_view text) {
    const size_t count = mesh_.positions.size();
    const uint32_t vertex = resolveIndex(text, count);
    if (vertex != kNoIndex) return vertex;
    long long ignored;
    if (parseInteger(text, ignored) == NumberFault::notANumber) fail(place.offset, quoted(place.text) + kCornerForms);
    const std::string known = std::to_string(count);
    fail(place.offset,
         "there is no vertex " + quoted(text) + "; " +
             (count == 0 ? "none stands before this face"
                         : "allowed are 1 to " + known + ", and -1 to -" + known + " counted back from here"));
  }

  // A normal that does not exist is none. The texture coordinate is not looked at.
  FaceCorner readCorner(const Token& token) {
    if (FaceCorner corner; readPlainCorner(token.text, mesh_.positions.size(), mesh_.normals.size(), corner))
      return corner;
    std::array<std::string_view, 3> parts;
    size_t count = 0;
    for (std::string_view rest = token.text;; ++count) {
      if (count == parts.size()) fail(token.offset, quoted(token.text) + kCornerForms);
      const size_t slash = rest.find('/');
      parts[count] = rest.substr(0, slash);
      if (slash == std::string_view::npos) break;
      rest.remove_prefix(slash + 1);
    }
    FaceCorner corner;
    corner.vertex = resolveVertex(token, parts[0]);
    if (!parts[2].empty()) {
      corner.normal = resolveIndex(parts[2], mesh_.normals.size());
      lacksNormal_ |= corner.normal == kNoIndex;
    }
    return corner;
  }

  void parseFace(const Token& word) {
    corners_.clear();
    lacksNormal_ = false;
    for (Token token = lines_.next(); !token.text.empty(); token = lines_.next()) {
      corners_.push_back(readCorner(token));
      lacksNormal_ |= (corners_.back().normal == kNoIndex) != (corners_.front().normal == kNoIndex);
    }
    if (corners_.size() < 3) return notes_.add(kFewCorners, word.offset);
    hasFaces_ = true;
    if (!unusable_.empty()) refuseUnusableVertices();
    if (lacksNormal_) notes_.add(kNormalsMissing, word.offset);
    if (lacksNormal_ || (hasNormalsWithoutDirection_ && hasNormalWithoutDirection())) {
      for (FaceCorner& corner : corners_) corner.normal = kNoIndex;
    }
    if (corners_.size() == 3) {
      addFace(0, 1, 2);
    } else {
      addPolygon(word);
    }
  }

  bool hasNormalWithoutDirection() const {
    return std::any_of(corners_.begin(), corners_.end(), [&](const FaceCorner& corner) {
      return corner.normal != kNoIndex && mesh_.normals[corner.normal] == glm::dvec3(0);
    });
  }

  // Tells of each such vertex once.
  void refuseUnusableVertices() {
    bool isBroken = false;
    for (const FaceCorner& corner : corners_) {
      const auto found = std::lower_bound(unusable_.begin(), unusable_.end(), corner.vertex,
                                          [](const UnusableVertex& v, uint32_t index) { return v.index < index; });
      if (found == unusable_.end() || found->index != corner.vertex) continue;
      isBroken = true;
      if (!std::exchange(found->isTold, true)) addFaultOf(found->offset);
    }
    if (isBroken) throw Broken();
  }

  // Reads a vertex again, to tell what is wrong with it.
  void addFaultOf(size_t vertex) {
    TextScanner line(text_.substr(vertex), kContinuation);
    line.nextLine();
    line.next();
    glm::dvec3 ignored;
    if (std::optional<Fault> fault = readVector(line, kVertexForm, ignored))
      faults_.add(vertex + fault->offset, std::move(fault->message));
  }

  void addFace(uint32_t a, uint32_t b, uint32_t c) {
    const FaceCorner &first = corners_[a], &second = corners_[b], &third = corners_[c];
    mesh_.faces.push_back({{first.vertex, second.vertex, third.vertex}, {first.normal, second.normal, third.normal}});
  }

  void addPolygon(const Token& word) {
    positions_.clear();
    for (const FaceCorner& corner : corners_) positions_.push_back(mesh_.positions[corner.vertex]);
    const CutPolygon polygon = triangulatePolygon(positions_);
    if (polygon.crossesItself) notes_.add(kCrossing, word.offset);
    if (polygon.triangles.empty()) notes_.add(kNoArea, word.offset);
    for (const auto& [a, b, c] : polygon.triangles) addFace(a, b, c);
  }

  std::string_view text_;
  TextScanner lines_;
  Diagnostics faults_;
  CountedNotes notes_;
  Mesh mesh_;
  bool hasFaces_ = false;
  bool hasNormalsWithoutDirection_ = false;
  bool passedOverContinues_ = false;      // the last statement was passed over and ended in a backslash
  std::optional<Token> firstUnknown_;     // statement
  std::vector<UnusableVertex> unusable_;  // by index
  std::vector<FaceCorner> corners_;       // of the face being read; kept for their memory
  bool lacksNormal_ = false;              // of the face being read, at some corners
  std::vector<glm::dvec3> positions_;     // likewise
};

}  // namespace

Mesh parseObj(const std::string& path, std::string_view bytes) {
  const PlainText text(path, bytes);
  return ObjParser(path, text.view()).parse();
}

}  // namespace turner
