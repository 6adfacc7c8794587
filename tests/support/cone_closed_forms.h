// Scenes of cones and cylinders whose pixels are known from a formula on paper.
#pragma once

#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "support/closed_form.h"

namespace turner::closed_form {

// Around the y axis, from -9 to 9.
inline Cone upright(double radius, uint32_t material) {
  return {{0, -9, 0}, radius, {0, 9, 0}, radius, material};
}

// Directions of the pixels of a square picture from an eye on the z axis, looking along -z.
inline dvec3 pixelAlongZ(int i, int j, int size, double tangent) {
  return {tangent * (2 * i + 1 - size) / size, tangent * (size - 2 * j - 1) / size, -1};
}

// A matte cylinder of radius 1 seen from 5 away, lit by a light in the plane of the eye across its axis.
inline Case matteCylinder(const std::string& name, double radius) {
  constexpr int kSize = 6;
  constexpr double kTangent = 0.18;  // no pixel passes it
  Case c{name, {}, pixels(kSize, kSize), {}};
  c.scene.camera = lookAt({0, 0, 5}, {0, 0, 0}, {0, 1, 0}, 2 / kDegree * std::atan(kTangent));
  const dvec3 light(3, 0, 4);
  c.scene.lights = {{.position = light}};
  c.scene.cones = {upright(radius, addMaterial(c.scene, matte({1, 0.5, 0.25})))};
  for (int j = 0; j < kSize; ++j)
    for (int i = 0; i < kSize; ++i) {
      const dvec3 d = pixelAlongZ(i, j, kSize, kTangent);
      // (x t)^2 + (5 - t)^2 = 1
      const double a = d.x * d.x + 1, t = (5 - std::sqrt(25 - a * 24)) / a;
      const dvec3 x = dvec3(0, 0, 5) + t * d, N(x.x, 0, x.z);
      c.expected.push_back({i, j, cosineAt(x, N, light) * dvec3(1, 0.5, 0.25)});
    }
  return c;
}

// The inside of a cylinder of radius 2 around the eye, with a light on its axis 1 above: N.L = r / sqrt(r^2 + (y -
// 1)^2).
inline Case insideACylinder(const std::string& name, double radius) {
  constexpr int kSize = 5;
  Case c{name, {}, pixels(kSize, kSize), {}};
  c.scene.camera = lookAt({0, 0, 0}, {0, 0, -1}, {0, 1, 0}, 90);
  c.scene.lights = {{.position = {0, 1, 0}}};
  c.scene.cones = {upright(radius, addMaterial(c.scene, matte({1, 0.5, 0.25})))};
  const double r = std::abs(radius);
  for (int j = 0; j < kSize; ++j)
    for (int i = 0; i < kSize; ++i) {
      const dvec3 d = pixelAlongZ(i, j, kSize, 1);
      const double y = r / std::hypot(d.x, d.z) * d.y;
      c.expected.push_back({i, j, r / std::hypot(r, y - 1) * dvec3(1, 0.5, 0.25)});
    }
  return c;
}

// A cone with its tip at 2 over a circle of this radius, seen along its axis from 10, where the light is too. Its
// normal rises by the angle alpha between axis and side: N = (cos(alpha) x / rho, sin(alpha)).
inline Case alongTheAxisOfACone(const std::string& name, double radius, bool tipIsBase) {
  constexpr int kSize = 6;  // even: no pixel at the tip
  const double tangent = 0.6 * radius / 10;
  Case c{name, {}, pixels(kSize, kSize), {}};
  const dvec3 eye(0, 10, 0);
  c.scene.camera = lookAt(eye, {0, 0, 0}, {0, 0, -1}, 2 / kDegree * std::atan(tangent));
  c.scene.lights = {{.position = eye}};
  const uint32_t material = addMaterial(c.scene, matte(dvec3(1)));
  const dvec3 tip(0, 2, 0), foot(0, 0, 0);
  c.scene.cones = {tipIsBase ? Cone{tip, 0, foot, radius, material} : Cone{foot, radius, tip, 0, material}};
  const double sine = radius / std::hypot(radius, 2), cosine = 2 / std::hypot(radius, 2);
  for (int j = 0; j < kSize; ++j)
    for (int i = 0; i < kSize; ++i) {
      const dvec3 d = pixelAlongZ(i, j, kSize, tangent);
      const double slope = std::hypot(d.x, d.y);
      // rho = slope (10 - y) and y = 2 - 2 rho / radius
      const double rho = 8 * slope / (1 - 2 * slope / radius), y = 2 - 2 * rho / radius;
      const double length = std::hypot(rho, 10 - y);
      c.expected.push_back({i, j, dvec3((sine * (10 - y) - cosine * rho) / length)});
    }
  return c;
}

// A mirror of radius 1 turns a ray that passes its axis at 0.6 along -z into the direction (0.96, 0, 0.28). A wall at
// x = 4 shows by its brightness where it lands.
inline Case mirrorCylinder() {
  Case c{"MirrorCylinder", {}, pixels(1, 1), {}};
  c.scene.camera = lookAt({0.6, 0, 5}, {0.6, 0, 0}, {0, 1, 0}, 45);
  c.scene.cones = {upright(1, addMaterial(c.scene, mirror(1)))};
  addQuad(c.scene, {4, -20, -21}, {0, 0, 40}, {0, 41, 0}, addMaterial(c.scene, matte(dvec3(1))));
  const dvec3 x(4, 0, 0.8 + 0.28 * 3.4 / 0.96), light(3, 0, 4);
  c.scene.lights = {{.position = light}};
  c.expected.push_back({0, 0, dvec3(cosineAt(x, {-1, 0, 0}, light))});
  return c;
}

// A cone at 45 degrees is a mirror that turns rays across its axis, in a plane with it, along the axis: up to a
// ceiling.
inline Case mirrorCone() {
  Case c{"MirrorConeTurnsRaysAlongItsAxis", {}, pixels(1, 1), {}};
  c.scene.camera = lookAt({0, 0, 5}, {0, 0, 0}, {0, 1, 0}, 45);
  c.scene.cones = {{{0, -2, 0}, 3, {0, 1, 0}, 0, addMaterial(c.scene, mirror(1))}};  // radius 1 at y = 0
  addQuad(c.scene, {-20, 6, -21}, {40, 0, 0}, {0, 0, 41}, addMaterial(c.scene, matte(dvec3(1))));
  const dvec3 light(1, 4, 2);
  c.scene.lights = {{.position = light}};
  c.expected.push_back({0, 0, dvec3(cosineAt({0, 6, 1}, {0, -1, 0}, light))});
  return c;
}

// Inside a mirror of r = 0.8, through its axis, where the light is: as between two parallel walls.
inline Case mirrorPipe(int depth, double sum) {
  Case c{"MirrorPipeOfDepth" + std::to_string(depth), {}, pixels(1, 1, depth), {}};
  c.scene.camera = lookAt({0, 0, 0.25}, {0, 0, 1}, {0, 1, 0}, 45);
  c.scene.lights = {{.position = {0, 0, 0}, .color = {5, 5, 5}}};
  Material wall = mirror(0.8);
  wall.diffuse = dvec3(1);
  c.scene.cones = {upright(1, addMaterial(c.scene, wall))};
  c.expected.push_back({0, 0, dvec3(sum), 1e-6 * sum});
  return c;
}

// In the plane across its axis a cylinder is a sphere: see bentBySphere.
inline Case bentByCylinder(std::string name, double radius, double b, double deviation, double tolerance) {
  Case c = bentBySphere(std::move(name), radius, b, deviation, tolerance);
  c.scene.cones = {upright(radius, c.scene.spheres[0].material)};
  c.scene.spheres.clear();
  return c;
}

// Copies of one cylinder, also from its other end, the first one black.
inline Case equalCylinders() {
  Case c{"LowestIdOfEqualCylinders", {}, pixels(5, 5), {}};
  c.scene.camera = lookAt({0.3, 0.2, 4}, {0, 0, 0}, {0, 1, 0}, 30);
  c.scene.lights = {{.position = {0.3, 0.2, 4}}};
  for (double color : {0.0, 1.0}) c.scene.cones.push_back(upright(1.2, addMaterial(c.scene, matte(dvec3(color)))));
  for (int y = 0; y < 5; ++y)
    for (int x = 0; x < 5; ++x) c.expected.push_back({x, y, dvec3(0), 0});
  return c;
}

inline std::vector<Case> coneCases() {
  const double bubble = 2 * (30 - std::asin(0.75) / kDegree);
  return {
      matteCylinder("MatteCylinder", 1),
      matteCylinder("CylinderThatFacesItsAxis", -1),
      insideACylinder("InsideACylinder", 2),
      insideACylinder("InsideACylinderThatFacesItsAxis", -2),
      alongTheAxisOfACone("ConeAlongItsAxis", 2, false),
      alongTheAxisOfACone("ConeAlongItsAxisFromItsTip", 2, true),
      alongTheAxisOfACone("FlatConeAlongItsAxis", 2000, false),
      alongTheAxisOfACone("SharpConeAlongItsAxis", 0.02, false),
      mirrorCylinder(),
      mirrorCone(),
      mirrorPipe(2, 1.8),
      mirrorPipe(9, 4.32891136),
      bentByCylinder("GlassCylinder", 1, 0.5, 21.05756, kFloatError),
      bentByCylinder("GlassCylinderNearItsRim", 1, 0.9, 54.57634, 2e-5),
      bentByCylinder("GlassCylinderThatFacesItsAxis", -1, 0.5, bubble, 4e-6),
      equalCylinders(),
  };
}

}  // namespace turner::closed_form
