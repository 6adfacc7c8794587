// Determinism: the picture depends on the scene alone, and sums of many samples are as good as float32 can be.
#include <fmt/format.h>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "hard/cases.h"
#include "hard/pictures.h"
#include "hard/vectors.h"
#include "reference/reference.h"
#include "support/our_scenes.h"
#include "support/shader_harness.h"

namespace turner::hard {
namespace {

// A tree that knows nothing of where its boxes are: halves of a shuffled order. Rays meet it in an order that no other
// tree has.
class ShuffledTree {
 public:
  ShuffledTree(std::span<const Box> boxes, const KindStarts& kinds, Random& random) : boxes_(boxes), kinds_(kinds) {
    for (uint32_t i = 0; i < boxes.size(); ++i) bvh_.order.push_back(i);
    size_t begin = 0;
    kinds_.push_back(boxes.size());
    for (const size_t end : kinds_) {
      std::shuffle(bvh_.order.begin() + std::ptrdiff_t(begin), bvh_.order.begin() + std::ptrdiff_t(end), random);
      begin = end;
    }
    if (!boxes.empty()) bvh_.root = build(0, boxes.size(), 0);
  }
  const Bvh& bvh() const { return bvh_; }

 private:
  BvhChild build(size_t begin, size_t end, int depth) {
    BvhChild child;
    child.box = boxes_[bvh_.order[begin]];
    for (size_t i = begin; i < end; ++i) {
      const Box& box = boxes_[bvh_.order[i]];
      child.box = {glm::min(child.box.lo, box.lo), glm::max(child.box.hi, box.hi)};
    }
    const size_t start = *std::upper_bound(kinds_.begin(), kinds_.end() - 1, begin);
    const bool isMixed = start < end;
    if (!isMixed && end - begin <= BvhLimits{}.maxLeafSize) {
      std::sort(bvh_.order.begin() + std::ptrdiff_t(begin), bvh_.order.begin() + std::ptrdiff_t(end));
      child.first = uint32_t(begin);
      child.count = uint32_t(end - begin);
      return child;
    }
    child.first = uint32_t(bvh_.nodes.size());
    bvh_.nodes.emplace_back();
    bvh_.depth = std::max(bvh_.depth, depth + 1);
    const size_t middle = isMixed ? start : begin + (end - begin) / 2;
    const BvhChild first = build(begin, middle, depth + 1), second = build(middle, end, depth + 1);
    bvh_.nodes[child.first] = {{first, second}};
    return child;
  }

