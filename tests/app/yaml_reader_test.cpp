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

// A study of which one list is given by `text`.
std::string study_with(const std::string& list, const std::string& text) {
  std::string study = "output: out\nbody: {file: b.npz}\n";
  if (list != "motions") study += "motions: [{file: w.npz}]\n";
  if (list != "designs") study += "designs: [{name: tee}]\n";
  return study + list + ": " + text + "\n";
}

TEST(YamlReader, TakesDesignsAndShapesFromGrids) {
  const StudyConfig designs =
      Study(study_with("designs", "{grid: {length: [0.3, 1], cleavage: [0, 0.5]}}")).read();
  ASSERT_EQ(designs.designs.size(), 4u);
  EXPECT_EQ(designs.designs[1].name, "l0.3_s0.25_c0.5");
  EXPECT_EQ(designs.designs[1].sleeve, garment::Design{}.sleeve);
  EXPECT_TRUE(designs.encode.held_out_designs->empty());
  const StudyConfig shapes = Study(study_with("shapes", "{grid: {betas: [[-2, 2], [1]]}}")).read();
  EXPECT_THAT(shapes.shapes, ElementsAre(ElementsAre(-2, 1), ElementsAre(2, 1)));
}

TEST(YamlReader, DrawsDesignsAndShapesByTheSeedWhereverItStands) {
  const std::string designs = "{random: {count: 4, length: [0.5, 1], sleeve: 0.3, held_out: 1}}";
  const std::string shapes = "{random: {count: 3, betas: 2, sigma: 0.5, limit: 1}}";
  const std::string text = study_with("designs", designs) + "shapes: " + shapes + "\n";
  const StudyConfig before = Study("seed: 7\n" + text).read();
  const StudyConfig after = Study(text + "seed: 7\n").read();
  const StudyConfig other = Study(text + "seed: 8\n").read();
  ASSERT_EQ(before.designs.size(), 4u);
  ASSERT_EQ(before.shapes.size(), 3u);
  EXPECT_EQ(to_yaml(after), to_yaml(before));
  for (int k = 0; k < 4; ++k) {
    EXPECT_NE(other.designs[k].length, before.designs[k].length);
    EXPECT_GE(before.designs[k].length, 0.5);
    EXPECT_EQ(before.designs[k].sleeve, 0.3);
  }
  EXPECT_NE(other.shapes, before.shapes);
  EXPECT_THAT(*before.encode.held_out_designs, ElementsAre("random_0"));
}

TEST(YamlReader, TakesMotionsFromAFolder) {
  const Scratch scratch;
  const std::string folder = scratch.path("amass");
  std::filesystem::create_directories(folder + "/CMU/01");
  for (const std::string file : {"/CMU/01/run.npz", "/CMU/01/shape.npz", "/walk.bvh"})
    write_bytes(folder + file, "");
  const std::string text = "{folder: " + folder + ", held_out: [walk]}";
  const StudyConfig study = Study(study_with("motions", text)).read();
  ASSERT_EQ(study.motions.size(), 2u);
  EXPECT_EQ(study.motions[0].name, "CMU/01/run");
  EXPECT_EQ(study.motions[0].file, folder + "/CMU/01/run.npz");
  EXPECT_THAT(study.encode.held_out_motions, ElementsAre("walk"));
}

TEST(YamlReader, EffectiveConfigurationListsWhatWasMade) {
  std::string text = study_with("designs", "{random: {count: 20, held_out: 3}}") +
                     "shapes: {random: {count: 20, betas: 4}}\nseed: 5\n";
  const std::string list = "motions: [{file: w.npz}]\n";
  std::string config;
  StudyConfig study;
  {
    const Scratch scratch;
    write_bytes(scratch.path("a b.bvh"), "");
    write_bytes(scratch.path("1.50.npz"), "");
    text.replace(text.find(list), list.size(),
                 "motions: {folder: " + scratch.path("") + ", held_out: ['1.50']}\n");
    study = Study(text).read();
    config = to_yaml(study);
  }  // neither folder nor draws are needed from here on
  for (const std::string key : {"random:", "folder:", "count:", "sigma:"})
    EXPECT_EQ(config.find(key), std::string::npos) << key;
  const StudyConfig again = Study(config).read();
  EXPECT_EQ(to_yaml(again), config);
  EXPECT_EQ(again.shapes, study.shapes);
  ASSERT_EQ(again.designs.size(), 20u);
  for (int k = 0; k < 20; ++k) {
    EXPECT_EQ(again.designs[k].name, study.designs[k].name);
    EXPECT_EQ(again.designs[k].length, study.designs[k].length);
    EXPECT_EQ(again.designs[k].is_held_out, k < 3);
  }
  ASSERT_EQ(again.motions.size(), 2u);
  EXPECT_EQ(again.motions[0].name, "1.50");
  EXPECT_EQ(again.motions[1].file, study.motions[1].file);
  EXPECT_EQ(again.encode.held_out_motions, study.encode.held_out_motions);
  EXPECT_EQ(again.encode.held_out_designs, study.encode.held_out_designs);
}

