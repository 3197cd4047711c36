#include "app/yaml_reader.h"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <optional>
#include <set>
#include <sstream>
#include <vector>

#include "app/lists.h"
#include "core/error.h"

namespace pleat::app {
namespace {

// `designs` and `shapes` as maps: one of these.
struct DesignSource {
  std::string file;  // that lists them
  std::optional<DesignGrid> grid;
  std::optional<RandomDesigns> random;
};
struct ShapeSource {
  std::optional<ShapeGrid> grid;
  std::optional<RandomShapes> random;
};

// One list of keys a struct serves to read and to write: `visit(key, field)`.

template <typename V>
void fields(V& visit, BodyConfig& c) {
  visit("file", c.file);
}
template <typename V>
void fields(V& visit, MotionEntry& c) {
  visit("file", c.file);
  visit("name", c.name);
  visit("start_s", c.start_s);
  visit("duration_s", c.duration_s);
  visit("held_out", c.held_out);
}
template <typename V>
void fields(V& visit, body::MotionConfig& c) {
  visit("frame_rate_hz", c.frame_rate_hz);
  visit("max_joint_step_deg", c.max_joint_step_deg);
  visit("shoulder_abduction_deg", c.shoulder_abduction_deg);
  visit("ground", c.ground);
}
template <typename V>
void fields(V& visit, garment::Design& c) {
  visit("name", c.name);
  visit("length", c.length);
  visit("sleeve", c.sleeve);
  visit("cleavage", c.cleavage);
  visit("held_out", c.is_held_out);
}
template <typename V>
void fields(V& visit, DesignGrid& c) {
  visit("length", c.length);
  visit("sleeve", c.sleeve);
  visit("cleavage", c.cleavage);
}
template <typename V>
void fields(V& visit, RandomDesigns& c) {
  visit("count", c.count);
  visit("length", c.length);
  visit("sleeve", c.sleeve);
  visit("cleavage", c.cleavage);
  visit("held_out", c.held_out);
}
template <typename V>
void fields(V& visit, DesignSource& c) {
  visit("file", c.file);
  visit("grid", c.grid);
  visit("random", c.random);
}
template <typename V>
void fields(V& visit, ShapeGrid& c) {
  visit("betas", c.betas);
}
template <typename V>
void fields(V& visit, RandomShapes& c) {
  visit("count", c.count);
  visit("betas", c.betas);
  visit("sigma", c.sigma);
  visit("limit", c.limit);
}
template <typename V>
void fields(V& visit, ShapeSource& c) {
  visit("grid", c.grid);
  visit("random", c.random);
}
template <typename V>
void fields(V& visit, MotionFolder& c) {
  visit("folder", c.folder);
  visit("held_out", c.held_out);
}
template <typename V>
void fields(V& visit, GarmentConfig& c) {
  visit("vertices", c.vertices);
}
template <typename V>
void fields(V& visit, garment::FabricConfig& c) {
  visit("file", c.file);
  visit("name", c.name);
  visit("membrane", c.membrane);
  visit("density_kg_per_m2", c.density_kg_per_m2);
  visit("youngs_modulus_N_per_m", c.youngs_modulus_N_per_m);
  visit("poisson_ratio", c.poisson_ratio);
  visit("bending_N_m", c.bending_N_m);
  visit("friction", c.friction);
  visit("stretching_scale", c.stretching_scale);
  visit("bending_scale", c.bending_scale);
}
template <typename V>
void fields(V& visit, sim::NewtonConfig& c) {
  visit("residual", c.residual);
  visit("max_iterations", c.max_iterations);
  visit("max_step_m", c.max_step_m);
}
template <typename V>
void fields(V& visit, sim::ContactConfig& c) {
  visit("distance_m", c.distance_m);
  visit("stiffness_N_per_m3", c.stiffness_N_per_m3);
  visit("stick_N_per_m3", c.stick_N_per_m3);
  visit("layer_distance_m", c.layer_distance_m);
  visit("barrier_distance_m", c.barrier_distance_m);
  visit("barrier_Pa", c.barrier_Pa);
}
template <typename V>
void fields(V& visit, sim::AcceptConfig& c) {
  visit("residual", c.residual);
  visit("min_gap_m", c.min_gap_m);
  visit("strain_95", c.strain_95);
}
template <typename V>
void fields(V& visit, sim::SimulationConfig& c) {
  visit("ease_deg", c.ease_deg);
  visit("ease_residual", c.ease_residual);
  visit("ease_iterations", c.ease_iterations);
  visit("retries", c.retries);
  visit("checkpoint_frames", c.checkpoint_frames);
  visit("solver", c.solver);
  visit("contact", c.contact);
  visit("accept", c.accept);
}
template <typename V>
void fields(V& visit, campaign::Limits& c) {
  visit("max_seconds_per_drape", c.max_seconds_per_drape);
  visit("max_memory_mb", c.max_memory_mb);
  visit("min_free_disk_mb", c.min_free_disk_mb);
}
template <typename V>
void fields(V& visit, encode::EncodeConfig& c) {
  visit("texture_size", c.texture_size);
  visit("fill", c.fill);
  visit("dtype", c.dtype);
  visit("skinning", c.skinning);
  visit("gzip_level", c.gzip_level);
}
template <typename V>
void fields(V& visit, learn::TrainDesignConfig& c) {
  visit("hidden", c.hidden);
  visit("components", c.components);
  visit("steps", c.steps);
  visit("learning_rate", c.learning_rate);
  visit("weight_decay", c.weight_decay);
}
template <typename V>
void fields(V& visit, learn::UNetConfig& c) {
  visit("block_channels", c.block_channels);
  visit("attention_blocks", c.attention_blocks);
  visit("layers_per_block", c.layers_per_block);
  visit("patch", c.patch);
  visit("norm_groups", c.norm_groups);
  visit("attention_head_channels", c.attention_head_channels);
  visit("condition_features", c.condition_features);
  visit("scale_shift", c.scale_shift);
}
template <typename V>
void fields(V& visit, learn::TrainConfig& c) {
  visit("network", c.network);
  visit("diffusion_steps", c.diffusion_steps);
  visit("prediction", c.prediction);
  visit("batch_size", c.batch_size);
  visit("steps", c.steps);
  visit("max_minutes", c.max_minutes);
  visit("learning_rate", c.learning_rate);
  visit("warmup_steps", c.warmup_steps);
  visit("weight_decay", c.weight_decay);
  visit("max_gradient_norm", c.max_gradient_norm);
  visit("average_decay", c.average_decay);
  visit("checkpoint_minutes", c.checkpoint_minutes);
  visit("validate_every_steps", c.validate_every_steps);
  visit("validation_rows", c.validation_rows);
  visit("preload_mb", c.preload_mb);
}
template <typename V>
void fields(V& visit, RowsConfig& c) {
  visit("held_out", c.held_out);
  visit("train", c.train);
}
template <typename V>
void fields(V& visit, learn::SampleConfig& c) {
  visit("sampler", c.sampler);
  visit("ddim_steps", c.ddim_steps);
  visit("samples_per_row", c.samples_per_row);
  visit("batch_size", c.batch_size);
}
template <typename V>
void fields(V& visit, evaluate::EvaluateConfig& c) {
  visit("plausibility_stride", c.plausibility_stride);
  visit("search_distance_m", c.search_distance_m);
}
template <typename V>
void fields(V& visit, ReportConfig& c) {
  visit("frames", c.frames);
  visit("picture_width", c.picture_width);
  visit("picture_height", c.picture_height);
}
template <typename V>
void fields(V& visit, StudyConfig& c) {
  visit("output", c.output);
  visit("seed", c.seed);
  visit("threads", c.threads);
  visit("profile", c.profile);
  visit("body", c.body);
  visit("motions", c.motions);
  visit("motion", c.motion);
  visit("shapes", c.shapes);
  visit("designs", c.designs);
  visit("garment", c.garment);
  visit("fabric", c.fabric);
  visit("simulation", c.simulation);
  visit("limits", c.limits);
  visit("encode", c.encode);
  visit("train_design", c.train_design);
  visit("train", c.train);
  visit("sample", c.sample);
  visit("sample_rows", c.rows);
  visit("evaluate", c.evaluate);
  visit("report", c.report);
}

size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<size_t> row(b.size() + 1);
  for (size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (size_t i = 1; i <= a.size(); ++i) {
    size_t diagonal = row[0];
    row[0] = i;
    for (size_t j = 1; j <= b.size(); ++j) {
      const size_t above = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, diagonal + (a[i - 1] != b[j - 1])});
      diagonal = above;
    }
  }
  return row[b.size()];
}

