// Figures of the repeats.
#include "report/swept_scene.h"

#include "base/spread.h"

namespace turner::report {

double SweepPoint::medianSeconds() const {
  return spreadOf(seconds).median;
}

double SweepPoint::fastest() const {
  return spreadOf(seconds).least;
}

double SweepPoint::slowest() const {
  return spreadOf(seconds).most;
}

double SweepPoint::efficiency() const {
  return 1 / (rmse * rmse * medianSeconds());
}

}  // namespace turner::report
