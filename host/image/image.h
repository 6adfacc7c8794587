// A picture in memory: linear Rec. 709 RGB, float32, row by row from the top left.
#pragma once

#include <cstddef>
#include <vector>

namespace turner {

// A half-open rectangle of pixels, x0 <= x < x1, y0 <= y < y1; (0,0) is the top left pixel.
struct Window {
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
  int width() const { return x1 - x0; }
  int height() const { return y1 - y0; }
  size_t area() const { return size_t(width()) * size_t(height()); }
  bool operator==(const Window&) const = default;
};

struct Image {
  int width = 0, height = 0;  // of the full picture, the display window
  Window window;              // what is here, the data window: all of it, or a crop
  std::vector<float> rgb;     // 3 * window.area() values

  Image() = default;
  Image(int fullWidth, int fullHeight, Window part)
      : width(fullWidth), height(fullHeight), window(part), rgb(3 * part.area(), 0.0f) {}
};

}  // namespace turner
