// A developer's program, not a test: how fast Turner is beside its peers. In one run, in turn, on the same scene with
// the same rays and shading: Turner's kernel on a Vulkan device, an Embree-based Whitted tracer on all cores, and with
// --povray POV-Ray. Before any clock runs, the pictures and ray counts of the first two must agree, else the run fails.
// Prints a Markdown table, row by row; --json writes every figure.
// usage: turner_bench [SCENE...] [options]      turner_bench --price [SCENE...] [options]
//        turner_bench --write-obj FILE --triangles N
#include <fmt/format.h>
#include <sys/wait.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <map>
#include <optional>
#include <thread>

#include "accel/bvh.h"
#include "base/errors.h"
#include "base/output_file.h"
#include "base/spread.h"
#include "base/text_file.h"
#include "bench/embree_tracer.h"
#include "bench/price.h"
#include "geometry/round_scene.h"
#include "gpu/devices.h"
#include "gpu/pack_scene.h"
#include "gpu/renderer.h"
#include "kernel/compile.h"
#include "scene/obj/mesh_obj.h"
#include "scene/scene_load.h"
#include "support/agreement.h"
#include "support/bumpy_spheres.h"
#include "support/json_file.h"
#include "support/our_scenes.h"
#include "support/temporary_folder.h"

namespace turner::test {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kDepth = 5;  // levels of the ray tree, as in POV-Ray and the SPD rules

double secondsSince(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

// ---- What is measured ----

// What the kernel did, by its counters.
struct KernelWork {
  struct PerRay {
    double nodes = 0, primitives = 0;  // visited, tested
  };
  PerRay eye, reflected, refracted, shadow;
  std::optional<double> rooflineShare;  // of the device's peak float32 arithmetic, in [0, 1]
};

// Arithmetic of a visit to a node and of a test of a primitive, in floating-point operations. Counted in the shader.
constexpr double kNodeFlop = 46, kPrimitiveFlop = 55;

// The peak of a device in FLOP/s. Of a CPU under lavapipe: eight lanes, each with a multiplication and an addition in a
// clock, and the clock is the one that the kernel states. Others must be told by --peak-gflops.
std::optional<double> peakFlops(const DeviceInfo& device, double toldGflops) {
  if (toldGflops > 0) return 1e9 * toldGflops;
  if (device.type != "CPU") return {};
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);)
    if (line.starts_with("cpu MHz"))
      return 16e6 * std::strtod(line.c_str() + line.find(':') + 1, nullptr) * std::thread::hardware_concurrency();
  return {};
}

KernelWork workOf(const Visits& visits) {
  const auto perRay = [&](uint64_t RayCounts::*kind) {
    const double rays = double(std::max<uint64_t>(1, visits.rays.*kind));
    return KernelWork::PerRay{double(visits.nodes.*kind) / rays, double(visits.primitives.*kind) / rays};
  };
  return {perRay(&RayCounts::eye),
          perRay(&RayCounts::reflected),
          perRay(&RayCounts::refracted),
          perRay(&RayCounts::shadow),
          {}};
}

struct PovRay {
  std::optional<double> seconds;  // of tracing alone, on all cores
  std::string clock;              // whose seconds these are; or why there are none
};

struct Measurement {
  std::string scene;
  int width = 0, height = 0;
  PrimitiveCounts primitives;
  size_t primitiveCount = 0;
  std::string refused;  // why Turner did not take the scene; then nothing below is set
  RayCounts turnerRays, embreeRays;
  std::vector<std::string> disagreements;
  double badPixels = 0;
  std::vector<double> turnerSeconds, embreeSeconds;  // of the runs, in turn
  Spread turnerMrays, embreeMrays, ratio;
  double buildSeconds = 0, commitSeconds = 0;
  double bytesPerPrimitive = 0, embreeBytesPerPrimitive = 0;
  PovRay povray;
  KernelWork work;
  std::optional<Spread>
      everythingRatio;  // trace time of the kernel with everything compiled in over that of the scene's own
};

