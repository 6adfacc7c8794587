// The scene format: exact values, and faults with their exact places.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <glm/geometric.hpp>
#include <string>
#include <vector>

#include "base/errors.h"
#include "base/text_file.h"
#include "scene/json/json_tree.h"
#include "scene/json/scene_json.h"
#include "scene/scene_load.h"

namespace turner {
namespace {

const std::string kBall = R"({"materials":{"clay":{}},"spheres":[{"center":[0,0,0],"material":"clay"}]})";

Scene parse(const std::string& text) {
  return parseJsonScene("scene.json", text).scene;
}

// All faults of a text; empty when it is a scene.
std::string faultsOf(const std::function<void()>& load) {
  try {
    load();
  } catch (const InputError& error) {
    return error.what();
  }
  return {};
}
std::string faultsOf(const std::string& text) {
  return faultsOf([&] { parse(text); });
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

// A folder of its own for each test, gone afterwards.
class SceneFolder : public testing::Test {
 protected:
  SceneFolder()
      : folder_(std::filesystem::path(testing::TempDir()) /
                (std::string("turner_scene_") + testing::UnitTest::GetInstance()->current_test_info()->name())) {
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
  }
  ~SceneFolder() override {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }
  std::string write(const std::string& name, const std::string& text) const {
    const std::string path = (folder_ / name).string();
    std::ofstream(path, std::ios::binary) << text;
    return path;
  }

 private:
  std::filesystem::path folder_;
};

class MeshInScene : public SceneFolder {
 protected:
  // One triangle, placed as the keys say.
  Scene load(const std::string& placement) const {
    write("one.obj", "v 1 0 0\nv 0 2 0\nv 0 0 3\nf 1 2 3\n");
    return loadScene(
        write("mesh.json", R"({"materials":{"m":{}},"meshes":[{"file":"one.obj","material":"m")" + placement + "}]}"));
  }
};

class CameraFit : public SceneFolder {};
class SceneNotes : public SceneFolder {};
class SceneFile : public SceneFolder {};

}  // namespace

// Values.

TEST(SceneJson, emptyObjectHasTheDefaults) {
  const ParsedScene parsed = parseJsonScene("scene.json", "{}");
  EXPECT_FALSE(parsed.hasCamera);
  EXPECT_EQ(parsed.scene.background, glm::dvec3(0));
  EXPECT_EQ(parsed.scene.depth, 5);
  EXPECT_EQ(parsed.scene.width, 512);
  EXPECT_EQ(parsed.scene.height, 512);
  EXPECT_TRUE(parsed.scene.lights.empty() && parsed.scene.materials.empty() && parsed.scene.spheres.empty());
}

TEST(SceneJson, fieldsLeftOutHaveTheirDefaults) {
  const ParsedScene parsed = parseJsonScene("scene.json", R"({
    "camera": { "eye": [1, 2, 3], "target": [0, 0, 0] }, "lights": [{ "position": [4, 5, 6] }],
    "materials": { "m": {} }, "spheres": [{ "center": [7, 8, 9], "material": "m" }] })");
  EXPECT_TRUE(parsed.hasCamera);
  EXPECT_EQ(parsed.scene.camera.up, glm::dvec3(0, 1, 0));
  EXPECT_EQ(parsed.scene.camera.fov, 45);
  EXPECT_EQ(parsed.scene.lights.at(0).position, glm::dvec3(4, 5, 6));
  EXPECT_EQ(parsed.scene.lights[0].color, glm::dvec3(1));
  EXPECT_EQ(parsed.scene.lights[0].falloff, Falloff::none);
  const Material& material = parsed.scene.materials.at(0);
  EXPECT_EQ(material.name, "m");
  EXPECT_EQ(material.diffuse, glm::dvec3(0));
  EXPECT_EQ(material.specular, glm::dvec3(0));
  EXPECT_EQ(material.shininess, 1);
  EXPECT_EQ(material.reflect, 0);
  EXPECT_EQ(material.transmit, 0);
  EXPECT_EQ(material.eta, 1.5);
  EXPECT_EQ(material.localWeight, 1);
  EXPECT_EQ(parsed.scene.spheres.at(0).center, glm::dvec3(7, 8, 9));
  EXPECT_EQ(parsed.scene.spheres[0].radius, 1);
}

TEST(SceneJson, everyFieldArrivesInItsPlace) {
  const Scene scene = parse(R"({
    "$schema": "scene.schema.json", "background": [0.1, 0.2, 0.3], "depth": 7, "width": 640, "height": 480,
    "camera": { "eye": [1, 2, 3], "target": [4, 5, 6], "up": [0, 0, 1], "fov": 60 },
    "lights": [{ "position": [1, 2, 3], "color": [4, 5, 6], "falloff": "inverse-square" }],
    "spheres": [{ "center": [1, 2, 3], "radius": 4, "material": "b" }],
    "triangles": [{ "vertices": [[1, 2, 3], [4, 5, 6], [7, 8, 10]], "material": "a" },
                  { "vertices": [[0, 0, 0], [1, 0, 0], [0, 1, 0]], "material": "b",
                    "normals": [[1, 0, 0], [0, 2, 0], [0, 0, 3]] }],
    "materials": { "b": { "diffuse": [1, 2, 3], "specular": [4, 5, 6], "shininess": 7, "reflect": 0.25,
                          "transmit": 0.5, "ior": 1.25 }, "a": {} } })");
  EXPECT_EQ(scene.background, glm::dvec3(0.1, 0.2, 0.3));
  EXPECT_EQ(scene.depth, 7);
  EXPECT_EQ(scene.width, 640);
  EXPECT_EQ(scene.height, 480);
  EXPECT_EQ(scene.camera.eye, glm::dvec3(1, 2, 3));
  EXPECT_EQ(scene.camera.target, glm::dvec3(4, 5, 6));
  EXPECT_EQ(scene.camera.up, glm::dvec3(0, 0, 1));
  EXPECT_EQ(scene.camera.fov, 60);
  EXPECT_EQ(scene.lights.at(0).color, glm::dvec3(4, 5, 6));
  EXPECT_EQ(scene.lights[0].falloff, Falloff::inverseSquare);
  // Materials keep the file's order, and may stand behind what uses them.
  ASSERT_EQ(scene.materials.size(), 2u);
  EXPECT_EQ(scene.materials[0].name, "b");
  EXPECT_EQ(scene.materials[0].diffuse, glm::dvec3(1, 2, 3));
  EXPECT_EQ(scene.materials[0].specular, glm::dvec3(4, 5, 6));
  EXPECT_EQ(scene.materials[0].shininess, 7);
  EXPECT_EQ(scene.materials[0].eta, 1.25);
  EXPECT_EQ(scene.materials[0].localWeight, 0.25);
  EXPECT_EQ(scene.spheres.at(0).material, 0u);
  EXPECT_EQ(scene.spheres[0].radius, 4);
  ASSERT_EQ(scene.triangles.size(), 2u);
  EXPECT_EQ(scene.triangles[0].material, 1u);
  EXPECT_EQ(scene.cornersOf(0)[2], glm::dvec3(7, 8, 10));
  EXPECT_FALSE(scene.triangles[0].isSmooth());
  ASSERT_TRUE(scene.triangles[1].isSmooth());
  EXPECT_EQ(scene.normalsOf(1)[1], glm::dvec3(0, 2, 0));
}

