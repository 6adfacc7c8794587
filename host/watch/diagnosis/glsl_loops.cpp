// First the brackets are matched, branch by branch of the preprocessor; then statements are followed from bracket to
// bracket, without a look at the expressions in them.
#include "watch/diagnosis/glsl_loops.h"

#include <algorithm>
#include <optional>

namespace turner::watch {
namespace {

constexpr size_t kNone = size_t(-1);

// Statements nest at most as deep as this; what is deeper is no shader, and would need a deep stack here.
constexpr int kDeepest = 200;

// Of each token: the bracket that it belongs to, and the branch of the preprocessor that it stands in.
struct Structure {
  std::vector<size_t> partner;  // kNone: not a bracket, or one that stands alone
  std::vector<int> branch;
};

char openingOf(char closing) {
  return closing == ')' ? '(' : closing == ']' ? '[' : '{';
}

Structure readStructure(const std::vector<GlslToken>& tokens) {
  struct Conditional {
    int outside;                 // the branch around it
    std::vector<size_t> opened;  // brackets that were open before it
    bool hasElse = false;
  };
  Structure structure{std::vector<size_t>(tokens.size(), kNone), std::vector<int>(tokens.size(), 0)};
  std::vector<Conditional> conditionals;
  std::vector<size_t> opened;
  int branch = 0, branches = 1;
  for (size_t i = 0; i < tokens.size(); ++i) {
    structure.branch[i] = branch;
    if (tokens[i].kind == GlslKind::directive) {
      const std::string_view name = directiveName(tokens[i]);
      if (name.starts_with("if")) {  // ifdef and ifndef too
        conditionals.push_back({branch, opened});
        branch = branches++;
      } else if (name.starts_with("el") && !conditionals.empty()) {
        // Every branch begins with the brackets that were open before the first.
        opened = conditionals.back().opened;
        conditionals.back().hasElse |= name == "else";
        branch = branches++;
      } else if (name == "endif" && !conditionals.empty()) {
        // Without an else nothing that may be skipped opens a bracket for what follows.
        if (!conditionals.back().hasElse) opened = conditionals.back().opened;
        branch = conditionals.back().outside;
        conditionals.pop_back();
      }
      continue;
    }
    if (tokens[i].kind != GlslKind::mark) continue;
    const char mark = tokens[i].text[0];
    if (mark == '(' || mark == '[' || mark == '{') {
      opened.push_back(i);
    } else if (mark == ')' || mark == ']' || mark == '}') {
      if (opened.empty() || tokens[opened.back()].text[0] != openingOf(mark)) continue;
      // One that is opened in a branch and closed behind it has several partners, thus none.
      if (structure.branch[opened.back()] == branch) {
        structure.partner[i] = opened.back();
        structure.partner[opened.back()] = i;
      }
      opened.pop_back();
    }
  }
  return structure;
}

// Follows statements. Where one cannot be followed there is no number of a token behind it.
struct Follower {
  const std::vector<GlslToken>& tokens;
  const Structure structure = readStructure(tokens);

  bool is(size_t i, std::string_view text) const { return i < tokens.size() && tokens[i].text == text; }

  // The next token that is no directive.
  size_t next(size_t i) const {
    while (i < tokens.size() && tokens[i].kind == GlslKind::directive) ++i;
    return i;
  }

  // Behind the bracket that closes this one.
  std::optional<size_t> behindBracket(size_t i, std::string_view opening) const {
    if (!is(i, opening) || structure.partner[i] == kNone) return std::nullopt;
    return structure.partner[i] + 1;
  }

