// Trees: no ray loses a primitive on its way through the boxes, however they lie; no scene is too much for a builder.
#include <fmt/format.h>

#include <array>
#include <atomic>
#include <chrono>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "base/threads.h"
#include "hard/brute_force.h"
#include "hard/cases.h"
#include "hard/vectors.h"

namespace turner::hard {
namespace {

using Lattice3 = glm::i64vec3;

// A scene whose local frame is the world itself, rounded: the eye is the origin, the target at a distance of 1.
Scene sceneAtOrigin() {
  Scene scene;
  scene.materials = {Material{}};
  scene.camera = {.eye = {0, 0, 0}, .target = {0, 0, 1}};
  return scene;
}

Query queryOf(const dvec3& origin, const dvec3& direction) {
  return {.ray = {.origin = vec3(origin), .direction = vec3(direction)}};
}

// Wrong ids among the rays that the oracle is sure of. If it is not sure of one in twenty, the test tests nothing.
struct Mismatches {
  std::atomic<size_t> rays = 0, unsure = 0, turner = 0, naive = 0;
  bool isTested() const { return rays > 0 && 20 * unsure <= rays; }
  double value() const { return isTested() ? double(turner) : NAN; }
  std::string note() const {
    return fmt::format("{} of {} not asked: too near to an edge", unsure.load(), rays.load());
  }
};

// Traces the rays with both tracers; `truthOf(ray, i)` is the oracle.
template <class TruthOf>
void compareIds(const Bench& bench, const std::vector<Query>& queries, Mismatches& mismatches, const TruthOf& truthOf) {
  const std::vector<Found> turner = bench.kernels.trace(queries);
  const std::vector<Found> naive = bench.kernels.trace(queries, Tracer::naive);
  parallelFor(queries.size(), [&](size_t i) {
    const Truth truth = truthOf(queries[i].ray);
    ++mismatches.rays;
    if (!truth.sure) {
      ++mismatches.unsure;
      return;
    }
    mismatches.turner += turner[i].id != truth.id;
    mismatches.naive += naive[i].id != truth.id;
  });
}

// --- pictures that tell ids: for rays that take more iterations than one dispatch has ---

struct IdPicture {
  std::vector<uint32_t> ids;  // kNothing: background, black or not a number
  std::vector<dvec3> directions;
};

// Renders a scene with a light at its eye and each primitive in a colour that is its id.
IdPicture renderIds(Scene scene, int size) {
  constexpr uint32_t kDigits = 1024;
  scene.materials.assign(scene.primitiveCount(), Material{});
  for (uint32_t id = 0; id < scene.materials.size(); ++id) {
    scene.materials[id].diffuse = {1, double(id / kDigits) / kDigits, double(id % kDigits) / kDigits};
    visitPrimitive(scene, id, [&](auto& primitive) { primitive.material = id; });
  }
  scene.lights = {{.position = scene.camera.eye}};
  scene.depth = 1;
  const Image image = test::renderShader(scene, test::settingsOf(scene, size, size));

  IdPicture picture;
  for (int y = 0; y < size; ++y)
    for (int x = 0; x < size; ++x) {
      picture.directions.push_back(pixelDirection(scene.camera, size, x, y));
      const float* rgb = &image.rgb[3 * size_t(y * size + x)];
      const double high = double(rgb[1]) / rgb[0] * kDigits, low = double(rgb[2]) / rgb[0] * kDigits;
      const bool shows = rgb[0] > 0 && high >= 0 && low >= 0;
      picture.ids.push_back(shows ? uint32_t(std::lround(high)) * kDigits + uint32_t(std::lround(low)) : kNothing);
    }
  return picture;
}

// Compares the ids in a picture with brute force.
void compareIdsInPicture(const Scene& scene, int size, Mismatches& mismatches) {
  const Scene local = roundScene(scene);
  const IdPicture picture = renderIds(scene, size);
  parallelFor(picture.ids.size(), [&](size_t i) {
    const Truth truth = bruteForce(local, dvec3(0), picture.directions[i]);
    ++mismatches.rays;
    if (truth.sure)
      mismatches.turner += picture.ids[i] != truth.id;
    else
      ++mismatches.unsure;
  });
}

// --- 19: everything on a lattice, where float32 is exact: no ray is left out ---

// Some of the squares of a lattice, cut into triangles, of which some are alone.
Scene latticeOfSquares(Random& random) {
  Scene scene = sceneAtOrigin();
  constexpr int kReach = 4;
  for (int axis = 0; axis < 3; ++axis)
    for (int i = -kReach; i <= kReach; ++i)
      for (int j = -kReach; j < kReach; ++j)
        for (int k = -kReach; k < kReach; ++k) {
          if (random() % 4 != 0) continue;
          dvec3 corner(i), a(0), b(0);
          corner[(axis + 1) % 3] = j;
          corner[(axis + 2) % 3] = k;
          a[(axis + 1) % 3] = 1;
          b[(axis + 2) % 3] = 1;
          scene.addTriangle({corner, corner + a, corner + a + b});
          if (random() % 4 != 0) scene.addTriangle({corner, corner + a + b, corner + b});
        }
  return scene;
}

// A ray with one or two components that are +0 or -0, from the planes of the lattice or the middles between them. The
// others are powers of 2, so that every quotient is exact.
Query latticeRay(Random& random) {
  Query query;
  vec3& d = query.ray.direction;
  const int axis = int(random() % 3), other = (axis + 1 + int(random() % 2)) % 3;
  for (int k = 0; k < 3; ++k) {
    query.ray.origin[k] = 0.5f * float(int(random() % 25) - 12);
    const float size = k == axis ? 1.0f : k == other && random() % 2 ? float(1 << random() % 3) : 0.0f;
    d[k] = random() % 2 ? size : -size;
  }
  return query;
}

// Twice the number, an integer on the lattice.
Lattice3 doubled(const dvec3& v) {
  return Lattice3(2.0 * v);
}

struct LatticeTruth {
  uint32_t id = kNothing;
  double t = INFINITY;
};

// The nearest closed triangle that is not edge-on, in integers. t is a quotient by a power of 2, hence exact too.
LatticeTruth nearestOnLattice(const Scene& scene, const TestRay& ray) {
  const Lattice3 o = doubled(ray.origin), d = Lattice3(ray.direction);
  LatticeTruth nearest;
  for (uint32_t id = 0; id < scene.triangles.size(); ++id) {
    const auto& [p, q, r] = scene.cornersOf(id);
    const Lattice3 a = doubled(p) - o, b = doubled(q) - o, c = doubled(r) - o;
    const auto volume = [&](const Lattice3& from, const Lattice3& to) {
      return d.x * (from.y * to.z - from.z * to.y) + d.y * (from.z * to.x - from.x * to.z) +
             d.z * (from.x * to.y - from.y * to.x);
    };
    const int64_t u = volume(b, c), v = volume(c, a), w = volume(a, b);
    if (std::min({u, v, w}) < 0 && std::max({u, v, w}) > 0) continue;
    if (u + v + w == 0) continue;
    const int64_t six = a.x * (b.y * c.z - b.z * c.y) + a.y * (b.z * c.x - b.x * c.z) + a.z * (b.x * c.y - b.y * c.x);
    const double t = 0.5 * double(six) / double(u + v + w);
    if (t > 0 && t < nearest.t) nearest = {id, t};
  }
  return nearest;
}

void axisParallelRays(const Bench& bench, Report& report) {
  Random random = bench.random(19);
  const Scene scene = latticeOfSquares(random);
  bench.kernels.setScene(scene);
  const size_t rays = bench.effort.rays(1e6, 1e5);
  size_t hits = 0, wrongIds = 0, wrong = 0, naiveWrong = 0;
  Bench::inBatches(rays, [&](size_t count) {
    std::vector<Query> queries(count);
    for (Query& query : queries) query = latticeRay(random);
    const std::vector<Found> turner = bench.kernels.trace(queries), naive = bench.kernels.trace(queries, Tracer::naive);
    std::vector<LatticeTruth> truths(count);
    forAll(count, [&](size_t i) { truths[i] = nearestOnLattice(scene, queries[i].ray); });
    const auto isWrong = [](const Found& found, const LatticeTruth& truth) {
      return found.hits() != (truth.id != kNothing) || (found.hits() && double(found.t) != truth.t);
    };
    for (size_t i = 0; i < count; ++i) {
      hits += truths[i].id != kNothing;
      wrongIds += turner[i].id != truths[i].id;
      wrong += isWrong(turner[i], truths[i]);
      naiveWrong += isWrong(naive[i], truths[i]);
    }
  });
  const std::string of = fmt::format("of {:.2g} rays with components +0 and -0", double(rays));
  report.atMost("false misses and wrong distances " + of, hits > 0 ? double(wrong) : NAN, 0, double(naiveWrong),
                fmt::format("{} hit; t is exact", hits));
  report.atMost("wrong ids " + of, double(wrongIds), 0, {}, "equal distances: the lowest id");
}

// --- 20: rays exactly through vertices that are corners of boxes ---

// Vertices and origins are multiples of this, so that the way from one to the other is a float.
constexpr double kGrain = 1.0 / 64;

double onGrain(double x) {
  return kGrain * std::round(x / kGrain);
}
dvec3 onGrain(const dvec3& v) {
  return {onGrain(v.x), onGrain(v.y), onGrain(v.z)};
}

// A ray through a vertex, from a direction and a distance that are rounded. Half of them are as long as the way, which
// is exact; the others are unit vectors.
Query rayThrough(const dvec3& vertex, const dvec3& from, double distance, Random& random) {
  const dvec3 origin = onGrain(vertex + distance * from);
  const dvec3 way = vertex - origin;
  return queryOf(origin, random() % 2 ? way : glm::normalize(way));
}

double stressDistance(Random& random) {
  return std::pow(10.0, uniform(random, 1, 5));
}

// A wavy sheet across one of the axes. No slope exceeds 0.5, so that a ray from within 45 degrees of the axis sees all
// triangles of a vertex, and nothing before them.
struct Sheet {
  static constexpr int kCells = 64;
  Scene scene = sceneAtOrigin();
  std::vector<dvec3> vertices;
  int axis;

