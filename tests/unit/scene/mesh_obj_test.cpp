// OBJ files become meshes by the format's rules, and wrong ones are refused with every fault at its place.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <tuple>
#include <vector>

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

// The text is read, with one note, at this place and with these words.
Mesh expectNote(const std::string& text, const std::string& place, const std::string& words) {
  SCOPED_TRACE(text);
  const Mesh mesh = parse(text);
  EXPECT_EQ(mesh.notes, std::vector<std::string>{"x.obj:" + place + ": note: " + words});
  return mesh;
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
  for (const char* face : {"f 1 2 3", "fo 1 2 3", "f 1/1 2/2 3/3", "f 1/x 2/0 3/-9", "f 1/ 2/ 3/", "f 1/1/ 2/2/ 3/3/",
                           "f 1// 2// 3//", "f +1 2 3"}) {
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
  EXPECT_TRUE(mesh.notes.empty());
  // At the end of the file it joins nothing.
  EXPECT_EQ(parse(kSquare + "f 1 2 3 4 \\").faces.size(), 2u);
  // Elsewhere a backslash is no blank.
  expectFault(kSquare + "f 1 2 \\ 3\n", "5:7", "'\\' is not a corner");
}

// A path of DOS, or any name, may end in a backslash: the statement behind it is one.
TEST(Obj, BackslashBehindWhatIsPassedOverSwallowsNothing) {
  for (const char* name : {"usemtl wood\\\n", "usemtl wood\\\r\n", "usemtl wood\\  \n", "mtllib c:\\\n", "g \\\n",
                           "usemtl\\\n", "# comment \\\n", "vt 0 0 \\\n"}) {
    SCOPED_TRACE(name);
    const Mesh mesh = parse(kSquare + name + "f 1 2 3\n" + name + "f 1 3 4\n");
    EXPECT_EQ(mesh.faces.size(), 2u);
    EXPECT_TRUE(mesh.notes.empty());
  }
  // What does not begin a statement belongs to the line before.
  const Mesh mesh = parse(kSquare + "l 1 2 \\\n 3 4 \\\r\n 1\ng one \\\n two\nf 1 2 3\n");
  EXPECT_EQ(mesh.faces.size(), 1u);
  EXPECT_TRUE(mesh.notes.empty());
}

TEST(Obj, LineEndsOfWindowsAndMissingLastLineEndAreTaken) {
  const Mesh mesh = parse("\xEF\xBB\xBFv 0 0 0\r\nv 1 0 0\r\n\r\nv 0 1 0\r\n# x\r\nf 1 2 3");
  EXPECT_EQ(mesh.positions.size(), 3u);
  EXPECT_EQ(mesh.faces.size(), 1u);
  EXPECT_TRUE(mesh.notes.empty());
}

TEST(Obj, VerticesAreReadWithAnythingBehindThem) {
  const Mesh mesh = parse("v 0 0 0 1\nv 1 0 0 0.5 0.5 0.5\nv 0 1 0 1 0.5 0.5 0.5\nf 1 2 3\n");
  EXPECT_EQ(mesh.positions.at(1), glm::dvec3(1, 0, 0));
  EXPECT_TRUE(mesh.notes.empty());
  for (const char* extra : {"4 5", "4 5 6 7 8", "red", "nan nan nan", "1 inf 1e999"}) {
    expectNote(kSquare + "v 1 2 3 " + extra + "\nf 1 2 3\n", "5:1",
               "1 vertex has something behind x y z that is neither a weight nor a colour");
  }
  // A missing line end would take a vertex away.
  expectFault("v 0 0 0 v 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\n", "1:9", "'v' begins a statement");
}

TEST(Obj, WhatSaysNothingAboutTheShapeIsPassedOver) {
  const Mesh mesh = parse(
      "mtllib a b.mtl\no name\ng a b\ns off\nmg 1 2\nusemtl x#y\nvt 0.5 0.5\nvp 1 2\nusemap off\n"
      "bevel on\nc_interp on\nd_interp on\nlod 1\nshadow_obj a\ntrace_obj b\nmaplib m\n" +
      kSquare + "l 1 2\np 1\nf 1 2 3\n");
  EXPECT_EQ(mesh.faces.size(), 1u);
  EXPECT_TRUE(mesh.notes.empty());
}

TEST(Obj, UnknownStatementsAreCounted) {
  expectNote(kSquare + "vw 1 0 0.5\nf 1 2 3\n", "5:1", "1 unknown statement was passed over: 'vw', did you mean 'v'?");
  expectNote(kSquare + "usemlt x\nf 1 2 3\nsomething\n", "5:1",
             "2 unknown statements were passed over: 'usemlt', did you mean 'usemtl'?; the first is here");
  expectNote(kSquare + "f 1 2 3\n\x1Asomething\n", "6:1", "1 unknown statement was passed over: '?something'");
  expectNote("newmtl a\nKa 1 1 1\n  map_Kd -s 1 1 1 a.png\nd 1\nillum 2\n" + kSquare + "f 1 2 3\n", "1:1",
             "5 lines of a material library were passed over; the first is here");
}

// They mean to change the shape: without them it would be wrong.
TEST(Obj, StatementsInCapitalLettersAreRefused) {
  expectFault(kSquare + "V 0 0 0\nf 1 2 3\n", "5:1", "unknown statement 'V', did you mean 'v'?");
  expectFault(kSquare + "F 1 2 3\n", "5:1", "unknown statement 'F', did you mean 'f'?");
  expectFault(kSquare + "VN 0 0 1\nf 1 2 3\n", "5:1", "unknown statement 'VN', did you mean 'vn'?");
}

TEST(Obj, FilesOfAnotherKindAreRefusedInOneLine) {
  expectFault("solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nendsolid\n", "1:1",
              "unknown statement 'solid', and no faces in the whole file");
  expectFault(
      "\x7F"
      "ELF\x02\n\xFF\n",
      "1:1", "unknown statement '?ELF?', and no faces");
}

TEST(Obj, FreeFormGeometryIsNotSupported) {
  for (const char* word : {"cstype", "deg", "bmat", "step", "curv", "curv2", "surf", "parm", "trim", "hole", "scrv",
                           "sp", "end", "con", "call", "csh"}) {
    expectFault(kSquare + word + " 1 2 3\nf 1 2 3\n", "5:1", std::string("'") + word + "' is not supported");
  }
}

TEST(Obj, IndicesAreChecked) {
  expectFault(kSquare + "f 1 2 5\n", "5:7",
              "there is no vertex '5'; allowed are 1 to 4, and -1 to -4 counted back from here");
  expectFault(kSquare + "f 1 2 0\n", "5:7", "there is no vertex '0'");
  expectFault(kSquare + "f -5 2 1\n", "5:3", "there is no vertex '-5'");
  expectFault(kSquare + "f 1 2 99999999999999999999\n", "5:7", "there is no vertex '99999999999999999999'");
  expectFault("f 1 2 3\n", "1:3", "there is no vertex '1'; none stands before this face");
  expectFault(kSquare + "f 1 2 x\n", "5:7", "'x' is not a corner");
  expectFault(kSquare + "f 1 2 1.5\n", "5:7", "'1.5' is not a corner");
  expectFault(kSquare + "f 1 2 /3\n", "5:7", "'/3' is not a corner");
  expectFault(kSquare + "f 1 2 3/1/1/1\n", "5:7", "'3/1/1/1' is not a corner");
}

TEST(Obj, FacesAreChecked) {
  expectFault(kSquare, "5:1", "the mesh has no faces");
  expectFault("", "1:1", "the mesh has no faces");
  expectFault(kSquare + "f 1 2\n", "6:1", "the mesh has no faces; at least one 'f' line of 3 corners");
  for (const char* face : {"f 1 2\n", "f 1\n", "f\n"}) {
    const Mesh mesh = expectNote(kSquare + "f 1 2 3\n" + face, "6:1", "1 face of fewer than 3 corners was dropped");
    EXPECT_EQ(mesh.faces.size(), 1u);
  }
  const Mesh mesh = expectNote(kSquare + "f 1 2 1 2\nf 1 1 1 1 1\nf 1 2 3\n", "5:1",
                               "2 polygons without area were dropped; the first is here");
  EXPECT_EQ(mesh.faces.size(), 1u);
}

TEST(Obj, FacesThatCrossThemselvesAreCutAndCounted) {
  const Mesh mesh =
      expectNote(kSquare + "f 1 2 3 4\nf 1 2 4 3\nf 1 3 2 4\n", "6:1",
                 "2 faces cross or overlap themselves and were cut into triangles anyhow; the first is here");
  EXPECT_EQ(mesh.faces.size(), 6u);
}

TEST(Obj, WarpedFacesKeepAllCorners) {
  const Mesh mesh = parse("v 0 0 0\nv 1 0 0\nv 1 0 0.5\nv 0 1 0\nv 0 0 0\nv 35 80 -11\nv 28 51 -7\nv -1 -23 -24\n" +
                          std::string("f 1 2 3 4\nf 5 6 7 8\n"));
  ASSERT_EQ(mesh.faces.size(), 4u);
  EXPECT_EQ(mesh.faces[0].vertices, (Indices{0, 1, 2}));
  EXPECT_EQ(mesh.faces[1].vertices, (Indices{0, 2, 3}));
  EXPECT_EQ(mesh.faces[2].vertices, (Indices{4, 5, 6}));
  EXPECT_EQ(mesh.faces[3].vertices, (Indices{7, 4, 6}));
  EXPECT_TRUE(mesh.notes.empty());
}

// What only shades never refuses a file.
TEST(Obj, FacesWithoutAllTheirNormalsAreFlat) {
  const std::string lacks = "1 face lacks the normal of a corner and is flat";
  for (const char* face : {"f 1//0 2//0 3//0\n", "f 1//1 2//3 3//1\n", "f 1//-3 2//1 3//1\n", "f 1//x 2//1 3//1\n",
                           "f 1//1 2 3//1\n", "f 1 2//1 3//1\n", "f 1//99999999999999999999 2//1 3//1\n"}) {
    const Mesh mesh = expectNote(kSquare + kNormals + face + "f 1//1 3//1 4//1\n", "7:1", lacks);
    ASSERT_EQ(mesh.faces.size(), 2u);
    EXPECT_EQ(mesh.faces[0].normals, kNone);
    EXPECT_EQ(mesh.faces[1].normals, (Indices{0, 0, 0}));
  }
  EXPECT_EQ(expectNote(kSquare + "f 1//1 2//2 3//3\n", "5:1", lacks).faces.at(0).normals, kNone);
  for (const char* normal : {"vn 0 0 0\n", "vn nan nan nan\n", "vn 0 0 1e31\n", "vn 0 1\n", "vn x y z\n", "vn\n"}) {
    const Mesh mesh = expectNote(kSquare + normal + kNormals + "f 1//1 2//2 3//2\nf 1//2 3//2 4//3\n", "5:1",
                                 "1 normal has no direction; faces with it are flat");
    ASSERT_EQ(mesh.faces.size(), 2u);
    EXPECT_EQ(mesh.faces[0].normals, kNone);
    EXPECT_EQ(mesh.faces[1].normals, (Indices{1, 1, 2}));
  }
  const Mesh mesh =
      expectNote(kSquare + "vn 0 0 1 1\nf 1//1 2//1 3//1\n", "5:1", "1 normal has something behind x y z");
  EXPECT_EQ(mesh.faces.at(0).normals, (Indices{0, 0, 0}));
}

TEST(Obj, NumbersOfVerticesAreChecked) {
  for (const auto& [vertex, column, words] :
       {std::tuple{"v 1 2", "6", "found 2 numbers"}, std::tuple{"v 1 2 x", "7", "'x' is not a number"},
        std::tuple{"v 1 2 nan", "7", "'nan' is not a number"}, std::tuple{"v 1 2 1e400", "7", "'1e400' is too large"},
        std::tuple{"v 1 2 -1e31", "7", "'-1e31' is too large"}}) {
    // Told once, however many faces have it; no fault where none has.
    expectFault(kSquare + vertex + "\nf 1 2 5\nf 2 3 -1\n", "5:" + std::string(column), words);
    expectNote(kSquare + vertex + "\nf 1 2 3\n", "5:1", "1 vertex is no place, but no face has it");
  }
  // A wrong vertex still counts: the faces behind it are not wrong too.
  expectFault("v 0 0 x\nv 1 0 0\nv 1 1 0\nf 1 2 3\n", "1:7", "'x' is not a number");
  expectNote("v 0 0 x\nv 0 0 0\nv 1 0 0\nv 1 1 \\\nx\nv 1 1 0\nf 2 3 5\n", "1:1",
             "2 vertices are no places, but no face has them; the first is here");
}

TEST(Obj, AllFaultsAreReportedAtOnce) {
  const std::string faults = faultsOf("v 0 0\nv 1 0 0\nv x\nf 1 2 3\nf 1 2 9\nV 0\nsurf\n");
  EXPECT_EQ(lineCount(faults), 5u) << faults;
  std::string many;
  for (int i = 0; i < 5000; ++i) many += "f 1\n";
  EXPECT_EQ(lineCount(faultsOf(many)), 101u);
}

const std::string kSmall = "# small\nmtllib a.mtl\n" + kSquare + "v 0.5 0.25 1e-3\n" + kNormals +
                           "vt 0 1\nusemtl a\nf 1//1 2//1 3//2\nf 1/1/1 2/1/2 3/1/1 4/1/2\nf -5 -4 -3 \\\n -1 -2\n";

// What is behind a mesh that was read may rely on it.
void expectSound(const Mesh& mesh) {
  const auto isFinite = [](const glm::dvec3& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
  };
  EXPECT_TRUE(std::all_of(mesh.positions.begin(), mesh.positions.end(), isFinite));
  EXPECT_FALSE(mesh.faces.empty() && mesh.notes.empty());
  for (const auto& [vertices, normals] : mesh.faces) {
    for (const uint32_t vertex : vertices) ASSERT_LT(vertex, mesh.positions.size());
    if (normals == kNone) continue;
    for (const uint32_t normal : normals) {
      ASSERT_LT(normal, mesh.normals.size());
      EXPECT_TRUE(isFinite(mesh.normals[normal]) && mesh.normals[normal] != glm::dvec3(0));
    }
  }
  for (const std::string& note : mesh.notes) {
    EXPECT_TRUE(note.starts_with("x.obj:") && note.find(": note: ") != note.npos && note.find('\n') == note.npos)
        << note;
  }
}

TEST(Obj, DamagedFilesParseOrAreRefused) {
  test::expectSurvivesDamage([](const std::string& text) { expectSound(parse(text)); }, kSmall, "x.obj");
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