TEST(SceneJson, conesArriveInTheirPlace) {
  const Scene scene = parse(R"({
    "cones": [{ "base": [1, 2, 3], "base_radius": 0.5, "apex": [4, 5, 6], "apex_radius": 0, "material": "b" },
              { "material": "a", "apex_radius": 2, "apex": [0, 1, 0], "base_radius": 2, "base": [0, 0, 0] }],
    "materials": { "b": {}, "a": {} } })");
  ASSERT_EQ(scene.cones.size(), 2u);
  EXPECT_EQ(scene.cones[0].base, glm::dvec3(1, 2, 3));
  EXPECT_EQ(scene.cones[0].baseRadius, 0.5);
  EXPECT_EQ(scene.cones[0].apex, glm::dvec3(4, 5, 6));
  EXPECT_EQ(scene.cones[0].apexRadius, 0);
  EXPECT_EQ(scene.cones[0].material, 0u);
  EXPECT_FALSE(scene.cones[0].isInward());
  EXPECT_EQ(scene.cones[1].apexRadius, 2);
  EXPECT_EQ(scene.cones[1].material, 1u);
}

TEST(SceneJson, numbersAreTheNearestDoubles) {
  const Scene scene = parse(
      R"({"background":[0.1,1e-400,0.30000000000000004],"lights":[{"position":[-2.2250738585072014e-308,5e-324,1E+3]},)"
      R"({"position":[9007199254740993,0.000000000000000000000000000000000000000000000000123e+49,-0.0]}]})");
  EXPECT_EQ(scene.background, glm::dvec3(0.1, 0.0, 0.30000000000000004));
  EXPECT_EQ(scene.lights[0].position, glm::dvec3(-2.2250738585072014e-308, 5e-324, 1000));
  EXPECT_EQ(scene.lights[1].position, glm::dvec3(9007199254740992.0, 1.23, 0));
}

TEST(SceneJson, numbersWithLongMantissasAreNotTooLarge) {
  const std::string text = R"({"background":[1)" + std::string(320, '0') + "e-320, 0e400, 2]}";
  EXPECT_EQ(parse(text).background, glm::dvec3(1, 0, 2));
}

