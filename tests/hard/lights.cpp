// Shadows: what is lit is lit and what is not is not, at terminators, in contacts, and wherever the light stands.
#include <fmt/format.h>

#include <array>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "hard/brute_force.h"
#include "hard/cases.h"
#include "hard/icosphere.h"
#include "hard/vectors.h"
#include "reference/reference.h"

namespace turner::hard {
namespace {

// --- samples: rays whose hits look for a light ---

struct Sample {
  Found found;
  bool lit;
};

// Each query's hit, and whether the light at its target reaches it: as addLight in whitted.comp asks.
std::vector<Sample> lightUp(Kernels& kernels, std::vector<Query> queries, Tracer tracer = Tracer::turner) {
  for (Query& query : queries) query.next = Next::light;
  std::vector<Sample> samples;
  std::vector<Query> shadows;
  for (const Found& found : kernels.trace(queries, tracer)) {
    samples.push_back({found, found.hits() && found.leaves});
    if (samples.back().lit) shadows.push_back({.ray = found.leaving, .end = float(1 - 0x1p-20)});
  }
  const std::vector<Found> blockers = kernels.trace(shadows, tracer);
  size_t next = 0;
  for (Sample& sample : samples)
    if (sample.lit) sample.lit = !blockers[next++].hits();
  return samples;
}

Query queryOf(const dvec3& origin, const dvec3& direction, const dvec3& light) {
  return {.ray = {.origin = vec3(origin), .direction = vec3(glm::normalize(direction))}, .target = vec3(light)};
}

double logUniform(Random& random, double lo, double hi) {
  return std::pow(10.0, uniform(random, lo, hi));
}

// A unit vector at this cosine to a normal.
dvec3 atCosine(const dvec3& normal, double cosine, Random& random) {
  dvec3 a, b;
  basisOf(normal, a, b);
  const double phi = uniform(random, 0, 2 * std::numbers::pi);
  return cosine * normal + std::sqrt(1 - cosine * cosine) * (std::cos(phi) * a + std::sin(phi) * b);
}

struct WrongSamples {
  size_t asked = 0, turner = 0, naive = 0;
  double value() const { return asked > 0 ? double(turner) : NAN; }
};

// --- 24: convex bodies shadow no point that faces the light ---

// A point of the surface with its normal. It is looked at from outside, from any angle.
struct SurfacePoint {
  dvec3 point, normal;
};

// The point of the body, of spheres or triangles, where a ray arrived. Of a triangle the point is any.
SurfacePoint trueSurface(const Scene& local, const Found& found) {
  if (found.id < local.spheres.size()) {
    const Sphere& sphere = local.spheres[found.id];
    const dvec3 normal = glm::normalize(dvec3(found.point) - sphere.center);
    return {sphere.center + sphere.radius * normal, normal};
  }
  const auto& [a, b, c] = local.cornersOf(found.id - local.spheres.size() - local.cones.size());
  return {a, glm::normalize(glm::cross(b - a, c - a))};
}

// On the sphere anywhere; on a triangle inside, on an edge or at a vertex.
SurfacePoint randomSurface(const Scene& local, Random& random) {
  if (!local.spheres.empty()) {
    const dvec3 normal = randomDirection(random);
    return {local.spheres[0].center + local.spheres[0].radius * normal, normal};
  }
  const auto& v = local.cornersOf(random() % local.triangles.size());
  const dvec3 normal = glm::normalize(glm::cross(v[1] - v[0], v[2] - v[0]));
  const int kind = int(random() % 3);
  const double s = kind == 0 ? 0 : uniform(random, 0, 1), u = kind == 1 ? 0 : uniform(random, 0, 1 - s);
  return {v[0] + s * (v[1] - v[0]) + (kind == 0 ? 0 : u) * (v[2] - v[0]), normal};
}

// Light at this distance, mostly near the plane of the surface.
Query terminatorQuery(const Scene& local, double lightDistance, Random& random) {
  const SurfacePoint surface = randomSurface(local, random);
  const double cosine = (random() % 2 ? 1 : -1) * logUniform(random, -5, 0);
  const dvec3 light = surface.point + lightDistance * atCosine(surface.normal, cosine, random);
  const dvec3 toEye = atCosine(surface.normal, logUniform(random, -4, 0), random);
  return queryOf(surface.point + uniform(random, 0.01, 3) * toEye, -toEye, light);
}

// Of one tracer. Back hits: of rays that the body's inside saw, by the tracer, though they come from outside.
struct TerminatorCount {
  size_t asked = 0, wrong = 0, backHits = 0;

