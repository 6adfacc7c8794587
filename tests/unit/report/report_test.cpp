// What a report computes from what it has measured.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>
#include <vector>

#include "base/errors.h"
#include "image/converged.h"
#include "report/chart.h"
#include "report/error_colours.h"
#include "report/figures.h"
#include "report/findings.h"
#include "report/journal.h"
#include "report/page.h"
#include "report/sweep.h"
#include "report/tables.h"
#include "support/environment.h"
#include "support/temporary_folder.h"

namespace turner::report {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

// ---- the sweep ----

Scene sceneWith(double reflect) {
  Scene scene;
  scene.materials = {{.name = "m", .diffuse = glm::dvec3(1), .reflect = reflect}};
  return scene;
}

RenderSettings depthOf(int depth) {
  RenderSettings whole;
  whole.depth = depth;
  return whole;
}

std::vector<std::string> names(const std::vector<Setting>& settings, const RenderSettings& whole) {
  std::vector<std::string> found;
  for (const Setting& setting : settings) found.push_back(settingName(setting, whole));
  return found;
}

TEST(Sweep, HasEverySamplerWithEveryNumberOfSamples) {
  const RenderSettings whole = depthOf(5);
  EXPECT_THAT(names(planSweep(sceneWith(0), whole, 2, CutOffs::measured), whole),
              ElementsAre("grid-1x1", "jitter-1x1", "sobol-1x1", "grid-2x2", "jitter-2x2", "sobol-2x2"));
  // The number that was asked for is measured, whatever it is.
  const std::vector<Setting> five = planSweep(sceneWith(0), whole, 5, CutOffs::measured);
  EXPECT_EQ(five.back().samples, 5);
  EXPECT_EQ(five[five.size() - 4].samples, 4);
}

TEST(Sweep, CutsOffOnlyWhereASceneSpawnsRays) {
  const RenderSettings whole = depthOf(3);
  EXPECT_THAT(
      names(planSweep(sceneWith(0.5), whole, 1, CutOffs::measured), whole),
      ElementsAre("grid-1x1", "jitter-1x1", "sobol-1x1", "sobol-1x1-depth1", "sobol-1x1-depth2", "sobol-1x1-weight0.3",
                  "sobol-1x1-weight0.1", "sobol-1x1-weight0.03", "sobol-1x1-weight0.01"));
  EXPECT_EQ(planSweep(sceneWith(0.5), depthOf(1), 1, CutOffs::measured).size(), 3u);
  EXPECT_EQ(planSweep(sceneWith(0.5), whole, 1, CutOffs::leftOut).size(), 3u);
}

// ---- figures ----

// A scene measured on one device and the reference: rmse = factor * samples^slope, seconds = samples * cost.
struct Law {
  double factor, slope, cost;
};

SweptScene measured(const std::vector<std::pair<Sampler, Law>>& laws, const std::vector<int>& numbers = {1, 2, 4, 8}) {
  SweptScene scene;
  scene.path = "scene's.json";
  scene.whole.depth = 5;
  scene.renderers = {{.name = "device", .options = "--device 0"},
                     {.name = "reference", .options = "--backend reference"}};
  for (const int n : numbers)
    for (const auto& [sampler, law] : laws) {
      SweepPoint point;
      point.setting = {sampler, n, 5, 0};
      point.name = "device-" + settingName(point.setting, scene.whole);
      point.rmse = law.factor * std::pow(double(n) * n, law.slope);
      point.rmses = {point.rmse};
      point.seconds = {law.cost * n * n};
      scene.points.push_back(point);
    }
  return scene;
}

TEST(Figures, SlopeOfAPowerLawIsItsPower) {
  EXPECT_NEAR(logSlope({1, 2, 8}, {3, 3 * std::pow(2, -0.75), 3 * std::pow(8, -0.75)}).value(), -0.75, 1e-12);
  EXPECT_FALSE(logSlope({2, 2}, {1, 3}).has_value());
  EXPECT_FALSE(logSlope({1, 2}, {0, 0}).has_value());  // no error has no logarithm
  const SweptScene scene = measured({{Sampler::jitter, {0.1, -0.6, 1}}});
  EXPECT_NEAR(curvesOf(scene).at(0).slope.value(), -0.6, 1e-12);
}

TEST(Figures, ReachesAnErrorWhereThePowerLawDoes) {
  // 0.02 N^-1/2: 0.01 at 4 samples; 0.001 at 400, beyond the measured 64.
  const std::vector<Curve> curves = curvesOf(measured({{Sampler::jitter, {0.02, -0.5, 0.1}}}, {1, 3, 4, 8}));
  ASSERT_TRUE(curves[0].targets[0] && curves[0].targets[1]);
  EXPECT_NEAR(curves[0].targets[0]->samples, 4, 1e-9);
  EXPECT_NEAR(curves[0].targets[0]->seconds, 0.4, 1e-9);
  EXPECT_FALSE(curves[0].targets[0]->extrapolated);
  EXPECT_NEAR(curves[0].targets[1]->samples, 400, 1e-6);
  EXPECT_TRUE(curves[0].targets[1]->extrapolated);
  // Not far beyond, and not along a slope through two points.
  EXPECT_FALSE(curvesOf(measured({{Sampler::jitter, {0.05, -0.5, 0.1}}}))[0].targets[1].has_value());
  EXPECT_FALSE(curvesOf(measured({{Sampler::jitter, {0.02, -0.5, 0.1}}}, {1, 4, 8}))[0].targets[1].has_value());
  // Never, where the error does not fall, or only beyond what a renderer takes.
  EXPECT_FALSE(curvesOf(measured({{Sampler::grid, {0.05, 0, 1}}}))[0].targets[0].has_value());
  EXPECT_FALSE(curvesOf(measured({{Sampler::grid, {1, -0.3, 1}}}))[0].targets[1].has_value());
  // At once, where one sample is good enough.
  EXPECT_EQ(curvesOf(measured({{Sampler::grid, {0.005, -0.5, 1}}}))[0].targets[0]->samples, 1);
}

TEST(Figures, FirstSettingBelowAnErrorIsOneThatExists) {
  const std::vector<std::string> sentences = findings(measured({{Sampler::jitter, {0.05, -0.5, 0.1}}}));
  EXPECT_THAT(sentences, testing::Contains("The first setting below an RMSE of 0.01 is device, jitter 8x8: 6.4 s, RMSE "
                                           "0.0063."));
  EXPECT_THAT(sentences, Not(testing::Contains(HasSubstr("RMSE of 0.001"))));
  EXPECT_THAT(
      findings(measured({{Sampler::jitter, {0.02, -0.5, 0.1}}})),
      testing::Contains("No setting comes down to an RMSE of 0.001. Along its slope jitter on device would, with "
                        "about 400 samples in each pixel, in 40 s."));
}

TEST(Figures, FurthestCutOffThatLosesLittleIsTold) {
  SweptScene scene = measured({{Sampler::sobol, {0.02, -0.5, 1}}}, {1, 4});
  for (int depth = 1; depth < 5; ++depth) {
    SweepPoint point = scene.points[1];
    point.setting.depth = depth;
    point.sampling.rmse = 0.005;
    point.cutOff.rmse = 0.008 / (depth * depth);
    point.seconds = {2.0 * depth};
    scene.points.push_back(point);
  }
  EXPECT_THAT(findings(scene),
              testing::Contains("A depth of 2 loses 0.002 rms (at 4x4 samples sampling loses 0.005) and "
                                "takes 0.25 of the time on device."));
}

TEST(Figures, FrontHasWhatNothingBeatsInBoth) {
  // jitter costs twice as much and is as wrong: none of it is on the front.
  SweptScene scene = measured({{Sampler::grid, {0.1, -0.5, 1}}, {Sampler::jitter, {0.1, -0.5, 2}}});
  for (const size_t i : paretoFront(scene)) EXPECT_EQ(scene.points[i].setting.sampler, Sampler::grid);
  EXPECT_EQ(paretoFront(scene).size(), 4u);
  // What has a NaN is on no front, however fast.
  scene.points[0].rmse = NAN;
  EXPECT_EQ(paretoFront(scene).size(), 4u);  // jitter 1x1 takes its place
  EXPECT_EQ(scene.points[paretoFront(scene)[0]].setting.sampler, Sampler::jitter);
}

TEST(Figures, LeadChangesWhereCurvesCross) {
  // 0.1 N^-1/2 against 0.2 N^-3/4: equal at 16 samples, which is no lead of either.
  const SweptScene scene =
      measured({{Sampler::grid, {0.1, -0.5, 1}}, {Sampler::sobol, {0.2, -0.75, 1}}}, {1, 2, 4, 8, 16});
  const std::vector<Curve> curves = curvesOf(scene);
  const std::vector<Lead> leads = leadsOf(scene, curves[0], curves[1], Figure::rmse);
  ASSERT_EQ(leads.size(), 2u);
  EXPECT_TRUE(leads[0].ofFirst);
  EXPECT_FALSE(leads[1].ofFirst);
  EXPECT_EQ(scene.points[leads[0].to].setting, (Setting{Sampler::grid, 2, 5, 0}));
  EXPECT_EQ(scene.points[leads[1].from].setting, (Setting{Sampler::sobol, 8, 5, 0}));
  EXPECT_THAT(findings(scene),
              testing::Contains("grid on device is less wrong than sobol on device from 1x1 to 2x2; sobol "
                                "on device is less wrong than grid on device from 8x8 to 16x16."));
}

// One point that is alike ends a lead: it is not claimed to hold everywhere.
TEST(Figures, ALeadEndsWhereItEnds) {
  SweptScene scene = measured({{Sampler::jitter, {0.1, -0.5, 1}}, {Sampler::sobol, {0.08, -0.5, 1}}}, {1, 2, 3, 4});
  scene.points[4].rmse = scene.points[5].rmse;  // jitter 3x3
  EXPECT_THAT(findings(scene), testing::Contains("sobol on device is less wrong than jitter on device from 1x1 to 2x2; "
                                                 "sobol on device is less wrong than jitter on device at 4x4."));
}

TEST(Figures, DifferencesOfNoiseAreNoLead) {
  const SweptScene scene = measured({{Sampler::grid, {0.1, -0.5, 1}}, {Sampler::sobol, {0.103, -0.51, 1}}});
  const std::vector<Curve> curves = curvesOf(scene);
  EXPECT_TRUE(leadsOf(scene, curves[0], curves[1], Figure::rmse).empty());
}

// Devices make the same picture, the one in a hundredth of the other's time: their curves have no time in common.
TEST(Figures, AFasterDeviceLeadsWhereverItsCurveEnds) {
  SweptScene scene = measured({{Sampler::sobol, {0.1, -0.5, 0.01}}});
  SweptScene slow = measured({{Sampler::sobol, {0.1, -0.5, 1}}});
  for (SweepPoint& point : slow.points) {
    point.renderer = 1;
    scene.points.push_back(point);
  }
  EXPECT_THAT(findings(scene),
              testing::Contains("For the same pictures device takes 0.01 times as long as reference."));
  EXPECT_THAT(findings(scene), testing::Contains("sobol on device is faster than sobol on reference from 1x1 to 8x8."));
  // Times that scatter into one another are no lead.
  for (SweepPoint& point : scene.points) point.seconds = {0.001, point.seconds[0], 1000};
  EXPECT_TRUE(leadsOf(scene, curvesOf(scene)[0], curvesOf(scene)[1], Figure::seconds).empty());
}

// A picture with a NaN has no error that could be compared: it would be that of the other pixels.
TEST(Figures, WhatIsNoNumberIsOnNoCurveAndNoFront) {
  SweptScene scene = measured({{Sampler::grid, {0.1, -0.5, 1}}}, {1, 2, 4});
  scene.points[1].rmse = NAN;
  scene.points[1].arithmetic.nan = 3;
  EXPECT_EQ(curvesOf(scene)[0].points, (std::vector<size_t>{0, 2}));
  EXPECT_EQ(paretoFront(scene), (std::vector<size_t>{0, 2}));
  EXPECT_THAT(findings(scene), testing::Contains("A picture by device has 3 pixels with a NaN or an infinity."));
}

TEST(Figures, AConvergedPictureThatIsNotIsTold) {
  SweptScene scene = measured({{Sampler::grid, {0.1, -0.5, 1}}});
  scene.converged.enough = false;
  EXPECT_THAT(findings(scene).at(0), testing::StartsWith("CAUTION"));
}

TEST(Figures, ATableWithoutErrorsIsStillOne) {
  SweptScene scene = measured({{Sampler::grid, {0, -0.5, 1}}});
  EXPECT_FALSE(curvesOf(scene)[0].slope.has_value());
  const std::string json = reportJson({}, [&] {
    std::vector<SweptScene> scenes;
    scenes.push_back(std::move(scene));
    return scenes;
  }());
  EXPECT_THAT(json, HasSubstr("\"efficiency\": null"));
  EXPECT_THAT(json, Not(HasSubstr("inf,")));
  EXPECT_THAT(json, Not(HasSubstr("nan,")));
}

TEST(Figures, CommandsAreQuotedForAShell) {
  SweptScene scene = measured({{Sampler::sobol, {0.1, -0.5, 1}}}, {4});
  scene.points[0].setting.minWeight = 0.1;
  scene.stem = "scene_s";
  EXPECT_EQ(renderCommand(scene, scene.points[0], "my shaders"),
            "turner render 'scene'\\''s.json' -o scene_s-device-sobol-4x4.exr --width 512 --height 512 --samples 4 "
            "--sampler sobol "
            "--seed 0 --depth 5 --min-weight 0.1 --device 0 --shaders 'my shaders'");
}

TEST(Figures, MedianOfAnEvenNumberIsBetween) {
  SweepPoint point;
  point.seconds = {4, 1, 2, 30};
  EXPECT_EQ(point.medianSeconds(), 3);
  point.rmse = 0.5;
  EXPECT_DOUBLE_EQ(point.efficiency(), 1 / (0.25 * 3));
}

// ---- the converged picture ----

// A renderer that is wrong by noise of a known rms: level * N^-3/4.
RenderPicture noisy(double level, std::vector<RenderSettings>* asked = nullptr) {
  return [=](const RenderSettings& settings) {
    if (asked) asked->push_back(settings);
    std::mt19937 random(settings.seed);
    const double rms = level * std::pow(double(settings.samples) * settings.samples, -0.75);
    std::normal_distribution<double> noise(0, rms);
    Image image(settings.width, settings.height, settings.crop);
    for (float& value : image.rgb) value = float(0.5 + noise(random));
    return image;
  };
}

RenderSettings small() {
  RenderSettings settings;
  settings.width = settings.height = 64;
  settings.crop = {0, 0, 64, 64};
  settings.minWeight = 0.1;
  return settings;
}

TEST(ConvergedPicture, KnowsItsOwnErrorAndIsGoodEnough) {
  std::vector<RenderSettings> asked;
  const Converged converged = converge(noisy(1, &asked), small(), 3, [](const Image&, double) { return 0.04; });
  EXPECT_TRUE(converged.enough);
  EXPECT_LE(converged.ownError, 0.01);
  double squares = 0;
  for (const float value : converged.mean.rgb) squares += (value - 0.5) * (value - 0.5);
  EXPECT_NEAR(converged.ownError, std::sqrt(squares / double(converged.mean.rgb.size())), 0.03 * converged.ownError);
  // Another sampler and another seed for each half, and nothing cut off.
  ASSERT_GE(asked.size(), 4u);
  for (size_t i = 0; i < asked.size(); i += 2) {
    EXPECT_NE(asked[i].sampler, asked[i + 1].sampler);
    EXPECT_NE(asked[i].seed, asked[i + 1].seed);
    EXPECT_EQ(asked[i].minWeight, 0);
  }
  // No more samples than the error asks for: half of 2^0.5 n^-1.5 is 0.01 at n = 17.
  EXPECT_LE(converged.samples, 24);
}

// A flat picture's grid error may be of the last bit: no number of jittered samples comes to a quarter of that.
TEST(ConvergedPicture, EndsWhenItCostsMoreThanAllElseAndSaysSo) {
  double samples = 0;
  const Converged converged = converge(
      noisy(1), small(), 8, [](const Image&, double) { return 1e-8; }, [&](double more) { samples += more; });
  EXPECT_FALSE(converged.enough);
  EXPECT_EQ(converged.samples, 48);
  EXPECT_LE(samples, 2 * (16 * 16 + 48 * 48 + 48 * 48));
}

TEST(ConvergedPicture, IsNotEnoughWithAPixelThatIsNoNumber) {
  int pictures = 0;
  const Converged converged = converge(
      [&](const RenderSettings& settings) {
        Image image = noisy(1)(settings);
        if (++pictures == 2) image.rgb[7] = NAN;
        return image;
      },
      small(), 4, [](const Image&, double) { return 1.0; });
  EXPECT_FALSE(converged.enough);
  EXPECT_EQ(pictures, 2);
}

TEST(ConvergedPicture, HasNumbersOfSamplesThatSuitSobol) {
  for (const int n : {1, 5, 7, 11, 43, 100, 256})
    (void)converge(
        [&](const RenderSettings& settings) {
          int rest = settings.samples;
          while (rest % 2 == 0) rest /= 2;
          while (rest % 3 == 0) rest /= 3;
          EXPECT_EQ(rest, 1) << settings.samples;
          EXPECT_LE(settings.samples, kMaxSamples);
          return noisy(1)(settings);
        },
        small(), n, [](const Image&, double) { return 0.01; });
}

TEST(ConvergedPicture, IsFoundInTheCacheAgainAndNotUnderAnotherKey) {
  const test::TemporaryFolder folder;
  const test::EnvironmentVariable home("XDG_CACHE_HOME", folder.path.c_str());
  std::vector<RenderSettings> asked;
  const Image first = cached(noisy(1, &asked), "key")(small());
  EXPECT_EQ(cached(noisy(1, &asked), "key")(small()).rgb, first.rgb);
  EXPECT_EQ(asked.size(), 1u);
  (void)cached(noisy(1, &asked), "another")(small());
  RenderSettings other = small();
  other.seed = 5;
  (void)cached(noisy(1, &asked), "key")(other);
  EXPECT_EQ(asked.size(), 3u);
  // A damaged file is rendered again and replaced.
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder.path))
    if (entry.is_regular_file()) std::ofstream(entry.path()) << "no picture";
  EXPECT_EQ(cached(noisy(1, &asked), "key")(small()).rgb, first.rgb);
  EXPECT_EQ(cached(noisy(1, &asked), "key")(small()).rgb, first.rgb);
  EXPECT_EQ(asked.size(), 4u);
}

