#include "app/codec_commands.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>

#include "app/exit_codes.h"
#include "app/pipeline.h"
#include "app/yaml_reader.h"
#include "body/body_file.h"
#include "campaign/verify.h"
#include "core/atomic_file.h"
#include "core/error.h"
#include "core/mesh_file.h"
#include "core/profile.h"
#include "encode/codec_report.h"
#include "encode/dataset.h"
#include "encode/mesh_decoder.h"
#include "show/image.h"
#include "show/render.h"

namespace pleat::app {
namespace {

struct ReportRequest {
  std::string study, json, picture;
  std::vector<int> sizes = {64, 128, 256};
  std::vector<std::string> fills = {"barycentric", "fitted"};
  std::string skinning;
  int vertices = 20000;
  int64_t frames = 1000;
};

// Each frame as simulated and as unposed, from the front and from the side.
show::Image unposing_picture(const std::vector<encode::UnposedFrame>& frames,
                             const encode::DatasetInputs& inputs, encode::Skinning skinning) {
  const std::vector<garment::Garment> garments = encode::read_garments(inputs.garment_files);
  const body::BodyModel model = body::read_body(inputs.body_file);
  constexpr size_t kMost = 6;
  std::vector<show::Image> images;
  for (size_t k = 0; k < std::min(kMost, frames.size()); ++k) {
    const encode::UnposedFrame& frame = frames[k];
    const garment::Garment& garment = garments[static_cast<size_t>(frame.design)];
    const garment::Clip clip = garment::read_clip_frames(frame.clip_file, frame.frame, 1);
    const body::ShapedBody body = body::shape_body(model, clip.shape);
    const body::Pose& pose = clip.poses.front();
    const Points3& posed = clip.positions.front();
    const auto transforms = body::joint_transforms(model, body, pose);
    const Points3 unposed = garment.t_pose + encode::unpose(garment, posed, transforms, skinning);
    const double yaw = show::facing_yaw(pose.rotations.row(0).transpose());
    constexpr double kHeight = 1.5;  // m
    show::RenderConfig render;
    render.width = 360;
    render.height = 420;
    render.has_ground = false;
    const Vec<3> middle = posed.colwise().mean().transpose();
    for (const show::View view : {show::View::kFront, show::View::kSide}) {
      images.push_back(
          show::render({show::body_mesh(body::pose_body(model, body, pose), model.faces),
                        show::cloth_mesh(posed, garment.topology.faces)},
                       show::view_camera(view, middle, yaw, kHeight), render));
      images.push_back(show::render(
          {show::cloth_mesh(unposed, garment.topology.faces)},
          show::view_camera(view, garment.t_pose.colwise().mean().transpose(), 0, kHeight),
          render));
    }
  }
  return show::contact_sheet(images, 4);
}

int report(const ReportRequest& request) {
  const StudyConfig study = read_study_or_folder(request.study);
  encode::CodecReportConfig config;
  config.texture_sizes = request.sizes;
  config.fills.clear();
  for (const std::string& fill : request.fills) config.fills.push_back(encode::parse_fill(fill));
  config.skinning =
      encode::parse_skinning(request.skinning.empty() ? study.encode.skinning : request.skinning);
  config.finer_vertices = request.vertices;
  config.max_frames = request.frames;
  encode::DatasetInputs inputs = dataset_inputs(study, campaign::plan(campaign_of(study)));
  const auto is_missing = [](const std::string& file) { return !std::filesystem::exists(file); };
  const size_t planned = inputs.clip_files.size();
  for (auto* files : {&inputs.clip_files, &inputs.garment_files})
    files->erase(std::remove_if(files->begin(), files->end(), is_missing), files->end());
  if (inputs.clip_files.empty())
    throw InputError(study.output + ": no chain is simulated yet; `pleat simulate " +
                     request.study + "` does it");
  const encode::CodecReport report = encode::codec_report(inputs, config);
  if (report.is_interrupted) return kInterrupted;
  std::printf("%zu of %zu chains. %s", inputs.clip_files.size(), planned,
              encode::to_markdown(report).c_str());
  if (!request.json.empty()) write_file_atomically(request.json, encode::to_json(report));
  if (!request.picture.empty())
    show::write_png(request.picture,
                    unposing_picture(report.worst_unposed, inputs, config.skinning));
  return kDone;
}

struct DecodeRequest {
  std::string dataset, out, mesh, body;
  int64_t frame = 0;
  int vertices = 0;
  bool is_unposed = false;
};

void check_frame(const encode::Dataset& dataset, int64_t frame) {
  if (frame < 0 || frame >= dataset.row_count())
    throw InputError("--frame " + std::to_string(frame) + ": " + dataset.path() +
                     " has rows 0 .. " + std::to_string(dataset.row_count() - 1));
}

int decode(const DecodeRequest& request) {
  if (!request.mesh.empty() && request.vertices > 0)
    throw InputError("decode: say --mesh or --vertices, not both");
  const encode::Dataset dataset(request.dataset);
  check_frame(dataset, request.frame);
  const encode::DatasetContents& contents = dataset.contents();
  const garment::Garment& garment = dataset.garment(request.frame);
  TriangleMesh mesh;
  if (!request.mesh.empty())
    mesh = read_mesh(request.mesh);
  else
    mesh = encode::layout_mesh(request.vertices > 0 ? garment::make_topology(request.vertices)
                                                    : garment.topology);
  std::optional<encode::MeshDecoder> decoder;
  try {
    decoder.emplace(garment.topology, contents.texture_size, contents.mask, mesh);
  } catch (const InputError& error) {
    throw InputError(request.mesh.empty() ? error.what() : request.mesh + ": " + error.what());
  }
  const garment::Garment worn = decoder->worn(garment);
  const Points3 offsets = decoder->offsets(dataset.texture(request.frame));
  if (request.is_unposed) {
    mesh.vertices = worn.t_pose + offsets;
  } else {
    const std::string body_file =
        request.body.empty()
            ? read_study_text(dataset.provenance().config, dataset.path() + ": attribute config")
                  .body.file
            : request.body;
    const body::BodyModel model = encode::read_body_of(dataset, body_file);
    const encode::DatasetRow& row = dataset.row(request.frame);
    mesh.vertices = encode::pose(
        worn, offsets, body::joint_transforms(model, body::shape_body(model, row.shape), row.pose),
        contents.skinning);
  }
  write_obj(request.out, mesh);
  std::printf(
      "%s: row %lld (%s, %s frame %d), %ld vertices\n", request.out.c_str(),
      static_cast<long long>(request.frame), garment.design.name.c_str(),
      contents.sequences[static_cast<size_t>(dataset.row(request.frame).sequence)].name.c_str(),
      dataset.row(request.frame).frame, static_cast<long>(mesh.vertices.rows()));
  return kDone;
}

struct RegenerateRequest {
  std::string dataset, out;
  int64_t frame = 0;
};

int regenerate(const RegenerateRequest& request, char** argv) {
  const encode::Dataset dataset(request.dataset);
  check_frame(dataset, request.frame);
  const encode::DatasetRow& row = dataset.row(request.frame);
  const StudyConfig study =
      read_study_text(dataset.provenance().config, dataset.path() + ": attribute config");
  enter_profile(study.profile, argv);
  const campaign::Campaign campaign = campaign_of(study);
  const campaign::Manifest manifest = campaign::plan(campaign);
  const auto chain = std::find_if(manifest.chains.begin(), manifest.chains.end(),
                                  [&](const campaign::Chain& c) { return c.key == row.clip_key; });
  if (chain == manifest.chains.end())
    throw InputError(dataset.path() + ": row " + std::to_string(request.frame) + " is of chain " +
                     row.clip_key +
                     ", which its configuration no longer gives: body, motions or this version of "
                     "Pleat differ from what made it");
  const campaign::Remade remade =
      campaign::remake(campaign, manifest, run_options_of(study),
                       static_cast<int>(chain - manifest.chains.begin()), row.frame);
  if (remade.clip.positions.empty()) return kInterrupted;
  const encode::DatasetContents& contents = dataset.contents();
  const body::BodyModel model = encode::read_body_of(dataset, study.body.file);
  const Points3& posed = remade.clip.positions.back();
  const Points3 offsets =
      encode::unpose(remade.garment, posed,
                     body::joint_transforms(model, body::shape_body(model, remade.clip.shape),
                                            remade.clip.poses.back()),
                     contents.skinning);
  const encode::TextureEncoder encoder(
      remade.garment.topology,
      encode::make_uv_layout(remade.garment.topology, contents.texture_size),
      encode::parse_fill(study.encode.fill));
  encode::Texture texture = encoder.encode(offsets);
  if (study.encode.dtype == "int16")
    texture = encode::from_fixed_point(encode::to_fixed_point(texture, dataset.scale_m()),
                                       texture.size, dataset.scale_m());
  const encode::Texture stored = dataset.texture(request.frame);
  float largest = 0;
  for (size_t i = 0; i < stored.values.size(); ++i)
    largest = std::max(largest, std::abs(stored.values[i] - texture.values[i]));
  std::printf("row %lld: chain %s, frame %d: %s\n", static_cast<long long>(request.frame),
              row.clip_key.c_str(), row.frame,
              largest == 0
                  ? "the same bits"
                  : ("differs by up to " + std::to_string(1000 * largest) + " mm").c_str());
  if (!request.out.empty()) {
    TriangleMesh mesh = encode::layout_mesh(remade.garment.topology);
    mesh.vertices = posed;
    write_obj(request.out, mesh);
    std::printf("%s: the drape, %ld vertices\n", request.out.c_str(),
                static_cast<long>(posed.rows()));
  }
  return largest == 0 ? kDone : kFailed;
}

}  // namespace

void add_codec_commands(CLI::App& program, int& result, char** argv) {
  CLI::App* codec = program.add_subcommand("codec", "what drapes lose as textures");
  codec->require_subcommand(1);
  const auto r = std::make_shared<ReportRequest>();
  CLI::App* command = codec->add_subcommand(
      "report",
      "round-trip errors of a study's drapes, in millimetres, by texture size, fill, storage and "
      "design");
  command->add_option("STUDY", r->study, "the study's YAML file, or its output folder")->required();
  command->add_option("--texture-size", r->sizes, "texels a side")->capture_default_str();
  command->add_option("--fill", r->fills, "barycentric (the paper's), fitted")
      ->capture_default_str();
  command->add_option("--skinning", r->skinning,
                      "linear or dual_quaternion; by default the study's");
  command->add_option("--vertices", r->vertices, "of the finer tessellation that is decoded on")
      ->capture_default_str();
  command->add_option("--frames", r->frames, "at most, evenly spread; 0: all")
      ->capture_default_str();
  command->add_option("--json", r->json, "file to write with everything");
  command->add_option("--picture", r->picture,
                      "PNG to write: the frames that unpose worst, as simulated and unposed");
  command->callback([r, &result] { result = report(*r); });

  const auto d = std::make_shared<DecodeRequest>();
  command = program.add_subcommand(
      "decode",
      "a frame of a dataset as OBJ, on the garment's own mesh, a finer or coarser one, or yours");
  command->add_option("DATASET", d->dataset, "dataset.h5")->required();
  command->add_option("OUT", d->out, "the .obj to write")->required();
  command->add_option("--frame", d->frame, "row of the dataset")->capture_default_str();
  command->add_option("--vertices", d->vertices, "of another tessellation, about");
  command->add_option("--mesh", d->mesh,
                      "a mesh with UVs in the layout of garment/uv; its positions do not count");
  command->add_option("--body", d->body, "by default the one that the dataset was made with");
  command->add_flag("--unposed", d->is_unposed, "in the T-pose");
  command->callback([d, &result] { result = decode(*d); });

  const auto g = std::make_shared<RegenerateRequest>();
  command = program.add_subcommand(
      "regenerate",
      "simulate a frame of a dataset again, from the dataset's provenance alone, and compare");
  command->add_option("DATASET", g->dataset, "dataset.h5")->required();
  command->add_option("--frame", g->frame, "row of the dataset")->capture_default_str();
  command->add_option("--out", g->out, "an .obj to write the drape to");
  command->callback([g, &result, argv] { result = regenerate(*g, argv); });
}

}  // namespace pleat::app