  void add(const Scene& local, const std::vector<Query>& queries, const std::vector<Sample>& samples) {
    for (size_t i = 0; i < samples.size(); ++i) {
      const Found& found = samples[i].found;
      if (!found.hits()) continue;  // a grazing ray may pass by
      const dvec3 origin(queries[i].ray.origin);
      const bool fromOutside =
          local.spheres.empty() || glm::length(origin - local.spheres[0].center) > local.spheres[0].radius;
      backHits += !found.front && fromOutside;
      if (!found.front) continue;
      const SurfacePoint surface = trueSurface(local, found);
      const dvec3 light(queries[i].target);
      const double cosine = glm::dot(surface.normal, light - surface.point) / glm::length(light - dvec3(found.point));
      if (std::abs(cosine) <= 1e-5) continue;
      ++asked;
      wrong += samples[i].lit != (cosine > 0);
    }
  }
};

void convexAcne(const Bench& bench, Report& report) {
  Random random = bench.random(24);
  const dvec3 centre(0.3, -0.2, 3);
  Scene sphere = icosphere(0, 1, centre), mesh = icosphere(4, 1, centre);
  sphere.triangles.clear();
  sphere.spheres = {{.center = centre}};
  for (Scene* scene : {&sphere, &mesh}) {
    scene->camera = {.eye = {0, 0, 0}, .target = {0, 0, 1}};
    bench.kernels.setScene(*scene);
    const Scene& local = bench.kernels.local();
    TerminatorCount all, allNaive;
    for (const double lightDistance : {2.0, 1e3, 1e6}) {
      TerminatorCount turner, naive;
      Bench::inBatches(bench.effort.rays(1e7, 2e5) / 6, [&](size_t count) {
        std::vector<Query> queries;
        for (size_t i = 0; i < count; ++i) queries.push_back(terminatorQuery(local, lightDistance, random));
        turner.add(local, queries, lightUp(bench.kernels, queries));
        naive.add(local, queries, lightUp(bench.kernels, queries, Tracer::naive));
      });
      report.atMost(fmt::format("{}, light at {:g}: wrong of {:.2g} samples", scene == &sphere ? "sphere" : "icosphere",
                                lightDistance, double(turner.asked)),
                    turner.asked > 0 ? double(turner.wrong) : NAN, 0, double(naive.wrong),
                    scene == &sphere ? ""
                                     : fmt::format("without {} hits on the back at silhouettes, where the distances of "
                                                   "two triangles are equal and the lowest id wins",
                                                   turner.backHits));
      all.backHits += turner.backHits;
      allNaive.backHits += naive.backHits;
    }
    if (scene == &sphere)
      report.atMost("sphere: grazing rays from outside that hit its inside", double(all.backHits), 0,
                    double(allNaive.backHits));
  }
}

// --- scenes of the other cases: a matt white, in a picture that is black where no light arrives ---

Material matt(double diffuse = 1) {
  return {.diffuse = dvec3(diffuse)};
}

void addQuad(Scene& scene, const dvec3& corner, const dvec3& a, const dvec3& b, uint32_t material = 0) {
  scene.addTriangle({corner, corner + a, corner + a + b}, material);
  scene.addTriangle({corner, corner + a + b, corner + b}, material);
}

void addFloor(Scene& scene, double half) {
  addQuad(scene, {-half, 0, half}, {2 * half, 0, 0}, {0, 0, -2 * half});
}

void addBox(Scene& scene, const dvec3& lo, const dvec3& hi, uint32_t material = 0) {
  const dvec3 size = hi - lo, x(size.x, 0, 0), y(0, size.y, 0), z(0, 0, size.z);
  addQuad(scene, lo, x, z, material);
  addQuad(scene, lo, z, y, material);
  addQuad(scene, lo, y, x, material);
  addQuad(scene, hi, -z, -x, material);
  addQuad(scene, hi, -y, -z, material);
  addQuad(scene, hi, -x, -y, material);
}

Scene mattScene(const dvec3& eye, const dvec3& target) {
  Scene scene;
  scene.materials = {matt()};
  scene.camera = {.eye = eye, .target = target, .fov = 40};
  return scene;
}

Image render(const Scene& scene, int size) {
  return test::renderShader(scene, test::settingsOf(scene, size, size));
}

float redAt(const Image& image, int x, int y) {
  return image.rgb[3 * size_t(y * image.width + x)];
}

// --- 25: contact ---

// A body on a floor: the floor is the first two triangles, the body all else.
struct Contact {
  Scene scene;

