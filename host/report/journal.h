// What a report has measured so far, on disk: a sweep that was interrupted, or killed, goes on where it stopped.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <utility>

#include "base/unique_fd.h"
#include "image/exr.h"

namespace turner::report {

struct Measurement {
  double seconds = 0;      // of tracing
  double meanSquare = -1;  // of the picture minus the converged one; NaN: some pixels are no numbers; negative: not
                           // measured, the picture was kept
};

// A folder with a picture for each point (a setting on a renderer) and a text file that grows by a line for each
// measurement: the name of the point, the number of the repeat, its figures.
class Journal {
 public:
  // Makes the folder, or takes up what is there; a last line that was cut short does not count. Throws RunError when
  // it cannot be written, InputError when another process is at it.
  explicit Journal(const std::string& folder);

  const std::string& folder() const { return folder_; }
  size_t size() const { return measurements_.size(); }

  std::optional<Measurement> find(const std::string& point, int repeat) const;
  void add(const std::string& point, int repeat, const Measurement& measurement);

  // Words that were settled once and must stay, by key.
  std::optional<std::string> decision(const std::string& key) const;
  void decide(const std::string& key, const std::string& value);

  // The picture of a point. keep() comes before add(): what was measured has its picture.
  void keep(const std::string& point, const Image& image, const Provenance& provenance) const;
  Image picture(const std::string& point) const;
  // Whether it is there, undamaged, and of these windows.
  bool hasPicture(const std::string& point, int width, int height, const Window& window) const;

  // All has served: deletes the folder, the measurements before the pictures that belong to them.
  void discard();
  std::string picturePath(const std::string& point) const { return folder_ + '/' + point + ".exr"; }

 private:
  void append(const std::string& line);
  void read(const std::string& line);

  std::string folder_;
  UniqueFd file_;
  std::map<std::pair<std::string, int>, Measurement> measurements_;
  std::map<std::string, std::string> decisions_;
};

}  // namespace turner::report
