// Status::limiter of the probe's kernel:
//   bits 31..28: 15 if a loop has made too many turns; else how many bits the most turns of a loop have, where a driver
//                has ended loops | bits 27..20: number of that loop | bits 19..0: what the canary in main() adds
// The greatest over all invocations stays there. Of loops with equally many turns the later one does: an inner loop
// before those around it, a loop of an included file before one of main().
#include "watch/diagnosis/loop_probe.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <utility>

#include "kernel/glsl_tokens.h"
#include "watch/diagnosis/glsl_loops.h"

namespace turner::watch {
namespace {

// As many numbers as there is room for. Later loops have no counters.
constexpr size_t kMostLoops = 256;

// What stands before everything that has a loop.
std::string declarations() {
  return fmt::format(
      "uint turnerMost = 0u, turnerLoop = 0u; "  // the most turns that a loop has made in one go, and which
      "bool turnerTooMany(inout uint turns, const uint loop) {{ "
      "if (turnerMost > {0}u) return true; "
      "++turns; "
      "if (turns > turnerMost) turnerMost = turns, turnerLoop = loop; "
      "return turns > {0}u; }} "
      "void turnerTell();\n",
      kMostTurns);
}

// What stands behind everything, where `status` is known. It has a canary of its own, as main()'s is the user's: four
// turns that no compiler can count.
std::string definitions() {
  return fmt::format(
      "\nvoid turnerTell() {{\n"
      "  uint sung = 0u;\n"
      "  for (uint i = 0u; i < 3u + min(gl_NumWorkGroups.x, 1u); ++i) ++sung;\n"
      "  bool tooMany = turnerMost > {}u;\n"
      "  uint size = tooMany ? 15u : uint(findMSB(turnerMost) + 1);\n"
      "  if (tooMany || sung != 4u) atomicMax(status.limiter, size << 28u | turnerLoop << 20u);\n"
      "}}\n",
      kMostTurns);
}

struct Insertion {
  size_t offset;
  std::string text;
};

size_t offsetBehind(const GlslToken& token) {
  return token.offset + token.text.size();
}

// A counter around a loop, and a look at it in every turn.
void insertCounter(const std::vector<GlslToken>& tokens, const GlslLoop& loop, size_t number,
                   std::vector<Insertion>& insertions) {
  insertions.push_back({tokens[loop.begin].offset, fmt::format("{{ uint turnerTurns{} = 0u; ", number)});
  insertions.push_back(
      {tokens[loop.bodyBegin].offset, fmt::format("{{ if (turnerTooMany(turnerTurns{0}, {0}u)) break; ", number)});
  insertions.push_back({offsetBehind(tokens[loop.bodyEnd - 1]), " }"});
  insertions.push_back({offsetBehind(tokens[loop.end - 1]), " }"});
}

// At every end of main().
void insertReport(const std::vector<GlslToken>& tokens, const GlslBody& main, std::vector<Insertion>& insertions) {
  for (size_t i = main.begin; i + 1 < main.end; ++i) {
    if (tokens[i].text != "return" || tokens[i + 1].text != ";") continue;
    insertions.push_back({tokens[i].offset, "{ turnerTell(); "});
    insertions.push_back({offsetBehind(tokens[i + 1]), " }"});
  }
  insertions.push_back({tokens[main.end - 1].offset, "turnerTell(); "});
}

// Of the kernel's own file: behind the directives that must come first, before what may include loops.
size_t declarationsOffset(const std::vector<GlslToken>& tokens, std::string_view text) {
  for (const GlslToken& token : tokens) {
    const std::string_view directive = directiveName(token);
    if (directive != "version" && directive != "extension") return token.offset;
  }
  return text.size();
}

// Insertions in one place stand in the order in which they were made.
std::string withInsertions(std::string_view text, std::vector<Insertion> insertions) {
  std::stable_sort(insertions.begin(), insertions.end(),
                   [](const Insertion& a, const Insertion& b) { return a.offset < b.offset; });
  std::string result;
  size_t done = 0;
  for (const Insertion& insertion : insertions) {
    result += text.substr(done, insertion.offset - done);
    result += insertion.text;
    done = insertion.offset;
  }
  result += text.substr(done);
  return result;
}

}  // namespace

LoopProbe probeLoops(const std::vector<ShaderSource>& sources) {
  LoopProbe probe;
  for (const ShaderSource& source : sources) {
    probe.sources.push_back(source);
    if (!source.text) continue;
    const std::vector<GlslToken> tokens = readGlslTokens(*source.text);
    std::vector<Insertion> insertions;
    const bool isKernel = probe.sources.size() == 1;
    if (isKernel) insertions.push_back({declarationsOffset(tokens, *source.text), declarations()});
    for (const GlslLoop& loop : findLoops(tokens)) {
      if (probe.loops.size() == kMostLoops) break;
      insertCounter(tokens, loop, probe.loops.size(), insertions);
      probe.loops.push_back({source.path, tokens[loop.keyword].line, tokens[loop.keyword].column});
    }
    for (const GlslBody& main : findMains(tokens)) insertReport(tokens, main, insertions);
    if (isKernel) insertions.push_back({source.text->size(), definitions()});
    probe.sources.back().text = withInsertions(*source.text, std::move(insertions));
  }
  return probe;
}

std::optional<SourceLocation> endlessLoop(const LoopProbe& probe, uint32_t limiterCount) {
  const uint32_t size = limiterCount >> 28, number = limiterCount >> 20 & (kMostLoops - 1);
  if (size == 0 || number >= probe.loops.size()) return std::nullopt;
  return probe.loops[number];
}

}  // namespace turner::watch
