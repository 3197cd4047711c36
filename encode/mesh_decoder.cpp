#include "encode/mesh_decoder.h"

#include <algorithm>
#include <array>

#include "core/error.h"
#include "garment/resample.h"

namespace pleat::encode {

TriangleMesh layout_mesh(const garment::GarmentTopology& topology) {
  return {Points3::Zero(topology.vertex_count, 3), topology.faces, topology.uv,
          topology.panel_faces};
}

MeshDecoder::MeshDecoder(const garment::GarmentTopology& topology, int texture_size,
                         const std::vector<uint8_t>& mask, const TriangleMesh& mesh)
    : vertex_count_(static_cast<int>(mesh.vertices.rows())) {
  if (mesh.uv.rows() == 0) throw InputError("the mesh has no UVs; a texture needs them");
  for (Eigen::Index f = 0; f < mesh.faces.rows(); ++f)
    for (int c = 0; c < 3; ++c) corners_.push_back({mesh.faces(f, c), mesh.uv_faces(f, c)});
  std::sort(corners_.begin(), corners_.end());
  corners_.erase(std::unique(corners_.begin(), corners_.end()), corners_.end());
  corner_count_ = Eigen::VectorXd::Zero(vertex_count_);
  for (const auto& [vertex, uv] : corners_) corner_count_[vertex] += 1;
  for (int v = 0; v < vertex_count_; ++v)
    if (corner_count_[v] == 0)
      throw InputError("the mesh's vertex " + std::to_string(v) + " is on no face");
  reads_ = bilinear_reads(mesh.uv, texture_size, mask);
  const garment::PanelPlaces places = garment::locate(topology, mesh.uv);
  places_.resize(mesh.uv.rows(), 3);
  for (Eigen::Index i = 0; i < mesh.uv.rows(); ++i)
    places_.row(i) = topology.faces.row(places.faces[i]);
  weights_ = places.barycentrics;
}

Eigen::MatrixXd MeshDecoder::joined(const Eigen::Ref<const Eigen::MatrixXd>& at_uvs) const {
  Eigen::MatrixXd sums = Eigen::MatrixXd::Zero(vertex_count_, at_uvs.cols());
  for (const auto& [vertex, uv] : corners_) sums.row(vertex) += at_uvs.row(uv);
  return sums.array().colwise() / corner_count_.array();
}

Eigen::MatrixXd MeshDecoder::at_vertices(const Eigen::Ref<const Eigen::MatrixXd>& values) const {
  Eigen::MatrixXd at_uvs = Eigen::MatrixXd::Zero(places_.rows(), values.cols());
  for (Eigen::Index uv = 0; uv < places_.rows(); ++uv)
    for (int c = 0; c < 3; ++c) at_uvs.row(uv) += weights_(uv, c) * values.row(places_(uv, c));
  return joined(at_uvs);
}

Points3 MeshDecoder::offsets(const Texture& texture) const {
  return joined(read_texture(texture, reads_));
}

garment::Garment MeshDecoder::worn(const garment::Garment& garment) const {
  garment::Garment worn;
  worn.design = garment.design;
  worn.t_pose = at_vertices(garment.t_pose);
  worn.weights = at_vertices(Eigen::MatrixXd(garment.weights)).sparseView();
  worn.weights.makeCompressed();
  return worn;
}

}  // namespace pleat::encode
