// In: figures. Out: aligned lines.
#include "command/comparison_text.h"

#include <fmt/format.h>

namespace turner {

std::string figuresText(const Comparison& c, double threshold) {
  return fmt::format("size         {} x {}\n", c.width, c.height) +
         fmt::format("rmse         {:.3e}   relative {:.3e}\n", c.rmse, c.relRmse) +
         fmt::format("mean error   {:.3e}   signed {:+.3e}\n", c.mae, c.meanSigned) +
         fmt::format("percentiles  50: {:.3e}   99: {:.3e}   99.9: {:.3e}   max: {:.3e}\n", c.p50, c.p99, c.p999,
                     c.max) +
         fmt::format("bad pixels   {:.4f} % off by more than {:g}\n", 100 * c.badPixels, threshold) +
         fmt::format("nan, inf     {}, {}\n", c.nan, c.inf);
}

std::string decompositionText(const Decomposition& decomposition) {
  const auto line = [](const char* name, const Comparison& c) {
    return fmt::format("{:<13}{:<11.3e}{:<11.3e}{:<11.3e}{:<11.3e}{:<11.3e}{:+.3e}\n", name, c.rmse, c.p50, c.p99,
                       c.p999, c.max, c.meanSigned);
  };
  const SamplingError& sampling = decomposition.sampling;
  return fmt::format("{:<13}{:<11}{:<11}{:<11}{:<11}{:<11}{}\n", "", "rmse", "p50", "p99", "p99.9", "max", "signed") +
         line("sampling", sampling.figures) + line("arithmetic", decomposition.arithmetic) +
         line("quantisation", decomposition.quantisation) +
         fmt::format("own error    {:.3e} rms, of the {} samples that sampling is measured against{}\n",
                     sampling.ownError, sampling.samples, sampling.converged ? "" : ": did not converge");
}

std::string envelopeText(const EnvelopeRule& rule) {
  return fmt::format("envelope     {:.4f} % off by more than {:g}, {:.4f} % excused, {} pixels outside\n",
                     100 * rule.needed, kEnvelopeTolerance, 100 * rule.excused, rule.outside) +
         fmt::format("the rest     99: {:.3e}   99.9: {:.3e}\n", rule.p99, rule.p999);
}

}  // namespace turner
