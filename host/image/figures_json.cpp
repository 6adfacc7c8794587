#include "image/figures_json.h"

namespace turner {

void putFigures(JsonWriter& json, const Comparison& comparison) {
  json.put("rmse", comparison.rmse);
  json.put("rel_rmse", comparison.relRmse);
  json.put("mae", comparison.mae);
  json.put("max", comparison.max);
  json.put("mean_signed", comparison.meanSigned);
  json.put("p50", comparison.p50);
  json.put("p99", comparison.p99);
  json.put("p999", comparison.p999);
  json.put("bad_pixels", comparison.badPixels);
  json.put("nan", comparison.nan);
  json.put("inf", comparison.inf);
  json.put("width", comparison.width);
  json.put("height", comparison.height);
}

void putCounts(JsonWriter& json, const char* key, const RayCounts& counts) {
  json.object(key, [&] {
    json.put("eye", counts.eye);
    json.put("reflected", counts.reflected);
    json.put("refracted", counts.refracted);
    json.put("shadow", counts.shadow);
  });
}

}  // namespace turner
