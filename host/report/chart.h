// A chart with logarithmic axes as SVG: drawn here and not in the browser, so that it prints, and needs no script.
#pragma once

#include <string>
#include <vector>

namespace turner::report {

struct Mark {
  double x = 1, y = 1;  // > 0; others are not drawn
  std::string label;    // shown on hover
  std::string id;       // of what the mark stands for: data-point
  std::string note;     // printed beside it
  bool ringed = false;  // on the Pareto front
};

// What a series is of is told by colour and by shape, whose it is by dashes and by filled, hollow or edged marks:
// either is enough.
enum class Shape { circle, square, triangle, diamond, cross };
struct Series {
  std::string name;  // in the legend
  std::vector<Mark> marks;
  int color = 0;  // of the palette
  Shape shape = Shape::circle;
  int dashes = 0;      // kind of line; and of mark
  bool joined = true;  // by lines
};

struct Chart {
  std::string title, xName, yName;  // the title is for those who do not see the chart
  std::vector<Series> series;
  std::vector<double> guides;                     // horizontal lines
  std::string stairsName;                         // in the legend
  std::vector<std::pair<double, double>> stairs;  // the Pareto front: what is reached at x holds until the next
};

// Whole: without style sheets or scripts of others.
std::string svgOf(const Chart& chart);

// Text for HTML and SVG.
std::string escaped(const std::string& text);

}  // namespace turner::report