TEST(SceneJson, wholeNumbersMayBeWrittenWithAPoint) {
  EXPECT_EQ(parse(R"({"depth":6.0,"width":1e2})").width, 100);
}

TEST(SceneJson, localWeightIsZeroWhereSharesAddUpToOne) {
  // 1 - 0.7 - 0.3 is 5.6e-17 in double precision.
  EXPECT_EQ(parse(R"({"materials":{"m":{"reflect":0.7,"transmit":0.3}}})").materials[0].localWeight, 0);
  EXPECT_EQ(parse(R"({"materials":{"m":{"reflect":0.1,"transmit":0.9}}})").materials[0].localWeight, 0);
}

TEST(SceneJson, commentsAndByteOrderMarkAreTaken) {
  EXPECT_EQ(parse("\xEF\xBB\xBF// a // b\n/* \" { */ { /**/ \"depth\" /* : */ : // 4\n 3 }// end").depth, 3);
}

TEST(SceneJson, stringsAreDecoded) {
  const Scene scene = parse(R"({"materials":{"a//\"\u00e4":{},"b":{}},)"
                            R"("spheres":[{"center":[0,0,0],"material":"a\/\/\u0022ä"}]})");
  EXPECT_EQ(scene.materials[0].name, "a//\"ä");
  EXPECT_EQ(scene.spheres[0].material, 0u);
}

// Diagnostics and their places.

TEST(SceneJsonFaults, exampleReadsAsPromised) {
  EXPECT_EQ(faultsOf("{\n \"camra\": 1,\n \"depth\": 0\n}"),
            "scene.json:2:2: error: unknown key \"camra\"; did you mean \"camera\"?\n"
            "scene.json:3:11: error: depth: found 0; must be an integer from 1 to 64");
}

TEST(SceneJsonFaults, allAreReportedInTheOrderOfTheirPlaces) {
  const std::string faults = faultsOf(R"({
  "spheres": [ { "center": [0, 0], "radius": -1, "material": "cly" } ],
  "lights": [ { "color": [1, 1, 1] } ],
  "materials": { "clay": { "reflect": 2 } },
  "camera": { "eye": [0, 0, 0], "target": [0, 0, 0] } })");
  EXPECT_EQ(faults,
            "scene.json:2:28: error: spheres[0].center: found an array of 2; must be three numbers [x, y, z], each a "
            "number from -1e30 to 1e30\n"
            "scene.json:2:46: error: spheres[0].radius: found -1; must be a number greater than 0, at most 1e30\n"
            "scene.json:2:62: error: spheres[0].material: found \"cly\"; did you mean \"clay\"?\n"
            "scene.json:3:15: error: lights[0]: key \"position\" is missing; it has no default\n"
            "scene.json:4:39: error: materials.clay.reflect: found 2; must be a number from 0 to 1\n"
            "scene.json:5:13: error: camera: eye and target are the same point; they must differ");
}

TEST(SceneJsonFaults, ofConesAreToldInTheirPlaces) {
  const auto faultOf = [](const std::string& cone) {
    return faultsOf("{\"materials\":{\"m\":{}},\n\"cones\":[" + cone + "]}");
  };
  const std::string ends = R"("base":[0,0,0],"apex":[0,1,0],"material":"m")";
  EXPECT_EQ(faultOf("{" + ends + R"(,"base_radius":1,"apex_radius":0})"), "");
  EXPECT_EQ(faultOf("{" + ends + R"(,"base_radius":1e5,"apex_radius":0})"), "");
  EXPECT_EQ(faultOf("{" + ends + R"(,"base_radius":1})"),
            "scene.json:2:10: error: cones[0]: key \"apex_radius\" is missing; it has no default");
  EXPECT_EQ(faultOf("{" + ends + R"(,"apex_radius":1})"),
            "scene.json:2:10: error: cones[0]: key \"base_radius\" is missing; it has no default");
  for (const std::string member : {"base", "apex", "material"}) {
    std::string cone = "{" + ends + R"(,"base_radius":1,"apex_radius":1})";
    cone.replace(cone.find('"' + member + '"'), member.size() + 2, "\"base_radius\"");
    EXPECT_TRUE(contains(faultOf(cone), "cones[0]: key \"" + member + "\" is missing")) << faultOf(cone);
  }
  EXPECT_EQ(faultOf("{" + ends + R"(,"base_radius":0,"apex_radius":0})"),
            "scene.json:2:10: error: cones[0]: both radii are 0; one of them must be greater");
  EXPECT_EQ(faultOf("{" + ends + R"(,"base_radius":1,"apex_radius":-1})"),
            "scene.json:2:86: error: cones[0].apex_radius: found -1; must be a number from 0 to 1e30");
  EXPECT_EQ(faultOf(R"({"base":[1,2,3],"apex":[1,2,3],"material":"m","base_radius":1,"apex_radius":1})"),
            "scene.json:2:10: error: cones[0]: base and apex are the same point; a cone needs a length");
  EXPECT_TRUE(contains(faultOf("{" + ends + R"(,"base_radius":0,"apex_radius":1.01e5})"),
                       "scene.json:2:10: error: cones[0]: the radii differ by more than 1e5 times the distance"));
  EXPECT_TRUE(contains(faultOf("{" + ends + R"(,"base_radius":1,"apex_radius":1,"radius":1})"), "unknown key"));
}