// "path:line: " of the value that a message such as "motion.frame_rate_hz = 0; ..." is about; of
// the map that it is missing from, or only the path where that is the whole file.
std::string place_of(const std::string& message, const YAML::Node& root, const std::string& path) {
  constexpr const char* kKeyLetters =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_.";
  std::istringstream keys(message.substr(0, message.find_first_not_of(kKeyLetters)));
  YAML::Node node = root;
  for (std::string key; std::getline(keys, key, '.');) {
    const YAML::Node& map = node;
    const YAML::Node child = map.IsMap() ? map[key] : YAML::Node(YAML::NodeType::Undefined);
    if (!child) break;
    node.reset(child);
  }
  if (node.is(root)) return path + ": ";
  return path + ":" + std::to_string(node.Mark().line + 1) + ": ";
}

// Reads one map of the file; what no field asked for is unknown.
class Reader {
 public:
  // seed: of a whole study, whose `motions`, `shapes` and `designs` may be maps that tell how to
  // make the lists.
  Reader(const YAML::Node& node, std::string file, std::string prefix,
         std::optional<uint64_t> seed = std::nullopt)
      : node_(node), file_(std::move(file)), prefix_(std::move(prefix)), seed_(seed) {
    if (!node.IsMap())
      fail(node, prefix_.empty() ? "the file" : prefix_, "is not a map of keys and values");
  }

