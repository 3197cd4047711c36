#include "app/yaml_reader.h"

#include <gmock/gmock.h>

#include <filesystem>

#include "tests/core/input_error.h"
#include "tests/core/scratch.h"

namespace pleat::app {
namespace {

using testing::ElementsAre;

// What a study cannot do without; tests append to it.
const std::string kLeast =
    "output: out\n"
    "body: {file: body.npz}\n"
    "motions:\n"
    "  - file: motions/walk.npz\n"
    "  - {file: jump.bvh, name: leap, held_out: true}\n"
    "designs:\n"
    "  - {name: tee, length: 0.3}\n";
const int kLeastLines = 7;

struct Study {
  Scratch scratch;
  std::string path = scratch.path("study.yaml");
  explicit Study(const std::string& text) { write_bytes(path, text); }
  StudyConfig read() const { return read_study(path); }
  std::string at(int line) const { return path + ":" + std::to_string(line) + ": "; }
};

TEST(YamlReader, ReadsTheQuickstart) {
  const StudyConfig study = read_study(PLEAT_SOURCE_DIR "/configs/quickstart.yaml");
  EXPECT_EQ(study.output, "runs/quickstart");
  EXPECT_EQ(study.body.file, "data/body/anny.npz");
  EXPECT_NE(study.motion.frame_rate_hz, body::MotionConfig{}.frame_rate_hz);
  ASSERT_EQ(study.motions.size(), 3u);
  EXPECT_EQ(study.motions[1].name, "walk");
  EXPECT_GT(study.motions[1].duration_s, 0);
  EXPECT_TRUE(study.motions[2].held_out);
  ASSERT_EQ(study.designs.size(), 4u);
  EXPECT_EQ(study.designs[1].name, "sleeveless_top");
  EXPECT_EQ(study.designs[1].cleavage, 0.7);
  EXPECT_TRUE(study.designs[3].is_held_out);
  EXPECT_THAT(study.shapes, ElementsAre(ElementsAre()));
  EXPECT_NE(study.train.max_minutes, learn::TrainConfig{}.max_minutes);
  EXPECT_EQ(garment::middle_fabric(study.fabric).density_kg_per_m2,
            garment::Fabric{}.density_kg_per_m2);
}

TEST(YamlReader, EffectiveConfigurationReadsBackTheSame) {
  // Values that a writer could round, and texts that YAML could take for something else.
  const Study odd(
      "output: \"a: b #c\"\nseed: 18446744073709551615\nthreads: 3\nbody: {file: '~'}\n"
      "motions: [{file: \"\\\"quoted\\\".npz\", name: '1.50', start_s: 0.1, held_out: true}, "
      "{file: 'C:\\walk.npz', name: 'yes'}]\n"
      "shapes: [[], [0.1, -0.30000000000000004], [1e-300]]\n"
      "designs: [{name: 'null', length: 0.3333333333333333, held_out: true}]\n"
      "fabric: {friction: 0.1234567890123456, bending_N_m: [1e-6, 0.30000000000000004], "
      "membrane: neo_hookean}\n"
      "simulation: {ease_deg: 7.3, solver: {residual: 1e-4}, accept: {min_gap_m: -0.001}}\n"
      "encode: {dtype: float32}\n"
      "train: {network: {block_channels: [32, 64], attention_blocks: [1]}}\n");
  for (const std::string& path :
       {odd.path, std::string(PLEAT_SOURCE_DIR "/configs/quickstart.yaml")}) {
    const StudyConfig study = read_study(path);
    const Study again(to_yaml(study));
    EXPECT_EQ(to_yaml(again.read()), to_yaml(study));
    EXPECT_EQ(again.read().encode.held_out_motions, study.encode.held_out_motions);
  }
  const StudyConfig study = Study(to_yaml(odd.read())).read();
  EXPECT_EQ(study.output, "a: b #c");
  EXPECT_EQ(study.seed, 18446744073709551615u);
  EXPECT_EQ(study.body.file, "~");
  EXPECT_EQ(study.motions[0].file, "\"quoted\".npz");
  EXPECT_EQ(study.motions[0].name, "1.50");
  EXPECT_EQ(study.motions[1].file, "C:\\walk.npz");
  EXPECT_EQ(study.motions[1].name, "yes");
  EXPECT_EQ(study.designs[0].name, "null");
  EXPECT_EQ(study.designs[0].length, 0.3333333333333333);
  EXPECT_THAT(study.shapes, ElementsAre(ElementsAre(), ElementsAre(0.1, -0.30000000000000004),
                                        ElementsAre(1e-300)));
  EXPECT_EQ(study.fabric.friction->low, 0.1234567890123456);
  EXPECT_EQ(study.fabric.friction->high, 0.1234567890123456);
  EXPECT_EQ(study.fabric.bending_N_m->low, 1e-6);
  EXPECT_EQ(study.fabric.bending_N_m->high, 0.30000000000000004);
  EXPECT_EQ(study.simulation.solver.residual, 1e-4);
  EXPECT_THAT(study.train.network.block_channels, ElementsAre(32, 64));
}

TEST(YamlReader, ReadsFabricsByNumbersByNameAndByFile) {
  const auto fabric = [](const std::string& text) {
    return Study(kLeast + "fabric: " + text + "\n").read().fabric;
  };
  EXPECT_EQ(garment::to_text(garment::middle_fabric(fabric("{}"))),
            garment::to_text(garment::Fabric{}));
  const garment::FabricConfig named = fabric("{name: gray_interlock, density_kg_per_m2: 0.2}");
  ASSERT_TRUE(named.tables);
  EXPECT_EQ(named.density_kg_per_m2->low, 0.2);
  EXPECT_EQ(named.friction->low, garment::Fabric{}.friction);
  const garment::FabricConfig filed = fabric("{file: " PLEAT_SOURCE_DIR
                                             "/configs/fabrics/gray_interlock.json, "
                                             "bending_scale: [0.5, 2]}");
  EXPECT_EQ(filed.tables->stretching, named.tables->stretching);
  EXPECT_EQ(filed.density_kg_per_m2->low, 0.187);
  EXPECT_EQ(filed.bending_scale.high, 2);
  // The effective configuration of a measured fabric reads back, without the numbers it has not.
  const Study study(kLeast + "fabric: {name: gray_interlock, friction: [0.2, 0.5]}\n");
  const std::string text = to_yaml(study.read());
  EXPECT_EQ(text.find("youngs_modulus"), std::string::npos);
  EXPECT_EQ(to_yaml(Study(text).read()), text);
}

TEST(YamlReader, NamesTheFileOfABadFabric) {
  const Scratch scratch;
  const std::string path = scratch.path("cloth.json");
  write_bytes(path, "{\"density\": -1}");
  const Study study(kLeast + "fabric:\n  friction: 0.3\n  file: " + path + "\n");
  EXPECT_INPUT_ERROR(study.read(), study.at(kLeastLines + 3), "fabric.file: " + path,
                     "density = -1");
  const Study unknown(kLeast + "fabric: {name: silk}\n");
  EXPECT_INPUT_ERROR(unknown.read(), unknown.at(kLeastLines + 1), "fabric.name", "'silk'",
                     "black_denim, ");
}

TEST(YamlReader, HandsOnSeedThreadsAndHeldOutNames) {
  const StudyConfig study =
      Study(kLeast + "  - {name: dress, held_out: true}\nseed: 7\nthreads: 2\n").read();
  EXPECT_EQ(study.motions[0].name, "walk");  // of the file
  EXPECT_THAT(study.encode.held_out_motions, ElementsAre("leap"));
  ASSERT_TRUE(study.encode.held_out_designs);
  EXPECT_THAT(*study.encode.held_out_designs, ElementsAre("dress"));
  EXPECT_EQ(study.train.seed, 7u);
  EXPECT_EQ(study.train_design.seed, 7u);
  EXPECT_EQ(study.sample.seed, 7u);
  EXPECT_EQ(study.train.threads, 2);
  EXPECT_EQ(study.sample.threads, 2);
}

TEST(YamlReader, UnknownKeyNamesPlaceAndNearestKey) {
  struct Case {
    std::string text;
    int line;  // after kLeast
    std::string key, hint;
  };
  for (const Case& c : std::vector<Case>{
           {"threds: 2\n", 1, "threds", "did you mean `threads`?"},
           {"seed: 1\nfabric:\n  friction: 0.3\n  densty_kg_per_m2: 0.1\n", 4,
            "fabric.densty_kg_per_m2", "did you mean `density_kg_per_m2`?"},
           {"simulation:\n  solver: {residul: 0.1}\n", 2, "simulation.solver.residul",
            "`residual`"},
           {"  - {nam: dress}\n", 1, "designs[1].nam", "`name`"},
           {"garment: {thickness_m: 1}\n", 1, "garment.thickness_m", "known: vertices"},
           {"designs_: 1\n", 1, "designs_", "`designs`"}}) {
    const Study study(kLeast + c.text);
    EXPECT_INPUT_ERROR(study.read(), study.at(kLeastLines + c.line), c.key + " is no known key",
                       c.hint);
  }
}

TEST(YamlReader, RefusesAKeyGivenTwice) {
  const Study study(kLeast + "seed: 1\nseed: 2\n");
  EXPECT_INPUT_ERROR(study.read(), study.at(kLeastLines + 2), "seed", "twice");
}

TEST(YamlReader, WrongTypeNamesPlaceKeyAndWhatIsExpected) {
  struct Case {
    std::string text, key, expected;
  };
  for (const Case& c :
       std::vector<Case>{{"fabric: {friction: much}", "fabric.friction = much", "a number"},
                         {"fabric: {friction: [1]}", "fabric.friction", "a number"},
                         {"fabric: {friction: [1, 2, 3]}", "fabric.friction", "[low, high]"},
                         {"fabric: {friction: [1, x]}", "fabric.friction[1] = x", "a number"},
                         {"fabric: {friction: {low: 1}}", "fabric.friction", "a number"},
                         {"fabric: {friction: }", "fabric.friction", "a number"},
                         {"threads: 1.5", "threads = 1.5", "a whole number"},
                         {"threads: 99999999999", "threads = 99999999999", "a whole number"},
                         {"seed: -1", "seed = -1", "a whole number >= 0"},
                         {"motion: {ground: 2}", "motion.ground = 2", "true or false"},
                         {"encode: {dtype: {a: 1}}", "encode.dtype", "a text"},
                         {"fabric: 3", "fabric", "not a map"},
                         {"fabric: ~", "fabric", "not a map"},
                         {"shapes: 3", "shapes", "not a list"},
                         {"shapes: [1, 2]", "shapes[0]", "not a list"},
                         {"shapes: [[1, x]]", "shapes[0][1] = x", "a number"}}) {
    const Study study(kLeast + c.text + "\n");
    EXPECT_INPUT_ERROR(study.read(), study.at(kLeastLines + 1), c.key, c.expected);
  }
}

TEST(YamlReader, WrongValueNamesPlaceAndKey) {
  for (const auto& [text, key] : std::vector<std::pair<std::string, std::string>>{
           {"threads: -1", "threads"},
           {"garment: {vertices: 3}", "garment.vertices"},
           {"shapes: [[0, 7]]", "shapes"},
           {"shapes: [[.nan]]", "shapes"},
           {"shapes: []", "shapes"},
           {"motion: {frame_rate_hz: 0}", "motion.frame_rate_hz"},
           {"fabric: {friction: -0.1}", "fabric.friction"},
           {"fabric: {density_kg_per_m2: .nan}", "fabric.density_kg_per_m2"},
           {"fabric: {density_kg_per_m2: [0.1, .inf]}", "fabric.density_kg_per_m2"},
           {"fabric: {friction: [0.5, 0.3]}", "fabric.friction"},
           {"fabric: {membrane: rubber}", "fabric.membrane"},
           {"simulation: {ease_deg: 0}", "simulation.ease_deg"},
           {"simulation: {solver: {residual: 2}}", "simulation.solver.residual"},
           {"simulation: {contact: {barrier_Pa: 0}}", "simulation.contact.barrier_Pa"},
           {"simulation: {accept: {strain_95: 0}}", "simulation.accept.strain_95"},
           {"encode: {texture_size: 4}", "encode.texture_size"},
           {"encode: {fill: paint}", "encode.fill"},
           {"train: {batch_size: 0}", "train.batch_size"},
           {"train_design: {steps: 0}", "train_design.steps"},
           {"sample: {ddim_steps: 0}", "sample.ddim_steps"},
           {"sample_rows: {train: -1}", "sample_rows"},
           {"evaluate: {plausibility_stride: -1}", "evaluate.plausibility_stride"},
           {"report: {frames: 0}", "report.frames"}}) {
    SCOPED_TRACE(text);
    const Study study(kLeast + text + "\n");
    EXPECT_INPUT_ERROR(study.read(), study.at(kLeastLines + 1), key);
  }
  const Study study(kLeast + "  - {name: cape, length: 1.5}\n");
  EXPECT_INPUT_ERROR(study.read(), study.path, "cape", "length = 1.5");
  const Study motion(kLeast + "motion:\n  ground: true\n  frame_rate_hz: -3\n");
  EXPECT_INPUT_ERROR(motion.read(), motion.at(kLeastLines + 3), "motion.frame_rate_hz = -3");
}

TEST(YamlReader, NamesWhatIsMissing) {
  for (const auto& [text, key] : std::vector<std::pair<std::string, std::string>>{
           {"seed: 1\n", "output"},
           {"output: out\n", "body.file"},
           {"output: out\nbody: {file: b.npz}\n", "motions"},
           {"output: out\nbody: {file: b.npz}\nmotions: [{name: walk}]\ndesigns: [{}]\n",
            "motions"},
           {"output: out\nbody: {file: b.npz}\nmotions: [{file: w.npz}]\n", "designs"}}) {
    const Study study(text);
    EXPECT_INPUT_ERROR(study.read(), study.path, key);
  }
}

TEST(YamlReader, RefusesFilesThatAreNoStudy) {
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"", "is empty"},
      {"# nothing but a comment\n", "is empty"},
      {"output: [1, 2\n", "not valid YAML"},
      {"output: out\n\tseed: 1\n", "not valid YAML"},
      {"a: &b {c: *d}\n", "not valid YAML"},
      {std::string(5000, '['), "not valid YAML"},
      {"just words\n", "not a map"},
      {"- output\n", "not a map"},
      {"[1]: 2\n", "no known key"},
      {std::string("\x89PNG\r\n\x1a\n\0\0\0\r", 12), ""}};
  for (const auto& [text, what] : cases) {
    const Study study(text);
    EXPECT_INPUT_ERROR(study.read(), study.path, what);
  }
  const Scratch scratch;
  EXPECT_INPUT_ERROR(read_study(scratch.path("absent.yaml")), "absent.yaml", "cannot be read");
  std::filesystem::create_directory(scratch.path("folder.yaml"));
  EXPECT_INPUT_ERROR(read_study(scratch.path("folder.yaml")), "folder.yaml", "cannot be read");
}

