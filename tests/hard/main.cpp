// A developer's program, and the tests that carry the label `hard`: measures the hard cases of numerical stability and
// prints the scoreboard. Ends with 1 if a figure is over its bar, or, where a miss is known, worse than what has been
// reached.
// usage: turner_hard [--full] [--case N]... [--without-times] [--seed S] [--json FILE] [--markdown FILE] [--list]
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <exception>

#include "base/errors.h"
#include "base/output_file.h"
#include "gpu/devices.h"
#include "hard/cases.h"

namespace turner::hard {
namespace {

std::vector<Case> allCases() {
  std::vector<Case> all;
  for (const auto& part : {sphereCases(), triangleCases(), treeCases(), lightCases(), refractionCases(), solidCases(),
                           mirrorCases(), shadingCases(), badInputCases(), invarianceCases(), determinismCases(),
                           coneCases(), coneSurfaceCases(), coneJointCases()})
    all.insert(all.end(), part.begin(), part.end());
  std::sort(all.begin(), all.end(), [](const Case& a, const Case& b) { return a.number < b.number; });
  return all;
}

int run(int argc, char** argv) {
  CLI::App app("The hard cases of numerical stability, solved and scored.");
  std::vector<int> numbers;
  bool full = false, list = false, withoutTimes = false;
  uint64_t seed = 1;
  std::string json, markdown;
  app.add_flag("--full", full, "the full counts, up to 10^7 rays in a case (else a small part of them)");
  app.add_option("--case", numbers, "only these cases, by number; may repeat");
  app.add_flag("--without-times", withoutTimes, "figures in seconds are shown and do not count: on a busy machine");
  app.add_option("--seed", seed, "of the random rays");
  app.add_option("--json", json, "write the table as JSON to this file");
  app.add_option("--markdown", markdown, "write the table as Markdown to this file");
  app.add_flag("--list", list, "list the cases");
  CLI11_PARSE(app, argc, argv);

  const std::vector<Case> cases = allCases();
  if (list) {
    for (const Case& known : cases) fmt::print("{:2} {}\n", known.number, known.name);
    return 0;
  }
  for (const int number : numbers)
    if (std::none_of(cases.begin(), cases.end(), [&](const Case& known) { return known.number == number; }))
      throw InputError("there is no case " + std::to_string(number) + "; --list lists them");

  Kernels kernels;
  std::vector<Scored> scored;
  bool holds = true;
  for (const Case& known : cases) {
    if (!numbers.empty() && std::find(numbers.begin(), numbers.end(), known.number) == numbers.end()) continue;
    const auto start = std::chrono::steady_clock::now();
    Report report;
    kernels.setLeastDistance(0);
    known.measure({kernels, {full}, seed}, report);
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    scored.push_back({known.number, known.name, report, seconds});
    holds = holds && report.holdsWhatIsReached(!withoutTimes);
    fmt::print("{:2} {} ({:.1f} s)\n", known.number, known.name, seconds);
    for (const Figure& figure : report.figures())
      fmt::print("   {:<8} {:.3g}, bar {:.3g}{}: {}{}\n", figure.passes() ? "passes" : "FAILS", figure.turner,
                 figure.bar, figure.naive ? fmt::format(", naive {:.3g}", *figure.naive) : "", figure.what,
                 figure.note.empty() ? "" : " (" + figure.note + ")");
    std::fflush(stdout);
  }
  const RunFacts facts{kernels.deviceName(), full ? "full" : "quick", seed};
  if (!json.empty()) writeWholeFile(json, jsonTable(scored, facts));
  if (!markdown.empty()) writeWholeFile(markdown, markdownTable(scored, facts));
  return holds ? 0 : 1;
}

}  // namespace
}  // namespace turner::hard

int main(int argc, char** argv) {
  try {
    const int code = turner::hard::run(argc, argv);
    turner::test::endRenderer();
    return code;
  } catch (const turner::InputError& error) {
    fmt::print(stderr, "turner_hard: error: {}\n", error.what());
    turner::test::endRenderer();
    return 2;
  } catch (const std::exception& error) {
    fmt::print(stderr, "turner_hard: error: {}\n", error.what());
    turner::test::endRenderer();
    return 1;
  }
}
