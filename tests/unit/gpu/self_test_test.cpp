// The self-test of devices: this one passes; a device that got one thing wrong, which is played by a test that asks for
// something else, would be told what.
#include "gpu/self_test.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "base/errors.h"
#include "base/text_file.h"
#include "gpu/devices.h"
#include "support/environment.h"
#include "support/shader_harness.h"
#include "support/temporary_folder.h"

namespace turner {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

class SelfTest : public testing::Test {
 protected:
  Device device{chooseDevice(listDevices(), test::wantedDevice())};
  BufferAccess access =
      device.canAccess(BufferAccess::texelBuffer) ? BufferAccess::texelBuffer : BufferAccess::storageBuffer;

  // The self-test with one line replaced.
  static std::vector<ShaderSource> altered(const std::string& line, const std::string& by) {
    std::vector<ShaderSource> sources = selfTestSources();
    int found = 0;
    for (ShaderSource& source : sources) {
      const size_t at = source.text->find(line);
      if (at == std::string::npos) continue;
      source.text->replace(at, line.size(), by);
      ++found;
    }
    EXPECT_EQ(found, 1) << line;
    return sources;
  }
};

TEST_F(SelfTest, PassesInEveryWayToFetch) {
  for (const BufferAccess way : {BufferAccess::texelBuffer, BufferAccess::storageBuffer, BufferAccess::deviceAddress}) {
    if (!device.canAccess(way)) continue;
    for (const bool loopsAtHead : {false, true})
      EXPECT_THAT(runSelfTest(device, way, selfTestSources(), loopsAtHead), IsEmpty()) << accessName(way);
  }
}

// Each way in which a driver may go wrong, with the words that name it.
TEST_F(SelfTest, TellsWhatIsWrong) {
  struct Wrong {
    const char *line, *by, *told;
  };
  const Wrong wrongs[] = {
      {"random.x ^ random.y ^", "random.x ^ random.x ^", "buffer_access.glsl"},
      // As if a lane had made its last turn again.
      {"if (taken)", "if (taken || left == 2u)", "loops that they leave one by one"},
      {"next = stack[top];", "next = stack[0];", "keep in a stack"},
      {"+ invocation] = word.z;", "] = word.z;", "keep in a stack or a buffer"},
      {"random.w << (random.x & 31u)", "random.w << (random.x & 15u)", "integer arithmetic"},
      {"precise float restExact = (a - aRounded) + (b - bRounded);", "float restExact = 0.0;", "twoSum"},
      {"precise float restExact = ((aHi * bHi - product) + aHi * bLo + aLo * bHi) + aLo * bLo;",
       "float restExact = 0.0;", "twoProduct"},
      // As a fused multiplication and addition has it.
      {"precise float area = to.x * from.y - to.y * from.x;",
       "float lost; precise float product = twoProduct(to.x, from.y, lost); "
       "precise float other = to.y * from.x; precise float area = (product - other) + lost;",
       "edgeArea"},
      {"atomicAdd(results[kCheckedCounter], 1u);", "results[kCheckedCounter] = 1u;", "has lost 127 of 128"}};
  for (const Wrong& wrong : wrongs)
    EXPECT_THAT(runSelfTest(device, access, altered(wrong.line, wrong.by), false), ElementsAre(HasSubstr(wrong.told)));
}

TEST_F(SelfTest, RefusesADeviceThatFails) {
  try {
    testDevice(device, access, altered("next = stack[top];", "next = stack[0];"));
    ADD_FAILURE() << "nothing was thrown";
  } catch (const RunError& error) {
    EXPECT_THAT(error.what(), HasSubstr(device.info().name));
    EXPECT_THAT(error.what(), HasSubstr("fails turner's self-test; its pictures would be wrong"));
    EXPECT_THAT(error.what(), HasSubstr("of 128 lanes\nchoose another device (turner devices)"));
  }
}

// A device that gets loops wrong but where they end at their head.
TEST_F(SelfTest, WorksAroundLoops) {
  const std::vector<ShaderSource> sources =
      altered("return sum + uint(budget);", "return LOOPS_AT_HEAD ? sum + uint(budget) : 0u;");
  const DeviceTrust trust = testDevice(device, access, sources);
  EXPECT_TRUE(trust.loopsAtHead);
  EXPECT_THAT(trust.note, HasSubstr(device.info().name));
  EXPECT_TRUE(testDevice(device, access, sources).loopsAtHead) << "from the cache";
}

TEST_F(SelfTest, IsRunOncePerDriver) {
  const test::TemporaryFolder folder;
  const test::EnvironmentVariable home("XDG_CACHE_HOME", folder.path.c_str());
  const auto results = [&] {
    std::vector<std::filesystem::path> found;
    for (const auto& entry : std::filesystem::directory_iterator(folder.path / "turner"))
      if (entry.path().extension() == ".self-test") found.push_back(entry.path());
    return found;
  };
  EXPECT_FALSE(testDevice(device, access, selfTestSources()).loopsAtHead);
  ASSERT_EQ(results().size(), 1u);
  EXPECT_EQ(readTextFile(results()[0].string()), "passed\n");
  // What is damaged is found out anew.
  std::filesystem::resize_file(results()[0], 3);
  EXPECT_FALSE(testDevice(device, access, selfTestSources()).loopsAtHead);
  EXPECT_EQ(readTextFile(results()[0].string()), "passed\n");
  // A test that failed is not kept.
  EXPECT_THROW(testDevice(device, access, altered("next = stack[top];", "next = stack[0];")), RunError);
  EXPECT_EQ(results().size(), 1u);
}

}  // namespace
}  // namespace turner
