// Tiles, passes and dispatches: how the picture's work is cut, and nothing about rays.
#include "gpu/renderer.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <list>
#include <thread>

#include "base/errors.h"
#include "base/stopwatch.h"
#include "gpu/vulkan_device.h"

namespace turner {
namespace {

using gpu::uint;

// A dispatch should take about this long: below any watchdog (2 s on Windows, 5 s and more on Linux) and short enough
// for progress and Ctrl-C, long enough to be worth its submission.
constexpr double kLongDispatch = 0.2, kShortDispatch = 0.05;  // seconds

// The rows from kStateRays on that hold counts.
constexpr uint kCounterWords = 3;
static_assert(gpu::kStateNodes == gpu::kStateRays + 1 && gpu::kStatePrimitives == gpu::kStateRays + 2);

// Most bytes of invocation state at a time.
constexpr vk::DeviceSize kStateBytes = 256 << 20;

template <class T>
std::span<const std::byte> bytesOf(const std::vector<T>& values) {
  return std::as_bytes(std::span<const T>(values));
}

// Everything written before is visible to everything after.
void fullBarrier(const vk::raii::CommandBuffer& commands) {
  using Stage = vk::PipelineStageFlagBits;
  using Access = vk::AccessFlagBits;
  const vk::MemoryBarrier barrier(
      Access::eShaderWrite | Access::eTransferWrite | Access::eHostWrite,
      Access::eShaderRead | Access::eShaderWrite | Access::eTransferRead | Access::eTransferWrite | Access::eHostRead);
  const vk::PipelineStageFlags stages = Stage::eComputeShader | Stage::eTransfer | Stage::eHost;
  commands.pipelineBarrier(stages, stages, {}, barrier, {}, {});
}

void copy(const vk::raii::CommandBuffer& commands, const Buffer& from, vk::DeviceSize offset, const Buffer& to,
          vk::DeviceSize size) {
  commands.copyBuffer(**from.buffer, **to.buffer, vk::BufferCopy(offset, 0, size));
}

// The kernel, specialised to a scene and its settings.
struct Pipeline {
  std::vector<uint32_t> words;
  Constants constants;
  vk::raii::DescriptorSetLayout setLayout;
  vk::raii::PipelineLayout layout;
  vk::raii::Pipeline pipeline;
};

static_assert(gpu::kBindCount - gpu::kBindNodes == kSceneArrays && sizeof(gpu::Word4) == kWordBytes);

vk::DescriptorType bindingType(uint binding, BufferAccess access) {
  return bindsTexels(binding, access) ? vk::DescriptorType::eStorageTexelBuffer : vk::DescriptorType::eStorageBuffer;
}

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

// What a scene, its settings and the device ask of a kernel.
Constants specialise(const Features& features, const RenderSettings& settings, uint workGroup, uint budget,
                     bool counters, bool fresh) {
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
  return constants;
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

// Most pipelines that are kept for later renders: of the kernel in hand and of one to compare it with, each to begin
// and to take up work, and those that count.
constexpr size_t kKeptPipelines = 8;

// Those pixels of a crop that are `stride` apart, as a crop of the picture that they make by themselves.
Window everyStride(const Window& crop, int stride) {
  return {0, 0, (crop.width() + stride - 1) / stride, (crop.height() + stride - 1) / stride};
}

// The tiles of a crop, left to right, top to bottom, each with state for its 8x8 blocks.
std::vector<gpu::Tile> cutIntoTiles(const Window& crop, int stride, int side) {
  const Window grid = everyStride(crop, stride);
  std::vector<gpu::Tile> tiles;
  for (int y = 0; y < grid.y1; y += side) {
    for (int x = 0; x < grid.x1; x += side) {
      gpu::Tile tile{};
      tile.x0 = uint(crop.x0 + stride * x);
      tile.y0 = uint(crop.y0 + stride * y);
      tile.stride = uint(stride);
      tile.width = uint(std::min(side, grid.x1 - x));
      tile.height = uint(std::min(side, grid.y1 - y));
      tile.slots = ((tile.width + 7) / 8) * ((tile.height + 7) / 8) * 64;
      tiles.push_back(tile);
    }
  }
  return tiles;
}

// What of the whole picture is done when a share of one tile is.
Progress tileProgress(const Progress& progress, size_t pixelsBefore, size_t pixels, size_t allPixels) {
  if (!progress) return [](double) {};
  return [=](double share) { progress((double(pixelsBefore) + share * double(pixels)) / double(allPixels)); };
}

}  // namespace

// The way of fetching that suits a device.
BufferAccess chooseAccess(const Device& device, BufferAccess wanted) {
  if (wanted == BufferAccess::automatic)
    return device.isCpu() && device.canAccess(BufferAccess::texelBuffer)      ? BufferAccess::texelBuffer
           : !device.isCpu() && device.canAccess(BufferAccess::deviceAddress) ? BufferAccess::deviceAddress
                                                                              : BufferAccess::storageBuffer;
  if (!device.canAccess(wanted))
    throw InputError("the device " + device.info().name + " cannot fetch rows as " + accessName(wanted));
  return wanted;
}

struct ShaderRenderer::Parts {
  Device device;
  BufferAccess access;
  Features features;
  View view;
  std::array<Buffer, kSceneArrays> rows;                 // from gpu::kBindNodes on
  std::list<std::shared_ptr<const Pipeline>> pipelines;  // the last that were used, latest first
  // Work-groups in one dispatch: follows the measured times, from one tile to the next.
  uint groupsPerDispatch = 64;

