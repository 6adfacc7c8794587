// Vulkan for formulas.comp: two buffers, one dispatch.
#include "hard/formulas.h"

#include <bit>
#include <optional>

#include "gpu/vulkan_device.h"
#include "hard/kernels/formulas.h"
#include "hard/row.h"
#include "kernel/compile.h"
#include "support/shader_harness.h"

namespace turner::hard {
namespace {

using gpu::uint;

constexpr uint kWorkGroup = 64;

vk::DescriptorSetLayoutBinding storageBuffer(uint binding) {
  return {binding, vk::DescriptorType::eStorageBuffer, 1, vk::ShaderStageFlagBits::eCompute};
}

}  // namespace

struct Formulas::Parts {
  Device device{chooseDevice(listDevices(), test::wantedDevice())};
  std::optional<vk::raii::DescriptorSetLayout> setLayout;
  std::optional<vk::raii::PipelineLayout> layout;
  std::optional<vk::raii::Pipeline> turner, naive;

  vk::raii::Pipeline makePipeline(const vk::raii::ShaderModule& module, uint isNaive) const;
};

vk::raii::Pipeline Formulas::Parts::makePipeline(const vk::raii::ShaderModule& module, uint isNaive) const {
  const uint values[] = {kWorkGroup, isNaive};
  const vk::SpecializationMapEntry entries[] = {{gpu::kSpecWorkGroup, 0, sizeof(uint)},
                                                {gpu::kSpecNaive, sizeof(uint), sizeof(uint)}};
  const vk::SpecializationInfo specialization(2, entries, sizeof(values), values);
  const vk::PipelineShaderStageCreateInfo stage({}, vk::ShaderStageFlagBits::eCompute, *module, "main",
                                                &specialization);
  return {device.vulkan(), nullptr, vk::ComputePipelineCreateInfo({}, stage, **layout)};
}

Formulas::Formulas() : parts_(std::make_unique<Parts>()) {
  const vk::raii::Device& device = parts_->device.vulkan();
  const vk::DescriptorSetLayoutBinding bindings[] = {storageBuffer(gpu::kBindLitGiven),
                                                     storageBuffer(gpu::kBindLitFound)};
  parts_->setLayout.emplace(device, vk::DescriptorSetLayoutCreateInfo({}, bindings));
  parts_->layout.emplace(device, vk::PipelineLayoutCreateInfo({}, **parts_->setLayout));
  const Spirv spirv =
      compileGlsl(TURNER_TESTS_DIR "/hard/kernels/formulas.comp", accessPreamble(BufferAccess::storageBuffer));
  const vk::raii::ShaderModule module(device, vk::ShaderModuleCreateInfo({}, spirv.words));
  parts_->turner = parts_->makePipeline(module, 0);
  parts_->naive = parts_->makePipeline(module, 1);
  throwIfInvalid();
}
Formulas::~Formulas() = default;

std::vector<Reflected> Formulas::evaluate(std::span<const Lit> lits, Tracer tracer) const {
  const Device& device = parts_->device;
  std::vector<Row> rows;
  rows.reserve(gpu::kLitRows * lits.size());
  for (const Lit& lit : lits)
    rows.insert(rows.end(),
                {rowOf(lit.point, std::bit_cast<uint>(lit.shininess)), rowOf(lit.N, std::bit_cast<uint>(lit.q)),
                 rowOf(lit.V), rowOf(lit.light, lit.fallsOff), rowOf(lit.E), rowOf(lit.diffuse), rowOf(lit.specular)});
  const Buffer given = device.upload(std::as_bytes(std::span(rows)), "lights and surfaces");
  const Buffer found = device.hostBuffer(gpu::kLitFoundRows * sizeof(Row) * lits.size(), "radiance");

  const vk::DescriptorPoolSize size(vk::DescriptorType::eStorageBuffer, 2);
  const vk::raii::DescriptorPool pool(
      device.vulkan(), vk::DescriptorPoolCreateInfo(vk::DescriptorPoolCreateFlagBits::eFreeDescriptorSet, 1, size));
  const vk::raii::DescriptorSets sets(device.vulkan(), vk::DescriptorSetAllocateInfo(*pool, **parts_->setLayout));
  const vk::DescriptorBufferInfo in(**given.buffer, 0, rows.size() * sizeof(Row)), out(**found.buffer, 0, found.size);
  const auto write = [&](uint binding, const vk::DescriptorBufferInfo& info) {
    return vk::WriteDescriptorSet(*sets[0], binding, 0, vk::DescriptorType::eStorageBuffer, {}, info);
  };
  device.vulkan().updateDescriptorSets({write(gpu::kBindLitGiven, in), write(gpu::kBindLitFound, out)}, {});
  device.run([&](const vk::raii::CommandBuffer& commands) {
    commands.bindPipeline(vk::PipelineBindPoint::eCompute,
                          tracer == Tracer::naive ? **parts_->naive : **parts_->turner);
    commands.bindDescriptorSets(vk::PipelineBindPoint::eCompute, **parts_->layout, 0, *sets[0], {});
    commands.dispatch(uint((lits.size() + kWorkGroup - 1) / kWorkGroup), 1, 1);
    const vk::MemoryBarrier done(vk::AccessFlagBits::eShaderWrite, vk::AccessFlagBits::eHostRead);
    commands.pipelineBarrier(vk::PipelineStageFlagBits::eComputeShader, vk::PipelineStageFlagBits::eHost, {}, done, {},
                             {});
  });
  throwIfInvalid();

  std::vector<Reflected> reflected;
  reflected.reserve(lits.size());
  for (size_t i = 0; i < lits.size(); ++i) {
    const Row& row = reinterpret_cast<const Row*>(found.mapped)[gpu::kLitFoundRows * i + gpu::kLitRadiance];
    reflected.push_back({{row.x, row.y, row.z}, std::bit_cast<float>(row.w)});
  }
  return reflected;
}

}  // namespace turner::hard