TEST(SceneJsonFaults, placesAreRightBehindCommentsAndByteOrderMarks) {
  EXPECT_EQ(faultsOf("\xEF\xBB\xBF{ /* \n, : */ \"depth\" : // 7\n  /**/ 0 }"),
            "scene.json:3:8: error: depth: found 0; must be an integer from 1 to 64");
  // Columns count bytes, and the byte order mark has three.
  EXPECT_EQ(faultsOf("\xEF\xBB\xBF{\"depth\":0}"),
            "scene.json:1:10: error: depth: found 0; must be an integer from 1 to 64");
}

TEST(SceneJsonFaults, placesAreRightBehindEscapes) {
  EXPECT_EQ(faultsOf(R"({"materials":{"\u0061\n":{"ior":"x"}}})"),
            "scene.json:1:33: error: materials.a?.ior: found \"x\"; must be a number from -1e30 to 1e30");
}

TEST(SceneJsonFaults, repeatedKeyNamesTheLineOfTheFirst) {
  EXPECT_EQ(faultsOf("{\n\"depth\": 2,\n\"width\": 3, \"depth\": 2}"),
            "scene.json:3:13: error: key \"depth\" stands twice; it first stands on line 2");
}

TEST(SceneJsonFaults, tooLargeNumberHidesNoOtherFault) {
  const std::string faults = faultsOf(R"({"background":[1e400,-1e999,-1],"depth":1e309})");
  EXPECT_EQ(faults,
            "scene.json:1:16: error: background[0]: found 1e400, which is too large; must be a number from 0 to 1e30\n"
            "scene.json:1:22: error: background[1]: found -1e999, which is too large; must be a number from 0 to 1e30\n"
            "scene.json:1:29: error: background[2]: found -1; must be a number from 0 to 1e30\n"
            "scene.json:1:41: error: depth: found 1e309; must be an integer from 1 to 64");
}

TEST(SceneJsonFaults, manyTooLargeNumbersAreRefusedToo) {
  std::string text = R"({"lights":[)";
  for (int i = 0; i < 100; ++i) text += R"({"position":[1e400,0,0]},)";
  EXPECT_TRUE(contains(faultsOf(text + "]}"), "found 1e400, which is too large"));
}

TEST(SceneJsonFaults, literalsThatAreNoNumbersAreRefusedAtTheirBeginning) {
  for (const std::string word : {"+1", ".5", "1.", "1e", "0x10", "tru", "-", "1_0"}) {
    const std::string faults = faultsOf("{\"background\": [0, " + word + ", 0]}");
    // These begin with a number, and the fault is what follows it.
    const std::string place = word == "0x10" || word == "1_0" ? "scene.json:1:21: " : "scene.json:1:20: ";
    EXPECT_TRUE(faults.starts_with(place + "error: found ")) << word << ": " << faults;
  }
}

TEST(SceneJsonFaults, wordsForWhatIsNotFiniteAreFaultsOfTheirField) {
  for (const std::string word : {"NaN", "Infinity", "-Infinity", "nan", "inf", "-inf"})
    EXPECT_EQ(faultsOf("{\"background\": [0, " + word + ", 0],\n\"depth\": " + word + "}"),
              "scene.json:1:20: error: background[1]: found " + word + "; must be a number from 0 to 1e30\n" +
                  "scene.json:2:10: error: depth: found " + word + "; must be an integer from 1 to 64");
  std::string many = R"({"lights":[)";
  for (int i = 0; i < 100; ++i) many += R"({"position":[NaN,0,0]},)";
  EXPECT_TRUE(contains(faultsOf(many + "]}"), "found NaN; expected a value: a finite number"));
}

