// Values -> places on logarithmic axes -> shapes of SVG.
#include "report/chart.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace turner::report {
namespace {

constexpr double kWidth = 860, kLeastHeight = 430;
constexpr double kLeft = 74, kRight = 250, kTop = 14, kBottom = 52;  // margins; the legend is in the right one

// Okabe and Ito, "Color Universal Design" (2008): told apart with every kind of colour vision.
constexpr const char* kPalette[] = {"#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00"};
constexpr const char* kDashes[] = {"", "7 4", "2 3", "10 3 2 3", "1 5"};
constexpr double kLegendRow = 20;

// The height that the legend needs, if it is more than the usual one.
double heightOf(const Chart& chart) {
  return std::max(kLeastHeight, kTop + kLegendRow * double(chart.series.size() + 2));
}

// One axis: values to places.
class Axis {
 public:
  Axis(double least, double most, double from, double to) : from_(from), to_(to) {
    low_ = std::log10(least);
    high_ = std::log10(most);
    const double room = std::max(0.06 * (high_ - low_), 0.03);
    low_ -= room;
    high_ += room;
  }
  double place(double value) const { return from_ + (std::log10(value) - low_) / (high_ - low_) * (to_ - from_); }

  // Decades; where these are few their 2 and 5, and where those are, all their digits; the ends, if nothing else is
  // there.
  std::vector<double> ticks() const {
    for (const auto& digits : {std::vector{1.0}, {1.0, 2.0, 5.0}, {1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0}}) {
      std::vector<double> found;
      for (int decade = int(std::floor(low_)); decade <= int(std::ceil(high_)); ++decade)
        for (const double digit : digits) {
          const double value = digit * std::pow(10.0, decade), at = std::log10(value);
          if (at >= low_ && at <= high_) found.push_back(value);
        }
      if (found.size() >= 3 || (found.size() == 2 && digits.size() == 9)) return found;
    }
    return {std::pow(10.0, low_), std::pow(10.0, high_)};
  }

 private:
  double low_, high_, from_, to_;
};

std::string shapeAt(Shape shape, double x, double y, const std::string& style) {
  constexpr double r = 4.5;
  switch (shape) {
    case Shape::circle:
      return fmt::format("<circle cx='{:.2f}' cy='{:.2f}' r='{}' {}/>", x, y, r, style);
    case Shape::square:
      return fmt::format("<rect x='{:.2f}' y='{:.2f}' width='{}' height='{}' {}/>", x - 4, y - 4, 8, 8, style);
    case Shape::triangle:
      return fmt::format("<path d='M{:.2f} {:.2f}l5.2 9h-10.4z' {}/>", x, y - 5.5, style);
    case Shape::diamond:
      return fmt::format("<path d='M{:.2f} {:.2f}l5.5 5.5l-5.5 5.5l-5.5 -5.5z' {}/>", x, y - 5.5, style);
    case Shape::cross:
      return fmt::format("<path d='M{:.2f} {:.2f}h3v-3h3v3h3v3h-3v3h-3v-3h-3z' {}/>", x - 4.5, y - 1.5, style);
  }
  return "";
}

bool isDrawn(const DataPoint& dataPoint) {
  return dataPoint.x > 0 && dataPoint.y > 0 && std::isfinite(dataPoint.x) && std::isfinite(dataPoint.y);
}

std::string numberText(double value) {
  return fmt::format("{:.3g}", value);
}

// Filled, hollow, or filled with a dark edge.
std::string styleOf(const Series& series) {
  const char* color = kPalette[series.color];
  switch (series.dashes % 3) {
    case 0:
      return fmt::format("fill='{}' stroke='#fff' stroke-width='.8'", color);
    case 1:
      return fmt::format("fill='#fff' stroke='{}' stroke-width='1.6'", color);
    default:
      return fmt::format("fill='{}' stroke='#111' stroke-width='1.4'", color);
  }
}

// The parts of the picture, one after the other.
class Drawing {
 public:
  Drawing(const Chart& chart, const Axis& x, const Axis& y, double height)
      : chart_(chart), x_(x), y_(y), height_(height) {}

  std::string draw() {
    add("<svg xmlns='http://www.w3.org/2000/svg' class='chart' viewBox='0 0 {} {}' role='img' font-family='sans-serif' "
        "font-size='12'><title>{}</title>",
        kWidth, height_, escaped(chart_.title));
    add("<rect width='{}' height='{}' fill='#fff'/>", kWidth, height_);
    axes();
    paretoSteps();
    for (const Series& series : chart_.series) line(series);
    for (const Series& series : chart_.series) points(series);
    legend();
    add("</svg>\n");
    return text_;
  }

 private:
  template <class... Arguments>
  void add(fmt::format_string<Arguments...> format, Arguments&&... arguments) {
    text_ += fmt::format(format, std::forward<Arguments>(arguments)...);
    text_ += '\n';
  }

  void axes() {
    const double right = kWidth - kRight, bottom = height_ - kBottom;
    for (const double tick : x_.ticks()) {
      add("<path d='M{:.2f} {}V{}' stroke='#e4e4e4'/>", x_.place(tick), kTop, bottom);
      add("<text x='{:.2f}' y='{}' text-anchor='middle' fill='#333'>{}</text>", x_.place(tick), bottom + 17,
          numberText(tick));
    }
    for (const double tick : y_.ticks()) {
      add("<path d='M{} {:.2f}H{}' stroke='#e4e4e4'/>", kLeft, y_.place(tick), right);
      add("<text x='{}' y='{:.2f}' text-anchor='end' fill='#333'>{}</text>", kLeft - 7, y_.place(tick) + 4,
          numberText(tick));
    }
    for (const double guide : chart_.guides) {
      const double at = y_.place(guide);
      if (at < kTop || at > bottom) continue;
      add("<path d='M{} {:.2f}H{}' stroke='#777' stroke-dasharray='1 4'/>", kLeft, at, right);
    }
    add("<path d='M{} {}V{}H{}' fill='none' stroke='#333'/>", kLeft, kTop, bottom, right);
    add("<text x='{}' y='{}' text-anchor='middle' fill='#111'>{}</text>", (kLeft + right) / 2, height_ - 12,
        escaped(chart_.xName));
    add("<text transform='translate(16 {}) rotate(-90)' text-anchor='middle' fill='#111'>{}</text>",
        (kTop + bottom) / 2, escaped(chart_.yName));
  }

