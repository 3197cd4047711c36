#include "encode/codec_report.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "body/body_file.h"
#include "core/error.h"
#include "core/mesh.h"
#include "core/progress.h"
#include "encode/mesh_decoder.h"

namespace pleat::encode {
namespace {

// An accepted frame, and the clip that it is of.
struct Place {
  int clip = 0, frame = 0;
};

std::vector<Place> places(const DatasetInputs& inputs, int64_t max_frames) {
  std::vector<Place> all;
  for (size_t c = 0; c < inputs.clip_files.size(); ++c) {
    const garment::Clip head = garment::read_clip_head(inputs.clip_files[c]);
    for (size_t t = 0; t < head.certificates.size(); ++t)
      if (head.certificates[t].is_accepted)
        all.push_back({static_cast<int>(c), static_cast<int>(t)});
  }
  if (all.empty())
    throw InputError("none of the frames was accepted; `pleat status` names the reasons");
  const int64_t count = static_cast<int64_t>(all.size());
  if (max_frames <= 0 || count <= max_frames) return all;
  std::vector<Place> spread;
  for (int64_t i = 0; i < max_frames; ++i)
    spread.push_back(all[(2 * i + 1) * count / (2 * max_frames)]);
  return spread;
}

void add_all(ErrorSummary& summary, const Eigen::VectorXd& errors) {
  for (const double error : errors) summary.add(error);
}

Eigen::VectorXd angles_deg(const Points3& a, const Points3& b) {
  Eigen::VectorXd angles(a.rows());
  for (Eigen::Index i = 0; i < a.rows(); ++i) {
    const Vec<3> u = a.row(i).transpose(), v = b.row(i).transpose();
    angles[i] = std::atan2(u.cross(v).norm(), u.dot(v)) * 180 / M_PI;
  }
  return angles;
}

std::vector<Edge> inner_edges(const Faces& faces) {
  std::vector<Edge> all = edges(faces);
  all.erase(std::remove_if(all.begin(), all.end(), [](const Edge& e) { return e.faces[1] < 0; }),
            all.end());
  return all;
}

// Of each edge: whether the cloth is folded over there.
std::vector<char> folds(const std::vector<Edge>& edges, const Points3& normals) {
  const double cosine = std::cos(105 * M_PI / 180);
  std::vector<char> folds;
  for (const Edge& edge : edges)
    folds.push_back(normals.row(edge.faces[0]).dot(normals.row(edge.faces[1])) < cosine);
  return folds;
}

// One texture size and fill at work.
struct Variant {
  TextureEncoder encoder;
  MeshDecoder finer;
  float largest = 0;  // m, of one axis
  CodecVariant result;
};

// A drape, and what unposes it.
struct Drape {
  const std::string* file = nullptr;
  int frame = 0, design = 0;
  Points3 posed;
  std::vector<body::Transform> transforms;
  Points3 offsets;
  Eigen::VectorXd singular_values;
};

template <typename Action>
bool for_each_drape(const DatasetInputs& inputs, const std::vector<Place>& places,
                    const std::vector<garment::Garment>& garments, const body::BodyModel& model,
                    Skinning skinning, Progress& progress, const std::string& what, Action action) {
  garment::Clip clip;
  body::ShapedBody body;
  int loaded = -1, design = 0;
  for (const Place& place : places) {
    if (is_interrupted()) return false;
    const std::string& file = inputs.clip_files[static_cast<size_t>(place.clip)];
    if (place.clip != loaded) {
      clip = load_clip(file, garments.front().topology.vertex_count);
      body = body::shape_body(model, clip.shape);
      design = design_of(clip, file, garments);
      loaded = place.clip;
    }
    Drape drape;
    drape.file = &file;
    drape.frame = place.frame;
    drape.design = design;
    drape.posed = clip.positions[static_cast<size_t>(place.frame)];
    drape.transforms =
        body::joint_transforms(model, body, clip.poses[static_cast<size_t>(place.frame)]);
    drape.offsets = unpose(garments[static_cast<size_t>(design)], drape.posed, drape.transforms,
                           skinning, &drape.singular_values);
    if (!drape.offsets.allFinite())
      throw InputError(file + ": frame " + std::to_string(place.frame) + " cannot be unposed");
    action(drape);
    progress.advance(1, what);
  }
  return true;
}

}  // namespace

void CodecErrors::add(const CodecErrors& other) {
  texture_mm.add(other.texture_mm);
  quantisation_mm.add(other.quantisation_mm);
  total_mm.add(other.total_mm);
  normals_deg.add(other.normals_deg);
  finer_mm.add(other.finer_mm);
}

CodecErrors CodecVariant::all() const {
  CodecErrors sum;
  for (const CodecErrors& design : designs) sum.add(design);
  return sum;
}

CodecReport codec_report(const DatasetInputs& inputs, const CodecReportConfig& config) {
  const std::vector<garment::Garment> garments = read_garments(inputs.garment_files);
  const garment::GarmentTopology& topology = garments.front().topology;
  const body::BodyModel model = body::read_body(inputs.body_file);
  const std::vector<Place> frames = places(inputs, config.max_frames);
  const garment::GarmentTopology finer = garment::make_topology(config.finer_vertices);

  CodecReport report;
  report.vertices = topology.vertex_count;
  report.finer_vertices = finer.vertex_count;
  for (const garment::Garment& garment : garments) report.designs.push_back(garment.design.name);
  report.frames.assign(garments.size(), 0);
  report.unposing_mm.resize(garments.size());

  std::vector<Variant> variants;
  for (const int size : config.texture_sizes) {
    const UvLayout layout = make_uv_layout(topology, size);
    for (const Fill fill : config.fills)
      variants.push_back({TextureEncoder(topology, layout, fill),
                          MeshDecoder(topology, size, layout.mask, layout_mesh(finer)),
                          0,
                          {size, fill, 0, std::vector<CodecErrors>(garments.size())}});
  }
  std::vector<garment::Garment> worn_finer;  // the same for every variant
  for (const garment::Garment& garment : garments)
    worn_finer.push_back(variants.front().finer.worn(garment));

  Progress progress("codec", 2 * static_cast<int64_t>(frames.size()), "frames");
  const std::vector<Edge> inner = inner_edges(topology.faces);
  const auto measure = [&](const Drape& drape) {
    const garment::Garment& garment = garments[static_cast<size_t>(drape.design)];
    ++report.frames[static_cast<size_t>(drape.design)];
    const double smallest = drape.singular_values.minCoeff();
    if (report.worst_unposed.empty() || report.worst_unposed.back().clip_file != *drape.file)
      report.worst_unposed.push_back({*drape.file, drape.frame, drape.design, smallest});
    else if (smallest < report.worst_unposed.back().smallest_singular_value)
      report.worst_unposed.back() = {*drape.file, drape.frame, drape.design, smallest};
    const std::vector<char> in_drape = folds(inner, face_normals(drape.posed, topology.faces)),
                            unposed = folds(inner, face_normals(garment.t_pose + drape.offsets,
                                                                topology.faces));
    for (size_t e = 0; e < inner.size(); ++e) {
      report.folds_posed += in_drape[e];
      report.folds_added += unposed[e] && !in_drape[e];
    }
    report.edges += static_cast<int64_t>(inner.size());
    add_all(report.unposing_mm[static_cast<size_t>(drape.design)],
            vertex_distances_mm(pose(garment, drape.offsets, drape.transforms, config.skinning),
                                drape.posed));
    const Points3 normals = face_normals(drape.posed, topology.faces);
    const Points3 surface = variants.front().finer.at_vertices(drape.posed);
    for (Variant& variant : variants) {
      CodecErrors& errors = variant.result.designs[static_cast<size_t>(drape.design)];
      const double scale_m = variant.result.scale_m;
      const auto posed = [&](const Texture& texture) {
        return pose(garment, decode_texture(texture, topology, variant.encoder.reads()),
                    drape.transforms, config.skinning);
      };
      const Texture texture = variant.encoder.encode(drape.offsets);
      const Texture stored =
          from_fixed_point(to_fixed_point(texture, scale_m), texture.size, scale_m);
      const Points3 from_float = posed(texture), decoded = posed(stored);
      add_all(errors.texture_mm, vertex_distances_mm(from_float, drape.posed));
      add_all(errors.quantisation_mm, vertex_distances_mm(decoded, from_float));
      add_all(errors.total_mm, vertex_distances_mm(decoded, drape.posed));
      add_all(errors.normals_deg, angles_deg(face_normals(decoded, topology.faces), normals));
      add_all(errors.finer_mm,
              vertex_distances_mm(
                  pose(worn_finer[static_cast<size_t>(drape.design)], variant.finer.offsets(stored),
                       drape.transforms, config.skinning),
                  surface));
    }
  };
  const auto survey = [&](const Drape& drape) {
    for (Variant& variant : variants)
      for (const float value : variant.encoder.encode(drape.offsets).values)
        variant.largest = std::max(variant.largest, std::abs(value));
  };
  const auto run = [&](const std::string& what, const auto& action) {
    return for_each_drape(inputs, frames, garments, model, config.skinning, progress, what, action);
  };
  report.is_interrupted = !run("range", survey);
  for (Variant& variant : variants)
    variant.result.scale_m = fixed_point_scale(static_cast<double>(variant.largest));
  report.is_interrupted = report.is_interrupted || !run("errors", measure);
  std::stable_sort(report.worst_unposed.begin(), report.worst_unposed.end(),
                   [](const UnposedFrame& a, const UnposedFrame& b) {
                     return a.smallest_singular_value < b.smallest_singular_value;
                   });
  for (Variant& variant : variants) report.variants.push_back(std::move(variant.result));
  return report;
}

namespace {

std::string fill_name(Fill fill) { return fill == Fill::kFitted ? "fitted" : "barycentric"; }

std::string numbers(const ErrorSummary& errors) {
  char text[96];
  std::snprintf(text, sizeof text, "%.4f / %.4f / %.3f", errors.mean(), errors.percentile(99),
                errors.max());
  return text;
}

std::string number(const char* pattern, double value) {
  char text[32];
  std::snprintf(text, sizeof text, pattern, value);
  return text;
}

std::string degrees(const ErrorSummary& errors) {
  char text[96];
  std::snprintf(text, sizeof text, "%.3f / %.3f", errors.mean(), errors.percentile(99));
  return text;
}

nlohmann::json to_json(const ErrorSummary& errors) {
  return {{"mean", errors.mean()}, {"p99", errors.percentile(99)}, {"max", errors.max()}};
}

nlohmann::json to_json(const CodecErrors& errors) {
  return {{"texture_mm", to_json(errors.texture_mm)},
          {"quantisation_mm", to_json(errors.quantisation_mm)},
          {"total_mm", to_json(errors.total_mm)},
          {"normals_deg", to_json(errors.normals_deg)},
          {"finer_mm", to_json(errors.finer_mm)}};
}

}  // namespace

std::string to_markdown(const CodecReport& report) {
  int64_t frames = 0;
  int designs = 0;
  for (const int64_t count : report.frames) {
    frames += count;
    designs += count > 0;
  }
  ErrorSummary unposing;
  for (const ErrorSummary& design : report.unposing_mm) unposing.add(design);
  const double worst =
      report.worst_unposed.empty() ? 1 : report.worst_unposed.front().smallest_singular_value;
  std::string text =
      std::to_string(frames) + " frames of " + std::to_string(designs) + " designs, " +
      std::to_string(report.vertices) +
      " vertices. Errors of vertices in the posed world, mm: mean / 99th percentile / largest; "
      "of face normals, degrees: mean / 99th percentile. Unposing and posing again: " +
      numbers(unposing) + " mm; the smallest singular value of a blended transform is " +
      number("%.3f", worst) + ". Folded-over edges: " +
      number("%.3g", 1e6 * report.folds_posed / std::max<double>(1, report.edges)) +
      " of a million in the drapes, " +
      number("%.3g", 1e6 * report.folds_added / std::max<double>(1, report.edges)) +
      " more in the unposed garments.\n\n" +
      "| texels | fill | texture (float32) | quantisation (int16) | total (int16) | normals | on " +
      std::to_string(report.finer_vertices) +
      " vertices |\n| --- | --- | --- | --- | --- | --- | --- |\n";
  const auto row = [](const CodecErrors& errors) {
    return numbers(errors.texture_mm) + " | " + numbers(errors.quantisation_mm) + " | " +
           numbers(errors.total_mm) + " | " + degrees(errors.normals_deg) + " | " +
           numbers(errors.finer_mm) + " |\n";
  };
  for (const CodecVariant& variant : report.variants)
    text += "| " + std::to_string(variant.texture_size) + " | " + fill_name(variant.fill) + " | " +
            row(variant.all());
  for (const CodecVariant& variant : report.variants) {
    text += "\n" + std::to_string(variant.texture_size) + " texels, " + fill_name(variant.fill) +
            ", by design:\n\n| design | frames | unposing | texture (float32) | quantisation "
            "(int16) | total (int16) | normals | on " +
            std::to_string(report.finer_vertices) +
            " vertices |\n| --- | --- | --- | --- | --- | --- | --- | --- |\n";
    for (size_t d = 0; d < report.designs.size(); ++d)
      if (report.frames[d] > 0)
        text += "| " + report.designs[d] + " | " + std::to_string(report.frames[d]) + " | " +
                numbers(report.unposing_mm[d]) + " | " + row(variant.designs[d]);
  }
  return text;
}

std::string to_json(const CodecReport& report) {
  nlohmann::json json = {{"vertices", report.vertices},
                         {"finer_vertices", report.finer_vertices},
                         {"folds_posed", report.folds_posed},
                         {"folds_added", report.folds_added},
                         {"edges", report.edges}};
  for (const UnposedFrame& frame : report.worst_unposed)
    json["worst_unposed"].push_back({{"shard", frame.clip_file},
                                     {"frame", frame.frame},
                                     {"smallest_singular_value", frame.smallest_singular_value}});
  for (size_t d = 0; d < report.designs.size(); ++d)
    json["designs"].push_back({{"name", report.designs[d]},
                               {"frames", report.frames[d]},
                               {"unposing_mm", to_json(report.unposing_mm[d])}});
  for (const CodecVariant& variant : report.variants) {
    nlohmann::json row = {{"texture_size", variant.texture_size},
                          {"scale_m", variant.scale_m},
                          {"fill", fill_name(variant.fill)}};
    row["all"] = to_json(variant.all());
    for (size_t d = 0; d < report.designs.size(); ++d)
      if (report.frames[d] > 0) row["designs"][report.designs[d]] = to_json(variant.designs[d]);
    json["variants"].push_back(row);
  }
  return json.dump(2) + "\n";
}

}  // namespace pleat::encode
