#include "garment/garment_file.h"

#include <cmath>

#include "core/error.h"
#include "core/hdf5_file.h"

namespace pleat::garment {
namespace {

using Dense = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

Faces read_faces(const Hdf5File& file, const std::string& name, int64_t bound) {
  const Dims dims = file.dims(name);
  if (dims.size() != 2 || dims[1] != 3) throw InputError(file.path() + ": " + name + " is not # x 3");
  const std::vector<int32_t> data = file.read<int32_t>(name);
  for (int32_t index : data)
    if (index < 0 || index >= bound) throw InputError(file.path() + ": " + name + " names a vertex that does not exist");
  return Eigen::Map<const Faces>(data.data(), dims[0], 3);
}

template <typename Points>
Points read_points(const Hdf5File& file, const std::string& name, int64_t rows) {
  const Dims dims = file.dims(name);
  if (dims.size() != 2 || dims[1] != Points::ColsAtCompileTime || (rows >= 0 && dims[0] != rows))
    throw InputError(file.path() + ": " + name + " has the wrong shape");
  const std::vector<double> data = file.read<double>(name);
  const Points points = Eigen::Map<const Points>(data.data(), dims[0], Points::ColsAtCompileTime);
  if (!points.allFinite()) throw InputError(file.path() + ": " + name + " has numbers that are not finite");
  return points;
}

std::vector<int32_t> read_integers(const Hdf5File& file, const std::string& name, int64_t rows, int bound) {
  const Dims dims = file.dims(name);
  if (dims.size() != 1 || dims[0] != rows) throw InputError(file.path() + ": " + name + " has the wrong shape");
  const std::vector<int32_t> data = file.read<int32_t>(name);
  for (int32_t value : data)
    if (value < 0 || value >= bound) throw InputError(file.path() + ": " + name + " has a number out of range");
  return data;
}

}  // namespace

void write_garment(const std::string& path, const Garment& garment, const Provenance& provenance) {
  const GarmentTopology& topology = garment.topology;
  Hdf5File file = Hdf5File::create(path);
  file.write("faces", topology.faces.data(), {topology.faces.rows(), 3});
  file.write("panel_faces", topology.panel_faces.data(), {topology.panel_faces.rows(), 3});
  file.write("sewn_vertex", topology.sewn_vertex.data(), {topology.sewn_vertex.size()});
  std::vector<int32_t> panel;
  for (Panel p : topology.panel_of_vertex) panel.push_back(static_cast<int32_t>(p));
  file.write("panel_of_vertex", panel, {static_cast<int64_t>(panel.size())});
  file.write("uv", topology.uv.data(), {topology.uv.rows(), 2});
  file.write("panels", garment.panels.data(), {garment.panels.rows(), 2});
  file.write("t_pose", garment.t_pose.data(), {garment.t_pose.rows(), 3});
  file.write("weights", Dense(garment.weights), Hdf5Type::kFloat64);
  file.write_attribute("/", "design_name", garment.design.name);
  file.write_attribute("/", "length", garment.design.length);
  file.write_attribute("/", "sleeve", garment.design.sleeve);
  file.write_attribute("/", "cleavage", garment.design.cleavage);
  file.write_attribute("/", "held_out", static_cast<int64_t>(garment.design.is_held_out));
  write_provenance(file, provenance);
  file.commit();
}

Garment read_garment(const std::string& path) {
  const Hdf5File file = Hdf5File::open(path);
  Garment garment;
  garment.t_pose = read_points<Points3>(file, "t_pose", -1);
  const int64_t vertices = garment.t_pose.rows();
  GarmentTopology& topology = garment.topology;
  topology.vertex_count = static_cast<int>(vertices);
  topology.uv = read_points<Points2>(file, "uv", -1);
  const int64_t panel_vertices = topology.uv.rows();
  garment.panels = read_points<Points2>(file, "panels", panel_vertices);
  topology.faces = read_faces(file, "faces", vertices);
  topology.panel_faces = read_faces(file, "panel_faces", panel_vertices);
  if (topology.faces.rows() != topology.panel_faces.rows())
    throw InputError(path + ": faces and panel_faces differ in number");
  const std::vector<int32_t> sewn = read_integers(file, "sewn_vertex", panel_vertices, static_cast<int>(vertices));
  topology.sewn_vertex = Eigen::Map<const Eigen::VectorXi>(sewn.data(), panel_vertices);
  for (int32_t panel : read_integers(file, "panel_of_vertex", panel_vertices, 4))
    topology.panel_of_vertex.push_back(static_cast<Panel>(panel));
  const Dense weights = file.read_matrix("weights");
  if (weights.rows() != vertices || !weights.allFinite() || weights.minCoeff() < 0 ||
      (weights.rowwise().sum().array() - 1).abs().maxCoeff() > 1e-6)
    throw InputError(path + ": weights are not one row a vertex of numbers >= 0 that sum to 1");
  garment.weights = weights.sparseView();
  garment.design.name = file.text_attribute("/", "design_name");
  garment.design.length = file.number_attribute("/", "length");
  garment.design.sleeve = file.number_attribute("/", "sleeve");
  garment.design.cleavage = file.number_attribute("/", "cleavage");
  garment.design.is_held_out = file.number_attribute("/", "held_out") != 0;
  validate(garment.design);
  return garment;
}

}  // namespace pleat::garment
