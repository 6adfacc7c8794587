// Chooses the parser by the extension, of a pipe by what it says, then adds what the file left out.
#include "scene/scene_load.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <glm/geometric.hpp>
#include <numbers>
#include <string_view>
#include <utility>

#include "base/errors.h"
#include "base/text_file.h"
#include "scene/json/scene_json.h"
#include "scene/nff/scene_nff.h"
#include "scene/plain_text.h"

namespace turner {

namespace {

// JSON begins with a brace, behind blanks and comments; NFF with an entity's letter or a comment of its own.
bool looksLikeNff(std::string_view text) {
  for (;;) {
    const size_t begin = text.find_first_not_of(" \t\r\n");
    if (begin == std::string_view::npos) return false;
    text.remove_prefix(begin);
    const std::string_view end = text.starts_with("//") ? "\n" : text.starts_with("/*") ? "*/" : "";
    if (end.empty()) return text[0] == '#' || (text[0] >= 'a' && text[0] <= 'z');
    text.remove_prefix(std::min(text.find(end, 2), text.size()));
    text.remove_prefix(std::min(end.size(), text.size()));
  }
}

ParsedScene parse(const std::string& path) {
  const std::string extension = lowerExtension(path);
  const bool isNamed = extension == ".json" || extension == ".nff";
  if (!isNamed && !isStream(path)) {
    throw InputError(path +
                     ": error: " + (extension.empty() ? "no extension" : "unknown extension \"" + extension + '"') +
                     "; a scene is a .json or an .nff file");
  }
  const std::string text = readTextFile(path);
  const std::string name = nameOfInput(path);
  const bool isNff = isNamed ? extension == ".nff" : looksLikeNff(PlainText(name, text).view());
  return isNff ? parseNffScene(name, text) : parseJsonScene(name, text);
}

// Whether the cross product of two edges vanishes. The edges are brought to about 1 first, by powers of two, so that it
// does so for the triangle's shape and not because tiny numbers underflow.
bool hasNoArea(const TriangleCorners& corners) {
  const auto& [a, b, c] = corners;
  // Whatever is as large as this without that is so with it too.
  constexpr double kFarFromUnderflow = 1e-280;
  const glm::dvec3 size = glm::abs(glm::cross(b - a, c - a));
  if (std::max({size.x, size.y, size.z}) > kFarFromUnderflow) return false;

  const auto scaled = [](glm::dvec3 edge) {
    const double largest = std::max({std::abs(edge.x), std::abs(edge.y), std::abs(edge.z)});
    if (largest == 0) return edge;
    const int exponent = -std::ilogb(largest);
    return glm::dvec3(std::scalbn(edge.x, exponent), std::scalbn(edge.y, exponent), std::scalbn(edge.z, exponent));
  };
  return b == c || glm::cross(scaled(b - a), scaled(c - a)) == glm::dvec3(0);
}

// Their vertices stay behind in the scene: others may share them.
void dropTrianglesWithoutArea(Scene& scene, const std::string& notePrefix) {
  const size_t dropped =
      std::erase_if(scene.triangles, [&](const Triangle& triangle) { return hasNoArea(scene.cornersOf(triangle)); });
  if (dropped == 1) scene.notes.push_back(notePrefix + "1 triangle without area was dropped");
  if (dropped > 1) scene.notes.push_back(notePrefix + std::to_string(dropped) + " triangles without area were dropped");
}

Bounds boundsOf(const Scene& scene) {
  Bounds bounds;
  Scene::visitPrimitives(scene, [&](const char*, const auto& primitives) {
    for (const auto& primitive : primitives) bounds.include(boundsOf(scene, primitive));
  });
  return bounds;
}

// Looks from the front, a little from above and from the right, at the sphere around the scene's bounds.
Camera fitCamera(const Scene& scene) {
  Camera camera;
  if (scene.primitiveCount() == 0) return camera;
  const Bounds bounds = boundsOf(scene);
  const glm::dvec3 center = 0.5 * (bounds.lo + bounds.hi);
  const double radius = 0.5 * glm::length(bounds.hi - bounds.lo);

  // The narrower of the two angles of view must hold the sphere, with a small margin around it.
  const double tangent = std::tan(0.5 * camera.fov * std::numbers::pi / 180);
  const double narrower = std::atan(tangent * std::min(1.0, double(scene.width) / scene.height));
  constexpr double kMargin = 1.05;
  double distance = kMargin * radius / std::sin(narrower);
  // Far from the origin, what is very small would leave no distance after rounding.
  distance = std::max(distance, 1e-9 * glm::length(center));
  if (distance == 0) distance = 1;

  camera.target = center;
  camera.eye = center + distance * glm::normalize(glm::dvec3(0.25, 0.35, 1));
  return camera;
}

void noteWhatIsMissing(Scene& scene, bool hasCamera, const std::string& notePrefix) {
  const auto note = [&](const char* text) { scene.notes.push_back(notePrefix + text); };
  if (scene.lights.empty()) note("the scene has no lights: its objects are black");
  if (scene.primitiveCount() == 0) note("the scene has no objects: the picture is its background");
  if (!hasCamera) note("the scene has no camera: one was fitted to its bounds");
}

}  // namespace

Scene loadScene(const std::string& path) {
  ParsedScene parsed = parse(path);
  Scene scene = std::move(parsed.scene);
  const bool hasName = nameOfInput(path) == path;
  scene.name = hasName ? std::filesystem::path(path).stem().string() : "stdin";
  const std::string notePrefix = nameOfInput(path) + ": note: ";
  dropTrianglesWithoutArea(scene, notePrefix);
  if (!parsed.hasCamera) scene.camera = fitCamera(scene);
  noteWhatIsMissing(scene, parsed.hasCamera, notePrefix);
  return scene;
}

std::vector<std::string> filesOf(const std::string& path, const std::vector<SourceFile>& sources) {
  std::vector<std::string> files = {path};
  for (size_t i = 1; i < sources.size(); ++i)
    files.push_back((std::filesystem::path(nameOfInput(path)).parent_path() / sources[i].path).string());
  return files;
}

}  // namespace turner
