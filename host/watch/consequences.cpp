// In: figures. Out: text.
#include "watch/consequences.h"

#include <fmt/format.h>

#include <cmath>

#include "image/figures_json.h"

namespace turner::watch {
namespace {

std::string line(const char* name, const std::string& text) {
  return fmt::format("  {:<10}{}\n", name, text);
}

uint64_t changedPixels(const Comparison& comparison) {
  return uint64_t(std::llround(comparison.badPixels * comparison.width * comparison.height));
}

std::string nonFinite(const Comparison& comparison) {
  return comparison.nan + comparison.inf == 0
             ? ""
             : fmt::format(", {} pixels with NaN, {} with infinity", comparison.nan, comparison.inf);
}

std::string seconds(double value) {
  return fmt::format("{:.3f} s", value);
}

std::string compileLine(const Consequences& of) {
  const std::string front =
      of.glslang > 0 ? "glslang " + seconds(of.glslang) + ", optimiser " + seconds(of.optimiser) : "compiled before";
  return line("compile",
              front + ", check " + seconds(of.check) + (of.sameCode ? "" : ", driver " + seconds(of.pipeline)));
}

std::string traceLine(const Consequences& of) {
  std::string text = seconds(of.timing ? of.timing->editedSeconds : of.trace);
  if (const std::optional<double> ratio = of.ratio())
    text += fmt::format(", {:.2f} x version {}{}", *ratio, of.lastGood.value_or(0),
                        of.timing ? fmt::format(" ({:.2f} to {:.2f} in {} turns)", of.timing->leastRatio,
                                                of.timing->mostRatio, of.timing->pairs)
                                  : " (not in turn)");
  return line("trace", text);
}

std::string pictureLine(const Consequences& of) {
  if (of.sameCode)
    return line("picture", fmt::format("that of version {}: the compiled code is the same", *of.lastGood));
  if (!of.lastGood) return "";
  if (!of.toLastGood) return line("picture", "of another size than before");
  const Comparison& c = *of.toLastGood;
  const uint64_t changed = changedPixels(c);
  if (changed == 0) return line("picture", fmt::format("no pixel differs from version {}", *of.lastGood));
  return line("picture", fmt::format("{} pixels changed ({:.2g} %), rms {:.3e}, max {:.3e}{}", changed,
                                     100 * c.badPixels, c.rmse, c.max, nonFinite(c)));
}

std::string raysLine(const Consequences& of) {
  if (!of.rays) return "";
  const RayCounts now = *of.rays, before = of.lastGoodRays.value_or(RayCounts{});
  if (of.lastGoodRays && now == before) return line("rays", fmt::format("{}, all counts as before", now.total()));
  std::string text;
  const auto add = [&](const char* name, uint64_t count, uint64_t last) {
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", name, count);
    if (of.lastGoodRays && count != last) text += fmt::format(" ({:+})", int64_t(count - last));
  };
  add("eye", now.eye, before.eye);
  add("reflected", now.reflected, before.reflected);
  add("refracted", now.refracted, before.refracted);
  add("shadow", now.shadow, before.shadow);
  return line("rays", text);
}

std::string codeLine(const Consequences& of) {
  std::string text = fmt::format("{} instructions", of.code.total);
  if (of.lastGood) text += fmt::format(" (+{} -{})", of.code.added, of.code.removed);
  return line("SPIR-V", text);
}

void putChange(JsonWriter& json, const RayCounts& now, const RayCounts& before) {
  json.object("rays_change", [&] {
    json.put("eye", int64_t(now.eye - before.eye));
    json.put("reflected", int64_t(now.reflected - before.reflected));
    json.put("refracted", int64_t(now.refracted - before.refracted));
    json.put("shadow", int64_t(now.shadow - before.shadow));
  });
}

}  // namespace

void putComparison(JsonWriter& json, const char* key, const std::optional<Comparison>& comparison) {
  if (comparison)
    json.object(key, [&] { putFigures(json, *comparison); });
  else
    json.putNull(key);
}

std::optional<double> Consequences::ratio() const {
  if (timing) return timing->ratio;
  if (sameCode) return 1.0;
  if (lastGoodTrace) return trace / *lastGoodTrace;
  return std::nullopt;
}

std::string referenceText(const Comparison& c) {
  return line("reference", fmt::format("rms {:.3e}, max {:.3e}{}", c.rmse, c.max, nonFinite(c)));
}

std::string consequencesText(const Consequences& of) {
  return compileLine(of) + (of.sameCode ? "" : traceLine(of)) + pictureLine(of) +
         (of.toReference ? referenceText(*of.toReference) : "") + raysLine(of) + codeLine(of) +
         (of.kept.empty() ? "" : line("kept", of.kept));
}

void putConsequences(JsonWriter& json, const Consequences& of) {
  json.put("version", of.version);
  json.put("last_good", of.lastGood);
  json.array("changed", [&] {
    for (const std::string& name : of.changed) json.put(name);
  });
  json.put("scene_changed", of.sceneChanged);
  json.put("same_code", of.sameCode);
  json.object("seconds", [&] {
    json.put("to_coarse", of.toCoarse);
    json.put("to_picture", of.toPicture);
    json.put("open", of.scene.openSeconds);
    json.put("load", of.scene.loadSeconds);
    json.put("build", of.scene.buildSeconds);
    json.put("upload", of.scene.uploadSeconds);
    json.put("glslang", of.glslang);
    json.put("optimiser", of.optimiser);
    json.put("check", of.check);
    json.put("pipeline", of.pipeline);
    json.put("trace", of.trace);
    json.put("readback", of.readback);
  });
  json.object("trace", [&] {
    json.put("seconds", of.timing ? of.timing->editedSeconds : of.trace);
    json.put("last_good_seconds", of.timing ? std::optional(of.timing->goodSeconds) : of.lastGoodTrace);
    json.put("ratio", of.ratio());
    json.put("least_ratio", of.timing ? std::optional(of.timing->leastRatio) : std::nullopt);
    json.put("most_ratio", of.timing ? std::optional(of.timing->mostRatio) : std::nullopt);
    json.put("interleaved", of.timing.has_value());
    json.put("pairs", of.timing ? of.timing->pairs : 0);
  });
  if (of.toLastGood)
    json.put("changed_pixels", changedPixels(*of.toLastGood));
  else
    json.putNull("changed_pixels");
  putComparison(json, "to_last_good", of.toLastGood);
  putComparison(json, "to_reference", of.toReference);
  if (of.rays)
    putCounts(json, "rays", *of.rays);
  else
    json.putNull("rays");
  if (of.rays && of.lastGoodRays)
    putChange(json, *of.rays, *of.lastGoodRays);
  else
    json.putNull("rays_change");
  json.object("spirv", [&] {
    json.put("instructions", of.code.total);
    json.put("added", of.code.added);
    json.put("removed", of.code.removed);
  });
  if (of.kept.empty())
    json.putNull("kept");
  else
    json.put("kept", of.kept);
}

}  // namespace turner::watch
