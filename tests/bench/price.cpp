#include "bench/price.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <utility>

#include "accel/bvh.h"
#include "base/spread.h"
#include "bench/price_failures.h"
#include "geometry/prepared_geometry.h"
#include "geometry/round_scene.h"
#include "gpu/pack_scene.h"
#include "gpu/renderer.h"
#include "kernel/compile.h"
#include "support/json_file.h"
#include "support/shader_variant.h"

namespace turner::test {
namespace {

// ---- The switches ----

struct Switch {
  std::string name, without;  // what the variant does instead
  std::vector<Replacement> replacements = {};
  bool exactBoxes = false;
  bool (*matters)(const Features&);  // whether a scene's kernel has it at all
  std::vector<MeasureFailures> failures = {};
};

// Renames a function of the shader and includes another one of its name before what follows it.
std::vector<Replacement> replaceFunction(const std::string& file, const std::string& type, const std::string& function,
                                         const std::string& next, const std::string& naive) {
  return {
      {function, file, type + ' ' + function + '(', type + ' ' + function + "Robust("},
      {"the function behind " + function, file, next, "#include \"../tests/hard/kernels/" + naive + "\"\n\n" + next}};
}

// A feature that is compiled out: behind its declaration the name means false.
Replacement forceOff(const std::string& name) {
  return {name, "layout.h", "// --- blocks", "#ifndef __cplusplus\n#define " + name + " false\n#endif\n// --- blocks"};
}

bool always(const Features&) {
  return true;
}

std::vector<Switch> allSwitches() {
  const Replacement safeInverse{"safe inverse", "ray.glsl", "factors.inverse = 1.0 / safe;",
                                "factors.inverse = 1.0 / direction;"};
  const Replacement start{"start of a ray", "shade.glsl",
                          "surface.point + step * direction + (surface.errorBound - step * cosine) * away;",
                          "surface.point;"};
  const Replacement leaving{"what a ray leaves", "shade.glsl", "primitive | (inward ? kStartsInward : 0u)", "kRefNone"};
  const std::string numerics = "// Arithmetic where plain float32 is not enough.";
  const Replacement precise{"head of numerics", "float_float.glsl", numerics, "#define precise\n" + numerics};
  std::vector<Replacement> slabs =
      replaceFunction("traverse.glsl", "float", "enterBox", "vec3 planesAt(", "plain_slabs.glsl");
  slabs.push_back(safeInverse);
  return {
      {.name = "watertight edge test",
       .without = "Möller and Trumbore's",
       .replacements = replaceFunction("triangle.glsl", "Intersection", "intersectTrianglePair",
                                       "// The surface where a ray hits", "moeller_trumbore.glsl"),
       .matters = [](const Features& features) { return features.triangles; },
       .failures = {leaksOfIcosphere}},
      {.name = "widened slabs, padded boxes",
       .without = "plain slabs, exact boxes",
       .replacements = slabs,
       .exactBoxes = true,
       .matters = [](const Features& features) { return features.nearestNodes || features.shadowNodes; },
       .failures = {missesOfSoup}},
      {.name = "compensated spheres near the eye",
       .without = "the formulas of other spheres",
       .replacements = {forceOff("NEAR_SPHERES")},
       .matters = [](const Features& features) { return features.nearSpheres; },
       .failures = {wrongHorizon}},
      {.name = "compensated spheres far away",
       .without = "the formulas of other spheres",
       .replacements = {forceOff("FAR_SPHERES")},
       .matters = [](const Features& features) { return features.farSpheres; },
       .failures = {wrongSilhouette}},
      {.name = "start offset by its error bound",
       .without = "no offset",
       .replacements = {start},
       .matters = always,
       .failures = {falseSelfHits}},
      {.name = "exclusion of the primitive that a ray leaves",
       .without = "none is excluded",
       .replacements = {leaving},
       .matters = always,
       .failures = {falseSelfHits}},
      {.name = "offset and exclusion",
       .without = "neither",
       .replacements = {start, leaving},
       // With neither a ray would pass the same hidden wall for ever: the render ends with an error.
       .matters = [](const Features& features) { return !features.dielectrics; },
       .failures = {falseSelfHits}},
      {.name = "precise",
       .without = "left out",
       .replacements = {precise},
       .matters = always,
       .failures = {leaksOfIcosphere, wrongHorizon, wrongRefraction}},
      {.name = "Snell's law with twice the digits",
       .without = "in float",
       .replacements = replaceFunction("shade.glsl", "bool", "refracted", "bool transmission(", "plain_snell.glsl"),
       .matters = [](const Features& features) { return features.refraction; },
       .failures = {wrongRefraction}},
      {.name = "solids of glass in one another",
       .without = "a hit on the front enters from air",
       .replacements = {forceOff("NESTED_DIELECTRICS")},
       .matters = [](const Features& features) { return features.dielectrics; },
       .failures = {wrongInNestedGlass}},
      // How far two equal kernels come apart: what is nearer to 1 is noise.
      {.name = "nothing: a control", .without = "the same kernel", .matters = always},
  };
}

// ---- A kernel, with everything or without one thing ----

class Kernel {
 public:
  // `without` stays the caller's; none: everything is there.
  Kernel(const PriceSettings& settings, const Switch* without)
      : without_(without),
        sources_(without ? std::span<const Replacement>(without->replacements) : std::span<const Replacement>()),
        renderer_(settings.device, settings.access),
        spirv_(compileGlsl(sources_.folder() + "/shaders/whitted.comp", accessPreamble(renderer_.access()))) {}

