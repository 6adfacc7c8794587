#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "base/errors.h"
#include "kernel/compile.h"

namespace turner {
namespace {

using testing::HasSubstr;

class Glsl : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = testing::TempDir() + "glsl_" + testing::UnitTest::GetInstance()->current_test_info()->name();
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::string write(const std::string& name, const std::string& text) {
    const std::string path = folder_ + "/" + name;
    std::ofstream(path) << text;
    return path;
  }
  static std::string messageOf(const std::string& path) {
    try {
      compileGlsl(path);
    } catch (const InputError& error) {
      return error.what();
    }
    return "compiles";
  }
  const std::string head_ =
      "#version 460\n#extension GL_GOOGLE_include_directive : require\nlayout(local_size_x = 1) in;\n";
  std::string folder_;
};

TEST_F(Glsl, CompilesTheKernelAndNamesItsFiles) {
  const Spirv spirv = compileGlsl(TURNER_SHADERS_DIR "/whitted.comp");
  ASSERT_FALSE(spirv.words.empty());
  EXPECT_EQ(spirv.words[0], 0x07230203u);
  EXPECT_EQ(spirv.words[1], 0x00010500u) << "SPIR-V 1.5 is what Vulkan 1.2 takes";
  EXPECT_THAT(spirv.files, testing::Contains(testing::EndsWith("shade.glsl")));
  EXPECT_THAT(spirv.files[0], testing::EndsWith("whitted.comp"));
}

TEST_F(Glsl, FaultHasFileAndLine) {
  const std::string path = write("a.comp", head_ + "void main() {\n  int x = undefinedName;\n}\n");
  EXPECT_THAT(messageOf(path), HasSubstr(path + ":5: error: 'undefinedName'"));
}

TEST_F(Glsl, FaultInAnIncludeNamesTheInclude) {
  const std::string include = write("part.glsl", "float f() {\n  return 1.0\n}\n");
  const std::string path = write("a.comp", head_ + "#include \"part.glsl\"\nvoid main() {}\n");
  EXPECT_THAT(messageOf(path), HasSubstr(include + ":3: error: "));
}

TEST_F(Glsl, FaultBehindAnIncludeHasTheRightLine) {
  write("part.glsl", "float f() { return 1.0; }\n\n\n\n");
  const std::string path = write("a.comp", head_ + "#include \"part.glsl\"\nvoid main() { oops; }\n");
  EXPECT_THAT(messageOf(path), HasSubstr(path + ":5: error: 'oops'"));
}

TEST_F(Glsl, MissingIncludeIsNamedAtItsPlace) {
  const std::string path = write("a.comp", head_ + "#include \"nowhere.glsl\"\nvoid main() {}\n");
  EXPECT_THAT(messageOf(path), HasSubstr(path + ":4: error: "));
  EXPECT_THAT(messageOf(path), HasSubstr("nowhere.glsl"));
}

TEST_F(Glsl, FileThatIncludesItselfEnds) {
  const std::string path = write("a.comp", head_ + "#include \"loop.glsl\"\nvoid main() {}\n");
  write("loop.glsl", "#include \"loop.glsl\"\n");
  EXPECT_THAT(messageOf(path), HasSubstr("loop.glsl:1: error: "));
  EXPECT_THAT(messageOf(path), HasSubstr("nest too deep"));
}

TEST_F(Glsl, MissingFileIsNamed) {
  EXPECT_THAT(messageOf(folder_ + "/none.comp"), HasSubstr("none.comp: error: cannot open"));
}

TEST_F(Glsl, ShaderWithoutMainIsRefused) {
  const std::string path = write("a.comp", head_);
  EXPECT_THAT(messageOf(path), HasSubstr("a.comp: error: "));
}

}  // namespace
}  // namespace turner
