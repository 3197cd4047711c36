#include "core/mesh_file.h"

#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <array>
#include <assimp/Importer.hpp>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>
#include <vector>

#include "core/atomic_file.h"
#include "core/error.h"

namespace pleat {
namespace {

// Gives equal keys one index, in the order of first appearance.
template <size_t N>
class Merger {
 public:
  int index(const std::array<double, N>& key) {
    const auto [place, is_new] = indices_.emplace(key, static_cast<int>(keys_.size()));
    if (is_new) keys_.push_back(key);
    return place->second;
  }
  const std::vector<std::array<double, N>>& keys() const { return keys_; }

 private:
  std::map<std::array<double, N>, int> indices_;
  std::vector<std::array<double, N>> keys_;
};

template <typename Rows>
Rows to_rows(const std::vector<std::array<int, 3>>& list) {
  Rows rows(list.size(), 3);
  for (size_t f = 0; f < list.size(); ++f) rows.row(f) << list[f][0], list[f][1], list[f][2];
  return rows;
}

}  // namespace

TriangleMesh read_mesh(const std::string& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) throw InputError(path + ": no such file");
  Assimp::Importer importer;
  importer.SetPropertyInteger(AI_CONFIG_PP_SBP_REMOVE,
                              aiPrimitiveType_POINT | aiPrimitiveType_LINE);
  const aiScene* scene = importer.ReadFile(
      path, aiProcess_Triangulate | aiProcess_SortByPType | aiProcess_PreTransformVertices);
  if (scene == nullptr) {
    throw InputError(path + ": cannot be read as a mesh: " + importer.GetErrorString());
  }

  Merger<3> positions;
  Merger<2> uvs;
  std::vector<std::array<int, 3>> faces, uv_faces;
  bool has_uv = true;
  for (unsigned m = 0; m < scene->mNumMeshes; ++m) {
    const aiMesh& part = *scene->mMeshes[m];
    const aiVector3D* part_uv = part.mTextureCoords[0];
    has_uv &= part_uv != nullptr;
    for (unsigned f = 0; f < part.mNumFaces; ++f) {
      if (part.mFaces[f].mNumIndices != 3) continue;
      std::array<int, 3> face, uv_face{};
      for (int k = 0; k < 3; ++k) {
        const unsigned corner = part.mFaces[f].mIndices[k];
        const aiVector3D& p = part.mVertices[corner];
        if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z)) {
          throw InputError(path + ": face " + std::to_string(faces.size()) +
                           " has a vertex that is not a finite number");
        }
        face[k] = positions.index({p.x, p.y, p.z});
        if (part_uv == nullptr) continue;
        const aiVector3D& uv = part_uv[corner];
        if (!std::isfinite(uv.x) || !std::isfinite(uv.y)) {
          throw InputError(path + ": face " + std::to_string(faces.size()) +
                           " has a UV that is not a finite number");
        }
        uv_face[k] = uvs.index({uv.x, uv.y});
      }
      if (face[0] == face[1] || face[1] == face[2] || face[2] == face[0]) continue;  // merged away
      faces.push_back(face);
      uv_faces.push_back(uv_face);
    }
  }
  if (faces.empty()) throw InputError(path + ": holds no triangles");

  TriangleMesh mesh;
  mesh.faces = to_rows<Faces>(faces);
  mesh.vertices.resize(positions.keys().size(), 3);
  for (int v = 0; v < mesh.vertices.rows(); ++v) {
    mesh.vertices.row(v) << positions.keys()[v][0], positions.keys()[v][1], positions.keys()[v][2];
  }
  if (has_uv) {
    mesh.uv_faces = to_rows<Faces>(uv_faces);
    mesh.uv.resize(uvs.keys().size(), 2);
    for (int t = 0; t < mesh.uv.rows(); ++t) {
      mesh.uv.row(t) << uvs.keys()[t][0], uvs.keys()[t][1];
    }
  }
  return mesh;
}

void write_obj(const std::string& path, const TriangleMesh& mesh) {
  std::string text;
  char line[128];
  for (int v = 0; v < mesh.vertices.rows(); ++v) {
    std::snprintf(line, sizeof line, "v %.9g %.9g %.9g\n", mesh.vertices(v, 0), mesh.vertices(v, 1),
                  mesh.vertices(v, 2));
    text += line;
  }
  for (int t = 0; t < mesh.uv.rows(); ++t) {
    std::snprintf(line, sizeof line, "vt %.9g %.9g\n", mesh.uv(t, 0), mesh.uv(t, 1));
    text += line;
  }
  const bool has_uv = mesh.uv_faces.rows() > 0;
  for (int f = 0; f < mesh.faces.rows(); ++f) {
    text += "f";
    for (int k = 0; k < 3; ++k) {
      text += " " + std::to_string(mesh.faces(f, k) + 1);  // OBJ counts from 1
      if (has_uv) text += "/" + std::to_string(mesh.uv_faces(f, k) + 1);
    }
    text += "\n";
  }
  write_file_atomically(path, text);
}

}  // namespace pleat