  template <typename T>
  void operator()(const std::string& key, T& value) {
    known_.push_back(key);
    const YAML::Node child = node_[key];
    if (child) read(child, name(key), value);
  }

  void finish() const {
    std::set<std::string> seen;
    for (const auto& item : node_) {
      const std::string key = item.first.as<std::string>("");
      if (!seen.insert(key).second) fail(item.first, name(key), "is given twice");
      if (std::find(known_.begin(), known_.end(), key) != known_.end()) continue;
      const auto nearest =
          std::min_element(known_.begin(), known_.end(), [&](const auto& a, const auto& b) {
            return edit_distance(a, key) < edit_distance(b, key);
          });
      std::string list;
      for (const std::string& known : known_) list += (list.empty() ? "" : ", ") + known;
      fail(item.first, name(key),
           "is no known key" + (edit_distance(*nearest, key) <= 3
                                    ? "; did you mean `" + *nearest + "`?"
                                    : "; known: " + list));
    }
  }

 private:
  std::string name(const std::string& key) const {
    return prefix_.empty() ? key : prefix_ + "." + key;
  }
  [[noreturn]] void fail(const YAML::Node& node, const std::string& key,
                         const std::string& what) const {
    throw InputError(file_ + ":" + std::to_string(node.Mark().line + 1) + ": " + key + " " + what);
  }

  template <typename T>
  void scalar(const YAML::Node& node, const std::string& key, T& value, const char* wanted) const {
    if (!node.IsScalar() || !YAML::convert<T>::decode(node, value))
      fail(node, key,
           "= " + (node.IsScalar() ? node.Scalar() : "(a list or map)") + "; expected " + wanted);
  }
  void read(const YAML::Node& node, const std::string& key, double& value) const {
    scalar(node, key, value, "a number");
  }
  void read(const YAML::Node& node, const std::string& key, int& value) const {
    scalar(node, key, value, "a whole number");
  }
  void read(const YAML::Node& node, const std::string& key, int64_t& value) const {
    scalar(node, key, value, "a whole number");
  }
  void read(const YAML::Node& node, const std::string& key, uint64_t& value) const {
    scalar(node, key, value, "a whole number >= 0");
  }
  void read(const YAML::Node& node, const std::string& key, bool& value) const {
    scalar(node, key, value, "true or false");
  }
  void read(const YAML::Node& node, const std::string& key, std::string& value) const {
    scalar(node, key, value, "a text");
  }
  void read(const YAML::Node& node, const std::string& key, garment::Range& range) const {
    if (!node.IsSequence()) {
      scalar(node, key, range.low, "a number, or a range [low, high]");
      range.high = range.low;
      return;
    }
    if (node.size() != 2) fail(node, key, "is a list; expected a number, or a range [low, high]");
    read(node[0], key + "[0]", range.low);
    read(node[1], key + "[1]", range.high);
  }
  template <typename T>
  void read(const YAML::Node& node, const std::string& key, std::optional<T>& value) const {
    read(node, key, value.emplace());
  }
  template <typename T>
  void read(const YAML::Node& node, const std::string& key, std::vector<T>& values) const {
    if (!node.IsSequence()) fail(node, key, "is not a list");
    if (node.size() > kMostItems)
      fail(node, key,
           "has " + std::to_string(node.size()) + " items; expected at most " +
               std::to_string(kMostItems));
    values.assign(node.size(), T{});
    for (size_t i = 0; i < node.size(); ++i)
      read(node[i], key + "[" + std::to_string(i) + "]", values[i]);
  }

