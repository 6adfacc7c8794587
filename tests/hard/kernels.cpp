// Vulkan for the test kernels: one descriptor set, one dispatch for each batch of rays.
#include "hard/kernels.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <glm/common.hpp>
#include <optional>
#include <tuple>

#include "base/errors.h"
#include "geometry/round_scene.h"
#include "gpu/devices.h"
#include "gpu/pack_scene.h"
#include "gpu/vulkan_device.h"
#include "hard/kernels/naive.h"
#include "hard/kernels/step.h"
#include "hard/row.h"
#include "kernel/compile.h"
#include "support/shader_harness.h"

namespace turner::hard {
namespace {

using gpu::uint;

constexpr size_t kBatch = 1 << 18;  // rays in a dispatch
constexpr uint kWorkGroup = 64;

// What a kernel is bound to, beside what it is given and finds.
struct Rows {
  std::array<Buffer, kSceneArrays> arrays;  // from gpu::kBindNodes on
  gpu::Frame frame{};
};

struct Kernel {
  std::optional<vk::raii::DescriptorSetLayout> setLayout;
  std::optional<vk::raii::PipelineLayout> layout;
  std::optional<vk::raii::Pipeline> pipeline;
};

BufferAccess accessOf(const Device& device) {
  return device.canAccess(BufferAccess::texelBuffer) ? BufferAccess::texelBuffer : BufferAccess::storageBuffer;
}

vk::DescriptorType typeOf(uint binding, BufferAccess access) {
  return binding >= gpu::kBindNodes && access == BufferAccess::texelBuffer ? vk::DescriptorType::eStorageTexelBuffer
                                                                           : vk::DescriptorType::eStorageBuffer;
}

bool isBound(uint binding) {
  return binding == gpu::kBindFrame || binding == gpu::kBindGiven || binding == gpu::kBindFound ||
         binding >= gpu::kBindNodes;
}

Kernel makeKernel(const Device& device, BufferAccess access, const std::string& path, const Features& features) {
  const Spirv spirv = compileGlsl(path, accessPreamble(access));
  std::vector<vk::DescriptorSetLayoutBinding> bindings;
  for (uint i = 0; i < gpu::kBindCount; ++i)
    if (isBound(i)) bindings.push_back({i, typeOf(i, access), 1, vk::ShaderStageFlagBits::eCompute});

  // The step has all that a scene may need, but kinds of primitives that it lacks and what follows from the scene.
  struct Constant {
    uint id, value;
  };
  const std::vector<Constant> constants = {
      {gpu::kSpecWorkGroup, kWorkGroup},
      {gpu::kSpecBudget, device.isCpu() ? gpu::kIterations / device.subgroupSize() : gpu::kIterations},
      {gpu::kSpecSpheres, features.spheres},
      {gpu::kSpecTriangles, features.triangles},
      {gpu::kSpecSmoothNormals, features.smoothNormals},
      {gpu::kSpecCones, features.cones},
      {gpu::kSpecSlopedCones, features.slopedCones},
      {gpu::kSpecSteepCones, features.steepCones},
      {gpu::kSpecFarCones, features.farCones},
      {gpu::kSpecNearSpheres, features.nearSpheres},
      {gpu::kSpecFarSpheres, features.farSpheres},
      {gpu::kSpecNestedDielectrics, features.dielectrics},
  };
  std::vector<vk::SpecializationMapEntry> entries;
  for (size_t i = 0; i < constants.size(); ++i)
    entries.push_back({constants[i].id, uint(i * sizeof(Constant) + offsetof(Constant, value)), sizeof(uint)});
  const vk::SpecializationInfo specialization(uint(entries.size()), entries.data(), constants.size() * sizeof(Constant),
                                              constants.data());
  Kernel kernel;
  kernel.setLayout.emplace(device.vulkan(), vk::DescriptorSetLayoutCreateInfo({}, bindings));
  kernel.layout.emplace(device.vulkan(), vk::PipelineLayoutCreateInfo({}, **kernel.setLayout));
  const vk::raii::ShaderModule module(device.vulkan(), vk::ShaderModuleCreateInfo({}, spirv.words));
  const vk::PipelineShaderStageCreateInfo stage({}, vk::ShaderStageFlagBits::eCompute, *module, "main",
                                                &specialization);
  kernel.pipeline.emplace(device.vulkan(), nullptr, vk::ComputePipelineCreateInfo({}, stage, **kernel.layout));
  device.name(*kernel.pipeline, path);
  throwIfInvalid();
  return kernel;
}

template <class T>
std::span<const std::byte> bytesOf(const std::vector<T>& values) {
  return std::as_bytes(std::span<const T>(values));
}

// The scene as the naive tracer has it: boxes that fit exactly, by a tree of the renderer's builder.
struct NaiveScene {
  std::vector<Row> nodes, primitives;
};

NaiveScene naiveScene(const Scene& local) {
  std::vector<Box> boxes;
  for (const Sphere& sphere : local.spheres)
    boxes.push_back(
        {glm::vec3(sphere.center - std::abs(sphere.radius)), glm::vec3(sphere.center + std::abs(sphere.radius))});
  for (const Cone& cone : local.cones) {
    const Bounds bounds = boundsOf(cone);
    boxes.push_back({glm::vec3(bounds.lo), glm::vec3(bounds.hi)});
  }
  for (const Triangle& triangle : local.triangles) {
    const TriangleCorners corners = local.cornersOf(triangle);
    const glm::vec3 a(corners[0]), b(corners[1]), c(corners[2]);
    boxes.push_back({glm::min(a, glm::min(b, c)), glm::max(a, glm::max(b, c))});
  }
  const size_t firstCone = local.spheres.size(), firstTriangle = firstCone + local.cones.size();
  const Bvh bvh = buildBvh(boxes, {firstCone, firstTriangle});
  NaiveScene scene;
  // Node 0 is the root; the children of Bvh node n are 2 n + 1 and 2 n + 2.
  const auto put = [&](const BvhChild& child) {
    scene.nodes.push_back(rowOf(child.box.lo, child.count > 0 ? child.first : 2 * child.first + 1));
    scene.nodes.push_back(rowOf(child.box.hi, child.count));
  };
  put(bvh.root);
  for (const Bvh::Node& node : bvh.nodes)
    for (const BvhChild& child : node.children) put(child);
  for (const uint id : bvh.order) {
    if (id < firstCone) {
      const Sphere& sphere = local.spheres[id];
      scene.primitives.push_back(rowOf(sphere.center, id));
      scene.primitives.push_back(rowOf(glm::vec3(0), 0));
      scene.primitives.push_back(rowOf(glm::vec3(float(std::abs(sphere.radius)), 0, 0), sphere.material));
    } else if (id < firstTriangle) {
      const Cone& cone = local.cones[id - firstCone];
      scene.primitives.push_back(rowOf(cone.base, id));
      scene.primitives.push_back(rowOf(cone.apex, 2));
      scene.primitives.push_back(
          rowOf(glm::vec3(float(std::abs(cone.baseRadius)), float(std::abs(cone.apexRadius)), 0), cone.material));
    } else {
      const Triangle& triangle = local.triangles[id - firstTriangle];
      const auto [a, b, c] = local.cornersOf(triangle);
      scene.primitives.push_back(rowOf(a, id));
      scene.primitives.push_back(rowOf(b, 1));
      scene.primitives.push_back(rowOf(c, triangle.material));
    }
  }
  return scene;
}

}  // namespace

struct Kernels::Parts {
  Parts(const DeviceInfo& info, const std::string& folder) : device(info), kernels(folder + "/tests/hard/kernels/") {}

