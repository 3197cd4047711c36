#include "encode/dataset.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "body/body_file.h"
#include "core/error.h"

namespace pleat::encode {
namespace {

constexpr int64_t kSchemaVersion = 1;
constexpr int kCertificateColumns = 8;

struct ArrayNote {
  const char* name;
  const char* unit;  // "1" where it has none
  const char* meaning;
};
constexpr ArrayNote kNotes[] = {
    {"textures", "m",
     "offset x, y, z from the design's template in T-pose space; metres = value * scale_m; row 0 "
     "is v = 1"},
    {"mask", "1",
     "1 texel inside a panel, 2 gutter filled from the nearest panel, 0 empty (value 0)"},
    {"pose", "rad", "axis-angle of each joint, local to its parent"},
    {"translation", "m", "of the root"},
    {"shape", "1", "body shape coefficients beta"},
    {"design_index", "1", "row of designs/..."},
    {"sequence_index", "1", "row of sequences/..."},
    {"frame_index", "1", "frame within its sequence"},
    {"previous", "1", "row of the frame before in the same clip, -1 where none"},
    {"split", "1", "0 train, 1 held-out design, 2 held-out sequence, 3 both"},
    {"certificate", "1, 1, m, 1, 1, 1, 1, 1",
     "residual, is_stable, min_gap_m, max_strain, strain_95, body_intersections, "
     "overlap_intersections, "
     "self_intersections"},
    {"clip_key", "1", "content key of the shard that the frame came from"},
    {"designs/parameters", "1", "length, sleeve, cleavage, each 0 .. 1"},
    {"designs/names", "1", "name of each design"},
    {"designs/held_out", "1", "1: not in the training split"},
    {"designs/vertices", "m", "sewn template in the T-pose of the mean body"},
    {"designs/panels", "m", "flat rest shape, panel vertices"},
    {"designs/weights", "1", "skin weights of the sewn vertices, one column a joint"},
    {"sequences/names", "1", "name of each motion"},
    {"sequences/held_out", "1", "1: not in the training split"},
    {"sequences/frame_rate_hz", "Hz", "frames a second"},
    {"garment/faces", "1", "triangles into the sewn vertices"},
    {"garment/panel_faces", "1", "the same triangles into the panel vertices"},
    {"garment/sewn_vertex", "1", "panel vertex -> sewn vertex"},
    {"garment/panel", "1", "of each panel vertex: 0 front, 1 back, 2 left sleeve, 3 right sleeve"},
    {"garment/uv", "1", "panel vertices in the layout, [0,1]^2, v up"},
    {"normalisation/mean", "m", "of the offsets over inside texels (mask 1) of the training split"},
    {"normalisation/std", "m", "of the offsets over inside texels (mask 1) of the training split"},
};

// --- writing

void write_per_row(Hdf5File& file, const DatasetContents& contents) {
  const std::vector<DatasetRow>& rows = contents.rows;
  const int64_t count = static_cast<int64_t>(rows.size());
  const int64_t shapes = rows.front().shape.size();
  std::vector<float> poses, translations, betas, certificates;
  std::vector<int32_t> designs, sequences, frames, previous;
  std::vector<uint8_t> splits;
  std::vector<std::string> keys;
  for (const DatasetRow& row : rows) {
    const auto append = [](std::vector<float>& values, const auto& numbers) {
      for (Eigen::Index i = 0; i < numbers.size(); ++i)
        values.push_back(static_cast<float>(numbers.data()[i]));
    };
    append(poses, row.pose.rotations);
    append(translations, row.pose.translation);
    append(betas, row.shape);
    const garment::Certificate& c = row.certificate;
    for (const double number :
         {c.residual, c.is_stable ? 1.0 : 0.0, c.min_gap_m, c.max_strain, c.strain_95,
          static_cast<double>(c.body_intersections), static_cast<double>(c.overlap_intersections),
          static_cast<double>(c.self_intersections)}) {
      certificates.push_back(static_cast<float>(number));
    }
    designs.push_back(row.design);
    sequences.push_back(row.sequence);
    frames.push_back(row.frame);
    previous.push_back(row.previous);
    splits.push_back(row.split);
    keys.push_back(row.clip_key);
  }
  file.write("pose", poses, {count, body::kJoints, 3});
  file.write("translation", translations, {count, 3});
  file.write("shape", betas, {count, shapes});
  file.write("design_index", designs, {count});
  file.write("sequence_index", sequences, {count});
  file.write("frame_index", frames, {count});
  file.write("previous", previous, {count});
  file.write("split", splits, {count});
  file.write("certificate", certificates, {count, kCertificateColumns});
  file.write("clip_key", keys);
}

void write_designs(Hdf5File& file, const std::vector<garment::Garment>& garments) {
  const garment::GarmentTopology& topology = garments.front().topology;
  const int64_t count = static_cast<int64_t>(garments.size()), vertices = topology.vertex_count,
                panel_vertices = topology.uv.rows();
  std::vector<float> parameters, t_poses, panels, weights;
  std::vector<std::string> names;
  std::vector<uint8_t> held_out;
  for (const garment::Garment& garment : garments) {
    const garment::Design& design = garment.design;
    for (const double p : {design.length, design.sleeve, design.cleavage})
      parameters.push_back(static_cast<float>(p));
    names.push_back(design.name);
    held_out.push_back(design.is_held_out ? 1 : 0);
    for (Eigen::Index i = 0; i < garment.t_pose.size(); ++i) {
      t_poses.push_back(static_cast<float>(garment.t_pose.data()[i]));
    }
    for (Eigen::Index i = 0; i < garment.panels.size(); ++i) {
      panels.push_back(static_cast<float>(garment.panels.data()[i]));
    }
    const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> dense =
        garment.weights;
    for (Eigen::Index i = 0; i < dense.size(); ++i)
      weights.push_back(static_cast<float>(dense.data()[i]));
  }
  file.write("designs/parameters", parameters, {count, 3});
  file.write("designs/names", names);
  file.write("designs/held_out", held_out, {count});
  file.write("designs/vertices", t_poses, {count, vertices, 3});
  file.write("designs/panels", panels, {count, panel_vertices, 2});
  file.write("designs/weights", weights, {count, vertices, body::kJoints});

  file.write("garment/faces", topology.faces.data(), {topology.faces.rows(), 3});
  file.write("garment/panel_faces", topology.panel_faces.data(), {topology.panel_faces.rows(), 3});
  file.write("garment/sewn_vertex", topology.sewn_vertex.data(), {panel_vertices});
  std::vector<uint8_t> panel_of_vertex;
  for (const garment::Panel panel : topology.panel_of_vertex)
    panel_of_vertex.push_back(static_cast<uint8_t>(panel));
  file.write("garment/panel", panel_of_vertex, {panel_vertices});
  file.write("garment/uv", topology.uv, Hdf5Type::kFloat32);
}

void write_sequences(Hdf5File& file, const std::vector<Sequence>& sequences) {
  const int64_t count = static_cast<int64_t>(sequences.size());
  std::vector<std::string> names;
  std::vector<uint8_t> held_out;
  std::vector<float> rates;
  for (const Sequence& sequence : sequences) {
    names.push_back(sequence.name);
    held_out.push_back(sequence.is_held_out ? 1 : 0);
    rates.push_back(static_cast<float>(sequence.frame_rate_hz));
  }
  file.write("sequences/names", names);
  file.write("sequences/held_out", held_out, {count});
  file.write("sequences/frame_rate_hz", rates, {count});
}

// --- reading

[[noreturn]] void refuse(const Hdf5File& file, const std::string& array, const std::string& what) {
  throw InputError(file.path() + ": " + array + ": " + what);
}

std::string text(const Dims& dims) {
  std::string result = "[";
  for (size_t i = 0; i < dims.size(); ++i) result += (i ? ", " : "") + std::to_string(dims[i]);
  return result + "]";
}

// Reads an array of exactly this shape.
template <typename T>
std::vector<T> read_shaped(const Hdf5File& file, const std::string& name, const Dims& expected) {
  const Dims found = file.dims(name);
  if (found != expected)
    refuse(file, name, "shape " + text(found) + "; expected " + text(expected));
  std::vector<T> values = file.read<T>(name);
  for (const T value : values) {
    if (!std::isfinite(static_cast<double>(value)))
      refuse(file, name, "holds a number that is not finite");
  }
  return values;
}

std::vector<std::string> read_names(const Hdf5File& file, const std::string& name,
                                    size_t expected) {
  std::vector<std::string> names = file.read_texts(name);
  if (names.size() != expected) {
    refuse(file, name,
           std::to_string(names.size()) + " entries; expected " + std::to_string(expected));
  }
  return names;
}

template <typename T>
void check_range(const Hdf5File& file, const std::string& name, const std::vector<T>& values,
                 int64_t low, int64_t high) {
  for (size_t i = 0; i < values.size(); ++i) {
    if (values[i] < low || values[i] > high) {
      refuse(file, name,
             "entry " + std::to_string(i) + " is " + std::to_string(values[i]) + "; expected " +
                 std::to_string(low) + " .. " + std::to_string(high));
    }
  }
}

int64_t dimension(const Hdf5File& file, const std::string& name, size_t rank, size_t which) {
  const Dims dims = file.dims(name);
  if (dims.size() != rank)
    refuse(file, name,
           "shape " + text(dims) + "; expected " + std::to_string(rank) + " dimensions");
  if (dims[which] <= 0) refuse(file, name, "is empty");
  if (dims[which] > std::numeric_limits<int32_t>::max())
    refuse(file, name, "shape " + text(dims) + " is too large");
  return dims[which];
}

template <typename Matrix>
Matrix to_matrix(const float* values, Eigen::Index rows, Eigen::Index columns) {
  using Stored = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  return Eigen::Map<const Stored>(values, rows, columns).template cast<double>();
}

garment::GarmentTopology read_topology(const Hdf5File& file, int vertex_count) {
  garment::GarmentTopology topology;
  topology.vertex_count = vertex_count;
  const int64_t panel_vertices = dimension(file, "garment/sewn_vertex", 1, 0);
  const std::vector<int32_t> sewn =
      read_shaped<int32_t>(file, "garment/sewn_vertex", {panel_vertices});
  check_range(file, "garment/sewn_vertex", sewn, 0, vertex_count - 1);
  topology.sewn_vertex =
      Eigen::Map<const Eigen::VectorXi>(sewn.data(), static_cast<Eigen::Index>(sewn.size()));
  const std::vector<uint8_t> panels = read_shaped<uint8_t>(file, "garment/panel", {panel_vertices});
  check_range(file, "garment/panel", panels, 0, static_cast<int64_t>(garment::Panel::kRightSleeve));
  for (const uint8_t panel : panels)
    topology.panel_of_vertex.push_back(static_cast<garment::Panel>(panel));
  const std::vector<float> uv = read_shaped<float>(file, "garment/uv", {panel_vertices, 2});
  for (const float x : uv) {
    if (x < 0 || x > 1) refuse(file, "garment/uv", std::to_string(x) + " lies outside of [0,1]");
  }
  topology.uv = to_matrix<Points2>(uv.data(), panel_vertices, 2);

  const int64_t faces = dimension(file, "garment/faces", 2, 0);
  const std::vector<int32_t> sewn_faces = read_shaped<int32_t>(file, "garment/faces", {faces, 3});
  const std::vector<int32_t> panel_faces =
      read_shaped<int32_t>(file, "garment/panel_faces", {faces, 3});
  check_range(file, "garment/faces", sewn_faces, 0, vertex_count - 1);
  check_range(file, "garment/panel_faces", panel_faces, 0, panel_vertices - 1);
  for (size_t i = 0; i < sewn_faces.size(); ++i) {
    if (sewn[static_cast<size_t>(panel_faces[i])] != sewn_faces[i]) {
      refuse(file, "garment/panel_faces",
             "corner " + std::to_string(i) + " is not sewn to that of garment/faces");
    }
  }
  topology.faces = Eigen::Map<const Faces>(sewn_faces.data(), faces, 3);
  topology.panel_faces = Eigen::Map<const Faces>(panel_faces.data(), faces, 3);
  return topology;
}

std::vector<garment::Garment> read_designs(const Hdf5File& file) {
  const int64_t count = dimension(file, "designs/parameters", 2, 0);
  const int64_t vertices = dimension(file, "designs/vertices", 3, 1);
  const garment::GarmentTopology topology = read_topology(file, static_cast<int>(vertices));
  const int64_t panel_vertices = topology.uv.rows();
  const std::vector<float> parameters = read_shaped<float>(file, "designs/parameters", {count, 3});
  const std::vector<std::string> names =
      read_names(file, "designs/names", static_cast<size_t>(count));
  const std::vector<uint8_t> held_out = read_shaped<uint8_t>(file, "designs/held_out", {count});
  const std::vector<float> t_poses =
      read_shaped<float>(file, "designs/vertices", {count, vertices, 3});
  const std::vector<float> panels =
      read_shaped<float>(file, "designs/panels", {count, panel_vertices, 2});
  const std::vector<float> weights =
      read_shaped<float>(file, "designs/weights", {count, vertices, body::kJoints});

  std::vector<garment::Garment> garments(static_cast<size_t>(count));
  for (int64_t d = 0; d < count; ++d) {
    garment::Garment& garment = garments[static_cast<size_t>(d)];
    const size_t i = static_cast<size_t>(d);
    garment.design = {names[i], parameters[3 * i], parameters[3 * i + 1], parameters[3 * i + 2],
                      held_out[i] != 0};
    garment.topology = topology;
    garment.t_pose = to_matrix<Points3>(t_poses.data() + d * vertices * 3, vertices, 3);
    garment.panels = to_matrix<Points2>(panels.data() + d * panel_vertices * 2, panel_vertices, 2);
    Eigen::MatrixXd dense = to_matrix<Eigen::MatrixXd>(
        weights.data() + d * vertices * body::kJoints, vertices, body::kJoints);
    const Eigen::VectorXd sums = dense.rowwise().sum();
    if (dense.minCoeff() < 0 || (sums.array() - 1).abs().maxCoeff() > 1e-3) {
      refuse(file, "designs/weights", "of design " + names[i] + " are negative or do not sum to 1");
    }
    dense.array().colwise() /= sums.array();  // rounded to float in the file
    garment.weights = dense.sparseView();
  }
  return garments;
}

std::vector<Sequence> read_sequences(const Hdf5File& file) {
  const int64_t count = dimension(file, "sequences/held_out", 1, 0);
  const std::vector<std::string> names =
      read_names(file, "sequences/names", static_cast<size_t>(count));
  const std::vector<uint8_t> held_out = read_shaped<uint8_t>(file, "sequences/held_out", {count});
  const std::vector<float> rates = read_shaped<float>(file, "sequences/frame_rate_hz", {count});
  std::vector<Sequence> sequences;
  for (size_t i = 0; i < names.size(); ++i) {
    if (rates[i] <= 0)
      refuse(file, "sequences/frame_rate_hz", std::to_string(rates[i]) + "; expected > 0");
    sequences.push_back({names[i], held_out[i] != 0, rates[i]});
  }
  return sequences;
}

std::vector<DatasetRow> read_rows_of(const Hdf5File& file, int64_t count, int64_t designs,
                                     int64_t sequences) {
  const int64_t shapes = dimension(file, "shape", 2, 1);
  const std::vector<float> poses = read_shaped<float>(file, "pose", {count, body::kJoints, 3});
  const std::vector<float> translations = read_shaped<float>(file, "translation", {count, 3});
  const std::vector<float> betas = read_shaped<float>(file, "shape", {count, shapes});
  const std::vector<int32_t> design = read_shaped<int32_t>(file, "design_index", {count});
  const std::vector<int32_t> sequence = read_shaped<int32_t>(file, "sequence_index", {count});
  const std::vector<int32_t> frame = read_shaped<int32_t>(file, "frame_index", {count});
  const std::vector<int32_t> previous = read_shaped<int32_t>(file, "previous", {count});
  const std::vector<uint8_t> split = read_shaped<uint8_t>(file, "split", {count});
  const std::vector<float> certificate =
      read_shaped<float>(file, "certificate", {count, kCertificateColumns});
  const std::vector<std::string> keys = read_names(file, "clip_key", static_cast<size_t>(count));
  check_range(file, "design_index", design, 0, designs - 1);
  check_range(file, "sequence_index", sequence, 0, sequences - 1);
  check_range(file, "split", split, 0, kSplits - 1);

  std::vector<DatasetRow> rows(static_cast<size_t>(count));
  for (size_t i = 0; i < rows.size(); ++i) {
    DatasetRow& row = rows[i];
    // Earlier than the row itself: links cannot run in a circle.
    if (previous[i] < -1 || previous[i] >= static_cast<int64_t>(i)) {
      refuse(file, "previous",
             "of row " + std::to_string(i) + " is " + std::to_string(previous[i]) +
                 "; expected -1 or an earlier row");
    }
    row.pose.rotations = to_matrix<Points3>(poses.data() + i * body::kJoints * 3, body::kJoints, 3);
    for (int c = 0; c < 3; ++c)
      row.pose.translation[c] = translations[3 * i + static_cast<size_t>(c)];
    row.shape =
        to_matrix<Eigen::MatrixXd>(betas.data() + i * static_cast<size_t>(shapes), shapes, 1);
    row.design = design[i];
    row.sequence = sequence[i];
    row.frame = frame[i];
    row.previous = previous[i];
    row.split = static_cast<Split>(split[i]);
    const float* numbers = certificate.data() + i * kCertificateColumns;
    for (int k = 5; k < kCertificateColumns; ++k)
      if (!(numbers[k] >= 0 && numbers[k] < 1e9))
        refuse(file, "certificate",
               "of row " + std::to_string(i) + " counts " + std::to_string(numbers[k]) +
                   " intersections");
    row.certificate.residual = numbers[0];
    row.certificate.is_stable = numbers[1] != 0;
    row.certificate.min_gap_m = numbers[2];
    row.certificate.max_strain = numbers[3];
    row.certificate.strain_95 = numbers[4];
    row.certificate.body_intersections = static_cast<int>(numbers[5]);
    row.certificate.overlap_intersections = static_cast<int>(numbers[6]);
    row.certificate.self_intersections = static_cast<int>(numbers[7]);
    row.certificate.is_accepted = true;
    row.clip_key = keys[i];
  }
  return rows;
}

Vec<3> read_vector(const Hdf5File& file, const std::string& name) {
  const std::vector<float> values = read_shaped<float>(file, name, {3});
  return {values[0], values[1], values[2]};
}

DatasetContents read_contents(const Hdf5File& file) {
  if (!file.has("textures") || !file.has_attribute("/", "schema_version")) {
    throw InputError(file.path() +
                     ": is not a Pleat dataset (no `textures` or no `schema_version`)");
  }
  const double version = file.number_attribute("/", "schema_version");
  if (version != static_cast<double>(kSchemaVersion)) {
    throw InputError(file.path() + ": schema_version " + std::to_string(version) +
                     "; this Pleat reads " + std::to_string(kSchemaVersion) +
                     "; encode the campaign again");
  }
  const Dims dims = file.dims("textures");
  if (dims.size() != 4 || dims[1] != 3 || dims[2] != dims[3] || dims[2] < 16 || dims[2] > 4096) {
    refuse(file, "textures",
           "shape " + text(dims) + "; expected [F, 3, R, R] with R in 16 .. 4096");
  }
  if (dims[0] <= 0) refuse(file, "textures", "holds no frame");
  if (dims[0] > std::numeric_limits<int32_t>::max())
    refuse(file, "textures", "holds too many frames");

  DatasetContents contents;
  contents.texture_size = static_cast<int>(dims[2]);
  contents.mask = read_shaped<uint8_t>(file, "mask", {dims[2], dims[2]});
  check_range(file, "mask", contents.mask, kEmpty, kGutter);
  contents.garments = read_designs(file);
  contents.sequences = read_sequences(file);
  contents.rows = read_rows_of(file, dims[0], static_cast<int64_t>(contents.garments.size()),
                               static_cast<int64_t>(contents.sequences.size()));
  contents.normalisation = {read_vector(file, "normalisation/mean"),
                            read_vector(file, "normalisation/std")};
  if (contents.normalisation.std.minCoeff() <= 0) refuse(file, "normalisation/std", "expected > 0");
  contents.skinning = parse_skinning(file.text_attribute("/", "skinning"));
  contents.body_sha256 = file.text_attribute("/", "body_sha256");
  return contents;
}

TexelReads reads_of(const Hdf5File& file, const DatasetContents& contents) {
  try {
    return bilinear_reads(contents.garments.front().topology.uv, contents.texture_size,
                          contents.mask);
  } catch (const InputError& error) {
    refuse(file, "garment/uv", error.what());
  }
}

void check_texture(const Dataset& dataset, const Texture& texture) {
  const size_t size = static_cast<size_t>(texture.size);
  if (texture.size != dataset.contents().texture_size || texture.values.size() != 3 * size * size) {
    throw InputError("a texture of " + std::to_string(texture.size) + " texels a side for " +
                     dataset.path() + ", which has " +
                     std::to_string(dataset.contents().texture_size));
  }
}

std::vector<body::Transform> transforms_of(const DatasetRow& row, const body::BodyModel& model) {
  return body::joint_transforms(model, body::shape_body(model, row.shape), row.pose);
}

}  // namespace

std::string split_name(int split) {
  constexpr const char* kNames[kSplits] = {"train", "held_out_design", "held_out_sequence",
                                           "held_out_both"};
  return kNames[split];
}

DatasetWriter::DatasetWriter(const std::string& path, const DatasetContents& contents,
                             double scale_m, int gzip_level, const Provenance& provenance)
    : file_(Hdf5File::create(path)),
      row_count_(static_cast<int64_t>(contents.rows.size())),
      texture_size_(contents.texture_size),
      scale_m_(scale_m) {
  assert(row_count_ > 0 && !contents.garments.empty() && !contents.sequences.empty());
  file_.write_attribute("/", "schema_version", kSchemaVersion);
  file_.write_attribute("/", "body_sha256", contents.body_sha256);
  file_.write_attribute("/", "skinning", skinning_name(contents.skinning));
  write_provenance(file_, provenance);

  const int64_t size = texture_size_;
  file_.create_dataset("textures", {row_count_, 3, size, size},
                       scale_m_ > 0 ? Hdf5Type::kInt16 : Hdf5Type::kFloat32, 1, gzip_level);
  file_.write_attribute("textures", "scale_m", scale_m_ > 0 ? scale_m_ : 1.0);
  file_.write("mask", contents.mask, {size, size});
  file_.mark_as_image("mask");
  write_per_row(file_, contents);
  write_designs(file_, contents.garments);
  write_sequences(file_, contents.sequences);
  for (const auto& [name, vector] : {std::pair("normalisation/mean", contents.normalisation.mean),
                                     std::pair("normalisation/std", contents.normalisation.std)}) {
    const std::vector<float> values(vector.data(), vector.data() + 3);
    file_.write(name, values, {3});
  }
  for (const ArrayNote& note : kNotes) {
    file_.write_attribute(note.name, "unit", std::string(note.unit));
    file_.write_attribute(note.name, "meaning", std::string(note.meaning));
  }
}

Texture DatasetWriter::append(const Texture& texture) {
  assert(row_ < row_count_ && texture.size == texture_size_);
  if (scale_m_ > 0) {
    const std::vector<int16_t> steps = to_fixed_point(texture, scale_m_);
    file_.write_rows("textures", row_++, 1, steps.data());
    return from_fixed_point(steps, texture_size_, scale_m_);
  }
  file_.write_rows("textures", row_++, 1, texture.values.data());
  return texture;
}

void DatasetWriter::commit() {
  assert(row_ == row_count_);
  file_.commit();
}

Dataset::Dataset(const std::string& path)
    : file_(Hdf5File::open(path)),
      contents_(read_contents(file_)),
      reads_(reads_of(file_, contents_)) {
  scale_m_ = file_.number_attribute("textures", "scale_m");
  if (!(scale_m_ > 0) || !std::isfinite(scale_m_))
    refuse(file_, "textures", "attribute scale_m; expected > 0");
}

const garment::Garment& Dataset::garment(int64_t row) const {
  return contents_.garments[static_cast<size_t>(this->row(row).design)];
}

Texture Dataset::texture(int64_t row) const {
  assert(row >= 0 && row < row_count());
  Texture texture{contents_.texture_size, std::vector<float>(3 * contents_.mask.size())};
  file_.read_rows("textures", row, 1, texture.values.data());
  for (float& value : texture.values) {
    value = static_cast<float>(static_cast<double>(value) * scale_m_);
    if (!std::isfinite(value))
      refuse(file_, "textures", "row " + std::to_string(row) + " is not finite");
  }
  return texture;
}

Points3 decode_offsets(const Dataset& dataset, int64_t row, const Texture& texture) {
  check_texture(dataset, texture);
  return decode_texture(texture, dataset.garment(row).topology, dataset.reads());
}

Points3 decode_unposed(const Dataset& dataset, int64_t row, const Texture& texture) {
  return dataset.garment(row).t_pose + decode_offsets(dataset, row, texture);
}

Points3 decode_posed(const Dataset& dataset, int64_t row, const Texture& texture,
                     const body::BodyModel& model) {
  return pose(dataset.garment(row), decode_offsets(dataset, row, texture),
              transforms_of(dataset.row(row), model), dataset.contents().skinning);
}

Points3 posed_body(const Dataset& dataset, int64_t row, const body::BodyModel& model) {
  const DatasetRow& frame = dataset.row(row);
  return body::pose_body(model, body::shape_body(model, frame.shape), frame.pose);
}

body::BodyModel read_body_of(const Dataset& dataset, const std::string& body_file) {
  if (sha256_of_file(body_file) != dataset.contents().body_sha256) {
    throw InputError(body_file + ": is not the body that " + dataset.path() +
                     " was made with (attribute body_sha256); name that one, or encode again");
  }
  return body::read_body(body_file);
}

Samples::Samples(const std::string& path, const Dataset& dataset) : file_(Hdf5File::open(path)) {
  const int64_t size = dataset.contents().texture_size;
  const int64_t count = dimension(file_, "row", 1, 0);
  rows_ = read_shaped<int32_t>(file_, "row", {count});
  check_range(file_, "row", rows_, 0, dataset.row_count() - 1);
  const Dims dims = file_.dims("textures"), expected = {count, 3, size, size};
  if (dims != expected)
    refuse(file_, "textures", "shape " + text(dims) + "; expected " + text(expected));
  texture_size_ = static_cast<int>(size);
}

Texture Samples::texture(int64_t sample) const {
  const size_t size = static_cast<size_t>(texture_size_);
  Texture texture{texture_size_, std::vector<float>(3 * size * size)};
  file_.read_rows("textures", sample, 1, texture.values.data());
  for (const float value : texture.values) {
    if (!std::isfinite(value))
      refuse(file_, "textures", "sample " + std::to_string(sample) + " is not finite");
  }
  return texture;
}

}  // namespace pleat::encode
