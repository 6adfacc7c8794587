// A snippet that the shaders no longer have, or have twice, is told by its name.
#include <gmock/gmock.h>

#include "base/errors.h"
#include "base/text_file.h"
#include "support/shader_variant.h"

namespace turner::test {
namespace {

std::string complaintAbout(const Replacement& replacement) {
  try {
    ShaderVariant variant({&replacement, 1});
  } catch (const RunError& error) {
    return error.what();
  }
  return {};
}

TEST(ShaderVariant, ReplacesASnippet) {
  const Replacement replacement{"depth", "interface.h", "DEPTH, 5u)", "DEPTH, 6u)"};
  const std::string original = readTextFile(TURNER_SHADERS_DIR "/interface.h");
  const ShaderVariant variant({&replacement, 1});
  const std::string text = readTextFile(variant.folder() + "/shaders/interface.h");
  EXPECT_THAT(text, testing::HasSubstr("DEPTH, 6u)"));
  EXPECT_THAT(text, testing::Not(testing::HasSubstr("DEPTH, 5u)")));
  EXPECT_EQ(text.size(), original.size());
  EXPECT_EQ(readTextFile(TURNER_SHADERS_DIR "/interface.h"), original);
}

TEST(ShaderVariant, RefusesASnippetThatIsNotThere) {
  EXPECT_THAT(complaintAbout({"lost one", "interface.h", "no such text", ""}),
              testing::AllOf(testing::HasSubstr("'lost one'"), testing::HasSubstr("0 times in interface.h")));
}

TEST(ShaderVariant, RefusesASnippetThatIsThereMoreThanOnce) {
  EXPECT_THAT(complaintAbout({"common one", "interface.h", "TURNER_FEATURE", ""}), testing::HasSubstr("'common one'"));
}

}  // namespace
}  // namespace turner::test
