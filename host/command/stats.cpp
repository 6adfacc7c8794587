// One JSON object for each function, its keys in the order of the contract.
#include "command/stats.h"

#include "base/json_writer.h"
#include "image/figures_json.h"
#include "image/provenance.h"

namespace turner {

std::string statsJson(const Stats& stats) {
  JsonWriter json;
  const RenderSettings& settings = stats.settings;
  json.object([&] {
    json.put("scene", stats.scene);
    json.object("device", [&] {
      json.put("name", stats.device.name);
      json.put("driver", stats.device.driver);
      json.put("type", stats.device.type);
    });
    json.object("options", [&] {
      json.put("width", settings.width);
      json.put("height", settings.height);
      json.put("samples", settings.samples);
      json.put("depth", settings.depth);
      json.put("sampler", samplerName(settings.sampler));
      json.put("seed", settings.seed);
      json.put("min_weight", settings.minWeight);
      json.put("backend", stats.backend);
      json.put("geometry", stats.geometry);
      json.put("fetch", stats.access);
      json.put("crop", cropText(settings.crop));
    });
    putParameters(json, "params", stats.parameters);
    json.object("kernel", [&] {
      json.put("edited", stats.editedKernel);
      json.array("added", [&] {
        for (const std::string& name : stats.addedFeatures) json.put(name);
      });
    });
    json.object("primitives", [&] {
      for (const PrimitiveCount& type : stats.primitives) json.put(type.name.c_str(), type.count);
    });
    putCounts(json, "rays", stats.rays);
    putCounts(json, "nodes_visited", stats.visits.nodes);
    putCounts(json, "primitives_tested", stats.visits.primitives);
    json.object("seconds", [&] {
      json.put("load", stats.seconds.load);
      json.put("build", stats.seconds.build);
      json.put("compile", stats.seconds.compile);
      json.put("upload", stats.seconds.upload);
      json.put("trace", stats.seconds.trace);
      json.put("readback", stats.seconds.readback);
      json.put("total", stats.seconds.total);
    });
    json.put("mrays_per_second",
             stats.seconds.trace > 0 ? double(stats.rays.total()) / stats.seconds.trace * 1e-6 : 0.0);
    json.object("tree", [&] {
      uint64_t primitives = 0;
      for (const PrimitiveCount& type : stats.primitives) primitives += type.count;
      json.put("nodes", stats.treeNodes);
      json.put("depth", stats.treeDepth);
      json.put("bytes_per_primitive", primitives > 0 ? double(stats.geometryBytes) / double(primitives) : 0.0);
    });
  });
  return json.text();
}

std::string comparisonJson(const Comparison& comparison, const std::optional<Decomposition>& decomposition,
                           const std::optional<EnvelopeRule>& envelope) {
  JsonWriter json;
  json.object([&] {
    putFigures(json, comparison);
    if (decomposition) {
      json.object("decompose", [&] {
        const SamplingError& sampling = decomposition->sampling;
        json.object("sampling", [&] {
          putFigures(json, sampling.figures);
          json.put("own_error", sampling.ownError);
          json.put("converged", sampling.converged);
          json.put("samples", sampling.samples);
        });
        json.object("arithmetic", [&] { putFigures(json, decomposition->arithmetic); });
        json.object("quantisation", [&] { putFigures(json, decomposition->quantisation); });
      });
    }
    if (envelope) {
      json.object("envelope", [&] {
        json.put("needed", envelope->needed);
        json.put("excused", envelope->excused);
        json.put("outside", envelope->outside);
        json.put("p99", envelope->p99);
        json.put("p999", envelope->p999);
      });
    }
  });
  return json.text();
}

std::string devicesJson(const std::vector<DeviceInfo>& devices) {
  JsonWriter json;
  json.array([&] {
    for (const DeviceInfo& device : devices) {
      json.object([&] {
        json.put("index", device.index);
        json.put("name", device.name);
        json.put("type", device.type);
        json.put("driver", device.driver);
        json.put("api", device.api);
        json.put("usable", device.usable);
      });
    }
  });
  return json.text();
}

}  // namespace turner
