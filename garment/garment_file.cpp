#include "garment/garment_file.h"

#include "core/error.h"
#include "core/hdf5_file.h"
#include "garment/checked_arrays.h"

namespace pleat::garment {
namespace {

void check_indices(const Hdf5File& file, const std::string& name,
                   const std::vector<int32_t>& values, int64_t bound) {
  for (const int32_t value : values)
    if (value < 0 || value >= bound)
      refuse(file, name,
             "index " + std::to_string(value) + "; expected 0 .. " + std::to_string(bound - 1));
}

Faces read_faces(const Hdf5File& file, const std::string& name, int64_t rows,
                 int64_t vertex_count) {
  const Dims dims = checked_dims(file, name, {rows, 3});
  const std::vector<int32_t> values = file.read<int32_t>(name);
  check_indices(file, name, values, vertex_count);
  return Eigen::Map<const Faces>(values.data(), dims[0], 3);
}

GarmentTopology read_topology(const Hdf5File& file) {
  GarmentTopology topology;
  topology.uv = read_reals<Points2>(file, "uv", -1);
  if (topology.uv.minCoeff() < 0 || topology.uv.maxCoeff() > 1) refuse(file, "uv", "leaves [0,1]");
  const int64_t panel_vertices = topology.uv.rows();
  const int64_t vertex_count = checked_dims(file, "t_pose", {-1, 3})[0];
  topology.vertex_count = static_cast<int>(vertex_count);
  topology.panel_faces = read_faces(file, "panel_faces", -1, panel_vertices);
  topology.faces = read_faces(file, "faces", topology.panel_faces.rows(), vertex_count);

  checked_dims(file, "sewn_vertex", {panel_vertices});
  const std::vector<int32_t> sewn = file.read<int32_t>("sewn_vertex");
  check_indices(file, "sewn_vertex", sewn, vertex_count);
  topology.sewn_vertex = Eigen::Map<const Eigen::VectorXi>(sewn.data(), panel_vertices);
  std::vector<char> is_used(static_cast<size_t>(vertex_count), 0);
  for (const int32_t v : sewn) is_used[static_cast<size_t>(v)] = 1;
  for (const char used : is_used)
    if (!used) refuse(file, "sewn_vertex", "a sewn vertex belongs to no panel");
  for (Eigen::Index i = 0; i < topology.faces.size(); ++i)
    if (topology.faces.data()[i] != topology.sewn_vertex[topology.panel_faces.data()[i]])
      refuse(file, "faces", "disagrees with panel_faces and sewn_vertex");

  checked_dims(file, "panel_of_vertex", {panel_vertices});
  const std::vector<int32_t> panel_of_vertex = file.read<int32_t>("panel_of_vertex");
  check_indices(file, "panel_of_vertex", panel_of_vertex, static_cast<int64_t>(kPanels.size()));
  for (const int32_t panel : panel_of_vertex)
    topology.panel_of_vertex.push_back(static_cast<Panel>(panel));
  return topology;
}

SkinWeights read_weights(const Hdf5File& file, int64_t vertex_count) {
  constexpr double kSumTolerance = 1e-4;
  checked_dims(file, "weights", {vertex_count, -1});
  const Eigen::MatrixXd weights = file.read_matrix("weights");
  // Written so that NaN fails too.
  if (!(weights.minCoeff() >= 0) ||
      !((weights.rowwise().sum().array() - 1).abs().maxCoeff() < kSumTolerance))
    refuse(file, "weights", "rows must be non-negative and sum to 1");
  return weights.sparseView();
}

}  // namespace

void write_garment(const std::string& path, const Garment& garment, const Provenance& provenance) {
  Hdf5File file = Hdf5File::create(path);
  const GarmentTopology& topology = garment.topology;
  const auto write_faces = [&](const std::string& name, const Faces& faces) {
    file.write<int32_t>(name, faces.data(), {faces.rows(), 3});
  };
  write_faces("faces", topology.faces);
  write_faces("panel_faces", topology.panel_faces);
  file.write<int32_t>("sewn_vertex", topology.sewn_vertex.data(), {topology.sewn_vertex.size()});
  const std::vector<int32_t> panel_of_vertex = [&] {
    std::vector<int32_t> numbers;
    for (const Panel panel : topology.panel_of_vertex)
      numbers.push_back(static_cast<int32_t>(panel));
    return numbers;
  }();
  file.write("panel_of_vertex", panel_of_vertex, {static_cast<int64_t>(panel_of_vertex.size())});
  file.write("uv", topology.uv);
  file.write("panels", garment.panels);
  file.write("t_pose", garment.t_pose);
  file.write("weights", Eigen::MatrixXd(garment.weights));
  write_design(file, garment.design);
  write_provenance(file, provenance);
  file.commit();
}

Garment read_garment(const std::string& path) {
  const Hdf5File file = Hdf5File::open(path);
  Garment garment;
  garment.design = read_design(file);
  garment.topology = read_topology(file);
  garment.panels = read_reals<Points2>(file, "panels", garment.topology.uv.rows());
  garment.t_pose = read_reals<Points3>(file, "t_pose", garment.topology.vertex_count);
  garment.weights = read_weights(file, garment.topology.vertex_count);
  return garment;
}

}  // namespace pleat::garment
