// The page is written whole: charts as SVG, pictures as PNG in it, style and script from page/ (compiled in).
#include "report/page.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "image/png.h"
#include "report/chart.h"
#include "report_page_parts.h"

namespace turner::report {
namespace {

// So many points have their pictures in the page; those of the Pareto front come first.
constexpr size_t kMostPictures = 8;
// Errors from 1e-4 to 1, in decades.
constexpr double kDarkest = -4;

std::string base64(const std::string& bytes) {
  constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (size_t i = 0; i < bytes.size(); i += 3) {
    uint32_t word = 0;
    for (size_t k = 0; k < 3; ++k) word = word << 8 | (i + k < bytes.size() ? uint8_t(bytes[i + k]) : 0u);
    for (size_t k = 0; k < 4; ++k) text += k <= bytes.size() - i ? kDigits[word >> (18 - 6 * k) & 63] : '=';
  }
  return text;
}

std::string dataUri(const Image& image) {
  return "data:image/png;base64," + base64(encodePng(image));
}

// The inverse of what encodePng applies (IEC 61966-2-1).
float linearOf(double srgb) {
  return float(srgb <= 0.04045 ? srgb / 12.92 : std::pow((srgb + 0.055) / 1.055, 2.4));
}

// viridis (van der Walt and Smith, matplotlib, CC0) at five places: lightness rises evenly, for every kind of colour
// vision and in grey.
constexpr std::array<std::array<double, 3>, 5> kColours = {
    {{0x44, 0x01, 0x54}, {0x3b, 0x52, 0x8b}, {0x21, 0x91, 0x8c}, {0x5e, 0xc9, 0x62}, {0xfd, 0xe7, 0x25}}};
constexpr const char* kColourBar = "#440154, #3b528b, #21918c, #5ec962, #fde725";

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

// Those of the front, then the best of each curve.
std::vector<size_t> picturedPoints(const SweptScene& scene) {
  std::vector<size_t> chosen;
  const auto add = [&](size_t i) {
    if (chosen.size() < kMostPictures && std::find(chosen.begin(), chosen.end(), i) == chosen.end())
      chosen.push_back(i);
  };
  const std::vector<size_t> front = paretoFront(scene);
  // From the best down, so that the best is always there.
  for (size_t i = front.size(); i-- > 0;) add(front[i]);
  for (const Curve& curve : curvesOf(scene)) add(curve.points.back());
  return chosen;
}

class Page {
 public:
  Page(const Machine& machine, const PictureOf& pictureOf) : machine_(machine), pictureOf_(pictureOf) {}

  std::string write(const std::vector<SweptScene>& scenes) {
    head(scenes);
    for (size_t i = 0; i < scenes.size(); ++i) section(i, scenes[i]);
    howToRead();
    add("<div id='label' role='status' hidden></div>\n<script>\n{}</script>\n</body>\n</html>\n", kPageScript);
    return text_;
  }

 private:
  template <class... Arguments>
  void add(fmt::format_string<Arguments...> format, Arguments&&... arguments) {
    text_ += fmt::format(format, std::forward<Arguments>(arguments)...);
  }

  void head(const std::vector<SweptScene>& scenes) {
    add("<!DOCTYPE html>\n<html lang='en'>\n<head>\n<meta charset='utf-8'>\n<meta name='viewport' "
        "content='width=device-width, initial-scale=1'>\n<link rel='icon' href='data:,'>\n<title>Speed against error: "
        "{}</title>\n<style>\n{}</style>\n</head>\n<body>\n",
        escaped(scenes.empty() ? "" : scenes[0].path), kPageStyle);
    add("<h1>Speed against error</h1>\n<p class='about'>turner {}, {}. {}, {} cores; {}. Times are of tracing, warm: "
        "the median of {} interleaved repeats.</p>\n",
        escaped(machine_.version), escaped(machine_.date), escaped(machine_.processor), machine_.cores,
        escaped(machine_.system), machine_.repeats);
    if (!scenes.empty()) {
      add("<p class='about'>");
      for (const auto& renderer : scenes[0].renderers)
        add("<b>{}</b>: {} ({}), {}. ", escaped(renderer.name), escaped(renderer.device), escaped(renderer.type),
            escaped(renderer.driver));
      add("</p>\n");
    }
    add("<p class='about'>This report again: <code>{}</code></p>\n", escaped(machine_.command));
  }

