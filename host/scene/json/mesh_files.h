// The mesh files of a JSON scene: each is read once, and freed behind its last placement.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "scene/json/json_fields.h"
#include "scene/obj/mesh_obj.h"
#include "scene/scene.h"

namespace turner {

class MeshFiles {
 public:
  // `folder`: that the scene lies in. Faults of a name are added to `fields`.
  MeshFiles(std::filesystem::path folder, JsonFields& fields) : folder_(std::move(folder)), fields_(fields) {}

  struct File {
    size_t placements = 0;  // that are still to come
    bool isRead = false;
    std::optional<Mesh> mesh;  // none before it is read, behind the last placement, and where the file has faults

    void placed() {
      if (--placements == 0) mesh.reset();
    }
  };

  // Once for each placement, before the first is read.
  void expect(const std::string& file) { ++files_[pathOf(file)].placements; }

  // The file that the scene names here; its source and its notes are appended to the scene's when it is read. nullptr
  // if it is no .obj file.
  File* open(size_t at, const Field& field, const std::string& file, Scene& scene);

  // The faults in the files, each line with its place in the mesh's file.
  const std::string& faults() const { return faults_; }

 private:
  std::string pathOf(const std::string& file) const { return (folder_ / file).lexically_normal().string(); }

  std::filesystem::path folder_;
  JsonFields& fields_;
  std::map<std::string, File> files_;  // by path
  std::string faults_;
};

}  // namespace turner