  Device device;
  std::string kernels;  // the folder of their sources
  BufferAccess access = accessOf(device);
  Scene local;
  std::vector<uint32_t> ids;  // of primitives, by their precedence
  Features features;
  Rows turner, naive;
  std::optional<Kernel> step, naiveStep;
  Features stepFeatures;  // that `step` was made for
  Buffer given = device.hostBuffer(kBatch * gpu::kGivenRows * sizeof(Row), "given");
  Buffer found = device.hostBuffer(kBatch * gpu::kFoundRows * sizeof(Row), "found");
  std::optional<vk::raii::DescriptorPool> pool;
  std::optional<vk::raii::DescriptorSet> set;

  void setArray(Rows& rows, uint binding, std::span<const std::byte> bytes) const {
    Buffer& buffer = rows.arrays[binding - gpu::kBindNodes];
    buffer = {};
    buffer = device.uploadWords(bytes, access, "rows " + std::to_string(binding));
  }
  void bind(const Kernel& kernel, const Rows& rows, const Buffer& frame, const Buffer& in);
};

void Kernels::Parts::bind(const Kernel& kernel, const Rows& rows, const Buffer& frame, const Buffer& in) {
  const vk::DescriptorPoolSize sizes[] = {{vk::DescriptorType::eStorageBuffer, gpu::kBindCount},
                                          {vk::DescriptorType::eStorageTexelBuffer, kSceneArrays}};
  set.reset();
  pool.emplace(device.vulkan(),
               vk::DescriptorPoolCreateInfo(vk::DescriptorPoolCreateFlagBits::eFreeDescriptorSet, 1, sizes));
  vk::raii::DescriptorSets sets(device.vulkan(), vk::DescriptorSetAllocateInfo(**pool, **kernel.setLayout));
  set.emplace(std::move(sets[0]));
  std::array<vk::DescriptorBufferInfo, gpu::kBindCount> infos;
  std::vector<vk::WriteDescriptorSet> writes;
  for (uint i = 0; i < gpu::kBindCount; ++i) {
    if (!isBound(i)) continue;
    const Buffer& buffer = i == gpu::kBindFrame   ? frame
                           : i == gpu::kBindGiven ? in
                           : i == gpu::kBindFound ? found
                                                  : rows.arrays[i - gpu::kBindNodes];
    vk::WriteDescriptorSet write(**set, i, 0, 1, typeOf(i, access));
    if (write.descriptorType == vk::DescriptorType::eStorageTexelBuffer) write.pTexelBufferView = &**buffer.texels;
    infos[i] = vk::DescriptorBufferInfo(**buffer.buffer, 0, i == gpu::kBindGiven ? in.size : buffer.size);
    write.pBufferInfo = &infos[i];
    writes.push_back(write);
  }
  device.vulkan().updateDescriptorSets(writes, {});
}

Kernels::Kernels() : Kernels(chooseDevice(listDevices(), test::wantedDevice()), TURNER_TESTS_DIR "/..") {}
Kernels::Kernels(const DeviceInfo& device, const std::string& folder)
    : parts_(std::make_unique<Parts>(device, folder)) {
  parts_->naiveStep = makeKernel(parts_->device, parts_->access, parts_->kernels + "naive.comp", {});
}
Kernels::~Kernels() = default;

std::string Kernels::deviceName() const {
  return parts_->device.info().name;
}

const Scene& Kernels::local() const {
  return parts_->local;
}

std::array<uint32_t, 4> Kernels::mediaAroundEye() const {
  return std::bit_cast<std::array<uint, 4>>(parts_->turner.frame.media);
}

void Kernels::setLeastDistance(float least) {
  parts_->naive.frame.background.x = least;
}

void Kernels::setScene(const Scene& world) {
  setScene(world, buildBvh);
}

void Kernels::setScene(const Scene& world, const BuildTree& build) {
  Parts& parts = *parts_;
  Scene local = roundScene(world);
  checkReach(local);
  const PreparedGeometry prepared = prepareGeometry(local);
  RenderSettings settings;
  settings.width = settings.height = 8;
  settings.crop = {0, 0, 8, 8};
  const PackedScene packed =
      packScene(prepared, build(prepared.boxes, prepared.typeStarts(), {}), settings, TraversalStart::wholeTree);
  parts.features = packed.features;
  const std::vector<uint> order = tieBreakRanks(prepared);
  parts.ids.resize(order.size());
  for (uint id = 0; id < order.size(); ++id) parts.ids[order[id]] = id;
  parts.turner.frame = packFrame(packed.view, settings, 1);
  const auto set = [&](uint binding, std::span<const std::byte> bytes) {
    parts.setArray(parts.turner, binding, bytes);
  };
  set(gpu::kBindNodes, bytesOf(packed.nodes));
  set(gpu::kBindPrimitives, bytesOf(packed.primitives));
  set(gpu::kBindVertexNormals, bytesOf(packed.vertexNormals));
  set(gpu::kBindMaterials, bytesOf(packed.materials));
  set(gpu::kBindLights, bytesOf(packed.lights));
  set(gpu::kBindLightBuffers, bytesOf(packed.lightBuffers));

  const NaiveScene naive = naiveScene(local);
  for (uint i = gpu::kBindNodes; i < gpu::kBindCount; ++i) parts.setArray(parts.naive, i, {});
  parts.setArray(parts.naive, gpu::kBindNodes, bytesOf(naive.nodes));
  parts.setArray(parts.naive, gpu::kBindPrimitives, bytesOf(naive.primitives));
  parts.setArray(parts.naive, gpu::kBindMaterials, bytesOf(packed.materials));
  parts.naive.frame.root = naive.primitives.empty() ? gpu::kRefNone : 0;

  const Features &a = parts.features, &b = parts.stepFeatures;
  const auto shape = [](const Features& f) {
    return std::tuple(f.spheres, f.triangles, f.smoothNormals, f.nearSpheres, f.farSpheres, f.cones, f.slopedCones,
                      f.steepCones, f.farCones, f.dielectrics);
  };
  if (!parts.step || shape(a) != shape(b)) {
    parts.step = makeKernel(parts.device, parts.access, parts.kernels + "step.comp", parts.features);
    parts.stepFeatures = parts.features;
  }
  parts.local = std::move(local);
}

std::vector<Found> Kernels::trace(std::span<const Query> queries, Tracer tracer) {
  Parts& parts = *parts_;
  if (!parts.step) throw RunError("no scene to trace rays in");
  const Kernel& kernel = tracer == Tracer::turner ? *parts.step : *parts.naiveStep;
  const Rows& rows = tracer == Tracer::turner ? parts.turner : parts.naive;
  const Buffer frame = parts.device.upload(std::as_bytes(std::span(&rows.frame, 1)), "frame");
  std::vector<Found> result;
  result.reserve(queries.size());
  for (size_t begin = 0; begin < queries.size(); begin += kBatch) {
    const size_t count = std::min(kBatch, queries.size() - begin);
    Row* const given = reinterpret_cast<Row*>(parts.given.mapped);
    for (size_t i = 0; i < count; ++i) {
      const Query& query = queries[begin + i];
      given[gpu::kGivenRows * i + gpu::kGivenOrigin] = rowOf(query.ray.origin, query.ray.leaving);
      given[gpu::kGivenRows * i + gpu::kGivenDirection] = rowOf(query.ray.direction, std::bit_cast<uint>(query.end));
      given[gpu::kGivenRows * i + gpu::kGivenNext] = rowOf(query.target, uint(query.next));
      given[gpu::kGivenRows * i + gpu::kGivenSolids] = std::bit_cast<Row>(query.ray.dielectrics);
    }
    // The kernel takes the number of its rays from the size of this binding.
    Buffer bound;
    bound.size = count * gpu::kGivenRows * sizeof(Row);
    std::swap(bound.buffer, parts.given.buffer);
    parts.bind(kernel, rows, frame, bound);
    std::swap(bound.buffer, parts.given.buffer);
    parts.device.run([&](const vk::raii::CommandBuffer& commands) {
      commands.bindPipeline(vk::PipelineBindPoint::eCompute, **kernel.pipeline);
      commands.bindDescriptorSets(vk::PipelineBindPoint::eCompute, **kernel.layout, 0, **parts.set, {});
      commands.dispatch(uint((count + kWorkGroup - 1) / kWorkGroup), 1, 1);
      const vk::MemoryBarrier done(vk::AccessFlagBits::eShaderWrite, vk::AccessFlagBits::eHostRead);
      commands.pipelineBarrier(vk::PipelineStageFlagBits::eComputeShader, vk::PipelineStageFlagBits::eHost, {}, done,
                               {}, {});
    });
    throwIfInvalid();
    const Row* const found = reinterpret_cast<const Row*>(parts.found.mapped);
    const auto vec = [](const Row& row) { return glm::vec3(row.x, row.y, row.z); };
    for (size_t i = 0; i < count; ++i) {
      const Row* const row = found + gpu::kFoundRows * i;
      const Row &hit = row[gpu::kFoundHit], &point = row[gpu::kFoundPoint], &Ng = row[gpu::kFoundNg];
      const Row &leaving = row[gpu::kFoundLeavingOrigin], &direction = row[gpu::kFoundLeavingDirection];
      if (hit.w & gpu::kFoundUnfinished)
        throw RunError("ray " + std::to_string(begin + i) + " did not come to its end within the budget");
      const bool hits = std::bit_cast<uint>(hit.y) != gpu::kRefNone;
      result.push_back({.t = hit.x,
                        .id = !hits                      ? kNothing
                              : tracer == Tracer::turner ? parts.ids[std::bit_cast<uint>(hit.z)]
                                                         : std::bit_cast<uint>(hit.z),
                        .front = (hit.w & gpu::kFoundFront) != 0,
                        .point = vec(point),
                        .margin = std::bit_cast<float>(point.w),
                        .Ng = vec(Ng),
                        .Ns = vec(row[gpu::kFoundNs]),
                        .material = Ng.w,
                        .hidden = (hit.w & gpu::kFoundHidden) != 0,
                        .leaves = (hit.w & gpu::kFoundLeaves) != 0,
                        .leaving = {vec(leaving), vec(direction), leaving.w,
                                    std::bit_cast<std::array<uint, 4>>(row[gpu::kFoundSolids])}});
    }
  }
  return result;
}

}  // namespace turner::hard