  std::span<const Box> boxes_;
  KindStarts kinds_;  // and where the last one ends
  Bvh bvh_;
};

// Values of a scene's picture that depend on anything but the scene.
struct Differing {
  size_t pictures = 0, byDispatching = 0, byTree = 0, byRepeating = 0;
};

void addDiffering(const Scene& scene, const RenderSettings& settings, int repeats, Random& random,
                  Differing& differing) {
  const Image expected = test::renderShader(scene, settings);
  const auto render = [&](const Dispatching& dispatching) {
    ++differing.pictures;
    return differingValues(expected, test::renderer().render(test::kernel(), settings, {}, dispatching).image);
  };
  for (const Dispatching& dispatching :
       {Dispatching{.tile = 16}, Dispatching{.tile = 64}, Dispatching{.tile = 4096}, Dispatching{.workGroup = 8},
        Dispatching{.workGroup = 32}, Dispatching{.workGroup = 128}, Dispatching{.workGroup = 256},
        Dispatching{.tile = 24, .workGroup = 16, .budget = 100}})
    differing.byDispatching += render(dispatching);
  for (int i = 0; i < repeats; ++i) differing.byRepeating += render({});

  const PreparedGeometry prepared = prepareGeometry(roundScene(scene));
  const ShuffledTree shuffled(prepared.boxes, prepared.typeStarts(), random);
  for (const Bvh& bvh : {buildBvh(prepared.boxes, prepared.typeStarts()),
                         buildMedianBvh(prepared.boxes, prepared.typeStarts()), shuffled.bvh()})
    for (const TraversalStart cubes : {TraversalStart::lists, TraversalStart::wholeTree}) {
      test::renderer().upload(packScene(prepared, bvh, settings, cubes));
      differing.byTree += render({});
    }
}

// Squares and spheres that lie in the same place, in two colors: only the rule of ties tells which is seen.
Scene coincidentScene() {
  Scene scene;
  scene.background = {0.2, 0.3, 0.4};
  scene.camera = {.eye = {0.3, 0.4, 5}, .target = {0, 0, 0}};
  scene.lights = {{{1, 2, 9}}};
  scene.materials = {{.diffuse = {0.9, 0.1, 0.1}}, {.diffuse = {0.1, 0.1, 0.9}, .reflect = 0.5, .localWeight = 0.5}};
  for (uint32_t i = 0; i < 20; ++i) {
    scene.spheres.push_back({{-0.8, 0, 0}, 0.7, i % 3 == 0});
    scene.addTriangle({dvec3(0, -1, 0), dvec3(1.6, -1, 0.2), dvec3(0.1, 1, 0.4)}, i % 3 == 0);
  }
  return scene;
}

void measureDeterminism(const Bench& bench, Report& report) {
  Random random = bench.random(42);
  const bool full = bench.effort.full;
  Differing differing;
  std::vector<Scene> scenes = {coincidentScene(), test::ours("glass"), test::ours("mirrors")};
  if (full) scenes.push_back(test::ours("spot"));
  for (const Scene& scene : scenes) {
    RenderSettings settings = test::settingsOfHeight(scene, full ? 150 : 45);
    settings.samples = 2;
    settings.sampler = Sampler::jitter;
    settings.depth = std::min(settings.depth, 5);
    addDiffering(scene, settings, full ? 10 : 2, random, differing);
  }
  const std::string of = fmt::format("values that differ, of {} pictures: ", differing.pictures);
  report.atMost(of + "by tiles, work-groups and budgets", double(differing.byDispatching), 0);
  report.atMost(of + "by the tree: Embree's, medians, shuffled; with lists and without", double(differing.byTree), 0);
  report.atMost(of + "when repeated", double(differing.byRepeating), 0);
}

// The largest relative error of a constant picture's mean of 65,536 samples; naive: of a plain sum and a running mean.
void measureSums(Report& report) {
  double turner = 0, naive = 0;
  for (const float value : {0.1f, 0.3f, 0.7f}) {
    Scene scene;
    scene.background = dvec3(value);
    for (const float mean : test::renderShader(scene, test::settingsOf(scene, 4, 4, kMaxSamples)).rgb)
      turner = worse(std::abs(double(mean) / value - 1), turner);
    float sum = 0, running = 0;
    constexpr int kSamples = kMaxSamples * kMaxSamples;
    for (int i = 1; i <= kSamples; ++i) {
      sum += value;
      running += (value - running) / float(i);
    }
    naive = worse(std::abs(double(sum) / kSamples / value - 1), naive);
    naive = worse(std::abs(double(running) / value - 1), naive);
  }
  report.atMost("relative error of the mean of 65536 samples of 0.1, 0.3, 0.7", turner, 2e-7, naive);
}

// A straight edge across a picture of 48 x 48 pixels: dark below it, 1 above.
struct Edge {
  static constexpr int kSize = 48;
  dvec3 point, normal;  // in pixels from the picture's top left; the normal points to the bright side
  double unit = 2 * std::tan(22.5 * std::numbers::pi / 180) / kSize;  // of a pixel at the distance of 1

  explicit Edge(Random& random) : point(uniform(random, 18, 30), uniform(random, 18, 30), 0) {
    const double turn = uniform(random, 0, 2 * std::numbers::pi);
    normal = {std::cos(turn), std::sin(turn), 0};
  }
  bool isBright(double x, double y) const { return glm::dot(dvec3(x, y, 0) - point, normal) > 0; }

  // One large triangle in the plane z = -1.
  Scene scene() const {
    const auto place = [&](const dvec3& p) { return dvec3((p.x - kSize / 2) * unit, -(p.y - kSize / 2) * unit, -1); };
    const dvec3 along(-normal.y, normal.x, 0);
    const double far = 4 / unit;
    Scene scene;
    scene.background = dvec3(1);
    scene.camera = {.eye = {0, 0, 0}, .target = {0, 0, -1}};
    scene.materials = {Material{}};
    scene.addTriangle({place(point + far * along), place(point - far * along), place(point - far * normal)});
    return scene;
  }

