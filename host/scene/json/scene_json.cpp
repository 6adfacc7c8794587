// Binds the tree of a JSON file to a Scene, field by field, collecting every fault.
#include "scene/json/scene_json.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <glm/geometric.hpp>
#include <optional>
#include <unordered_map>
#include <utility>

#include "base/diagnostics.h"
#include "base/errors.h"
#include "base/text_file.h"
#include "scene/json/json_camera.h"
#include "scene/json/json_fields.h"
#include "scene/json/json_tree.h"
#include "scene/json/mesh_files.h"
#include "scene/json/place_mesh.h"
#include "scene/json/settings_json.h"
#include "scene/plain_text.h"

namespace turner {

namespace {

constexpr NumberRule kNotNegative{[](double x) { return x >= 0 && x <= kLargestNumber; }, "a number from 0 to 1e30"};
constexpr NumberRule kPositive{[](double x) { return x > 0 && x <= kLargestNumber; },
                               "a number greater than 0, at most 1e30"};
constexpr NumberRule kShare{[](double x) { return x >= 0 && x <= 1; }, "a number from 0 to 1"};

// Takes the scene out of a tree, section by section; faults are noted and reading goes on.
class SceneReader {
 public:
  // `bytes` are those of the file, `text` is what was read of them.
  SceneReader(const std::string& path, std::string_view bytes, std::string_view text, const JsonTree& tree,
              Diagnostics& faults)
      : fields_(tree, text, faults), meshFiles_(std::filesystem::path(path).parent_path(), fields_) {
    // The file's name alone: what is written about a scene does not depend on the folder it lies in.
    parsed_.scene.sources.push_back({std::filesystem::path(path).filename().string(), sha256Hex(bytes)});
  }

  void read();
  // The faults of the meshes, each line with its place in the mesh's file.
  const std::string& meshFaults() const { return meshFiles_.faults(); }
  ParsedScene take() { return std::move(parsed_); }

 private:
  void readLight(size_t at, const Field& field);
  void readFalloff(size_t at, const Field& field, Falloff& falloff);
  void readMaterial(std::string_view name, size_t at, const Field& field);
  void readSphere(size_t at, const Field& field);
  void readCone(size_t at, const Field& field);
  void readTriangle(size_t at, const Field& field);
  std::optional<TriangleCorners> readNormals(size_t at, const Field& field);
  void readMesh(size_t at, const Field& field);
  void readMaterialName(size_t at, const Field& field, uint32_t& material);
  void countPlacements(size_t meshes);

