// Options are declared with CLI11 and converted by our own exact functions, which say what is allowed.
#include "command/command_line.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <sstream>
#include <type_traits>
#include <utility>

#include "base/diagnostics.h"
#include "base/errors.h"
#include "base/number.h"
#include "base/tell.h"
#include "kernel/edits/parameters.h"

namespace turner {
namespace {

// --- values: converted by our own exact functions, refused with the option, what was found and what is allowed ---

[[noreturn]] void refuse(const std::string& option, const std::string& found, const std::string& allowed) {
  throw InputError(fmt::format("{}: found '{}'; must be {}", option, found, allowed));
}

template <class Integer>
void addInteger(CLI::App& command, const std::string& name, Integer& value, long long least, long long most,
                const std::string& text, const std::string& type = "INT") {
  command
      .add_option_function<std::string>(
          name,
          [name, &value, least, most](const std::string& found) {
            long long number = 0;
            if (parseInteger(found, number) != NumberFault::none || number < least || number > most)
              refuse(name, found, fmt::format("a whole number from {} to {}", least, most));
            if constexpr (std::is_integral_v<Integer>)
              value = Integer(number);
            else
              value = typename Integer::value_type(number);
          },
          text)
      ->type_name(type);
}

template <class Real>
void addNumber(CLI::App& command, const std::string& name, Real& value, double most, const std::string& text,
               double least = 0) {
  command
      .add_option_function<std::string>(
          name,
          [name, &value, most, least](const std::string& found) {
            double number = 0;
            if (parseNumber(found, number) != NumberFault::none || number < least || number > most)
              refuse(name, found,
                     most < INFINITY ? fmt::format("a number from {:g} to {:g}", least, most)
                                     : fmt::format("a number of at least {:g}", least));
            value = Real(number);
          },
          text)
      ->type_name("NUMBER");
}

template <class Choice>
void addChoice(CLI::App& command, const std::string& name, Choice& value,
               const std::vector<std::pair<std::string, Choice>>& choices, const std::string& text) {
  std::string allowed;
  for (const auto& [word, choice] : choices) allowed += (allowed.empty() ? "" : " or ") + word;
  command
      .add_option_function<std::string>(
          name,
          [name, &value, choices, allowed](const std::string& found) {
            for (const auto& [word, choice] : choices) {
              if (word != found) continue;
              value = choice;
              return;
            }
            refuse(name, found, allowed);
          },
          text)
      ->type_name(allowed);
}

// A value that was forgotten would take the next option for one.
void checkText(const std::string& option, const std::string& type, const std::string& found) {
  if (found.empty()) refuse(option, found, "something");
  if (found.starts_with("--") || found == "-o" || found == "-h")
    refuse(option, found, "a value, not an option; write ./" + found + " if a file has this name");
  if (type == "DIR" && found == "-") refuse(option, found, "a folder; write ./- if one has this name");
}

void addText(CLI::App& command, const std::string& name, std::string& value, const std::string& type,
             const std::string& text) {
  command
      .add_option_function<std::string>(
          name,
          [name, type, &value](const std::string& found) {
            checkText(name, type, found);
            value = found;
          },
          text)
      ->type_name(type);
}

// --- commands ---

void addRenderOptions(CLI::App& command, RenderOptions& options) {
  addInteger(command, "--width", options.width, 1, kMaxSize, "Width of the picture in pixels (default: the scene's)");
  addInteger(command, "--height", options.height, 1, kMaxSize,
             "Height of the picture in pixels (default: the scene's)");
  addInteger(command, "--samples", options.samples, 1, kMaxSamples,
             "n of the n x n samples in each pixel (default: 1)");
  addInteger(command, "--depth", options.depth, 1, kMaxDepth,
             "Levels of the ray tree; the eye ray is level 1 (default: the scene's)");
  addChoice<Sampler>(command, "--sampler", options.sampler,
                     {{"grid", Sampler::grid}, {"jitter", Sampler::jitter}, {"sobol", Sampler::sobol}},
                     "Where samples lie: at cell centres, hashed inside the cells, or spread evenly along each axis as "
                     "well, best with --samples of factors 2 and 3 (default: grid)");
  addInteger(command, "--seed", options.seed, 0, UINT32_MAX, "Seed of jitter and sobol (default: 0)");
  addNumber(command, "--min-weight", options.minWeight, 1,
            "Drop rays whose product of r and t factors is below this (default: 0)");
  addChoice<Geometry>(command, "--geometry", options.geometry,
                      {{"exact", Geometry::exact}, {"rounded", Geometry::rounded}},
                      "What the reference traces: the scene, or the values that the shader gets (default: exact)");
  addText(command, "--device", options.device, "N|NAME",
          "Vulkan device: index, or part of its name (default: $TURNER_DEVICE, else the best one)");
  addText(command, "--crop", options.crop, "x0,y0,x1,y1", "Render only the pixels x0 <= x < x1, y0 <= y < y1");
  addText(command, "--shaders", options.shaders, "DIR", "Folder of the kernel's sources (default: turner's own)");
  command
      .add_option_function<std::vector<std::string>>(
          "--set",
          [&options](const std::vector<std::string>& found) {
            for (const std::string& text : found) options.parameters.push_back(parseSetting(text, "--set"));
          },
          "Set a parameter of edited shaders, such as softness=0.3 or tint=1,0.5,0; may be repeated")
      ->expected(1)
      ->allow_extra_args(false)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)
      ->type_name("NAME=VALUE");
  command.add_flag(
      "--narrow", options.narrow,
      "Compile an edited kernel for what the scene needs alone, and refuse it if it needs more: to measure what "
      "that costs");
  command.add_flag("--quiet", options.quiet, "Print nothing but errors");
  addChoice<BufferAccess>(
      command, "--fetch", options.access,
      {{"texels", BufferAccess::texelBuffer},
       {"buffers", BufferAccess::storageBuffer},
       {"addresses", BufferAccess::deviceAddress}},
      "How the kernel fetches the scene; never changes the picture (default: what suits the device)");
  addInteger(
      command, "--tile", options.tile, 8, 4096,
      "Pixels on a tile's side, rounded up to whole blocks of 8; never changes the picture (default: the device's)");
  addInteger(command, "--work-group", options.workGroup, 1, 1 << 20,
             "Invocations in a work-group, rounded up to whole subgroups; never changes the picture (default: 64)");
}

// `streams`: "-" is standard input and output.
void addSceneAndOutputs(CLI::App& command, RenderOptions& options, bool streams) {
  const std::string scene = "A .json or .nff scene", output = "File to write, .exr or .png; may be repeated";
  command.add_option("SCENE", options.scene, scene + (streams ? ", or - for one from standard input" : ""))->required();
  command
      .add_option("-o,--output", options.outputs,
                  output + (streams ? "; -, or png:-, is standard output" : "") + " (default: SCENE.exr)")
      ->expected(1)
      ->allow_extra_args(false)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)
      ->type_name("FILE");
}

