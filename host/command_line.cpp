#include "command_line.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cctype>
#include <map>

#include "errors.h"
#include "faults.h"
#include "number.h"

namespace turner {
namespace {

void addRenderOptions(CLI::App& command, RenderOptions& options) {
  command.add_option("--width", options.width, "Width of the picture in pixels (default: the scene's)")
      ->check(CLI::Range(1, kMaxSize));
  command.add_option("--height", options.height, "Height of the picture in pixels (default: the scene's)")
      ->check(CLI::Range(1, kMaxSize));
  command.add_option("--samples", options.samples, "n of the n x n samples in each pixel")
      ->check(CLI::Range(1, kMaxSamples))
      ->capture_default_str();
  command.add_option("--depth", options.depth, "Levels of the ray tree; the eye ray is level 1 (default: the scene's)")
      ->check(CLI::Range(1, kMaxDepth));
  static const std::map<std::string, Sampler> kSamplers = {{"grid", Sampler::grid}, {"jitter", Sampler::jitter}};
  command.add_option("--sampler", options.sampler, "Where samples lie: grid (cell centres) or jitter (default: grid)")
      ->transform(CLI::CheckedTransformer(kSamplers).description("{grid,jitter}"));
  command.add_option("--seed", options.seed, "Seed of the jitter")->capture_default_str();
  command.add_option("--min-weight", options.minWeight, "Drop rays whose product of r and t factors is below this")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  static const std::map<std::string, Geometry> kGeometries = {{"exact", Geometry::exact},
                                                              {"rounded", Geometry::rounded}};
  command
      .add_option("--geometry", options.geometry,
                  "What the reference traces: the exact scene, or the one rounded for the shader (default: exact)")
      ->transform(CLI::CheckedTransformer(kGeometries).description("{exact,rounded}"));
  command.add_option("--device", options.device,
                     "Vulkan device: index, or part of its name (default: $TURNER_DEVICE, else the best one)");
  command.add_option("--crop", options.crop, "Render only the pixels x0 <= x < x1, y0 <= y < y1")
      ->type_name("x0,y0,x1,y1");
  command.add_option("--shaders", options.shaders, "Folder of the kernel's sources (default: turner's own)")
      ->type_name("DIR");
  command.add_flag("--quiet", options.quiet, "Print nothing but errors");
  command
      .add_option("--tile", options.tile, "Pixels on a tile's side; never changes the picture (default: the device's)")
      ->check([](const std::string& text) {
        long long side = 0;
        const bool good = parseInteger(text, side) == NumberFault::none && side >= 8 && side <= 4096 && side % 8 == 0;
        return good ? std::string() : "must be a multiple of 8 from 8 to 4096, not " + text;
      });
  command
      .add_option("--work-group", options.workGroup,
                  "Invocations in a work-group, rounded up to whole subgroups; never changes the picture")
      ->capture_default_str();
}

// CLI11 names an unknown argument; say what it may have meant.
std::string unknownArgument(const CLI::App& app, const std::string& argument) {
  const CLI::App* command = app.get_subcommands().empty() ? &app : app.get_subcommands()[0];
  std::vector<std::string> known;
  for (const CLI::Option* option : command->get_options())
    for (const std::string& name : option->get_lnames()) known.push_back("--" + name);
  const std::string nearest = nearestName(argument.substr(0, argument.find('=')), known);
  const std::string where = command == &app ? "turner --help" : "turner " + command->get_name() + " --help";
  return fmt::format("unknown argument '{}'; {}", argument,
                     nearest.empty() ? where + " lists the options" : "did you mean " + nearest + "?");
}

}  // namespace

CommandLine parseCommandLine(int argc, char** argv) {
  CommandLine line;
  CLI::App app("Turner: a headless Whitted ray tracer. Traces spheres and triangles in a Vulkan compute shader.",
               "turner");
  app.set_version_flag("--version", std::string("turner ") + TURNER_VERSION);
  app.require_subcommand(1);
  app.failure_message([](const CLI::App*, const CLI::Error& error) { return std::string(error.what()); });

  CLI::App* render = app.add_subcommand("render", "Render a scene into EXR and PNG files");
  render->add_option("SCENE", line.render.scene, "A .json or .nff scene")->required();
  render
      ->add_option("-o,--output", line.render.outputs,
                   "File to write, .exr or .png; may be repeated (default: SCENE.exr)")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)
      ->type_name("FILE");
  static const std::map<std::string, Backend> kBackends = {{"shader", Backend::shader},
                                                           {"reference", Backend::reference}};
  render
      ->add_option("--backend", line.render.backend,
                   "Who renders: shader, or reference in double precision (default: shader)")
      ->transform(CLI::CheckedTransformer(kBackends).description("{shader,reference}"));
  render->add_option("--stats", line.render.stats, "Write counts and times as JSON")->type_name("FILE");
  addRenderOptions(*render, line.render);