struct Options {
  std::vector<std::string> scenes;
  int runs = 5;
  std::string device, json, writeObj;
  BufferAccess access = BufferAccess::automatic;
  double peakGflops = 0;  // 0: not told
  bool povray = false, everything = false, price = false;
  size_t priceRays = 1'000'000;
  size_t maxTriangles = 1'000'000, triangles = 1'000'000;
  int width = 0, height = 0;  // 0: the scene's own
};

// ---- Turner: the only place that names the steps from a scene to its picture ----

class TurnerSide {
 public:
  // `everything`: a kernel with all features compiled in, whatever the scene needs.
  TurnerSide(const DeviceInfo& device, BufferAccess access, bool everything = false)
      : device_(device), renderer_(device, access), everything_(everything) {}
  const DeviceInfo& device() const { return device_; }
  BufferAccess access() const { return renderer_.access(); }

  struct Built {
    double seconds = 0;  // of prepareGeometry, buildBvh and packScene
    size_t bytes = 0;    // on the device
  };
  // Throws InputError when the device cannot take the scene.
  Built build(Scene local, const RenderSettings& settings) {
    const Clock::time_point start = Clock::now();
    const PreparedGeometry prepared = prepareGeometry(std::move(local));
    PackedScene packed = packScene(prepared, buildBvh(prepared.boxes, prepared.typeStarts()), settings,
                                   everything_ ? TraversalStart::mixedLists : TraversalStart::lists);
    if (everything_) packed.features = everyFeature(packed.features.lights);
    const Built built{secondsSince(start), packed.bytes()};
    renderer_.upload(packed);
    return built;
  }
  ShaderPicture render(const RenderSettings& settings) { return renderer_.render(kernel_, settings); }
  Visits countVisits(const RenderSettings& settings) { return renderer_.countVisits(kernel_, settings); }

 private:
  DeviceInfo device_;
  ShaderRenderer renderer_;
  bool everything_;
  Spirv kernel_ = compileGlsl(TURNER_SHADERS_DIR "/whitted.comp", accessPreamble(renderer_.access()));
};

// ---- Scenes ----

struct BenchScene {
  std::string name;
  std::string file;  // empty: procedural
  size_t triangles = 0;
  int width = 512, height = 512;
};

std::vector<BenchScene> defaultScenes(size_t maxTriangles) {
  std::vector<BenchScene> scenes;
  const auto addFile = [&](const std::filesystem::path& path) {
    scenes.push_back({path.filename().string(), path.string()});
  };
  const std::filesystem::path ours = TURNER_SCENES_DIR;
  for (const char* name : {"balls", "gears", "mount", "rings", "teapot"})
    addFile(ours / "spd" / (std::string(name) + ".nff"));
  addFile(ours / "spot.obj");
  addFile(TURNER_BENCH_DIR "/meshes/stanford-bunny.obj");
  // The peer computes in float32 as it comes, and knows no solids: over the planet and in nested glass it sees
  // something else.
  for (const std::string& name : test::ourScenesBut({"planet", "nested_glass"})) addFile(ours / (name + ".json"));
  for (size_t triangles = 1000; triangles <= maxTriangles; triangles *= 10)
    scenes.push_back({fmt::format("bumpy-{}", triangles), "", triangles, 1024, 768});
  return scenes;
}

// The scenes that the user names: by file name, with or without extension, or by path.
std::vector<BenchScene> chooseScenes(const Options& options) {
  std::vector<BenchScene> known = defaultScenes(options.scenes.empty() ? options.maxTriangles : 10'000'000);
  if (options.scenes.empty()) return known;
  std::vector<BenchScene> chosen;
  for (const std::string& wanted : options.scenes) {
    const size_t before = chosen.size();
    for (const BenchScene& scene : known)
      if (wanted == scene.name || wanted == std::filesystem::path(scene.name).stem()) chosen.push_back(scene);
    if (chosen.size() > before) continue;
    if (!std::filesystem::is_regular_file(wanted)) {
      std::string names;
      for (const BenchScene& scene : known) names += ' ' + scene.name;
      throw InputError("there is no scene '" + wanted + "'; name a .json, .nff or .obj file, or one of:" + names);
    }
    chosen.push_back({std::filesystem::path(wanted).filename().string(), wanted});
  }
  return chosen;
}