void checkOutputs(const RenderOptions& options) {
  for (const std::string& output : options.outputs) checkText("--output", "FILE", output);
}

void addRender(CLI::App& app, RenderOptions& options) {
  CLI::App* command = app.add_subcommand("render", "Render a scene into EXR and PNG files");
  addSceneAndOutputs(*command, options, true);
  addChoice<Backend>(*command, "--backend", options.backend,
                     {{"shader", Backend::shader}, {"reference", Backend::reference}},
                     "Who renders: the shader, or the reference in double precision (default: shader)");
  addText(*command, "--stats", options.stats, "FILE", "Write counts and times as JSON; - is standard output");
  addRenderOptions(*command, options);
}

void addCompare(CLI::App& app, CompareOptions& options, RenderOptions& render) {
  CLI::App* command =
      app.add_subcommand("compare", "Compare two EXR files, or a scene's shader picture with the reference's");
  command->add_option("FILES", options.files, "A.exr B.exr, or one scene; - is standard input")
      ->required()
      ->expected(1, 2);
  addNumber(*command, "--max-rmse", options.bounds.rmse, INFINITY,
            "Fail (exit 1) if the root mean square error exceeds this");
  addNumber(*command, "--max-error", options.bounds.max, INFINITY,
            "Fail if the largest error of a channel exceeds this");
  addNumber(*command, "--max-bad-pixels", options.bounds.badPixels, INFINITY,
            "Fail if the share of pixels off by more than --threshold exceeds this");
  addNumber(*command, "--threshold", options.threshold, INFINITY,
            "Error of a channel above which a pixel is bad (default: 0.001)");
  addText(*command, "--error-image", options.errorImage, "FILE", "Write |A - B| as EXR; - is standard output");
  command->add_flag("--json", options.json, "Print the figures as JSON");
  command->add_flag("--decompose", options.decompose,
                    "Of a scene: tell the errors of sampling, of arithmetic and of the scene's rounding apart");
  command->add_flag("--envelope", options.envelope,
                    "Of a scene: how many of the pixels off by more than 1e-5 lie where the reference does with eye "
                    "rays off by 4 ulp");
  addRenderOptions(*command, render);
}