  CLI::App* compare =
      app.add_subcommand("compare", "Compare two EXR files, or a scene's shader picture with the reference's");
  compare->add_option("FILES", line.compare.files, "A.exr B.exr, or one scene")->required()->expected(1, 2);
  const auto bound = [&](const std::string& name, double& value, const std::string& text) {
    compare->add_option(name, value, text)->check(CLI::NonNegativeNumber);
  };
  bound("--max-rmse", line.compare.bounds.rmse, "Fail (exit 1) if the root mean square error exceeds this");
  bound("--max-error", line.compare.bounds.max, "Fail if the largest error of a channel exceeds this");
  bound("--max-bad-pixels", line.compare.bounds.badPixels,
        "Fail if the share of pixels off by more than --threshold exceeds this");
  bound("--threshold", line.compare.threshold, "Error of a channel from which a pixel is bad (default: 0.001)");
  compare->add_option("--error-image", line.compare.errorImage, "Write |A - B| as EXR")->type_name("FILE");
  compare->add_flag("--json", line.compare.json, "Print the figures as JSON");
  addRenderOptions(*compare, line.render);

  CLI::App* devices = app.add_subcommand("devices", "List the Vulkan devices");
  devices->add_flag("--json", line.devicesAsJson, "Print as JSON");

  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& help) {
    app.exit(help);
    return line;
  } catch (const CLI::ExtrasError&) {
    const std::vector<std::string> extras = app.remaining(true);
    throw InputError(unknownArgument(app, extras.empty() ? "" : extras[0]));
  } catch (const CLI::RequiredError& error) {
    const bool noCommand = app.get_subcommands().empty();
    throw InputError(noCommand ? "name a command: render, compare or devices; turner --help tells more" : error.what());
  } catch (const CLI::ParseError& error) {
    throw InputError(error.what());
  }

  if (*render) line.kind = CommandKind::render;
  if (*compare) line.kind = CommandKind::compare;
  if (*devices) line.kind = CommandKind::devices;
  if (*compare && line.compare.files.size() == 1) line.render.scene = line.compare.files[0];
  return line;
}

namespace {

Window parseCrop(const std::string& text, int width, int height) {
  int numbers[4];
  size_t at = 0;
  for (int i = 0; i < 4; ++i) {
    const size_t end = i < 3 ? text.find(',', at) : text.size();
    long long value = 0;
    if (end == std::string::npos ||
        parseInteger(std::string_view(text).substr(at, end - at), value) != NumberFault::none || value < 0 ||
        value > kMaxSize)
      throw InputError("--crop: found '" + text + "'; must be four whole numbers x0,y0,x1,y1");
    numbers[i] = int(value);
    at = end + 1;
  }
  const Window crop{numbers[0], numbers[1], numbers[2], numbers[3]};
  if (crop.x0 >= crop.x1 || crop.y0 >= crop.y1 || crop.x1 > width || crop.y1 > height)
    throw InputError(fmt::format(
        "--crop: found {}; must be a part of the {} x {} picture: 0 <= x0 < x1 <= {} and 0 <= y0 < y1 <= {}", text,
        width, height, width, height));
  return crop;
}

}  // namespace

RenderSettings settingsFor(const Scene& scene, const RenderOptions& options) {
  RenderSettings settings;
  settings.width = options.width.value_or(scene.width);
  settings.height = options.height.value_or(scene.height);
  settings.crop = options.crop.empty() ? Window{0, 0, settings.width, settings.height}
                                       : parseCrop(options.crop, settings.width, settings.height);
  settings.samples = options.samples;
  settings.sampler = options.sampler;
  settings.seed = options.seed;
  settings.depth = options.depth.value_or(scene.depth);
  settings.minWeight = options.minWeight;
  constexpr size_t kMaxPixels = size_t(1) << 28;
  if (settings.crop.area() > kMaxPixels)
    throw InputError(
        fmt::format("a picture of {} x {} pixels is too large for one file; render it in parts with --crop "
                    "of at most {} pixels",
                    settings.crop.width(), settings.crop.height(), kMaxPixels));
  return settings;
}

}  // namespace turner
