// RapidJSON's reader tells events and where it stands; the start of each token is found from there.
#include "scene/json/json_tree.h"

#include <rapidjson/reader.h>

#include <algorithm>
#include <cctype>
#include <utility>

namespace turner {

namespace {

// RapidJSON's input stream over the text. Notes whether the reader ever came to the end: a fault found there means that
// the file was cut off.
class TextStream {
 public:
  using Ch = char;

  explicit TextStream(std::string_view text) : text_(text) {}

  Ch Peek() const {
    if (at_ < text_.size()) return text_[at_];
    sawEnd_ = true;
    return '\0';
  }
  Ch Take() {
    const Ch c = Peek();
    if (at_ < text_.size()) ++at_;
    return c;
  }
  size_t Tell() const { return at_; }
  bool sawEnd() const { return sawEnd_; }

  // Writing in place is part of RapidJSON's stream concept, but is not asked of this one.
  Ch* PutBegin() { return nullptr; }
  void Put(Ch) {}
  void Flush() {}
  size_t PutEnd(Ch*) { return 0; }

 private:
  std::string_view text_;
  size_t at_ = 0;
  mutable bool sawEnd_ = false;
};

// The place of the next token: behind white space, comments, commas and colons.
size_t skipToToken(std::string_view text, size_t at) {
  while (at < text.size()) {
    const char c = text[at];
    if (c == ' ' || c == '\t' || c == '\n' || c == '\r' || c == ',' || c == ':') {
      ++at;
    } else if (text.substr(at, 2) == "//") {
      at = std::min(text.find('\n', at), text.size());
    } else if (text.substr(at, 2) == "/*") {
      const size_t end = text.find("*/", at + 2);
      at = end == text.npos ? text.size() : end + 2;
    } else {
      break;
    }
  }
  return at;
}

bool isWordCharacter(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) || c == '+' || c == '-' || c == '.' || c == '_';
}

// A number or a bare word such as NaN, from its first character on.
std::string_view wordAt(std::string_view text, size_t at) {
  size_t end = at;
  while (end < text.size() && isWordCharacter(text[end])) ++end;
  return text.substr(at, end - at);
}

// Numbers that JSON has no words for, as other programs write them. They stand where a number may stand, so that the
// reader of the tree can say which field it is that they are wrong in.
bool isNotFinite(std::string_view word) {
  if (word.starts_with('-') || word.starts_with('+')) word.remove_prefix(1);
  std::string lower(word);
  std::transform(lower.begin(), lower.end(), lower.begin(), [](unsigned char c) { return char(std::tolower(c)); });
  return lower == "nan" || lower == "inf" || lower == "infinity";
}

// Receives RapidJSON's events and lays down the nodes. An event says where its token ends at best, so each token's
// beginning is looked for from the end of the token before it.
class TreeBuilder {
 public:
  // `parsed` is what RapidJSON reads: `text` with some numbers blanked out.
  TreeBuilder(std::string_view text, std::string_view parsed, const TextStream& stream, JsonTree& tree)
      : text_(text), parsed_(parsed), stream_(stream), tree_(tree) {}

  bool Null() { return addWord(JsonKind::null); }
  bool Bool(bool) { return addWord(JsonKind::boolean); }
  bool RawNumber(const char*, rapidjson::SizeType, bool) { return addWord(JsonKind::number); }
  bool String(const char* string, rapidjson::SizeType length, bool) {
    addString(JsonKind::string, {string, length});
    return true;
  }
  bool Key(const char* string, rapidjson::SizeType length, bool) {
    addString(JsonKind::key, {string, length});
    return true;
  }
  bool StartObject() { return open(JsonKind::object); }
  bool StartArray() { return open(JsonKind::array); }
  bool EndObject(rapidjson::SizeType) { return close(); }
  bool EndArray(rapidjson::SizeType) { return close(); }