// A mesh on a floor before a camera, under one light.
Scene sceneAroundMesh(const std::string& path) {
  Mesh mesh = parseObj(path, readTextFile(path));
  if (mesh.faces.empty()) throw InputError(path + " has no faces");
  Scene scene;
  scene.background = {0.4, 0.5, 0.65};
  scene.materials = {{.name = "floor", .diffuse = {0.6, 0.58, 0.54}},
                     {.name = "mesh", .diffuse = {0.7, 0.62, 0.5}, .specular = {0.2, 0.2, 0.2}, .shininess = 30}};
  glm::dvec3 lo(INFINITY), hi(-INFINITY);
  for (const Mesh::Face& face : mesh.faces) {
    for (const uint32_t vertex : face.vertices) {
      lo = glm::min(lo, mesh.positions[vertex]);
      hi = glm::max(hi, mesh.positions[vertex]);
    }
    scene.triangles.push_back({face.vertices, face.normals, 1});
  }
  scene.positions = std::move(mesh.positions);
  scene.normals = std::move(mesh.normals);
  const glm::dvec3 middle = 0.5 * (lo + hi);
  const double size = glm::length(hi - lo);
  const glm::dvec3 a(middle.x - 3 * size, lo.y, middle.z + 3 * size), b(middle.x + 3 * size, lo.y, middle.z + 3 * size);
  const glm::dvec3 c(middle.x + 3 * size, lo.y, middle.z - 3 * size), d(middle.x - 3 * size, lo.y, middle.z - 3 * size);
  scene.addTriangle({a, b, c}, 0);
  scene.addTriangle({a, c, d}, 0);
  scene.camera = {.eye = middle + size * glm::dvec3(0.5, 0.6, 1.6), .target = middle, .fov = 35};
  scene.lights = {{.position = middle + size * glm::dvec3(-1.5, 3, 2)}};
  return scene;
}

Scene makeScene(const BenchScene& scene) {
  if (scene.file.empty()) return bumpySpheres(scene.triangles);
  if (std::filesystem::path(scene.file).extension() == ".obj") return sceneAroundMesh(scene.file);
  return loadScene(scene.file);
}

// ---- POV-Ray ----

std::string quoted(const std::string& text) {
  std::string result = "'";
  for (const char c : text) result += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return result + "'";
}

// Runs a shell command; its output and exit code.
std::pair<std::string, int> outputOf(const std::string& command) {
  FILE* pipe = popen((command + " 2>&1").c_str(), "r");
  if (!pipe) throw RunError("cannot start a shell: popen failed");
  std::string text;
  std::array<char, 4096> part;
  for (size_t n; (n = fread(part.data(), 1, part.size(), pipe)) > 0;) text.append(part.data(), n);
  const int status = pclose(pipe);
  return {text, WIFEXITED(status) ? WEXITSTATUS(status) : 1};
}

// "Trace Time: 0 hours 0 minutes 1 seconds (1.234 seconds)": the number in brackets.
std::optional<double> traceTimeOf(const std::string& statistics) {
  const size_t line = statistics.find("Trace Time:");
  if (line == std::string::npos) return {};
  const size_t open = statistics.find('(', line), end = statistics.find('\n', line);
  if (open == std::string::npos || open > end) return {};
  return std::strtod(statistics.c_str() + open + 1, nullptr);
}

PovRay measurePovRay(const BenchScene& scene, const RenderSettings& settings, int runs) {
  const std::filesystem::path converter = TURNER_BENCH_DIR "/nff_to_pov.py";
  if (std::filesystem::path(scene.file).extension() != ".nff") return {{}, "not an NFF scene"};
  if (outputOf("command -v povray").second != 0) return {{}, "POV-Ray is not installed"};
  const TemporaryFolder folder;
  const std::string source = (folder.path / "scene.pov").string();
  const auto [complaint, converted] = outputOf(fmt::format("python3 {} {} {} > {}", quoted(converter.string()),
                                                           quoted(scene.file), settings.depth, quoted(source)));
  if (converted != 0) throw RunError("nff_to_pov.py failed on " + scene.file + ":\n" + complaint);
  // The median of as many runs as the others get. All tell their time in the same way.
  std::vector<double> seconds;
  bool itsOwnClock = true;
  for (int run = 0; run < runs; ++run) {
    const Clock::time_point start = Clock::now();
    const auto [statistics, failed] =
        outputOf(fmt::format("povray +I{} +O{} +W{} +H{} -A -D +FN", quoted(source),
                             quoted((folder.path / "picture.png").string()), settings.width, settings.height));
    const double wall = secondsSince(start);
    if (failed != 0) throw RunError("POV-Ray failed on " + scene.file + ":\n" + statistics);
    const std::optional<double> trace = traceTimeOf(statistics);
    itsOwnClock = trace.has_value();
    seconds.push_back(trace.value_or(wall));
  }
  return {spreadOf(seconds).median, itsOwnClock ? "POV-Ray's own trace time" : "wall time of POV-Ray's process"};
}