// ---- the journal ----

TEST(Journal, GoesOnWithWhatWasWrittenWhole) {
  const test::TemporaryFolder folder;
  const std::string path = (folder.path / "unfinished").string();
  Image image(2, 1, {0, 0, 2, 1});
  image.rgb = {0.1f, 0.2f, 0.3f, 0.4f, 0.5f, 0.6f};
  {
    Journal journal(path);
    journal.keep("a", image, {});
    journal.add("a", 0, {.seconds = 1.0 / 3, .meanSquare = -1});
    journal.add("a", 1, {.seconds = 0.25, .meanSquare = 1e-7});
    journal.decide("converged", "reference");
  }
  // Killed while it wrote.
  std::ofstream(path + "/journal", std::ios::app) << "measured a 2 0.12";
  {
    Journal journal(path);
    EXPECT_EQ(journal.size(), 2u);
    EXPECT_EQ(journal.find("a", 0)->seconds, 1.0 / 3);  // to the last bit
    EXPECT_EQ(journal.find("a", 1)->meanSquare, 1e-7);
    EXPECT_FALSE(journal.find("a", 2).has_value());
    EXPECT_EQ(journal.decision("converged"), "reference");
    EXPECT_EQ(journal.picture("a").rgb, image.rgb);
    journal.add("a", 2, {.seconds = 9, .meanSquare = 1});
  }
  EXPECT_EQ(Journal(path).find("a", 2)->seconds, 9);
}