  // Numbers come as text; these are never called.
  bool Int(int) { return false; }
  bool Uint(unsigned) { return false; }
  bool Int64(int64_t) { return false; }
  bool Uint64(uint64_t) { return false; }
  bool Double(double) { return false; }

  // Where the token begins that comes after the last one received.
  size_t nextToken() const { return skipToToken(parsed_, end_); }

 private:
  void add(JsonKind kind, size_t offset, std::string_view text) {
    const size_t index = tree_.nodes.size();
    tree_.nodes.push_back({kind, offset, text, index + 1});
    if (kind != JsonKind::key) closeKeyOf(index);
  }

  // A key ends where its value ends.
  void closeKeyOf(size_t value) {
    if (value > 0 && tree_.nodes[value - 1].kind == JsonKind::key)
      tree_.nodes[value - 1].next = tree_.nodes[value].next;
  }

  bool addWord(JsonKind kind) {
    const size_t offset = nextToken();
    add(kind, offset, wordAt(text_, offset));
    end_ = offset + wordAt(parsed_, offset).size();
    return true;
  }

  void addString(JsonKind kind, std::string_view string) {
    const size_t offset = nextToken();
    end_ = stream_.Tell();
    std::string_view written = text_.substr(offset + 1, end_ - offset - 2);  // between the quotes
    if (written != string) written = tree_.decoded.emplace_back(string);
    add(kind, offset, written);
  }

  bool open(JsonKind kind) {
    const size_t offset = nextToken();
    if (open_.size() == kMaxJsonNesting) return false;
    open_.push_back(tree_.nodes.size());
    add(kind, offset, {});
    end_ = offset + 1;
    return true;
  }

  bool close() {
    tree_.nodes[open_.back()].next = tree_.nodes.size();
    closeKeyOf(open_.back());
    open_.pop_back();
    end_ = nextToken() + 1;
    return true;
  }

  std::string_view text_, parsed_;
  const TextStream& stream_;
  size_t end_ = 0;  // of the last token
  JsonTree& tree_;
  std::vector<size_t> open_;  // the containers around the current place
};

// What may stand at the place of a syntax fault.
std::string describeExpected(rapidjson::ParseErrorCode code) {
  switch (code) {
    case rapidjson::kParseErrorDocumentRootNotSingular:
      return "nothing may follow the closing bracket";
    case rapidjson::kParseErrorObjectMissName:
      return "expected a key in double quotes";
    case rapidjson::kParseErrorObjectMissColon:
      return "expected ':' and a value after the key";
    case rapidjson::kParseErrorObjectMissCommaOrCurlyBracket:
      return "expected ',' or '}'";
    case rapidjson::kParseErrorArrayMissCommaOrSquareBracket:
      return "expected ',' or ']'";
    case rapidjson::kParseErrorStringUnicodeEscapeInvalidHex:
      return "expected four hexadecimal digits after \\u";
    case rapidjson::kParseErrorStringUnicodeSurrogateInvalid:
      return "expected the second half of a surrogate pair";
    case rapidjson::kParseErrorStringEscapeInvalid:
      return "a string may contain neither control characters nor escapes other than "
             "\\\" \\\\ \\/ \\b \\f \\n \\r \\t \\u";
    case rapidjson::kParseErrorStringMissQuotationMark:
      return "expected the closing quote of a string";
    case rapidjson::kParseErrorStringInvalidEncoding:
      return "must be UTF-8";
    case rapidjson::kParseErrorNumberMissFraction:
      return "expected digits after the decimal point";
    case rapidjson::kParseErrorNumberMissExponent:
      return "expected digits in the exponent";
    case rapidjson::kParseErrorUnspecificSyntaxError:
      return "a comment is // up to the end of the line or /* up to */";
    default:
      return "expected a value: a finite number, a string, true, false, null, [...] or {...}";
  }
}

// What stands at the place of a syntax fault: a word, or a character that may not be printable.
std::string describeFound(std::string_view text, size_t at) {
  const std::string_view word = wordAt(text, at);
  if (!word.empty()) return std::string(word.substr(0, 40));
  const unsigned char c = static_cast<unsigned char>(text[at]);
  if (c > 0x20 && c < 0x7F) return std::string("'") + text[at] + "'";
  constexpr char kDigits[] = "0123456789abcdef";
  return std::string("the byte 0x") + kDigits[c >> 4] + kDigits[c & 15];
}

void addSyntaxFault(const rapidjson::ParseResult& result, std::string_view text, const TextStream& stream,
                    const TreeBuilder& builder, Diagnostics& faults) {
  const rapidjson::ParseErrorCode code = result.Code();
  const std::string expected = describeExpected(code);
  if (stream.sawEnd()) {
    const bool isEmpty = skipToToken(text, 0) == text.size();
    faults.add(text.size(), (isEmpty ? "the file is empty; " : "the file ends too early; ") + expected);
    return;
  }
  size_t at = result.Offset();
  switch (code) {
    // RapidJSON stops within the word; the reader of the message looks for its beginning.
    case rapidjson::kParseErrorValueInvalid:
    case rapidjson::kParseErrorNumberMissFraction:
    case rapidjson::kParseErrorNumberMissExponent:
      if (builder.nextToken() < at) at = builder.nextToken();
      break;
    case rapidjson::kParseErrorUnspecificSyntaxError:
      --at;  // the slash has been taken
      break;
    case rapidjson::kParseErrorTermination:
      faults.add(at, "nested too deeply; at most " + std::to_string(kMaxJsonNesting) + " brackets may be open");
      return;
    default:
      break;
  }
  faults.add(at, "found " + describeFound(text, at) + "; " + expected);
}

}  // namespace