// ---- One scene ----

double mrays(const RayCounts& rays, double seconds) {
  return double(rays.total()) / seconds * 1e-6;
}

Measurement measureScene(const BenchScene& chosen, const Options& options, TurnerSide& turner, TurnerSide* general) {
  Measurement m;
  m.scene = chosen.name;
  const Scene local = [&] {
    const Scene scene = makeScene(chosen);
    return roundScene(scene);
  }();
  checkReach(local);
  m.primitives = local.primitiveCounts();
  m.primitiveCount = local.primitiveCount();
  RenderSettings settings;
  settings.width = m.width = options.width > 0 ? options.width : chosen.width;
  settings.height = m.height = options.height > 0 ? options.height : chosen.height;
  settings.crop = {0, 0, settings.width, settings.height};
  settings.depth = kDepth;

  const double primitives = double(std::max<size_t>(1, m.primitiveCount));
  try {
    const TurnerSide::Built built = turner.build(local, settings);
    m.buildSeconds = built.seconds;
    m.bytesPerPrimitive = double(built.bytes) / primitives;
  } catch (const InputError& error) {
    m.refused = error.what();
    return m;
  }
  const EmbreeTracer embree(local);
  m.commitSeconds = embree.commitSeconds();
  m.embreeBytesPerPrimitive = double(embree.bytes()) / primitives;

  // Verify, then time. This is also the warm-up.
  Visits visits;
  {
    const Image image = turner.render(settings).image;
    visits = turner.countVisits(settings);
    m.turnerRays = visits.rays;
    m.work = workOf(visits);
    const EmbreePicture peer = embree.render(settings);
    m.embreeRays = peer.rays;
    m.badPixels = badPixels(image, peer.image);
    m.disagreements = disagreements({image, m.turnerRays}, {peer.image, peer.rays});
  }
  std::vector<double> turnerMrays, embreeMrays, ratios;
  for (int run = 0; run < options.runs; ++run) {
    m.turnerSeconds.push_back(turner.render(settings).traceSeconds);
    m.embreeSeconds.push_back(embree.render(settings).traceSeconds);
    turnerMrays.push_back(mrays(m.turnerRays, m.turnerSeconds.back()));
    embreeMrays.push_back(mrays(m.embreeRays, m.embreeSeconds.back()));
    ratios.push_back(turnerMrays.back() / embreeMrays.back());
  }
  m.turnerMrays = spreadOf(turnerMrays);
  m.embreeMrays = spreadOf(embreeMrays);
  m.ratio = spreadOf(ratios);
  if (const std::optional<double> peak = peakFlops(turner.device(), options.peakGflops))
    m.work.rooflineShare =
        (kNodeFlop * double(visits.nodes.total()) + kPrimitiveFlop * double(visits.primitives.total())) /
        (spreadOf(m.turnerSeconds).median * *peak);
  if (general) {
    general->build(local, settings);
    general->render(settings);
    std::vector<double> everythingRatios;
    for (int run = 0; run < options.runs; ++run) {
      const double own = turner.render(settings).traceSeconds;
      everythingRatios.push_back(general->render(settings).traceSeconds / own);
    }
    m.everythingRatio = spreadOf(everythingRatios);
  }
  if (options.povray) m.povray = measurePovRay(chosen, settings, options.runs);
  return m;
}

