// Barriers, dispatches of a length that no watchdog minds, and the checks of what the kernel says of itself.
#include "gpu/tile_passes.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <span>
#include <string>
#include <thread>

#include "base/errors.h"
#include "base/stopwatch.h"
#include "gpu/tiles.h"

namespace turner {
namespace {

using gpu::uint;

// A dispatch should take about this long: below any watchdog (2 s on Windows, 5 s and more on Linux) and short enough
// for progress and Ctrl-C, long enough to be worth its submission.
constexpr double kLongDispatch = 0.2, kShortDispatch = 0.05;  // seconds

static_assert(gpu::kStateNodes == gpu::kStateRays + 1 && gpu::kStatePrimitives == gpu::kStateRays + 2);

// Most bytes of invocation state at a time.
constexpr vk::DeviceSize kStateBytes = 256 << 20;

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

// What of the whole picture is done when a share of one tile is.
Progress tileProgress(const Progress& progress, size_t pixelsBefore, size_t pixels, size_t allPixels) {
  if (!progress) return [](double) {};
  return [=](double share) { progress((double(pixelsBefore) + share * double(pixels)) / double(allPixels)); };
}

// Pixels on a tile's side.
int tileSide(const Device& device, const Dispatching& dispatching, const Features& features, int depth, bool edited) {
  // A CPU wants its working set small; a GPU wants more invocations than it has lanes (17,000 on a large one).
  int side = dispatching.tile > 0 ? (dispatching.tile + 7) / 8 * 8 : device.isCpu() ? 128 : 512;
  const vk::DeviceSize most = std::min<vk::DeviceSize>(kStateBytes, device.limits().maxStorageBufferRange);
  while (side > 8 && vk::DeviceSize(side) * vk::DeviceSize(side) *
                             gpu::stateWords(uint(depth), features.dielectrics, edited) * sizeof(gpu::Word4) >
                         most)
    side = std::max(8, side / 2 / 8 * 8);
  return side;
}

uint workGroupSize(const Device& device, int wanted) {
  const uint most =
      std::min(device.limits().maxComputeWorkGroupInvocations, device.limits().maxComputeWorkGroupSize[0]);
  if (wanted < 1 || uint(wanted) > most)
    throw InputError("a work-group of " + std::to_string(wanted) + " invocations: the device " + device.info().name +
                     " takes 1 to " + std::to_string(most));
  // Part of a subgroup would leave lanes that are never active; lavapipe 22.3 lets those run its loops to the limiter.
  const uint subgroup = device.subgroupSize();
  return std::min(most, (uint(wanted) + subgroup - 1) / subgroup * subgroup);
}

uint threads(const Device& device) {
  return device.isCpu() ? std::max(1u, std::thread::hardware_concurrency()) : 1;
}

// lavapipe's limiter counts what any lane of a subgroup does; see kIterations in layout.h.
uint budget(const Device& device, const Dispatching& dispatching) {
  if (dispatching.budget > 0) return std::max(dispatching.budget, kLeastBudget);
  return device.isCpu() ? gpu::kIterations / device.subgroupSize() : gpu::kIterations;
}

}  // namespace

// --- making ---------------------------------------------------------------------------------------------------------

TilePasses::TilePasses(SceneOnDevice& scene, const Spirv& kernel, const RenderSettings& settings,
                       const Dispatching& dispatching, int stride, bool counters)
    : scene_(scene),
      device_(scene.device),
      kernel_(kernel),
      settings_(settings),
      dispatching_(dispatching),
      counters_(counters),
      samplesInPixel_(uint(settings.samples * settings.samples)) {
  const Stopwatch watch;
  if (dispatching.compiles) dispatching.compiles();
  workGroup_ = workGroupSize(device_, dispatching.workGroup);
  fresh_ = make(true);
  const View& view = scene.view;
  const Window &packed = view.crop, &crop = settings.crop;
  if (settings.width != view.width || settings.height != view.height || crop.x0 < packed.x0 || crop.y0 < packed.y0 ||
      crop.x1 > packed.x1 || crop.y1 > packed.y1)
    throw RunError("the scene was packed for another picture than is to be rendered");
  makeBuffers(stride);
  bind();
  warmUp(*fresh_);
  compileSeconds_ = watch.seconds();
}

void TilePasses::makeBuffers(int stride) {
  const bool dielectrics = scene_.features.dielectrics;
  const int side = tileSide(device_, dispatching_, scene_.features, settings_.depth, kernel_.edited);
  tiles_ = cutIntoTiles(settings_.crop, stride, side);
  uint slots = 0, area = 0;
  for (const gpu::Tile& tile : tiles_) {
    slots = std::max(slots, tile.slots);
    area = std::max(area, tile.width * tile.height);
  }
  gpu::Frame frame = packFrame(scene_.view, settings_, threads(device_));
  for (uint i = 0; i < kSceneArrays; ++i) {
    const uint64_t address = scene_.rows[i].address;
    frame.addresses[i] = {uint(address), uint(address >> 32), 0, 0};
  }
  frame_ = device_.upload(std::as_bytes(std::span(&frame, 1)), "frame");
  state_ = device_.storageBuffer(
      vk::DeviceSize(slots) * gpu::stateWords(uint(settings_.depth), dielectrics, kernel_.edited) * sizeof(gpu::Word4),
      "state");
  pixels_ = device_.storageBuffer(vk::DeviceSize(area) * sizeof(gpu::Word4), "pixels");
  status_ = device_.storageBuffer(sizeof(gpu::Status), "status");
  hostStatus_ = device_.hostBuffer(sizeof(gpu::Status), "status on the host");
  // Reads back the pixels of a tile, or the counts of its invocations.
  hostPixels_ = device_.hostBuffer(
      std::max<vk::DeviceSize>(pixels_.size, counters_ ? kCounterWords * slots * sizeof(gpu::Word4) : 0),
      "pixels on the host");
}

void TilePasses::bind() {
  const uint count = bindingCount(scene_.access);
  const vk::DescriptorPoolSize sizes[] = {{vk::DescriptorType::eStorageBuffer, gpu::kBindCount},
                                          {vk::DescriptorType::eStorageTexelBuffer, kSceneArrays}};
  pool_.emplace(device_.vulkan(),
                vk::DescriptorPoolCreateInfo(vk::DescriptorPoolCreateFlagBits::eFreeDescriptorSet, 1, sizes));
  vk::raii::DescriptorSets sets(device_.vulkan(), vk::DescriptorSetAllocateInfo(**pool_, *fresh_->setLayout));
  set_.emplace(std::move(sets[0]));
  std::array<const Buffer*, gpu::kBindCount> buffers{};
  buffers[gpu::kBindFrame] = &frame_;
  buffers[gpu::kBindState] = &state_;
  buffers[gpu::kBindPixels] = &pixels_;
  buffers[gpu::kBindStatus] = &status_;
  for (uint i = 0; i < kSceneArrays; ++i) buffers[gpu::kBindNodes + i] = &scene_.rows[i];
  std::array<vk::DescriptorBufferInfo, gpu::kBindCount> infos;
  std::vector<vk::WriteDescriptorSet> writes;
  for (uint i = 0; i < count; ++i) {
    vk::WriteDescriptorSet write(**set_, i, 0, 1, bindingType(i, scene_.access));
    if (write.descriptorType == vk::DescriptorType::eStorageTexelBuffer) write.pTexelBufferView = &**buffers[i]->texels;
    infos[i] = vk::DescriptorBufferInfo(**buffers[i]->buffer, 0, buffers[i]->size);
    write.pBufferInfo = &infos[i];
    writes.push_back(write);
  }
  device_.vulkan().updateDescriptorSets(writes, {});
}

std::shared_ptr<const Pipeline> TilePasses::make(bool isFresh) const {
  const Constants constants = specialise(scene_.features, settings_, workGroup_, budget(device_, dispatching_),
                                         counters_, isFresh, scene_.trust.loopsAtHead || dispatching_.loopsAtHead);
  return scene_.pipelines.find(device_, kernel_, constants, scene_.access, dispatching_.keptPipelines);
}

const Pipeline& TilePasses::resumedPipeline() {
  if (!resumed_) {
    const Stopwatch watch;
    if (dispatching_.compiles) dispatching_.compiles();
    resumed_ = make(false);
    warmUp(*resumed_);
    compileSeconds_ += watch.seconds();
  }
  return *resumed_;
}

// Drivers compile at the first dispatch: give them one of no work-groups, in which nothing of the kernel runs, so that
// a loop without end is no slow compiler.
void TilePasses::warmUp(const Pipeline& pipeline) {
  device_.run([&](const vk::raii::CommandBuffer& commands) {
    fullBarrier(commands);
    prepare(commands, pipeline, {});
    commands.dispatch(0, 1, 1);
    fullBarrier(commands);
  });
}

// --- running --------------------------------------------------------------------------------------------------------

void TilePasses::run(const Progress& progress, const std::function<void(const gpu::Tile&)>& finished) {
  if (progress) progress(0);
  size_t allPixels = 0, pixelsBefore = 0;
  for (const gpu::Tile& tile : tiles_) allPixels += size_t(tile.width) * tile.height;
  for (const gpu::Tile& tile : tiles_) {
    const size_t pixels = size_t(tile.width) * tile.height;
    traceTile(tile, tileProgress(progress, pixelsBefore, pixels, allPixels));
    pixelsBefore += pixels;
    const Stopwatch watch;
    readPixels(tile);
    finished(tile);
    readbackSeconds_ += watch.seconds();
  }
}

void TilePasses::prepare(const vk::raii::CommandBuffer& commands, const Pipeline& pipeline,
                         const gpu::Tile& tile) const {
  commands.bindPipeline(vk::PipelineBindPoint::eCompute, *pipeline.pipeline);
  commands.bindDescriptorSets(vk::PipelineBindPoint::eCompute, *pipeline.layout, 0, **set_, {});
  commands.pushConstants<gpu::Tile>(*pipeline.layout, vk::ShaderStageFlagBits::eCompute, 0, tile);
}

// The work-groups of one dispatch, wrapped into rows where a device takes only so many side by side.
void TilePasses::record(const vk::raii::CommandBuffer& commands, const Pipeline& pipeline,
                        const gpu::Tile& tile) const {
  prepare(commands, pipeline, tile);
  const uint across = std::min(tile.groups, device_.limits().maxComputeWorkGroupCount[0]);
  commands.dispatch(across, (tile.groups + across - 1) / across, 1);
}

gpu::Status TilePasses::readStatus() const {
  gpu::Status result;
  std::memcpy(&result, hostStatus_.mapped, sizeof result);
  return result;
}

// Dispatches a tile again and again until all its pixels are finished.
void TilePasses::traceTile(gpu::Tile tile, const Progress& progress) {
  const uint allGroups = (tile.slots + workGroup_ - 1) / workGroup_;
  const double allSamples = double(tile.width) * tile.height * samplesInPixel_;
  double waitingBefore = allSamples;  // when this pass began
  gpu::Status last;
  const Pipeline* pipeline = fresh_.get();
  for (;;) {
    for (tile.firstGroup = 0; tile.firstGroup < allGroups; tile.firstGroup += tile.groups) {
      tile.groups = std::min(scene_.groupsPerDispatch, allGroups - tile.firstGroup);
      const double seconds = device_.run([&](const vk::raii::CommandBuffer& commands) {
        fullBarrier(commands);
        if (tile.firstGroup == 0) commands.fillBuffer(**status_.buffer, 0, VK_WHOLE_SIZE, 0);
        if (tile.firstGroup == 0 && pipeline == fresh_.get())
          commands.fillBuffer(**pixels_.buffer, 0, VK_WHOLE_SIZE, 0);
        fullBarrier(commands);
        record(commands, *pipeline, tile);
        fullBarrier(commands);
        copy(commands, status_, 0, hostStatus_, sizeof(gpu::Status));
        fullBarrier(commands);
      });
      traceSeconds_ += seconds;
      if (seconds > kLongDispatch) scene_.groupsPerDispatch = std::max(1u, scene_.groupsPerDispatch / 2);
      if (seconds < kShortDispatch && tile.groups == scene_.groupsPerDispatch)
        scene_.groupsPerDispatch = std::min(scene_.groupsPerDispatch * 2, 1u << 20);
      last = readStatus();
      if (last.lacks != 0) throw FeaturesLacking(last.lacks);
      if (last.limiter > 0)
        throw LoopsCut(
            "the driver of " + device_.info().name +
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

// Into hostPixels_. A kernel that was edited may end before its end, or write nothing at all, with no limiter to blame.
void TilePasses::readPixels(const gpu::Tile& tile) const {
  const size_t area = size_t(tile.width) * tile.height;
  device_.run([&](const vk::raii::CommandBuffer& commands) {
    fullBarrier(commands);
    copy(commands, pixels_, 0, hostPixels_, area * sizeof(gpu::Word4));
    fullBarrier(commands);
  });
  size_t missing = 0;
  for (size_t i = 0; i < area; ++i) missing += pixel(i).w != gpu::kPixelDone;
  if (missing > 0)
    throw PixelsMissing("the kernel has ended without finishing " + std::to_string(missing) + " of the " +
                        std::to_string(area) + " pixels of a tile; the picture would be wrong and is not written");
}

std::vector<std::array<uint32_t, 4>> TilePasses::readCounts(const gpu::Tile& tile) const {
  const vk::DeviceSize wordBytes = vk::DeviceSize(tile.slots) * sizeof(gpu::Word4);
  device_.run([&](const vk::raii::CommandBuffer& commands) {
    fullBarrier(commands);
    copy(commands, state_, gpu::kStateRays * wordBytes, hostPixels_, kCounterWords * wordBytes);
    fullBarrier(commands);
  });
  std::vector<std::array<uint32_t, 4>> counts(kCounterWords * size_t(tile.slots));
  std::memcpy(counts.data(), hostPixels_.mapped, kCounterWords * wordBytes);
  return counts;
}

}  // namespace turner