TEST(YamlReader, WrongListNamesPlaceAndKey) {
  const Scratch scratch;
  write_bytes(scratch.path("walk.bvh"), "");
  const std::string folder = scratch.path("");
  struct Case {
    std::string list, text;
    int line;  // after the first of the list
    std::vector<std::string> parts;
  };
  for (const Case& c : std::vector<Case>{
           {"designs", "{}", 0, {"designs needs a list", "`file:`", "`grid:`", "`random:`"}},
           {"designs", "{grid: {}, random: {count: 1}}", 0, {"designs needs", "one of"}},
           {"designs", "{file: a.yaml, grid: {}}", 0, {"designs needs", "one of"}},
           {"designs", "{grd: {}}", 0, {"designs.grd", "`grid`"}},
           {"designs", "{grid: {lenght: [1]}}", 0, {"designs.grid.lenght", "`length`"}},
           {"designs", "{grid: 3}", 0, {"designs.grid", "not a map"}},
           {"designs", "{grid: {length: 1}}", 0, {"designs.grid.length", "not a list"}},
           {"designs", "{grid: {length: [x]}}", 0, {"designs.grid.length[0] = x", "a number"}},
           {"designs", "\n  grid:\n    sleeve: [0, 2]", 2, {"designs.grid.sleeve = 2", "0 .. 1"}},
           {"designs", "\n  random:\n    count: 0", 2, {"designs.random.count = 0", "1 .. 100000"}},
           {"designs", "\n  random:\n    sleeve: [0, 1]", 2, {"designs.random.count = 0"}},
           {"designs", "{random: {count: 1.5}}", 0, {"designs.random.count = 1.5", "whole"}},
           {"designs", "{random: {count: 2, sigma: 1}}", 0, {"designs.random.sigma", "known"}},
           {"designs", "{random: {count: 2, length: [1, 0]}}", 0, {"designs.random.length"}},
           {"shapes", "{}", 0, {"shapes needs a list", "`grid:`", "`random:`"}},
           {"shapes", "{grid: {}}", 0, {"shapes.grid.betas", "empty"}},
           {"shapes", "{grid: {betas: [1, 2]}}", 0, {"shapes.grid.betas[0]", "not a list"}},
           {"shapes", "{grid: {betas: {grid: {betas: [[1]]}}}}", 0, {"grid.betas", "not a list"}},
           {"shapes", "\n  grid:\n    betas: [[0], [9]]", 2, {"shapes.grid.betas[1] = 9"}},
           {"shapes", "{random: {count: 2}}", 0, {"shapes.random.betas = 0", "1 .. "}},
           {"shapes", "{random: {count: 2, beta: 2}}", 0, {"shapes.random.beta", "`betas`"}},
           {"shapes", "{random: {count: 2, betas: 2, limit: 9}}", 0, {"shapes.random.limit = 9"}},
           {"shapes", "{file: a.yaml}", 0, {"shapes.file", "known: grid, random"}},
           {"motions", "[]", 0, {"motions: the list is empty"}},
           {"motions", "{}", 0, {"motions needs a list", "`folder:`"}},
           {"motions", "{foldr: x}", 0, {"motions.foldr", "`folder`"}},
           {"motions", "{folder: " + folder + "x}", 0, {"motions.folder: ", "No such file"}},
           {"motions", "\n  held_out: [leap]\n  folder: " + folder, 1, {"no motion 'leap'"}},
           {"designs", "[]", 0, {"designs: the list is empty"}},
           {"shapes", "[]", 0, {"shapes: the list is empty"}}}) {
    SCOPED_TRACE(c.list + ": " + c.text);
    const Study study(study_with(c.list, c.text));
    const int line = (c.list == "shapes" ? 5 : 4) + c.line;
    for (const std::string& part : c.parts) EXPECT_INPUT_ERROR(study.read(), study.at(line), part);
  }
}

TEST(YamlReader, RefusesAListWithoutEnd) {
  std::string shapes = "[";
  for (int k = 0; k < 100001; ++k) shapes += "[],";
  const Study study(study_with("shapes", shapes + "]"));
  EXPECT_INPUT_ERROR(study.read(), study.at(5), "shapes has 100001 items", "at most 100000");
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