TEST(SceneJsonFaults, wrongSyntaxIsOneFaultAtItsPlace) {
  const auto expect = [](const std::string& text, const std::string& fault) {
    EXPECT_EQ(faultsOf(text).substr(0, fault.size()), fault) << text;
  };
  expect("", "scene.json:1:1: error: the file is empty; ");
  expect(" \n // only a comment\n", "scene.json:3:1: error: the file is empty; ");
  expect("{\"depth\": 1,}", "scene.json:1:13: error: found '}'; expected a key in double quotes");
  expect("{\"lights\": [1,]}", "scene.json:1:15: error: found ']'; expected a value");
  expect("{depth: 1}", "scene.json:1:2: error: found depth; expected a key in double quotes");
  expect("{\"depth\" 1}", "scene.json:1:10: error: found 1; expected ':'");
  expect("{\"depth\": 1 \"width\": 2}", "scene.json:1:13: error: found '\"'; expected ',' or '}'");
  expect("[1 2]", "scene.json:1:4: error: found 2; expected ',' or ']'");
  expect("{} {}", "scene.json:1:4: error: found '{'; nothing may follow");
  expect("{/ }", "scene.json:1:2: error: found '/'; a comment is");
  expect("[\"a\nb\"]", "scene.json:1:4: error: found the byte 0x0a; a string may contain neither");
  expect("[\"\\q\"]", "scene.json:1:3: error: found '\\'; a string may contain neither");
  expect("[\"\\u12x4\"]", "scene.json:1:3: error: found '\\'; expected four hexadecimal digits");
  expect("[\"\\ud800x\"]", "scene.json:1:3: error: found '\\'; expected the second half");
  expect("[\"\xFF\"]", "scene.json:1:3: error: found the byte 0xff; must be UTF-8");
  expect("[]", "scene.json:1:1: error: found an array of 0; must be an object");
  expect("7", "scene.json:1:1: error: found 7; must be an object");
  expect(std::string("{\"a\0\":1}", 8), "scene.json:1:4: error: found the byte 0x00; a scene is a text file");
}

TEST(SceneJsonFaults, cutOffAnywhereIsAFaultAtTheEnd) {
  const std::string text =
      "// c\n{ /* d */ \"background\": [0.5, 1e0, -0.0], \"camera\": { \"eye\": [0, 0, 5],\n \"target\": [0, 0, 0] },"
      "\"materials\": { \"a\\u00e4\": {} }, \"lights\": [{ \"position\": [0, 1, 2], \"falloff\": \"none\" }], "
      "\"triangles\": [] }";
  ASSERT_EQ(faultsOf(text), "");
  for (size_t length = 0; length < text.size(); ++length) {
    const std::string faults = faultsOf(text.substr(0, length));
    const size_t line = 1 + static_cast<size_t>(std::count(text.begin(), text.begin() + length, '\n'));
    const size_t lineBegin = line == 1 ? 0 : text.rfind('\n', length - 1) + 1;
    const std::string place =
        "scene.json:" + std::to_string(line) + ':' + std::to_string(length - lineBegin + 1) + ": error: ";
    EXPECT_TRUE(faults.starts_with(place)) << length << ": " << faults;
    EXPECT_FALSE(contains(faults, "\n")) << faults;
  }
}

TEST(SceneJsonFaults, deepNestingIsRefusedAndNotSuffered) {
  for (const std::string bracket : {"[", "{\"a\":"}) {
    std::string text;
    for (int i = 0; i < 1000000; ++i) text += bracket;
    EXPECT_TRUE(contains(faultsOf(text), "nested too deeply")) << bracket;
  }
  EXPECT_TRUE(
      contains(faultsOf(std::string(kMaxJsonNesting, '[') + std::string(kMaxJsonNesting, ']')), "must be an object"));
}

TEST(SceneJsonFaults, longTextsFromTheFileAreCutInMessages) {
  const std::string faults = faultsOf("{\"" + std::string(100000, 'k') + "\": 1, \"depth\": \"" +
                                      std::string(100000, 'x') + "\", \"width\": " + std::string(100000, '9') + "}");
  EXPECT_TRUE(contains(faults, "unknown key")) << faults.substr(0, 300);
  EXPECT_LT(faults.size(), 1000u);
}

TEST(SceneJsonFaults, upIsTakenUnlessItIsParallelToTheView) {
  const auto camera = [](const std::string& target, const std::string& up) {
    return faultsOf("{\"camera\": {\"eye\": [0, 0, 0], \"target\": " + target + ", \"up\": " + up + "}}");
  };
  EXPECT_EQ(camera("[0, -1, 1e-3]", "[0, 1, 0]"), "");
  EXPECT_EQ(camera("[1e-20, 0, 0]", "[0, 1e20, 0]"), "");
  EXPECT_TRUE(contains(camera("[0.1, 0.2, 0.3]", "[-0.3, -0.6, -0.9]"), "parallel"));
  EXPECT_TRUE(contains(camera("[1e-40, 0, 0]", "[0, 1, 0]"), "same point"));
}