TEST(Journal, BelievesNoRubbish) {
  const test::TemporaryFolder folder;
  std::ofstream(folder.path / "journal")
      << "measured a 0 nan -1\nmeasured b 0 -1 -1\nmeasured c 1 1 -1\nmeasured d 0 1 5\n"
         "measured e -1 1 1\nrubbish\n\nmeasured f\nmeasured g 1 0.5 nan\n";
  const Journal journal(folder.path.string());
  EXPECT_EQ(journal.size(), 1u);
  EXPECT_TRUE(std::isnan(journal.find("g", 1)->meanSquare));  // pixels that are no numbers
}

TEST(Journal, KnowsADamagedPictureAndOneOfAnotherSize) {
  const test::TemporaryFolder folder;
  Journal journal(folder.path.string());
  const Window window{0, 0, 2, 1};
  EXPECT_FALSE(journal.hasPicture("a", 2, 1, window));
  journal.keep("a", Image(2, 1, window), {});
  EXPECT_TRUE(journal.hasPicture("a", 2, 1, window));
  EXPECT_FALSE(journal.hasPicture("a", 3, 1, window));
  std::filesystem::resize_file(journal.picturePath("a"), 40);
  EXPECT_FALSE(journal.hasPicture("a", 2, 1, window));
  journal.discard();
  EXPECT_FALSE(std::filesystem::exists(folder.path));
}

