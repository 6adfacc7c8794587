// Keys and columns in the order of docs: scene, device, setting, times, errors.
#include "report/tables.h"

#include <fmt/format.h>

#include <cmath>

#include "base/json_writer.h"
#include "image/figures_json.h"
#include "image/provenance.h"
#include "report/figures.h"
#include "report/findings.h"

namespace turner::report {
namespace {

void putSeconds(JsonWriter& json, const SweepPoint& point) {
  json.object("seconds", [&] {
    json.put("median", point.medianSeconds());
    json.put("min", point.fastest());
    json.put("max", point.slowest());
    json.array("repeats", [&] {
      for (const double seconds : point.seconds) json.put(seconds);
    });
  });
}

void putPoint(JsonWriter& json, const Machine& machine, const SweptScene& scene, const SweepPoint& point,
              bool onFront) {
  json.object([&] {
    json.put("name", point.name);
    json.put("device", scene.renderers[point.renderer].name);
    json.put("sampler", samplerName(point.setting.sampler));
    json.put("samples", point.setting.samples);
    json.put("depth", point.setting.depth);
    json.put("min_weight", point.setting.minWeight);
    putSeconds(json, point);
    json.put("rmse", point.rmse);
    json.array("rmse_of_seeds", [&] {
      for (const double rmse : point.rmses) json.put(rmse);
    });
    json.put("rel_rmse", point.relRmse);
    json.put("mae", point.total.mae);
    json.put("mean_signed", point.total.meanSigned);
    json.put("p50", point.total.p50);
    json.put("p99", point.total.p99);
    json.put("p999", point.total.p999);
    json.put("max", point.total.max);
    json.put("nan", point.total.nan);
    json.put("inf", point.total.inf);
    json.put("efficiency", point.efficiency());
    json.put("pareto", onFront);
    json.object("sampling", [&] { putFigures(json, point.sampling); });
    json.object("cut_off", [&] { putFigures(json, point.cutOff); });
    json.object("quantisation", [&] { putFigures(json, point.quantisation); });
    json.object("arithmetic", [&] { putFigures(json, point.arithmetic); });
    json.put("command", renderCommand(scene, point, machine.shaders));
  });
}

void putCurve(JsonWriter& json, const SweptScene& scene, const Curve& curve) {
  json.object([&] {
    json.put("device", scene.renderers[curve.renderer].name);
    json.put("sampler", samplerName(curve.sampler));
    json.put("slope", curve.slope.value_or(NAN));
    json.array("reaches", [&] {
      for (size_t t = 0; t < std::size(kTargets); ++t) {
        const std::optional<Reach>& reach = curve.targets[t];
        json.object([&] {
          json.put("rmse", kTargets[t]);
          json.put("samples", reach ? reach->samples : NAN);
          json.put("seconds", reach ? reach->seconds : NAN);
          json.put("extrapolated", reach && reach->extrapolated);
        });
      }
    });
  });
}

void putScene(JsonWriter& json, const Machine& machine, const SweptScene& scene) {
  const std::vector<bool> onFront = isOnFront(scene);
  json.object([&] {
    json.put("scene", scene.path);
    json.put("sha256", scene.summary.sources.empty() ? "" : scene.summary.sources[0].sha256);
    for (const PrimitiveCount& type : scene.primitives) json.put(type.name.c_str(), type.count);
    json.put("width", scene.whole.width);
    json.put("height", scene.whole.height);
    json.put("crop", cropText(scene.whole.crop));
    json.put("depth", scene.whole.depth);
    json.array("devices", [&] {
      for (const auto& renderer : scene.renderers) {
        json.object([&] {
          json.put("device", renderer.name);
          json.put("name", renderer.device);
          json.put("driver", renderer.driver);
          json.put("type", renderer.type);
        });
      }
    });
    json.object("converged", [&] {
      json.put("device", scene.renderers[scene.convergedBy.renderer].name);
      json.put("samples", 2 * uint64_t(scene.converged.samples) * uint64_t(scene.converged.samples));
      json.put("own_error", scene.converged.ownError);
      json.put("own_rel_error", scene.converged.ownRelative);
      json.put("least_error", scene.converged.leastError);
      json.put("converged", scene.converged.enough);
      json.put("float_error", scene.convergedBy.floatError);
    });
    json.array("findings", [&] {
      for (const std::string& sentence : findings(scene)) json.put(sentence);
    });
    json.array("curves", [&] {
      for (const Curve& curve : curvesOf(scene)) putCurve(json, scene, curve);
    });
    json.array("points", [&] {
      for (size_t i = 0; i < scene.points.size(); ++i) putPoint(json, machine, scene, scene.points[i], onFront[i]);
    });
  });
}

// A field of CSV (RFC 4180).
std::string field(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + '"';
}

// Numbers that do not exist are empty.
std::string field(double value) {
  return std::isfinite(value) ? fmt::format("{}", value) : "";
}

}  // namespace

std::string reportJson(const Machine& machine, const std::vector<SweptScene>& scenes) {
  JsonWriter json;
  json.object([&] {
    json.put("turner", machine.version);
    json.put("date", machine.date);
    json.put("command", machine.command);
    json.object("machine", [&] {
      json.put("processor", machine.processor);
      json.put("cores", machine.cores);
      json.put("system", machine.system);
    });
    json.put("repeats", machine.repeats);
    json.array("scenes", [&] {
      for (const SweptScene& scene : scenes) putScene(json, machine, scene);
    });
  });
  return json.text();
}

std::string reportCsv(const Machine& machine, const std::vector<SweptScene>& scenes) {
  std::string text =
      "scene,device,device_name,driver,sampler,samples,depth,min_weight,width,height,crop,seconds_median,seconds_min,"
      "seconds_max,rmse,own_error,rel_rmse,mean_signed,p50,p99,p999,max,nan,inf,efficiency,pareto,sampling_rmse,"
      "cut_off_rmse,quantisation_rmse,arithmetic_rmse,arithmetic_p999,arithmetic_max,arithmetic_mean_signed,arithmetic_"
      "bad_pixels,"
      "command\n";
  for (const SweptScene& scene : scenes) {
    const std::vector<bool> onFront = isOnFront(scene);
    for (size_t i = 0; i < scene.points.size(); ++i) {
      const SweepPoint& p = scene.points[i];
      const RendererInfo& renderer = scene.renderers[p.renderer];
      const std::vector<std::string> fields = {field(scene.path),
                                               field(renderer.name),
                                               field(renderer.device),
                                               field(renderer.driver),
                                               samplerName(p.setting.sampler),
                                               std::to_string(p.setting.samples),
                                               std::to_string(p.setting.depth),
                                               field(p.setting.minWeight),
                                               std::to_string(scene.whole.width),
                                               std::to_string(scene.whole.height),
                                               field(cropText(scene.whole.crop)),
                                               field(p.medianSeconds()),
                                               field(p.fastest()),
                                               field(p.slowest()),
                                               field(p.rmse),
                                               field(scene.converged.ownError),
                                               field(p.relRmse),
                                               field(p.total.meanSigned),
                                               field(p.total.p50),
                                               field(p.total.p99),
                                               field(p.total.p999),
                                               field(p.total.max),
                                               std::to_string(p.total.nan),
                                               std::to_string(p.total.inf),
                                               field(p.efficiency()),
                                               onFront[i] ? "1" : "0",
                                               field(p.sampling.rmse),
                                               field(p.cutOff.rmse),
                                               field(p.quantisation.rmse),
                                               field(p.arithmetic.rmse),
                                               field(p.arithmetic.p999),
                                               field(p.arithmetic.max),
                                               field(p.arithmetic.meanSigned),
                                               field(p.arithmetic.badPixels),
                                               field(renderCommand(scene, p, machine.shaders))};
      for (size_t f = 0; f < fields.size(); ++f) text += (f > 0 ? "," : "") + fields[f];
      text += '\n';
    }
  }
  return text;
}

}  // namespace turner::report
