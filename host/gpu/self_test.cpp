// Random words go to the device; what it makes of them is computed here once more, in integers and in double, where
// sums and products of the numbers below are exact.
#include "gpu/self_test.h"

#include <array>
#include <bit>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <random>
#include <span>

#include "base/cache_folder.h"
#include "base/errors.h"
#include "base/text_file.h"
#include "gpu/self_test/self_test_layout.h"
#include "gpu/self_test_sources.h"
#include "kernel/compile.h"

namespace turner {
namespace {

using namespace gpu;
using Word = std::array<uint32_t, 4>;
using Words = std::array<Word, kSelfTestWords>;

// --- what must come out ---------------------------------------------------------------------------------------------

Words randomWords() {
  std::mt19937 random(1980);  // any seed would do
  Words words;
  for (Word& word : words)
    for (uint32_t& value : word) value = uint32_t(random());
  return words;
}

double numberOf(uint32_t bits) {
  return double(std::bit_cast<float>((bits & 0x807fffffu) | ((123u + ((bits >> 23) & 7u)) << 23)));
}

// Rounded once, whatever the host's compiler contracts.
double rounded(double value) {
  return double(float(value));
}

uint32_t hash(uint32_t x) {
  x = (x ^ (x >> 16)) * 0x7feb352du;
  x = (x ^ (x >> 15)) * 0x846ca68bu;
  return x ^ (x >> 16);
}

// The walk of self_test.comp, with its loops as one.
uint32_t walkTree(const Words& words, uint32_t key, int budget) {
  std::vector<uint32_t> stack;
  std::array<uint32_t, kSelfTestStates> states{};
  uint32_t next = 1, sum = 0;
  do {
    --budget;
    if (next == 0 && !stack.empty()) next = stack.back(), stack.pop_back();
    while (next > 0 && next < kSelfTestLeaves && budget > 0) {
      --budget;
      const Word& word = words[next];
      const bool first = ((word[3] ^ key) & 4) != 0;
      if (((word[2] ^ key) & 3) != 0) stack.push_back(2 * next + !first);
      next = 2 * next + first;
    }
    if (next < kSelfTestLeaves) continue;
    for (uint32_t left = 1 + (next & 3); next > 0 && budget > 0;) {
      --budget;
      const Word& word = words[next + left];
      if (((word[0] ^ key) & 8) != 0)
        sum = sum * 31 + word[1];
      else if (word[0] & 1)
        states[next & 3] = word[2];
      else
        sum ^= states[left & 3];
      --left;
      if (left == 0 || (word[2] & 48) == 0) next = 0;
    }
  } while ((next > 0 || !stack.empty()) && budget > 0);
  return sum + uint32_t(budget);
}

uint32_t integers(const Word& word) {
  return hash(word[0]) + uint32_t(31 - std::countl_zero(word[1] | 1u)) +
         uint32_t(std::countr_zero(word[2] | 0x80000000u)) + (word[3] << (word[0] & 31)) +
         std::bit_cast<uint32_t>(float(word[3] & 0xffffffu)) + word[2] % 255;
}

// A result and its rest in one word; a rest of -0 is 0.
uint32_t withRest(double value, double rest) {
  return hash(std::bit_cast<uint32_t>(float(value))) + (rest == 0 ? 0 : std::bit_cast<uint32_t>(float(rest)));
}

// All words of one invocation.
std::array<uint32_t, kChecks> expected(const Words& words, uint32_t invocation) {
  const Word& random = words[invocation];
  std::array<uint32_t, kChecks> result{};
  result[kCheckWords] = random[0] ^ random[1] ^ random[2] ^ random[3];
  result[kCheckTraversal] = walkTree(words, random[1], 1 + int(random[2] % 300));
  result[kCheckIntegers] = integers(random);

  const double a = numberOf(random[0]), b = numberOf(random[1]), c = numberOf(random[2]), d = numberOf(random[3]);
  const double sum = rounded(a + b), product = rounded(c * d), scale = numberOf(random[2] ^ random[3]);
  const double endX = rounded(a * scale), endY = rounded(b * scale);
  result[kCheckSum] = withRest(sum, a + b - sum);
  result[kCheckProduct] = withRest(product, c * d - product);
  result[kCheckArea] = withRest(scale, rounded(endX * b) - rounded(endY * a));
  return result;
}

// All checks in one word, in the shader's order of reports.
uint32_t inBrief(const std::array<uint32_t, kChecks>& checks) {
  uint32_t all = 0;
  for (const uint32_t value : checks) all = hash(all ^ value);
  return all;
}

// What is wrong, and what of the kernel relies on it.
constexpr std::array<const char*, kChecks> kFaults = {
    "words of the scene are read wrongly (shaders/buffer_access.glsl)",
    "what lanes compute in loops that they leave one by one, or keep in a stack or a buffer, is not what they have "
    "behind them (shaders/traverse.glsl, resume.glsl)",
    "integer arithmetic is wrong (shaders/sampling.glsl, scene.h)",
    "`precise` sums are not rounded one by one (shaders/float_float.glsl, twoSum)",
    "`precise` products are not rounded one by one (shaders/float_float.glsl, twoProduct)",
    "`precise` products are contracted with a difference, and rays would pass between triangles "
    "(shaders/triangle.glsl, edgeArea)"};

// --- on the device --------------------------------------------------------------------------------------------------

using Results = std::array<uint32_t, kCheckedCounter + 1>;

Results runOnDevice(const Device& device, BufferAccess access, const std::vector<uint32_t>& spirv, bool loopsAtHead,
                    const Words& words) {
  const Buffer input = device.uploadWords(std::as_bytes(std::span(words)), access, "words of the self-test");
  const Buffer states = device.hostBuffer(kSelfTestStates * kSelfTestInvocations * sizeof(uint32_t), "its states");
  const Buffer output = device.hostBuffer(sizeof(Results), "results of the self-test");
  std::memset(output.mapped, 0, sizeof(Results));
  std::memset(states.mapped, 0, size_t(states.size));

  const bool texels = access == BufferAccess::texelBuffer;
  const vk::DescriptorType inputType =
      texels ? vk::DescriptorType::eStorageTexelBuffer : vk::DescriptorType::eStorageBuffer;
  const uint32_t count = access == BufferAccess::deviceAddress ? 2 : 3;
  const std::array types = {vk::DescriptorType::eStorageBuffer, vk::DescriptorType::eStorageBuffer, inputType};
  const std::array buffers = {&output, &states, &input};
  std::vector<vk::DescriptorSetLayoutBinding> bindings;
  for (uint32_t i = 0; i < count; ++i) bindings.push_back({i, types[i], 1, vk::ShaderStageFlagBits::eCompute});
  const vk::raii::Device& vulkan = device.vulkan();
  const vk::raii::DescriptorSetLayout setLayout(vulkan, vk::DescriptorSetLayoutCreateInfo({}, bindings));
  const vk::PushConstantRange range(vk::ShaderStageFlagBits::eCompute, 0, sizeof(vk::DeviceAddress));
  const vk::raii::PipelineLayout layout(vulkan, vk::PipelineLayoutCreateInfo({}, *setLayout, range));
  const vk::raii::ShaderModule module(vulkan, vk::ShaderModuleCreateInfo({}, spirv));
  const uint32_t constant = loopsAtHead;
  const vk::SpecializationMapEntry entry(kSelfTestLoopsAtHead, 0, sizeof constant);
  const vk::SpecializationInfo specialization(1, &entry, sizeof constant, &constant);
  const vk::PipelineShaderStageCreateInfo stage({}, vk::ShaderStageFlagBits::eCompute, *module, "main",
                                                &specialization);
  const vk::raii::Pipeline pipeline(vulkan, nullptr, vk::ComputePipelineCreateInfo({}, stage, *layout));
  device.name(pipeline, "self-test");

  const vk::DescriptorPoolSize sizes[] = {{vk::DescriptorType::eStorageBuffer, 3},
                                          {vk::DescriptorType::eStorageTexelBuffer, 1}};
  const vk::raii::DescriptorPool pool(
      vulkan, vk::DescriptorPoolCreateInfo(vk::DescriptorPoolCreateFlagBits::eFreeDescriptorSet, 1, sizes));
  const vk::raii::DescriptorSets sets(vulkan, vk::DescriptorSetAllocateInfo(*pool, *setLayout));
  for (uint32_t i = 0; i < count; ++i) {
    const vk::DescriptorBufferInfo info(**buffers[i]->buffer, 0, buffers[i]->size);
    vk::WriteDescriptorSet write(*sets[0], i, 0, 1, types[i], nullptr, &info);
    if (i == 2 && texels) write.pTexelBufferView = &**input.texels;
    vulkan.updateDescriptorSets(write, {});
  }
  device.run([&](const vk::raii::CommandBuffer& commands) {
    commands.bindPipeline(vk::PipelineBindPoint::eCompute, *pipeline);
    commands.bindDescriptorSets(vk::PipelineBindPoint::eCompute, *layout, 0, *sets[0], {});
    commands.pushConstants<vk::DeviceAddress>(*layout, vk::ShaderStageFlagBits::eCompute, 0, input.address);
    const vk::MemoryBarrier before(vk::AccessFlagBits::eTransferWrite | vk::AccessFlagBits::eHostWrite,
                                   vk::AccessFlagBits::eShaderRead | vk::AccessFlagBits::eShaderWrite);
    commands.pipelineBarrier(vk::PipelineStageFlagBits::eTransfer | vk::PipelineStageFlagBits::eHost,
                             vk::PipelineStageFlagBits::eComputeShader, {}, before, {}, {});
    commands.dispatch(1, 1, 1);
    const vk::MemoryBarrier after(vk::AccessFlagBits::eShaderWrite, vk::AccessFlagBits::eHostRead);
    commands.pipelineBarrier(vk::PipelineStageFlagBits::eComputeShader, vk::PipelineStageFlagBits::eHost, {}, after, {},
                             {});
  });
  Results results;
  std::memcpy(results.data(), output.mapped, sizeof results);
  return results;
}

// --- the cache ------------------------------------------------------------------------------------------------------

constexpr std::string_view kPassed = "passed\n", kPassedAtHead = "passed with loops that end at their head\n";
constexpr std::string_view kSuffix = ".self-test";
constexpr size_t kMostKept = 16;

// Named by all that the result depends on: the driver's build, its lanes, the test. Empty: nothing is kept.
std::string cachePath(const Device& device, BufferAccess access, const std::vector<ShaderSource>& sources) {
  const std::string folder = cacheFolder();
  if (folder.empty()) return "";
  const char* lanes = std::getenv("LP_NATIVE_VECTOR_WIDTH");
  std::string all = device.identity() + '\n' + accessName(access) + '\n' + (lanes ? lanes : "") + '\n';
  for (const ShaderSource& source : sources) all += *source.text;
  return folder + '/' + sha256Hex(all) + std::string(kSuffix);
}

void keep(const std::string& path, std::string_view result) {
  if (!path.empty()) keepInCache(path, kSuffix, result, kMostKept);
}

}  // namespace

std::vector<ShaderSource> selfTestSources() {
  const std::string folder = "self_test/";
  return {{"", folder + "self_test.comp", kSelfTestShader},
          {"self_test_layout.h", folder + "self_test_layout.h", kSelfTestLayout},
          {"float_float.glsl", folder + "float_float.glsl", kFloatFloat}};
}

std::vector<std::string> runSelfTest(const Device& device, BufferAccess access,
                                     const std::vector<ShaderSource>& sources, bool loopsAtHead) {
  const Words words = randomWords();
  const auto run = [&](const char* preamble) {
    const Spirv spirv = compileGlsl(sources, accessPreamble(access) + preamble);
    return runOnDevice(device, access, spirv.words, loopsAtHead, words);
  };
  std::vector<std::array<uint32_t, kChecks>> right;
  for (uint32_t invocation = 0; invocation < kSelfTestInvocations; ++invocation)
    right.push_back(expected(words, invocation));

  const Results brief = run("");
  bool isRight = brief[kCheckedCounter] == kSelfTestInvocations;
  for (uint32_t invocation = 0; invocation < kSelfTestInvocations; ++invocation)
    isRight &= brief[invocation] == inBrief(right[invocation]);
  if (isRight) return {};

  const Results results = run("#define IN_DETAIL\n");
  std::array<size_t, kChecks> wrong{};
  for (uint32_t invocation = 0; invocation < kSelfTestInvocations; ++invocation)
    for (uint32_t check = 0; check < kChecks; ++check)
      wrong[check] += results[check * kSelfTestInvocations + invocation] != right[invocation][check];
  const std::string of = " of " + std::to_string(kSelfTestInvocations);
  std::vector<std::string> faults;
  for (uint32_t check = 0; check < kChecks; ++check)
    if (wrong[check] > 0)
      faults.push_back(std::string(kFaults[check]) + ": " + std::to_string(wrong[check]) + of + " lanes");
  if (results[kCheckedCounter] != kSelfTestInvocations)
    faults.push_back("a counter that all lanes increase has lost " +
                     std::to_string(int64_t(kSelfTestInvocations) - int64_t(results[kCheckedCounter])) + of +
                     " (shaders/resume.glsl, status)");
  // In brief something was wrong, and in detail nothing is: what goes wrong depends on the code around it.
  if (faults.empty()) faults.push_back("the checks are right one by one and wrong together (shaders/whitted.comp)");
  return faults;
}

DeviceTrust testDevice(const Device& device, BufferAccess access, const std::vector<ShaderSource>& sources) {
  const std::string name = device.info().name + " (" + device.info().driver + ")";
  const DeviceTrust atHead{true, "note: " + name +
                                     " loses values where its lanes leave a loop one by one; the kernel's loops are "
                                     "given to it in a form that it gets right"};
  const std::string path = cachePath(device, access, sources);
  const std::optional<std::string> kept = path.empty() ? std::nullopt : readCached(path);
  if (kept == kPassed) return {};
  if (kept == kPassedAtHead) return atHead;

  const std::vector<std::string> faults = runSelfTest(device, access, sources, false);
  if (faults.empty()) {
    keep(path, kPassed);
    return {};
  }
  const std::vector<std::string> left = runSelfTest(device, access, sources, true);
  if (left.empty()) {
    keep(path, kPassedAtHead);
    return atHead;
  }
  std::string message = "the device " + name + " fails turner's self-test; its pictures would be wrong";
  for (const std::string& fault : left) message += "\n  " + fault;
  throw RunError(message + "\nchoose another device (turner devices), update its driver, or use --backend reference");
}

}  // namespace turner
