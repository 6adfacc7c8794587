// Pipelines are kept for later renders, the latest ones.
#include "gpu/pipeline.h"

#include <gtest/gtest.h>

#include <memory>

#include "gpu/devices.h"
#include "support/our_scenes.h"
#include "support/shader_harness.h"

namespace turner {
namespace {

TEST(KeptPipelines, AreTheLatestOnes) {
  const Scene scene = test::ours("diffuse");
  const RenderSettings settings = test::settingsOf(scene, 8, 8);
  const Features features = test::packed(scene, settings).features;
  const Device device{chooseDevice(listDevices(), test::wantedDevice())};
  const Spirv kernel = test::compileKernel(BufferAccess::storageBuffer);
  KeptPipelines pipelines;
  const auto withDepth = [&](int depth) {
    RenderSettings other = settings;
    other.depth = depth;
    const Constants constants = specialise(features, other, 64, kLeastBudget, false, true, false);
    return pipelines.find(device, kernel, constants, BufferAccess::storageBuffer, 2);
  };
  const std::weak_ptr<const Pipeline> first = withDepth(1), second = withDepth(2);
  EXPECT_EQ(withDepth(1), first.lock());
  const std::weak_ptr<const Pipeline> third = withDepth(3);
  EXPECT_TRUE(second.expired()) << "it was used before the others";
  EXPECT_EQ(withDepth(1), first.lock());
  EXPECT_EQ(withDepth(3), third.lock());
}

}  // namespace
}  // namespace turner
