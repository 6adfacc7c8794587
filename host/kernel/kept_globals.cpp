// Declarations as their tokens show them: of a line of the edit, outside of braces.
#include "kernel/kept_globals.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>
#include <string_view>

#include "base/errors.h"
#include "kernel/glsl_tokens.h"
#include "kernel/source_names.h"
#include "layout.h"

namespace turner {
namespace {

struct Global {
  std::string name;
  int components = 1;
};

// Components of the types that are kept.
int componentsOf(std::string_view type) {
  static const std::map<std::string_view, int> components = {
      {"bool", 1},  {"int", 1},   {"uint", 1},  {"float", 1}, {"vec2", 2},  {"vec3", 3},  {"vec4", 4},  {"ivec2", 2},
      {"ivec3", 3}, {"ivec4", 4}, {"uvec2", 2}, {"uvec3", 3}, {"uvec4", 4}, {"bvec2", 2}, {"bvec3", 3}, {"bvec4", 4}};
  const auto found = components.find(type);
  return found == components.end() ? 0 : found->second;
}

// What a declaration of no variable that an invocation has for itself begins with, or of one that cannot change.
bool isOther(std::string_view word) {
  static const std::set<std::string_view> words = {"const",  "layout", "uniform", "buffer",  "shared", "in",
                                                   "out",    "struct", "void",    "precise", "PARAM",  "readonly",
                                                   "writeonly", "invariant"};
  return words.contains(word);
}

// The variables that a source declares outside of functions. Throws InputError at one that cannot be kept, if it is not
// among the known ones.
std::vector<Global> globalsOf(const ShaderSource& source, const std::set<std::string>& known) {
  std::vector<Global> globals;
  std::vector<GlslToken> tokens = readGlslTokens(*source.text);
  std::erase_if(tokens, [](const GlslToken& token) { return token.kind == GlslKind::directive; });
  const auto is = [&](size_t i, std::string_view text) { return i < tokens.size() && tokens[i].text == text; };
  for (size_t at = 0; at < tokens.size();) {
    // A statement outside of braces: up to its semicolon, or to its closing brace if it has a body.
    size_t end = at;
    bool hasBody = false;
    for (int depth = 0; end < tokens.size(); ++end) {
      if (is(end, "{") || is(end, "(") || is(end, "[")) ++depth;
      if (is(end, "}") || is(end, ")") || is(end, "]")) --depth;
      if (depth == 0 && is(end, "}")) hasBody = true;
      if (depth == 0 && (is(end, ";") || hasBody)) break;
    }
    const bool declares = !hasBody && end > at + 1 && tokens[at].kind == GlslKind::word && !isOther(tokens[at].text) &&
                          tokens[at + 1].kind == GlslKind::word && !is(at + 2, "(");
    if (declares) {
      const int components = componentsOf(tokens[at].text);
      // Names stand behind the type and behind commas outside of brackets.
      size_t name = at + 1;
      for (int depth = 0, i = int(name); size_t(i) <= end; ++i) {
        const size_t token = size_t(i);
        if (is(token, "(") || is(token, "[") || is(token, "{")) ++depth;
        if (is(token, ")") || is(token, "]") || is(token, "}")) --depth;
        if (depth > 0 || !(is(token, ",") || token == end)) continue;
        const std::string text(tokens[name].text);
        if (!known.contains(text)) {
          if (components == 0 || is(name + 1, "["))
            throw InputError(faultAt(locationAt(source, tokens[name].offset)) + text + " is " +
                             (components == 0 ? "a " + std::string(tokens[at].text) : "an array") +
                             ", which is not kept where the work of a pixel is cut into several dispatches; declare it "
                             "in the function that uses it, or as bool, int, uint, float or vectors of these");
          globals.push_back({text, components});
        } else {
          globals.push_back({text, 0});
        }
        name = token + 1;
      }
    }
    at = end + 1;
  }
  return globals;
}

}  // namespace

std::string keptGlobalsPreamble(const std::vector<ShaderSource>& shipped, const std::vector<ShaderSource>& edited) {
  // All that the kernel itself declares is kept, or computed anew.
  std::set<std::string> known;
  for (const ShaderSource& source : shipped)
    for (const GlslToken& token : readGlslTokens(*source.text))
      if (token.kind == GlslKind::word) known.emplace(token.text);
  std::vector<std::string> scalars;
  for (const ShaderSource& source : edited) {
    const ShaderSource* const before = findSource(shipped, source.name);
    if (!source.text || (before && before->text == source.text)) continue;
    for (const Global& global : globalsOf(source, known)) {
      if (global.components == 1) scalars.push_back(global.name);
      for (int i = 0; global.components > 1 && i < global.components; ++i)
        scalars.push_back(global.name + '.' + "xyzw"[i]);
      if (scalars.size() > 4 * gpu::kEditWords)
        throw InputError(faultAt({source.path}) +
                         fmt::format("the edit's global variables have more than {} numbers, as many as are kept where the "
                                     "work of a pixel is cut into several dispatches; declare some in functions",
                                     4 * gpu::kEditWords));
    }
  }
  std::string preamble = "#define EDIT_STATE(KEEP)";
  while (scalars.size() % 4 != 0) scalars.push_back("editPadding");
  for (size_t i = 0; i < scalars.size(); i += 4)
    preamble += fmt::format(" KEEP(editWord({}u), {}, {}, {}, {})", i / 4, scalars[i], scalars[i + 1], scalars[i + 2],
                            scalars[i + 3]);
  return preamble + "\n";
}

}  // namespace turner