JsonTree parseJson(std::string_view text, Diagnostics& faults) {
  if (const size_t zero = text.find('\0'); zero != text.npos) {
    faults.add(zero, "found the byte 0x00; a scene is a text file");
    return {};
  }

  // RapidJSON computes every number even where it only hands over its text, and gives up at those beyond its range
  // (1e400) and at NaN. They are blanked out, one at each attempt, so that faults behind them are found too; the tree
  // keeps what is written. After some attempts it is a fault like any other: the time spent must stay proportional to
  // the file.
  constexpr int kMaxAttempts = 32;
  std::string blanked;
  for (int attempt = 1;; ++attempt) {
    const std::string_view parsed = blanked.empty() ? text : std::string_view(blanked);
    JsonTree tree;
    TextStream stream(parsed);
    TreeBuilder builder(text, parsed, stream, tree);
    rapidjson::Reader reader;
    constexpr unsigned kFlags = rapidjson::kParseCommentsFlag | rapidjson::kParseNumbersAsStringsFlag |
                                rapidjson::kParseValidateEncodingFlag | rapidjson::kParseIterativeFlag;
    const rapidjson::ParseResult result = reader.Parse<kFlags>(stream, builder);
    if (!result.IsError()) return tree;
    const bool isTooLarge = result.Code() == rapidjson::kParseErrorNumberTooBig;
    const size_t at = isTooLarge ? result.Offset() : builder.nextToken();
    const std::string_view number = wordAt(text, at);
    const bool isWord = result.Code() == rapidjson::kParseErrorValueInvalid && isNotFinite(number);
    if (!isTooLarge && (!isWord || attempt == kMaxAttempts)) {
      addSyntaxFault(result, text, stream, builder, faults);
      return {};
    }
    if (attempt == kMaxAttempts) {
      faults.add(at, "found " + std::string(number.substr(0, 40)) + ", which is too large");
      return {};
    }
    if (blanked.empty()) blanked = text;
    blanked.replace(at, number.size(), "0" + std::string(number.size() - 1, ' '));
  }
}

}  // namespace turner