  Features upload(const Scene& local, const RenderSettings& picture) {
    PreparedGeometry prepared = prepareGeometry(local);
    if (hasExactBoxes()) prepared.boxes = exactBoxes(prepared);
    const PackedScene packed = packScene(prepared, buildBvh(prepared.boxes, prepared.typeStarts()), picture);
    renderer_.upload(packed);
    return packed.features;
  }
  double traceSeconds(const RenderSettings& picture) { return renderer_.render(spirv_, picture).traceSeconds; }
  uint64_t rays(const RenderSettings& picture) { return renderer_.countVisits(spirv_, picture).rays.total(); }

  bool hasExactBoxes() const { return without_ && without_->exactBoxes; }
  std::string folder() const { return sources_.folder(); }

 private:
  const Switch* without_;
  ShaderVariant sources_;
  ShaderRenderer renderer_;
  Spirv spirv_;
};

// ---- What is measured ----

struct Cost {
  std::string scene;
  uint64_t rays = 0, raysWithout = 0;
  Spread seconds, secondsWithout, ratio;  // with over without
};

struct Removed {
  std::string what;
  double with = 0, without = 0;
};

struct Priced {
  std::string name, without;
  std::vector<Cost> costs;  // of the scenes whose kernels have it
  std::vector<Removed> removed;
};

Cost costOf(const std::string& scene, Kernel& with, Kernel& without, const PriceSettings& settings) {
  Cost cost{.scene = scene};
  cost.rays = with.rays(settings.picture);
  cost.raysWithout = without.rays(settings.picture);
  with.traceSeconds(settings.picture);  // warms up
  without.traceSeconds(settings.picture);
  std::vector<double> seconds, secondsWithout, ratios;
  for (int run = 0; run < settings.runs; ++run) {
    seconds.push_back(with.traceSeconds(settings.picture));
    secondsWithout.push_back(without.traceSeconds(settings.picture));
    ratios.push_back(seconds.back() / secondsWithout.back());
  }
  cost.seconds = spreadOf(seconds);
  cost.secondsWithout = spreadOf(secondsWithout);
  cost.ratio = spreadOf(ratios);
  return cost;
}

std::vector<Removed> removedBy(const Switch& means, const Kernel& without, hard::Kernels& robust,
                               const PriceSettings& settings) {
  hard::Kernels kernels(settings.device, without.folder());
  std::vector<Removed> removed;
  for (const MeasureFailures measure : means.failures) {
    const std::vector<Failures> with = measure({robust, robust, false, settings.rays});
    const std::vector<Failures> left = measure({kernels, robust, without.hasExactBoxes(), settings.rays});
    for (size_t i = 0; i < with.size(); ++i) removed.push_back({with[i].what, with[i].value, left[i].value});
  }
  return removed;
}

// ---- Tables ----

std::string shown(const Spread& ratio) {
  return fmt::format("{:.2f} ({:.2f}..{:.2f})", ratio.median, ratio.least, ratio.most);
}

// The geometric mean of the scenes' ratios, and where they lie.
std::string costsOf(const Priced& priced) {
  if (priced.costs.empty()) return "no scene here has it";
  double logarithms = 0;
  std::vector<double> ratios;
  for (const Cost& cost : priced.costs) {
    ratios.push_back(cost.ratio.median);
    logarithms += std::log(cost.ratio.median);
  }
  const Spread spread = spreadOf(ratios);
  return fmt::format("{:.2f} ({:.2f}..{:.2f})", std::exp(logarithms / double(ratios.size())), spread.least,
                     spread.most);
}

void printCost(const Cost& cost, const std::string& name) {
  fmt::print("| {} | {} | {:.4f} | {:.4f} | {} | {:+.2f} % |\n", name, cost.scene, cost.seconds.median,
             cost.secondsWithout.median, shown(cost.ratio),
             100 * (double(cost.raysWithout) / double(std::max<uint64_t>(1, cost.rays)) - 1));
  std::fflush(stdout);
}

void printSummary(const std::vector<Priced>& all) {
  fmt::print(
      "\n| means | instead | trace time with/without, geometric mean (scenes) | failures | with | without |\n"
      "| --- | --- | --- | --- | ---: | ---: |\n");
  for (const Priced& priced : all) {
    std::string lead = fmt::format("| {} | {} | {} |", priced.name, priced.without, costsOf(priced));
    if (priced.removed.empty()) fmt::print("{} | | |\n", lead);
    for (const Removed& removed : priced.removed) {
      fmt::print("{} {} | {:.3g} | {:.3g} |\n", lead, removed.what, removed.with, removed.without);
      lead = "| | | |";
    }
  }
}

std::string priceJson(const std::vector<Priced>& all, const PriceSettings& settings) {
  JsonFile json;
  json.object(nullptr, [&] {
    json.put("device", settings.device.name);
    json.put("driver", settings.device.driver);
    json.put("runs", uint64_t(settings.runs));
    json.put("rays", uint64_t(settings.rays));
    json.array("switches", [&] {
      for (const Priced& priced : all)
        json.object(nullptr, [&] {
          json.put("name", priced.name);
          json.put("instead", priced.without);
          json.array("scenes", [&] {
            for (const Cost& cost : priced.costs)
              json.object(nullptr, [&] {
                json.put("scene", cost.scene);
                json.put("rays", cost.rays);
                json.put("rays_without", cost.raysWithout);
                json.put("seconds", cost.seconds);
                json.put("seconds_without", cost.secondsWithout);
                json.put("ratio", cost.ratio);
              });
          });
          json.array("failures", [&] {
            for (const Removed& removed : priced.removed)
              json.object(nullptr, [&] {
                json.put("what", removed.what);
                json.put("with", removed.with);
                json.put("without", removed.without);
              });
          });
        });
    });
  });
  return json.text();
}

// Five balls of radius 1 around a point, one a mirror and one of glass.
void addBalls(Scene& scene, const glm::dvec3& middle) {
  const uint32_t first = uint32_t(scene.materials.size());
  scene.materials.push_back({.name = "matte", .diffuse = {0.7, 0.4, 0.3}, .localWeight = 1});
  scene.materials.push_back({.name = "mirror", .diffuse = {0.1, 0.1, 0.1}, .reflect = 0.8, .localWeight = 0.2});
  scene.materials.push_back({.name = "glass", .reflect = 0.1, .transmit = 0.9, .localWeight = 0});
  for (int i = 0; i < 5; ++i)
    scene.spheres.push_back({middle + glm::dvec3(2.2 * (i - 2), 0, i % 2 ? -2.0 : 0.0), 1, first + uint32_t(i % 3)});
}

}  // namespace

std::vector<PricedScene> extremeScenes() {
  Scene ground;
  ground.background = {0.4, 0.5, 0.65};
  ground.materials = {{.name = "ground", .diffuse = {0.5, 0.5, 0.4}}};
  ground.spheres = {{{0, -1e6, 0}, 1e6, 0}};
  addBalls(ground, {0, 1, -8});
  ground.camera = {.eye = {0, 1.5, 0}, .target = {0, 1, -8}, .fov = 60};
  ground.lights = {{.position = {-6, 12, 0}}};

  Scene far;
  far.background = {0.4, 0.5, 0.65};
  addBalls(far, {0, 0, 0});
  far.camera = {.eye = {0, 1000, 4900}, .target = {0, 0, 0}, .fov = 0.14};
  far.lights = {{.position = {-6, 12, 8}}};

  Scene nested;
  nested.background = {0.4, 0.5, 0.65};
  nested.materials = {{.name = "glass", .reflect = 0.1, .transmit = 0.9, .localWeight = 0},
                      {.name = "water", .reflect = 0.05, .transmit = 0.95, .eta = 1.333, .localWeight = 0},
                      {.name = "ground", .diffuse = {0.5, 0.5, 0.4}}};
  for (int i = 0; i < 5; ++i)
    for (const double radius : {1.0, 0.8})
      nested.spheres.push_back({glm::dvec3(2.2 * (i - 2), 1, i % 2 ? -2.0 : 0.0), radius, radius < 1 ? 1u : 0u});
  nested.spheres.push_back({{0, -100, 0}, 100, 2});
  nested.camera = {.eye = {0, 3, 11}, .target = {0, 1, 0}, .fov = 50};
  nested.lights = {{.position = {-6, 12, 8}}};
  return {{"ground sphere", ground}, {"far balls", far}, {"glass in glass", nested}};
}

std::string price(const std::vector<PricedScene>& scenes, const PriceSettings& settings) {
  const std::vector<Switch> switches = allSwitches();
  Kernel everything(settings, nullptr);
  std::vector<std::unique_ptr<Kernel>> kernels;
  std::vector<Priced> all;
  for (const Switch& means : switches) {
    kernels.push_back(std::make_unique<Kernel>(settings, &means));
    all.push_back({.name = means.name, .without = means.without});
  }

  fmt::print(
      "| means | scene | with, s | without, s | with/without | rays without |\n"
      "| --- | --- | ---: | ---: | ---: | ---: |\n");
  for (const PricedScene& scene : scenes) {
    const Scene local = roundScene(scene.scene);
    checkReach(local);
    const Features features = everything.upload(local, settings.picture);
    for (size_t i = 0; i < switches.size(); ++i) {
      if (!switches[i].matters(features)) continue;
      kernels[i]->upload(local, settings.picture);
      all[i].costs.push_back(costOf(scene.name, everything, *kernels[i], settings));
      printCost(all[i].costs.back(), all[i].name);
    }
  }
  hard::Kernels robust(settings.device, everything.folder());
  for (size_t i = 0; i < switches.size(); ++i) all[i].removed = removedBy(switches[i], *kernels[i], robust, settings);
  printSummary(all);
  return priceJson(all, settings);
}

}  // namespace turner::test