TEST(SceneJsonFaults, everyBadSceneIsRefusedForItsReason) {
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(TURNER_TESTS_DIR "/bad_scenes")) {
    if (entry.path().extension() != ".json") continue;
    ++count;
    const std::string path = entry.path().string();
    const std::string text = readTextFile(path);
    const std::string mark = "// expect: ";
    ASSERT_TRUE(text.starts_with(mark)) << path;
    const std::string expected = text.substr(mark.size(), text.find('\n') - mark.size());
    const std::string faults = faultsOf([&] { loadScene(path); });
    EXPECT_TRUE(contains(faults, expected)) << path << "\nexpected: " << expected << "\nfound: " << faults;
    EXPECT_TRUE(faults.starts_with(path + ':')) << faults;
  }
  EXPECT_GE(count, 40);
}

// Meshes.

TEST_F(MeshInScene, isScaledThenRotatedThenMoved) {
  const Scene scene = load(R"(,"scale":2,"rotate":[90,90,90],"translate":[10,20,30])");
  ASSERT_EQ(scene.triangles.size(), 1u);
  // x -> y: about x it stays, about y it goes to -z, about z it stays there. Exact, since sines of right angles are.
  EXPECT_EQ(scene.cornersOf(0)[0], glm::dvec3(10, 20, 28));
  // y -> z about x, -> x about y, -> y about z.
  EXPECT_EQ(scene.cornersOf(0)[1], glm::dvec3(10, 24, 30));
  // z -> -y about x, stays about y, -> x about z.
  EXPECT_EQ(scene.cornersOf(0)[2], glm::dvec3(16, 20, 30));
}

TEST_F(MeshInScene, turnsByRightAnglesAreExact) {
  for (const int turns : {-7, -4, -1, 0, 1, 2, 3, 4, 1000001}) {
    const glm::dvec3 x = load(",\"rotate\":[0,0," + std::to_string(90LL * turns) + "]").cornersOf(0)[0];
    const glm::dvec3 expected[4] = {{1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}};
    EXPECT_EQ(x, expected[((turns % 4) + 4) % 4]) << turns;
  }
  const glm::dvec3 x = load(",\"rotate\":[0,0,60]").cornersOf(0)[0];
  EXPECT_NEAR(x.x, 0.5, 1e-15);
  EXPECT_NEAR(x.y, std::sqrt(0.75), 1e-15);
}

TEST_F(MeshInScene, normalsAreDirectionsThatAreRotatedOnly) {
  write("smooth.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nvn 1e-300 0 0\nf 1//1 2//1 3//2\n");
  const Scene scene =
      loadScene(write("smooth.json", R"({"materials":{"m":{}},"meshes":[{"file":"smooth.obj","material":"m","scale":3,)"
                                     R"("rotate":[0,90,0],"translate":[5,5,5]}]})"));
  ASSERT_TRUE(scene.triangles.at(0).isSmooth());
  EXPECT_EQ(scene.normalsOf(0)[0], glm::dvec3(1, 0, 0));
  EXPECT_EQ(scene.normalsOf(0)[2], glm::dvec3(0, 0, -1));
}

// A smooth square of four vertices, placed twice: each placement has four positions and two normals, which its two
// triangles share.
TEST_F(MeshInScene, sharesItsVerticesAmongItsTriangles) {
  write("square.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvn 0 0 1\nvn 0 1 0\nf 1//1 2//1 3//2\nf 1//1 3//2 4//2\n");
  const Scene scene = loadScene(
      write("squares.json", R"({"materials":{"m":{}},"meshes":[{"file":"square.obj","material":"m","scale":2},)"
                            R"({"file":"./square.obj","material":"m","rotate":[90,0,0],"translate":[0,0,5]}]})"));
  ASSERT_EQ(scene.triangles.size(), 4u);
  EXPECT_EQ(scene.positions.size(), 8u);
  EXPECT_EQ(scene.normals.size(), 4u);
  EXPECT_EQ(scene.triangles[1].positions, (std::array<uint32_t, 3>{0, 2, 3}));
  EXPECT_EQ(scene.triangles[3].positions, (std::array<uint32_t, 3>{4, 6, 7}));
  EXPECT_EQ(scene.triangles[3].normals, (std::array<uint32_t, 3>{2, 3, 3}));
  EXPECT_EQ(scene.cornersOf(1), (TriangleCorners{glm::dvec3(0), glm::dvec3(2, 2, 0), glm::dvec3(0, 2, 0)}));
  EXPECT_EQ(scene.cornersOf(3), (TriangleCorners{glm::dvec3(0, 0, 5), glm::dvec3(1, 0, 6), glm::dvec3(0, 0, 6)}));
  EXPECT_EQ(scene.normalsOf(3), (TriangleCorners{glm::dvec3(0, -1, 0), glm::dvec3(0, 0, 1), glm::dvec3(0, 0, 1)}));
}