double povrayRatio(const Measurement& m) {
  return *m.povray.seconds / spreadOf(m.turnerSeconds).median;
}

// ---- The table ----

void printHead(bool povray) {
  fmt::print(
      "| scene | primitives | eye | reflected | refracted | shadow | Turner, Mray/s | Embree, Mray/s | Turner/Embree | "
      "build, s | commit, s | bytes/primitive | nodes, primitives per eye ray | reflected | refracted | shadow | "
      "roofline |"
      "{}\n",
      povray ? " POV-Ray, s | POV-Ray/Turner |" : "");
  fmt::print("| --- |{}\n", [&] {
    std::string columns;
    for (int i = 0; i < (povray ? 18 : 16); ++i) columns += " ---: |";
    return columns;
  }());
}

void printRow(const Measurement& m, bool povray) {
  if (!m.refused.empty()) {
    fmt::print("| {} | {} | does not fit: {} |\n", m.scene, m.primitiveCount, m.refused);
  } else {
    const RayCounts& rays = m.turnerRays;
    fmt::print("| {} | {} | {} | {} | {} | {} | {:.2f} | {:.2f} | {:.2f} ({:.2f}..{:.2f}) | {:.3f} | {:.3f} | {:.0f} |",
               m.scene, m.primitiveCount, rays.eye, rays.reflected, rays.refracted, rays.shadow, m.turnerMrays.median,
               m.embreeMrays.median, m.ratio.median, m.ratio.least, m.ratio.most, m.buildSeconds, m.commitSeconds,
               m.bytesPerPrimitive);
    for (const KernelWork::PerRay& work : {m.work.eye, m.work.reflected, m.work.refracted, m.work.shadow})
      fmt::print(" {:.1f}, {:.1f} |", work.nodes, work.primitives);
    fmt::print(" {} |", m.work.rooflineShare ? fmt::format("{:.1f} %", 100 * *m.work.rooflineShare) : "");
    if (povray && m.povray.seconds)
      fmt::print(" {:.3f} | {:.1f} |", *m.povray.seconds, povrayRatio(m));
    else if (povray)
      fmt::print(" {} | |", m.povray.clock);
    fmt::print("\n");
  }
  std::fflush(stdout);
}

struct Summary {
  size_t scenes = 0;
  double geometricMean = 0, least = INFINITY;
  std::string leastScene;
};

Summary summarise(const std::vector<Measurement>& measurements) {
  Summary summary;
  double logarithms = 0;
  for (const Measurement& m : measurements) {
    if (!m.refused.empty()) continue;
    ++summary.scenes;
    logarithms += std::log(m.ratio.median);
    if (m.ratio.median >= summary.least) continue;
    summary.least = m.ratio.median;
    summary.leastScene = m.scene;
  }
  if (summary.scenes > 0) summary.geometricMean = std::exp(logarithms / double(summary.scenes));
  return summary;
}

std::string cpuModel() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);)
    if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
  return "unknown";
}

// ---- JSON ----

void writeMeasurement(JsonFile& json, const Measurement& m) {
  json.put("scene", m.scene);
  json.put("width", uint64_t(m.width));
  json.put("height", uint64_t(m.height));
  for (const PrimitiveCount& type : m.primitives) json.put(type.name.c_str(), type.count);
  if (!m.refused.empty()) return json.put("does_not_fit", m.refused);
  json.put("rays", m.turnerRays);
  json.put("embree_rays", m.embreeRays);
  json.put("bad_pixels", m.badPixels);
  json.put("disagreements", m.disagreements);
  json.put("turner_seconds", m.turnerSeconds);
  json.put("embree_seconds", m.embreeSeconds);
  json.put("turner_mrays_per_second", m.turnerMrays);
  json.put("embree_mrays_per_second", m.embreeMrays);
  json.put("ratio", m.ratio);
  json.put("build_seconds", m.buildSeconds);
  json.put("embree_commit_seconds", m.commitSeconds);
  json.put("bytes_per_primitive", m.bytesPerPrimitive);
  json.put("embree_bytes_per_primitive", m.embreeBytesPerPrimitive);
  json.object("work_per_ray", [&] {
    const auto put = [&](const char* kind, const KernelWork::PerRay& work) {
      json.object(kind, [&] {
        json.put("nodes", work.nodes);
        json.put("primitives", work.primitives);
      });
    };
    put("eye", m.work.eye);
    put("reflected", m.work.reflected);
    put("refracted", m.work.refracted);
    put("shadow", m.work.shadow);
  });
  json.put("roofline_share", m.work.rooflineShare);
  json.put("everything_ratio", m.everythingRatio ? std::optional(m.everythingRatio->median) : std::nullopt);
  json.put("povray_seconds", m.povray.seconds);
  json.put("povray_clock", m.povray.clock);
  json.put("povray_ratio", m.povray.seconds ? std::optional(povrayRatio(m)) : std::nullopt);
}

