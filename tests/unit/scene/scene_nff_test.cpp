// NFF files become the scene that they describe, and wrong ones are refused with every fault at its place.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <glm/geometric.hpp>
#include <random>
#include <string>
#include <vector>

#include "base/errors.h"
#include "base/text_file.h"
#include "scene/nff/scene_nff.h"
#include "support/damage.h"
#include "support/loading_speed.h"
#include "support/nff_texts.h"

namespace turner {
namespace {

const std::string &kView = test::kNffView, &kMaterial = test::kNffMaterial;
using test::parseNff;

// The message for a wrong file, one line for each fault.
std::string faultsOf(const std::string& text) {
  try {
    parseNffScene("x.nff", text);
  } catch (const InputError& error) {
    return error.what();
  }
  return "no fault";
}

size_t lineCount(const std::string& text) {
  return 1 + size_t(std::count(text.begin(), text.end(), '\n'));
}

// The text has exactly one fault, at this place and with these words.
void expectFault(const std::string& text, const std::string& place, const std::string& words) {
  const std::string faults = faultsOf(text);
  EXPECT_EQ(lineCount(faults), 1u) << faults;
  EXPECT_EQ(faults.rfind("x.nff:" + place + ": error: ", 0), 0u) << faults << "\nexpected at " << place;
  EXPECT_NE(faults.find(words), std::string::npos) << faults << "\nexpected: " << words;
}

TEST(Nff, EveryEntityIsRead) {
  const Scene scene =
      parseNff("# a comment\nb 0.1 0.2 0.3\n" + kView + "l 1 2 3 4 5 6  # with a colour\n" + kMaterial +
               "s 1 2 3 0.5\np 3\n0 0 0\n1 0 0\n0 1 0\n\npp 3\n0 0 0 0 0 1\n1 0 0 0 0 2\n0 1 0 0 1 1\n" +
               "f 1 1 1 1 0 0 0 0\ns 0 0 0 -2\r\n");
  EXPECT_EQ(scene.name, "test");
  ASSERT_EQ(scene.sources.size(), 1u);
  EXPECT_EQ(scene.sources[0].path, "test.nff");
  EXPECT_EQ(scene.sources[0].sha256.size(), 64u);
  EXPECT_EQ(scene.background, glm::dvec3(0.1, 0.2, 0.3));
  EXPECT_EQ(scene.depth, 5);
  EXPECT_EQ(scene.width, 320);
  EXPECT_EQ(scene.height, 200);
  EXPECT_EQ(scene.camera.eye, glm::dvec3(0, 0, 5));
  EXPECT_EQ(scene.camera.target, glm::dvec3(0));
  EXPECT_EQ(scene.camera.up, glm::dvec3(0, 1, 0));
  EXPECT_EQ(scene.camera.fov, 45);
  ASSERT_EQ(scene.lights.size(), 1u);
  EXPECT_EQ(scene.lights[0].position, glm::dvec3(1, 2, 3));
  EXPECT_EQ(scene.lights[0].color, glm::dvec3(4, 5, 6));
  EXPECT_EQ(scene.lights[0].falloff, Falloff::none);
  ASSERT_EQ(scene.spheres.size(), 2u);
  EXPECT_EQ(scene.spheres[0].center, glm::dvec3(1, 2, 3));
  EXPECT_EQ(scene.spheres[0].radius, 0.5);
  EXPECT_EQ(scene.spheres[0].material, 0u);
  EXPECT_EQ(scene.spheres[1].radius, -2);
  EXPECT_EQ(scene.spheres[1].material, 1u);
  ASSERT_EQ(scene.triangles.size(), 2u);
  EXPECT_FALSE(scene.triangles[0].isSmooth());
  EXPECT_EQ(scene.cornersOf(0)[1], glm::dvec3(1, 0, 0));
  ASSERT_TRUE(scene.triangles[1].isSmooth());
  EXPECT_EQ(scene.normalsOf(1)[1], glm::dvec3(0, 0, 2));
  EXPECT_EQ(scene.normalsOf(1)[2], glm::dvec3(0, 1, 1));
  EXPECT_TRUE(scene.notes.empty());
}

TEST(Nff, MaterialsFollowTheirRule) {
  const Scene scene = parseNff(kMaterial + "f 1 1 1 1 1 0 0 0\n");
  ASSERT_EQ(scene.materials.size(), 2u);
  const Material& material = scene.materials[0];
  EXPECT_EQ(material.name, "f1");
  EXPECT_EQ(scene.materials[1].name, "f2");
  EXPECT_EQ(material.diffuse, 0.8 * glm::dvec3(1, 0.5, 0.25));
  EXPECT_EQ(material.specular, glm::dvec3(0.5));
  EXPECT_EQ(material.shininess, 3);
  EXPECT_EQ(material.reflect, 0.5);
  EXPECT_EQ(material.transmit, 0.25);
  EXPECT_EQ(material.eta, 1.5);
  EXPECT_EQ(material.localWeight, 1);
  // Kd + Ks + T may exceed 1, and an index of 0 does not matter without transmission.
  EXPECT_EQ(scene.materials[1].reflect, 1);
  EXPECT_EQ(scene.materials[1].localWeight, 1);
}

TEST(Nff, LightsWithoutColorShareByTheNumberOfAllLights) {
  const Scene scene = parseNff("l 0 0 1\nl 0 0 2 0.5 0.25 2\nl 0 0 3\nl 0 0 4\n");
  ASSERT_EQ(scene.lights.size(), 4u);
  for (const size_t i : {0, 2, 3}) EXPECT_EQ(scene.lights[i].color, glm::dvec3(0.5));
  EXPECT_EQ(scene.lights[1].color, glm::dvec3(0.5, 0.25, 2));
}

TEST(Nff, ViewLinesMayStandInAnyOrder) {
  const ParsedScene parsed =
      parseNffScene("x.nff", "v\n# comment\nresolution 8 9\nangle 30\n\nup 0 0 1\nat 1 0 0\nfrom 4 5 6\nb 1 1 1\n");
  EXPECT_TRUE(parsed.hasCamera);
  EXPECT_EQ(parsed.scene.camera.eye, glm::dvec3(4, 5, 6));
  EXPECT_EQ(parsed.scene.height, 9);
  EXPECT_EQ(parsed.scene.background, glm::dvec3(1));
}

TEST(Nff, MissingViewMeansNoCamera) {
  EXPECT_FALSE(parseNffScene("x.nff", "").hasCamera);
  EXPECT_FALSE(parseNffScene("x.nff", "b 0 0 0").hasCamera);
  EXPECT_TRUE(parseNffScene("x.nff", kView).hasCamera);
}

TEST(Nff, ConcavePolygonOf144CornersBecomes142Triangles) {
  std::string text = kMaterial + "p 144\n";
  double outline = 0;
  std::vector<std::pair<double, double>> points;
  for (int i = 0; i < 144; ++i) {
    const double angle = 2 * M_PI * i / 144, radius = i % 4 < 2 ? 1 : 0.8;
    // Six digits, as in the SPD's files.
    points.emplace_back(std::round(1e6 * radius * std::cos(angle)) / 1e6,
                        std::round(1e6 * radius * std::sin(angle)) / 1e6);
    text += std::to_string(points.back().first) + " " + std::to_string(points.back().second) + " 0.5\n";
  }
  for (size_t i = 0; i < points.size(); ++i) {
    const auto [ax, ay] = points[i];
    const auto [bx, by] = points[(i + 1) % points.size()];
    outline += ax * by - ay * bx;
  }
  const Scene scene = parseNff(text);
  ASSERT_EQ(scene.triangles.size(), 142u);
  double sum = 0;
  for (const Triangle& triangle : scene.triangles) {
    const auto [a, b, c] = scene.cornersOf(triangle);
    const double twiceArea = glm::cross(b - a, c - a).z;
    EXPECT_GT(twiceArea, 0);
    sum += twiceArea;
  }
  EXPECT_NEAR(sum, outline, 1e-13);
}

TEST(Nff, TrianglesOfAPolygonShareItsCorners) {
  const Scene scene =
      parseNff(kMaterial + "p 3\n0 0 0\n1 0 0\n0 1 0\npp 4\n0 0 0 0 0 1\n1 0 0 0 0 1\n1 1 0 0 0 2\n" + "0 1 0 0 0 1\n");
  ASSERT_EQ(scene.triangles.size(), 3u);
  EXPECT_EQ(scene.positions.size(), 7u);
  EXPECT_EQ(scene.normals.size(), 4u);
  for (size_t i = 1; i < 3; ++i)
    for (size_t k = 0; k < 3; ++k) EXPECT_EQ(scene.triangles[i].positions[k], scene.triangles[i].normals[k] + 3);
}

TEST(Nff, ConesStayWhatTheyAre) {
  const Scene scene =
      parseNff(kMaterial + "c 1 2 3 0.5 4 5 7 0.25\nc 0 0 0 -1 0 0 1 0\n" + kMaterial + "c 0 0 0 0 0 1 0 2\n");
  ASSERT_EQ(scene.cones.size(), 3u);
  EXPECT_TRUE(scene.triangles.empty());
  EXPECT_EQ(scene.cones[0].base, glm::dvec3(1, 2, 3));
  EXPECT_EQ(scene.cones[0].baseRadius, 0.5);
  EXPECT_EQ(scene.cones[0].apex, glm::dvec3(4, 5, 7));
  EXPECT_EQ(scene.cones[0].apexRadius, 0.25);
  EXPECT_EQ(scene.cones[0].material, 0u);
  EXPECT_FALSE(scene.cones[0].isInward());
  EXPECT_TRUE(scene.cones[1].isInward());
  EXPECT_EQ(scene.cones[2].baseRadius, 0);
  EXPECT_EQ(scene.cones[2].material, 1u);
}

TEST(Nff, ConesMayStandOnThreeLines) {
  const Scene one = parseNff(kMaterial + "c 0 -1 0 1 0 1 0 0.5\n"),
              three = parseNff(kMaterial + "c\n0 -1 0 1\n0 1 0 0.5\n");
  ASSERT_EQ(one.cones.size(), 1u);
  ASSERT_EQ(three.cones.size(), 1u);
  EXPECT_EQ(one.cones[0].apex, three.cones[0].apex);
  EXPECT_EQ(one.cones[0].apexRadius, three.cones[0].apexRadius);
  expectFault(kMaterial + "c\n0 -1 0 1\n", "2:1", "the file ends inside this cone");
  expectFault(kMaterial + "c\n0 -1 0 1\ns 0 0 0 1\n", "4:1", "where an end of the cone should stand");
}

TEST(Nff, NumbersAndLinesAreChecked) {
  expectFault("b 0 0\n", "1:6", "found 2 numbers");
  expectFault("b 0 0 0 0\n", "1:9", "more on the line than expected: '0'");
  expectFault("b 0 x 0\n", "1:5", "'x' is not a number");
  expectFault("b 0 1e400 0\n", "1:5", "'1e400' is too large");
  expectFault("b 0 nan 0\n", "1:5", "'nan' is not a number");
  expectFault("b 0 inf 0\n", "1:5", "'inf' is not a number");
  expectFault("b 0 -0.1 0\n", "1:5", "must not be negative");
  expectFault("b 0 0 0\nb 0 0 0\n", "2:1", "a second background");
  expectFault("l 0 0 1e31\n", "1:7", "allowed are numbers from -1e30 to 1e30");
  expectFault("l 0 0 1 1\n", "1:10", "found 4 numbers");
  expectFault("l 0 0 0 1 -1 1\n", "1:11", "must not be negative");
  expectFault("f 1 1 1 1 0 0\n", "1:14", "found 6 numbers");
  expectFault("f 1 -1 1 1 0 0 0 0\n", "1:5", "must not be negative");
  expectFault("f 1 1 1 -1 0 0 0 0\n", "1:9", "Kd is out of its range");
  expectFault("f 1 1 1 1 1.5 0 0 0\n", "1:11", "Ks is out of its range; allowed are values from 0 to 1");
  expectFault("f 1 1 1 1 1 -1 0 0\n", "1:13", "Shine is out of its range");
  expectFault("f 1 1 1 1 1 1 1.5 1\n", "1:15", "T is out of its range");
  expectFault("f 1 1 1 1 1 1 0.5 0\n", "1:19", "index of refraction must be a number greater than 0");
  expectFault("f 1 1 1 1 1 1 0.5\n", "1:18", "index of refraction must be a number greater than 0");
  expectFault("f 1 1 1 1 1 1 0.5 x\n", "1:19", "index of refraction must be a number greater than 0");
}

TEST(Nff, ObjectsAreChecked) {
  expectFault("s 0 0 0 1\ns 0 0 0 2\n", "1:1", "no material yet: an 'f' line must stand before the objects");
  expectFault(kMaterial + "s 0 0 0 0\n", "2:9", "the radius is 0");
  expectFault(kMaterial + "s 0 0 0 1e31\n", "2:9", "'1e31' is too large");
  expectFault(kMaterial + "c 0 0 0 0 1 0 0 0\n", "2:9", "both radii are 0");
  expectFault(kMaterial + "c 0 0 0 1 1 0 0 -1\n", "2:17", "one radius is negative");
  expectFault(kMaterial + "c 0 0 0 1e6 0 0 1 0\n", "2:13", "a polygon is a disc");
  expectFault(kMaterial + "c 1 2 3 1 1 2 3 1\n", "2:11", "the same point");
  expectFault(kMaterial + "c 1 2 3 1 1 2 3\n", "2:16", "found 7 numbers");
  expectFault(kMaterial + "p\n", "2:2", "the number of corners is missing");
  expectFault(kMaterial + "p -1\n", "2:3", "a polygon of -1 corners");
  expectFault(kMaterial + "p 3.5\n", "2:3", "'3.5' is not a number of corners");
  expectFault(kMaterial + "p 3 3\n", "2:5", "more on the line");
  expectFault(kMaterial + "p 1000000000\n0 0 0\n", "2:3", "more than the rest of the file can hold");
  expectFault(kMaterial + "p 99999999999999999999999\n0 0 0\n", "2:3", "more than the rest of the file can hold");
  expectFault(kMaterial + "p 3\n0 0 0\n1 0 0\ns 0 0 0 1\n", "5:1", "the polygon has 2 of its 3 corners");
  expectFault(kMaterial + "p 3\n0 0 0\n1 0 0\n1 1 0\n0 1 0\ns 0 0 0 1\n", "6:1", "found the number '0'");
  expectFault(kMaterial + "p 3\n0 0 0\n1 0 0\n1 1\n", "5:4", "found 2 numbers");
}

TEST(Nff, FileThatEndsInsideAnEntitySaysWhich) {
  expectFault(kMaterial + "p 3\n0 0 0\n1.5 0.25 0.125\n", "2:1",
              "the file ends inside this polygon: the polygon has 2 of its 3 corners");
  expectFault("v\nfrom 0 0 0\n", "1:1", "the file ends inside this view: it lacks 'at', 'up', 'angle', 'resolution'");
}

TEST(Nff, ViewIsChecked) {
  const auto view = [](const std::string& from, const std::string& at, const std::string& up, const std::string& rest) {
    return "v\nfrom " + from + "\nat " + at + "\nup " + up + "\n" + rest;
  };
  const std::string rest = "angle 45\nresolution 8 8\n";
  expectFault(view("1 2 3", "1 2 3", "0 0 1", rest), "3:4", "the same point");
  expectFault(view("0 0 5", "0 0 0", "0 0 0", rest), "4:4", "must not be 0 0 0");
  expectFault(view("0 0 5", "0 0 0", "0 0 -2", rest), "4:4", "parallel to the view");
  expectFault(view("0 0 5", "0 0 0", "0 1 0", "angle 180\nresolution 8 8\n"), "5:7", "less than 180 degrees");
  expectFault(view("0 0 5", "0 0 0", "0 1 0", "angle 0\nresolution 8 8\n"), "5:7", "more than 0");
  expectFault(view("0 0 5", "0 0 0", "0 1 0", "angle 45\nresolution 8 0\n"), "6:14", "whole numbers from 1 to 65536");
  expectFault(view("0 0 5", "0 0 0", "0 1 0", "angle 45\nresolution 8.5 8\n"), "6:12", "not a size in pixels");
  expectFault(view("0 0 5", "0 0 0", "0 1 0", "angle 45\nresolution 8 65537\n"), "6:14", "not a size in pixels");
  expectFault(view("0 0 5", "0 0 0", "0 1 0", "angle 45\nangle 45\nresolution 8 8\n"), "6:1", "stands twice");
  expectFault(view("0 0 5", "0 0 0", "0 1 0", "angle 45\nb 0 0 0\n"), "1:1", "the view lacks 'resolution'");
  expectFault("v 1\n" + kView.substr(2), "1:3", "allowed is 'v' alone");
  expectFault(kView + kView, "8:1", "a second view");
  expectFault("b 0 0 0\nfrom 0 0 0\nat 0 0 0\n", "2:1", "'from' stands outside a view");
}

TEST(Nff, FilesOfAnotherKindAreRefused) {
  expectFault("q 1 2 3\n", "1:1", "unknown entity 'q'; allowed are b, c, f, l, p, pp, s, v and comments with #");
  expectFault("solid\n{\n\xff\n", "1:1", "unknown entity 'solid'; allowed are");
  // They mean to change the shape.
  expectFault(kMaterial + "P 3\n0 0 0\n1 0 0\n0 1 0\n", "2:1", "unknown entity 'P', did you mean 'p'?");
}

TEST(Nff, AllFaultsAreReportedAtOnceInTheirOrder) {
  const std::string faults = faultsOf("b 0 0\nl 0 0 x\nS\n1 2 3\n4 5 6\ns 0 0 0 1\nf 1\ns 1 2 3 0\n");
  EXPECT_EQ(lineCount(faults), 6u) << faults;
  size_t at = 0;
  for (const char* place : {":1:6:", ":2:7:", ":3:1:", ":6:1:", ":7:4:", ":8:9:"}) {
    at = faults.find(place, at);
    ASSERT_NE(at, std::string::npos) << place << '\n' << faults;
  }
}

TEST(Nff, GarbledPolygonIsOneFault) {
  std::string text = kMaterial + "p 200\n";
  for (int i = 0; i < 200; ++i) text += "oops 1 2\n";
  expectFault(text + "s 0 0 0 1\n", "3:1", "'oops' is not a number");
}

TEST(Nff, EndlessFaultsAreCutShort) {
  std::string text;
  for (int i = 0; i < 5000; ++i) text += "b x\n";
  const std::string faults = faultsOf(text);
  EXPECT_EQ(lineCount(faults), 101u);
  EXPECT_NE(faults.find("too many faults"), std::string::npos);
}

const std::string kSmall = "# small\nb 0.5 0.25 1e-3\n" + kView + "l 1 2 3\nl 1 2 3 1 1 1\n" + kMaterial +
                           "s 0 0 0 1\nc 0 0 0 1 1 0 0 0.5\np 5\n0 0 0\n4 0 0\n4 4 0\n1 1 0\n0 4 0\n" +
                           "pp 3\n0 0 0 0 0 1\n1 0 0 0 1 1\n0 1 0 1 0 1\n";

TEST(Nff, DamagedFilesParseOrAreRefused) {
  test::expectSurvivesDamage([](const std::string& text) { parseNff(text); }, kSmall, "dir/test.nff");
}

constexpr size_t kEach = 10'000;

// So many spheres, triangles and smooth triangles, and some gears.
std::string largeNff() {
  std::mt19937_64 random(1);
  const auto vector = [&] {
    std::string numbers;
    for (int k = 0; k < 3; ++k) numbers += ' ' + std::to_string(1e-6 * double(random() % 20'000'000) - 10);
    return numbers.substr(1);
  };
  std::string text = kMaterial;
  for (size_t i = 0; i < kEach; ++i) {
    text += "s " + vector() + " 0.25\n";
    text += "p 3\n" + vector() + '\n' + vector() + '\n' + vector() + '\n';
    text += "pp 3\n";
    for (int k = 0; k < 3; ++k) text += vector() + ' ' + vector() + '\n';
  }
  // Gears, as the SPD has them, are the hard part of a file.
  for (int gear = 0; gear < 10; ++gear) {
    text += "p 144\n";
    for (int i = 0; i < 144; ++i) {
      const double angle = 2 * M_PI * i / 144, radius = i % 4 < 2 ? 1 : 0.8;
      text += std::to_string(radius * std::cos(angle)) + ' ' + std::to_string(radius * std::sin(angle)) + " 0\n";
    }
  }
  return text;
}

TEST(Nff, LargeFilesAreReadWhole) {
  const Scene scene = parseNff(largeNff());
  EXPECT_EQ(scene.spheres.size(), kEach);
  EXPECT_EQ(scene.triangles.size(), 2 * kEach + 10 * 142);
}

TEST(TimingNff, LargeFilesAreReadFast) {
  const std::string text = largeNff();
  const double ratio = test::timeBesideSumming(text, [](const std::string& t) { parseNff(t); });
  RecordProperty("time_beside_summing", std::to_string(ratio));
  EXPECT_LT(ratio, test::kMostTimeBesideSumming);
}

TEST(Nff, SpdScenesHaveTheirPublishedCounts) {
  struct Expected {
    const char* file;
    size_t lights, spheres, cones, triangles, smooth;
  };
  const std::filesystem::path folder = std::filesystem::path(TURNER_SCENES_DIR) / "spd";
  for (const Expected& expected : {Expected{"balls.nff", 3, 7381, 0, 2, 0},
                                   {"gears.nff", 5, 0, 0, 9217 * 2 + 128 * 142, 0},
                                   {"mount.nff", 1, 4, 0, 8192, 0},
                                   {"rings.nff", 3, 4200, 4200, 2, 0},
                                   {"teapot.nff", 2, 0, 0, 2256 + 36 * 2, 2256}}) {
    SCOPED_TRACE(expected.file);
    const std::string path = (folder / expected.file).string();
    const ParsedScene parsed = parseNffScene(path, readTextFile(path));
    EXPECT_TRUE(parsed.hasCamera);
    EXPECT_EQ(parsed.scene.width, 512);
    EXPECT_EQ(parsed.scene.lights.size(), expected.lights);
    EXPECT_EQ(parsed.scene.spheres.size(), expected.spheres);
    EXPECT_EQ(parsed.scene.cones.size(), expected.cones);
    EXPECT_EQ(parsed.scene.triangles.size(), expected.triangles);
    EXPECT_EQ(std::count_if(parsed.scene.triangles.begin(), parsed.scene.triangles.end(),
                            [](const Triangle& triangle) { return triangle.isSmooth(); }),
              std::ptrdiff_t(expected.smooth));
    EXPECT_TRUE(parsed.scene.notes.empty());
  }
}

}  // namespace
}  // namespace turner
