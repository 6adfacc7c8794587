// Scenes whose pixels are known from a formula on paper, and those values: what every renderer must give.
// Knows the scene and the settings, and no renderer.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <numbers>
#include <ostream>
#include <string>
#include <utility>
#include <vector>

#include "image/settings.h"
#include "scene/scene.h"

namespace turner::closed_form {

using glm::dvec3;

inline constexpr double kDegree = std::numbers::pi / 180;

// Float32 arithmetic over a few operations, for values of about 1.
inline constexpr double kFloatError = 2e-6;

struct Expected {
  int x, y;
  dvec3 color;
  double tolerance = kFloatError;  // absolute, in each channel
};

struct Case {
  std::string name;
  Scene scene;
  RenderSettings settings;
  std::vector<Expected> expected;
};

inline void PrintTo(const Case& known, std::ostream* out) {
  *out << known.name;
}  // for GoogleTest

// ---- What the scenes are made of ----

inline Material matte(const dvec3& diffuse) {
  return {.name = "matte", .diffuse = diffuse};
}

inline Material mirror(double reflect) {
  return {.name = "mirror", .reflect = reflect, .localWeight = 1 - reflect};
}

inline Material glass(double reflect, double transmit, double eta) {
  return {.name = "glass", .reflect = reflect, .transmit = transmit, .eta = eta, .localWeight = 1 - reflect - transmit};
}

inline uint32_t addMaterial(Scene& scene, const Material& material) {
  scene.materials.push_back(material);
  return uint32_t(scene.materials.size() - 1);
}

// A parallelogram of two triangles with one corner and two edges; its front looks along cross(edge1, edge2).
inline void addQuad(Scene& scene, const dvec3& corner, const dvec3& edge1, const dvec3& edge2, uint32_t material) {
  scene.addTriangle({corner, corner + edge1, corner + edge1 + edge2}, material);
  scene.addTriangle({corner, corner + edge1 + edge2, corner + edge2}, material);
}

// A square floor at this height, with its front up.
inline void addFloor(Scene& scene, double y, double halfSize, uint32_t material) {
  addQuad(scene, {-halfSize, y, halfSize}, {2 * halfSize, 0, 0}, {0, 0, -2 * halfSize}, material);
}

inline Camera lookAt(const dvec3& eye, const dvec3& target, const dvec3& up, double fov) {
  return {.eye = eye, .target = target, .up = up, .fov = fov};
}

inline RenderSettings pixels(int width, int height, int depth = 5) {
  return {.width = width, .height = height, .crop = {0, 0, width, height}, .depth = depth};
}

// max(0, N.L) at `point` of a surface with normal N.
inline double cosineAt(const dvec3& point, const dvec3& N, const dvec3& light) {
  return std::max(0.0, glm::dot(N, glm::normalize(light - point)));
}

// ---- The cases ----

// A floor seen from 5 above, straight down, with 5x5 pixels at 90 degrees: pixel (i, j) sees (2i - 4, 0, 2j - 4).
inline Case floorFromAbove(std::string name, const Material& material, const Light& light) {
  Case c{std::move(name), {}, pixels(5, 5), {}};
  c.scene.camera = lookAt({0, 5, 0}, {0, 0, 0}, {0, 0, -1}, 90);
  c.scene.lights = {light};
  addFloor(c.scene, 0, 50, addMaterial(c.scene, material));
  const dvec3 N(0, 1, 0);
  for (int j = 0; j < 5; ++j)
    for (int i = 0; i < 5; ++i) {
      const dvec3 x(2 * i - 4, 0, 2 * j - 4);
      const dvec3 L = glm::normalize(light.position - x), V = glm::normalize(c.scene.camera.eye - x);
      const double cosH = glm::dot(N, glm::normalize(L + V));
      const double d = light.falloff == Falloff::inverseSquare ? glm::length(light.position - x) : 1;
      const dvec3 color = light.color / (d * d) *
                          (material.diffuse + material.specular * std::pow(cosH, material.shininess)) * glm::dot(N, L);
      c.expected.push_back({i, j, color});
    }
  return c;
}

inline Case diffuse() {
  return floorFromAbove("Diffuse", matte({0.8, 0.4, 0.2}), {.position = {1, 4, 2}, .color = {1, 0.5, 0.25}});
}

inline Case inverseSquare() {
  return floorFromAbove("InverseSquare", matte({0.8, 0.4, 0.2}),
                        {.position = {1, 2, 2}, .color = {4, 2, 1}, .falloff = Falloff::inverseSquare});
}

inline Case blinnPhong(std::string name, double shininess) {
  return floorFromAbove(
      std::move(name),
      {.name = "shiny", .diffuse = {0.1, 0.2, 0.3}, .specular = {0.7, 0.5, 0.25}, .shininess = shininess},
      {.position = {1, 4, 2}, .color = {1, 1, 0.5}});
}

// An opaque half-plane x < -0.95 at height 2 and a light at (-2, 4, 0): the shadow on the floor ends at
// x = -2 + (2 - 0.95) / (4 - 2) * 4 = 0.1. Pixel i of 32 sees x = (2i - 31) / 32, so that 18 is the first lit one.
inline Case shadowEdge() {
  Case c{"ShadowEdge", {}, pixels(32, 32), {}};
  c.scene.camera = lookAt({0, 1, 0}, {0, 0, 0}, {0, 0, -1}, 90);
  c.scene.lights = {{.position = {-2, 4, 0}}};
  const uint32_t white = addMaterial(c.scene, matte(dvec3(1)));
  addFloor(c.scene, 0, 50, white);
  addQuad(c.scene, {-20, 2, 20}, {20 - 0.95, 0, 0}, {0, 0, -40}, white);
  for (int j = 0; j < 32; ++j)
    for (int i = 0; i < 32; ++i) {
      const dvec3 x((2 * i - 31) / 32.0, 0, (2 * j - 31) / 32.0);
      c.expected.push_back({i, j, dvec3(i < 18 ? 0 : cosineAt(x, {0, 1, 0}, {-2, 4, 0}))});
    }
  return c;
}

// Two parallel mirrors with r = 0.8 and a ray perpendicular to both. Each hit sends w_local * E * k_d = 0.2 * 5 = 1,
// and `depth` levels of the ray tree sum up to 1 + 0.8 + 0.8^2 + ... = (1 - 0.8^depth) / 0.2.
inline Case mirrorCorridor(int depth, double sum) {
  Case c{"MirrorCorridorOfDepth" + std::to_string(depth), {}, pixels(1, 1, depth), {}};
  c.scene.camera = lookAt({0, 0, 0.25}, {0, 0, 1}, {0, 1, 0}, 45);
  c.scene.lights = {{.position = {0, 0, -0.5}, .color = {5, 5, 5}}};
  Material wall = mirror(0.8);
  wall.diffuse = dvec3(1);
  const uint32_t material = addMaterial(c.scene, wall);
  addQuad(c.scene, {-3, -5, -1}, {7, 0, 0}, {0, 9, 0}, material);  // front toward +z
  addQuad(c.scene, {-3, -5, 1}, {0, 9, 0}, {7, 0, 0}, material);   // front toward -z
  c.expected.push_back({0, 0, dvec3(sum), 1e-6 * sum});
  return c;
}

// Through a slab of glass 1 thick. Behind it, a floor whose brightness N.L under a low light tells where the ray lands.
// The ray leaves in its old direction, shifted; at 60 degrees by 0.5124720.
inline Case glassSlab() {
  constexpr double shiftAt60 = 0.5124720;
  Case c{"GlassSlab", {}, pixels(5, 5), {}};
  const double eyeHeight = 1, floorHeight = -3;  // the slab is from 0 down to -1
  const dvec3 eye(0, eyeHeight, 0);
  const dvec3 forward(std::sin(60 * kDegree), -std::cos(60 * kDegree), 0), right(0, 0, 1);
  const dvec3 up = glm::cross(right, forward);
  c.scene.camera = lookAt(eye, eye + forward, {0, 1, 0}, 30);
  const dvec3 light(5, -2, 0.5);
  c.scene.lights = {{.position = light}};
  const uint32_t clear = addMaterial(c.scene, glass(0, 1, 1.5));
  addFloor(c.scene, 0, 60, clear);
  addQuad(c.scene, {-60, -1, -60}, {120, 0, 0}, {0, 0, 120}, clear);  // front down
  addFloor(c.scene, floorHeight, 60, addMaterial(c.scene, matte(dvec3(1))));
  for (int j = 0; j < 5; ++j)
    for (int i = 0; i < 5; ++i) {
      const double scale = std::tan(15 * kDegree) / 5;
      const dvec3 d = glm::normalize(forward + scale * (2 * i - 4) * right + scale * (4 - 2 * j) * up);
      const double cosine = -d.y, sine = std::sqrt(d.x * d.x + d.z * d.z), tangent = sine / cosine;
      const double inside = sine / 1.5, tangentInside = inside / std::sqrt(1 - inside * inside);
      // How far the slab takes the landing point back along the floor.
      const bool centre = i == 2 && j == 2;
      const double back = centre ? shiftAt60 / std::cos(60 * kDegree) : tangent - tangentInside;
      const double reach = tangent * (eyeHeight - floorHeight) - back;
      const dvec3 x(d.x / sine * reach, floorHeight, d.z / sine * reach);
      c.expected.push_back({i, j, dvec3(cosineAt(x, {0, 1, 0}, light))});
    }
  return c;
}

// From inside glass under the surface y = 0: above the critical angle of 41.81 degrees all of r + t = 0.9 is reflected
// and sees the floor; below it, r = 0.2 of the floor and t = 0.7 of the background are seen.
inline Case totalReflection() {
  Case c{"TotalInternalReflection", {}, pixels(1, 9), {}};
  const dvec3 eye(0, -1, 0), light(2, -2, 0);
  c.scene.background = {0.25, 0.5, 1};
  c.scene.camera = lookAt(eye, eye + dvec3(1, 1, 0), {0, 1, 0}, 60);
  c.scene.lights = {{.position = light}};
  addFloor(c.scene, 0, 90, addMaterial(c.scene, glass(0.2, 0.7, 1.5)));
  addFloor(c.scene, -3, 90, addMaterial(c.scene, matte(dvec3(1))));
  for (int j = 0; j < 9; ++j) {
    // Between the ray and the surface's normal; the picture's upper half looks more steeply.
    const double angle = 45 * kDegree - std::atan(std::tan(30 * kDegree) * (8 - 2 * j) / 9);
    const dvec3 floor(cosineAt({std::tan(angle) * (1 + 3), -3, 0}, {0, 1, 0}, light));
    const bool total = 1.5 * std::sin(angle) >= 1;
    c.expected.push_back({0, j, total ? 0.9 * floor : 0.2 * floor + 0.7 * c.scene.background});
  }
  return c;
}

// One ray toward -z passes a unit sphere's centre at distance b and leaves it turned toward the axis by `deviation`
// degrees, again at distance b from the centre. A wall at z = -4 shows by its brightness N.L where the ray lands.
inline Case bentBySphere(std::string name, double radius, double b, double deviation, double tolerance) {
  Case c{std::move(name), {}, pixels(1, 1), {}};
  c.scene.camera = lookAt({b, 0, 5}, {b, 0, 0}, {0, 1, 0}, 45);
  c.scene.spheres.push_back({{0, 0, 0}, radius, addMaterial(c.scene, glass(0, 1, 1.5))});
  addQuad(c.scene, {-50, -51, -4}, {100, 0, 0}, {0, 101, 0}, addMaterial(c.scene, matte(dvec3(1))));
  const double sine = std::sin(deviation * kDegree), cosine = std::cos(deviation * kDegree);
  // The ray is { b m + s d } with d = (-sine, 0, -cosine) and m = (cosine, 0, -sine).
  const double s = (4 - b * sine) / cosine;
  const dvec3 x(b * cosine - s * sine, 0, -4);
  const dvec3 light = x + dvec3(0.7, 0, 1);
  c.scene.lights = {{.position = light}};
  c.expected.push_back({0, 0, dvec3(1 / std::sqrt(1 + 0.7 * 0.7)), tolerance});
  return c;
}

// pcg4d of Jarzynski and Olano (JCGT 9(3), 2020).
inline std::array<uint32_t, 4> pcg4d(std::array<uint32_t, 4> v) {
  const auto multiplyAdd = [&] {
    v[0] += v[1] * v[3];
    v[1] += v[2] * v[0];
    v[2] += v[0] * v[1];
    v[3] += v[1] * v[2];
  };
  for (uint32_t& word : v) word = word * 1664525u + 1013904223u;
  multiplyAdd();
  for (uint32_t& word : v) word ^= word >> 16;
  multiplyAdd();
  return v;
}

// Where the samples of a pixel lie within it, in the order of the cells, in [0, 1): computed here once more, as
// docs/light_transport.md says it, with the digits in a list.
inline std::vector<glm::dvec2> hashedPositions(Sampler sampler, uint32_t n, uint32_t x, uint32_t y, uint32_t seed) {
  std::vector<uint32_t> radices;
  for (uint32_t rest = n, prime = 2; rest > 1; ++prime)
    for (; rest % prime == 0; rest /= prime) radices.push_back(prime);
  const auto strip = [&](uint32_t number, uint32_t key) {
    uint32_t node = 1, value = 0;
    for (const uint32_t radix : radices) {
      uint32_t h = key + node * 0x9e3779b9u;
      h = (h ^ h >> 16) * 0x7feb352du;
      h = (h ^ h >> 15) * 0x846ca68bu;
      h ^= h >> 16;
      const uint32_t digit = number % radix;
      const uint32_t shuffled = (digit * (1 + ((h & 0xffff) * (radix - 1) >> 16)) + ((h >> 16) * radix >> 16)) % radix;
      value = value * radix + shuffled;
      number /= radix;
      node = node * radix + digit;
    }
    return value;
  };
  const auto keys = pcg4d({x, y, 1u << 16, seed});
  std::vector<glm::dvec2> positions;
  for (uint32_t cell = 0; cell < n * n; ++cell) {
    const auto random = pcg4d({x, y, cell, seed});
    const uint32_t i = cell % n, j = cell / n;
    glm::dvec2 inCell((random[0] >> 8) / 16777216.0, (random[1] >> 8) / 16777216.0);
    if (sampler == Sampler::sobol) inCell = (inCell + glm::dvec2(strip(j, keys[0]), strip(i, keys[1]))) / double(n);
    positions.push_back((glm::dvec2(i, j) + inCell) / double(n));
  }
  return positions;
}

// Hashed samples: each pixel is the mean of N.L at the points where its samples land.
inline Case hashedSamples(const std::string& name, Sampler sampler, uint32_t n) {
  Case c{name, {}, pixels(7, 5), {}};
  constexpr uint32_t seed = 0xdecade;
  c.settings.samples = int(n);
  c.settings.sampler = sampler;
  c.settings.seed = seed;
  c.scene.camera = lookAt({0, 5, 0}, {0, 0, 0}, {0, 0, -1}, 90);
  const dvec3 light(1, 1, 2);
  c.scene.lights = {{.position = light}};
  addFloor(c.scene, 0, 50, addMaterial(c.scene, matte(dvec3(1))));
  for (uint32_t y = 0; y < 5; ++y)
    for (uint32_t x = 0; x < 7; ++x) {
      double sum = 0;
      for (const glm::dvec2& at : hashedPositions(sampler, n, x, y, seed))
        sum += cosineAt({2 * (x + at.x) - 7, 0, 2 * (y + at.y) - 5}, {0, 1, 0}, light);
      c.expected.push_back({int(x), int(y), dvec3(sum / (n * n))});
    }
  return c;
}

// A black triangle over a part of the only pixel, before a white background: the pixel is the share of samples that
// miss it, exactly. `edge` is a half-plane a x + b y < c in pixel coordinates, `covered` the number of its samples.
inline Case coverage(std::string name, Sampler sampler, int n, double a, double b, double c, int covered) {
  Case result{std::move(name), {}, pixels(1, 1), {}};
  result.settings.samples = n;
  result.settings.sampler = sampler;
  result.settings.seed = 3;
  result.scene.background = dvec3(1);
  result.scene.camera = lookAt({0, 0, 1}, {0, 0, 0}, {0, 1, 0}, 90);
  // The pixel reaches from (-1, 1) to (1, -1) in the plane z = 0. Its triangle: a point of the edge line, far along the
  // line both ways, and far into the half-plane.
  const double square = a * a + b * b;
  const auto toPlane = [](double x, double y) { return dvec3(2 * x - 1, 1 - 2 * y, 0); };
  const double x = c * a / square, y = c * b / square;
  result.scene.addTriangle(
      {toPlane(x - 8 * b, y + 8 * a), toPlane(x + 8 * b, y - 8 * a), toPlane(x - 8 * a, y - 8 * b)},
      addMaterial(result.scene, matte(dvec3(0))));
  result.expected.push_back({0, 0, dvec3(1 - double(covered) / (n * n)), 0});
  return result;
}

// A perfect mirror before the background: a ray beyond the depth is black.
inline Case depthCut(int depth, const dvec3& color) {
  Case c{"DepthCutAt" + std::to_string(depth), {}, pixels(3, 3, depth), {}};
  c.scene.background = {0.25, 0.5, 1};
  c.scene.camera = lookAt({0, 0, 2}, {0, 0, 0}, {0, 1, 0}, 45);
  c.scene.spheres.push_back({{0, 0, 0}, 1.5, addMaterial(c.scene, mirror(1))});
  for (int y = 0; y < 3; ++y)
    for (int x = 0; x < 3; ++x) c.expected.push_back({x, y, color, 0});
  return c;
}

inline Case background() {
  Case c{"BackgroundOnMiss", {}, pixels(2, 2), {}};
  c.scene.background = {0.25, 0.5, 1};
  for (int y = 0; y < 2; ++y)
    for (int x = 0; x < 2; ++x) c.expected.push_back({x, y, c.scene.background, 0});
  return c;
}

// Copies of one triangle: the lowest id is seen, and its copies do not shadow it.
inline Case equalTriangles() {
  Case c{"LowestIdOfEqualTriangles", {}, pixels(3, 3), {}};
  c.scene.camera = lookAt({0, 0, 3}, {0, 0, 0}, {0, 1, 0}, 45);
  c.scene.lights = {{.position = {0, 0, 3}, .color = {1, 1, 1}}};
  const std::array<dvec3, 3> vertices{dvec3(-9.3, -7.1, 0.3), dvec3(8.7, -6.9, 0.3), dvec3(0.1, 9.9, 0.3)};
  const std::array<dvec3, 4> colors{dvec3(0.5, 0.25, 1), dvec3(1, 0, 0), dvec3(0, 1, 0), dvec3(0, 0, 1)};
  for (const dvec3& color : colors) c.scene.addTriangle(vertices, addMaterial(c.scene, matte(color)));
  // The middle pixel alone, where N.L = 1.
  c.expected.push_back({1, 1, colors[0]});
  return c;
}

// Copies of one sphere, the first one black.
inline Case equalSpheres() {
  Case c{"LowestIdOfEqualSpheres", {}, pixels(5, 5), {}};
  c.scene.background = dvec3(0);
  c.scene.camera = lookAt({0.3, 0.2, 4}, {0, 0, 0}, {0, 1, 0}, 45);
  c.scene.lights = {{.position = {0.3, 0.2, 4}}};
  for (double color : {0.0, 1.0, 1.0})
    c.scene.spheres.push_back({{0, 0, 0}, 1, addMaterial(c.scene, matte(dvec3(color)))});
  for (int y = 0; y < 5; ++y)
    for (int x = 0; x < 5; ++x) c.expected.push_back({x, y, dvec3(0), 0});
  return c;
}

// A triangle seen from behind is lit by what is on the viewer's side, and by nothing else.
inline Case backHit(bool lightBesideViewer) {
  Case c{lightBesideViewer ? "BackHitIsLitFromItsSide" : "BackHitIsDarkFromTheOtherSide", {}, pixels(1, 1), {}};
  c.scene.camera = lookAt({0, 0, 3}, {0, 0, 0}, {0, 1, 0}, 45);
  c.scene.lights = {{.position = {3, 0, lightBesideViewer ? 4.0 : -4.0}}};
  c.scene.addTriangle({dvec3(-9, -7, 0), dvec3(0, 9, 0), dvec3(8, -7, 0)}, addMaterial(c.scene, matte({1, 0.5, 0.25})));
  c.expected.push_back({0, 0, lightBesideViewer ? 0.8 * dvec3(1, 0.5, 0.25) : dvec3(0)});
  return c;
}

// One smooth triangle in the plane z = 0, its three vertex normals all the same, tilted toward x by this angle.
inline Scene tiltedNormals(double degrees, const Material& material) {
  Scene scene;
  const dvec3 normal(std::sin(degrees * kDegree), 0, std::cos(degrees * kDegree));
  scene.addTriangle({dvec3(-9, -7, 0), dvec3(8, -7, 0), dvec3(0, 9, 0)}, {normal, normal, normal},
                    addMaterial(scene, material));
  return scene;
}

// Ns shades: with Ns 30 degrees from the axis and L 60 degrees from it on the same side, Ns.L = cos 30.
inline Case smoothShading() {
  Case c{"SmoothNormalShades", tiltedNormals(30, matte(dvec3(1))), pixels(1, 1), {}};
  c.scene.camera = lookAt({0, 0, 3}, {0, 0, 0}, {0, 1, 0}, 45);
  c.scene.lights = {{.position = {2 * std::sin(60 * kDegree), 0, 2 * std::cos(60 * kDegree)}},
                    // Behind the triangle, though Ns looks at it: Ng.L <= 0 blocks it.
                    {.position = {2 * std::sin(100 * kDegree), 0, 2 * std::cos(100 * kDegree)}}};
  c.expected.push_back({0, 0, dvec3(std::cos(30 * kDegree))});
  return c;
}

// Ns 20 degrees from the axis turns the mirrored ray by 40 degrees; it lands on a wall at x = 2 whose brightness says
// where. At 50 degrees the mirrored ray would go into the triangle, so that it is mirrored about Ng: straight back,
// past the eye, to the background.
inline Case smoothMirror(double degrees) {
  Case c{degrees < 45 ? "SmoothNormalReflects" : "ReflectionIntoTheSurfaceIsAboutItsPlane",
         tiltedNormals(degrees, mirror(1)),
         pixels(1, 1),
         {}};
  c.scene.background = {0.25, 0.5, 1};
  c.scene.camera = lookAt({0, 0, 3}, {0, 0, 0}, {0, 1, 0}, 45);
  const dvec3 light(1, 0, 3);
  c.scene.lights = {{.position = light}};
  addQuad(c.scene, {2, -20, -19}, {0, 0, 40}, {0, 41, 0}, addMaterial(c.scene, matte(dvec3(1))));
  const dvec3 x(2, 0, 2 / std::tan(2 * degrees * kDegree));
  const dvec3 color = degrees < 45 ? dvec3(cosineAt(x, {-1, 0, 0}, light)) : c.scene.background;
  c.expected.push_back({0, 0, color});
  return c;
}

// Vertex normals that look away from the viewer, 60 degrees to one side while he is 50 degrees to the other, do not
// shade: the triangle's plane does.
inline Case smoothNormalFacingAway() {
  Case c{"SmoothNormalFacingAwayIsNotUsed", tiltedNormals(-60, matte(dvec3(1))), pixels(1, 1), {}};
  c.scene.camera = lookAt({3 * std::sin(50 * kDegree), 0, 3 * std::cos(50 * kDegree)}, {0, 0, 0}, {0, 1, 0}, 45);
  c.scene.lights = {{.position = {3, 0, 4}}};
  c.expected.push_back({0, 0, dvec3(0.8)});
  return c;
}

// Vertex normals decide which side is the front, not the winding: a ray at 45 degrees enters the glass, and the wall
// 1 behind its surface shows by its brightness where it lands.
inline Case smoothNormalsAgainstWinding() {
  Case c{"SmoothNormalsDecideTheFront", tiltedNormals(0, glass(0, 1, 1.5)), pixels(1, 1), {}};
  std::swap(c.scene.triangles[0].positions[1], c.scene.triangles[0].positions[2]);
  c.scene.camera = lookAt({-2, 0, 2}, {0, 0, 0}, {0, 1, 0}, 45);
  const dvec3 light(1, 0, -0.5);
  c.scene.lights = {{.position = light}};
  addQuad(c.scene, {-20, -21, -1}, {40, 0, 0}, {0, 42, 0}, addMaterial(c.scene, matte(dvec3(1))));
  const dvec3 x(std::tan(std::asin(std::sin(45 * kDegree) / 1.5)), 0, -1);
  c.expected.push_back({0, 0, dvec3(cosineAt(x, {0, 0, 1}, light))});
  return c;
}

inline std::vector<Case> allCases() {
  // Deviations of a ray by a sphere: 2 (i - asin(sin(i) / 1.5)) with sin(i) = b. A sphere of negative radius is left
  // where it is entered, as a bubble in glass is: 2 (i - asin(1.5 sin(i))), away from the axis.
  const double bubble = 2 * (30 - std::asin(0.75) / kDegree);
  return {
      diffuse(),
      inverseSquare(),
      blinnPhong("BlinnPhong", 3.0827),
      blinnPhong("BlinnPhongWithoutShininess", 0),
      blinnPhong("BlinnPhongSharp", 101.148),
      shadowEdge(),
      mirrorCorridor(2, 1.8),
      mirrorCorridor(5, 3.3616),
      mirrorCorridor(9, 4.32891136),
      glassSlab(),
      totalReflection(),
      bentBySphere("GlassSphereNearItsAxis", 1, 0.1, 3.83323, kFloatError),
      bentBySphere("GlassSphere", 1, 0.5, 21.05756, kFloatError),
      bentBySphere("GlassSphereNearItsRim", 1, 0.9, 54.57634, 2e-5),
      bentBySphere("SphereOfNegativeRadius", -1, 0.5, bubble, 4e-6),
      hashedSamples("JitteredSamples", Sampler::jitter, 3),
      hashedSamples("SobolSamplesOfOnePrime", Sampler::sobol, 3),
      hashedSamples("SobolSamplesOfAPowerOfTwo", Sampler::sobol, 8),
      hashedSamples("SobolSamplesOfManyPrimes", Sampler::sobol, 30),
      coverage("CoverageByAVerticalEdge", Sampler::grid, 8, 1, 0, 0.3, 16),
      coverage("CoverageByASlantedEdge", Sampler::grid, 8, 1, 1, 0.9, 28),
      coverage("CoverageByAnEdgeBetweenCells", Sampler::jitter, 8, 1, 0, 0.5, 32),
      depthCut(1, {0, 0, 0}),
      depthCut(2, {0.25, 0.5, 1}),
      background(),
      equalTriangles(),
      equalSpheres(),
      backHit(true),
      backHit(false),
      smoothShading(),
      smoothMirror(20),
      smoothMirror(50),
      smoothNormalFacingAway(),
      smoothNormalsAgainstWinding(),
  };
}

}  // namespace turner::closed_form