  size_t at(int i, int j) const { return size_t(i * (kCells + 1) + j); }
  dvec3 turned(double x, double y, double height) const {
    dvec3 v;
    v[axis] = height;
    v[(axis + 1) % 3] = x;
    v[(axis + 2) % 3] = y;
    return v;
  }
  Sheet(int sheetAxis, double translation, Random& random) : axis(sheetAxis) {
    for (int i = 0; i <= kCells; ++i)
      for (int j = 0; j <= kCells; ++j)
        vertices.push_back(dvec3(translation) +
                           turned(i - kCells / 2, j - kCells / 2, onGrain(uniform(random, 0, 0.2))));
    for (int i = 0; i < kCells; ++i)
      for (int j = 0; j < kCells; ++j) {
        std::array<size_t, 4> c = {at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)};
        if (random() % 2) std::rotate(c.begin(), c.begin() + 1, c.end());
        scene.addTriangle({vertices[c[0]], vertices[c[1]], vertices[c[2]]});
        scene.addTriangle({vertices[c[0]], vertices[c[2]], vertices[c[3]]});
      }
  }
  size_t innerVertex(Random& random) const {
    return at(1 + int(random() % (kCells - 1)), 1 + int(random() % (kCells - 1)));
  }
  // From one side or the other, within 45 degrees of the axis.
  dvec3 side(Random& random) const {
    const double tangent = uniform(random, 0, 1), phi = uniform(random, 0, 2 * std::numbers::pi);
    const double sign = random() % 2 ? 1 : -1;
    return glm::normalize(turned(tangent * std::cos(phi), tangent * std::sin(phi), sign));
  }
};

struct VertexMisses {
  size_t rays = 0, turner = 0, naive = 0, strays = 0;
};

void aimAtSheet(const Bench& bench, const Sheet& sheet, size_t rays, Random& random, VertexMisses& misses) {
  bench.kernels.setScene(sheet.scene);
  const Scene& local = bench.kernels.local();
  Bench::inBatches(rays, [&](size_t count) {
    std::vector<Query> queries;
    std::vector<size_t> aims;
    for (size_t i = 0; i < count; ++i) {
      aims.push_back(sheet.innerVertex(random));
      queries.push_back(rayThrough(sheet.vertices[aims[i]], sheet.side(random), stressDistance(random), random));
    }
    const std::vector<Found> turner = bench.kernels.trace(queries), naive = bench.kernels.trace(queries, Tracer::naive);
    for (size_t i = 0; i < count; ++i) {
      ++misses.rays;
      misses.turner += !turner[i].hits();
      misses.naive += !naive[i].hits();
      if (!turner[i].hits()) continue;
      const auto& corners = local.cornersOf(turner[i].id);
      misses.strays += std::find(corners.begin(), corners.end(), sheet.vertices[aims[i]]) == corners.end();
    }
  });
}

// Lonely triangles: each vertex is a corner of its box, or near it.
Scene triangleSoup(double translation, Random& random) {
  Scene scene = sceneAtOrigin();
  for (int i = 0; i < 128; ++i) {
    const dvec3 place = dvec3(translation) + uniform(random, 0, 32) * randomDirection(random);
    TriangleCorners corners;
    for (dvec3& vertex : corners)
      vertex = onGrain(place + dvec3(uniform(random, 0, 4), uniform(random, 0, 4), uniform(random, 0, 4)));
    // One in four is flat along an axis.
    const int axis = int(random() % 12);
    if (axis < 3)
      for (dvec3& vertex : corners) vertex[axis] = corners[0][axis];
    scene.addTriangle(corners);
  }
  return scene;
}

// A tree whose boxes all hold the whole scene and more: it loses nothing, and every ray tests every primitive.
Bvh buildOfOpenBoxes(std::span<const Box> boxes, const KindStarts& kinds, const BvhLimits& limits) {
  Bvh bvh = buildBvh(boxes, kinds, limits);
  const vec3 size = bvh.root.box.hi - bvh.root.box.lo;
  const Box open{bvh.root.box.lo - size, bvh.root.box.hi + size};
  bvh.root.box = open;
  for (Bvh::Node& node : bvh.nodes) node.children[0].box = node.children[1].box = open;
  return bvh;
}

// Rays at vertices of the soup through the tree, and past every primitive: the same hits, bit for bit.
size_t lostInBoxes(const Bench& bench, const Scene& soup, size_t rays, Random& random, size_t& hits) {
  size_t lost = 0;
  Bench::inBatches(rays, [&](size_t count) {
    std::vector<Query> queries;
    for (size_t i = 0; i < count; ++i) {
      const dvec3 vertex = soup.cornersOf(random() % soup.triangles.size())[random() % 3];
      queries.push_back(rayThrough(vertex, randomDirection(random), stressDistance(random), random));
    }
    bench.kernels.setScene(soup, buildOfOpenBoxes);
    const std::vector<Found> all = bench.kernels.trace(queries);
    bench.kernels.setScene(soup);
    const std::vector<Found> some = bench.kernels.trace(queries);
    for (size_t i = 0; i < count; ++i) {
      hits += all[i].hits();
      lost += all[i].id != some[i].id || (all[i].hits() && all[i].t != some[i].t);
    }
  });
  return lost;
}

void raysAtBoxCorners(const Bench& bench, Report& report) {
  Random random = bench.random(20);
  VertexMisses misses;
  size_t soupRays = 0, soupHits = 0, lost = 0;
  const std::array<double, 4> translations = {0, 10, 1000, 1e4};
  for (const double translation : translations) {
    for (int axis = 0; axis < 3; ++axis) {
      const Sheet sheet(axis, translation, random);
      aimAtSheet(bench, sheet, bench.effort.rays(1e7, 2e5) / 12, random, misses);
    }
    const size_t rays = bench.effort.rays(1e7, 1e5) / 4;
    soupRays += rays;
    lost += lostInBoxes(bench, triangleSoup(translation, random), rays, random, soupHits);
  }
  const std::string from = "rays at vertices from 10...1e5 away";
  report.atMost(fmt::format("misses of {:.2g} {}, wavy sheets", double(misses.rays), from), double(misses.turner), 0,
                double(misses.naive));
  report.atMost("hits on triangles without that vertex", double(misses.strays), 0);
  report.atMost(fmt::format("false misses of boxes, {:.2g} {}, lonely triangles", double(soupRays), from),
                soupHits > 0 ? double(lost) : NAN, 0, {},
                fmt::format("against tests of every triangle; {} hit", soupHits));
}

// --- 21, 22: builders ---

// Builds a scene's tree by both builders, and reports what that takes.
void reportBuilds(const std::string& what, const Scene& scene, int depthBar, Report& report) {
  const PreparedGeometry prepared = prepareGeometry(roundScene(scene));
  const auto reportOne = [&](const char* name, auto* build) {
    const auto start = std::chrono::steady_clock::now();
    const Bvh bvh = build(prepared.boxes, prepared.typeStarts(), BvhLimits{});
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    const bool isWhole = bvh.order.size() == prepared.boxes.size();
    report.atMost(fmt::format("{}, {}: depth", what, name), isWhole ? double(bvh.depth) : NAN, depthBar);
    report.atMostSeconds(fmt::format("{}, {}: seconds to build", what, name), seconds, 5);
  };
  reportOne("Embree", buildBvh);
  reportOne("medians", buildMedianBvh);
}

// Spheres of radius 1 + i 1e-6 around a point 4 away from the eye.
Scene concentricSpheres(size_t count) {
  Scene scene = sceneAtOrigin();
  for (size_t i = 0; i < count; ++i) scene.spheres.push_back({.center = {0, 0, 4}, .radius = 1 + 1e-6 * double(i)});
  return scene;
}

// From outside, the nearest of concentric spheres is the largest. Few enough that a ray may test all of them in one
// dispatch: in a picture it may take more.
void reportConcentricRays(const Bench& bench, Random& random, Report& report) {
  const Scene scene = concentricSpheres(500);
  bench.kernels.setScene(scene);
  const uint32_t last = uint32_t(scene.spheres.size()) - 1;
  const Sphere& largest = bench.kernels.local().spheres[last];
  std::vector<Query> queries(bench.effort.rays(1e6, 2e4));
  for (Query& query : queries) {
    const dvec3 aim = largest.center + uniform(random, 0, 0.9) * randomDirection(random);
    const dvec3 origin = dvec3(vec3(largest.center + uniform(random, 1.1, 4) * randomDirection(random)));
    query = queryOf(origin, glm::normalize(aim - origin));
  }
  Mismatches mismatches;
  compareIds(bench, queries, mismatches, [&](const TestRay&) { return Truth{last, true}; });
  report.atMost(fmt::format("{} concentric spheres: wrong ids of {:.2g} rays", last + 1, double(queries.size())),
                mismatches.value(), 0, double(mismatches.naive));
}

// The same in a picture, where a ray may test all of them.
void reportConcentricPicture(const Scene& scene, int size, Report& report) {
  const IdPicture picture = renderIds(scene, size);
  const uint32_t last = uint32_t(scene.spheres.size()) - 1;
  size_t wrong = 0, asked = 0;
  for (size_t i = 0; i < picture.ids.size(); ++i) {
    const dvec3 toCentre = scene.spheres[last].center;
    const double impact = glm::length(glm::cross(toCentre, picture.directions[i]));
    if (impact > 0.9 * scene.spheres[last].radius) continue;
    ++asked;
    wrong += picture.ids[i] != last;
  }
  report.atMost(fmt::format("{} concentric spheres: wrong pixels of {}", last + 1, asked),
                asked > 0 ? double(wrong) : NAN, 0);
}

Scene copiesOfATriangle(size_t count) {
  Scene scene = sceneAtOrigin();
  scene.addTriangle({dvec3(-1, -0.8, 2), dvec3(1, -1, 2.5), dvec3(0.1, 1, 3)});
  scene.triangles.resize(count, scene.triangles[0]);
  return scene;
}

void sameCentroids(const Bench& bench, Report& report) {
  Random random = bench.random(21);
  const Scene spheres = concentricSpheres(1'000'000);
  reportBuilds("10^6 concentric spheres", spheres, 64, report);
  reportConcentricRays(bench, random, report);
  reportConcentricPicture(concentricSpheres(bench.effort.full ? 1'000'000 : 20'000), 16, report);

  const Scene copies = copiesOfATriangle(100'000);
  reportBuilds("10^5 equal triangles", copies, 64, report);
  Mismatches mismatches;
  compareIdsInPicture(copiesOfATriangle(bench.effort.full ? 100'000 : 20'000), 16, mismatches);
  report.atMost("equal triangles: wrong pixels of 256", mismatches.value(), 0, {}, mismatches.note());
}

// Spheres at x = 2^k of radius 2^k / 4. The target is 1024 away: in units of that, nothing is beyond the 1e10 that
// checkReach allows.
Scene lineOfPowers() {
  Scene scene = sceneAtOrigin();
  scene.camera.target = {0, 0, 1024};
  for (int k = -40; k <= 40; ++k)
    scene.spheres.push_back({.center = {std::ldexp(1.0, k), 0, 0}, .radius = std::ldexp(0.25, k)});
  return scene;
}

// Rays at a sphere of the line from nearby, from far away, or from the eye.
Query rayAtLine(const Scene& local, Random& random) {
  const Sphere& sphere = local.spheres[random() % local.spheres.size()];
  const dvec3 aim = sphere.center + uniform(random, 0, 1.2) * sphere.radius * randomDirection(random);
  dvec3 origin(0);
  const int kind = int(random() % 3);
  if (kind == 0) origin = sphere.center + uniform(random, 2, 16) * sphere.radius * randomDirection(random);
  if (kind == 1)
    origin = std::ldexp(uniform(random, 1, 2), int(random() % 12)) * sphere.center.x * randomDirection(random);
  origin = dvec3(vec3(origin));
  return queryOf(origin, glm::normalize(aim - origin));
}

// Triangles across the corner of a cube, each a ten thousandth smaller than the one before: their boxes are nested.
Scene nestedTriangles(size_t count) {
  Scene scene = sceneAtOrigin();
  for (size_t k = 0; k < count; ++k) {
    const double s = std::pow(0.9999, double(k));
    scene.addTriangle({dvec3(s, 0, 0), dvec3(0, s, 0), dvec3(0, 0, s)});
  }
  return scene;
}

// Into the corner from outside it, and out of it from between the triangles.
void compareNested(Scene scene, Mismatches& mismatches) {
  constexpr int kSize = 16;
  const dvec3 diagonal = dvec3(1, 1, 1) / std::sqrt(3.0);
  for (const double place : {1.0, 0.2, 0.01}) {
    scene.camera = {.eye = place * diagonal, .target = (place == 1.0 ? place - 1 : place + 1) * diagonal, .fov = 60};
    compareIdsInPicture(scene, kSize, mismatches);
  }
}

void geometricLineUp(const Bench& bench, Report& report) {
  Random random = bench.random(22);
  const int cap = int(gpu::kMaxTreeDepth);
  const Scene line = lineOfPowers();
  reportBuilds("81 spheres at 2^k", line, cap, report);
  bench.kernels.setScene(line);
  const Scene& local = bench.kernels.local();
  Mismatches mismatches;
  Bench::inBatches(bench.effort.rays(1e6, 1e5), [&](size_t count) {
    std::vector<Query> queries;
    for (size_t i = 0; i < count; ++i) queries.push_back(rayAtLine(local, random));
    compareIds(bench, queries, mismatches,
               [&](const TestRay& ray) { return bruteForce(local, ray.origin, ray.direction); });
  });
  report.atMost(fmt::format("spheres at 2^k: wrong ids of {:.2g} rays", double(mismatches.rays)), mismatches.value(), 0,
                double(mismatches.naive), mismatches.note());

  const Scene nested = nestedTriangles(100'000);
  reportBuilds("10^5 nested boxes", nested, cap, report);
  Mismatches pixels;
  compareNested(nestedTriangles(bench.effort.full ? 100'000 : 20'000), pixels);
  report.atMost(fmt::format("nested boxes: wrong pixels of {}", pixels.rays.load()), pixels.value(), 0, {},
                pixels.note());
}

// --- 23: many primitives ---

// A cube of cells in front of the eye, with a sphere, a cone or a triangle in the middle part of each: by turns.
class Cells {
 public:
  explicit Cells(size_t count, Random& random) : perSide_(int(std::cbrt(double(count)) + 0.5)) {
    scene_ = sceneAtOrigin();
    for (int z = 0; z < perSide_; ++z)
      for (int y = 0; y < perSide_; ++y)
        for (int x = 0; x < perSide_; ++x) {
          const double cell = kSide / perSide_;
          const auto inCell = [&](double margin) {
            return kCorner + cell * (dvec3(x, y, z) + dvec3(uniform(random, margin, 1 - margin),
                                                            uniform(random, margin, 1 - margin),
                                                            uniform(random, margin, 1 - margin)));
          };
          const size_t kind = indexOf({x, y, z}) % kKinds;
          if (kind == 0)
            scene_.spheres.push_back({.center = inCell(0.3), .radius = cell * uniform(random, 0.05, 0.25)});
          else if (kind == 1)
            scene_.cones.push_back({inCell(0.2), cell * uniform(random, 0, 0.1), inCell(0.2),
                                    cell * (random() % 2 ? 0.01 : uniform(random, 0.01, 0.1)), 0});
          else
            scene_.addTriangle({inCell(0.1), inCell(0.1), inCell(0.1)});
        }
  }

  Scene& scene() { return scene_; }
  size_t count() const { return size_t(perSide_) * size_t(perSide_) * size_t(perSide_); }

  // A ray from the eye or from among the cells, at one of them.
  Query ray(Random& random) const {
    const auto place = [&] {
      return kCorner + kSide * dvec3(uniform(random, 0, 1), uniform(random, 0, 1), uniform(random, 0, 1));
    };
    const dvec3 origin = random() % 2 ? dvec3(0) : dvec3(vec3(place()));
    return queryOf(origin, glm::normalize(place() - origin));
  }

  // The oracle goes through the layers of cells across the ray's largest component, and tests in double what lies about
  // the ray's way through each.
  Truth nearest(const Scene& local, const TestRay& ray) const {
    Nearest nearest;
    const double cell = kSide / perSide_;
    const dvec3 origin = (dvec3(ray.origin) - kCorner) / cell, direction(ray.direction);
    const dvec3 size = glm::abs(direction);
    const int axis = size.x > size.y ? (size.x > size.z ? 0 : 2) : size.y > size.z ? 1 : 2;
    const int a = (axis + 1) % 3, b = (axis + 2) % 3;
    for (int layer = 0; layer < perSide_; ++layer) {
      const double t0 = (layer - origin[axis]) / direction[axis], t1 = (layer + 1 - origin[axis]) / direction[axis];
      const auto range = [&](int k) {
        const auto [lo, hi] = std::minmax({origin[k] + t0 * direction[k], origin[k] + t1 * direction[k]});
        return std::pair{std::clamp(int(std::floor(lo - 0.01)), 0, perSide_),
                         std::clamp(int(std::floor(hi + 0.01)), -1, perSide_ - 1)};
      };
      const auto [aLo, aHi] = range(a);
      const auto [bLo, bHi] = range(b);
      glm::ivec3 at;
      at[axis] = layer;
      for (at[a] = aLo; at[a] <= aHi; ++at[a])
        for (at[b] = bLo; at[b] <= bHi; ++at[b]) addPrimitive(nearest, local, idAt(at, local), ray.origin, direction);
    }
    return nearest.truth();
  }

 private:
  static constexpr double kSide = 2;
  static constexpr dvec3 kCorner = {-1, -1, 1.5};
  size_t indexOf(const glm::ivec3& at) const { return size_t((at.z * perSide_ + at.y) * perSide_ + at.x); }
  static constexpr size_t kKinds = 3;
  uint32_t idAt(const glm::ivec3& at, const Scene& scene) const {
    const size_t index = indexOf(at), kind = index % kKinds;
    const size_t first = kind == 0 ? 0 : scene.spheres.size() + (kind == 1 ? 0 : scene.cones.size());
    return uint32_t(first + index / kKinds);
  }

  int perSide_;
  Scene scene_;
};

void reportMany(const Bench& bench, size_t count, Random& random, Report& report) {
  Cells cells(count, random);
  const std::string what = fmt::format("{:.2g} primitives: wrong ids of 1e4 rays", double(cells.count()));
  bench.kernels.setScene(cells.scene());
  cells.scene() = {};
  std::vector<Query> queries;
  for (int i = 0; i < 10'000; ++i) queries.push_back(cells.ray(random));
  Mismatches mismatches;
  const Scene& local = bench.kernels.local();
  compareIds(bench, queries, mismatches, [&](const TestRay& ray) { return cells.nearest(local, ray); });
  report.atMost(what, mismatches.value(), 0, double(mismatches.naive), mismatches.note());
}

// Among the tiny ones one triangle that is 10^6 large: all boxes are rounded in its measure.
void reportGiant(size_t count, Random& random, Report& report) {
  Cells cells(count, random);
  TriangleCorners giant;
  for (int i = 0; i < 3; ++i) {
    const double angle = 2 * std::numbers::pi * i / 3, x = 1e6 * std::cos(angle), y = 1e6 * std::sin(angle);
    giant[size_t(i)] = {x, y, 2.6 - 0.04 * x + 0.03 * y};
  }
  cells.scene().addTriangle(giant);
  Mismatches mismatches;
  const auto start = std::chrono::steady_clock::now();
  compareIdsInPicture(cells.scene(), 32, mismatches);
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  report.atMost(
      fmt::format("{:.2g} and one of size 1e6: wrong pixels of {}", double(cells.count()), mismatches.rays.load()),
      mismatches.value(), 0, {}, fmt::format("{}; {:.1f} s", mismatches.note(), seconds));
}

void manyPrimitives(const Bench& bench, Report& report) {
  Random random = bench.random(23);
  const bool full = bench.effort.full;
  reportMany(bench, full ? 1'000'000 : 100'000, random, report);
  if (full) reportMany(bench, 10'000'000, random, report);
  reportGiant(full ? 1'000'000 : 20'000, random, report);
}

}  // namespace

std::vector<Case> treeCases() {
  return {{19, "Axis-parallel rays on a lattice", axisParallelRays},
          {20, "Rays at the corners of boxes", raysAtBoxCorners},
          {21, "Same centroids", sameCentroids},
          {22, "Geometric line-up", geometricLineUp},
          {23, "Many primitives", manyPrimitives}};
}

}  // namespace turner::hard
