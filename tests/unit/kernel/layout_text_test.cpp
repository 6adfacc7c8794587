// An edited layout.h may add; what it changes of the host's is refused.
#include <gmock/gmock.h>

#include <algorithm>
#include <string>

#include "base/errors.h"
#include "base/text_file.h"
#include "kernel/layout_text.h"

namespace turner {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

std::string original() {
  return readTextFile(TURNER_SHADERS_DIR "/layout.h");
}

std::string complaintAbout(const std::string& text, const std::string& path = "edited/layout.h") {
  try {
    checkLayout({{"", "edited/whitted.comp", "#include \"layout.h\"\n"}, {"layout.h", path, text}});
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

// The text must stand in layout.h once.
std::string afterEdit(const std::string& from, const std::string& to) {
  std::string text = original();
  const size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  EXPECT_EQ(text.find(from, at + 1), std::string::npos) << from;
  if (at != std::string::npos) text.replace(at, from.size(), to);
  return complaintAbout(text);
}

// "edited/layout.h:12:3: error: " of a text in the original.
std::string placeOf(const std::string& text) {
  const std::string before = original().substr(0, original().find(text));
  const auto line = 1 + std::count(before.begin(), before.end(), '\n');
  return "edited/layout.h:" + std::to_string(line) + ':' + std::to_string(before.size() - before.rfind('\n')) +
         ": error: ";
}

TEST(LayoutText, TheHostsOwnPasses) {
  EXPECT_EQ(complaintAbout(original()), "");
}

TEST(LayoutText, AnotherValueIsRefusedWithPlaceAndRemedy) {
  EXPECT_EQ(afterEdit("kSpecDepth = 1u", "kSpecDepth = 7u"),
            placeOf("kSpecDepth = 1u") +
                "kSpecDepth is 7u here, but 1u in the running turner, which was built with its own layout.h and cannot "
                "follow; build turner with this file, or take the change back");
}

TEST(LayoutText, AnotherValueInAListIsRefused) {
  EXPECT_THAT(afterEdit("kNodePlanes = 1u", "kNodePlanes = 2u"),
              StartsWith(placeOf("kNodePlanes = 1u") + "kNodePlanes is 2u here, but 1u in"));
}

TEST(LayoutText, AnotherValueByDefineIsRefused) {
  EXPECT_THAT(afterEdit("TURNER_CONST kLightPosition = 0u, kLightColor = 1u, kLightRows = 2u;",
                        "#define kLightPosition 1u\n#define kLightColor 0u\n#define  kLightRows 2u"),
              AllOf(HasSubstr("kLightPosition is 1u here, but 0u in"), HasSubstr("kLightColor is 0u here, but 1u in"),
                    testing::Not(HasSubstr("kLightRows"))));
}

TEST(LayoutText, AnotherValueIsRefusedInWhicheverFileItStands) {
  EXPECT_THAT(
      complaintAbout("const uint kLightRows = 3u;\n#define kLightColor\nconst uint kMine = 3u;", "edited/mine.glsl"),
      AllOf(StartsWith("edited/mine.glsl:1:12: error: kLightRows is 3u here, but 2u in"),
            HasSubstr("edited/mine.glsl:2:1: error: kLightColor is  here, but 1u in"),
            testing::Not(HasSubstr("kMine"))));
}

TEST(LayoutText, AnotherExpressionIsRefused) {
  EXPECT_THAT(afterEdit("kRefTriangle | kRefSecond | kRefOffsetMask", "kRefTriangle | kRefOffsetMask"),
              HasSubstr("kRefPrimitive is kRefTriangle | kRefOffsetMask here, but kRefTriangle | kRefSecond | "
                        "kRefOffsetMask in"));
}

TEST(LayoutText, AnotherValueIsSeenHoweverItIsDeclared) {
  EXPECT_THAT(afterEdit("TURNER_CONST kMaxLeafSize = 4u", "const uint kMaxLeafSize = 5u"),
              HasSubstr("kMaxLeafSize is 5u here, but 4u in"));
}

TEST(LayoutText, AllFaultsAreToldAtOnceInTheirOrder) {
  std::string text = original();
  text.replace(text.find("kSpecBudget = 15u"), 17, "kSpecBudget = 16u");
  text.replace(text.find("kRefLeaf = 0x80000000u"), 22, "kRefLeaf = 0x40000000u");
  text.replace(text.find("uint limiter;"), 13, "int limiter;");
  const std::string complaint = complaintAbout(text);
  EXPECT_EQ(std::count(complaint.begin(), complaint.end(), '\n'), 2);
  EXPECT_LT(complaint.find("kRefLeaf"), complaint.find("kSpecBudget"));
  EXPECT_LT(complaint.find("kSpecBudget"), complaint.find("struct Status"));
}

TEST(LayoutText, SwappedMembersAreRefused) {
  EXPECT_THAT(afterEdit("uint x0, y0;", "uint y0, x0;"),
              AllOf(StartsWith(placeOf("x0, y0;")),
                    HasSubstr("struct Tile has 'uint y0' here, but 'uint x0' in the running turner, which")));
}

TEST(LayoutText, AddedAndLostMembersAreRefused) {
  EXPECT_THAT(afterEdit("Row addresses[6];", "Row addresses[6]; Row mine;"),
              HasSubstr("struct Frame has 'Row mine' here, but ends before it in the running turner"));
  EXPECT_THAT(afterEdit("uint mediaLost;", ""),
              HasSubstr("struct Status ends here, but has 'uint mediaLost' in the running turner"));
  EXPECT_THAT(afterEdit("Row addresses[6];", "Row addresses[7];"),
              HasSubstr("'Row addresses[7]' here, but 'Row addresses[6]' in"));
}

TEST(LayoutText, AnotherSpellingPasses) {
  EXPECT_EQ(afterEdit("kMaxLeafSize = 4u", "kMaxLeafSize = /* the same */ 0x4U"), "");
  EXPECT_EQ(afterEdit("uint x0, y0;", "uint x0;\n  uint y0;"), "");
  EXPECT_EQ(afterEdit("Row addresses[6];", "Row addresses[0x6u];"), "");
  EXPECT_EQ(afterEdit("kSphereUnits = 1u, kPairUnits = 3u;", "kSphereUnits = 1u;\nTURNER_CONST kPairUnits = 3u;"), "");
}

TEST(LayoutText, CommentsMayChange) {
  EXPECT_EQ(afterEdit("// What the host reads after a dispatch.", "// kSpecDepth = 9u; struct Tile { uint x; };"), "");
  EXPECT_EQ(afterEdit("// What the host reads after a dispatch.", "/* TURNER_CONST kSpecDepth = 9u; */"), "");
}

TEST(LayoutText, AdditionsPass) {
  EXPECT_EQ(afterEdit("// What the host reads after a dispatch.",
                      "TURNER_CONST kMine = 3u, kOther = kMine + 1u;\nstruct Mine { uint a; float b[3]; };"),
            "");
}

TEST(LayoutText, WhatIsMissingPasses) {
  EXPECT_EQ(afterEdit("TURNER_CONST kSpecDepth = 1u;", ""), "");
  EXPECT_EQ(complaintAbout(""), "");
}

TEST(LayoutText, AnUnreadableOrBrokenFilePasses) {
  checkLayout({{"layout.h", "layout.h", std::nullopt}});
  for (const char* text :
       {"struct Tile {", "struct Tile { uint", "TURNER_CONST kSpecDepth =", "TURNER_CONST kSpecDepth", "struct",
        "struct Tile { , ; uint x0", "/* no end", "#define x \\"})
    EXPECT_NO_FATAL_FAILURE(complaintAbout(text)) << text;
}

}  // namespace
}  // namespace turner
