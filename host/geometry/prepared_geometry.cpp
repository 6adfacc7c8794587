// Triangles find their partners among those that follow closely in the scene: meshes are written strip by strip.
#include "geometry/prepared_geometry.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <utility>

#include "base/reserve.h"
#include "base/threads.h"

namespace turner {
namespace {

double halfArea(const Bounds& bounds) {
  const glm::dvec3 size = bounds.hi - bounds.lo;
  return size.x * size.y + size.y * size.z + size.z * size.x;
}

// Whether all but their geometry allows two triangles to be a pair.
bool areAlike(const Triangle& first, const Triangle& second) {
  return first.material == second.material && first.isSmooth() == second.isSmooth();
}

// The edge that two triangles share, by the vertices opposite it. Both must go counter-clockwise on the same side, so
// that each has the edge in its own direction. False if there is none; it hardly matters which where there are several.
bool sharesEdge(const Scene& scene, const Triangle& first, const Triangle& second, int& firstOpposite,
                int& secondOpposite) {
  // Files may repeat a vertex, under another index.
  const auto isSame = [&](int i, int j) {
    const uint32_t a = first.positions[size_t(i % 3)], b = second.positions[size_t(j % 3)];
    return a == b || scene.positions[a] == scene.positions[b];
  };
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      if (!isSame(i + 1, j + 2) || !isSame(i + 2, j + 1)) continue;
      firstOpposite = i;
      secondOpposite = j;
      return true;
    }
  return false;
}

// Turns the corners of a triangle, in their cyclic order, until this one is the first.
void turnTo(Triangle& triangle, int corner) {
  std::rotate(triangle.positions.begin(), triangle.positions.begin() + corner, triangle.positions.end());
  std::rotate(triangle.normals.begin(), triangle.normals.begin() + corner, triangle.normals.end());
}

constexpr size_t kReach = 16;       // how far behind a triangle its partner may stand
constexpr size_t kPiece = 1 << 14;  // triangles that look for partners among themselves

// Pairs the triangles of one piece.
std::vector<TrianglePair> pairPiece(Scene& scene, size_t begin, size_t end) {
  std::vector<TrianglePair> pairs;
  pairs.reserve(end - begin);
  std::vector<bool> taken(end - begin);
  for (size_t i = begin; i < end; ++i) {
    if (taken[i - begin]) continue;
    Triangle& first = scene.triangles[i];
    const Bounds bounds = boundsOf(scene, first);
    // The kernel's work on a pair is that on one triangle, for every ray that comes near: the common box must be
    // entered less often than both boxes would be. By a tenth at least: that keeps a tiny triangle out of the box of a
    // large one, from afar in which its areas round to 0 and tell nothing.
    double leastGrowth = 0.9;
    TrianglePair pair{uint32_t(i)};
    int corners[2] = {0, 0};
    for (size_t j = i + 1; j < std::min(end, i + 1 + kReach) && leastGrowth > 0.6; ++j) {
      int opposite[2];
      if (taken[j - begin] || !areAlike(first, scene.triangles[j]) ||
          !sharesEdge(scene, first, scene.triangles[j], opposite[0], opposite[1]))
        continue;
      const Bounds other = boundsOf(scene, scene.triangles[j]);
      const double growth = halfArea(bounds.united(other)) / (halfArea(bounds) + halfArea(other));
      if (!(growth < leastGrowth)) continue;
      leastGrowth = growth;
      pair.second = uint32_t(j);
      std::copy(std::begin(opposite), std::end(opposite), corners);
    }
    if (!pair.isAlone()) {
      taken[pair.second - begin] = true;
      turnTo(first, corners[0]);
      turnTo(scene.triangles[pair.second], corners[1]);
    }
    pairs.push_back(pair);
  }
  return pairs;
}

// No pair reaches over two solids then. The front of their triangles is that of the winding.
void giveMediaMaterials(PreparedGeometry& prepared) {
  Scene& scene = prepared.scene;
  prepared.dielectrics = findNestedDielectrics(scene);
  prepared.firstMedium = uint32_t(scene.materials.size());
  for (const uint32_t material : prepared.dielectrics.materials) scene.materials.push_back(scene.materials[material]);
  for (size_t i = 0; i < prepared.dielectrics.ofSpheres.size(); ++i)
    if (const uint32_t solid = prepared.dielectrics.ofSpheres[i]; solid != kNoMedium)
      scene.spheres[i].material = prepared.firstMedium + solid;
  for (size_t i = 0; i < prepared.dielectrics.ofTriangles.size(); ++i)
    if (const uint32_t solid = prepared.dielectrics.ofTriangles[i]; solid != kNoMedium) {
      Triangle& triangle = scene.triangles[i];
      triangle.material = prepared.firstMedium + solid;
      if (facing(scene, triangle) > 0) continue;
      std::swap(triangle.positions[1], triangle.positions[2]);
      std::swap(triangle.normals[1], triangle.normals[2]);
    }
}

std::vector<TrianglePair> pairTriangles(Scene& scene) {
  const size_t count = scene.triangles.size();
  std::vector<std::vector<TrianglePair>> pieces((count + kPiece - 1) / kPiece);
  parallelFor(pieces.size(),
              [&](size_t i) { pieces[i] = pairPiece(scene, i * kPiece, std::min(count, (i + 1) * kPiece)); });
  std::vector<TrianglePair> pairs;
  size_t total = 0;
  for (const auto& piece : pieces) total += piece.size();
  reservePrefaulted(pairs, total);
  for (const auto& piece : pieces) pairs.insert(pairs.end(), piece.begin(), piece.end());
  return pairs;
}

glm::vec3 roundedDown(const glm::dvec3& v) {
  const auto down = [](double x) {
    const float f = float(x);
    return double(f) > x ? std::nextafterf(f, -INFINITY) : f;
  };
  return {down(v.x), down(v.y), down(v.z)};
}

glm::vec3 roundedUp(const glm::dvec3& v) {
  return -roundedDown(-v);
}

Bounds boundsOf(const Scene& scene, const TrianglePair& pair) {
  const Bounds first = boundsOf(scene, scene.triangles[pair.first]);
  return pair.isAlone() ? first : first.united(boundsOf(scene, scene.triangles[pair.second]));
}

std::vector<Box> paddedBoxes(const PreparedGeometry& prepared) {
  const size_t count = prepared.elementCount();
  const auto bounds = [&](size_t i) {
    return prepared.visitElement(i, [&](const auto& element) { return boundsOf(prepared.scene, element); });
  };
  Bounds all;
  for (size_t i = 0; i < count; ++i) all.include(bounds(i));
  const glm::dvec3 size = all.hi - all.lo;
  const double extent = count == 0 ? 0 : std::max({size.x, size.y, size.z});

  // A primitive test moves vertices by up to a rounding of their distance to the ray's origin, which is up to the
  // scene's extent; the test of a node's planes (origin + byte * scale, all in units of the ray) moves them by up to
  // five. Eight roundings of each cover both, and the ray that the list of a light is made for instead of the rounded
  // one.
  std::vector<Box> boxes;
  reservePrefaulted(boxes, count);
  boxes.resize(count);
  forAll(count, [&](size_t i) {
    const auto [lo, hi] = bounds(i);
    const glm::dvec3 pad = 0x1p-21 * (glm::max(glm::abs(lo), glm::abs(hi)) + extent);
    boxes[i] = {roundedDown(lo - pad), roundedUp(hi + pad)};
  });
  return boxes;
}

}  // namespace

PreparedGeometry prepareGeometry(Scene local) {
  PreparedGeometry prepared;
  prepared.scene = std::move(local);
  giveMediaMaterials(prepared);
  prepared.pairs = pairTriangles(prepared.scene);
  prepared.boxes = paddedBoxes(prepared);
  return prepared;
}

}  // namespace turner
