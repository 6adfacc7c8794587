// The page is written whole: charts as SVG, pictures as PNG in it; page/ has its frame, style and script (compiled in).
#include "report/page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/base64.h"
#include "image/png.h"
#include "image/provenance.h"
#include "report/chart.h"
#include "report/error_colours.h"
#include "report/figures.h"
#include "report/findings.h"
#include "report/page_charts.h"
#include "report_page_parts.h"

namespace turner::report {
namespace {

// So many points have their pictures in the page; those of the Pareto front come first.
constexpr size_t kMostPictures = 8;

std::string dataUri(const Image& image) {
  return "data:image/png;base64," + base64(encodePng(image));
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
    for (size_t i = 0; i < scenes.size(); ++i) section(i, scenes[i]);
    return fmt::format(kPageFrame, fmt::arg("title", escaped(scenes.empty() ? "" : scenes[0].path)),
                       fmt::arg("style", kPageStyle), fmt::arg("script", kPageScript),
                       fmt::arg("version", escaped(machine_.version)), fmt::arg("date", escaped(machine_.date)),
                       fmt::arg("processor", escaped(machine_.processor)), fmt::arg("cores", machine_.cores),
                       fmt::arg("system", escaped(machine_.system)), fmt::arg("repeats", machine_.repeats),
                       fmt::arg("renderers", scenes.empty() ? "" : renderers(scenes[0])),
                       fmt::arg("command", escaped(machine_.command)), fmt::arg("scenes", text_));
  }

 private:
  template <class... Arguments>
  void add(fmt::format_string<Arguments...> format, Arguments&&... arguments) {
    text_ += fmt::format(format, std::forward<Arguments>(arguments)...);
  }

  // Who they are, in a paragraph.
  static std::string renderers(const SweptScene& scene) {
    std::string text = "<p class='about'>";
    for (const auto& renderer : scene.renderers)
      text += fmt::format("<b>{}</b>: {} ({}), {}. ", escaped(renderer.name), escaped(renderer.device),
                          escaped(renderer.type), escaped(renderer.driver));
    return text + "</p>\n";
  }

  void section(size_t number, const SweptScene& scene) {
    const RenderSettings& whole = scene.whole;
    add("<section class='scene'>\n<h2>{}</h2>\n", escaped(scene.path));
    add("<p class='about'>{}; {} x {} pixels", toText(scene.primitives), whole.width, whole.height);
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
      add("<p class='note'>--depth and --min-weight were not measured: no material reflects or transmits, the depth is "
          "1, or --no-cut-offs was given.</p>\n");
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

  const Machine& machine_;
  const PictureOf& pictureOf_;
  std::string text_;  // of the scenes
};

}  // namespace

std::string reportPage(const Machine& machine, const std::vector<SweptScene>& scenes, const PictureOf& pictureOf) {
  return Page(machine, pictureOf).write(scenes);
}

}  // namespace turner::report