std::string benchJson(const std::vector<Measurement>& measurements, const Summary& summary, const DeviceInfo& device,
                      const std::string& access, int runs) {
  JsonFile json;
  json.object(nullptr, [&] {
    json.put("device", device.name);
    json.put("fetch", access);
    json.put("driver", device.driver);
    json.put("cpu", cpuModel());
    json.put("embree", embreeVersion());
    json.put("runs", uint64_t(runs));
    json.put("depth", uint64_t(kDepth));
    json.array("scenes", [&] {
      for (const Measurement& m : measurements) json.object(nullptr, [&] { writeMeasurement(json, m); });
    });
    if (summary.scenes == 0) return;
    json.put("geometric_mean", summary.geometricMean);
    json.put("minimum", summary.least);
    json.put("minimum_scene", summary.leastScene);
  });
  return json.text();
}

// ---- The program ----

DeviceInfo wantedDevice(const Options& options) {
  const char* environment = std::getenv("TURNER_DEVICE");
  return chooseDevice(listDevices(), !options.device.empty() ? options.device : environment ? environment : "");
}

// The scenes that --price measures if none are named.
std::vector<BenchScene> defaultPriceScenes() {
  std::vector<BenchScene> scenes;
  for (const BenchScene& scene : defaultScenes(0))
    for (const char* name : {"spheres.json", "glass.json", "spot.json", "balls.nff", "gears.nff", "teapot.nff"})
      if (scene.name == name) scenes.push_back(scene);
  return scenes;
}

int priceOfRobustness(const Options& options) {
  if (!options.json.empty()) checkWritable(options.json);
  std::vector<PricedScene> scenes;
  for (const BenchScene& scene : options.scenes.empty() ? defaultPriceScenes() : chooseScenes(options))
    scenes.push_back({scene.name, makeScene(scene)});
  if (options.scenes.empty())
    for (PricedScene& scene : extremeScenes()) scenes.push_back(std::move(scene));
  RenderSettings picture;
  picture.width = options.width > 0 ? options.width : 512;
  picture.height = options.height > 0 ? options.height : 512;
  picture.crop = {0, 0, picture.width, picture.height};
  picture.depth = kDepth;
  const DeviceInfo device = wantedDevice(options);
  fmt::print("device: {} ({})\nCPU: {}\n{} interleaved runs at {} x {}, depth {}\n\n", device.name, device.driver,
             cpuModel(), options.runs, picture.width, picture.height, kDepth);
  const std::string json = price(scenes, {device, options.access, picture, options.runs, options.priceRays});
  if (!options.json.empty()) writeWholeFile(options.json, json);
  return 0;
}

