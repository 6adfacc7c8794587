#include "gpu/prepare.h"

#include <utility>

#include "accel/bvh.h"
#include "geometry/prepared_geometry.h"
#include "geometry/round_scene.h"

namespace turner {

PackedScene prepareScene(Scene scene, const RenderSettings& settings) {
  Scene local = roundScene(std::move(scene));
  checkReach(local);
  const Shapes shapes = shapesOf(std::move(local));
  return packScene(shapes, buildBvh(shapes.boxes, shapes.firstPair()), settings);
}

}  // namespace turner