  Parts(const DeviceInfo& info, BufferAccess wanted) : device(info), access(chooseAccess(device, wanted)) {
    const uint bindings = device.limits().maxPerStageDescriptorStorageBuffers;
    const uint needed = access == BufferAccess::storageBuffer ? gpu::kBindCount : gpu::kBindNodes;
    if (bindings < needed)
      throw RunError("the device " + info.name + " binds " + std::to_string(bindings) +
                     " storage buffers; turner needs " + std::to_string(needed));
  }

  uint threads() const { return device.isCpu() ? std::max(1u, std::thread::hardware_concurrency()) : 1; }
  int tileSide(const Dispatching& dispatching, int depth) const;
  uint workGroupSize(int wanted) const;
  // lavapipe's limiter counts what any lane of a subgroup does; see kIterations in layout.h.
  uint budget(const Dispatching& dispatching) const {
    if (dispatching.budget > 0) return std::max(dispatching.budget, kLeastBudget);
    return device.isCpu() ? gpu::kIterations / device.subgroupSize() : gpu::kIterations;
  }

  std::shared_ptr<const Pipeline> pipeline(const Spirv& kernel, const Constants& constants);

  struct Passes;
};

// Kept or new.
std::shared_ptr<const Pipeline> ShaderRenderer::Parts::pipeline(const Spirv& kernel, const Constants& constants) {
  const auto found = std::find_if(pipelines.begin(), pipelines.end(), [&](const auto& kept) {
    return kept->constants == constants && kept->words == kernel.words;
  });
  if (found != pipelines.end())
    pipelines.splice(pipelines.begin(), pipelines, found);
  else
    pipelines.push_front(std::make_shared<const Pipeline>(makePipeline(device, kernel, constants, access)));
  if (pipelines.size() > kKeptPipelines) pipelines.pop_back();
  return pipelines.front();
}

// One traversal of all tiles with one pipeline.
struct ShaderRenderer::Parts::Passes {
  Parts& parts;
  const Device& device;
  const Spirv& kernel;
  const RenderSettings& settings;
  const Dispatching& dispatching;
  bool counters;
  uint workGroup, samplesInPixel;
  std::shared_ptr<const Pipeline> fresh;    // of the first pass over a tile
  std::shared_ptr<const Pipeline> resumed;  // of those that take up its work; made when it is first needed
  Buffer frame, state, pixels, status, hostPixels, hostStatus;
  std::optional<vk::raii::DescriptorPool> pool;
  std::optional<vk::raii::DescriptorSet> set;
  std::vector<gpu::Tile> tiles;
  double traceSeconds = 0, resumedCompileSeconds = 0;

  Passes(Parts& parts, const Spirv& kernel, const RenderSettings& settings, const Dispatching& dispatching, int stride,
         bool counters);
  void warmUp(const Pipeline& pipeline);
  void traceTile(gpu::Tile tile, const Progress& progress);
  void readPixels(const gpu::Tile& tile) const;
  const gpu::Word4& pixel(size_t i) const { return reinterpret_cast<const gpu::Word4*>(hostPixels.mapped)[i]; }

