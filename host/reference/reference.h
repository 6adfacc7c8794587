// The witness: renders a scene in double precision, recursively, with formulas and an acceleration structure of its
// own. Shares the scene and the settings with the shader's path, and no tracing code.
#pragma once

#include <span>
#include <vector>

#include "image/envelope.h"
#include "image/image.h"
#include "image/settings.h"
#include "scene/scene.h"

namespace turner {

struct ReferencePicture {
  Image image;
  RayCounts rays;
  double traceSeconds = 0;  // by the wall's clock, without building the tree
};

// How the reference finds its hits. Brute force tests every primitive; it is the tests' witness for the tree.
enum class ReferenceSearch { tree, bruteForce };

// Renders `scene` (as it stands: exact, or the result of roundScene) on all cores.
// The picture does not depend on the number of cores, nor on the crop.
ReferencePicture renderReference(const Scene& scene, const RenderSettings& settings, const Progress& progress = {},
                                 ReferenceSearch search = ReferenceSearch::tree);

// For each of the pixels, what its channels may become where every eye ray errs by up to 4 ulp of a float near 1 in
// each component of its direction: the means of its samples' minima and maxima, each by so many rays. Runs on all
// cores.
std::vector<PixelBounds> renderEnvelope(const Scene& scene, const RenderSettings& settings,
                                        std::span<const Pixel> pixels, int rays, const Progress& progress = {});

}  // namespace turner
