// Knows the form of turner's messages and how glslang names tokens.
#include "watch/diagnosis/diagnosis.h"

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string_view>
#include <utility>

#include "base/errors.h"
#include "base/text_file.h"
#include "kernel/glsl_tokens.h"

namespace turner::watch {
namespace {

// --- the message -----------------------------------------------------------------------------------------------------

// Takes ":12" off the end of a text.
std::optional<int> takeNumber(std::string_view& text) {
  const size_t colon = text.rfind(':');
  if (colon == std::string_view::npos) return std::nullopt;
  int number = 0;
  const char* const end = text.data() + text.size();
  const auto [stop, fault] = std::from_chars(text.data() + colon + 1, end, number);
  if (fault != std::errc() || stop != end || number < 1) return std::nullopt;
  text = text.substr(0, colon);
  return number;
}

Diagnosis readLine(std::string_view line) {
  constexpr std::string_view kError = ": error: ";
  const size_t at = line.find(kError);
  Diagnosis diagnosis;
  if (at == std::string_view::npos || at == 0) {
    diagnosis.message = line;
    return diagnosis;
  }
  diagnosis.message = line.substr(at + kError.size());
  std::string_view location = line.substr(0, at);
  const std::optional<int> last = takeNumber(location);
  const std::optional<int> first = last ? takeNumber(location) : std::nullopt;
  diagnosis.file = location;
  if (first) {
    diagnosis.line = *first;
    diagnosis.column = *last;
  } else if (last) {
    diagnosis.line = *last;
  }
  return diagnosis;
}

// --- the source's line -----------------------------------------------------------------------------------------------

std::string textOnDisk(const std::string& path) {
  constexpr uintmax_t kLargest = 4 << 20;  // bytes; no shader is as large
  std::error_code fault;
  if (!std::filesystem::is_regular_file(path, fault) || std::filesystem::file_size(path, fault) > kLargest) return {};
  try {
    return readTextFile(path);
  } catch (const InputError&) {
    return {};
  }
}

// Lines end as glslang counts them: with "\n", "\r\n" or "\r".
std::string lineOf(std::string_view text, int number) {
  for (int line = 1;; ++line) {
    const size_t end = std::min(text.find_first_of("\r\n"), text.size());
    if (line == number) return std::string(text.substr(0, end));
    if (end == text.size()) return {};
    text.remove_prefix(text.substr(end).starts_with("\r\n") ? end + 2 : end + 1);
  }
}

std::string sourceLine(const Diagnosis& diagnosis, const std::vector<ShaderSource>& sources) {
  for (const ShaderSource& source : sources)
    if (source.path == diagnosis.file && source.text) return lineOf(*source.text, diagnosis.line);
  return lineOf(textOnDisk(diagnosis.file), diagnosis.line);
}

// --- the column ------------------------------------------------------------------------------------------------------

// glslang's names of tokens in a syntax error; keywords are named by themselves in capitals.
constexpr std::pair<std::string_view, std::string_view> kTokenNames[] = {
    {"LEFT_OP", "<<"},
    {"RIGHT_OP", ">>"},
    {"INC_OP", "++"},
    {"DEC_OP", "--"},
    {"LE_OP", "<="},
    {"GE_OP", ">="},
    {"EQ_OP", "=="},
    {"NE_OP", "!="},
    {"AND_OP", "&&"},
    {"OR_OP", "||"},
    {"XOR_OP", "^^"},
    {"MUL_ASSIGN", "*="},
    {"DIV_ASSIGN", "/="},
    {"ADD_ASSIGN", "+="},
    {"MOD_ASSIGN", "%="},
    {"LEFT_ASSIGN", "<<="},
    {"RIGHT_ASSIGN", ">>="},
    {"AND_ASSIGN", "&="},
    {"XOR_ASSIGN", "^="},
    {"OR_ASSIGN", "|="},
    {"SUB_ASSIGN", "-="},
    {"LEFT_PAREN", "("},
    {"RIGHT_PAREN", ")"},
    {"LEFT_BRACKET", "["},
    {"RIGHT_BRACKET", "]"},
    {"LEFT_BRACE", "{"},
    {"RIGHT_BRACE", "}"},
    {"DOT", "."},
    {"COMMA", ","},
    {"COLON", ":"},
    {"EQUAL", "="},
    {"SEMICOLON", ";"},
    {"BANG", "!"},
    {"DASH", "-"},
    {"TILDE", "~"},
    {"PLUS", "+"},
    {"STAR", "*"},
    {"SLASH", "/"},
    {"PERCENT", "%"},
    {"LEFT_ANGLE", "<"},
    {"RIGHT_ANGLE", ">"},
    {"VERTICAL_BAR", "|"},
    {"CARET", "^"},
    {"AMPERSAND", "&"},
    {"QUESTION", "?"},
    {"HIGH_PRECISION", "highp"},
    {"MEDIUM_PRECISION", "mediump"},
    {"LOW_PRECISION", "lowp"},
};

// Whether a token of the line may be the one that a message names.
bool isNamed(const GlslToken& token, std::string_view name) {
  if (name == "IDENTIFIER" || name == "TYPE_NAME" || name == "FIELD_SELECTION") return token.kind == GlslKind::word;
  const std::string_view text = token.text;
  if (name == "BOOLCONSTANT") return text == "true" || text == "false";
  if (name.ends_with("CONSTANT")) return token.kind == GlslKind::number;
  for (const auto& [tokenName, characters] : kTokenNames)
    if (name == tokenName) return text == characters;
  return text.size() == name.size() && std::equal(text.begin(), text.end(), name.begin(), [](char a, char b) {
           return a == b || (a >= 'a' && a <= 'z' && a - 'a' + 'A' == b);
         });
}

// The part of a text between two others, or from the first on; empty where there is none.
std::string_view between(std::string_view text, std::string_view before, std::string_view behind) {
  const size_t at = text.find(before);
  if (at == std::string_view::npos) return {};
  text.remove_prefix(at + before.size());
  return text.substr(0, text.find_first_of(behind));
}

int deduceColumn(const std::string& message, const std::string& line) {
  const std::vector<GlslToken> tokens = readGlslTokens(line);
  // 'name' : undeclared identifier
  const std::string_view quoted = between(message, "'", "'");
  if (!quoted.empty()) {
    for (const GlslToken& token : tokens)
      if (token.text == quoted) return int(token.offset) + 1;
    if (const size_t at = line.find(quoted); at != std::string::npos) return int(at) + 1;
  }
  // '' : syntax error, unexpected RIGHT_BRACE, expecting COMMA or SEMICOLON
  const std::string_view unexpected = between(message, "unexpected ", ", ");
  if (!unexpected.empty()) {
    for (const GlslToken& token : tokens)
      if (isNamed(token, unexpected)) return int(token.offset) + 1;
  }
  const size_t first = line.find_first_not_of(" \t");
  return first == std::string::npos ? 1 : int(first) + 1;
}

// --- the terminal ----------------------------------------------------------------------------------------------------

// A character of a text in UTF-8: its bytes, and whether a terminal only shows it.
struct Character {
  size_t length = 1;
  bool harmless = false;
};

Character characterAt(std::string_view text) {
  const auto byte = [&](size_t i) { return uint32_t((unsigned char)text[i]); };
  if (byte(0) < 0x80) return {1, byte(0) >= ' ' && byte(0) != 0x7f};
  const size_t length = byte(0) >= 0xf0 ? 4 : byte(0) >= 0xe0 ? 3 : 2;
  if (byte(0) < 0xc2 || byte(0) > 0xf4 || length > text.size()) return {};
  uint32_t code = byte(0) & (0x7f >> length);
  for (size_t i = 1; i < length; ++i) {
    if ((byte(i) & 0xc0) != 0x80) return {};
    code = code << 6 | (byte(i) & 0x3f);
  }
  // Control characters of Latin 1, and those that turn the direction of writing.
  const bool turns = code == 0x61c || (code >= 0x200b && code <= 0x200f) || (code >= 0x2028 && code <= 0x202e) ||
                     (code >= 0x2060 && code <= 0x206f) || code == 0xfeff;
  return {length, code >= 0xa0 && !turns};
}

// What would move the cursor, or worse, becomes '?'. Tabs stay.
std::string harmless(std::string_view text) {
  std::string safe;
  while (!text.empty()) {
    const Character character = characterAt(text);
    if (character.harmless || text[0] == '\t')
      safe += text.substr(0, character.length);
    else
      safe += '?';
    text.remove_prefix(character.length);
  }
  return safe;
}

// As far as a text takes place on a terminal: blanks, and tabs where it has tabs.
std::string blanksFor(std::string_view text) {
  std::string blanks;
  while (!text.empty()) {
    blanks += text[0] == '\t' ? '\t' : ' ';
    text.remove_prefix(characterAt(text).length);
  }
  return blanks;
}

// Whether a text may be cut in two before this byte.
bool beginsCharacter(std::string_view text, size_t at) {
  return at >= text.size() || ((unsigned char)text[at] & 0xc0) != 0x80;
}

}  // namespace

std::vector<Diagnosis> readDiagnoses(const std::string& text, const std::vector<ShaderSource>& sources) {
  std::vector<Diagnosis> diagnoses;
  for (std::string_view rest = text; !rest.empty();) {
    const size_t end = std::min(rest.find('\n'), rest.size());
    if (end > 0) {
      Diagnosis diagnosis = readLine(rest.substr(0, end));
      // A fault of a whole source is placed at its beginning, where an editor can go.
      const bool isSource = std::any_of(sources.begin(), sources.end(), [&](const ShaderSource& source) {
        return source.text && source.path == diagnosis.file;
      });
      if (isSource && diagnosis.line == 0) diagnosis.line = diagnosis.column = 1;
      if (diagnosis.line > 0) {
        diagnosis.source = sourceLine(diagnosis, sources);
        if (diagnosis.column == 0) diagnosis.column = deduceColumn(diagnosis.message, diagnosis.source);
      }
      diagnoses.push_back(std::move(diagnosis));
    }
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  return diagnoses;
}

std::string gccText(const Diagnosis& diagnosis) {
  std::string text = diagnosis.file.empty() ? "turner" : harmless(diagnosis.file);
  for (const int number : {diagnosis.line, diagnosis.column})
    if (number > 0) text += ':' + std::to_string(number);
  text += ": error: " + harmless(diagnosis.message);
  if (diagnosis.source.empty()) return text;

  // Of a long line only what is near the caret.
  constexpr size_t kLongest = 120, kBefore = 80;
  const std::string_view source = diagnosis.source;
  size_t caret = std::min(size_t(std::max(diagnosis.column, 1)) - 1, source.size());
  while (caret > 0 && !beginsCharacter(source, caret)) --caret;
  size_t begin = 0, end = source.size();
  if (source.size() > kLongest) {
    begin = std::min(caret > kBefore ? caret - kBefore : 0, source.size() - kLongest);
    end = begin + kLongest;
    while (begin < caret && !beginsCharacter(source, begin)) ++begin;
    while (end > caret && !beginsCharacter(source, end)) --end;
  }
  const std::string before = (begin > 0 ? "..." : "") + std::string(source.substr(begin, caret - begin));
  const std::string behind = std::string(source.substr(caret, end - caret)) + (end < source.size() ? "..." : "");
  return text + "\n  " + harmless(before + behind) + "\n  " + blanksFor(before) + '^';
}

void putDiagnoses(JsonWriter& json, const std::vector<Diagnosis>& diagnoses) {
  json.array("diagnoses", [&] {
    for (const Diagnosis& diagnosis : diagnoses) {
      json.object([&] {
        json.put("file", diagnosis.file);
        json.put("line", diagnosis.line);
        json.put("column", diagnosis.column);
        json.put("message", diagnosis.message);
        json.put("source", diagnosis.source);
      });
    }
  });
}

}  // namespace turner::watch