  // What is reached stays reached until something better is.
  void paretoSteps() {
    std::string path;
    for (const auto& [x, y] : chart_.paretoSteps) {
      if (!(x > 0 && y > 0)) continue;
      if (path.empty())
        path = fmt::format("M{:.2f} {:.2f}", x_.place(x), y_.place(y));
      else
        path += fmt::format("H{:.2f}V{:.2f}", x_.place(x), y_.place(y));
    }
    if (!path.empty())
      add("<path class='front' d='{}' fill='none' stroke='#bbb' stroke-width='5' stroke-linejoin='round'/>", path);
  }

  void line(const Series& series) {
    if (!series.joined) return;
    std::string path;
    for (const DataPoint& dataPoint : series.points)
      if (isDrawn(dataPoint))
        path += fmt::format("{}{:.2f} {:.2f}", path.empty() ? 'M' : 'L', x_.place(dataPoint.x), y_.place(dataPoint.y));
    if (path.empty()) return;
    add("<path class='curve' d='{}' fill='none' stroke='{}' stroke-width='1.6' stroke-dasharray='{}'/>", path,
        kPalette[series.color], kDashes[series.dashes]);
  }

  void points(const Series& series) {
    for (const DataPoint& dataPoint : series.points) {
      if (!isDrawn(dataPoint)) continue;
      const double x = x_.place(dataPoint.x), y = y_.place(dataPoint.y);
      add("<g class='point' tabindex='0' data-point='{}' data-label='{}'><title>{}</title>", escaped(dataPoint.id),
          escaped(dataPoint.label), escaped(dataPoint.label));
      if (dataPoint.highlighted)
        add("<circle cx='{:.2f}' cy='{:.2f}' r='8' fill='none' stroke='#111' stroke-width='1.2'/>", x, y);
      add("{}</g>", shapeAt(series.shape, x, y, styleOf(series)));
      if (!dataPoint.note.empty() && isFree(x, y))
        add("<text x='{:.2f}' y='{:.2f}' fill='#111' font-size='11' paint-order='stroke' stroke='#fff' "
            "stroke-width='3'>{}</text>",
            x + 10, y - 6, escaped(dataPoint.note));
    }
  }

  // Whether a note beside this place would not lie on another; takes the place.
  bool isFree(double x, double y) {
    for (const auto& [otherX, otherY] : noted_)
      if (std::abs(x - otherX) < 46 && std::abs(y - otherY) < 13) return false;
    noted_.emplace_back(x, y);
    return true;
  }

  void legend() {
    double y = kTop + 12;
    const double x = kWidth - kRight + 18;
    for (const Series& series : chart_.series) {
      if (series.joined)
        add("<path d='M{} {}h30' stroke='{}' stroke-width='1.6' stroke-dasharray='{}'/>", x, y, kPalette[series.color],
            kDashes[series.dashes]);
      add("{}", shapeAt(series.shape, x + 15, y, styleOf(series)));
      add("<text x='{}' y='{}' fill='#111'>{}</text>", x + 38, y + 4, escaped(series.name));
      y += kLegendRow;
    }
    if (chart_.paretoSteps.empty()) return;
    add("<path d='M{} {}h30' stroke='#bbb' stroke-width='5'/>", x, y);
    add("<circle cx='{}' cy='{}' r='8' fill='none' stroke='#111' stroke-width='1.2'/>", x + 15, y);
    add("<text x='{}' y='{}' fill='#111'>{}</text>", x + 38, y + 4, escaped(chart_.paretoStepsName));
  }

  const Chart& chart_;
  const Axis &x_, &y_;
  double height_;
  std::vector<std::pair<double, double>> noted_;
  std::string text_;
};

}  // namespace

std::string escaped(const std::string& text) {
  std::string result;
  for (const char c : text) {
    switch (c) {
      case '&':
        result += "&amp;";
        break;
      case '<':
        result += "&lt;";
        break;
      case '>':
        result += "&gt;";
        break;
      case '"':
        result += "&quot;";
        break;
      case '\'':
        result += "&#39;";
        break;
      default:
        result += c;
    }
  }
  return result;
}

std::string svgOf(const Chart& chart) {
  double leastX = HUGE_VAL, mostX = 0, leastY = HUGE_VAL, mostY = 0;
  for (const Series& series : chart.series)
    for (const DataPoint& dataPoint : series.points) {
      if (!isDrawn(dataPoint)) continue;
      leastX = std::min(leastX, dataPoint.x);
      mostX = std::max(mostX, dataPoint.x);
      leastY = std::min(leastY, dataPoint.y);
      mostY = std::max(mostY, dataPoint.y);
    }
  if (!(mostX > 0)) return "<p>There is nothing to draw: no error is a number above 0.</p>\n";
  const double height = heightOf(chart);
  const Axis x(leastX, mostX, kLeft, kWidth - kRight), y(leastY, mostY, height - kBottom, kTop);
  return Drawing(chart, x, y, height).draw();
}

}  // namespace turner::report
