// Runs a sweep: renders every setting on every renderer, again and again, and compares the pictures.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "report/journal.h"
#include "report/renderers.h"
#include "report/sweep.h"
#include "report/swept_scene.h"

namespace turner::report {

// A scene that is to be measured.
struct SceneToSweep {
  const Scene& scene;
  std::string path;
  std::string stem;  // of its file's name, as a word that is good for other files' names
  std::string tag;   // of its files, unique in the journal
  RenderSettings whole;
  std::vector<Setting> settings;
  int repeats = 1;
};

// Follows a sweep while it runs.
class SweepObserver {
 public:
  virtual ~SweepObserver() = default;
  // There are so many samples more, or less, for a renderer to do than was known.
  virtual void expect(const std::string& renderer, double samples) = 0;
  // So many of them are done; `what` says of what. Called often. May throw, to end the sweep.
  virtual void done(const std::string& renderer, double samples, const std::string& what) = 0;
};

// Reports to the observer what a scene's sweep takes, as far as it is not in the journal.
void expectSweep(const SceneToSweep& sweep, const std::vector<RendererInfo>& renderers, const Journal& journal,
                 SweepObserver& observer);

// `renderers` are the devices' and, last, the reference's. Measures what the journal does not have.
SweptScene measure(const SceneToSweep& sweep, std::vector<std::unique_ptr<Renderer>> renderers, Journal& journal,
                   SweepObserver& observer);

}  // namespace turner::report
