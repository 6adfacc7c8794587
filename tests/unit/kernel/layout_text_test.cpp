// An edited layout.h may add; what it changes of the host's is refused.
#include <gmock/gmock.h>

#include <algorithm>
#include <cstddef>
#include <string>

#include "base/errors.h"
#include "base/text_file.h"
#include "kernel/layout_text.h"
#include "layout.h"

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

TEST(LayoutText, AllSourcesOfTheKernelPass) {
  EXPECT_NO_THROW(checkLayout(readShaderSources(TURNER_SHADERS_DIR "/whitted.comp")));
}

TEST(LayoutText, AnotherValueIsRefusedWithPlaceAndRemedy) {
  EXPECT_EQ(afterEdit("kGrid = 0u", "kGrid = 7u"),
            placeOf("kGrid = 0u") +
                "kGrid is 7u here, but 0u in the running turner, which was built with its own layout.h and cannot "
                "follow; build turner with this file, or take the change back");
}

TEST(LayoutText, AnotherValueInAListIsRefused) {
  EXPECT_THAT(afterEdit("kPairUnits = 3u", "kPairUnits = 4u"),
              StartsWith(placeOf("kPairUnits = 3u") + "kPairUnits is 4u here, but 3u in"));
}

TEST(LayoutText, AnotherValueByDefineIsRefused) {
  EXPECT_THAT(afterEdit("TURNER_CONST kGrid = 0u;\nTURNER_CONST kJitter = 1u;\nTURNER_CONST kSobol = 2u;",
                        "#define kGrid 1u\n#define kJitter 0u\n#define  kSobol 2u"),
              AllOf(HasSubstr("kGrid is 1u here, but 0u in"), HasSubstr("kJitter is 0u here, but 1u in"),
                    testing::Not(HasSubstr("kSobol"))));
}

TEST(LayoutText, AnotherValueIsRefusedInWhicheverFileItStands) {
  EXPECT_THAT(
      complaintAbout("const uint kSobol = 3u;\n#define kJitter\nconst uint kMine = 3u;", "edited/mine.glsl"),
      AllOf(StartsWith("edited/mine.glsl:1:12: error: kSobol is 3u here, but 2u in"),
            HasSubstr("edited/mine.glsl:2:1: error: kJitter is  here, but 1u in"), testing::Not(HasSubstr("kMine"))));
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
  text.replace(text.find("kSobol = 2u"), 11, "kSobol = 3u");
  text.replace(text.find("kRefLeaf = 0x80000000u"), 22, "kRefLeaf = 0x40000000u");
  text.replace(text.find("uint limiter;"), 13, "int limiter;");
  const std::string complaint = complaintAbout(text);
  EXPECT_EQ(std::count(complaint.begin(), complaint.end(), '\n'), 2);
  EXPECT_LT(complaint.find("kRefLeaf"), complaint.find("kSobol"));
  EXPECT_LT(complaint.find("kSobol"), complaint.find("struct Status"));
}

TEST(LayoutText, SwappedMembersAreRefused) {
  EXPECT_THAT(afterEdit("uint x0, y0;", "uint y0, x0;"),
              AllOf(StartsWith(placeOf("x0, y0;")),
                    HasSubstr("struct Tile has 'uint y0' here, but 'uint x0' in the running turner, which")));
}

TEST(LayoutText, AddedAndLostMembersAreRefused) {
  EXPECT_THAT(afterEdit("uvec4 parameters[32];", "uvec4 parameters[32]; uvec4 mine;"),
              HasSubstr("struct Frame has 'uvec4 mine' here, but ends before it in the running turner"));
  EXPECT_THAT(afterEdit("uint padding0, padding1, padding2;", ""),
              HasSubstr("struct Status ends here, but has 'uint padding0' in the running turner"));
  EXPECT_THAT(afterEdit("uvec4 addresses[6];", "uvec4 addresses[7];"),
              HasSubstr("'uvec4 addresses[7]' here, but 'uvec4 addresses[6]' in"));
}

