// A chart with logarithmic axes as SVG: drawn here and not in the browser, so that it prints, and needs no script.
#pragma once

#include <string>
#include <vector>

namespace turner::report {

struct DataPoint {
  double x = 1, y = 1;       // > 0; others are not drawn
  std::string label;         // shown on hover
  std::string id;            // of what the point stands for: data-point
  std::string note;          // printed beside it
  bool highlighted = false;  // on the Pareto front
};

// Colour and shape show the kind of a series, dashes and filled, hollow or edged points show whose it is:
// either is enough.
enum class Shape { circle, square, triangle, diamond, cross };
struct Series {
  std::string name;  // in the legend
  std::vector<DataPoint> points;
  int color = 0;  // of the palette
  Shape shape = Shape::circle;
  int dashes = 0;      // kind of line, and of point
  bool joined = true;  // by lines
};

struct Chart {
  std::string title, xName, yName;  // the title is for those who do not see the chart
  std::vector<Series> series;
  std::vector<double> guides;                          // horizontal lines
  std::string paretoStepsName;                         // in the legend
  std::vector<std::pair<double, double>> paretoSteps;  // the Pareto front: what is reached at x holds until the next
};

// Whole: without style sheets or scripts of others.
std::string svgOf(const Chart& chart);

// Text for HTML and SVG.
std::string escaped(const std::string& text);

}  // namespace turner::report