  JsonFields fields_;
  ParsedScene parsed_;
  Scene& scene_ = parsed_.scene;
  std::vector<std::string> materialNames_;
  std::unordered_map<std::string_view, uint32_t> materials_;
  MeshFiles meshFiles_;
};

void SceneReader::read() {
  const Field root;
  // The sections may come in any order, but materials are known before what refers to them.
  size_t materials = 0, spheres = 0, cones = 0, triangles = 0, meshes = 0;  // 0 is the root: not there
  const auto keep = [](size_t& place) { return [&place](size_t at, const Field&) { place = at; }; };
  fields_.readObject(
      0, root,
      {{"$schema", false,
        [&](size_t at, const Field& field) {
          std::string ignored;
          fields_.readString(at, field, "the address of the schema", ignored);
        }},
       {"background", false,
        [&](size_t at, const Field& field) { fields_.readVector(at, field, kNotNegative, scene_.background); }},
       {"depth", false,
        [&](size_t at, const Field& field) { fields_.readInteger(at, field, 1, kMaxDepth, scene_.depth); }},
       {"width", false,
        [&](size_t at, const Field& field) { fields_.readInteger(at, field, 1, kMaxSize, scene_.width); }},
       {"height", false,
        [&](size_t at, const Field& field) { fields_.readInteger(at, field, 1, kMaxSize, scene_.height); }},
       {"camera", false,
        [&](size_t at, const Field& field) {
          parsed_.hasCamera = true;
          readCamera(fields_, at, field, scene_.camera);
        }},
       {"lights", false,
        [&](size_t at, const Field& field) {
          fields_.readArray(at, field, [&](size_t light, const Field& name) { readLight(light, name); });
        }},
       {"params", false, [&](size_t at, const Field& field) { readSettings(fields_, at, field, scene_.parameters); }},
       {"materials", false, keep(materials)},
       {"spheres", false, keep(spheres)},
       {"cones", false, keep(cones)},
       {"triangles", false, keep(triangles)},
       {"meshes", false, keep(meshes)}});

  if (materials) {
    fields_.readMembers(materials, {&root, "materials"},
                        [&](std::string_view name, size_t at, const Field& field) { readMaterial(name, at, field); });
  }
  if (spheres) {
    fields_.readArray(spheres, {&root, "spheres"}, [&](size_t at, const Field& field) { readSphere(at, field); });
  }
  if (cones) {
    fields_.readArray(cones, {&root, "cones"}, [&](size_t at, const Field& field) { readCone(at, field); });
  }
  if (triangles) {
    fields_.readArray(triangles, {&root, "triangles"}, [&](size_t at, const Field& field) { readTriangle(at, field); });
  }
  if (meshes) {
    countPlacements(meshes);
    fields_.readArray(meshes, {&root, "meshes"}, [&](size_t at, const Field& field) { readMesh(at, field); });
  }
}

void SceneReader::readFalloff(size_t at, const Field& field, Falloff& falloff) {
  static const std::vector<std::string> kNames = {"none", "inverse-square"};
  std::string name;
  if (!fields_.readString(at, field, "\"none\" or \"inverse-square\"", name)) return;
  if (name == kNames[0]) {
    falloff = Falloff::none;
  } else if (name == kNames[1]) {
    falloff = Falloff::inverseSquare;
  } else {
    fields_.addMessage(at, field, "found " + quote(name) + suggestName(name, kNames, "allowed are"));
  }
}

void SceneReader::readLight(size_t at, const Field& field) {
  Light light;
  fields_.readObject(
      at, field,
      {{"position", true,
        [&](size_t place, const Field& name) { fields_.readVector(place, name, kAnyNumber, light.position); }},
       {"color", false,
        [&](size_t place, const Field& name) { fields_.readVector(place, name, kNotNegative, light.color); }},
       {"falloff", false, [&](size_t place, const Field& name) { readFalloff(place, name, light.falloff); }}});
  scene_.lights.push_back(light);
}

void SceneReader::readMaterial(std::string_view name, size_t at, const Field& field) {
  Material material;
  material.name = name;
  bool hasShares = true;
  size_t eta = 0;
  const auto vectorInto = [&](glm::dvec3& vector) {
    return [&](size_t place, const Field& key) { fields_.readVector(place, key, kNotNegative, vector); };
  };
  const auto shareInto = [&](double& share) {
    return [&](size_t place, const Field& key) { hasShares &= fields_.readNumber(place, key, kShare, share); };
  };
  fields_.readObject(
      at, field,
      {{"diffuse", false, vectorInto(material.diffuse)},
       {"specular", false, vectorInto(material.specular)},
       {"shininess", false,
        [&](size_t place, const Field& key) { fields_.readNumber(place, key, kNotNegative, material.shininess); }},
       {"reflect", false, shareInto(material.reflect)},
       {"transmit", false, shareInto(material.transmit)},
       {"ior", false, [&](size_t place, const Field& key) {
          if (fields_.readNumber(place, key, kAnyNumber, material.eta)) eta = place;
        }}});

  // Exact on decimals too: where r + t is meant to be 1 the sum rounds to 1, while 1 - r - t may leave a remainder.
  const double sum = material.reflect + material.transmit;
  if (hasShares && sum > 1) {
    fields_.addMessage(at, field, "reflect and transmit together are more than 1; at most all light can be passed on");
  }
  material.localWeight = std::max(0.0, 1 - sum);
  if (eta && material.transmit > 0 && material.eta <= 0) {
    fields_.addFault(eta, Field{&field, "ior"}, "a number greater than 0 where the material transmits");
  }

  materials_.emplace(name, static_cast<uint32_t>(scene_.materials.size()));
  materialNames_.emplace_back(name);
  scene_.materials.push_back(std::move(material));
}

void SceneReader::readMaterialName(size_t at, const Field& field, uint32_t& material) {
  std::string name;
  if (!fields_.readString(at, field, "the name of a material", name)) return;
  if (const auto known = materials_.find(name); known != materials_.end()) {
    material = known->second;
  } else {
    fields_.addMessage(at, field,
                       "found " + quote(name) +
                           (materialNames_.empty() ? std::string("; the scene has no materials")
                                                   : suggestName(name, materialNames_, "the materials are")));
  }
}

void SceneReader::readSphere(size_t at, const Field& field) {
  Sphere sphere;
  fields_.readObject(
      at, field,
      {{"center", true,
        [&](size_t place, const Field& name) { fields_.readVector(place, name, kAnyNumber, sphere.center); }},
       {"radius", false,
        [&](size_t place, const Field& name) { fields_.readNumber(place, name, kPositive, sphere.radius); }},
       {"material", true, [&](size_t place, const Field& name) { readMaterialName(place, name, sphere.material); }}});
  scene_.spheres.push_back(sphere);
}

void SceneReader::readCone(size_t at, const Field& field) {
  Cone cone;
  bool areGood = true;
  const auto endInto = [&](glm::dvec3& end) {
    return [&](size_t place, const Field& name) { areGood &= fields_.readVector(place, name, kAnyNumber, end); };
  };
  const auto radiusInto = [&](double& radius) {
    return [&](size_t place, const Field& name) { areGood &= fields_.readNumber(place, name, kNotNegative, radius); };
  };
  areGood &= fields_.readObject(
      at, field,
      {{"base", true, endInto(cone.base)},
       {"base_radius", true, radiusInto(cone.baseRadius)},
       {"apex", true, endInto(cone.apex)},
       {"apex_radius", true, radiusInto(cone.apexRadius)},
       {"material", true, [&](size_t place, const Field& name) { readMaterialName(place, name, cone.material); }}});
  if (!areGood) return;
  if (cone.base == cone.apex)
    fields_.addMessage(at, field, "base and apex are the same point; a cone needs a length");
  else if (cone.baseRadius == 0 && cone.apexRadius == 0)
    fields_.addMessage(at, field, "both radii are 0; one of them must be greater");
  else if (isTooFlat(cone))
    fields_.addMessage(at, field,
                       "the radii differ by more than 1e5 times the distance of base and apex; triangles make a disc");
  scene_.cones.push_back(cone);
}

void SceneReader::readTriangle(size_t at, const Field& field) {
  TriangleCorners corners{};
  std::optional<TriangleCorners> normals;
  uint32_t material = 0;
  fields_.readObject(
      at, field,
      {{"vertices", true,
        [&](size_t place, const Field& name) { fields_.readVectors(place, name, kAnyNumber, corners); }},
       {"normals", false, [&](size_t place, const Field& name) { normals = readNormals(place, name); }},
       {"material", true, [&](size_t place, const Field& name) { readMaterialName(place, name, material); }}});
  if (normals)
    scene_.addTriangle(corners, *normals, material);
  else
    scene_.addTriangle(corners, material);
}

std::optional<TriangleCorners> SceneReader::readNormals(size_t at, const Field& field) {
  TriangleCorners normals{};
  if (!fields_.readVectors(at, field, kAnyNumber, normals)) return {};
  // The squares of float32 numbers outside of this are 0 or infinite.
  constexpr double kShortest = 1e-15, kLongest = 1e15;
  bool isGood = true;
  fields_.readArray(at, field, [&](size_t place, const Field& name) {
    const double length = glm::length(normals[name.index]);
    if (length >= kShortest && length <= kLongest) return;
    fields_.addMessage(place, name,
                       "found a normal of length " + std::string(length == 0 ? "0" : "out of range") +
                           "; its length must be from 1e-15 to 1e15");
    isGood = false;
  });
  return isGood ? std::optional(normals) : std::nullopt;
}

// How often each file is placed: its mesh is freed behind the last time.
void SceneReader::countPlacements(size_t meshes) {
  if (fields_.node(meshes).kind != JsonKind::array) return;
  for (size_t mesh = meshes + 1; mesh < fields_.node(meshes).next; mesh = fields_.node(mesh).next) {
    if (fields_.node(mesh).kind != JsonKind::object) continue;
    for (size_t key = mesh + 1; key < fields_.node(mesh).next; key = fields_.node(key + 1).next)
      if (fields_.node(key).text == "file") meshFiles_.expect(std::string(fields_.node(key + 1).text));
  }
}

void SceneReader::readMesh(size_t at, const Field& field) {
  MeshFiles::File* file = nullptr;
  uint32_t material = 0;
  Placement placement;
  const auto vectorInto = [&](glm::dvec3& vector) {
    return [&](size_t place, const Field& name) { fields_.readVector(place, name, kAnyNumber, vector); };
  };
  fields_.readObject(
      at, field,
      {{"file", true,
        [&](size_t place, const Field& name) {
          std::string path;
          if (fields_.readString(place, name, "the path of an .obj file", path))
            file = meshFiles_.open(place, name, path, scene_);
        }},
       {"material", true, [&](size_t place, const Field& name) { readMaterialName(place, name, material); }},
       {"scale", false,
        [&](size_t place, const Field& name) { fields_.readNumber(place, name, kPositive, placement.scale); }},
       {"rotate", false, vectorInto(placement.degrees)},
       {"translate", false, vectorInto(placement.translation)}});
  if (!file) return;
  if (file->mesh && !placeMesh(*file->mesh, material, placement, kLargestNumber, scene_)) {
    fields_.addMessage(at, field, "the mesh, scaled and moved, reaches beyond 1e30; its vertices must stay within");
  }
  file->placed();
}

}  // namespace

ParsedScene parseJsonScene(const std::string& path, std::string_view bytes) {
  const PlainText plain(path, bytes);
  const std::string_view text = plain.view();
  Diagnostics faults(path, text);
  const JsonTree tree = parseJson(text, faults);
  faults.throwIfAny();

  SceneReader reader(path, bytes, text, tree, faults);
  reader.read();
  if (reader.meshFaults().empty()) {
    faults.throwIfAny();
    return reader.take();
  }
  // The scene's own faults first, then those of its meshes: the user is to see all of them.
  try {
    faults.throwIfAny();
  } catch (const InputError& error) {
    throw InputError(error.what() + ('\n' + reader.meshFaults()));
  }
  throw InputError(reader.meshFaults());
}

}  // namespace turner