void addWatch(CLI::App& app, WatchOptions& options, RenderOptions& render) {
  CLI::App* command = app.add_subcommand(
      "watch", "Render a scene again whenever its files or the shaders change, and tell what the change did");
  addSceneAndOutputs(*command, render, false);
  addText(*command, "--keep", options.keep, "DIR", "Keep every version there: its sources, its picture, its figures");
  addText(
      *command, "--params", options.params, "FILE",
      "Values of the shaders' parameters as JSON, {\"softness\": 0.3}: a file that is followed, or - for lines from "
      "standard input; they show without a compilation");
  // Beyond this the device itself is given up.
  addNumber(*command, "--timeout", options.timeout, 100,
            "Seconds that a piece of a picture may take before it is called an endless loop (default: 10)", 1);
  command->add_flag("--json", options.json, "Print what happens as JSON, one object on a line");
  addRenderOptions(*command, render);
}

void addShaders(CLI::App& app, ShaderOptions& options) {
  CLI::App* command = app.add_subcommand("shaders", "Copy the kernel's sources, to edit them; check edited ones");
  addText(*command, "--copy", options.copyTo, "DIR", "Folder for the copy; it must be new or empty");
  addText(*command, "--check", options.check, "DIR",
          "Compile the kernel there and check it, without a device: exit code 0 if it is sound, else 2");
  command->add_option("SCENE", options.scene, "With --check: tell what of the kernel this scene leaves out");
  command->add_flag("--json", options.json, "With --check: print the result as JSON");
}

void checkShaderOptions(const ShaderOptions& options) {
  if (options.copyTo.empty() == options.check.empty())
    throw InputError("name the folder for the copy, or the one to check: turner shaders --copy DIR, or --check DIR");
  if (options.check.empty() && (options.json || !options.scene.empty()))
    throw InputError(std::string(options.json ? "--json" : "a scene") + " goes with --check DIR, not with --copy");
}

void addReport(CLI::App& app, ReportOptions& options) {
  CLI::App* command = app.add_subcommand(
      "report", "Measure speed against error: samplers, samples, depths and least weights on every device");
  command->add_option("SCENES", options.scenes, "One or more .json or .nff scenes")->required();
  addText(*command, "-o,--output", options.output, "DIR",
          "Folder for report.html, report.json and report.csv (default: report)");
  CLI::Option* quick = command->add_flag(
      "--quick", options.quick,
      "At most 8 x 8 samples, 3 repeats, and 40000 pixels unless their size is given: some minutes for most scenes "
      "(default)");
  command->add_flag("--full", options.full, "At most 16 x 16 samples, the scene's own size, 10 repeats")
      ->excludes(quick);
  addInteger(*command, "--max-samples", options.maxSamples, 1, kMaxSamples,
             "Most samples n of n x n; measured are this one and 1, 2, 3, 4, 6, 8, 12, 16, ... below (default: 8, with "
             "--full 16)");
  addInteger(*command, "--repeats", options.repeats, 1, 1000,
             "Measurements of each point, each with a seed of its own (default: 3, with --full 10)");
  addInteger(
      *command, "--width", options.width, 1, kMaxSize,
      "Width of the pictures in pixels; without --height that follows (default: the scene's, smaller with --quick)");
  addInteger(*command, "--height", options.height, 1, kMaxSize, "Height of the pictures in pixels");
  addInteger(*command, "--depth", options.depth, 1, kMaxDepth,
             "Levels of the ray tree, the most that is measured (default: the scene's)");
  command->add_flag("--no-cut-offs", options.noCutOffs, "Leave out smaller depths and least weights");
  addText(*command, "--crop", options.crop, "x0,y0,x1,y1", "Measure only the pixels x0 <= x < x1, y0 <= y < y1");
  addText(*command, "--device", options.device, "N|NAME",
          "Measure on this Vulkan device and the reference only (default: on all)");
  addText(*command, "--shaders", options.shaders, "DIR", "Folder of the kernel's sources (default: turner's own)");
  command->add_flag("--exr", options.keepExr, "Keep the pictures as EXR, in DIR/pictures");
  command->add_flag("--quiet", options.quiet, "Print nothing but errors");
}