TEST(Journal, IsForOneProcessAtATime) {
  const test::TemporaryFolder folder;
  const Journal journal(folder.path.string());
  EXPECT_THROW(Journal(folder.path.string()), InputError);
}

// ---- charts and colours ----

TEST(Chart, EscapesWhatItIsGivenAndLeavesOutWhatHasNoLogarithm) {
  Chart chart{"a < b & 'c'", "x", "y", {}, {}, "", {}};
  chart.series = {
      {.name = "<script>",
       .points = {{1, 1, "one", "1", "", false}, {2, 0, "none", "2", "", false}, {10, 0.1, "three", "3", "", true}}}};
  const std::string svg = svgOf(chart);
  EXPECT_THAT(svg, HasSubstr("&lt;script&gt;"));
  EXPECT_THAT(svg, HasSubstr("a &lt; b &amp; &#39;c&#39;"));
  EXPECT_THAT(svg, HasSubstr("data-point='1'"));
  EXPECT_THAT(svg, Not(HasSubstr("data-point='2'")));
  EXPECT_THAT(svg, Not(HasSubstr("nan")));
  EXPECT_THAT(svg, Not(HasSubstr("inf")));
}

TEST(Chart, WithoutAnyErrorSaysSo) {
  EXPECT_THAT(svgOf({}), HasSubstr("nothing to draw"));
}

