// Textures on other meshes: another tessellation of the garment, or a user's own mesh with UVs in
// our layout. The texture, the template and the skin weights are all functions on the layout.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "body/skinning.h"
#include "core/mesh.h"
#include "encode/texture.h"
#include "encode/unpose.h"

namespace pleat::encode {

// The sewn mesh with its UVs; positions are left zero.
TriangleMesh layout_mesh(const garment::GarmentTopology& topology);

class MeshDecoder {
 public:
  // mesh: its positions do not count, but it needs UVs (InputError), all on panels of the layout.
  // topology: of the garments that are decoded.
  MeshDecoder(const garment::GarmentTopology& topology, int texture_size,
              const std::vector<uint8_t>& mask, const TriangleMesh& mesh);

  int vertex_count() const { return vertex_count_; }
  // Values of the topology's sewn vertices at the mesh's: linear on each face; # x columns.
  Eigen::MatrixXd at_vertices(const Eigen::Ref<const Eigen::MatrixXd>& values) const;
  Points3 offsets(const Texture& texture) const;  // from the template, T-pose, m
  // Template and skin weights of a garment at the mesh's vertices, for pose(): no topology, no
  // panels.
  garment::Garment worn(const garment::Garment& garment) const;

 private:
  // Of values at the UVs, the mean at each vertex: seams agree from both sides.
  Eigen::MatrixXd joined(const Eigen::Ref<const Eigen::MatrixXd>& at_uvs) const;

  int vertex_count_ = 0;
  std::vector<std::array<int, 2>> corners_;  // vertex and UV of it, each pair once
  Eigen::VectorXd corner_count_;             // of each vertex
  TexelReads reads_;                         // at the UVs
  Faces places_;                             // sewn vertices around each UV,
  Points3 weights_;                          // and their shares
};

}  // namespace pleat::encode