  // `motions`, `shapes` and `designs`, where not plain lists.
  bool tells_how(const YAML::Node& list) const { return seed_ && list.IsMap(); }
  template <typename T, typename Make>  // what is wrong gets its place
  void make(std::vector<T>& list, Make make) const {
    try {
      list = make();
    } catch (const InputError& e) {
      throw InputError(place_of(e.what(), node_, file_) + e.what());
    }
  }
  void read(const YAML::Node& node, const std::string& key,
            std::vector<garment::Design>& designs) const {
    if (!tells_how(node)) return read<garment::Design>(node, key, designs);
    DesignSource source;
    read(node, key, source);
    if (!source.file.empty() + source.grid.has_value() + source.random.has_value() != 1)
      fail(node, key,
           "needs a list of designs, or one of `file:` (of a file that lists them), `grid:` and "
           "`random:`");
    if (!source.file.empty()) return read_design_file(source.file, designs);
    make(designs, [&] {
      return source.grid ? designs_of(*source.grid) : designs_of(*source.random, *seed_);
    });
  }
  void read(const YAML::Node& node, const std::string& key,
            std::vector<std::vector<double>>& shapes) const {
    if (!tells_how(node)) return read<std::vector<double>>(node, key, shapes);
    ShapeSource source;
    read(node, key, source);
    if (source.grid.has_value() + source.random.has_value() != 1)
      fail(node, key, "needs a list of shapes, or one of `grid:` and `random:`");
    make(shapes,
         [&] { return source.grid ? shapes_of(*source.grid) : shapes_of(*source.random, *seed_); });
  }
  void read(const YAML::Node& node, const std::string& key,
            std::vector<MotionEntry>& motions) const {
    if (!tells_how(node)) return read<MotionEntry>(node, key, motions);
    MotionFolder source;
    read(node, key, source);
    if (source.folder.empty())
      fail(node, key, "needs a list of motions, or `folder:` with the path of a folder of them");
    make(motions, [&] { return motions_of(source); });
  }

  template <typename T>
  std::enable_if_t<std::is_class_v<T>> read(const YAML::Node& node, const std::string& key,
                                            T& value) const {
    Reader reader(node, file_, key);
    fields(reader, value);
    reader.finish();
  }
  static void read_design_file(const std::string& path, std::vector<garment::Design>& designs);

  YAML::Node node_;
  std::string file_, prefix_;
  std::optional<uint64_t> seed_;
  std::vector<std::string> known_;
};

YAML::Node parse(const std::string& text, const std::string& path);

YAML::Node load(const std::string& path) {
  constexpr uintmax_t kMostBytes = 64 << 20;  // lists as long as kMostItems allows
  std::error_code error;
  const uintmax_t size = std::filesystem::file_size(path, error);
  if (error) throw InputError(path + ": cannot be read: " + error.message());
  if (size > kMostBytes)
    throw InputError(path + ": is larger than a configuration can be (64 MiB)");
  std::ifstream stream(path);
  if (!stream) throw InputError(path + ": cannot be read");
  return parse(std::string(std::istreambuf_iterator<char>(stream), {}), path);
}

YAML::Node parse(const std::string& text, const std::string& path) {
  try {
    const YAML::Node node = YAML::Load(text);
    if (!node || node.IsNull()) throw InputError(path + ": is empty");
    return node;
  } catch (const YAML::Exception& e) {
    throw InputError(path + ":" + std::to_string(e.mark.line + 1) + ": not valid YAML: " + e.msg);
  }
}

void Reader::read_design_file(const std::string& path, std::vector<garment::Design>& designs) {
  Reader reader(load(path), path, "");
  reader("designs", designs);  // a plain list, not a further file
  reader.finish();
}

// Writes every key with its value.
class Writer {
 public:
  explicit Writer(YAML::Emitter& out) : out_(out) { out_ << YAML::BeginMap; }
  template <typename T>
  void operator()(const std::string& key, T& value) {
    out_ << YAML::Key << key << YAML::Value;
    write(value);
  }
  template <typename T>
  void operator()(const std::string& key, std::optional<T>& value) {
    if (value) (*this)(key, *value);
  }
  void finish() { out_ << YAML::EndMap; }