 private:
  void bind();
  std::shared_ptr<const Pipeline> make(bool isFresh) const {
    return parts.pipeline(
        kernel, specialise(parts.features, settings, workGroup, parts.budget(dispatching), counters, isFresh));
  }
  const Pipeline& resumedPipeline();
  void record(const vk::raii::CommandBuffer& commands, const Pipeline& pipeline, const gpu::Tile& tile) const;
  gpu::Status readStatus() const;
};

int ShaderRenderer::Parts::tileSide(const Dispatching& dispatching, int depth) const {
  // A CPU wants its working set small; a GPU wants more invocations than it has lanes (17,000 on a large one).
  int side = dispatching.tile > 0 ? (dispatching.tile + 7) / 8 * 8 : device.isCpu() ? 128 : 512;
  const vk::DeviceSize most = std::min<vk::DeviceSize>(kStateBytes, device.limits().maxStorageBufferRange);
  while (side > 8 && vk::DeviceSize(side) * vk::DeviceSize(side) * gpu::stateWords(uint(depth), features.dielectrics) *
                             sizeof(gpu::Word4) >
                         most)
    side = std::max(8, side / 2 / 8 * 8);
  return side;
}

uint ShaderRenderer::Parts::workGroupSize(int wanted) const {
  const uint most =
      std::min(device.limits().maxComputeWorkGroupInvocations, device.limits().maxComputeWorkGroupSize[0]);
  if (wanted < 1 || uint(wanted) > most)
    throw InputError("a work-group of " + std::to_string(wanted) + " invocations: the device " + device.info().name +
                     " takes 1 to " + std::to_string(most));
  // Part of a subgroup would leave lanes that are never active; lavapipe 22.3 lets those run its loops to the limiter.
  const uint subgroup = device.subgroupSize();
  return std::min(most, (uint(wanted) + subgroup - 1) / subgroup * subgroup);
}

ShaderRenderer::Parts::Passes::Passes(Parts& owner, const Spirv& spirv, const RenderSettings& wanted,
                                      const Dispatching& cut, int stride, bool counting)
    : parts(owner),
      device(owner.device),
      kernel(spirv),
      settings(wanted),
      dispatching(cut),
      counters(counting),
      workGroup(owner.workGroupSize(dispatching.workGroup)),
      samplesInPixel(uint(settings.samples * settings.samples)),
      fresh(make(true)) {
  const View& view = parts.view;
  const Window &packed = view.crop, &crop = settings.crop;
  if (settings.width != view.width || settings.height != view.height || crop.x0 < packed.x0 || crop.y0 < packed.y0 ||
      crop.x1 > packed.x1 || crop.y1 > packed.y1)
    throw RunError("the scene was packed for another picture than is to be rendered");
  const int side = parts.tileSide(dispatching, settings.depth);
  tiles = cutIntoTiles(settings.crop, stride, side);
  uint slots = 0, area = 0;
  for (const gpu::Tile& tile : tiles) {
    slots = std::max(slots, tile.slots);
    area = std::max(area, tile.width * tile.height);
  }
  std::vector<gpu::Frame> frames = {packFrame(parts.view, settings, parts.threads())};
  for (uint i = 0; i < kSceneArrays; ++i) {
    const uint64_t address = parts.rows[i].address;
    frames[0].addresses[i] = {uint(address), uint(address >> 32), 0, 0};
  }
  frame = device.upload(bytesOf(frames), "frame");
  state = device.storageBuffer(
      vk::DeviceSize(slots) * gpu::stateWords(uint(settings.depth), parts.features.dielectrics) * sizeof(gpu::Word4),
      "state");
  pixels = device.storageBuffer(vk::DeviceSize(area) * sizeof(gpu::Word4), "pixels");
  status = device.storageBuffer(sizeof(gpu::Status), "status");
  hostStatus = device.hostBuffer(sizeof(gpu::Status), "status on the host");
  // Reads back the pixels of a tile, or the counts of its invocations.
  hostPixels = device.hostBuffer(
      std::max<vk::DeviceSize>(pixels.size, counters ? kCounterWords * slots * sizeof(gpu::Word4) : 0),
      "pixels on the host");
  bind();
}

void ShaderRenderer::Parts::Passes::bind() {
  const uint count = bindingCount(parts.access);
  const vk::DescriptorPoolSize sizes[] = {{vk::DescriptorType::eStorageBuffer, gpu::kBindCount},
                                          {vk::DescriptorType::eStorageTexelBuffer, kSceneArrays}};
  pool.emplace(device.vulkan(),
               vk::DescriptorPoolCreateInfo(vk::DescriptorPoolCreateFlagBits::eFreeDescriptorSet, 1, sizes));
  vk::raii::DescriptorSets sets(device.vulkan(), vk::DescriptorSetAllocateInfo(**pool, *fresh->setLayout));
  set.emplace(std::move(sets[0]));
  std::array<const Buffer*, gpu::kBindCount> buffers{};
  buffers[gpu::kBindFrame] = &frame;
  buffers[gpu::kBindState] = &state;
  buffers[gpu::kBindPixels] = &pixels;
  buffers[gpu::kBindStatus] = &status;
  for (uint i = 0; i < kSceneArrays; ++i) buffers[gpu::kBindNodes + i] = &parts.rows[i];
  std::array<vk::DescriptorBufferInfo, gpu::kBindCount> infos;
  std::vector<vk::WriteDescriptorSet> writes;
  for (uint i = 0; i < count; ++i) {
    vk::WriteDescriptorSet write(**set, i, 0, 1, bindingType(i, parts.access));
    if (write.descriptorType == vk::DescriptorType::eStorageTexelBuffer) write.pTexelBufferView = &**buffers[i]->texels;
    infos[i] = vk::DescriptorBufferInfo(**buffers[i]->buffer, 0, buffers[i]->size);
    write.pBufferInfo = &infos[i];
    writes.push_back(write);
  }
  device.vulkan().updateDescriptorSets(writes, {});
}

// The work-groups of one dispatch, wrapped into rows where a device takes only so many side by side.
void ShaderRenderer::Parts::Passes::record(const vk::raii::CommandBuffer& commands, const Pipeline& pipeline,
                                           const gpu::Tile& tile) const {
  commands.bindPipeline(vk::PipelineBindPoint::eCompute, *pipeline.pipeline);
  commands.bindDescriptorSets(vk::PipelineBindPoint::eCompute, *pipeline.layout, 0, **set, {});
  commands.pushConstants<gpu::Tile>(*pipeline.layout, vk::ShaderStageFlagBits::eCompute, 0, tile);
  const uint across = std::min(tile.groups, device.limits().maxComputeWorkGroupCount[0]);
  commands.dispatch(across, (tile.groups + across - 1) / across, 1);
}

gpu::Status ShaderRenderer::Parts::Passes::readStatus() const {
  gpu::Status result;
  std::memcpy(&result, hostStatus.mapped, sizeof result);
  return result;
}

// Drivers compile at the first dispatch: give them one in which no pixel is inside the tile.
const Pipeline& ShaderRenderer::Parts::Passes::resumedPipeline() {
  if (!resumed) {
    const Stopwatch watch;
    if (dispatching.compiles) dispatching.compiles();
    resumed = make(false);
    warmUp(*resumed);
    resumedCompileSeconds = watch.seconds();
  }
  return *resumed;
}

void ShaderRenderer::Parts::Passes::warmUp(const Pipeline& pipeline) {
  gpu::Tile nothing{};
  nothing.width = 8;  // a row of blocks, of no height
  nothing.slots = 1;
  nothing.groups = 1;
  device.run([&](const vk::raii::CommandBuffer& commands) {
    fullBarrier(commands);
    record(commands, pipeline, nothing);
    fullBarrier(commands);
  });
}

// Dispatches a tile again and again until all its pixels are finished.
void ShaderRenderer::Parts::Passes::traceTile(gpu::Tile tile, const Progress& progress) {
  const uint allGroups = (tile.slots + workGroup - 1) / workGroup;
  const double allSamples = double(tile.width) * tile.height * samplesInPixel;
  double waitingBefore = allSamples;  // when this pass began
  gpu::Status last;
  const Pipeline* pipeline = fresh.get();
  for (;;) {
    for (tile.firstGroup = 0; tile.firstGroup < allGroups; tile.firstGroup += tile.groups) {
      tile.groups = std::min(parts.groupsPerDispatch, allGroups - tile.firstGroup);
      const double seconds = device.run([&](const vk::raii::CommandBuffer& commands) {
        fullBarrier(commands);
        if (tile.firstGroup == 0) commands.fillBuffer(**status.buffer, 0, VK_WHOLE_SIZE, 0);
        if (tile.firstGroup == 0 && pipeline == fresh.get()) commands.fillBuffer(**pixels.buffer, 0, VK_WHOLE_SIZE, 0);
        fullBarrier(commands);
        record(commands, *pipeline, tile);
        fullBarrier(commands);
        copy(commands, status, 0, hostStatus, sizeof(gpu::Status));
        fullBarrier(commands);
      });
      traceSeconds += seconds;
      if (seconds > kLongDispatch) parts.groupsPerDispatch = std::max(1u, parts.groupsPerDispatch / 2);
      if (seconds < kShortDispatch && tile.groups == parts.groupsPerDispatch)
        parts.groupsPerDispatch = std::min(parts.groupsPerDispatch * 2, 1u << 20);
      last = readStatus();
      if (last.limiter > 0)
        throw LoopsCut(
            "the driver of " + device.info().name +
                " ended the kernel's loops early (a loop limiter); the picture would be wrong and is not written",
            last.limiter);
      if (last.mediaLost > 0)
        throw UntrueKernel(
            "a ray was in more than " + std::to_string(gpu::kMaxMedia) +
            " solids of glass at once, met more of their walls in one place, or passed more than " +
            std::to_string(gpu::kMaxHiddenInterfaces) +
            " walls hidden in others; the picture would be wrong and is not written; use --backend reference");
      // What of this pass is still to be dispatched waits as before.
      const double toCome = 1 - double(tile.firstGroup + tile.groups) / double(allGroups);
      const double waiting = std::min(waitingBefore, toCome * waitingBefore + double(last.samplesWaiting));
      progress(1 - waiting / allSamples);
    }
    if (last.unfinished == 0) return;
    waitingBefore = std::min(waitingBefore, double(last.samplesWaiting));
    pipeline = &resumedPipeline();
    progress(1 - waitingBefore / allSamples);
  }
}

// Into hostPixels. A kernel that was edited may end before its end, or write nothing at all, with no limiter to blame.
void ShaderRenderer::Parts::Passes::readPixels(const gpu::Tile& tile) const {
  const size_t area = size_t(tile.width) * tile.height;
  device.run([&](const vk::raii::CommandBuffer& commands) {
    fullBarrier(commands);
    copy(commands, pixels, 0, hostPixels, area * sizeof(gpu::Word4));
    fullBarrier(commands);
  });
  size_t missing = 0;
  for (size_t i = 0; i < area; ++i) missing += pixel(i).w != gpu::kPixelDone;
  if (missing > 0)
    throw PixelsMissing("the kernel has ended without finishing " + std::to_string(missing) + " of the " +
                        std::to_string(area) + " pixels of a tile; the picture would be wrong and is not written");
}

// --- the renderer ---------------------------------------------------------------------------------------------------

ShaderRenderer::ShaderRenderer(const DeviceInfo& device, BufferAccess access)
    : parts_(std::make_unique<Parts>(device, access)) {}
ShaderRenderer::~ShaderRenderer() = default;

BufferAccess ShaderRenderer::access() const {
  return parts_->access;
}

void ShaderRenderer::upload(const PackedScene& scene) {
  parts_->features = scene.features;
  parts_->view = scene.view;
  const auto upload = [&](uint binding, std::span<const std::byte> bytes, const char* name) {
    Buffer& buffer = parts_->rows[binding - gpu::kBindNodes];
    buffer = {};  // the last scene's is no longer needed
    buffer = parts_->device.uploadWords(bytes, parts_->access, name);
  };
  upload(gpu::kBindNodes, bytesOf(scene.nodes), "nodes");
  upload(gpu::kBindPrimitives, bytesOf(scene.primitives), "primitives");
  upload(gpu::kBindVertexNormals, bytesOf(scene.vertexNormals), "vertex normals");
  upload(gpu::kBindMaterials, bytesOf(scene.materials), "materials");
  upload(gpu::kBindLights, bytesOf(scene.lights), "lights");
  upload(gpu::kBindLightBuffers, bytesOf(scene.lightBuffers), "light buffers");
}

ShaderPicture ShaderRenderer::render(const Spirv& kernel, const RenderSettings& settings, const Progress& progress,
                                     const Dispatching& dispatching) {
  return trace(kernel, settings, 1, progress, dispatching);
}

ShaderPicture ShaderRenderer::renderCoarse(const Spirv& kernel, const RenderSettings& settings, int stride,
                                           const Progress& progress, const Dispatching& dispatching) {
  ShaderPicture picture = trace(kernel, settings, stride, progress, dispatching);
  const Image grid = std::move(picture.image);
  Image& image = picture.image = Image(settings.width, settings.height, settings.crop);
  for (int y = 0; y < settings.crop.height(); ++y) {
    const int row = std::min((y + stride / 2) / stride, grid.window.height() - 1);
    for (int x = 0; x < settings.crop.width(); ++x) {
      const int column = std::min((x + stride / 2) / stride, grid.window.width() - 1);
      std::copy_n(&grid.rgb[3 * (size_t(row) * size_t(grid.window.width()) + size_t(column))], 3,
                  &image.rgb[3 * (size_t(y) * size_t(settings.crop.width()) + size_t(x))]);
    }
  }
  return picture;
}

// The picture that the pixels of a stride make by themselves.
ShaderPicture ShaderRenderer::trace(const Spirv& kernel, const RenderSettings& settings, int stride,
                                    const Progress& progress, const Dispatching& dispatching) {
  const Window grid = everyStride(settings.crop, stride);
  ShaderPicture picture;
  picture.image =
      stride == 1 ? Image(settings.width, settings.height, settings.crop) : Image(grid.width(), grid.height(), grid);

  Stopwatch watch;
  if (dispatching.compiles) dispatching.compiles();
  Parts::Passes passes(*parts_, kernel, settings, dispatching, stride, false);
  passes.warmUp(*passes.fresh);
  picture.compileSeconds = watch.lap();
  if (progress) progress(0);

  size_t done = 0;
  for (const gpu::Tile& tile : passes.tiles) {
    const size_t area = size_t(tile.width) * tile.height;
    passes.traceTile(tile, tileProgress(progress, done, area, grid.area()));
    done += area;

    watch.lap();
    passes.readPixels(tile);
    const size_t left = (tile.x0 - uint(settings.crop.x0)) / tile.stride;
    const size_t top = (tile.y0 - uint(settings.crop.y0)) / tile.stride;
    for (uint y = 0; y < tile.height; ++y) {
      const size_t source = size_t(y) * tile.width;
      const size_t target = (top + y) * size_t(grid.width()) + left;
      for (uint x = 0; x < tile.width; ++x)
        std::memcpy(&picture.image.rgb[3 * (target + x)], &passes.pixel(source + x), 3 * sizeof(float));
    }
    picture.readbackSeconds += watch.lap();
  }
  picture.compileSeconds += passes.resumedCompileSeconds;
  picture.traceSeconds = passes.traceSeconds;
  return picture;
}

Visits ShaderRenderer::countVisits(const Spirv& kernel, const RenderSettings& settings, const Progress& progress,
                                   const Dispatching& dispatching) {
  if (dispatching.compiles) dispatching.compiles();
  Parts::Passes passes(*parts_, kernel, settings, dispatching, 1, true);
  passes.warmUp(*passes.fresh);
  if (progress) progress(0);
  Visits visits;
  size_t done = 0;
  for (const gpu::Tile& tile : passes.tiles) {
    const size_t area = size_t(tile.width) * tile.height;
    passes.traceTile(tile, tileProgress(progress, done, area, settings.crop.area()));
    done += area;
    passes.readPixels(tile);  // only to see that the work was done

    const vk::DeviceSize wordBytes = vk::DeviceSize(tile.slots) * sizeof(gpu::Word4);
    passes.device.run([&](const vk::raii::CommandBuffer& commands) {
      fullBarrier(commands);
      copy(commands, passes.state, gpu::kStateRays * wordBytes, passes.hostPixels, kCounterWords * wordBytes);
      fullBarrier(commands);
    });
    std::vector<std::array<uint, 4>> counts(kCounterWords * size_t(tile.slots));
    std::memcpy(counts.data(), passes.hostPixels.mapped, kCounterWords * wordBytes);
    RayCounts* const rows[kCounterWords] = {&visits.rays, &visits.nodes, &visits.primitives};
    for (size_t i = 0; i < counts.size(); ++i) {
      RayCounts& row = *rows[i / tile.slots];
      row.eye += counts[i][0];
      row.reflected += counts[i][1];
      row.refracted += counts[i][2];
      row.shadow += counts[i][3];
    }
  }
  return visits;
}

}  // namespace turner
