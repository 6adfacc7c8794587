// OBJ files become meshes by the format's rules, and wrong ones are refused with every fault at its place.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>

#include "base/errors.h"
#include "base/text_file.h"
#include "scene/obj/mesh_obj.h"
#include "support/damage.h"
#include "support/loading_speed.h"

namespace turner {
namespace {

using Indices = std::array<uint32_t, 3>;
constexpr Indices kNone{UINT32_MAX, UINT32_MAX, UINT32_MAX};

const std::string kSquare = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
const std::string kNormals = "vn 0 0 1\nvn 0 1 1\n";

Mesh parse(const std::string& text) {
  return parseObj("x.obj", text);
}

std::string faultsOf(const std::string& text) {
  try {
    parse(text);
  } catch (const InputError& error) {
    return error.what();
  }
  return "no fault";
}

size_t lineCount(const std::string& text) {
  return 1 + size_t(std::count(text.begin(), text.end(), '\n'));
}

void expectFault(const std::string& text, const std::string& place, const std::string& words) {
  const std::string faults = faultsOf(text);
  EXPECT_EQ(lineCount(faults), 1u) << faults;
  EXPECT_EQ(faults.rfind("x.obj:" + place + ": error: ", 0), 0u) << faults << "\nexpected at " << place;
  EXPECT_NE(faults.find(words), std::string::npos) << faults << "\nexpected: " << words;
}

TEST(Obj, VerticesNormalsAndFacesAreRead) {
  const Mesh mesh = parse("# mesh\n" + kSquare + kNormals + "f 1//1 2//1 3//2\nf 1 3 4\n");
  ASSERT_EQ(mesh.positions.size(), 4u);
  EXPECT_EQ(mesh.positions[2], glm::dvec3(1, 1, 0));
  ASSERT_EQ(mesh.normals.size(), 2u);
  EXPECT_EQ(mesh.normals[1], glm::dvec3(0, 1, 1));
  ASSERT_EQ(mesh.faces.size(), 2u);
  EXPECT_EQ(mesh.faces[0].vertices, (Indices{0, 1, 2}));
  EXPECT_EQ(mesh.faces[0].normals, (Indices{0, 0, 1}));
  EXPECT_EQ(mesh.faces[1].vertices, (Indices{0, 2, 3}));
  EXPECT_EQ(mesh.faces[1].normals, kNone);
}

TEST(Obj, AllFormsOfCornersAreRead) {
  for (const char* face : {"f 1 2 3", "f 1/1 2/2 3/3", "f 1/ 2/ 3/", "f 1/1/ 2/2/ 3/3/", "f 1// 2// 3//", "f +1 2 3"}) {
    const Mesh mesh = parse(kSquare + kNormals + face);
    EXPECT_EQ(mesh.faces.at(0).vertices, (Indices{0, 1, 2})) << face;
    EXPECT_EQ(mesh.faces.at(0).normals, kNone) << face;
  }
  for (const char* face : {"f 1//2 2//1 3//2", "f 1/1/2 2/2/1 3/3/2", "f 1/-1/-1 2/-1/-2 3/-1/2"}) {
    const Mesh mesh = parse(kSquare + kNormals + face);
    EXPECT_EQ(mesh.faces.at(0).vertices, (Indices{0, 1, 2})) << face;
    EXPECT_EQ(mesh.faces.at(0).normals, (Indices{1, 0, 1})) << face;
  }
}

TEST(Obj, NegativeIndicesCountBackFromTheFace) {
  const Mesh mesh = parse(kSquare + "f -4 -3 -2\nv 2 2 0\nf -1 -2 -5\n");
  EXPECT_EQ(mesh.faces.at(0).vertices, (Indices{0, 1, 2}));
  EXPECT_EQ(mesh.faces.at(1).vertices, (Indices{4, 3, 0}));
}

TEST(Obj, PolygonsBecomeTrianglesWithTheirNormals) {
  const Mesh square = parse(kSquare + kNormals + "f 1//1 2//2 3//1 4//2\n");
  ASSERT_EQ(square.faces.size(), 2u);
  EXPECT_EQ(square.faces[0].vertices, (Indices{0, 1, 2}));
  EXPECT_EQ(square.faces[1].vertices, (Indices{0, 2, 3}));
  EXPECT_EQ(square.faces[1].normals, (Indices{0, 0, 1}));

  // A gear of 144 corners: concave, so that a fan would be wrong.
  std::string text, face = "f";
  for (int i = 0; i < 144; ++i) {
    const double angle = 2 * M_PI * i / 144, radius = i % 4 < 2 ? 1 : 0.8;
    text += "v " + std::to_string(radius * std::cos(angle)) + " " + std::to_string(radius * std::sin(angle)) + " 0\n";
    face += " " + std::to_string(i + 1);
  }
  EXPECT_EQ(parse(text + face).faces.size(), 142u);
}

TEST(Obj, BackslashJoinsLines) {
  const Mesh mesh =
      parse("v 0 0 \\\n0\nv 1 0 0\nv 1 1\\\r\n 0\nv 0 1 0\nf 1 2 \\  \n\\\n 3 4\nf 1 2 3 # comment \\\nf 1 2 3\n");
  EXPECT_EQ(mesh.positions.size(), 4u);
  EXPECT_EQ(mesh.faces.size(), 4u);
  // Elsewhere a backslash is no blank.
  expectFault(kSquare + "f 1 2 \\ 3\n", "5:7", "'\\' is not a corner");
}

TEST(Obj, LineEndsOfWindowsAndMissingLastLineEndAreTaken) {
  const Mesh mesh = parse("\xEF\xBB\xBFv 0 0 0\r\nv 1 0 0\r\n\r\nv 0 1 0\r\n# x\r\nf 1 2 3");
  EXPECT_EQ(mesh.positions.size(), 3u);
  EXPECT_EQ(mesh.faces.size(), 1u);
}

TEST(Obj, WeightsAndColorsBehindVerticesArePassedOver) {
  EXPECT_EQ(parse("v 0 0 0 1\nv 1 0 0 0.5 0.5 0.5\nv 0 1 0 1 0.5 0.5 0.5\nf 1 2 3\n").positions.at(1),
            glm::dvec3(1, 0, 0));
  expectFault(kSquare + "v 1 2 3 4 5\nf 1 2 3\n", "5:12", "too many or too few numbers");
  expectFault(kSquare + "v 1 2 3 4 5 6 7 8\nf 1 2 3\n", "5:17", "too many or too few numbers");
  expectFault(kSquare + "v 1 2 3 red\nf 1 2 3\n", "5:9", "'red' is not a number");
}

TEST(Obj, WhatSaysNothingAboutTheShapeIsPassedOver) {
  const Mesh mesh = parse(
      "mtllib a b.mtl\no name\ng a b\ns off\nmg 1 2\nusemtl x#y\nvt 0.5 0.5\nvp 1 2\nusemap off\n"
      "bevel on\nc_interp on\nd_interp on\nlod 1\nshadow_obj a\ntrace_obj b\nmaplib m\n" +
      kSquare + "l 1 2\np 1\nf 1 2 3\n");
  EXPECT_EQ(mesh.faces.size(), 1u);
}

TEST(Obj, FreeFormGeometryIsNotSupported) {
  for (const char* word : {"cstype", "deg", "bmat", "step", "curv", "curv2", "surf", "parm", "trim", "hole", "scrv",
                           "sp", "end", "con", "call", "csh"}) {
    expectFault(kSquare + word + " 1 2 3\nf 1 2 3\n", "5:1", std::string("'") + word + "' is not supported");
  }
}

TEST(Obj, UnknownStatementsNameTheNearestKnownOne) {
  expectFault(kSquare + "usemlt x\nf 1 2 3\n", "5:1", "unknown statement 'usemlt', did you mean 'usemtl'?");
  expectFault(kSquare + "f 1 2 3\nsomething\n", "6:1", "unknown statement 'something'; allowed are");
}

TEST(Obj, IndicesAreChecked) {
  expectFault(kSquare + "f 1 2 5\n", "5:7",
              "there is no vertex '5'; allowed are 1 to 4, and -1 to -4 counted back from here");
  expectFault(kSquare + "f 1 2 0\n", "5:7", "there is no vertex '0'");
  expectFault(kSquare + "f -5 2 1\n", "5:3", "there is no vertex '-5'");
  expectFault(kSquare + "f 1 2 99999999999999999999\n", "5:7", "there is no vertex '99999999999999999999'");
  expectFault(kSquare + kNormals + "f 1//1 2//3 3//1\n", "7:8", "there is no normal '3'; allowed are 1 to 2");
  expectFault(kSquare + "f 1//1 2//1 3//1\n", "5:3", "there is no normal '1'; none stands before this face");
  expectFault("f 1 2 3\n", "1:3", "there is no vertex '1'; none stands before this face");
  expectFault(kSquare + "f 1 2 x\n", "5:7", "'x' is not a corner");
  expectFault(kSquare + "f 1 2 1.5\n", "5:7", "'1.5' is not a corner");
  expectFault(kSquare + "f 1 2 /3\n", "5:7", "'/3' is not a corner");
  expectFault(kSquare + "f 1 2 3/x\n", "5:7", "'3/x' is not a corner");
  expectFault(kSquare + "f 1 2 3/1/1/1\n", "5:7", "'3/1/1/1' is not a corner");
}

TEST(Obj, FacesAreChecked) {
  expectFault(kSquare + "f 1 2\n", "5:1", "a face of 2 corners; allowed are 3 and more");
  expectFault(kSquare + "f 1\n", "5:1", "a face of 1 corner;");
  expectFault(kSquare + "f\n", "5:1", "a face of 0 corners");
  expectFault(kSquare + kNormals + "f 1//1 2 3//1\n", "7:8", "all or none");
  expectFault(kSquare + kNormals + "f 1 2//1 3//1\n", "7:5", "all or none");
  expectFault(kSquare + "f 1 3 2 4\n", "5:1", "crosses or overlaps itself near its corner");
  expectFault(kSquare, "5:1", "the mesh has no faces");
  expectFault("", "1:1", "the mesh has no faces");
}

TEST(Obj, NumbersAreChecked) {
  expectFault(kSquare + "v 1 2\nf 1 2 3\n", "5:6", "found 2 numbers");
  expectFault(kSquare + "v 1 2 x\nf 1 2 3\n", "5:7", "'x' is not a number");
  expectFault(kSquare + "v 1 2 nan\nf 1 2 3\n", "5:7", "'nan' is not a number");
  expectFault(kSquare + "v 1 2 1e400\nf 1 2 3\n", "5:7", "'1e400' is too large");
  expectFault(kSquare + "v 1 2 -1e31\nf 1 2 3\n", "5:7", "'-1e31' is too large");
  expectFault(kSquare + "vn 0 0 0\nf 1 2 3\n", "5:4", "a normal must not be 0 0 0");
  expectFault(kSquare + "vn 0 0 1 1\nf 1 2 3\n", "5:10", "more on the line");
  // A wrong vertex still counts: the faces behind it are not wrong too.
  expectFault("v 0 0 x\nv 1 0 0\nv 1 1 0\nf 1 2 3\n", "1:7", "'x' is not a number");
}

TEST(Obj, AllFaultsAreReportedAtOnce) {
  const std::string faults = faultsOf("v 0 0\nv 1 0 0\nvn 0 0 0\nf 1 2 9\nfoo\nf 1 2\n");
  EXPECT_EQ(lineCount(faults), 5u) << faults;
  std::string many;
  for (int i = 0; i < 5000; ++i) many += "f\n";
  EXPECT_EQ(lineCount(faultsOf(many)), 101u);
}

const std::string kSmall = "# small\nmtllib a.mtl\n" + kSquare + "v 0.5 0.25 1e-3\n" + kNormals +
                           "vt 0 1\nusemtl a\nf 1//1 2//1 3//2\nf 1/1/1 2/1/2 3/1/1 4/1/2\nf -5 -4 -3 \\\n -1 -2\n";

TEST(Obj, DamagedFilesParseOrAreRefused) {
  test::expectSurvivesDamage([](const std::string& text) { parse(text); }, kSmall, "x.obj");
}

// A grid of bumps, as programs write it.
constexpr int kSide = 200;

// A surface of kSide x kSide points with normals.
std::string largeObj() {
  std::string text;
  for (const char* word : {"v", "vn"}) {
    for (int i = 0; i < kSide * kSide; ++i) {
      const double x = 0.01 * (i % kSide), y = 0.01 * (i / kSide);
      text += std::string(word) + ' ' + std::to_string(x) + ' ' + std::to_string(y) + ' ' +
              std::to_string(1 + std::sin(9 * x) * std::cos(7 * y)) + '\n';
    }
  }
  for (int i = 0; i + kSide + 1 < kSide * kSide; ++i) {
    const auto corner = [](int k) { return std::to_string(k + 1) + "//" + std::to_string(k + 1); };
    text += "f " + corner(i) + ' ' + corner(i + 1) + ' ' + corner(i + kSide) + '\n';
    text += "f " + corner(i + 1) + ' ' + corner(i + kSide + 1) + ' ' + corner(i + kSide) + '\n';
  }
  return text;
}

TEST(Obj, LargeFilesAreReadWhole) {
  EXPECT_EQ(parse(largeObj()).faces.size(), 2u * (kSide * kSide - kSide - 1));
}

TEST(TimingObj, LargeFilesAreReadFast) {
  const std::string text = largeObj();
  const double ratio = test::timeBesideSumming(text, [](const std::string& t) { parse(t); });
  RecordProperty("time_beside_summing", std::to_string(ratio));
  EXPECT_LT(ratio, test::kMostTimeBesideSumming);
}

TEST(Obj, RealMeshesHaveTheirCounts) {
  struct Expected {
    const char* file;
    size_t positions, faces;
  };
  for (const Expected& expected : {Expected{TURNER_SCENES_DIR "/spot.obj", 2930, 5856},
                                   {TURNER_BENCH_DIR "/meshes/stanford-bunny.obj", 35947, 69451}}) {
    SCOPED_TRACE(expected.file);
    const Mesh mesh = parseObj(expected.file, readTextFile(expected.file));
    EXPECT_EQ(mesh.positions.size(), expected.positions);
    EXPECT_EQ(mesh.faces.size(), expected.faces);
  }
}

}  // namespace
}  // namespace turner