  void section(size_t number, const SweptScene& scene) {
    const RenderSettings& whole = scene.whole;
    add("<section class='scene'>\n<h2>{}</h2>\n", escaped(scene.path));
    add("<p class='about'>{} spheres, {} triangles; {} x {} pixels", scene.spheres, scene.triangles, whole.width,
        whole.height);
    if (!(whole.crop == Window{0, 0, whole.width, whole.height}))
      add(", of which x {} to {}, y {} to {} are rendered", whole.crop.x0, whole.crop.x1 - 1, whole.crop.y0,
          whole.crop.y1 - 1);
    add("; depth {}.</p>\n<ul class='findings'>\n", whole.depth);
    for (const std::string& sentence : findings(scene)) add("<li>{}</li>\n", escaped(sentence));
    add("</ul>\n");
    const Converged& converged = scene.converged;
    add("<p class='note'>Errors are against a converged picture by {}: {} samples in each pixel, half of them "
        "jittered, half sobol's, with seeds of their own. Its own rms error is {:.2g}{}, and is subtracted.</p>\n",
        escaped(scene.renderers[scene.convergedBy.renderer].name), 2 * converged.samples * converged.samples,
        converged.ownError,
        converged.enough ? fmt::format(", at most a quarter of the least error found ({:.2g})", converged.leastError)
                         : fmt::format(": MORE than a quarter of the least error found ({:.2g}); the smallest errors "
                                       "here are not to be trusted",
                                       converged.leastError));
    add("<h3>Error over time</h3>\n{}", errorOverTime(scene));
    add("<h3>Error over samples</h3>\n{}", errorOverSamples(scene));
    pictures(number, scene);
    cutOffs(scene);
    reaches(scene);
    table(scene);
    add("</section>\n");
  }

  void pictures(size_t number, const SweptScene& scene) {
    const std::vector<size_t> chosen = picturedPoints(scene);
    if (chosen.empty()) return;
    add("<h3>Picture and error</h3>\n<div class='choose'><label>picture <select class='which'>");
    for (const size_t i : chosen)
      add("<option value='{}'>{}</option>", escaped(scene.points[i].name),
          escaped(pointInWords(scene, scene.points[i])));
    add("</select></label> <label>beside it <select class='other'><option value='error'>its error</option><option "
        "value='converged'>the converged picture</option></select></label></div>\n");
    std::string list, first;
    for (const size_t i : chosen) {
      const SweepPoint& point = scene.points[i];
      const Image image = pictureOf_(number, point);
      const std::string picture = dataUri(image), error = dataUri(colouredError(image, scene.converged.mean));
      list += fmt::format("{}\"{}\":{{\"picture\":\"{}\",\"error\":\"{}\"}}", list.empty() ? "" : ",", point.name,
                          picture, error);
      if (first.empty())
        first = fmt::format("<img class='left' alt='the picture' src='{}'><img class='right' alt='its error' src='{}'>",
                            picture, error);
    }
    add("<div class='compare'>{}<input type='range' min='0' max='100' value='50' aria-label='how much of the picture "
        "is seen'></div>\n",
        first);
    add("<p class='scale'>|error| of the worst channel: 1e-4 <span style='background:linear-gradient(to right, "
        "{})'></span> 1, logarithmic</p>\n",
        kColourBar);
    add("<script type='application/json' class='pictures'>{{\"converged\":\"{}\",\"points\":{{{}}}}}</script>\n",
        dataUri(scene.converged.mean), list);
  }

  void cutOffs(const SweptScene& scene) {
    const bool any = std::any_of(scene.points.begin(), scene.points.end(),
                                 [&](const SweepPoint& p) { return p.setting != uncut(p.setting, scene.whole); });
    if (!any) {
      add("<p class='note'>--depth and --min-weight change nothing here: no material reflects or transmits, or the "
          "depth is 1.</p>\n");
      return;
    }
    add("<h3>What --depth and --min-weight cut off</h3>\n<p class='note'>Against the same samples at depth {} without "
        "a least weight, so that there is no noise in it. Bias is the mean signed error: what is cut off is light that "
        "is missing.</p>\n<div class='wide'><table class='cuts'><thead><tr><th>setting</th><th>time</th><th>share of "
        "the time</th><th>rms cut off</th><th>largest</th><th>bias</th></tr></thead><tbody>\n",
        scene.whole.depth);
    for (const SweepPoint& point : scene.points) {
      if (point.setting == uncut(point.setting, scene.whole)) continue;
      add("<tr><td>{}</td><td>{}</td><td>{:.2f}</td><td>{:.2e}</td><td>{:.2e}</td><td>{:+.2e}</td></tr>\n",
          escaped(pointInWords(scene, point)), timeInWords(point.medianSeconds()),
          point.medianSeconds() / uncutPoint(scene, point).medianSeconds(), point.cutOff.rmse, point.cutOff.max,
          point.cutOff.meanSigned);
    }
    add("</tbody></table></div>\n");
  }

  void reaches(const SweptScene& scene) {
    add("<h3>What an error costs</h3>\n<div class='wide'><table "
        "class='reaches'><thead><tr><th>curve</th><th>slope</th>");
    for (const double target : kTargets) add("<th>time to RMSE {:g}</th><th>samples</th>", target);
    add("</tr></thead><tbody>\n");
    for (const Curve& curve : curvesOf(scene)) {
      add("<tr><td>{}, {}</td><td>{}</td>", escaped(scene.renderers[curve.renderer].name), samplerName(curve.sampler),
          curve.slope ? fmt::format("{:.2f}", *curve.slope) : "");
      for (const std::optional<Reach>& reach : curve.targets) {
        if (reach)
          add("<td>{}{}</td><td>{:.3g}</td>", timeInWords(reach->seconds), reach->extrapolated ? " *" : "",
              reach->samples);
        else
          add("<td></td><td></td>");
      }
      add("</tr>\n");
    }
    add("</tbody></table></div>\n<p class='note'>* extrapolated along the slope, beyond what was measured</p>\n");
  }

