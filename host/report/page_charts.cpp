// Points and curves -> series of a chart.
#include "report/page_charts.h"

#include <fmt/format.h>

#include <iterator>
#include <utility>

#include "image/provenance.h"
#include "report/chart.h"
#include "report/figures.h"
#include "report/findings.h"

namespace turner::report {
namespace {

std::string labelOf(const SweptScene& scene, const SweepPoint& point) {
  return fmt::format(
      "{}\n{}, RMSE {:.3g}\nof that sampling {:.2g}, cut off {:.2g}, arithmetic {:.2g}, quantisation {:.2g}",
      pointInWords(scene, point), timeInWords(point.medianSeconds()), point.rmse, point.sampling.rmse,
      point.cutOff.rmse, point.arithmetic.rmse, point.quantisation.rmse);
}

Shape shapeOf(Sampler sampler) {
  return sampler == Sampler::grid ? Shape::square : sampler == Sampler::jitter ? Shape::circle : Shape::triangle;
}

Series seriesOf(const SweptScene& scene, const Curve& curve) {
  Series series;
  series.name = fmt::format("{}, {}", scene.renderers[curve.renderer].name, samplerName(curve.sampler));
  if (curve.slope) series.name += fmt::format(" (slope {:.2f})", *curve.slope);
  series.color = int(curve.sampler);
  series.shape = shapeOf(curve.sampler);
  series.dashes = int(curve.renderer % 5);
  return series;
}

// Depths or least weights, of one renderer.
Series cutSeries(const SweptScene& scene, size_t renderer, bool depths) {
  Series series;
  series.name = fmt::format("{}, {}", scene.renderers[renderer].name, depths ? "less depth" : "least weights");
  series.color = depths ? 3 : 5;
  series.shape = depths ? Shape::diamond : Shape::cross;
  series.dashes = int(renderer % 5);
  series.joined = false;
  return series;
}

DataPoint dataPointOf(const SweptScene& scene, const SweepPoint& point, double x, bool onFront) {
  const Setting& setting = point.setting;
  DataPoint dataPoint{x, point.rmse, labelOf(scene, point), point.name, "", onFront};
  if (!onFront) return dataPoint;
  dataPoint.note = fmt::format("{}x{}", setting.samples, setting.samples);
  if (setting.depth != scene.whole.depth) dataPoint.note = fmt::format("depth {}", setting.depth);
  if (setting.minWeight > 0) dataPoint.note = fmt::format("weight {}", setting.minWeight);
  return dataPoint;
}

}  // namespace

std::string errorOverTime(const SweptScene& scene) {
  Chart chart{"RMSE over time of tracing", "time of tracing, seconds", "RMSE", {}, {}, "Pareto front", {}};
  chart.guides.assign(std::begin(kTargets), std::end(kTargets));
  const std::vector<size_t> front = paretoFront(scene);
  const std::vector<bool> onFront = isOnFront(scene);
  for (const Curve& curve : curvesOf(scene)) {
    Series series = seriesOf(scene, curve);
    for (const size_t i : curve.points)
      series.points.push_back(dataPointOf(scene, scene.points[i], scene.points[i].medianSeconds(), onFront[i]));
    chart.series.push_back(std::move(series));
  }
  for (const bool depths : {true, false})
    for (size_t renderer = 0; renderer < scene.renderers.size(); ++renderer) {
      Series series = cutSeries(scene, renderer, depths);
      for (size_t i = 0; i < scene.points.size(); ++i) {
        const SweepPoint& point = scene.points[i];
        const bool isDepth = point.setting.depth != scene.whole.depth, isWeight = point.setting.minWeight > 0;
        if (point.renderer == renderer && (depths ? isDepth : isWeight))
          series.points.push_back(dataPointOf(scene, point, point.medianSeconds(), onFront[i]));
      }
      if (!series.points.empty()) chart.series.push_back(std::move(series));
    }
  for (const size_t i : front) chart.paretoSteps.emplace_back(scene.points[i].medianSeconds(), scene.points[i].rmse);
  return svgOf(chart);
}

std::string errorOverSamples(const SweptScene& scene) {
  Chart chart{"RMSE over samples in each pixel", "samples in each pixel", "RMSE", {}, {}, "", {}};
  // The error hardly depends on who renders: that of the first who has any is drawn.
  const std::vector<Curve> curves = curvesOf(scene);
  for (const Curve& curve : curves) {
    if (curve.renderer != curves.front().renderer) continue;
    Series series = seriesOf(scene, curve);
    for (const size_t i : curve.points) {
      const SweepPoint& point = scene.points[i];
      series.points.push_back(dataPointOf(scene, point, double(point.setting.samples) * point.setting.samples, false));
    }
    chart.series.push_back(std::move(series));
  }
  return svgOf(chart);
}

}  // namespace turner::report