// --- words that are not known ---

std::string didYouMean(const std::string& word, const std::vector<std::string>& known, const std::string& help) {
  const std::string nearest = nearestName(word, known);
  return nearest.empty() ? help + " tells what there is" : "did you mean " + nearest + "?";
}

// The first word is a command, or asks for help or version.
void checkFirstWord(const CLI::App& app, int argc, char** argv) {
  std::vector<std::string> known = {"--help", "--version"};
  for (const CLI::App* command : app.get_subcommands({})) known.push_back(command->get_name());
  if (argc < 2)
    throw InputError("name a command: render, compare, watch, report, devices or shaders; turner --help tells more");
  const std::string word = argv[1];
  if (word == "-h" || std::find(known.begin(), known.end(), word) != known.end()) return;
  throw InputError(fmt::format("unknown {} '{}'; {}", word.starts_with('-') ? "argument" : "command", word,
                               didYouMean(word, known, "turner --help")));
}

std::string unknownArgument(const CLI::App& app, const std::string& argument) {
  const CLI::App* command = app.get_subcommands().at(0);
  std::vector<std::string> known;
  for (const CLI::Option* option : command->get_options())
    for (const std::string& name : option->get_lnames()) known.push_back("--" + name);
  return fmt::format(
      "unknown argument '{}'; {}", argument,
      didYouMean(argument.substr(0, argument.find('=')), known, "turner " + command->get_name() + " --help"));
}

}  // namespace

CommandLine parseCommandLine(int argc, char** argv) {
  CommandLine line;
  CLI::App app("Turner: a headless Whitted ray tracer. Traces spheres and triangles in a Vulkan compute shader.",
               "turner");
  app.set_version_flag("--version", std::string("turner ") + TURNER_VERSION);
  app.require_subcommand(1);
  addRender(app, line.render);
  addCompare(app, line.compare, line.render);
  addWatch(app, line.watch, line.render);
  addReport(app, line.report);
  CLI::App* devices = app.add_subcommand("devices", "List the Vulkan devices");
  devices->add_flag("--json", line.devicesAsJson, "Print as JSON");
  addShaders(app, line.shaders);

  checkFirstWord(app, argc, argv);
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& help) {
    std::ostringstream text;
    app.exit(help, text, text);
    printResult(text.str());
    return line;
  } catch (const CLI::ExtrasError&) {
    checkOutputs(line.render);  // an option that was taken for a file is why its value is left over
    throw InputError(unknownArgument(app, app.remaining(true).at(0)));
  } catch (const CLI::RequiredError& error) {
    // A misspelt option is a better reason than what is missing because of it.
    const std::vector<std::string> extras = app.remaining(true);
    throw InputError(extras.empty() ? error.what() : unknownArgument(app, extras[0]));
  } catch (const CLI::ParseError& error) {
    throw InputError(error.what());
  }

  checkOutputs(line.render);
  if (app.got_subcommand("render")) line.kind = CommandKind::render;
  if (app.got_subcommand("compare")) line.kind = CommandKind::compare;
  if (app.got_subcommand("watch")) line.kind = CommandKind::watch;
  if (app.got_subcommand("shaders")) line.kind = CommandKind::shaders;
  if (app.got_subcommand("report")) line.kind = CommandKind::report;
  if (app.got_subcommand("devices")) line.kind = CommandKind::devices;
  if (line.kind == CommandKind::shaders) checkShaderOptions(line.shaders);
  const CompareOptions& compare = line.compare;
  if (compare.files.size() == 1) line.render.scene = compare.files[0];
  if (compare.files.size() == 2 && (compare.decompose || compare.envelope))
    throw InputError(
        fmt::format("{} takes one scene, not two pictures", compare.decompose ? "--decompose" : "--envelope"));
  return line;
}

}  // namespace turner
