// One traversal of a picture's tiles with one kernel: each tile is dispatched until its pixels are finished, and read
// back. Knows nothing of rays.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "gpu/dispatching.h"
#include "gpu/pipeline.h"
#include "gpu/scene_on_device.h"
#include "gpu/vulkan_device.h"
#include "image/settings.h"
#include "kernel/compile.h"
#include "layout.h"

namespace turner {

// The rows of an invocation's state from kStateRays on that hold counts: rays, nodes, primitives.
inline constexpr uint32_t kCounterWords = 3;

class TilePasses {
 public:
  // Makes pipeline and buffers for every stride-th pixel of the settings' crop, and has the driver compile. All
  // references must outlive this. Throws InputError where the device has no such work-groups or memory, RunError where
  // the scene was packed for another picture.
  TilePasses(SceneOnDevice& scene, const Spirv& kernel, const RenderSettings& settings, const Dispatching& dispatching,
             int stride, bool counters);

  // Traces the tiles one after another; `finished` is called with each whose pixels have been read. Throws
  // UntrueKernel's kinds where the picture would be wrong.
  void run(const Progress& progress, const std::function<void(const gpu::Tile&)>& finished);

  // Of the tile that was read last, row by row.
  const gpu::Word4& pixel(size_t i) const { return reinterpret_cast<const gpu::Word4*>(hostPixels_.mapped)[i]; }

  // The counts of a tile's invocations: kCounterWords times one for each slot. Overwrites the pixels that were read.
  std::vector<std::array<uint32_t, 4>> readCounts(const gpu::Tile& tile) const;

  double compileSeconds() const { return compileSeconds_; }
  double traceSeconds() const { return traceSeconds_; }
  double readbackSeconds() const { return readbackSeconds_; }

 private:
  void makeBuffers(int stride);
  void bind();
  std::shared_ptr<const Pipeline> make(bool isFresh) const;
  const Pipeline& resumedPipeline();
  void warmUp(const Pipeline& pipeline);
  void traceTile(gpu::Tile tile, const Progress& progress);
  void prepare(const vk::raii::CommandBuffer& commands, const Pipeline& pipeline, const gpu::Tile& tile) const;
  void record(const vk::raii::CommandBuffer& commands, const Pipeline& pipeline, const gpu::Tile& tile) const;
  gpu::Status readStatus() const;
  void readPixels(const gpu::Tile& tile) const;

  SceneOnDevice& scene_;
  const Device& device_;
  const Spirv& kernel_;
  const RenderSettings& settings_;
  const Dispatching& dispatching_;
  bool counters_;
  uint32_t workGroup_ = 0, samplesInPixel_;
  std::shared_ptr<const Pipeline> fresh_;    // of the first pass over a tile
  std::shared_ptr<const Pipeline> resumed_;  // of those that take up its work; made when it is first needed
  Buffer frame_, state_, pixels_, status_, hostPixels_, hostStatus_;
  std::optional<vk::raii::DescriptorPool> pool_;
  std::optional<vk::raii::DescriptorSet> set_;
  std::vector<gpu::Tile> tiles_;
  double compileSeconds_ = 0, traceSeconds_ = 0, readbackSeconds_ = 0;
};

}  // namespace turner