  std::optional<GlslLoop> loopAt(size_t i, int depth) const {
    GlslLoop loop{i, i, 0, 0, 0};
    // Attributes: [[unroll]] and the like.
    while (loop.begin > 0 && is(loop.begin - 1, "]") && structure.partner[loop.begin - 1] != kNone)
      loop.begin = structure.partner[loop.begin - 1];
    if (is(i, "do")) {
      loop.bodyBegin = next(i + 1);
      const std::optional<size_t> bodyEnd = behindStatement(loop.bodyBegin, depth);
      if (!bodyEnd) return std::nullopt;
      loop.bodyEnd = *bodyEnd;
      const size_t whileAt = next(loop.bodyEnd);
      const std::optional<size_t> condition =
          is(whileAt, "while") ? behindBracket(next(whileAt + 1), "(") : std::nullopt;
      if (!condition || !is(next(*condition), ";")) return std::nullopt;
      loop.end = next(*condition) + 1;
    } else {
      const std::optional<size_t> head = behindBracket(next(i + 1), "(");
      if (!head) return std::nullopt;
      loop.bodyBegin = next(*head);
      const std::optional<size_t> bodyEnd = behindStatement(loop.bodyBegin, depth);
      if (!bodyEnd) return std::nullopt;
      loop.bodyEnd = loop.end = *bodyEnd;
    }
    for (const size_t part : {loop.begin, loop.bodyBegin, loop.bodyEnd - 1, loop.end - 1})
      if (structure.branch[part] != structure.branch[i]) return std::nullopt;
    return loop;
  }

  // Behind the statement that begins here.
  std::optional<size_t> behindStatement(size_t i, int depth) const {
    if (depth > kDeepest || i >= tokens.size()) return std::nullopt;
    if (is(i, "{")) return behindBracket(i, "{");
    if (is(i, "for") || is(i, "while") || is(i, "do")) {
      const std::optional<GlslLoop> loop = loopAt(i, depth + 1);
      return loop ? std::optional(loop->end) : std::nullopt;
    }
    if (is(i, "if") || is(i, "switch")) {
      const std::optional<size_t> head = behindBracket(next(i + 1), "(");
      const std::optional<size_t> first = head ? behindStatement(next(*head), depth + 1) : std::nullopt;
      if (!first || !is(i, "if") || !is(next(*first), "else")) return first;
      return behindStatement(next(next(*first) + 1), depth + 1);
    }
    if (is(i, "[")) {  // attributes before a statement
      const std::optional<size_t> attributes = behindBracket(i, "[");
      return attributes ? behindStatement(next(*attributes), depth + 1) : std::nullopt;
    }
    // An expression or a declaration goes to its semicolon.
    while (i < tokens.size() && !is(i, ";")) {
      if (is(i, "}") || is(i, ")") || is(i, "]")) return std::nullopt;
      const bool opens = is(i, "(") || is(i, "[") || is(i, "{");
      if (opens && structure.partner[i] == kNone) return std::nullopt;
      i = opens ? structure.partner[i] + 1 : i + 1;
    }
    return i < tokens.size() ? std::optional(i + 1) : std::nullopt;
  }
};

}  // namespace

std::vector<GlslLoop> findLoops(const std::vector<GlslToken>& tokens) {
  const Follower follower{tokens};
  std::vector<GlslLoop> loops;
  std::vector<bool> endsDo(tokens.size(), false);
  for (size_t i = 0; i < tokens.size(); ++i) {
    const bool isDo = follower.is(i, "do"), isWhile = follower.is(i, "while");
    if (!isDo && !isWhile && !follower.is(i, "for")) continue;
    if (isWhile) {
      // Behind a brace that stands alone it may end a do that could not be followed.
      const bool afterLostBrace = i > 0 && follower.is(i - 1, "}") && follower.structure.partner[i - 1] == kNone;
      if (endsDo[i] || afterLostBrace) continue;
    }
    const std::optional<GlslLoop> loop = follower.loopAt(i, 0);
    if (!loop) continue;
    if (isDo) endsDo[follower.next(loop->bodyEnd)] = true;
    loops.push_back(*loop);
  }
  return loops;
}

std::vector<GlslBody> findMains(const std::vector<GlslToken>& tokens) {
  const Follower follower{tokens};
  std::vector<GlslBody> mains;
  for (size_t i = 1; i < tokens.size(); ++i) {
    if (!follower.is(i, "main") || !follower.is(i - 1, "void")) continue;
    const std::optional<size_t> begin = follower.behindBracket(i + 1, "(");
    const std::optional<size_t> end = begin ? follower.behindBracket(*begin, "{") : std::nullopt;
    if (end) mains.push_back({*begin, *end});
  }
  return mains;
}

}  // namespace turner::watch
