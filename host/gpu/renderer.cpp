// From a packed scene to a picture, tile by tile.
#include "gpu/renderer.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <utility>

#include "gpu/scene_on_device.h"
#include "gpu/tile_passes.h"
#include "gpu/tiles.h"

namespace turner {

ShaderRenderer::ShaderRenderer(const DeviceInfo& device, BufferAccess access)
    : scene_(std::make_unique<SceneOnDevice>(device, access)) {}
ShaderRenderer::~ShaderRenderer() = default;

BufferAccess ShaderRenderer::access() const {
  return scene_->access;
}

void ShaderRenderer::plan(const PackedScene& scene) {
  scene_->plan(scene);
}

const std::string& ShaderRenderer::note() const {
  return scene_->trust.note;
}

void ShaderRenderer::upload(PackedScene scene) {
  scene_->upload(std::move(scene));
}

void ShaderRenderer::addFeatures(ConstantSet set) {
  scene_->features = withFeatures(scene_->features, set);
}

void ShaderRenderer::setAddedFeatures(ConstantSet set) {
  scene_->features = withFeatures(scene_->sceneFeatures, set);
}

ConstantSet ShaderRenderer::addedFeatures() const {
  return turner::addedFeatures(scene_->sceneFeatures, scene_->features);
}

const Features& ShaderRenderer::features() const {
  return scene_->features;
}

// Again with what an edited kernel has found that it lacks, until it lacks nothing.
template <class Work>
auto ShaderRenderer::withAllItNeeds(const RenderSettings& settings, const Dispatching& dispatching, const Work& work) {
  for (;;) {
    ConstantSet lacks = 0;
    try {
      return work();
    } catch (const FeaturesLacking& lacking) {
      lacks = lacking.lacks;
    }
    scene_->features = withLacking(scene_->features, lacks, settings, dispatching.narrow);
  }
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
  return withAllItNeeds(settings, dispatching,
                        [&] { return traceOnce(kernel, settings, stride, progress, dispatching); });
}

ShaderPicture ShaderRenderer::traceOnce(const Spirv& kernel, const RenderSettings& settings, int stride,
                                        const Progress& progress, const Dispatching& dispatching) {
  const Window grid = everyStride(settings.crop, stride);
  ShaderPicture picture;
  picture.image =
      stride == 1 ? Image(settings.width, settings.height, settings.crop) : Image(grid.width(), grid.height(), grid);

  TilePasses passes(*scene_, kernel, settings, dispatching, stride, false);
  passes.run(progress, [&](const gpu::Tile& tile) {
    const size_t left = (tile.x0 - uint32_t(settings.crop.x0)) / tile.stride;
    const size_t top = (tile.y0 - uint32_t(settings.crop.y0)) / tile.stride;
    for (uint32_t y = 0; y < tile.height; ++y) {
      const size_t source = size_t(y) * tile.width;
      const size_t target = (top + y) * size_t(grid.width()) + left;
      for (uint32_t x = 0; x < tile.width; ++x)
        std::memcpy(&picture.image.rgb[3 * (target + x)], &passes.pixel(source + x), 3 * sizeof(float));
    }
  });
  picture.compileSeconds = passes.compileSeconds();
  picture.traceSeconds = passes.traceSeconds();
  picture.readbackSeconds = passes.readbackSeconds();
  return picture;
}

Visits ShaderRenderer::countVisits(const Spirv& kernel, const RenderSettings& settings, const Progress& progress,
                                   const Dispatching& dispatching) {
  return withAllItNeeds(settings, dispatching, [&] { return count(kernel, settings, progress, dispatching); });
}

Visits ShaderRenderer::count(const Spirv& kernel, const RenderSettings& settings, const Progress& progress,
                             const Dispatching& dispatching) {
  TilePasses passes(*scene_, kernel, settings, dispatching, 1, true);
  Visits visits;
  RayCounts* const kinds[kCounterWords] = {&visits.rays, &visits.nodes, &visits.primitives};
  passes.run(progress, [&](const gpu::Tile& tile) {
    const std::vector<std::array<uint32_t, 4>> counts = passes.readCounts(tile);
    for (size_t i = 0; i < counts.size(); ++i) {
      RayCounts& count = *kinds[i / tile.slots];
      count.eye += counts[i][0];
      count.reflected += counts[i][1];
      count.refracted += counts[i][2];
      count.shadow += counts[i][3];
    }
  });
  return visits;
}

}  // namespace turner
