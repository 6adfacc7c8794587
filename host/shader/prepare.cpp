#include "shader/prepare.h"

#include <utility>

#include "shader/bvh.h"
#include "shader/round_scene.h"
#include "shader/shapes.h"

namespace turner {

PackedScene prepareScene(Scene scene, const RenderSettings& settings) {
  Scene local = roundScene(std::move(scene));
  checkReach(local);
  const Shapes shapes = shapesOf(std::move(local));
  return packScene(shapes, buildBvh(shapes.boxes, shapes.firstPair()), settings);
}

}  // namespace turner
