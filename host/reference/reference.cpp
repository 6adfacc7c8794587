// Renders block by block on all cores.
#include "reference/reference.h"

#include <algorithm>
#include <mutex>
#include <stop_token>

#include "base/stopwatch.h"
#include "base/threads.h"
#include "reference/aggregate.h"
#include "reference/pixel.h"
#include "reference/samples.h"
#include "reference/whitted.h"

namespace turner {

using reference::Aggregate;
using reference::ImagePlane;
using reference::Whitted;

ReferencePicture renderReference(const Scene& scene, const RenderSettings& settings, const Progress& progress,
                                 ReferenceSearch search) {
  if (progress) progress(0);
  const Aggregate aggregate(scene, search);
  const ImagePlane plane(scene.camera, settings);
  const Stopwatch stopwatch;
  ReferencePicture picture;
  const Window& crop = settings.crop;
  picture.image = Image(settings.width, settings.height, crop);

  constexpr int kBlock = 16;  // pixels to a side: what a core takes at a time
  const int across = (crop.width() + kBlock - 1) / kBlock, down = (crop.height() + kBlock - 1) / kBlock;
  std::stop_source stop;
  std::mutex raysMutex;
  const auto renderBlock = [&](size_t block) {
    const int x0 = crop.x0 + int(block) % across * kBlock, y0 = crop.y0 + int(block) / across * kBlock;
    Whitted whitted(aggregate, settings, stop.get_token());
    for (int y = y0; y < std::min(y0 + kBlock, crop.y1); ++y)
      for (int x = x0; x < std::min(x0 + kBlock, crop.x1); ++x) {
        if (stop.stop_requested()) return;
        const glm::dvec3 color = reference::pixelColor(whitted, plane, settings, x, y);
        float* rgb = &picture.image.rgb[3 * (size_t(y - crop.y0) * size_t(crop.width()) + size_t(x - crop.x0))];
        for (int k = 0; k < 3; ++k) rgb[k] = float(color[k]);
      }
    const std::lock_guard lock(raysMutex);
    picture.rays.eye += whitted.counts.eye;
    picture.rays.reflected += whitted.counts.reflected;
    picture.rays.refracted += whitted.counts.refracted;
    picture.rays.shadow += whitted.counts.shadow;
  };
  parallelFor(size_t(across) * size_t(down), renderBlock, progress, stop);
  if (progress) progress(1);
  picture.traceSeconds = stopwatch.seconds();
  return picture;
}

std::vector<PixelBounds> renderEnvelope(const Scene& scene, const RenderSettings& settings,
                                        std::span<const Pixel> pixels, int rays, const Progress& progress) {
  const Aggregate aggregate(scene, ReferenceSearch::tree);
  const ImagePlane plane(scene.camera, settings);
  std::vector<PixelBounds> bounds(pixels.size());
  std::stop_source stop;
  const auto findBounds = [&](size_t i) {
    Whitted whitted(aggregate, settings, stop.get_token());
    bounds[i] = reference::pixelBounds(whitted, plane, settings, pixels[i].x, pixels[i].y, rays);
  };
  parallelFor(pixels.size(), findBounds, progress, stop);
  if (progress) progress(1);
  return bounds;
}

}  // namespace turner