int bench(const Options& options) {
  if (!options.json.empty()) checkWritable(options.json);
  const std::vector<BenchScene> scenes = chooseScenes(options);
  const DeviceInfo device = wantedDevice(options);
  TurnerSide turner(device, options.access);
  fmt::print("device: {} ({}), fetching {}\nCPU: {}\nEmbree {}\n{} interleaved runs, depth {}\n\n", device.name,
             device.driver, accessName(turner.access()), cpuModel(), embreeVersion(), options.runs, kDepth);
  printHead(options.povray);

  std::optional<TurnerSide> general;
  if (options.everything) general.emplace(device, options.access, true);
  std::vector<Measurement> measurements;
  bool agree = true;
  for (const BenchScene& scene : scenes) {
    measurements.push_back(measureScene(scene, options, turner, general ? &*general : nullptr));
    const Measurement& m = measurements.back();
    printRow(m, options.povray);
    for (const std::string& sentence : m.disagreements) fmt::print(stderr, "{}: {}\n", m.scene, sentence);
    agree = agree && m.disagreements.empty();
  }
  if (options.everything) {
    fmt::print(
        "\nTrace time with everything compiled in, over that of the kernel that is specialised to the scene:\n\n");
    fmt::print("| scene | everything / specialised |\n| --- | ---: |\n");
    for (const Measurement& m : measurements)
      if (m.everythingRatio)
        fmt::print("| {} | {:.2f} ({:.2f}..{:.2f}) |\n", m.scene, m.everythingRatio->median, m.everythingRatio->least,
                   m.everythingRatio->most);
  }
  const Summary summary = summarise(measurements);
  if (summary.scenes > 0)
    fmt::print("\nTurner/Embree: geometric mean {:.3f}, minimum {:.3f} ({})\n", summary.geometricMean, summary.least,
               summary.leastScene);
  for (const Measurement& m : measurements)
    if (m.povray.seconds) fmt::print("POV-Ray on {}: {}\n", m.scene, m.povray.clock);
  if (!options.json.empty())
    writeWholeFile(options.json, benchJson(measurements, summary, device, accessName(turner.access()), options.runs));
  if (!agree) throw RunError("the two tracers have not done the same work: see above");
  return 0;
}

int run(int argc, char** argv) {
  Options options;
  CLI::App app("Measures Turner beside Embree, and with --povray beside POV-Ray.", "turner_bench");
  app.add_option("SCENE", options.scenes, "Names of the default scenes, or .json, .nff or .obj files (default: all)");
  app.add_option("--runs", options.runs, "Timed runs of each tracer")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  app.add_option("--device", options.device, "Vulkan device: index, or part of its name");
  app.add_option("--fetch", options.access,
                 "How the kernel fetches: texels, buffers or addresses (default: the device's)")
      ->transform(
          CLI::CheckedTransformer(std::map<std::string, BufferAccess>{{"texels", BufferAccess::texelBuffer},
                                                                      {"buffers", BufferAccess::storageBuffer},
                                                                      {"addresses", BufferAccess::deviceAddress}}));
  app.add_option("--peak-gflops", options.peakGflops, "The device's peak float32 arithmetic, for the roofline");
  app.add_option("--json", options.json, "File for all figures");
  app.add_flag("--povray", options.povray, "Measure POV-Ray too, on NFF scenes");
  app.add_flag("--everything", options.everything, "Measure the kernel with everything compiled in, too");
  app.add_flag("--price", options.price,
               "Measure instead what each means of robustness costs, and which failures it removes");
  app.add_option("--price-rays", options.priceRays, "Rays of each measurement of failures")
      ->check(CLI::Range(size_t(1000), size_t(100'000'000)))
      ->capture_default_str();
  app.add_option("--max-triangles", options.maxTriangles, "Bounds the procedural meshes")->capture_default_str();
  app.add_option("--width", options.width, "Of the pictures (default: 512; procedural 1024)")
      ->check(CLI::Range(1, kMaxSize));
  app.add_option("--height", options.height, "Of the pictures (default: 512; procedural 768)")
      ->check(CLI::Range(1, kMaxSize));
  app.add_option("--write-obj", options.writeObj, "Only write a procedural mesh to this file");
  app.add_option("--triangles", options.triangles, "Of the mesh for --write-obj")
      ->check(CLI::Range(size_t(1), size_t(100'000'000)))
      ->capture_default_str();
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  if (options.price) return priceOfRobustness(options);
  if (options.writeObj.empty()) return bench(options);
  writeBumpyObj(options.writeObj, options.triangles);
  return 0;
}

}  // namespace
}  // namespace turner::test

int main(int argc, char** argv) {
  try {
    return turner::test::run(argc, argv);
  } catch (const turner::InputError& error) {
    fmt::print(stderr, "turner_bench: {}\n", error.what());
    return 2;
  } catch (const std::exception& error) {
    fmt::print(stderr, "turner_bench: {}\n", error.what());
    return 1;
  }
}