  static Contact ofSphere(double gap) {
    Contact contact{mattScene({5, 2, 1}, {0.5, 0, 0})};
    addFloor(contact.scene, 6);
    contact.scene.spheres = {{.center = {0, 1 + gap, 0}}};
    return contact;
  }
  static Contact ofCube(double gap) {
    Contact contact{mattScene({4, 3, 1}, {0.5, 0, 0})};
    addFloor(contact.scene, 6);
    addBox(contact.scene, {-0.5, gap, -0.5}, {0.5, 1 + gap, 0.5});
    return contact;
  }
};

// Where float32 has put things, and what is lit there: closed forms.
struct ContactTruth {
  Scene local;
  double floor;        // its height
  dvec3 lo{0}, hi{0};  // of the box
  explicit ContactTruth(const Scene& world) : local(roundScene(world)), floor(local.cornersOf(0)[0].y) {
    if (local.triangles.size() <= 2) return;
    lo = hi = local.cornersOf(2)[0];
    for (size_t i = 2; i < local.triangles.size(); ++i)
      for (const dvec3& vertex : local.cornersOf(i)) {
        lo = glm::min(lo, vertex);
        hi = glm::max(hi, vertex);
      }
  }

  // Whether the body is on the way from a point: along all of a direction.
  bool blocks(const dvec3& point, const dvec3& direction) const {
    if (!local.spheres.empty()) {
      const dvec3 toCentre = local.spheres[0].center - point;
      const bool ahead = glm::dot(toCentre, direction) > 0;
      return ahead && glm::length(glm::cross(toCentre, direction)) <= local.spheres[0].radius * glm::length(direction);
    }
    double enter = 0, leave = INFINITY;
    for (int k = 0; k < 3; ++k) {
      const double a = (lo[k] - point[k]) / direction[k], b = (hi[k] - point[k]) / direction[k];
      enter = std::max(enter, std::min(a, b));
      leave = std::min(leave, std::max(a, b));
    }
    return enter <= leave;
  }
  enum class Sees { nothing, body, dark, lit };
  Sees sees(const dvec3& direction, const dvec3& light) const {
    if (blocks({0, 0, 0}, direction)) return Sees::body;
    if (direction.y >= 0) return Sees::nothing;
    const dvec3 point = floor / direction.y * direction;
    const dvec3 corner = glm::abs(local.cornersOf(0)[1] - local.cornersOf(1)[2]);
    const dvec3 middle = 0.5 * (local.cornersOf(0)[1] + local.cornersOf(1)[2]);
    if (std::abs(point.x - middle.x) > corner.x / 2 || std::abs(point.z - middle.z) > corner.z / 2)
      return Sees::nothing;
    return blocks(point, light - point) ? Sees::dark : Sees::lit;
  }
};

// Pixels of the floor that are lit or dark against the closed form, and have no border of light within a pixel.
WrongSamples wrongFloorPixels(const Scene& scene, int size, size_t& slit) {
  const ContactTruth truth(scene);
  const Image image = render(scene, size);
  WrongSamples wrong;
  const auto seesAt = [&](int x, int y) {
    return truth.sees(pixelDirection(truth.local.camera, size, x, y), truth.local.lights[0].position);
  };
  for (int y = 0; y < size; ++y)
    for (int x = 0; x < size; ++x) {
      const ContactTruth::Sees seen = seesAt(x, y);
      if (seen != ContactTruth::Sees::dark && seen != ContactTruth::Sees::lit) continue;
      bool border = false;
      for (int i = 0; i < 9; ++i) border = border || seesAt(x + i % 3 - 1, y + i / 3 - 1) != seen;
      ++wrong.asked;
      slit += seen == ContactTruth::Sees::lit;
      // Written so that a NaN is wrong.
      const float red = redAt(image, x, y);
      const bool right = seen == ContactTruth::Sees::lit ? red > 0 : red == 0;
      wrong.turner += !border && !right;
    }
  return wrong;
}

// Below the sphere, up to its contact with the floor: a point of the floor is looked at from halfway to the sphere.
Query underSphere(const ContactTruth& truth, Random& random) {
  const Sphere& sphere = truth.local.spheres[0];
  const double distance = logUniform(random, -2.5, -0.3) * sphere.radius,
               phi = uniform(random, 0, 2 * std::numbers::pi);
  const dvec3 point(sphere.center.x + distance * std::cos(phi), truth.floor,
                    sphere.center.z + distance * std::sin(phi));
  const dvec3 light = point + 4.0 * atCosine({0, 1, 0}, uniform(random, 0.1, 1), random);
  return queryOf(point + dvec3(0, 0.25 * distance * distance / sphere.radius, 0), {0, -1, 0}, light);
}

// Inside the cube, above its bottom that lies in the floor: mostly near an edge or a corner.
Query insideCube(const ContactTruth& truth, Random& random) {
  const double height = truth.hi.y - truth.lo.y;
  dvec3 point;
  for (const int k : {0, 2}) {
    const double inside = random() % 3 ? logUniform(random, -7, -0.3) : uniform(random, 0, 1);
    point[k] = random() % 2 ? truth.lo[k] + inside * height : truth.hi[k] - inside * height;
  }
  point.y = truth.floor;
  const dvec3 light = point + 4.0 * atCosine({0, 1, 0}, uniform(random, 0.001, 1), random);
  return queryOf(point + dvec3(0, uniform(random, 0.01, 0.9) * height, 0), {0, -1, 0}, light);
}

// Samples that are lit though the closed form has them in the shadow: for certain where the light's way passes through
// the body to a millionth of it.
size_t countLeaks(const ContactTruth& truth, const std::vector<Query>& queries, const std::vector<Sample>& samples,
                  size_t* asked = nullptr) {
  size_t leaks = 0;
  for (size_t i = 0; i < samples.size(); ++i) {
    if (!samples[i].found.hits()) continue;
    const dvec3 point(queries[i].ray.origin.x, truth.floor, queries[i].ray.origin.z);
    const dvec3 way = dvec3(queries[i].target) - point;
    if (truth.local.spheres.empty()) {
      if (point.x <= truth.lo.x || point.x >= truth.hi.x || point.z <= truth.lo.z || point.z >= truth.hi.z) continue;
    } else {
      const Sphere& sphere = truth.local.spheres[0];
      const dvec3 toCentre = sphere.center - point;
      if (glm::length(glm::cross(toCentre, way)) > (1 - 1e-6) * sphere.radius * glm::length(way)) continue;
    }
    if (asked) ++*asked;
    leaks += samples[i].lit;
  }
  return leaks;
}

template <class MakeQuery>
void reportLeaks(const Bench& bench, const Scene& scene, const std::string& where, Random& random, Report& report,
                 const MakeQuery& makeQuery) {
  bench.kernels.setScene(scene);
  const ContactTruth truth(scene);
  WrongSamples leaks;
  Bench::inBatches(bench.effort.rays(1e6, 1e5), [&](size_t count) {
    std::vector<Query> queries;
    for (size_t i = 0; i < count; ++i) queries.push_back(makeQuery(truth, random));
    leaks.turner += countLeaks(truth, queries, lightUp(bench.kernels, queries), &leaks.asked);
    leaks.naive += countLeaks(truth, queries, lightUp(bench.kernels, queries, Tracer::naive));
  });
  report.atMost(fmt::format("gap 0, {}: lit of {:.2g} samples", where, double(leaks.asked)), leaks.value(), 0,
                double(leaks.naive));
}

void contact(const Bench& bench, Report& report) {
  Random random = bench.random(25);
  const int size = bench.effort.full ? 512 : 256;
  // One light shines from above, one from so low that a slit of 1e-4 lets it pass below the body.
  const std::array<std::pair<const char*, dvec3>, 2> lights = {
      {{"high", dvec3(-3, 3, 1)}, {"low", dvec3(-1000, 0.07, 1)}}};
  for (const double gap : {0.0, 1e-6, 1e-4})
    for (const bool isSphere : {true, false})
      for (const auto& [name, position] : lights) {
        Contact contact = isSphere ? Contact::ofSphere(gap) : Contact::ofCube(gap);
        contact.scene.lights = {{.position = position}};
        size_t lit = 0;
        const WrongSamples wrong = wrongFloorPixels(contact.scene, size, lit);
        report.atMost(fmt::format("{}, gap {:g}, {} light: wrong pixels farther than 1 from a border",
                                  isSphere ? "sphere" : "cube", gap, name),
                      wrong.value(), 0, {}, fmt::format("{} of the floor, {} lit", wrong.asked, lit));
      }
  reportLeaks(bench, Contact::ofSphere(0).scene, "under the sphere", random, report, underSphere);
  reportLeaks(bench, Contact::ofCube(0).scene, "inside the cube", random, report, insideCube);
}

// --- 26: a light on a surface ---

struct Brightness {
  size_t lit = 0, notFinite = 0;
  double most = 0;
  double value() const { return notFinite > 0 ? NAN : most; }
};

Brightness brightnessOf(const Image& image) {
  Brightness brightness;
  for (const float value : image.rgb) {
    brightness.notFinite += !std::isfinite(value);
    brightness.lit += value != 0;
    if (std::isfinite(value)) brightness.most = std::max(brightness.most, std::abs(double(value)));
  }
  return brightness;
}

// The scene's only light, and what it does to a picture: nothing.
void reportDark(const std::string& what, Scene scene, const Light& light, int size, Report& report) {
  scene.lights = {light};
  const Brightness brightness = brightnessOf(render(scene, size));
  report.atMost(what + ": brightest value", brightness.value(), 0, {},
                fmt::format("{} values not 0, {} not finite", brightness.lit, brightness.notFinite));
}

// N.L of samples at distances from the light down to 10^-8, by the surface that the kernel finds; 0 where it is dark.
template <class MakeQuery>
void reportDarkSamples(const Bench& bench, const Scene& scene, const std::string& what, Report& report,
                       const MakeQuery& makeQuery) {
  bench.kernels.setScene(scene);
  const dvec3 light = bench.kernels.local().lights[0].position;
  const auto most = [&](const std::vector<Query>& queries, Tracer tracer, size_t& lit) {
    double brightest = 0;
    for (const Sample& sample : lightUp(bench.kernels, queries, tracer)) {
      if (!sample.lit) continue;
      ++lit;
      const double cosine = glm::dot(dvec3(sample.found.Ns), glm::normalize(light - dvec3(sample.found.point)));
      brightest = cosine <= brightest ? brightest : cosine;  // a NaN stays
    }
    return brightest;
  };
  std::vector<Query> queries(bench.effort.rays(2.5e5, 1e5));
  for (Query& query : queries) query = makeQuery(light);
  size_t lit = 0, naiveLit = 0;
  const double turner = most(queries, Tracer::turner, lit), naive = most(queries, Tracer::naive, naiveLit);
  report.atMost(fmt::format("{}: N.L of {:.2g} samples around the light", what, double(queries.size())), turner, 0,
                naive, fmt::format("{} lit, naive {}", lit, naiveLit));
}

void lightOnSurface(const Bench& bench, Report& report) {
  Random random = bench.random(26);
  const int size = bench.effort.full ? 512 : 128;
  // Eye and target are such that the local frame holds the light exactly where it is.
  Scene plane = mattScene({0.5, 2, 4}, {0, 0, 0}), sphere = mattScene({0, 2, 4}, {0, 1, 0});
  addFloor(plane, 3);
  sphere.spheres = {{.center = {0, 0, 0}}};
  for (const Falloff falloff : {Falloff::none, Falloff::inverseSquare}) {
    const std::string name = falloff == Falloff::none ? "" : ", inverse-square";
    reportDark("in the plane y = 0" + name, plane, {.position = {0, 0, 0}, .falloff = falloff}, size, report);
    reportDark("on the unit sphere" + name, sphere, {.position = {0, 1, 0}, .falloff = falloff}, size, report);
  }
  plane.lights = {{.position = {0, 0, 0}}};
  sphere.lights = {{.position = {0, 1, 0}}};
  reportDarkSamples(bench, plane, "in the plane", report, [&](const dvec3& light) {
    const dvec3 aim = light + logUniform(random, -8, -0.5) * atCosine({0, 1, 0}, 0, random);
    const dvec3 toEye = atCosine({0, 1, 0}, logUniform(random, -2, 0), random);
    return queryOf(aim + toEye, -toEye, light);
  });
  reportDarkSamples(bench, sphere, "on the sphere", report, [&](const dvec3& light) {
    const double radius = 0.25, angle = logUniform(random, -8, -0.5);  // the local frame is a quarter of the world
    const dvec3 centre = light - dvec3(0, radius, 0), normal = atCosine({0, 1, 0}, std::cos(angle), random);
    const dvec3 toEye = atCosine(normal, logUniform(random, -2, 0), random);
    return queryOf(centre + radius * normal + toEye, -toEye, light);
  });
}

// --- 27: lights in odd places ---

// A ball on a floor.
Scene ballOnFloor() {
  Scene scene = mattScene({0.7, 2, 5}, {0, 0.7, 0});
  addFloor(scene, 3);
  scene.spheres = {{.center = {0, 1, 0}}};
  return scene;
}

void reportLightInsideGlass(int size, Report& report) {
  Scene scene = ballOnFloor();
  scene.materials.push_back({.diffuse = dvec3(0.5), .reflect = 0.1, .transmit = 0.8, .localWeight = 0.1});
  scene.spheres[0].material = 1;
  scene.lights = {{.position = {0.2, 1.3, 0.1}}};
  const Image image = render(scene, size);
  const Scene local = roundScene(scene);
  WrongSamples wrong;
  size_t glows = 0;
  for (int y = 0; y < size; ++y)
    for (int x = 0; x < size; ++x) {
      const dvec3 direction = pixelDirection(local.camera, size, x, y);
      const bool seesBall = meet(local.spheres[0], dvec3(0), direction).has_value();
      glows += seesBall && redAt(image, x, y) > 0;
      wrong.asked += !seesBall;
      wrong.turner += !seesBall && redAt(image, x, y) != 0;
    }
  report.atMost("inside a glass sphere: pixels outside it that are not 0", glows > 0 ? wrong.value() : NAN, 0, {},
                fmt::format("{} asked; {} pixels of the glass glow", wrong.asked, glows));
}

// A ball alone, lit from behind the camera: N.L in closed form.
void reportLightBehindCamera(int size, Report& report) {
  Scene scene = mattScene({0, 0, 5}, {0, 0, 0});
  scene.spheres = {{.center = {0, 0, 0}}};
  scene.lights = {{.position = {3, 4, 20}}};
  const Image image = render(scene, size);
  const Scene local = roundScene(scene);
  const Sphere& ball = local.spheres[0];
  WrongSamples wrong;
  for (int y = 0; y < size; ++y)
    for (int x = 0; x < size; ++x) {
      const dvec3 direction = pixelDirection(local.camera, size, x, y);
      const auto meeting = meet(ball, dvec3(0), direction);
      if (meeting && glm::length(glm::cross(ball.center, direction)) > 0.99 * ball.radius) continue;
      // What an error of 2e-7 in t or in the direction makes of N: more, the more grazing the ray is.
      const dvec3 point = (meeting ? meeting->t : 0) * direction, normal = glm::normalize(point - ball.center);
      const double value = meeting ? glm::dot(normal, glm::normalize(local.lights[0].position - point)) : 0;
      const double tolerance = meeting ? 2e-7 * meeting->t / (ball.radius * -glm::dot(normal, direction)) : 0;
      ++wrong.asked;
      wrong.turner += !(std::abs(redAt(image, x, y) - std::max(value, 0.0)) <= tolerance);
    }
  report.atMost("behind the camera: pixels that differ from N.L by more than 2e-7 t / (r N.V)", wrong.value(), 0, {},
                fmt::format("{} asked", wrong.asked));
}

// Spheres and triangles in disorder: nothing that the eye sees is in the shadow.
void reportLightAtEye(int size, Random& random, Report& report) {
  Scene scene = mattScene({0, 0, 0}, {0, 0, 8});
  const auto place = [&] { return dvec3(uniform(random, -3, 3), uniform(random, -3, 3), uniform(random, 4, 12)); };
  for (int i = 0; i < 60; ++i) scene.spheres.push_back({.center = place(), .radius = uniform(random, 0.05, 0.5)});
  for (int i = 0; i < 60; ++i) {
    const dvec3 corner = place();
    scene.addTriangle({corner, corner + randomDirection(random), corner + randomDirection(random)});
  }
  scene.lights = {{.position = scene.camera.eye}};
  const Image image = render(scene, size);
  const Scene local = roundScene(scene);
  WrongSamples wrong;
  for (int y = 0; y < size; ++y)
    for (int x = 0; x < size; ++x) {
      const Truth truth = bruteForce(local, dvec3(0), pixelDirection(local.camera, size, x, y));
      if (!truth.sure) continue;
      ++wrong.asked;
      const float red = redAt(image, x, y);
      wrong.turner += !(truth.id == kNothing ? red == 0 : red > 0);
    }
  report.atMost("at the eye: pixels of objects in shadow, or of the background that are not 0", wrong.value(), 0, {},
                fmt::format("{} asked", wrong.asked));
}

void oddLights(const Bench& bench, Report& report) {
  Random random = bench.random(27);
  const int size = bench.effort.full ? 512 : 128;
  for (const double depth : {1.0, 1e-2, 1e-4})
    reportDark(fmt::format("inside an opaque sphere, {:g} deep", depth), ballOnFloor(),
               {.position = dvec3(0, 1, 0) + (1 - depth) * glm::normalize(dvec3(1, -1, 2))}, size, report);
  reportLightInsideGlass(size, report);
  Scene ball = mattScene({0, 0, 5}, {0, 0, 0}), quad = ball;
  ball.spheres = {{.center = {0, 0, 0}}};
  addQuad(quad, {-1, -1, 0.3}, {2, 0, -0.5}, {0, 2, 0.2});
  reportDark("behind a sphere", ball, {.position = {0, 0, -3}}, size, report);
  reportDark("behind a square", quad, {.position = {0.2, 0.1, -3}}, size, report);
  reportLightBehindCamera(size, report);
  reportLightAtEye(size, random, report);
}

// --- 28: coincident surfaces ---

// A box against a wall, or a glass cube on a floor; `gap` < 0: sunk into it. The lower ids are the first's.
Scene boxAtWall(double gap, bool wallFirst) {
  Scene scene = mattScene({2, 1.5, 4}, {0, 0, 0});
  scene.materials.push_back(matt(0.6));
  const auto wall = [&] { addQuad(scene, {-3, -3, 0}, {6, 0, 0}, {0, 6, 0}); };
  if (wallFirst) wall();
  addBox(scene, {-0.6, -0.5, gap}, {0.5, 0.6, 0.8 + gap}, 1);
  if (!wallFirst) wall();
  scene.lights = {{.position = {2, 3, 3}}};
  return scene;
}

Scene cubeOnFloor(double gap, bool floorFirst) {
  Scene scene = mattScene({1.5, 2, 4}, {0, 0.5, 0});
  scene.background = {0.2, 0.3, 0.4};
  scene.materials.push_back({.reflect = 0.1, .transmit = 0.9, .localWeight = 0});
  if (floorFirst) addFloor(scene, 3);
  addBox(scene, {-0.5, gap, -0.6}, {0.6, 1 + gap, 0.5}, 1);
  if (!floorFirst) addFloor(scene, 3);
  scene.lights = {{.position = {2, 5, 3}}};
  return scene;
}

// All of it turned: what lies in one plane does so but for rounding.
Scene turned(Scene scene) {
  const dvec3 x = glm::normalize(dvec3(0.8, 0.3, -0.5)), y = glm::normalize(glm::cross(dvec3(0.1, 0.2, 1), x));
  const dvec3 z = glm::cross(x, y);
  for (dvec3* point : {&scene.camera.eye, &scene.camera.target, &scene.camera.up, &scene.lights[0].position})
    *point = point->x * x + point->y * y + point->z * z;
  for (dvec3& v : scene.positions) v = v.x * x + v.y * y + v.z * z;
  return scene;
}

Image renderWithMedianTree(const Scene& scene, int size) {
  const RenderSettings settings = test::settingsOf(scene, size, size);
  const PreparedGeometry prepared = prepareGeometry(roundScene(scene));
  test::renderer().upload(packScene(prepared, buildMedianBvh(prepared.boxes, prepared.typeStarts()), settings));
  return test::renderer().render(test::kernel(), settings).image;
}

// Values that change with tiles, work-groups or the tree.
size_t countDifferences(const Scene& scene, int size, const Image& image) {
  const RenderSettings settings = test::settingsOf(scene, size, size);
  size_t differences = 0;
  for (const Image& other : {render(scene, size), renderWithMedianTree(scene, size),
                             test::renderShader(scene, settings, {.tile = 16, .workGroup = 16}),
                             test::renderShader(scene, settings, {.tile = 64, .workGroup = 128})})
    for (size_t i = 0; i < image.rgb.size(); ++i) differences += other.rgb[i] != image.rgb[i];
  return differences;
}

// Pixels near which a picture has an edge.
std::vector<bool> edgesOf(const Image& image) {
  const int size = image.width;
  std::vector<bool> edges(image.window.area());
  for (int y = 0; y < size; ++y)
    for (int x = 0; x < size; ++x)
      for (int i = 0; i < 9; ++i) {
        const int u = std::clamp(x + i % 3 - 1, 0, size - 1), v = std::clamp(y + i / 3 - 1, 0, size - 1);
        if (std::abs(redAt(image, u, v) - redAt(image, x, y)) > 0.03) edges[size_t(y * size + x)] = true;
      }
  return edges;
}

// The largest difference of two pictures off the edges; NaN if there is one, or if hardly anything is off them.
double largestDifference(const Image& a, const Image& b, const std::vector<bool>& edges) {
  double most = 0;
  if (2 * std::count(edges.begin(), edges.end(), true) > int(edges.size())) return NAN;
  for (size_t i = 0; i < a.rgb.size(); ++i) {
    if (edges[i / 3]) continue;
    const double difference = std::abs(double(a.rgb[i]) - b.rgb[i]);
    most = difference <= most ? most : difference;
  }
  return most;
}

void reportCoincident(const std::string& what, const Scene& touching, const Scene& overlapping, int size,
                      Report& report) {
  const RenderSettings settings = test::settingsOf(touching, size, size);
  const Image image = render(touching, size);
  const Image overlap = renderReference(roundScene(overlapping), settings).image;
  const std::vector<bool> edges = edgesOf(overlap);
  report.atMost(what + ": values that change with tiles, work-groups or tree",
                double(countDifferences(touching, size, image)), 0);
  const double difference = largestDifference(image, render(overlapping, size), edges);
  report.atMost(what + ": largest difference to an overlap of 1e-6", difference, 1e-5, {},
                fmt::format("off edges, {} of {} pixels", std::count(edges.begin(), edges.end(), false), edges.size()));
  report.atMost(what + ": largest difference to the reference",
                largestDifference(image, renderReference(roundScene(touching), settings).image, edges), 1e-5);
}

void coincidentSurfaces(const Bench& bench, Report& report) {
  const int size = bench.effort.full ? 512 : 96;
  for (const bool first : {true, false}) {
    reportCoincident(fmt::format("box at a wall, {} first", first ? "wall" : "box"), boxAtWall(0, first),
                     boxAtWall(-1e-6, first), size, report);
    reportCoincident(fmt::format("glass cube on a floor, {} first", first ? "floor" : "cube"), cubeOnFloor(0, first),
                     cubeOnFloor(-1e-6, first), size, report);
    reportCoincident(fmt::format("glass cube on a tilted floor, {} first", first ? "floor" : "cube"),
                     turned(cubeOnFloor(0, first)), turned(cubeOnFloor(-1e-6, first)), size, report);
  }
}

}  // namespace

std::vector<Case> lightCases() {
  return {{24, "Convex bodies at the terminator", convexAcne},
          {25, "Contact", contact},
          {26, "Light on a surface", lightOnSurface},
          {27, "Lights in odd places", oddLights},
          {28, "Light through coincident surfaces", coincidentSurfaces}};
}

}  // namespace turner::hard
