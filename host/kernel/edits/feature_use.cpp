// A pass over the tokens of each edited file, statement by statement. Macros are not expanded.
#include "kernel/edits/feature_use.h"

#include <algorithm>
#include <bit>
#include <map>
#include <string_view>

#include "kernel/edits/source_edit.h"
#include "layout.h"

namespace turner {
namespace {

// Bit i stands for the constant with id i.
using Set = uint32_t;

Set featureOf(std::string_view word) {
  constexpr Set kHighlights = 1u << gpu::kSpecHighlights, kReflection = 1u << gpu::kSpecReflection,
                kRefraction = 1u << gpu::kSpecRefraction, kFalloff = 1u << gpu::kSpecFalloff;
  static const std::map<std::string_view, Set> words = {
      {"HIGHLIGHTS", kHighlights},  {"specular", kHighlights},      {"shininess", kHighlights},
      {"powOneMinus", kHighlights}, {"REFLECTION", kReflection},    {"reflectance", kReflection},
      {"reflection", kReflection},  {"mirrored", kReflection},      {"kReflected", kReflection},
      {"REFRACTION", kRefraction},  {"transmittance", kRefraction}, {"transmission", kRefraction},
      {"refracted", kRefraction},   {"etaBehind", kRefraction},     {"kRefracted", kRefraction},
      {"pushRay", kRefraction},     {"popRay", kRefraction},        {"FALLOFF", kFalloff},
      {"falloff", kFalloff},
  };
  const auto found = words.find(word);
  return found == words.end() ? 0 : found->second;
}

class Reader {
 public:
  Reader(const EditedFile& file, std::vector<FeatureUse>& uses) : file_(file), uses_(uses) {}

  void read() {
    const std::vector<GlslToken>& tokens = file_.tokens;
    for (size_t i = 0; i < tokens.size(); ++i) {
      const std::string_view text = tokens[i].text;
      if (tokens[i].kind == GlslKind::directive) {
        Set set = 0;
        for (const GlslToken& word : readGlslTokens(text.substr(1))) set |= featureOf(word.text);
        note(i, i + 1, set);
        begin_ = i + 1;
        continue;
      }
      if (text == "(" || text == "[") ++depth_;
      if (text == ")" || text == "]") --depth_;
      if (depth_ > 0) continue;
      if (text == "{") open(i);
      if (text == "}") close(i);
      if (text == ";") end(i);
    }
  }

 private:
  // What the tokens [begin_, i] name.
  Set named(size_t i) const {
    Set set = 0;
    for (size_t j = begin_; j <= i; ++j) {
      const std::string_view text = file_.tokens[j].text;
      set |= featureOf(text);
      if (const auto found = meanings_.find(text); found != meanings_.end()) set |= found->second;
    }
    return set;
  }

  bool beginsWithElse() const { return begin_ < file_.tokens.size() && file_.tokens[begin_].text == "else"; }
  Set around() const { return blocks_.empty() ? 0 : blocks_.back(); }
  // What leads to the statement that begins here.
  Set leading() const { return around() | (beginsWithElse() ? before_ : 0); }

  void open(size_t i) {
    const Set set = leading() | named(i);
    note(begin_, i + 1, set);
    if (blocks_.empty()) meanings_.clear();
    blocks_.push_back(set);
    before_ = 0;
    begin_ = i + 1;
  }

  void close(size_t i) {
    note(begin_, i + 1, around());
    before_ = around();
    if (!blocks_.empty()) blocks_.pop_back();
    begin_ = i + 1;
  }

  void end(size_t i) {
    const Set set = leading() | named(i);
    note(begin_, i + 1, set);
    // A variable stands for what its value depends on.
    for (size_t j = begin_; j + 1 <= i; ++j)
      if (file_.tokens[j + 1].text == "=" && file_.tokens[j].kind == GlslKind::word)
        meanings_[file_.tokens[j].text] = set;
    before_ = set;
    begin_ = i + 1;
  }

  // These tokens are about the features; if one was edited, they are used.
  void note(size_t begin, size_t end, Set set) {
    if (set == 0 || !(file_.isChanged(begin, end) || file_.isCutBefore(begin))) return;
    for (; set != 0; set &= set - 1) {
      const uint32_t constant = uint32_t(std::countr_zero(set));
      const bool known =
          std::any_of(uses_.begin(), uses_.end(), [&](const FeatureUse& use) { return use.constant == constant; });
      if (!known) uses_.push_back({constant, {file_.path, file_.tokens[begin].line, file_.tokens[begin].column}});
    }
  }

  const EditedFile& file_;
  std::vector<FeatureUse>& uses_;
  std::map<std::string_view, Set> meanings_;  // of the function's variables
  std::vector<Set> blocks_;                   // what leads into each of the open blocks
  Set before_ = 0;                            // of the statement before
  size_t begin_ = 0;                          // of the statement
  int depth_ = 0;                             // of parentheses
};

}  // namespace

std::vector<FeatureUse> featuresUsed(const std::vector<ShaderSource>& shipped,
                                     const std::vector<ShaderSource>& edited) {
  std::vector<FeatureUse> uses;
  for (const EditedFile& file : editedFiles(shipped, edited)) Reader(file, uses).read();
  return uses;
}

std::string geometryWarnings(const std::vector<ShaderSource>& shipped, const std::vector<ShaderSource>& edited) {
  std::string warnings;
  for (const EditedFile& file : editedFiles(shipped, edited)) {
    const std::vector<GlslToken>& tokens = file.tokens;
    for (size_t i = 1; i + 1 < tokens.size(); ++i) {
      static constexpr std::string_view kReaders[] = {"nodeAt",         "sphereAt",   "nearSphereAt", "coneAt",
                                                      "trianglePairAt", "planeAt",    "faceAt",       "coarseCellAt",
                                                      "fineCellAt",     "listEntryAt"};
      const bool isReader = std::find(std::begin(kReaders), std::end(kReaders), tokens[i].text) != std::end(kReaders);
      // A definition: a type before it, a body behind its parameters.
      if (!isReader || tokens[i - 1].kind != GlslKind::word || tokens[i - 1].text == "return") continue;
      size_t end = i;
      for (int depth = 0; end < tokens.size(); ++end) {
        if (tokens[end].text == "{") ++depth;
        if (tokens[end].text == "}" && --depth == 0) break;
      }
      if (!file.isChanged(i, end)) continue;
      warnings +=
          file.path + ':' + std::to_string(tokens[i].line) + ": warning: " + std::string(tokens[i].text) +
          "() is edited; tree and lists are those of the geometry in the scene, and what is moved here is missed "
          "where it went: move it in the scene\n";
    }
  }
  return warnings;
}

}  // namespace turner