size_t countOf(const std::string& text, const std::string& part) {
  size_t count = 0;
  for (size_t at = 0; (at = text.find(part, at)) != std::string::npos; at += part.size()) ++count;
  return count;
}

TEST(Chart, OfASinglePointHasAxes) {
  Chart chart;
  chart.series = {{.name = "s", .points = {{0.0345, 0.0345, "l", "i", "", false}}}};
  const std::string svg = svgOf(chart);
  EXPECT_THAT(svg, Not(HasSubstr("nan")));
  EXPECT_GE(countOf(svg, "text-anchor='end'"), 2u);  // numbers at the axis of y
}

TEST(Chart, GrowsWithItsLegend) {
  Chart chart;
  for (int i = 0; i < 40; ++i) chart.series.push_back({.name = "s", .points = {{1, 1, "l", "i", "", false}}});
  EXPECT_THAT(svgOf(chart), HasSubstr("viewBox='0 0 860 854'"));
}

TEST(ColouredError, GrowsBrighterWithTheError) {
  Image a(5, 1, {0, 0, 5, 1}), b = a;
  const float errors[] = {0, 1e-3f, 1e-2f, 1, NAN};
  for (size_t i = 0; i < 5; ++i) a.rgb[3 * i + 1] = errors[i];
  const Image coloured = colouredError(a, b);
  const auto luminance = [&](size_t i) {
    return 0.2126f * coloured.rgb[3 * i] + 0.7152f * coloured.rgb[3 * i + 1] + 0.0722f * coloured.rgb[3 * i + 2];
  };
  for (size_t i = 0; i + 2 < 5; ++i) EXPECT_LT(luminance(i), luminance(i + 1)) << i;
  EXPECT_EQ(luminance(3), luminance(4));  // what is no number is as wrong as can be
}

}  // namespace
}  // namespace turner::report