 private:
  void write(std::string& value) { out_ << value; }
  void write(double value) { out_ << value; }
  void write(int value) { out_ << value; }
  void write(int64_t value) { out_ << value; }
  void write(uint64_t value) { out_ << value; }
  void write(bool value) { out_ << value; }
  void write(garment::Range& range) {
    if (range.low == range.high)
      out_ << range.low;
    else
      out_ << YAML::Flow << YAML::BeginSeq << range.low << range.high << YAML::EndSeq;
  }
  template <typename T>
  void write(std::vector<T>& values) {
    if constexpr (std::is_arithmetic_v<T>) out_ << YAML::Flow;
    out_ << YAML::BeginSeq;
    for (auto& value : values) write(value);
    out_ << YAML::EndSeq;
  }
  template <typename T>
  std::enable_if_t<std::is_class_v<T>> write(T& value) {
    Writer writer(out_);
    fields(writer, value);
    writer.finish();
  }
  YAML::Emitter& out_;
};

template <typename T>
std::string text_of(T config) {
  YAML::Emitter out;
  out.SetDoublePrecision(17);
  Writer writer(out);
  fields(writer, config);
  writer.finish();
  return std::string(out.c_str()) + "\n";
}

std::string section(const std::string& name, const std::string& text) {
  std::string indented;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) indented += "  " + line + "\n";
  return name + ":\n" + indented;
}

}  // namespace

namespace {

StudyConfig study_of(const YAML::Node& root, const std::string& path) {
  StudyConfig study;
  try {
    Reader(root, path, "")("seed", study.seed);  // first, as lists may be drawn by it
    Reader reader(root, path, "", study.seed);
    fields(reader, study);
    reader.finish();
  } catch (const YAML::Exception& e) {
    throw InputError(path + ":" + std::to_string(e.mark.line + 1) + ": " + e.msg);
  }
  for (MotionEntry& motion : study.motions) {
    if (motion.name.empty()) motion.name = std::filesystem::path(motion.file).stem().string();
    if (motion.held_out) study.encode.held_out_motions.push_back(motion.name);
  }
  study.encode.held_out_designs.emplace();
  for (const garment::Design& design : study.designs)
    if (design.is_held_out) study.encode.held_out_designs->push_back(design.name);
  study.train.seed = study.train_design.seed = study.sample.seed = study.seed;
  study.train.threads = study.train_design.threads = study.sample.threads = study.threads;
  try {
    garment::complete(study.fabric);
    validate(study);
  } catch (const InputError& e) {
    throw InputError(place_of(e.what(), root, path) + e.what());
  }
  return study;
}

}  // namespace

StudyConfig read_study(const std::string& path) { return study_of(load(path), path); }

StudyConfig read_study_text(const std::string& text, const std::string& name) {
  return study_of(parse(text, name), name);
}

StudyConfig read_study_or_folder(const std::string& path) {
  if (!std::filesystem::is_directory(path)) return read_study(path);
  StudyConfig study = read_study(path + "/config.yaml");
  study.output = path;
  return study;
}

std::string to_yaml(const StudyConfig& study) { return text_of(study); }

std::string simulation_settings(const StudyConfig& study) {
  return section("simulation", text_of(study.simulation));
}
std::string motion_settings(const body::MotionConfig& config) {
  MotionEntry cut;
  cut.start_s = config.start_s;
  cut.duration_s = config.duration_s;
  return section("motion", text_of(config)) + section("cut", text_of(cut));
}
std::string encode_settings(const StudyConfig& study) {
  std::string held_out;
  for (const std::string& name : study.encode.held_out_motions) held_out += name + "\n";
  for (const garment::Design& design : study.designs)
    held_out += design.name + (design.is_held_out ? " 1\n" : " 0\n");
  return section("encode", text_of(study.encode)) + held_out;
}
std::string train_settings(const StudyConfig& study) {
  return section("train_design", text_of(study.train_design)) +
         section("train", text_of(study.train)) + std::to_string(study.seed);
}
std::string sample_settings(const StudyConfig& study) {
  return section("sample", text_of(study.sample)) + section("sample_rows", text_of(study.rows));
}
std::string evaluate_settings(const StudyConfig& study) {
  return section("evaluate", text_of(study.evaluate));
}
std::string report_settings(const StudyConfig& study) {
  return section("report", text_of(study.report));
}

}  // namespace pleat::app