TEST(LayoutText, AnotherSpellingPasses) {
  EXPECT_EQ(afterEdit("kMaxLeafSize = 4u", "kMaxLeafSize = /* the same */ 0x4U"), "");
  EXPECT_EQ(afterEdit("uint x0, y0;", "uint x0;\n  uint y0;"), "");
  EXPECT_EQ(afterEdit("uvec4 addresses[6];", "uvec4 addresses[0x6u];"), "");
  EXPECT_EQ(afterEdit("kSphereUnits = 1u, kPairUnits = 3u;", "kSphereUnits = 1u;\nTURNER_CONST kPairUnits = 3u;"), "");
}

TEST(LayoutText, CommentsMayChange) {
  EXPECT_EQ(afterEdit("// What the host reads after a dispatch.", "// kGrid = 9u; struct Tile { uint x; };"), "");
  EXPECT_EQ(afterEdit("// What the host reads after a dispatch.", "/* TURNER_CONST kGrid = 9u; */"), "");
}

// The lines of interface.h, by their names.
TEST(LayoutText, AnotherLineOfTheInterfaceIsRefused) {
  const std::string interface = readTextFile(TURNER_SHADERS_DIR "/interface.h");
  const auto edited = [&](const std::string& from, const std::string& to) {
    std::string text = interface;
    EXPECT_NE(text.find(from), std::string::npos) << from;
    text.replace(text.find(from), from.size(), to);
    return complaintAbout(text, "edited/interface.h");
  };
  EXPECT_EQ(edited("", ""), "");
  EXPECT_THAT(edited("TURNER_CONSTANT(Depth, 1,", "TURNER_CONSTANT(Depth, 7,"),
              AllOf(StartsWith("edited/interface.h:"), HasSubstr("Depth is TURNER_CONSTANT ( Depth , 7 , uint"),
                    HasSubstr("here, but TURNER_CONSTANT ( Depth , 1 , uint")));
  EXPECT_THAT(edited("TURNER_FEATURE(Spheres, 4, bool", "TURNER_FEATURE(Spheres, 4, uint"), HasSubstr("Spheres is"));
  EXPECT_THAT(edited("TURNER_ARRAY(Materials, 7,", "TURNER_ARRAY(Materials, 8,"), HasSubstr("Materials is"));
  EXPECT_THAT(edited("TURNER_BLOCK(State, 1,", "TURNER_BLOCK(State, 2,"), HasSubstr("State is"));
  EXPECT_EQ(edited("#undef TURNER_ARRAY", "TURNER_CONSTANT(Mine, 40, uint, MINE, 1u)\n#undef TURNER_ARRAY"), "");
}

// What the kernel's check knows of the blocks comes from the text.
TEST(LayoutText, MembersAreThoseOfTheCompiler) {
  const auto check = [](const char* structure, size_t size, const char* name, size_t offset, const char* type) {
    const std::vector<LayoutMember> members = layoutMembers(structure);
    ASSERT_FALSE(members.empty()) << structure;
    EXPECT_EQ(members.back().offset + members.back().size, size) << structure;
    const auto found = std::find_if(members.begin(), members.end(), [&](const auto& m) { return m.name == name; });
    ASSERT_NE(found, members.end()) << name;
    EXPECT_EQ(found->offset, offset) << name;
    EXPECT_EQ(found->type, type) << name;
  };
  check("Frame", sizeof(gpu::Frame), "minWeight", offsetof(gpu::Frame, minWeight), "float");
  check("Frame", sizeof(gpu::Frame), "media", offsetof(gpu::Frame, media), "uvec4");
  check("Frame", sizeof(gpu::Frame), "addresses", offsetof(gpu::Frame, addresses), "uvec4");
  check("Tile", sizeof(gpu::Tile), "groups", offsetof(gpu::Tile, groups), "uint");
  check("Status", sizeof(gpu::Status), "mediaLost", offsetof(gpu::Status, mediaLost), "uint");
  EXPECT_TRUE(layoutMembers("Nothing").empty());
}

TEST(LayoutText, AdditionsPass) {
  EXPECT_EQ(afterEdit("// What the host reads after a dispatch.",
                      "TURNER_CONST kMine = 3u, kOther = kMine + 1u;\nstruct Mine { uint a; float b[3]; };"),
            "");
}

TEST(LayoutText, WhatIsMissingPasses) {
  EXPECT_EQ(afterEdit("TURNER_CONST kGrid = 0u;", ""), "");
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
