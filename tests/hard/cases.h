// The catalogue of hard cases: what each is, and what it has at hand. A case measures the shader's own functions (or
// whole pictures) against an oracle that shares nothing with them, and a naive tracer beside them.
#pragma once

#include <algorithm>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "hard/kernels.h"
#include "hard/report.h"
#include "support/shader_harness.h"

namespace turner::hard {

using Random = std::mt19937_64;

// How much is done: the full counts, or some thousandths of them for the tests that everybody runs.
struct Effort {
  bool full = false;
  // `full` rays, or at most `quick`.
  size_t rays(double fullCount, double quickCount = 2e5) const { return size_t(full ? fullCount : quickCount); }
};

// What a case has at hand.
struct Bench {
  Kernels& kernels;
  Effort effort;
  uint64_t seed;

  // Every case has its own numbers, whichever other cases run.
  Random random(int number) const { return Random(seed * 1000 + uint64_t(number)); }

  // Calls task(count) until `total` is reached, with at most 2^18 at a time: a batch's rays fit in memory.
  template <class Task>
  static void inBatches(size_t total, const Task& task) {
    for (size_t done = 0; done < total;) {
      const size_t count = std::min<size_t>(total - done, 1 << 18);
      task(count);
      done += count;
    }
  }
};

struct Case {
  int number;
  std::string name;
  void (*measure)(const Bench& bench, Report& report);
};

// By part of the catalogue, each in a file of that name.
std::vector<Case> sphereCases();
std::vector<Case> triangleCases();
std::vector<Case> treeCases();
std::vector<Case> lightCases();
std::vector<Case> refractionCases();
std::vector<Case> solidCases();
std::vector<Case> mirrorCases();
std::vector<Case> shadingCases();
std::vector<Case> badInputCases();
std::vector<Case> invarianceCases();
std::vector<Case> determinismCases();
std::vector<Case> coneCases();
std::vector<Case> coneSurfaceCases();
std::vector<Case> coneJointCases();

}  // namespace turner::hard
