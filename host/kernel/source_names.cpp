// Looks at tokens, without regard to scopes.
#include "kernel/source_names.h"

#include <algorithm>
#include <optional>
#include <string_view>

#include "kernel/glsl_tokens.h"

namespace turner {
namespace {

// Whether the line of this token declares what the host binds.
bool isOfLayout(std::string_view token) {
  return token == "layout" || token == "binding" || token.starts_with("kBind");
}

}  // namespace

SourceLocation locationAt(const ShaderSource& source, size_t offset) {
  SourceLocation location{source.path};
  const std::string_view before = std::string_view(*source.text).substr(0, offset);
  location.line += int(std::count(before.begin(), before.end(), '\n'));
  location.column = int(before.size() - (before.rfind('\n') + 1)) + 1;  // npos + 1 is 0
  return location;
}

std::string faultAt(const SourceLocation& location) {
  return location.path + ':' + std::to_string(location.line) + ':' + std::to_string(location.column) + ": error: ";
}

SourceLocation findDeclaration(const std::vector<ShaderSource>& sources, const std::vector<std::string>& names) {
  struct Found {
    const ShaderSource* source;
    size_t offset, rank;  // a lower rank is better
  };
  std::optional<Found> best;
  for (const ShaderSource& source : sources) {
    if (!source.text) continue;
    const std::vector<GlslToken> tokens = readGlslTokens(*source.text);
    for (size_t i = 0; i < tokens.size();) {
      size_t end = i;
      bool hasLayout = false;
      for (; end < tokens.size() && tokens[end].line == tokens[i].line; ++end)
        hasLayout |= isOfLayout(tokens[end].text);
      for (; i < end; ++i) {
        const auto number = size_t(std::find(names.begin(), names.end(), tokens[i].text) - names.begin());
        if (number == names.size()) continue;
        const size_t rank = number + (hasLayout ? 0 : names.size());
        if (!best || rank < best->rank) best = Found{&source, tokens[i].offset, rank};
      }
    }
  }
  return best ? locationAt(*best->source, best->offset) : SourceLocation{sources.empty() ? "" : sources[0].path};
}

bool findMember(const std::vector<ShaderSource>& sources, const std::string& structure, const std::string& member,
                SourceLocation& location) {
  for (const ShaderSource& source : sources) {
    if (!source.text) continue;
    const std::vector<GlslToken> tokens = readGlslTokens(*source.text);
    for (size_t i = 0; i + 1 < tokens.size(); ++i) {
      if (tokens[i].text != structure || tokens[i + 1].text != "{") continue;
      for (size_t j = i + 2; j < tokens.size() && tokens[j].text != "}"; ++j) {
        if (tokens[j].text != member) continue;
        location = locationAt(source, tokens[j].offset);
        return true;
      }
    }
  }
  return false;
}

}  // namespace turner
