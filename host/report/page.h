// A report as one HTML file that opens offline: charts, pictures, the table of all points.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "report/tables.h"

namespace turner::report {

// The picture of a point, of a scene by its number.
using PictureOf = std::function<Image(size_t scene, const SweepPoint&)>;

std::string reportPage(const Machine& machine, const std::vector<SweptScene>& scenes, const PictureOf& pictureOf);

}  // namespace turner::report