  // The bright share of a pixel: the square clipped by the edge (Sutherland and Hodgman 1974), by the shoelace formula.
  double coverage(int px, int py) const {
    const dvec3 square[] = {{px, py, 0}, {px + 1, py, 0}, {px + 1, py + 1, 0}, {px, py + 1, 0}};
    std::vector<dvec3> clipped;
    for (int i = 0; i < 4; ++i) {
      const dvec3 &a = square[i], &b = square[(i + 1) % 4];
      const double da = glm::dot(a - point, normal), db = glm::dot(b - point, normal);
      if (da > 0) clipped.push_back(a);
      if ((da > 0) != (db > 0)) clipped.push_back(a + da / (da - db) * (b - a));
    }
    double area = 0;
    for (size_t i = 0; i < clipped.size(); ++i) area += glm::cross(clipped[i], clipped[(i + 1) % clipped.size()]).z / 2;
    return area;
  }
};

// The slope of a straight line through points, by least squares.
double slopeOf(const std::vector<double>& x, const std::vector<double>& y) {
  double meanX = 0, meanY = 0, xy = 0, xx = 0;
  for (size_t i = 0; i < x.size(); ++i) meanX += x[i] / double(x.size()), meanY += y[i] / double(x.size());
  for (size_t i = 0; i < x.size(); ++i) xy += (x[i] - meanX) * (y[i] - meanY), xx += (x[i] - meanX) * (x[i] - meanX);
  return xy / xx;
}

// How fast the error of pixels on a straight edge falls with the number of samples N: RMSE ~ N^slope. Jitter has -3/4
// (Mitchell 1996); samples anywhere in the pixel, in double, are the naive ones.
void measureEdgeSlope(const Bench& bench, Report& report) {
  Random random = bench.random(142);
  std::vector<double> logN, jittered, anywhere;
  std::vector<Edge> edges;
  for (int k = 0; k < (bench.effort.full ? 100 : 12); ++k) edges.emplace_back(random);
  for (int n = 2; n <= (bench.effort.full ? 32 : 16); n *= 2) {
    double squares = 0, naiveSquares = 0;
    size_t pixels = 0;
    for (const Edge& edge : edges) {
      RenderSettings settings = test::settingsOf(edge.scene(), Edge::kSize, Edge::kSize, n);
      settings.sampler = Sampler::jitter;
      settings.seed = uint32_t(random());
      const Image image = test::renderShader(edge.scene(), settings);
      for (int i = 0; i < Edge::kSize * Edge::kSize; ++i) {
        const int px = i % Edge::kSize, py = i / Edge::kSize;
        const double exact = edge.coverage(px, py);
        if (exact <= 0 || exact >= 1) continue;
        ++pixels;
        squares += std::pow(image.rgb[3 * size_t(i)] - exact, 2);
        int bright = 0;
        for (int s = 0; s < n * n; ++s) bright += edge.isBright(px + uniform(random, 0, 1), py + uniform(random, 0, 1));
        naiveSquares += std::pow(double(bright) / (n * n) - exact, 2);
      }
    }
    logN.push_back(std::log(n * n));
    jittered.push_back(std::log(squares / double(pixels)) / 2);
    anywhere.push_back(std::log(naiveSquares / double(pixels)) / 2);
  }
  const double slope = slopeOf(logN, jittered), naive = slopeOf(logN, anywhere);
  report.atMost("error on a straight edge ~ N^s, jittered: |s + 0.75|", std::abs(slope + 0.75), 0.05,
                std::abs(naive + 0.75), fmt::format("s = {:.3f}; of random samples {:.3f}", slope, naive));
}

void determinismAndSums(const Bench& bench, Report& report) {
  measureDeterminism(bench, report);
  measureSums(report);
  measureEdgeSlope(bench, report);
}

}  // namespace

std::vector<Case> determinismCases() {
  return {{42, "Determinism and sums", determinismAndSums}};
}

}  // namespace turner::hard
