// In: figures. Out: aligned lines.
#include "command/comparison_text.h"

#include <fmt/format.h>

namespace turner {

void printFigures(const Comparison& c, double threshold) {
  fmt::print("size         {} x {}\n", c.width, c.height);
  fmt::print("rmse         {:.3e}   relative {:.3e}\n", c.rmse, c.relRmse);
  fmt::print("mean error   {:.3e}   signed {:+.3e}\n", c.mae, c.meanSigned);
  fmt::print("percentiles  50: {:.3e}   99: {:.3e}   99.9: {:.3e}   max: {:.3e}\n", c.p50, c.p99, c.p999, c.max);
  fmt::print("bad pixels   {:.4f} % off by more than {:g}\n", 100 * c.badPixels, threshold);
  fmt::print("nan, inf     {}, {}\n", c.nan, c.inf);
}

void printDecomposition(const Decomposition& decomposition) {
  fmt::print("{:<13}{:<11}{:<11}{:<11}{:<11}{:<11}{}\n", "", "rmse", "p50", "p99", "p99.9", "max", "signed");
  const auto print = [](const char* name, const Comparison& c) {
    fmt::print("{:<13}{:<11.3e}{:<11.3e}{:<11.3e}{:<11.3e}{:<11.3e}{:+.3e}\n", name, c.rmse, c.p50, c.p99, c.p999,
               c.max, c.meanSigned);
  };
  const SamplingError& sampling = decomposition.sampling;
  print("sampling", sampling.figures);
  print("arithmetic", decomposition.arithmetic);
  print("quantisation", decomposition.quantisation);
  fmt::print("own error    {:.3e} rms, of the {} samples that sampling is measured against{}\n", sampling.ownError,
             sampling.samples, sampling.converged ? "" : ": did not converge");
}

void printEnvelope(const EnvelopeRule& rule) {
  fmt::print("envelope     {:.4f} % off by more than {:g}, {:.4f} % excused, {} pixels outside\n", 100 * rule.needed,
             kEnvelopeTolerance, 100 * rule.excused, rule.outside);
  fmt::print("the rest     99: {:.3e}   99.9: {:.3e}\n", rule.p99, rule.p999);
}

}  // namespace turner
