#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/errors.h"
#include "gpu/devices.h"

namespace turner {
namespace {

const std::vector<DeviceInfo> kMachine = {
    {.index = 0, .name = "llvmpipe (LLVM 15)", .type = "CPU"},
    {.index = 1, .name = "Onboard Graphics 5", .type = "integrated GPU"},
    {.index = 2, .name = "Ancient Board 1", .type = "discrete GPU", .usable = false},
    {.index = 3, .name = "Big Board 9000", .type = "discrete GPU"},
    {.index = 4, .name = "Big Board 9000 Ti", .type = "discrete GPU"},
};

std::string refusal(const std::string& wanted, const std::vector<DeviceInfo>& devices = kMachine) {
  try {
    return "chose " + chooseDevice(devices, wanted).name;
  } catch (const InputError& error) {
    return error.what();
  }
}

TEST(Devices, TheBestIsAUsableDiscreteGpu) {
  EXPECT_EQ(chooseDevice(kMachine, "").index, 3);
}

TEST(Devices, SoftwareIsLastButWelcome) {
  EXPECT_EQ(chooseDevice({kMachine[0], kMachine[1]}, "").index, 1);
  EXPECT_EQ(chooseDevice({kMachine[0]}, "").index, 0);
}

TEST(Devices, AreNamedByIndexOrPartOfTheirName) {
  EXPECT_EQ(chooseDevice(kMachine, "1").index, 1);
  EXPECT_EQ(chooseDevice(kMachine, "LLVMPIPE").index, 0);
  EXPECT_EQ(chooseDevice(kMachine, "9000 ti").index, 4);
}

TEST(Devices, UnknownAndAmbiguousNamesListWhatThereIs) {
  EXPECT_THAT(refusal("radeon"), testing::AllOf(testing::HasSubstr("'radeon'"), testing::HasSubstr("1: Onboard")));
  EXPECT_THAT(refusal("7"), testing::HasSubstr("no device '7'"));
  EXPECT_THAT(refusal("-1"), testing::HasSubstr("no device '-1'"));
  EXPECT_THAT(refusal("big board"), testing::HasSubstr("more than one"));
  EXPECT_THAT(refusal("ancient"), testing::HasSubstr("not usable"));
}

TEST(Devices, NoneUsableIsTheMachinesFailure) {
  EXPECT_THROW(chooseDevice({kMachine[2]}, ""), RunError);
}

TEST(Devices, ThisMachineHasOne) {
  const std::vector<DeviceInfo> devices = listDevices();
  ASSERT_FALSE(devices.empty());
  EXPECT_TRUE(chooseDevice(devices, "").usable);
  EXPECT_FALSE(devices[0].name.empty());
  EXPECT_FALSE(devices[0].driver.empty());
}

}  // namespace
}  // namespace turner