TEST_F(MeshInScene, comesBehindTheTrianglesAndIsReadOnce) {
  write("one.obj", "v 1 0 0\nv 0 2 0\nv 0 0 3\nf 1 2 3\n");
  const std::string path = write(
      "twice.json", R"({"meshes":[{"file":"one.obj","material":"m"},{"file":"./one.obj","material":"m","scale":2}],)"
                    R"("triangles":[{"vertices":[[0,0,0],[9,0,0],[0,9,0]],"material":"m"}],"materials":{"m":{}}})");
  const Scene scene = loadScene(path);
  ASSERT_EQ(scene.triangles.size(), 3u);
  EXPECT_EQ(scene.cornersOf(0)[1].x, 9);
  EXPECT_EQ(scene.cornersOf(1)[0].x, 1);
  EXPECT_EQ(scene.cornersOf(2)[0].x, 2);
  ASSERT_EQ(scene.sources.size(), 2u);
  EXPECT_EQ(scene.sources[0].path, "twice.json");
  EXPECT_EQ(scene.sources[0].sha256, sha256Hex(readTextFile(path)));
  EXPECT_EQ(scene.sources[1].path, "one.obj");
}

TEST_F(MeshInScene, faultsInItJoinThoseOfTheScene) {
  const std::string mesh = write("bad.obj", "v 1 0 0\nf 1 2 3\n");
  const std::string scene = write("scene.json", R"({"depth":0,"meshes":[{"file":"bad.obj","material":"m"},)"
                                                R"({"file":"bad.obj","material":"m"}]})");
  const std::string faults = faultsOf([&] { loadScene(scene); });
  EXPECT_TRUE(contains(faults, scene + ":1:10: error: depth")) << faults;
  EXPECT_TRUE(contains(faults, "meshes[1].material: found \"m\"; the scene has no materials")) << faults;
  const size_t first = faults.find("\n" + mesh + ":2:");
  ASSERT_NE(first, std::string::npos) << faults;
  EXPECT_EQ(faults.find("\n" + mesh + ":2:3: ", first + 1), std::string::npos) << "told once: " << faults;
}

TEST_F(MeshInScene, missingFileIsAFaultWhereItIsNamed) {
  const std::string scene =
      write("scene.json", "{\"materials\":{\"m\":{}},\n\"meshes\":[{\"file\":\"no.obj\",\"material\":\"m\"}]}");
  EXPECT_EQ(faultsOf([&] { loadScene(scene); }),
            scene + ":2:19: error: meshes[0].file: found \"no.obj\"; cannot open: No such file or directory");
}

TEST_F(MeshInScene, beyondTheRangeIsRefused) {
  EXPECT_TRUE(contains(faultsOf([&] { load(R"(,"scale":1e30)"); }), "meshes[0]: the mesh, scaled and moved, reaches"));
}

TEST_F(MeshInScene, verticesOfNoFaceMayLieAnywhere) {
  write("far.obj", "v 1e30 0 0\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 2 3 4\n");
  const Scene scene =
      loadScene(write("far.json", R"({"materials":{"m":{}},"meshes":[{"file":"far.obj","material":"m","scale":2}]})"));
  EXPECT_EQ(scene.cornersOf(0)[1], glm::dvec3(2, 0, 0));
}

TEST_F(MeshInScene, notesAreToldOnceForEachFile) {
  const std::string mesh = write("odd.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nvw 1\nf 1 2 3\n");
  const Scene scene =
      loadScene(write("twice.json", R"({"materials":{"m":{}},"meshes":[{"file":"odd.obj","material":"m"},)"
                                    R"({"file":"odd.obj","material":"m"}],"lights":[{"position":[0,9,0]}],)"
                                    R"("camera":{"eye":[0,0,9],"target":[0,0,0]}})"));
  EXPECT_EQ(scene.triangles.size(), 2u);
  EXPECT_EQ(scene.notes, std::vector<std::string>{mesh + ":4:1: note: 1 unknown statement was passed over: 'vw', " +
                                                  "did you mean 'v'?"});
}

// Files.

TEST_F(SceneFile, extensionChoosesTheParser) {
  EXPECT_EQ(loadScene(write("a.JSON", kBall)).spheres.size(), 1u);
  EXPECT_EQ(loadScene(write("some.scene.json", kBall)).name, "some.scene");
  EXPECT_TRUE(contains(faultsOf([&] { loadScene(write("a.xml", kBall)); }), "a scene is a .json or an .nff file"));
  EXPECT_TRUE(contains(faultsOf([&] { loadScene(write("a", kBall)); }), "no extension; a scene is"));
}

TEST_F(SceneFile, missingOneIsToldOf) {
  EXPECT_TRUE(contains(faultsOf([] { loadScene("no/such/scene.json"); }), "no/such/scene.json: error: cannot open"));
}

