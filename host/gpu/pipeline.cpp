// Set layout, specialisation constants and pipeline.
#include "gpu/pipeline.h"

#include <algorithm>
#include <string>

namespace turner {
namespace {

using gpu::uint;

vk::raii::DescriptorSetLayout makeSetLayout(const Device& device, BufferAccess access) {
  std::vector<vk::DescriptorSetLayoutBinding> bindings;
  for (uint i = 0; i < bindingCount(access); ++i)
    bindings.push_back({i, bindingType(i, access), 1, vk::ShaderStageFlagBits::eCompute});
  return {device.vulkan(), vk::DescriptorSetLayoutCreateInfo({}, bindings)};
}

static_assert(uint(Sampler::grid) == gpu::kGrid && uint(Sampler::jitter) == gpu::kJitter &&
              uint(Sampler::sobol) == gpu::kSobol);

// The prime factors of n <= 256, ascending, in bytes: there are at most eight.
std::array<uint, 2> packedRadices(uint n) {
  std::array<uint, 2> words{};
  uint count = 0;
  for (uint prime = 2; n > 1; ++prime)
    for (; n % prime == 0; n /= prime, ++count) words[count / 4] |= prime << (8 * (count % 4));
  return words;
}

Pipeline makePipeline(const Device& device, const Spirv& kernel, const Constants& constants, BufferAccess access) {
  std::array<vk::SpecializationMapEntry, gpu::kSpecCount> entries;
  for (uint i = 0; i < entries.size(); ++i)
    entries[i] = vk::SpecializationMapEntry(i, uint(i * sizeof(uint)), sizeof(uint));
  const vk::SpecializationInfo specialization(uint(entries.size()), entries.data(), sizeof constants, constants.data());

  Pipeline result{kernel.words, constants, makeSetLayout(device, access), nullptr, nullptr};
  const vk::PushConstantRange tile(vk::ShaderStageFlagBits::eCompute, 0, sizeof(gpu::Tile));
  result.layout = {device.vulkan(), vk::PipelineLayoutCreateInfo({}, *result.setLayout, tile)};
  const vk::raii::ShaderModule module(device.vulkan(), vk::ShaderModuleCreateInfo({}, kernel.words));
  const vk::PipelineShaderStageCreateInfo stage({}, vk::ShaderStageFlagBits::eCompute, *module, "main",
                                                &specialization);
  result.pipeline = {device.vulkan(), nullptr, vk::ComputePipelineCreateInfo({}, stage, *result.layout)};
  device.name(module, "whitted.comp");
  device.name(result.pipeline, std::string("whitted") + (constants[gpu::kSpecFresh] ? "" : ", resumed") +
                                   (constants[gpu::kSpecCounters] ? ", counting" : ""));
  throwIfInvalid();
  return result;
}

}  // namespace

vk::DescriptorType bindingType(uint32_t binding, BufferAccess access) {
  return bindsTexels(binding, access) ? vk::DescriptorType::eStorageTexelBuffer : vk::DescriptorType::eStorageBuffer;
}

// What a scene, its settings and the device ask of a kernel.
Constants specialise(const Features& features, const RenderSettings& settings, uint32_t workGroup, uint32_t budget,
                     bool counters, bool fresh, bool loopsAtHead) {
  Constants constants = constantsOf(features);
  constants[gpu::kSpecWorkGroup] = workGroup;
  constants[gpu::kSpecDepth] = uint(settings.depth);
  constants[gpu::kSpecSamples] = uint(settings.samples);
  constants[gpu::kSpecReflection] = features.reflection && settings.depth > 1;
  constants[gpu::kSpecRefraction] = features.refraction && settings.depth > 1;
  constants[gpu::kSpecSampler] = uint(settings.sampler);
  if (settings.sampler == Sampler::sobol) {
    const std::array<uint, 2> radices = packedRadices(uint(settings.samples));
    constants[gpu::kSpecRadicesLow] = radices[0];
    constants[gpu::kSpecRadicesHigh] = radices[1];
  }
  constants[gpu::kSpecCounters] = counters;
  constants[gpu::kSpecBudget] = budget;
  constants[gpu::kSpecFresh] = fresh;
  constants[gpu::kSpecLoopsAtHead] = loopsAtHead;
  return constants;
}

std::shared_ptr<const Pipeline> KeptPipelines::find(const Device& device, const Spirv& kernel,
                                                    const Constants& constants, BufferAccess access, size_t most) {
  const auto found = std::find_if(pipelines_.begin(), pipelines_.end(), [&](const auto& kept) {
    return kept->constants == constants && kept->words == kernel.words;
  });
  if (found != pipelines_.end())
    pipelines_.splice(pipelines_.begin(), pipelines_, found);
  else
    pipelines_.push_front(std::make_shared<const Pipeline>(makePipeline(device, kernel, constants, access)));
  if (pipelines_.size() > most) pipelines_.pop_back();
  return pipelines_.front();
}

}  // namespace turner
