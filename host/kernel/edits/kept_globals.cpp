// Declarations as their tokens show them: of a line of the edit, outside of braces.
#include "kernel/edits/kept_globals.h"

#include <glslang/SPIRV/spirv.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>
#include <string_view>

#include "base/errors.h"
#include "kernel/edits/parameters.h"
#include "kernel/glsl_tokens.h"
#include "kernel/source_names.h"
#include "kernel/spirv_module.h"
#include "layout.h"

namespace turner {
namespace {

struct Global {
  std::string name;
  std::string type;
  bool isArray = false;
  size_t offset = 0;
};

// Components of the types that are kept.
int componentsOf(std::string_view type) {
  static const std::map<std::string_view, int> components = {
      {"bool", 1},  {"int", 1},   {"uint", 1},  {"float", 1}, {"vec2", 2},  {"vec3", 3},  {"vec4", 4},  {"ivec2", 2},
      {"ivec3", 3}, {"ivec4", 4}, {"uvec2", 2}, {"uvec3", 3}, {"uvec4", 4}, {"bvec2", 2}, {"bvec3", 3}, {"bvec4", 4}};
  const auto found = components.find(type);
  return found == components.end() ? 0 : found->second;
}

// What a declaration begins with of no variable that an invocation has for itself, or of one that cannot change.
bool isOther(std::string_view word) {
  static const std::set<std::string_view> words = {"const", "layout", "uniform",  "buffer",    "shared",   "in",
                                                   "out",   "struct", "readonly", "writeonly", "coherent", "PARAM"};
  return words.contains(word);
}

bool isQualifier(std::string_view word) {
  return word == "precise" || word == "highp" || word == "mediump" || word == "lowp";
}

// The variables that a source declares outside of functions. Macros are not expanded.
std::vector<Global> globalsOf(std::string_view text) {
  std::vector<Global> globals;
  std::vector<GlslToken> tokens = readGlslTokens(text);
  std::erase_if(tokens, [](const GlslToken& token) { return token.kind == GlslKind::directive; });
  const auto is = [&](size_t i, std::string_view what) { return i < tokens.size() && tokens[i].text == what; };
  const auto isWord = [&](size_t i) { return i < tokens.size() && tokens[i].kind == GlslKind::word; };
  const auto depthOf = [&](size_t i) {
    return int(is(i, "(") || is(i, "[") || is(i, "{")) - int(is(i, ")") || is(i, "]") || is(i, "}"));
  };
  for (size_t at = 0; at < tokens.size();) {
    // A statement outside of braces: up to its semicolon, or to its closing brace if it has a body.
    size_t end = at;
    bool hasBody = false;
    for (int depth = 0; end < tokens.size(); ++end) {
      depth += depthOf(end);
      hasBody = depth == 0 && is(end, "}");
      if (hasBody || (depth == 0 && is(end, ";"))) break;
    }
    const size_t next = end + 1;
    while (isWord(at) && isQualifier(tokens[at].text)) ++at;
    size_t name = at + 1;
    // vec3[2] a
    const bool isArrayType = is(name, "[");
    while (isArrayType && name < end && !isWord(name)) ++name;
    const bool declares = !hasBody && isWord(at) && !isOther(tokens[at].text) && isWord(name) && !is(name + 1, "(");
    // Names stand behind the type, and behind commas outside of brackets.
    int depth = 0;
    for (size_t i = name; declares && i <= end; ++i) {
      depth += depthOf(i);
      if (depth > 0 || !(is(i, ",") || i == end)) continue;
      globals.push_back({std::string(tokens[name].text), std::string(tokens[at].text), isArrayType || is(name + 1, "["),
                         tokens[name].offset});
      name = i + 1;
    }
    at = next;
  }
  return globals;
}

std::set<std::string> globalNames(const std::vector<ShaderSource>& sources) {
  std::set<std::string> names;
  for (const ShaderSource& source : sources) {
    if (!source.text) continue;
    for (const Global& global : globalsOf(*source.text)) names.insert(global.name);
  }
  return names;
}

constexpr char kRemedy[] =
    ", which is not kept where the work of a pixel is cut into several dispatches; declare it in the function that "
    "uses "
    "it, or as bool, int, uint, float or vectors of these, without a macro";

}  // namespace

std::string keptGlobalsPreamble(const std::vector<ShaderSource>& shipped, const std::vector<ShaderSource>& edited) {
  // What the kernel itself declares is kept, or computed anew.
  const std::set<std::string> known = globalNames(shipped);
  std::vector<std::string> scalars;
  for (const ShaderSource& source : edited) {
    const ShaderSource* const before = findSource(shipped, source.name);
    if (!source.text || (before && before->text == source.text)) continue;
    for (const Global& global : globalsOf(*source.text)) {
      if (known.contains(global.name)) continue;
      const int components = global.isArray ? 0 : componentsOf(global.type);
      if (components == 0)
        throw InputError(faultAt(locationAt(source, global.offset)) + global.name + " is " +
                         (global.isArray ? "an array" : "a " + global.type) + kRemedy);
      if (components == 1) scalars.push_back(global.name);
      for (int i = 0; components > 1 && i < components; ++i) scalars.push_back(global.name + '.' + "xyzw"[i]);
      if (scalars.size() > 4 * gpu::kEditWords)
        throw InputError(
            faultAt({source.path}) +
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

void checkGlobals(std::span<const uint32_t> words, const std::vector<ShaderSource>& shipped,
                  const std::vector<ShaderSource>& edited) {
  std::set<std::string> known = globalNames(shipped);
  for (const ShaderSource& source : edited) {
    if (!source.text) continue;
    for (const Global& global : globalsOf(*source.text)) known.insert(global.name);
  }
  std::vector<Parameter> parameters = readParameters(edited).parameters;
  for (const Parameter& parameter : parameters) known.insert(parameter.name);
  const SpirvModule module = readSpirvModule(words);
  for (const uint32_t variable : module.variables) {
    const std::string name = module.name(variable);
    if (module.definition(variable).operand(2) != spv::StorageClassPrivate || name.empty() || known.contains(name))
      continue;
    if (name == "editPadding") continue;
    throw InputError(faultAt(findDeclaration(edited, {name})) + name + " is a global variable that a macro declares" +
                     kRemedy);
  }
}

}  // namespace turner
