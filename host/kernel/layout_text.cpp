// Knows how layout.h and interface.h are written: TURNER_CONST a = 1u, b = 2u; struct Name { Type a, b[2]; }; and
// TURNER_FEATURE(Name, ...).
#include "kernel/layout_text.h"

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstdlib>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "base/errors.h"
#include "kernel/glsl_tokens.h"
#include "kernel/host_interface.h"
#include "kernel/source_names.h"
#include "layout_text_of_host.h"

namespace turner {
namespace {

struct Words {
  std::vector<std::string> words;
  size_t offset = 0;  // of what they tell
  bool operator==(const Words& other) const { return words == other.words; }
};

struct Structure {
  std::vector<Words> members;  // each with its type: "uint", "x0"
  size_t end = 0;              // offset of its closing brace
};

// What a layout declares by its names. A name may be declared more than once, for different preprocessors.
struct Layout {
  std::multimap<std::string, Words> constants;
  std::multimap<std::string, Structure> structures;
};

// 4u, 4, 0x4u and 04 are all 4.
std::optional<uint64_t> plainInteger(std::string_view word) {
  std::string digits(word);
  if (!digits.empty() && (digits.back() == 'u' || digits.back() == 'U')) digits.pop_back();
  if (digits.empty() || digits[0] < '0' || digits[0] > '9') return std::nullopt;
  char* end = nullptr;
  errno = 0;
  const uint64_t value = std::strtoull(digits.c_str(), &end, 0);
  if (*end || errno) return std::nullopt;
  return value;
}

// One spelling for all of one value where a number stands alone.
std::string spelling(std::string_view word) {
  const std::optional<uint64_t> value = plainInteger(word);
  return value ? std::to_string(*value) : std::string(word);
}

std::string textOf(const Words& words) {
  std::string text;
  for (const std::string& word : words.words) {
    const bool joins = text.empty() || word == "[" || word == "]" || text.back() == '[';
    text += (joins ? "" : " ") + word;
  }
  return text;
}

// The tokens without the lines of the preprocessor.
std::vector<GlslToken> declaringTokens(std::string_view text) {
  std::vector<GlslToken> tokens = readGlslTokens(text);
  std::erase_if(tokens, [](const GlslToken& token) { return token.kind == GlslKind::directive; });
  return tokens;
}

// Gathers from `at` on up to one of `ends` outside of brackets, and passes nothing of the end.
Words gather(std::span<const GlslToken> tokens, size_t& at, std::string_view ends) {
  Words words;
  if (at < tokens.size()) words.offset = tokens[at].offset;
  for (int depth = 0; at < tokens.size(); ++at) {
    const std::string_view text = tokens[at].text;
    if (depth == 0 && text.size() == 1 && ends.find(text[0]) != std::string_view::npos) break;
    if (text == "(" || text == "[" || text == "{") ++depth;
    if (text == ")" || text == "]" || text == "}") --depth;
    words.words.emplace_back(text);
  }
  return words;
}

// From behind the opening brace up to the closing one: uint x0, y0; is uint x0; uint y0;
Structure readStructure(std::span<const GlslToken> tokens, size_t& at) {
  Structure structure;
  while (at < tokens.size() && tokens[at].text != "}") {
    const size_t first = at;
    Words member = gather(tokens, at, ",;}");
    if (member.words.empty()) {
      ++at;  // a stray comma or semicolon
      continue;
    }
    const std::string type = member.words[0];
    member.offset = tokens[first + (member.words.size() > 1 ? 1 : 0)].offset;
    for (;;) {
      for (std::string& word : member.words) word = spelling(word);
      structure.members.push_back(member);
      if (at >= tokens.size() || tokens[at].text != ",") break;
      member = gather(tokens, ++at, ",;}");
      member.words.insert(member.words.begin(), type);
    }
    if (at < tokens.size() && tokens[at].text == ";") ++at;
  }
  if (at < tokens.size()) structure.end = tokens[at].offset;
  return structure;
}

// kUpperCamel, as all constants are called: other names belong to functions.
bool isConstantName(std::string_view name) {
  return name.size() > 1 && name[0] == 'k' && name[1] >= 'A' && name[1] <= 'Z';
}

Layout readLayout(std::string_view text) {
  Layout layout;
  const std::vector<GlslToken> tokens = declaringTokens(text);
  for (size_t at = 0; at + 2 < tokens.size(); ++at) {
    if (tokens[at].text == "struct" && tokens[at + 1].kind == GlslKind::word && tokens[at + 2].text == "{") {
      const std::string name(tokens[at + 1].text);
      layout.structures.emplace(name, readStructure(tokens, at += 3));
    } else if (tokens[at].text.starts_with("TURNER_") && tokens[at + 1].text == "(") {
      // A line of interface.h, by the name that it begins with.
      const GlslToken& name = tokens[at + 2];
      Words line{{}, name.offset};
      for (; at < tokens.size() && tokens[at].text != ")"; ++at) line.words.emplace_back(tokens[at].text);
      line.words.emplace_back(")");
      layout.constants.emplace(name.text, line);
    } else if (isConstantName(tokens[at].text) && tokens[at + 1].text == "=") {
      // However it is declared: const uint a = 1u; is the same to the kernel as TURNER_CONST.
      const GlslToken& name = tokens[at];
      Words value = gather(tokens, at += 2, ",;");
      value.offset = name.offset;
      layout.constants.emplace(name.text, value);
    }
  }
  for (const GlslToken& token : readGlslTokens(text)) {
    if (directiveName(token) != "define") continue;
    // #define a 1u declares a constant too: the name and the value are the words behind.
    const std::vector<GlslToken> words = readGlslTokens(token.text.substr(token.text.find("define")));
    if (words.size() < 2 || !isConstantName(words[1].text)) continue;
    Words value;
    value.offset = token.offset;
    for (size_t i = 2; i < words.size(); ++i) value.words.emplace_back(words[i].text);
    layout.constants.emplace(words[1].text, value);
  }
  return layout;
}

bool areSame(const Words& a, const Words& b) {
  if (a.words.size() != 1 || b.words.size() != 1) return a == b;
  return spelling(a.words[0]) == spelling(b.words[0]);
}

// The first difference between a structure and the host's, as a fault's text with its offset.
std::optional<std::pair<size_t, std::string>> difference(const std::string& name, const Structure& here,
                                                         const Structure& host) {
  for (size_t i = 0; i < here.members.size() || i < host.members.size(); ++i) {
    const auto quoted = [&](const Structure& structure) { return "'" + textOf(structure.members[i]) + "'"; };
    if (i >= host.members.size())
      return {{here.members[i].offset, "struct " + name + " has " + quoted(here) + " here, but ends before it"}};
    if (i >= here.members.size()) return {{here.end, "struct " + name + " ends here, but has " + quoted(host)}};
    if (here.members[i] != host.members[i])
      return {{here.members[i].offset, "struct " + name + " has " + quoted(here) + " here, but " + quoted(host)}};
  }
  return std::nullopt;
}

const Layout& hostLayout() {
  static const Layout layout = readLayout(kHostLayout);
  return layout;
}

}  // namespace

std::vector<LayoutMember> layoutMembers(const std::string& structure) {
  static const std::map<std::string, uint32_t> sizes = {{"uint", 4},  {"float", 4},  {"vec2", 8},
                                                        {"vec3", 12}, {"uvec3", 12}, {"uvec4", 16}};
  std::vector<LayoutMember> members;
  const auto found = hostLayout().structures.find(structure);
  if (found == hostLayout().structures.end()) return members;
  uint32_t offset = 0;
  for (const Words& member : found->second.members) {
    // type name, or type name [ length ]
    const bool isArray = member.words.size() == 5;
    const uint32_t length = isArray ? uint32_t(std::stoul(member.words[3])) : 0;
    const uint32_t size = sizes.at(member.words[0]) * (isArray ? length : 1);
    members.push_back({member.words[1], member.words[0], offset, length, size});
    offset += size;
  }
  return members;
}

void checkLayout(const std::vector<ShaderSource>& sources) {
  const Layout& host = hostLayout();
  std::string faults;
  for (const ShaderSource& source : sources) {
    if (!source.text) continue;
    std::map<size_t, std::string> found;  // by offset
    const Layout here = readLayout(*source.text);
    for (const auto& [name, value] : here.constants) {
      const auto [first, last] = host.constants.equal_range(name);
      bool fits = first == last;  // what the host does not know, it does not mind
      for (auto wanted = first; wanted != last; ++wanted) fits |= areSame(value, wanted->second);
      if (!fits)
        found[value.offset] = name + " is " + textOf(value) + " here, but " + textOf(first->second) + kLayoutRemedy;
    }
    for (const GlslToken& token : readGlslTokens(*source.text)) {
      const std::string_view directive = directiveName(token);
      if (directive != "define" && directive != "undef") continue;
      const std::vector<GlslToken> words = readGlslTokens(token.text.substr(token.text.find(directive)));
      const auto isHidden = [&](const HostConstant& constant) {
        return words.size() > 1 && words[1].text == std::string_view(constant.variable);
      };
      if (std::any_of(hostConstants().begin(), hostConstants().end(), isHidden))
        found[token.offset] =
            std::string(words[1].text) +
            " is a constant that turner gives the kernel; a macro of this name hides it; take another name";
    }
    for (const auto& [name, structure] : here.structures) {
      const auto wanted = host.structures.find(name);
      if (wanted == host.structures.end()) continue;
      if (const auto differs = difference(name, structure, wanted->second))
        found[differs->first] = differs->second + kLayoutRemedy;
    }
    for (const auto& [offset, message] : found)
      faults += (faults.empty() ? "" : "\n") + faultAt(locationAt(source, offset)) + message;
  }
  if (!faults.empty()) throw InputError(faults);
}

}  // namespace turner
