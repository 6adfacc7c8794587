// Takes the lines first, then checks that none is missing and what they say.
#include "scene/nff/nff_view.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <optional>
#include <string>
#include <utility>

namespace turner::nff {
namespace {

constexpr std::array<std::string_view, 6> kViewWords{"from", "at", "up", "angle", "hither", "resolution"};
size_t viewWordIndex(std::string_view word) {
  return size_t(std::find(kViewWords.begin(), kViewWords.end(), word) - kViewWords.begin());
}

// Without overflow or underflow.
double lengthOf(const glm::dvec3& v) {
  return std::hypot(v.x, v.y, v.z);
}

// A view's lines in the order of kViewWords.
using ViewLines = std::array<std::optional<Numbers>, kViewWords.size()>;

Numbers readViewLine(Lines& lines, size_t index) {
  switch (index) {
    case 0:
      return lines.readNumbers({3}, "from x y z");
    case 1:
      return lines.readNumbers({3}, "at x y z");
    case 2:
      return lines.readNumbers({3}, "up x y z");
    case 3:
      return lines.readNumbers({1}, "angle degrees");
    case 4:
      lines.passRest();  // not looked at
      return {};
    default:
      return lines.readNumbers({2}, "resolution width height");
  }
}

// Reads up to the next entity. False at the end of the file; `broken` becomes true where a line is wrong.
bool readViewLines(Lines& lines, ViewLines& given, bool& broken) {
  while (lines.nextLine() && lines.faults.count() < kMostFaults) {
    if (isEntity(lines.peek().text)) return true;
    const Token name = lines.next();
    const size_t index = viewWordIndex(name.text);
    try {
      if (index == kViewWords.size()) {
        lines.noteUnknown(name);
        continue;
      }
      if (given[index]) lines.fail(name.offset, quoted(name.text) + " stands twice in this view; allowed is once");
      given[index] = readViewLine(lines, index);
    } catch (const Broken&) {
      broken = true;
      if (index < given.size() && !given[index]) given[index].emplace();  // wrong, but not missing
    }
  }
  return false;
}

bool isComplete(Lines& lines, const Token& word, const ViewLines& given, bool more) {
  std::string missing;
  for (size_t i = 0; i < kViewWords.size(); ++i) {
    if (given[i] || kViewWords[i] == "hither") continue;  // hither is not looked at, so it need not be there
    missing += (missing.empty() ? "'" : ", '") + std::string(kViewWords[i]) + "'";
  }
  if (missing.empty()) return true;
  lines.faults.add(word.offset, (more ? "the view lacks " : "the file ends inside this view: it lacks ") + missing);
  return false;
}

int readSize(Lines& lines, const Numbers& numbers, size_t i) {
  if (numbers[i] >= 1 && numbers[i] <= kMaxSize && numbers[i] == std::floor(numbers[i])) return int(numbers[i]);
  lines.faults.add(numbers.offsets[i],
                   "not a size in pixels; allowed are whole numbers from 1 to " + std::to_string(kMaxSize));
  return 1;
}

void setView(Lines& lines, const ViewLines& given, Scene& scene) {
  const auto& [from, at, up, angle, hither, resolution] = given;
  Camera& camera = scene.camera;
  camera.eye = from->vector(0);
  camera.target = at->vector(0);
  camera.up = up->vector(0);
  camera.fov = (*angle)[0];
  const double distance = lengthOf(camera.target - camera.eye), upLength = lengthOf(camera.up);
  if (distance == 0) {
    lines.faults.add(at->offsets[0], "'from' and 'at' are the same point; the view needs a direction");
  } else if (upLength == 0) {
    lines.faults.add(up->offsets[0], "'up' must not be 0 0 0");
  } else {
    // The sine of the angle between them, below which the picture's axes would be rounding noise in float32.
    const double sine = lengthOf(glm::cross((camera.target - camera.eye) / distance, camera.up / upLength));
    if (sine < 1e-6) lines.faults.add(up->offsets[0], "'up' is parallel to the view; allowed is any other direction");
  }
  if (camera.fov <= 0 || camera.fov >= 180) {
    lines.faults.add(angle->offsets[0],
                     "the angle is out of its range; allowed is more than 0 and less than 180 degrees");
  }
  scene.width = readSize(lines, *resolution, 0);
  scene.height = readSize(lines, *resolution, 1);
}

}  // namespace

bool isViewWord(std::string_view word) {
  return viewWordIndex(word) < kViewWords.size();
}

bool parseView(Lines& lines, const Token& word, ParsedScene& parsed) {
  ViewLines given;
  bool broken = false;
  const Token extra = lines.next();
  if (!extra.text.empty()) {
    lines.faults.add(extra.offset, "more on the line than expected: " + quoted(extra.text) + "; allowed is 'v' alone");
    broken = true;
  }
  const bool more = readViewLines(lines, given, broken);
  if (std::exchange(parsed.hasCamera, true)) {
    lines.faults.add(word.offset, "a second view; allowed is one 'v'");
  } else if (isComplete(lines, word, given, more) && !broken) {
    setView(lines, given, parsed.scene);
  }
  return more;
}

}  // namespace turner::nff