TEST(YamlReader, TakesDesignsFromAFile) {
  const std::string kOthers =
      "output: out\nbody: {file: b.npz}\nmotions: [{file: w.npz}]\ndesigns: ";
  const StudyConfig paper =
      Study(kOthers + "{file: " PLEAT_SOURCE_DIR "/configs/designs_paper.yaml}\n").read();
  EXPECT_EQ(paper.designs.size(), 17u);  // paper, section 5.1
  EXPECT_EQ(paper.encode.held_out_designs->size(), 6u);

  const Scratch scratch;
  const std::string designs = scratch.path("designs.yaml");
  const Study study(kOthers + "{file: " + designs + "}\n");
  EXPECT_INPUT_ERROR(study.read(), designs, "cannot be read");
  write_bytes(designs, "designs:\n  - {name: tee}\n  - {name: dress, lenght: 1}\n");
  EXPECT_INPUT_ERROR(study.read(), designs + ":3: ", "designs[1].lenght", "`length`");
  write_bytes(designs, "designs: [\n");
  EXPECT_INPUT_ERROR(study.read(), designs + ":", "not valid YAML");
  write_bytes(designs, "designs: {file: " + designs + "}\n");
  EXPECT_INPUT_ERROR(study.read(), designs);  // no circle
  const Study typo(kOthers + "{fiel: a.yaml}\n");
  EXPECT_INPUT_ERROR(typo.read(), typo.at(4), "designs.fiel", "`file`");
  const Study none(kOthers + "{}\n");
  EXPECT_INPUT_ERROR(none.read(), none.at(4), "designs", "`file:`");
}

TEST(YamlReader, SettingsOfAStageAreThoseItDependsOn) {
  const StudyConfig study = Study(kLeast).read();
  StudyConfig other = study;
  other.simulation.accept.min_gap_m = 0.002;
  EXPECT_NE(simulation_settings(other), simulation_settings(study));
  EXPECT_EQ(encode_settings(other), encode_settings(study));
  other = study;
  other.designs[0].is_held_out = true;
  EXPECT_EQ(simulation_settings(other), simulation_settings(study));
  EXPECT_NE(encode_settings(other), encode_settings(study));
  other = study;
  other.encode.held_out_motions.clear();
  EXPECT_NE(encode_settings(other), encode_settings(study));
  other = study;
  other.seed = 9;
  EXPECT_NE(train_settings(other), train_settings(study));
  other = study;
  other.threads = 9;  // changes no bit
  EXPECT_EQ(train_settings(other), train_settings(study));
  body::MotionConfig cut = study.motion;
  cut.start_s = 0.5;
  EXPECT_NE(motion_settings(cut), motion_settings(study.motion));
}

}  // namespace
}  // namespace pleat::app
