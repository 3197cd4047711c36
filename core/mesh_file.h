#pragma once

#include <string>

#include "core/mesh.h"

namespace pleat {

// Any triangle or polygon mesh that assimp reads (OBJ, PLY, GLTF ...); polygons are triangulated,
// vertices that differ only in UV or normal are one vertex. Throws InputError naming the file.
TriangleMesh read_mesh(const std::string& path);

// Wavefront OBJ with UVs where the mesh has them. Written whole or not at all.
void write_obj(const std::string& path, const TriangleMesh& mesh);

}  // namespace pleat
