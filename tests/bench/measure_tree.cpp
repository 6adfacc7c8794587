// A developer's program, not a test: what the tree of boxes is worth. Renders cliff_hanger.json and spheres of more and
// more triangles twice with the same kernel, through the tree and through a list that every ray walks to its end, and
// prints the table of docs/performance.md. The pictures must be equal, bit for bit.
// usage: turner_measure_tree
#include <fmt/format.h>

#include <cmath>
#include <cstring>
#include <numbers>

#include "base/errors.h"
#include "scene/scene_load.h"
#include "support/closed_form.h"
#include "support/shader_harness.h"

namespace turner {
namespace {

// Nodes in a row whose boxes hold everything: each has a leaf, and the rest of the list. Every ray tests every
// primitive.
Bvh listOf(const std::vector<Box>& boxes, const KindStarts& kinds) {
  const Box everything{glm::vec3(-1e9f), glm::vec3(1e9f)};
  Bvh list;
  std::vector<BvhChild> leaves;
  for (uint32_t i = 0; i < boxes.size(); ++i) list.order.push_back(i);
  for (uint32_t first = 0; first < boxes.size();) {
    const auto start = std::upper_bound(kinds.begin(), kinds.end(), first);
    const uint32_t end = uint32_t(start != kinds.end() ? *start : boxes.size());
    const uint32_t count = std::min(gpu::kMaxLeafSize, end - first);
    leaves.push_back({everything, first, count});
    first += count;
  }
  for (uint32_t i = 0; i + 1 < leaves.size(); ++i) {
    const bool last = i + 2 == leaves.size();
    list.nodes.push_back({{leaves[i], last ? leaves[i + 1] : BvhChild{everything, i + 1, 0}}});
  }
  list.root = leaves.size() == 1 ? leaves[0] : BvhChild{everything, 0, 0};
  list.depth = 1;  // of the stack that a walk needs: each leaf comes off at once
  return list;
}

// A sphere of about this many triangles, in rings between two poles, beside an exact one on a floor.
Scene tessellatedSphere(int triangles) {
  Scene scene;
  scene.background = {0.2, 0.3, 0.5};
  scene.camera = {.eye = {0, 1.2, 6}, .target = {0, 0.2, 0}, .fov = 35};
  scene.lights = {{.position = {4, 6, 5}}};
  scene.materials = {closed_form::matte({0.7, 0.6, 0.5})};
  scene.spheres = {{{1.1, 0, 0}, 1, 0}};
  closed_form::addFloor(scene, -1, 20, 0);
  const int rings = std::max(2, int(std::lround(std::sqrt(triangles / 4.0)))), sectors = 2 * rings;
  const auto point = [&](int ring, int sector) {
    const double theta = std::numbers::pi * ring / rings, phi = 2 * std::numbers::pi * sector / sectors;
    return glm::dvec3(-1.1 + std::sin(theta) * std::cos(phi), std::cos(theta), std::sin(theta) * std::sin(phi));
  };
  for (int ring = 0; ring < rings; ++ring) {
    for (int sector = 0; sector < sectors; ++sector) {
      const glm::dvec3 a = point(ring, sector), b = point(ring, sector + 1);
      const glm::dvec3 c = point(ring + 1, sector), d = point(ring + 1, sector + 1);
      if (ring > 0) scene.addTriangle({a, b, d}, 0);
      if (ring + 1 < rings) scene.addTriangle({a, d, c}, 0);
    }
  }
  return scene;
}

// The median of three runs; also the last picture.
double traceSeconds(const PackedScene& scene, const RenderSettings& settings, Image& image) {
  test::renderer().upload(scene);
  std::vector<double> seconds;
  for (int run = 0; run < 3; ++run) {
    ShaderPicture picture = test::renderer().render(test::kernel(), settings);
    seconds.push_back(picture.traceSeconds);
    image = std::move(picture.image);
  }
  std::sort(seconds.begin(), seconds.end());
  return seconds[1];
}

void measure(const std::string& name, const Scene& scene) {
  RenderSettings settings = test::settingsOf(scene, 512, 512);
  settings.crop = {160, 224, 224, 288};
  const PreparedGeometry prepared = prepareGeometry(roundScene(scene));
  const PackedScene tree =
      packScene(prepared, buildBvh(prepared.boxes, prepared.typeStarts()), settings, TraversalStart::wholeTree);
  const PackedScene list =
      packScene(prepared, listOf(prepared.boxes, prepared.typeStarts()), settings, TraversalStart::wholeTree);
  Image treeImage, listImage;
  const double treeSeconds = traceSeconds(tree, settings, treeImage);
  const double rays = double(test::renderer().countVisits(test::kernel(), settings).rays.total());
  const double listSeconds = traceSeconds(list, settings, listImage);
  if (std::memcmp(treeImage.rgb.data(), listImage.rgb.data(), treeImage.rgb.size() * sizeof(float)) != 0)
    throw RunError(name + ": tree and list render different pictures");
  fmt::print("| {} | {} | {:.3f} | {:.2f} | {:.0f} | {} | {:.0f} |\n", name, tree.primitiveCount,
             listSeconds / rays * 1e6, treeSeconds / rays * 1e6, listSeconds / treeSeconds, tree.treeDepth,
             double(tree.bytes()) / double(tree.primitiveCount));
}

}  // namespace
}  // namespace turner

int main() {
  using namespace turner;
  const DeviceInfo device = chooseDevice(listDevices(), "");
  fmt::print("{}, {}\n\n", device.name, device.driver);
  fmt::print("| scene | primitives | list, us/ray | tree, us/ray | ratio | depth | bytes/primitive |\n");
  fmt::print("| --- | ---: | ---: | ---: | ---: | ---: | ---: |\n");
  measure("cliff_hanger.json", loadScene(TURNER_SCENES_DIR "/cliff_hanger.json"));
  for (const int triangles : {100, 1000, 10'000, 100'000})
    measure(fmt::format("sphere of {} triangles", triangles), tessellatedSphere(triangles));
  test::endRenderer();
}
