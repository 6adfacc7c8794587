// What the hard cases measure, and the table that is made of it.
#pragma once

#include <cmath>
#include <optional>
#include <string>
#include <vector>

namespace turner::hard {

// The larger of two errors; a NaN stays.
inline double worse(double a, double b) {
  return a >= b || std::isnan(a) ? a : b;
}

// One measured figure. It passes if it is at most its bar.
struct Figure {
  std::string what;             // with the unit where it has one
  std::optional<double> naive;  // the naive tracer's; none: not measured, as the note says
  double turner = 0;
  double bar = 0;
  std::string note;
  bool isTime = false;                           // in seconds: of the machine and of what else it does
  bool passes() const { return turner <= bar; }  // a NaN does not
};

// A figure that misses its bar, known and not yet mended: the tests hold what is reached.
struct KnownMiss {
  double reached;  // with room for other machines
  std::string why;
};

// The figures of one case.
class Report {
 public:
  // `naive` where it is measured.
  void atMost(const std::string& what, double turner, double bar, std::optional<double> naive = {},
              const std::string& note = {});
  // A time in seconds.
  void atMostSeconds(const std::string& what, double turner, double bar);
  // A figure whose bar is known to be missed: fails only beyond what has been reached.
  void knownMiss(const std::string& what, double turner, double bar, const KnownMiss& known,
                 std::optional<double> naive = {});
  void add(Figure figure);

  const std::vector<Figure>& figures() const { return figures_; }
  bool passes() const;  // every figure is at most its bar
  // Or at most what has been reached, where a miss is known. Times may be left out.
  bool holdsWhatIsReached(bool withTimes = true) const;

 private:
  std::vector<Figure> figures_;
  std::vector<std::optional<double>> reached_;
};

// A case with what it measured.
struct Scored {
  int number;
  std::string name;
  Report report;
  double seconds;
};

// What the table says of the run.
struct RunFacts {
  std::string device;
  std::string effort;  // "full" or "quick"
  unsigned long long seed;
};

std::string markdownTable(const std::vector<Scored>& cases, const RunFacts& facts);
std::string jsonTable(const std::vector<Scored>& cases, const RunFacts& facts);

}  // namespace turner::hard