  void table(const SweptScene& scene) {
    constexpr const char* kColumns[] = {"setting",  "median time", "fastest",   "slowest",     "RMSE",
                                        "relative", "sampling",    "cut off",   "quantis.",    "arithm.",
                                        "bias",     "p50",         "p99",       "p99.9",       "max",
                                        "NaN",      "inf",         "1/(MSE s)", "to repeat it"};
    add("<h3>All points</h3>\n<p class='note'>Bold: on the Pareto front. Click on a heading to sort by it, on a row to "
        "see it in the charts.</p>\n<div class='wide'><table class='points'><thead><tr>");
    for (const char* column : kColumns)
      add("<th scope='col'{}><button>{}</button></th>", column == std::string("to repeat it") ? " class='command'" : "",
          column);
    add("</tr></thead><tbody>\n");
    const std::vector<bool> onFront = isOnFront(scene);
    for (size_t i = 0; i < scene.points.size(); ++i) {
      const SweepPoint& p = scene.points[i];
      add("<tr class='{}' data-point='{}'><td>{}</td>", onFront[i] ? "front" : "", escaped(p.name),
          escaped(pointInWords(scene, p)));
      for (const double seconds : {p.medianSeconds(), p.fastest(), p.slowest()})
        add("<td data-value='{}'>{}</td>", seconds, timeInWords(seconds));
      for (const double figure :
           {p.rmse, p.relRmse, p.sampling.rmse, p.cutOff.rmse, p.quantisation.rmse, p.arithmetic.rmse,
            p.total.meanSigned, p.total.p50, p.total.p99, p.total.p999, p.total.max})
        cell(figure, fmt::format("{:.2e}", figure));
      for (const uint64_t count : {p.total.nan, p.total.inf}) add("<td data-value='{}'>{}</td>", count, count);
      cell(p.efficiency(), fmt::format("{:.3g}", p.efficiency()));
      add("<td class='command'><code>{}</code></td></tr>\n", escaped(renderCommand(scene, p, machine_.shaders)));
    }
    add("</tbody></table></div>\n");
  }

  // Empty where there is no number.
  void cell(double value, const std::string& text) {
    if (std::isfinite(value))
      add("<td data-value='{}'>{}</td>", value, text);
    else
      add("<td data-value=''></td>");
  }

  void howToRead() {
    add("<h2>How to read this</h2>\n<ul>\n<li><b>RMSE</b>: root mean square over linear R, G and B of the picture "
        "minus the converged one, and over the repeats, each of which has a seed of its own. The other figures are of "
        "seed 0.</li>\n<li><b>Pareto front</b>: no other setting is both faster and less wrong, by a "
        "hundredth.</li>\n<li><b>Slope</b>: of log RMSE over log samples. Random samples have -0.5; at edges "
        "stratified ones have -0.75, on smooth shading -1.</li>\n<li><b>Sampling, cut off, quantisation, "
        "arithmetic</b>: the steps from the converged picture to this one. The reference at the same samples; with "
        "this depth and least weight; of the scene rounded to float32; the shader of that.</li>\n<li><b>Bias</b>: mean "
        "signed error. <b>p99.9</b>: one pixel in a thousand is off by more.</li>\n</ul>\n");
  }

  const Machine& machine_;
  const PictureOf& pictureOf_;
  std::string text_;
};

}  // namespace

Image colouredError(const Image& a, const Image& b) {
  Image coloured(a.width, a.height, a.window);
  for (size_t i = 0; i < coloured.rgb.size(); i += 3) {
    double error = 0;
    for (size_t c = 0; c < 3; ++c) {
      const double difference = std::abs(double(a.rgb[i + c]) - double(b.rgb[i + c]));
      if (!(difference <= error)) error = std::isnan(difference) ? HUGE_VAL : difference;
    }
    const double place =
        std::clamp((std::log10(std::max(error, 1e-30)) - kDarkest) / -kDarkest, 0.0, 1.0) * double(kColours.size() - 1);
    const size_t low = std::min(size_t(place), kColours.size() - 2);
    for (size_t c = 0; c < 3; ++c) {
      const double share = place - double(low);
      coloured.rgb[i + c] = linearOf(((1 - share) * kColours[low][c] + share * kColours[low + 1][c]) / 255);
    }
  }
  return coloured;
}

std::string reportPage(const Machine& machine, const std::vector<SweptScene>& scenes, const PictureOf& pictureOf) {
  return Page(machine, pictureOf).write(scenes);
}

}  // namespace turner::report
