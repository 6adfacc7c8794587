// The steps in their order; each takes over the value of the step before.
#include "gpu/prepare.h"

#include <utility>

#include "accel/bvh.h"
#include "geometry/prepared_geometry.h"
#include "geometry/round_scene.h"

namespace turner {

PackedScene prepareScene(Scene scene, const RenderSettings& settings) {
  const LocalFrame frame = localFrame(scene.camera);
  Scene local = roundScene(std::move(scene));
  checkReach(local);
  const PreparedGeometry prepared = prepareGeometry(std::move(local));
  PackedScene packed = packScene(prepared, buildBvh(prepared.boxes, prepared.typeStarts()), settings);
  packed.view.frame = frame;
  return packed;
}

}  // namespace turner
