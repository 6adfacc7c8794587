// What an edited kernel may declare otherwise than the host expects it, and what it may not.
#include <gmock/gmock.h>
#include <glslang/SPIRV/spirv.hpp>

#include <algorithm>
#include <map>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include "base/errors.h"
#include "base/text_file.h"
#include "kernel/buffer_access.h"
#include "kernel/compile.h"
#include "kernel/kernel_check.h"
#include "kernel/shader_sources.h"
#include "kernel/spirv_words.h"
#include "layout.h"

namespace turner {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

constexpr BufferAccess kAllWays[] = {BufferAccess::texelBuffer, BufferAccess::storageBuffer,
                                     BufferAccess::deviceAddress};

std::string shaderPath(const std::string& file) {
  return TURNER_SHADERS_DIR "/" + file;
}

struct Edit {
  std::string file, from, to;
};

ShaderSource& sourceIn(std::vector<ShaderSource>& sources, const std::string& file) {
  const auto source =
      std::find_if(sources.begin(), sources.end(), [&](const ShaderSource& s) { return s.path == shaderPath(file); });
  if (source == sources.end()) throw RunError("no source " + file);
  return *source;
}

// The kernel's sources with the lines of interface.h written out as declarations, as an author may: blocks in
// whitted.comp, arrays in buffer_access.glsl, constants in layout.h.
std::vector<ShaderSource> writtenOut() {
  std::vector<ShaderSource> sources = readShaderSources(shaderPath("whitted.comp"));
  std::string blocks, arrays, constants;
  std::istringstream interface(*sourceIn(sources, "interface.h").text);
  for (std::string line; std::getline(interface, line);) {
    std::smatch m;
    static const std::regex block(R"(TURNER_BLOCK\((\w+), \d+, (\w*), (\w+), (\w+), (.*), ".*)"),
        array(R"(TURNER_ARRAY\((\w+), \d+, (\w+), ".*)"),
        constant(R"(TURNER_(?:CONSTANT|FEATURE)\((\w+), \d+, (\w+), (\w+), (\w+).*)");
    if (std::regex_match(line, m, block))
      blocks += "layout(std430, binding = kBind" + m.str(1) + ") " + m.str(2) + " buffer " + m.str(1) + "Buffer { " +
                m.str(3) + ' ' + m.str(4) + m.str(5) + "; };\n";
    else if (std::regex_match(line, m, array))
      arrays += "WORDS(" + m.str(2) + ", kBind" + m.str(1) + ");\n";
    else if (std::regex_match(line, m, constant))
      constants +=
          "layout(constant_id = kSpec" + m.str(1) + ") const " + m.str(2) + ' ' + m.str(3) + " = " + m.str(4) + ";\n";
  }
  const auto replaceFrom = [&](const std::string& file, const std::string& from, const std::string& to,
                               const std::string& by) {
    std::string& text = *sourceIn(sources, file).text;
    const size_t begin = text.find(from), end = text.find(to, begin);
    if (begin == std::string::npos || end == std::string::npos) throw RunError(from + " is not in " + file);
    text.replace(begin, end + to.size() - begin, by);
  };
  const std::string include = "#include \"interface.h\"\n";
  replaceFrom("whitted.comp", "#define TURNER_BLOCK", include, blocks);
  replaceFrom("buffer_access.glsl", "#define TURNER_ARRAY", include, arrays);
  replaceFrom("layout.h", "  layout(constant_id = id) const type NAME = value;", "\n", "\n");
  replaceFrom("layout.h", include, "\n", include + "#ifndef __cplusplus\n" + constants + "#endif\n");
  return sources;
}

// The same with some texts replaced, each of which must stand in its file once.
std::vector<ShaderSource> edited(const std::vector<Edit>& edits) {
  std::vector<ShaderSource> sources = writtenOut();
  for (const Edit& edit : edits) {
    ShaderSource* const source = &sourceIn(sources, edit.file);
    const size_t at = source->text->find(edit.from);
    if (at == std::string::npos || source->text->find(edit.from, at + 1) != std::string::npos)
      throw RunError("'" + edit.from + "' does not stand once in " + edit.file);
    source->text->replace(at, edit.from.size(), edit.to);
  }
  return sources;
}

// Empty if the kernel may be used.
std::string complaintAbout(const std::vector<ShaderSource>& sources, BufferAccess access) {
  const Spirv kernel = compileGlsl(sources, accessPreamble(access));
  try {
    checkKernel(kernel, sources, access);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}
std::string complaintAbout(const std::vector<Edit>& edits, BufferAccess access = BufferAccess::storageBuffer) {
  return complaintAbout(edited(edits), access);
}

// "path:12:3: error: " of the first byte of `at` in the edited file.
std::string placeOf(const std::vector<Edit>& edits, const std::string& file, const std::string& at) {
  for (const ShaderSource& source : edited(edits)) {
    if (source.path != shaderPath(file)) continue;
    const size_t offset = source.text->find(at);
    if (offset == std::string::npos) throw RunError("'" + at + "' does not stand in " + file);
    const std::string before = source.text->substr(0, offset);
    return source.path + ':' + std::to_string(1 + std::count(before.begin(), before.end(), '\n')) + ':' +
           std::to_string(before.size() - (before.rfind('\n') + 1) + 1) + ": error: ";
  }
  throw RunError("no source " + file);
}

size_t linesOf(const std::string& text) {
  return text.empty() ? 0 : size_t(1 + std::count(text.begin(), text.end(), '\n'));
}

// A kernel that uses nothing of the host's but what the declarations and statements do.
std::vector<ShaderSource> smallKernel(const std::string& declarations, const std::string& statements) {
  std::vector<ShaderSource> sources = writtenOut();
  std::string& layout = *sourceIn(sources, "layout.h").text;
  const size_t constants = layout.find("#ifndef __cplusplus\nlayout(constant_id");
  layout.erase(constants, layout.find("#endif", constants) - constants + 6);
  sources[0].text =
      "#version 460\n#extension GL_GOOGLE_include_directive : require\n#include \"layout.h\"\n"
      "layout(local_size_x_id = kSpecWorkGroup, local_size_y = 1, local_size_z = 1) in;\n"
      "layout(std430, binding = kBindPixels) buffer PixelsBuffer { Word4 pixels[]; };\n" +
      declarations + "void main() {\n" + statements + "}\n";
  return sources;
}

TEST(KernelCheck, TheKernelPassesInAllWaysOfFetching) {
  for (const BufferAccess access : kAllWays) {
    EXPECT_EQ(complaintAbout(readShaderSources(shaderPath("whitted.comp")), access), "") << accessName(access);
    EXPECT_EQ(complaintAbout(std::vector<Edit>(), access), "") << accessName(access) << ", written out";
  }
}

// --- changes that the host does not mind -----------------------------------------------------------------------------

TEST(KernelCheck, APrivateConstantPasses) {
  const Edit edit = {"resume.glsl", "const uint kDone = kPixelDone;",
                     "const uint kDone = kPixelDone;\nconst float kMine[2] = {0.5, 2.0};"};
  for (const BufferAccess access : kAllWays)
    EXPECT_EQ(complaintAbout({edit, {"whitted.comp", "sum / float(SAMPLES", "kMine[phase & 1u] * sum / float(SAMPLES"}},
                             access),
              "")
        << accessName(access);
}

TEST(KernelCheck, AConstantIdOfTheUsersOwnPasses) {
  const std::vector<Edit> edits = {{"resume.glsl", "const uint kDone = kPixelDone;",
                                    "const uint kDone = kPixelDone;\nlayout(constant_id = 40) const float MINE = 0.5;"},
                                   {"whitted.comp", "sum / float(SAMPLES", "MINE * sum / float(SAMPLES"}};
  EXPECT_EQ(complaintAbout(edits), "");
}

TEST(KernelCheck, AnUnusedBindingMayGo) {
  const std::vector<Edit> edits = {
      {"buffer_access.glsl", "WORDS(lights, kBindLights);", ""},
      {"scene.h", "Word4 a = WORD4(lights, kLightWords * index), b = WORD4(lights, kLightWords * index + 1u);",
       "Word4 a = Word4(0u), b = Word4(0u);"}};
  for (const BufferAccess access : kAllWays) EXPECT_EQ(complaintAbout(edits, access), "") << accessName(access);
}

TEST(KernelCheck, MembersAtTheEndMayBeLeftAway) {
  const std::vector<Edit> edits = {
      {"whitted.comp", "buffer StatusBuffer { Status status; };",
       "buffer StatusBuffer { uint unfinished, limiter, samplesWaiting; } status;"},
      {"whitted.comp", "if (NESTED_DIELECTRICS && mediaLost) atomicAdd(status.mediaLost, 1u);", ""}};
  EXPECT_EQ(complaintAbout(edits), "");
}

TEST(KernelCheck, SharedMemoryAndSubgroupsPass) {
  EXPECT_EQ(complaintAbout(
                smallKernel("#extension GL_KHR_shader_subgroup_ballot : require\nshared uint kept[64];\n",
                            "  kept[gl_LocalInvocationIndex & 63u] = subgroupBallotBitCount(subgroupBallot(true));\n"
                            "  barrier();\n  pixels[0].x = kept[0];\n"),
                BufferAccess::storageBuffer),
            "");
}

TEST(KernelCheck, ABlockMayHaveAnotherName) {
  EXPECT_EQ(complaintAbout({{"whitted.comp", "buffer StateBuffer { Word4 state[]; };",
                             "buffer Waiting { Word4 words[]; };\n#define state words"}}),
            "");
}

// --- bindings --------------------------------------------------------------------------------------------------------

TEST(KernelCheck, ABindingBeyondTheHostsIsRefused) {
  const Edit edit = {"whitted.comp", "binding = kBindStatus", "binding = 12"};
  for (const BufferAccess access : kAllWays)
    EXPECT_THAT(complaintAbout({edit}, access),
                AllOf(StartsWith(placeOf({edit}, "whitted.comp", "StatusBuffer")),
                      HasSubstr("StatusBuffer has binding 12; turner binds 0 to " +
                                std::string(access == BufferAccess::deviceAddress ? "3" : "9")),
                      HasSubstr("; take one of these")))
        << accessName(access);
}

TEST(KernelCheck, SwappedBindingsAreRefused) {
  const std::vector<Edit> edits = {
      {"whitted.comp", "kBindState)  buffer StateBuffer", "kBindPixels)  buffer StateBuffer"},
      {"whitted.comp", "kBindPixels)  buffer PixelsBuffer", "kBindState)  buffer PixelsBuffer"}};
  const std::string complaint = complaintAbout(edits);
  EXPECT_THAT(complaint,
              HasSubstr(placeOf(edits, "whitted.comp", "StateBuffer") +
                        "StateBuffer has binding 2, where turner binds the pixels; write binding = kBindState"));
  EXPECT_THAT(complaint, HasSubstr(placeOf(edits, "whitted.comp", "PixelsBuffer") +
                                   "PixelsBuffer has binding 1, where turner binds the state of the invocations; write "
                                   "binding = kBindPixels"));
  EXPECT_EQ(linesOf(complaint), 2u);
}

TEST(KernelCheck, SwappedRowsAreRefusedAtTheirMacros) {
  const std::vector<Edit> edits = {
      {"buffer_access.glsl", "WORDS(nodes, kBindNodes)", "WORDS(nodes, kBindPrimitives)"},
      {"buffer_access.glsl", "WORDS(primitives, kBindPrimitives)", "WORDS(primitives, kBindNodes)"}};
  for (const BufferAccess access : {BufferAccess::texelBuffer, BufferAccess::storageBuffer}) {
    const std::string complaint = complaintAbout(edits, access);
    EXPECT_EQ(linesOf(complaint), 2u) << complaint;
    EXPECT_THAT(complaint, HasSubstr(placeOf(edits, "buffer_access.glsl", "nodes, kBindPrimitives")));
    EXPECT_THAT(complaint, HasSubstr("has binding 5, where turner binds the primitives; write binding = kBindNodes"));
    EXPECT_THAT(complaint, HasSubstr(placeOf(edits, "buffer_access.glsl", "primitives, kBindNodes")));
  }
}

TEST(KernelCheck, AnotherSetIsRefused) {
  const Edit edit = {"whitted.comp", "layout(std430, binding = kBindStatus)",
                     "layout(std430, set = 1, binding = kBindStatus)"};
  EXPECT_THAT(complaintAbout({edit}), AllOf(StartsWith(placeOf({edit}, "whitted.comp", "StatusBuffer")),
                                            HasSubstr("is in descriptor set 1"), HasSubstr("leave the set away")));
}

TEST(KernelCheck, ASecondUseOfABindingIsRefused) {
  const std::vector<Edit> edits = {
      {"whitted.comp", "Frame frame;", "layout(std430, binding = 1) buffer Extra { float extra[]; };\nFrame frame;"},
      {"whitted.comp", "sum / float(SAMPLES", "extra[pixelAt] * sum / float(SAMPLES"}};
  EXPECT_THAT(complaintAbout(edits),
              AllOf(StartsWith(placeOf(edits, "whitted.comp", "Extra")), HasSubstr("Extra holds float[]"),
                    HasSubstr("at binding 1 turner binds the state of the invocations")));
}

TEST(KernelCheck, RowsInAnotherWayAreRefused) {
  // The kernel that was compiled for one way, with the host fetching in another.
  const std::vector<ShaderSource> sources = edited({});
  const auto complaint = [&](BufferAccess compiled, BufferAccess bound) {
    try {
      checkKernel(compileGlsl(sources, accessPreamble(compiled)), sources, bound);
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  const std::string location = placeOf({}, "buffer_access.glsl", "nodes, kBindNodes");
  EXPECT_THAT(
      complaint(BufferAccess::texelBuffer, BufferAccess::storageBuffer),
      HasSubstr(location + "nodes is a storage texel buffer; at binding 4 turner binds the nodes as a storage buffer"));
  EXPECT_THAT(
      complaint(BufferAccess::storageBuffer, BufferAccess::texelBuffer),
      HasSubstr(location + "nodesBuffer is a storage buffer; at binding 4 turner binds the nodes as a storage texel "
                           "buffer; declare it by WORDS() of buffer_access.glsl"));
  EXPECT_EQ(linesOf(complaint(BufferAccess::storageBuffer, BufferAccess::texelBuffer)), size_t(kSceneArrays));
  EXPECT_THAT(
      complaint(BufferAccess::storageBuffer, BufferAccess::deviceAddress),
      HasSubstr(location + "nodesBuffer has binding 4; turner binds 0 to 3 where rows are fetched as addresses; read "
                           "rows by WORD4() of buffer_access.glsl"));
  EXPECT_THAT(complaint(BufferAccess::deviceAddress, BufferAccess::storageBuffer),
              HasSubstr("needs PhysicalStorageBufferAddresses, which turner's device is not opened with where rows are "
                        "fetched as buffers"));
}

TEST(KernelCheck, TexelsOfAnotherFormatAreRefused) {
  const std::vector<Edit> edits = {{"buffer_access.glsl", "rgba32ui) readonly", "rgba16ui) readonly"}};
  EXPECT_THAT(complaintAbout(edits, BufferAccess::texelBuffer),
              AllOf(HasSubstr(placeOf(edits, "buffer_access.glsl", "nodes, kBindNodes")),
                    HasSubstr("nodes has texels of another format; turner binds the nodes as rgba32ui")));
}

TEST(KernelCheck, OtherResourcesAreRefused) {
  const struct {
    std::string declaration, statement, complaint;
  } cases[] = {
      {"layout(binding = 0) uniform Params { vec4 tint; };\n", "  pixels[0] = floatBitsToUint(tint);\n",
       "Params is a uniform buffer; turner binds none"},
      {"layout(binding = 4) uniform sampler2D Params;\n",
       "  pixels[0] = floatBitsToUint(textureLod(Params, vec2(0), 0.0));\n",
       "Params is a texture that turner does not bind"},
      {"layout(binding = 4, rgba32ui) uniform uimage2D Params;\n", "  pixels[0] = imageLoad(Params, ivec2(0));\n",
       "Params is an image that turner does not bind"},
      {"layout(binding = 4) uniform usamplerBuffer Params;\n", "  pixels[0] = texelFetch(Params, 0);\n",
       "Params is a texture that turner does not bind"},
      {"layout(std430, binding = 4) buffer Params { Word4 rows[]; } many[2];\n", "  pixels[0] = many[1].rows[0];\n",
       " is an array of bindings"},
  };
  for (const auto& each : cases) {
    const std::vector<ShaderSource> sources = smallKernel(each.declaration, each.statement);
    const std::string complaint = complaintAbout(sources, BufferAccess::storageBuffer);
    EXPECT_THAT(complaint, AllOf(StartsWith(sources[0].path + ":6:"), HasSubstr(each.complaint)));
    EXPECT_EQ(linesOf(complaint), 1u) << complaint;
  }
}

// --- blocks ----------------------------------------------------------------------------------------------------------

TEST(KernelCheck, SwappedMembersAreRefused) {
  const std::vector<Edit> edits = {{"layout.h", "uint limiter; ", "uint moved; "},
                                   {"layout.h", "uint samplesWaiting;", "uint limiter;"},
                                   {"layout.h", "uint moved; ", "uint samplesWaiting; "}};
  EXPECT_THAT(complaintAbout(edits),
              AllOf(StartsWith(placeOf(edits, "layout.h", "samplesWaiting; ")),
                    HasSubstr("samplesWaiting is at byte 4 of Status here, but at byte 8 in the running turner"),
                    HasSubstr("build turner with this file, or take the change back")));
}

TEST(KernelCheck, AnInsertedMemberIsOneFault) {
  const std::vector<Edit> edits = {{"layout.h", "vec3 centreHi;", "uvec4 mine; vec3 centreHi;"}};
  for (const BufferAccess access : kAllWays) {
    const std::string complaint = complaintAbout(edits, access);
    EXPECT_THAT(complaint, AllOf(StartsWith(placeOf(edits, "layout.h", "mine;")),
                                 HasSubstr("byte 0 of Frame is called mine here, but centreHi in the running turner")));
    EXPECT_EQ(linesOf(complaint), 1u) << complaint;
  }
}

TEST(KernelCheck, AMemberBehindTheHostsIsRefused) {
  const std::vector<Edit> edits = {{"layout.h", "uvec4 parameters[32];", "uvec4 parameters[32]; uvec4 mine;"}};
  EXPECT_THAT(complaintAbout(edits), AllOf(StartsWith(placeOf(edits, "layout.h", "mine;")),
                                           HasSubstr("mine is at byte 768 of Frame here, where nothing begins")));
  const std::vector<Edit> longer = {{"layout.h", "uvec4 parameters[32];", "uvec4 parameters[33];"}};
  EXPECT_THAT(complaintAbout(longer),
              AllOf(StartsWith(placeOf(longer, "layout.h", "parameters[33]")),
                    HasSubstr("parameters is a uvec4[33] here, but a uvec4[32] in the running turner")));
}

TEST(KernelCheck, AMemberOfAnotherTypeIsRefused) {
  const std::vector<Edit> edits = {
      {"whitted.comp", "buffer StatusBuffer { Status status; };",
       "buffer StatusBuffer { float unfinished; uint limiter, samplesWaiting, mediaLost; } status;"},
      {"resume.glsl", "atomicAdd(status.unfinished, 1u);", "status.unfinished = 1.0;"}};
  EXPECT_THAT(complaintAbout(edits), AllOf(StartsWith(placeOf(edits, "whitted.comp", "unfinished; uint limiter")),
                                           HasSubstr("unfinished is a float here, but a uint in the running turner")));
}

TEST(KernelCheck, ChangedPushConstantsAreRefused) {
  const std::vector<Edit> more = {
      {"whitted.comp", "uniform PushConstants { Tile tile; };", "uniform PushConstants { Tile tile; float gain; };"},
      {"whitted.comp", "sum / float(SAMPLES", "gain * sum / float(SAMPLES"}};
  EXPECT_THAT(complaintAbout(more), AllOf(StartsWith(placeOf(more, "whitted.comp", "gain; };")),
                                          HasSubstr("gain is at byte 32 of Tile here, where nothing begins")));
  const std::vector<Edit> moved = {{"whitted.comp", "uniform PushConstants { Tile tile; };",
                                    "uniform PushConstants { layout(offset = 16) Tile tile; };"}};
  EXPECT_THAT(complaintAbout(moved),
              AllOf(StartsWith(placeOf(moved, "layout.h", "x0, y0;")),
                    HasSubstr("x0 is at byte 16 of Tile here, but at byte 0 in the running turner")));
}

TEST(KernelCheck, AnotherStrideIsRefused) {
  const std::vector<Edit> edits = {
      {"whitted.comp", "buffer PixelsBuffer { Word4 pixels[]; };", "buffer PixelsBuffer { Pixel pixels[]; };"},
      {"whitted.comp", "layout(std430, binding = kBindPixels)",
       "struct Pixel { Word4 word, mine; };\nlayout(std430, binding = kBindPixels)"},
      {"resume.glsl", "pixels[pixelAt].w", "pixels[pixelAt].word.w"},
      {"whitted.comp", "pixels[pixelAt] = packWord", "pixels[pixelAt].word = packWord"}};
  for (const BufferAccess access : kAllWays)
    EXPECT_THAT(
        complaintAbout(edits, access),
        AllOf(StartsWith(placeOf(edits, "whitted.comp", "PixelsBuffer")),
              HasSubstr("PixelsBuffer holds struct Pixel[]; at binding 2 turner binds the pixels, which are rows"),
              HasSubstr("declare it as { Word4 pixels[]; }")));
}

TEST(KernelCheck, RowsBehindSomethingElseAreRefused) {
  EXPECT_THAT(complaintAbout({{"whitted.comp", "{ Word4 state[]; }", "{ Word4 mine; Word4 state[]; }"}}),
              HasSubstr("StateBuffer holds uvec4 and more"));
  EXPECT_THAT(complaintAbout({{"whitted.comp", "{ Word4 state[]; }", "{ layout(offset = 32) Word4 state[]; }"}}),
              HasSubstr("StateBuffer holds uvec4[] at byte 32, one element every 16 bytes"));
}

// --- specialisation constants and the work-group ---------------------------------------------------------------------

// Every id takes the type that interface.h gives it, and no other.
TEST(KernelCheck, ConstantsHaveTheTypesOfTheInterface) {
  std::vector<ShaderSource> sources = writtenOut();
  const std::string& features = *sourceIn(sources, "layout.h").text;
  int tried = 0;
  for (uint32_t id = 0; id < gpu::kSpecCount; ++id) {
    const std::string number = std::to_string(id);
    const auto complaint = [&](const std::string& type) {
      return complaintAbout(
          smallKernel("layout(constant_id = " + number + ") const " + type + " MINE = " + type + "(1);\n",
                      "  if (float(MINE) > 0.5) pixels[0].x = 1u;\n"),
          BufferAccess::storageBuffer);
    };
    const std::string asBool = complaint("bool"), asUint = complaint("uint");
    EXPECT_NE(asBool.empty(), asUint.empty()) << id;
    EXPECT_EQ(complaint("int").empty(), asUint.empty()) << id;
    EXPECT_THAT(complaint("float"), HasSubstr(":6:")) << id;
    const std::string& refused = asBool + asUint;
    // "MINE is a uint with the constant_id of kSpecSpheres, ..."
    const size_t at = refused.find("kSpec");
    ASSERT_NE(at, std::string::npos) << id;
    const std::string name = refused.substr(at, refused.find(',', at) - at);
    const size_t declared = features.find("constant_id = " + name + ")");
    if (declared == std::string::npos) {
      EXPECT_EQ(id, gpu::kSpecWorkGroup) << name;
      continue;
    }
    const size_t type = features.find("const ", declared) + 6;
    EXPECT_EQ(features.substr(type, 4) == "bool", asBool.empty()) << name;
    ++tried;
  }
  EXPECT_EQ(tried, int(gpu::kSpecCount) - 1);
}

TEST(KernelCheck, AConstantOfAnotherTypeIsRefused) {
  const std::vector<Edit> edit = {{"layout.h", "const bool COUNTERS = false;",
                                   "const uint COUNTERS_ON = 0u;\nconst bool COUNTERS = COUNTERS_ON != 0u;"}};
  EXPECT_THAT(
      complaintAbout(edit),
      AllOf(StartsWith(placeOf(edit, "layout.h", "COUNTERS_ON = 0u")),
            HasSubstr("COUNTERS_ON is a uint with the constant_id of kSpecCounters, for which turner gives a bool"),
            HasSubstr("take an id from " + std::to_string(gpu::kSpecCount) + " on for a constant of your own")));
}

TEST(KernelCheck, SwappedConstantsAreRefused) {
  const std::vector<Edit> edits = {{"layout.h", "kSpecDepth) const uint DEPTH", "kSpecSamples) const uint DEPTH"},
                                   {"layout.h", "kSpecSamples) const uint SAMPLES", "kSpecDepth) const uint SAMPLES"}};
  const std::string complaint = complaintAbout(edits);
  EXPECT_THAT(complaint,
              HasSubstr(placeOf(edits, "layout.h", "DEPTH = ") +
                        "DEPTH has the constant_id of kSpecSamples, but turner gives it as kSpecDepth; write "
                        "constant_id = kSpecDepth"));
  EXPECT_THAT(complaint, HasSubstr(placeOf(edits, "layout.h", "SAMPLES = ")));
  EXPECT_EQ(linesOf(complaint), 2u);
}

TEST(KernelCheck, AnotherWorkGroupIsRefused) {
  const std::string original = "local_size_x_id = kSpecWorkGroup, local_size_y = 1, local_size_z = 1";
  for (const char* other : {"local_size_x = 64, local_size_y = 1, local_size_z = 1", "local_size_x = 1",
                            "local_size_x_id = 30, local_size_y = 1, local_size_z = 1",
                            "local_size_x_id = kSpecWorkGroup, local_size_y = 2, local_size_z = 1",
                            "local_size_x_id = kSpecWorkGroup, local_size_y_id = kSpecDepth, local_size_z = 1",
                            "local_size_y_id = kSpecWorkGroup, local_size_x = 1, local_size_z = 1"}) {
    std::vector<ShaderSource> sources = smallKernel("", "  pixels[gl_WorkGroupID.x] = Word4(1u);\n");
    sources[0].text->replace(sources[0].text->find(original), original.size(), other);
    EXPECT_THAT(complaintAbout(sources, BufferAccess::storageBuffer),
                AllOf(StartsWith(sources[0].path + ":4:"), HasSubstr("write layout(local_size_x_id = kSpecWorkGroup, "
                                                                     "local_size_y = 1, local_size_z = 1) in;")))
        << other;
  }
  const std::vector<Edit> edits = {{"whitted.comp", "local_size_x_id = kSpecWorkGroup", "local_size_x = 64"}};
  EXPECT_THAT(complaintAbout(edits), StartsWith(placeOf(edits, "whitted.comp", "local_size_x = 64")));
}

// --- the device ------------------------------------------------------------------------------------------------------

TEST(KernelCheck, WhatTheDeviceIsNotOpenedWithIsRefused) {
  const std::vector<ShaderSource> fine =
      smallKernel("double exact = 1.0;\n", "  exact *= double(pixels[0].x);\n  pixels[0].x = uint(exact);\n");
  EXPECT_THAT(
      complaintAbout(fine, BufferAccess::storageBuffer),
      StartsWith(fine[0].path + ":6:1: error: the kernel needs Float64, which turner's device is not opened with; "
                                "do without it"));
  const std::vector<ShaderSource> wide =
      smallKernel("#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require\n",
                  "  uint64_t mine = uint64_t(pixels[0].x) << 3;\n  pixels[0].x = uint(mine >> 2);\n");
  EXPECT_THAT(complaintAbout(wide, BufferAccess::storageBuffer),
              AllOf(StartsWith(wide[0].path + ":8:3: "), HasSubstr("needs Int64")));
  const std::vector<ShaderSource> printing =
      smallKernel("#extension GL_EXT_debug_printf : require\n", "  debugPrintfEXT(\"%u\", pixels[0].x);\n");
  EXPECT_THAT(
      complaintAbout(printing, BufferAccess::storageBuffer),
      AllOf(StartsWith(printing[0].path + ":"), HasSubstr("needs the SPIR-V extension SPV_KHR_non_semantic_info")));
}

// --- the words -------------------------------------------------------------------------------------------------------

TEST(KernelCheck, AllFaultsAreToldAtOnce) {
  const std::vector<Edit> edits = {
      {"whitted.comp", "local_size_y = 1", "local_size_y = 2"},
      {"whitted.comp", "binding = kBindStatus", "binding = 12"},
      {"whitted.comp", "{ Word4 state[]; }", "{ Word4 mine; Word4 state[]; }"},
      {"layout.h", "const bool FALLOFF = true", "const uint FALLING = 1u;\nconst bool FALLOFF = FALLING != 0u"}};
  EXPECT_EQ(linesOf(complaintAbout(edits)), 4u);
}

TEST(KernelCheck, WordsThatAreNoSpirvAreRefused) {
  const std::vector<ShaderSource> sources = edited({});
  Spirv kernel = compileGlsl(sources, accessPreamble(BufferAccess::storageBuffer));
  const auto complaint = [&](const std::vector<uint32_t>& words) {
    try {
      checkKernel({words}, sources, BufferAccess::storageBuffer);
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_EQ(complaint(kernel.words), "");
  EXPECT_THAT(complaint({}), HasSubstr("is no valid SPIR-V for Vulkan 1.2"));
  EXPECT_NE(complaint({spv::MagicNumber}), "");
  // Damage in the declarations, here and there: no crash, whatever is made of them.
  for (size_t at = 5; at < 4000; at += 149) {
    for (const uint32_t damage : {0u, 0xffffffffu, 0x0001003bu, 0x7fff001eu}) {
      std::vector<uint32_t> words = kernel.words;
      words[at] = damage;
      words.resize(std::min<size_t>(words.size(), 12000));
      EXPECT_NE(complaint(words), "");
    }
  }
}

TEST(SpirvWords, CountsInstructionsAndStopsWhereTheyMakeNoSense) {
  const std::vector<uint32_t> header(kSpirvHeaderWords);
  const auto with = [&](std::vector<uint32_t> words) {
    words.insert(words.begin(), header.begin(), header.end());
    return words;
  };
  using Counts = std::map<uint16_t, size_t>;
  EXPECT_EQ(countInstructions({}), Counts());
  EXPECT_EQ(countInstructions(with({0x10007, 0x20008, 5, 0x10007})), (Counts{{7, 2}, {8, 1}}));
  EXPECT_EQ(countInstructions(with({0x10007, 0x30008, 5})), (Counts{{7, 1}}));
  EXPECT_EQ(countInstructions(with({0x10007, 8, 0x10007})), (Counts{{7, 1}}));
}

TEST(SpirvWords, ComparesInstructionsByOpcode) {
  const std::vector<uint32_t> before = {0, 0, 0, 0, 0, 0x10007, 0x10007, 0x10008, 0x1000a};
  const std::vector<uint32_t> after = {0, 0, 0, 0, 0, 0x10008, 0x10007, 0x10009, 0x10009, 0x1000a};
  const InstructionChange change = compareInstructions(before, after);
  EXPECT_EQ(change.total, 5u);
  EXPECT_EQ(change.added, 2u);
  EXPECT_EQ(change.removed, 1u);
  EXPECT_EQ(compareInstructions(after, after).added, 0u);
  EXPECT_EQ(compareInstructions(after, after).removed, 0u);
  EXPECT_EQ(compareInstructions({}, after).added, 5u);
}

TEST(SpirvWords, AnAddedMultiplicationIsSeen) {
  const auto words = [](const std::vector<Edit>& edits) {
    return compileGlsl(edited(edits), accessPreamble(BufferAccess::storageBuffer)).words;
  };
  const std::vector<uint32_t> before = words({});
  const std::vector<uint32_t> after =
      words({{"whitted.comp", "float(SAMPLES * SAMPLES), phase", "float(SAMPLES * SAMPLES) * (sum.x * sum.y), phase"}});
  EXPECT_GT(countInstructions(after)[spv::OpFMul], countInstructions(before)[spv::OpFMul]);
  EXPECT_GT(compareInstructions(before, after).added, 0u);
}

}  // namespace
}  // namespace turner
