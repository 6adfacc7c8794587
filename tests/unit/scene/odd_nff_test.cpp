// NFF files that are not quite right are read, and one note for each kind says what was odd, how often, and where
// first.
#include <gtest/gtest.h>

#include <array>
#include <string>
#include <vector>

#include "support/nff_texts.h"

namespace turner {
namespace {

const std::string &kView = test::kNffView, &kMaterial = test::kNffMaterial;
using test::parseNff;

// The text is read, with one note, at this place and with these words.
Scene expectNote(const std::string& text, const std::string& place, const std::string& words) {
  SCOPED_TRACE(text);
  const Scene scene = parseNff(text);
  EXPECT_EQ(scene.notes, std::vector<std::string>{"dir/test.nff:" + place + ": note: " + words});
  return scene;
}

TEST(OddNff, PolygonsWithoutAreaAreDroppedAndCounted) {
  const std::string line = "p 3\n0 0 0\n1 1 1\n2 2 2\n";
  expectNote(kMaterial + line, "2:1", "1 polygon without area was dropped");
  const Scene scene = expectNote(kMaterial + line + "p 4\n1 0 0\n1 0 0\n1 0 0\n1 0 0\n" + "p 3\n0 0 0\n1 0 0\n0 1 0\n",
                                 "2:1", "2 polygons without area were dropped; the first is here");
  EXPECT_EQ(scene.triangles.size(), 1u);
}

TEST(OddNff, PolygonsOfFewCornersAreDroppedAndCounted) {
  for (const char* polygon : {"p 2\n0 0 0\n1 0 0\n", "p 1\n0 0 0\n", "p 0\n", "pp 2\n0 0 0 0 0 1\n1 0 0 0 0 0\n"}) {
    const Scene scene =
        expectNote(kMaterial + polygon + "s 0 0 0 1\n", "2:1", "1 polygon of fewer than 3 corners was dropped");
    EXPECT_EQ(scene.spheres.size(), 1u);
    EXPECT_TRUE(scene.triangles.empty());
  }
}

TEST(OddNff, PolygonsThatCrossThemselvesAreCutAndCounted) {
  const std::string bowtie = "p 4\n0 0 0\n2 2 0\n2 0 0\n0 2 0\n";
  const Scene scene =
      expectNote(kMaterial + bowtie + "s 0 0 0 1\n" + bowtie, "2:1",
                 "2 polygons cross or overlap themselves and were cut into triangles anyhow; the first is here");
  EXPECT_EQ(scene.triangles.size(), 4u);
}

TEST(OddNff, WarpedPolygonsKeepAllCorners) {
  const Scene scene = parseNff(kMaterial + "p 4\n0 0 0\n0 0 -2\n1 0 -1\n0 -1 0\n");
  ASSERT_EQ(scene.triangles.size(), 2u);
  EXPECT_EQ(scene.triangles[0].positions, (std::array<uint32_t, 3>{0, 1, 2}));
  EXPECT_EQ(scene.triangles[1].positions, (std::array<uint32_t, 3>{0, 2, 3}));
  EXPECT_TRUE(scene.notes.empty());
}

// What only shades never refuses a file.
TEST(OddNff, PatchesWithoutAllTheirNormalsAreFlat) {
  for (const char* normal : {"0 0 0", "0 0 nan", "x y z", "0 0 1e31", "0 1", ""}) {
    const Scene scene = expectNote(kMaterial + "pp 3\n0 0 0 0 0 1\n1 0 0 " + normal + "\n1 1 0 0 0 1\n" +
                                       "pp 3\n0 0 0 0 0 1\n1 0 0 0 0 1\n1 1 0 0 0 1\n",
                                   "2:1", "1 polygon has a normal without a direction and is flat");
    ASSERT_EQ(scene.triangles.size(), 2u);
    EXPECT_FALSE(scene.triangles[0].isSmooth());
    EXPECT_TRUE(scene.triangles[1].isSmooth());
    EXPECT_EQ(scene.normalsOf(1)[2], glm::dvec3(0, 0, 1));
  }
}

TEST(OddNff, UnknownEntitiesAreCounted) {
  const Scene scene = expectNote("b 1 1 1\nq 1 2 3\n1 2\n3 4\nzz\n" + kMaterial + "s 0 0 0 1\n  x\xff\ns 0 0 0 2\n",
                                 "2:1", "3 unknown entities were passed over: 'q'; the first is here");
  EXPECT_EQ(scene.background, glm::dvec3(1));
  EXPECT_EQ(scene.spheres.size(), 2u);
  EXPECT_EQ(expectNote(kView + "yon 100\naspect 1.3\n", "8:1",
                       "2 unknown entities were passed over: 'yon'; the first is here")
                .width,
            320);
}

// The index of refraction counts only where T > 0, hither never.
TEST(OddNff, WhatIsNotUsedMayBeMissingOrWrong) {
  for (const char* material : {"f 1 1 1 1 0 0 0\n", "f 1 1 1 1 0 0 0 nan\n", "f 1 1 1 1 0 0 0 -1\n"})
    EXPECT_EQ(parseNff(material).materials.size(), 1u);
  const std::string view = "v\nfrom 0 0 5\nat 0 0 0\nup 0 1 0\nangle 45\nresolution 8 8\n";
  for (const char* hither : {"", "hither nan\n", "hither\n", "hither 1 2\n", "hither x\n"})
    EXPECT_EQ(parseNff(view + hither).width, 8);
}

}  // namespace
}  // namespace turner