TEST_F(SceneNotes, sayWhatIsMissing) {
  const std::string path = write("empty.json", "{}");
  const Scene scene = loadScene(path);
  EXPECT_EQ(scene.notes,
            (std::vector<std::string>{path + ": note: the scene has no lights: its objects are black",
                                      path + ": note: the scene has no objects: the picture is its background",
                                      path + ": note: the scene has no camera: one was fitted to its bounds"}));
  EXPECT_NE(scene.camera.eye, scene.camera.target);
}

TEST_F(SceneNotes, countTrianglesWithoutArea) {
  const auto triangle = [](const std::string& vertices) {
    return "{\"material\":\"m\",\"vertices\":" + vertices + "}";
  };
  const std::string tiny = "[[0,0,0],[1e-200,0,0],[0,1e-200,0]]";
  const Scene scene = loadScene(
      write("flat.json", R"({"materials":{"m":{}},"triangles":[)" + triangle("[[1,1,1],[1,1,1],[2,3,4]]") + "," +
                             triangle("[[7,0,0],[8,0,0],[7,1,0]]") + "," + triangle("[[1,1,1],[2,2,2],[5,5,5]]") + "," +
                             triangle("[[1,0,0],[2,0,0],[1,0,0]]") + "," + triangle("[[0,0,0],[2,1,0],[2,1,0]]") + "," +
                             triangle(tiny) + R"(],"lights":[{"position":[0,9,0]}],)" +
                             R"("camera":{"eye":[0,0,9],"target":[0,0,0]}})"));
  ASSERT_EQ(scene.triangles.size(), 2u);
  EXPECT_EQ(scene.cornersOf(0)[0].x, 7);
  EXPECT_EQ(scene.cornersOf(1)[1].x, 1e-200);
  ASSERT_EQ(scene.notes.size(), 1u);
  EXPECT_TRUE(contains(scene.notes[0], "flat.json: note: 4 triangles without area were dropped"));
}

TEST_F(CameraFit, seesTheWholeScene) {
  for (const std::string size : {"", R"("width":900,"height":300,)", R"("width":300,"height":900,)"}) {
    const Scene scene = loadScene(
        write("fit.json", "{" + size + R"("materials":{"m":{}},"spheres":[{"center":[100,2,3],"material":"m"},)" +
                              R"({"center":[103,2,3],"radius":0.5,"material":"m"}]})"));
    const Camera& camera = scene.camera;
    const glm::dvec3 view = glm::normalize(camera.target - camera.eye);
    EXPECT_LT(view.z, -0.9 * std::abs(view.x));  // from the front
    const double tangent = std::tan(camera.fov * std::acos(-1.0) / 360);
    const double narrower = std::atan(tangent * std::min(1.0, double(scene.width) / scene.height));
    for (const Sphere& sphere : scene.spheres) {
      const glm::dvec3 toCenter = sphere.center - camera.eye;
      const double distance = glm::length(toCenter);
      const double angle = std::acos(glm::dot(toCenter, view) / distance) + std::asin(sphere.radius / distance);
      EXPECT_LT(angle, narrower) << size;
    }
  }
}

// The folder of scenes.

TEST(OwnScenes, areAllWithoutFaultsAndWithoutNotes) {
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(TURNER_SCENES_DIR)) {
    const std::string path = entry.path().string();
    if (!path.ends_with(".json") || path.ends_with(".schema.json")) continue;
    ++count;
    EXPECT_TRUE(readTextFile(path).starts_with("// ")) << path << " has no first line that says its idea";
    Scene scene;
    EXPECT_EQ(faultsOf([&] { scene = loadScene(path); }), "");
    EXPECT_TRUE(scene.notes.empty()) << path << ": " << scene.notes.front();
    EXPECT_FALSE(scene.lights.empty()) << path;
  }
  EXPECT_GE(count, 10);
}

TEST(OwnScenes, deepGlassTouchesAndDoesNotOverlap) {
  const Scene scene = loadScene(TURNER_SCENES_DIR "/deep_glass.json");
  ASSERT_EQ(scene.spheres.size(), 20u);
  EXPECT_EQ(scene.lights.size(), 3u);
  EXPECT_EQ(scene.depth, 16);
  for (size_t i = 0; i < scene.spheres.size(); ++i) {
    double nearest = INFINITY;
    for (size_t j = 0; j < scene.spheres.size(); ++j) {
      if (i == j) continue;
      const double gap = glm::distance(scene.spheres[i].center, scene.spheres[j].center) - scene.spheres[i].radius -
                         scene.spheres[j].radius;
      EXPECT_GT(gap, -1e-15) << i << ' ' << j;
      nearest = std::min(nearest, gap);
    }
    EXPECT_LT(nearest, 1e-15) << i;
  }
}

}  // namespace turner
