// In: figures. Out: text.
#include "watch/version_report.h"

#include <fmt/format.h>

#include <cmath>

#include "gpu/kernel_features.h"
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

std::string compileLine(const VersionReport& report) {
  const std::string front = report.glslang > 0
                                ? "glslang " + seconds(report.glslang) + ", optimiser " + seconds(report.optimiser)
                                : "compiled before";
  return line("compile", front + ", check " + seconds(report.check) +
                             (report.sameCode ? "" : ", driver " + seconds(report.pipeline)));
}

std::string traceLine(const VersionReport& report) {
  std::string text = seconds(report.timing ? report.timing->editedSeconds : report.trace);
  if (const std::optional<double> ratio = report.ratio())
    text += fmt::format(", {:.2f} x version {}{}", *ratio, report.lastGood.value_or(0),
                        report.timing ? fmt::format(" ({:.2f} to {:.2f} in {} turns)", report.timing->leastRatio,
                                                    report.timing->mostRatio, report.timing->pairs)
                                      : " (not in turn)");
  return line("trace", text);
}

std::string pictureLine(const VersionReport& report) {
  if (report.sameCode)
    return line("picture", fmt::format("that of version {}: the compiled code is the same", *report.lastGood));
  if (!report.lastGood) return "";
  if (!report.toLastGood) return line("picture", "of another size than before");
  const Comparison& c = *report.toLastGood;
  const uint64_t changed = changedPixels(c);
  if (changed == 0) return line("picture", fmt::format("no pixel differs from version {}", *report.lastGood));
  return line("picture", fmt::format("{} pixels changed ({:.2g} %), rms {:.3e}, max {:.3e}{}", changed,
                                     100 * c.badPixels, c.rmse, c.max, nonFinite(c)));
}

std::string raysLine(const VersionReport& report) {
  if (!report.rays) return "";
  const RayCounts now = *report.rays, before = report.lastGoodRays.value_or(RayCounts{});
  if (report.lastGoodRays && now == before) return line("rays", fmt::format("{}, all counts as before", now.total()));
  std::string text;
  const auto add = [&](const char* name, uint64_t count, uint64_t last) {
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", name, count);
    if (report.lastGoodRays && count != last) text += fmt::format(" ({:+})", int64_t(count - last));
  };
  add("eye", now.eye, before.eye);
  add("reflected", now.reflected, before.reflected);
  add("refracted", now.refracted, before.refracted);
  add("shadow", now.shadow, before.shadow);
  return line("rays", text);
}

std::string featuresText(const VersionReport& report) {
  std::string text;
  for (const std::string& told : report.news) text += line("kernel", told);
  if (report.timing && report.timing->featuresRatio > 0)
    text += line("kernel", fmt::format("version {} takes {:.2f} x its time with what was added", *report.lastGood,
                                       report.timing->featuresRatio));
  return text;
}

std::string parametersLine(const VersionReport& report) {
  return report.parameters.empty() ? "" : line("params", valuesText(report.parameters));
}

std::string codeLine(const VersionReport& report) {
  std::string text = fmt::format("{} instructions", report.code.total);
  if (report.lastGood) text += fmt::format(" (+{} -{})", report.code.added, report.code.removed);
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

std::optional<double> VersionReport::ratio() const {
  if (timing) return timing->ratio;
  if (sameCode) return 1.0;
  if (lastGoodTrace) return trace / *lastGoodTrace;
  return std::nullopt;
}

std::string referenceText(const Comparison& c) {
  return line("reference", fmt::format("rms {:.3e}, max {:.3e}{}", c.rmse, c.max, nonFinite(c)));
}

std::string versionReportText(const VersionReport& report) {
  return report.warnings + compileLine(report) + (report.sameCode ? "" : traceLine(report)) + pictureLine(report) +
         (report.toReference ? referenceText(*report.toReference) : "") + raysLine(report) + parametersLine(report) +
         codeLine(report) + featuresText(report) + (report.kept.empty() ? "" : line("kept", report.kept));
}

std::string versionReportJson(const VersionReport& report) {
  JsonWriter json;
  json.object([&] { putVersionReport(json, report); });
  return json.text();
}

void putVersionReport(JsonWriter& json, const VersionReport& report) {
  json.put("version", report.version);
  json.put("last_good", report.lastGood);
  json.array("changed", [&] {
    for (const std::string& name : report.changed) json.put(name);
  });
  json.put("scene_changed", report.sceneChanged);
  json.put("same_code", report.sameCode);
  json.object("seconds", [&] {
    json.put("to_coarse", report.toCoarse);
    json.put("to_picture", report.toPicture);
    json.put("open", report.scene.openSeconds);
    json.put("load", report.scene.loadSeconds);
    json.put("build", report.scene.buildSeconds);
    json.put("upload", report.scene.uploadSeconds);
    json.put("glslang", report.glslang);
    json.put("optimiser", report.optimiser);
    json.put("check", report.check);
    json.put("pipeline", report.pipeline);
    json.put("trace", report.trace);
    json.put("readback", report.readback);
  });
  json.object("trace", [&] {
    json.put("seconds", report.timing ? report.timing->editedSeconds : report.trace);
    json.put("last_good_seconds", report.timing ? std::optional(report.timing->goodSeconds) : report.lastGoodTrace);
    json.put("ratio", report.ratio());
    json.put("least_ratio", report.timing ? std::optional(report.timing->leastRatio) : std::nullopt);
    json.put("most_ratio", report.timing ? std::optional(report.timing->mostRatio) : std::nullopt);
    json.put("interleaved", report.timing.has_value());
    json.put("pairs", report.timing ? report.timing->pairs : 0);
  });
  if (report.toLastGood)
    json.put("changed_pixels", changedPixels(*report.toLastGood));
  else
    json.putNull("changed_pixels");
  putComparison(json, "to_last_good", report.toLastGood);
  putComparison(json, "to_reference", report.toReference);
  if (report.rays)
    putCounts(json, "rays", *report.rays);
  else
    json.putNull("rays");
  if (report.rays && report.lastGoodRays)
    putChange(json, *report.rays, *report.lastGoodRays);
  else
    json.putNull("rays_change");
  json.object("spirv", [&] {
    json.put("instructions", report.code.total);
    json.put("added", report.code.added);
    json.put("removed", report.code.removed);
  });
  json.object("kernel", [&] {
    json.array("added", [&] {
      for (const std::string& name : featureNames(report.added)) json.put(name);
    });
    json.put("added_ratio", report.timing && report.timing->featuresRatio > 0
                                ? std::optional(report.timing->featuresRatio)
                                : std::nullopt);
    json.array("notes", [&] {
      for (const std::string& told : report.news) json.put(told);
    });
    json.put("warnings", report.warnings);
  });
  putParameters(json, "params", report.parameters);
  if (report.kept.empty())
    json.putNull("kept");
  else
    json.put("kept", report.kept);
}

}  // namespace turner::watch
