// The scene as its file means it: plain data in double precision, in world units. Comes from scene_load, goes to
// round_scene, bvh, pack and reference. Knows nothing of files, Vulkan or the packed form.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <string>
#include <tuple>
#include <vector>

#include "base/parameter_setting.h"
#include "primitives/cone.h"
#include "primitives/sphere.h"
#include "primitives/triangle.h"

namespace turner {

struct Camera {
  glm::dvec3 eye{0, 0, 1};
  glm::dvec3 target{0, 0, 0};
  glm::dvec3 up{0, 1, 0};
  double fov = 45;  // vertical, degrees, in (0, 180)
};

enum class Falloff { none, inverseSquare };

struct Light {
  glm::dvec3 position{0, 0, 0};
  glm::dvec3 color{1, 1, 1};  // E_i of the light transport (docs: scenes); times 1/d^2 for inverseSquare
  Falloff falloff = Falloff::none;

  // Visits what is neither a place nor a choice, as dvec3& and double&: roundScene rounds it as it is.
  template <class Self, class Visit>
  static void visitValues(Self& light, Visit&& visit) {
    visit(light.color);
  }
};

struct Material {
  std::string name;
  glm::dvec3 diffuse{0, 0, 0};   // k_d
  glm::dvec3 specular{0, 0, 0};  // k_s
  double shininess = 1;          // n, >= 0
  double reflect = 0;            // r
  double transmit = 0;           // t
  double eta = 1.5;              // eta, looked at only where transmit > 0
  double localWeight = 1;        // w_local: 1 - r - t in a scene of ours, 1 in NFF

  // Visits all values, as dvec3& and double&: they are rounded, and compared, one like the other.
  template <class Self, class Visit>
  static void visitValues(Self& m, Visit&& visit) {
    for (auto* v : {&m.diffuse, &m.specular}) visit(*v);
    for (auto* x : {&m.shininess, &m.reflect, &m.transmit, &m.eta, &m.localWeight}) visit(*x);
  }
};

// How many primitives of a type there are, under the name of its list.
struct PrimitiveCount {
  std::string name;
  uint64_t count = 0;

  template <class Bytes>
  void fields(Bytes& b) {
    b(name, count);
  }
};
using PrimitiveCounts = std::vector<PrimitiveCount>;  // of all types

// As "2 spheres, 0 cones, 1 triangles".
inline std::string toText(const PrimitiveCounts& counts) {
  std::string text;
  for (const PrimitiveCount& type : counts)
    text += (text.empty() ? "" : ", ") + std::to_string(type.count) + ' ' + type.name;
  return text;
}

// A file that a scene was read from.
struct SourceFile {
  std::string path;    // as written in the scene, or the scene's own name
  std::string sha256;  // of its bytes, in hex
};

struct Scene {
  std::string name;                 // the file's name without folder and extension
  std::vector<SourceFile> sources;  // the scene file first, then its meshes in order
  glm::dvec3 background{0, 0, 0};
  int depth = 5;  // levels of the ray tree, the eye ray being level 1
  int width = 512;
  int height = 512;
  Camera camera;
  std::vector<Light> lights;
  std::vector<Material> materials;
  // Primitive ids: spheres, then cones, then triangles, then the faces of meshes (which stand behind the triangles
  // here), each in file order. Among hits at equal distance the lowest id wins.
  std::vector<Sphere> spheres;
  std::vector<Cone> cones;
  std::vector<Triangle> triangles;
  // Of vertices, which triangles share; some may be no triangle's.
  std::vector<glm::dvec3> positions, normals;
  // Values for parameters of edited shaders.
  std::vector<ParameterSetting> parameters;
  // What the user should be told: lines "FILE: note: WHAT" or "FILE:LINE:COLUMN: note: WHAT".
  std::vector<std::string> notes;

  TriangleCorners cornersOf(const Triangle& triangle) const { return at(positions, triangle.positions); }
  const glm::dvec3& cornerOf(const Triangle& triangle, size_t k) const { return positions[triangle.positions[k]]; }
  TriangleCorners cornersOf(size_t triangle) const { return cornersOf(triangles[triangle]); }
  // Of a smooth one.
  TriangleCorners normalsOf(const Triangle& triangle) const { return at(normals, triangle.normals); }
  TriangleCorners normalsOf(size_t triangle) const { return normalsOf(triangles[triangle]); }

  // A triangle with three vertices of its own.
  void addTriangle(const TriangleCorners& corners, uint32_t material = 0) {
    triangles.push_back({.positions = append(positions, corners), .material = material});
  }
  void addTriangle(const TriangleCorners& corners, const TriangleCorners& vertexNormals, uint32_t material = 0) {
    triangles.push_back({append(positions, corners), append(normals, vertexNormals), material});
  }

  // The types of primitives in the order of their ids; triangles are the last.
  static constexpr std::array kTypeNames = {"spheres", "cones", "triangles"};
  template <class Self>
  static auto primitiveLists(Self& scene) {
    return std::tie(scene.spheres, scene.cones, scene.triangles);
  }
  // Visits all lists: visit(name, vector).
  template <class Self, class Visit>
  static void visitPrimitives(Self& scene, Visit&& visit) {
    const char* const* name = kTypeNames.data();
    std::apply([&](auto&... list) { (visit(*name++, list), ...); }, primitiveLists(scene));
  }
  // Visits one primitive: visit(primitive, its index in its list). Returns what that returns.
  template <size_t kType = 0, class Visit>
  decltype(auto) visitPrimitive(size_t id, Visit&& visit) const {
    const auto& list = std::get<kType>(primitiveLists(*this));
    if constexpr (kType + 1 < kTypeNames.size())
      if (id >= list.size()) return visitPrimitive<kType + 1>(id - list.size(), visit);
    return visit(list[id], id);
  }
  PrimitiveCounts primitiveCounts() const {
    PrimitiveCounts counts;
    visitPrimitives(*this, [&](const char* type, const auto& list) { counts.push_back({type, list.size()}); });
    return counts;
  }
  size_t primitiveCount() const {
    size_t count = 0;
    visitPrimitives(*this, [&](const char*, const auto& list) { count += list.size(); });
    return count;
  }

 private:
  using Indices = std::array<uint32_t, 3>;
  static TriangleCorners at(const std::vector<glm::dvec3>& values, const Indices& i) {
    return {values[i[0]], values[i[1]], values[i[2]]};
  }
  static Indices append(std::vector<glm::dvec3>& values, const TriangleCorners& corners) {
    const uint32_t first = uint32_t(values.size());
    values.insert(values.end(), corners.begin(), corners.end());
    return {first, first + 1, first + 2};
  }
};

// What is asked of all primitives alike; most have no need of their scene.
template <class Primitive>
Bounds boundsOf(const Scene&, const Primitive& primitive) {
  return boundsOf(primitive);
}
inline Bounds boundsOf(const Scene& scene, const Triangle& triangle) {
  return boundsOf(scene.cornersOf(triangle));
}
template <class Primitive>
bool isWithinReach(const Scene&, const Primitive& local) {
  return isWithinReach(local);
}
inline bool isWithinReach(const Scene& scene, const Triangle& local) {
  return isWithinReach(scene.cornersOf(local));
}

// The largest values that a scene or the command line may ask for.
inline constexpr int kMaxDepth = 64;
inline constexpr int kMaxSize = 65536;   // width and height, pixels
inline constexpr int kMaxSamples = 256;  // n of the n x n grid: its cells' 24-bit fractions must fit in 32 bits

}  // namespace turner
