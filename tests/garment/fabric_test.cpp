#include "garment/fabric.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>

#include "garment/fabric_file.h"
#include "tests/core/input_error.h"
#include "tests/core/scratch.h"

namespace pleat::garment {
namespace {

using Json = nlohmann::json;

Json good_file() {
  Json json;
  json["density"] = 0.2;
  json["stretching"] = Json::array();
  for (int r = 0; r < 6; ++r) json["stretching"].push_back({20 + r, -3, 60 + r, 10});
  json["bending"] = Json::array();
  for (int r = 0; r < 3; ++r) json["bending"].push_back({1e-5, 2e-5, 3e-5, 4e-5, 5e-5});
  return json;
}

std::string written(const Scratch& scratch, const std::string& text) {
  const std::string path = scratch.path("cloth.json");
  write_bytes(path, text);
  return path;
}

FabricConfig measured(const std::string& file) {
  FabricConfig config;
  config.file = file;
  return config;
}

FabricConfig completed(FabricConfig config) {
  complete(config);
  validate(config);
  return config;
}

TEST(Fabric, RefusesWhatNoClothHas) {
  validate(FabricConfig{});
  const auto with = [](std::optional<Range> FabricConfig::*key, const Range& value) {
    FabricConfig config;
    config.*key = value;
    return config;
  };
  EXPECT_INPUT_ERROR(validate(with(&FabricConfig::density_kg_per_m2, 0)),
                     "fabric.density_kg_per_m2 = 0", "> 0");
  EXPECT_INPUT_ERROR(validate(with(&FabricConfig::youngs_modulus_N_per_m, -1)),
                     "fabric.youngs_modulus_N_per_m");
  EXPECT_INPUT_ERROR(validate(with(&FabricConfig::poisson_ratio, 0.5)), "fabric.poisson_ratio");
  EXPECT_INPUT_ERROR(validate(with(&FabricConfig::bending_N_m, -1)), "fabric.bending_N_m");
  EXPECT_INPUT_ERROR(
      validate(with(&FabricConfig::friction, std::numeric_limits<double>::infinity())),
      "fabric.friction");
  EXPECT_INPUT_ERROR(validate(with(&FabricConfig::friction, {0.5, 0.3})), "fabric.friction",
                     "lower");
  EXPECT_INPUT_ERROR(validate(with(&FabricConfig::density_kg_per_m2, {0, 0.3})),
                     "fabric.density_kg_per_m2 = 0");
  EXPECT_INPUT_ERROR(validate(with(&FabricConfig::poisson_ratio, {0.2, 0.6})),
                     "fabric.poisson_ratio = 0.6");
  FabricConfig config;
  config.membrane = "rubber";
  EXPECT_INPUT_ERROR(validate(config), "fabric.membrane = rubber", "stvk", "neo_hookean");
  config = {};
  config.bending_scale = {0, 2};
  EXPECT_INPUT_ERROR(validate(config), "fabric.bending_scale");
}

TEST(Fabric, DefaultsAreTheFabricsOwn) {
  const Fabric fabric = middle_fabric(completed({})), standard;
  EXPECT_EQ(to_text(fabric), to_text(standard));
  EXPECT_EQ(fabric.bending_N_m, standard.bending_N_m);
  EXPECT_EQ(fabric.friction, standard.friction);
  EXPECT_FALSE(fabric.tables);
}

TEST(Fabric, TextTellsFabricsApart) {
  std::set<std::string> texts;
  Fabric fabric;
  texts.insert(to_text(fabric));
  fabric.friction += 1e-16;
  texts.insert(to_text(fabric));
  fabric.membrane = MembraneModel::kNeoHookean;
  texts.insert(to_text(fabric));
  fabric.tables = FabricTables{};
  texts.insert(to_text(fabric));
  fabric.tables->stretching[5][3] = 1e-300;
  texts.insert(to_text(fabric));
  fabric.tables->bending[2][4] = 1e-300;
  texts.insert(to_text(fabric));
  EXPECT_EQ(texts.size(), 6u);
}

TEST(Fabric, RangesAreDrawnEvenlyAndReproducibly) {
  FabricConfig config;
  config.density_kg_per_m2 = Range(0.1, 0.3);
  config.bending_N_m = Range(1e-6, 1e-5);
  config = completed(config);
  EXPECT_DOUBLE_EQ(middle_fabric(config).density_kg_per_m2, 0.2);
  double sum = 0, together = 0;
  constexpr int kChains = 2000;
  for (int i = 0; i < kChains; ++i) {
    const std::string chain = "walk/tee/" + std::to_string(i);
    const Fabric drawn = draw_fabric(config, 7, chain);
    EXPECT_EQ(to_text(drawn), to_text(draw_fabric(config, 7, chain)));
    EXPECT_GE(drawn.density_kg_per_m2, 0.1);
    EXPECT_LT(drawn.density_kg_per_m2, 0.3);
    EXPECT_EQ(drawn.friction, Fabric{}.friction);
    sum += drawn.density_kg_per_m2;
    together += (drawn.density_kg_per_m2 - 0.2) / 0.2 * (drawn.bending_N_m - 5.5e-6) / 9e-6;
  }
  // Four standard errors of the mean of a uniform number, and of the product of two.
  EXPECT_NEAR(sum / kChains, 0.2, 4 * 0.2 / std::sqrt(12.0 * kChains));
  EXPECT_NEAR(together / kChains, 0, 4.0 / 12 / std::sqrt(kChains));
  EXPECT_NE(to_text(draw_fabric(config, 8, "walk/tee")),
            to_text(draw_fabric(config, 7, "walk/tee")));
  EXPECT_NE(to_text(draw_fabric(config, 7, "walk/cape")),
            to_text(draw_fabric(config, 7, "walk/tee")));
  // Another range changes no number but its own.
  FabricConfig more = config;
  more.friction = Range(0.2, 0.6);
  const Fabric before = draw_fabric(config, 7, "walk/tee"),
               after = draw_fabric(more, 7, "walk/tee");
  EXPECT_EQ(before.density_kg_per_m2, after.density_kg_per_m2);
  EXPECT_EQ(before.bending_N_m, after.bending_N_m);
  EXPECT_NE(before.friction, after.friction);
}

TEST(Fabric, ScalesStiffness) {
  const Scratch scratch;
  FabricConfig config;
  config.stretching_scale = 2;
  config.bending_scale = 3;
  Fabric fabric = middle_fabric(completed(config));
  EXPECT_DOUBLE_EQ(fabric.youngs_modulus_N_per_m, 2 * Fabric{}.youngs_modulus_N_per_m);
  EXPECT_DOUBLE_EQ(fabric.bending_N_m, 3 * Fabric{}.bending_N_m);
  config.file = written(scratch, good_file().dump());
  fabric = middle_fabric(completed(config));
  ASSERT_TRUE(fabric.tables);
  EXPECT_DOUBLE_EQ(fabric.tables->stretching[5][2], 2 * 65);
  EXPECT_DOUBLE_EQ(fabric.tables->bending[1][4], 3 * 5e-5);
}

TEST(FabricFile, GivesDensityAndTables) {
  const Scratch scratch;
  Json json = good_file();
  json["damping"] = 0.01;
  json["source"] = "a test";
  const std::string path = written(scratch, "// jeans\n" + json.dump());
  FabricConfig config = completed(measured(path));
  Fabric fabric = middle_fabric(config);
  EXPECT_EQ(fabric.density_kg_per_m2, 0.2);
  EXPECT_EQ(fabric.friction, Fabric{}.friction);
  ASSERT_TRUE(fabric.tables);
  EXPECT_EQ(fabric.tables->stretching[3], (std::array<double, 4>{23, -3, 63, 10}));
  EXPECT_EQ(fabric.tables->bending[2], (std::array<double, 5>{1e-5, 2e-5, 3e-5, 4e-5, 5e-5}));
  // What is given beside the file counts.
  config = measured(path);
  config.density_kg_per_m2 = 0.31;
  config.friction = Range(0.1, 0.2);
  fabric = draw_fabric(completed(config), 1, "walk");
  EXPECT_EQ(fabric.density_kg_per_m2, 0.31);
  EXPECT_LT(fabric.friction, 0.2);
}

TEST(FabricFile, MultipliersScale) {
  const Scratch scratch;
  Json json = good_file();
  json["thicken"] = 2;
  json["density_mult"] = 1.5;
  json["stretching_mult"] = 3;
  json["bending_mult"] = 0.5;
  const MeasuredFabric fabric = read_fabric_file(written(scratch, json.dump()));
  EXPECT_DOUBLE_EQ(fabric.density_kg_per_m2, 0.2 * 1.5 * 2);
  EXPECT_DOUBLE_EQ(fabric.tables.stretching[0][0], 20 * 3 * 2);
  EXPECT_DOUBLE_EQ(fabric.tables.bending[0][0], 1e-5 * 0.5 * 2);
}

TEST(FabricFile, RefusesHostileFiles) {
  const Scratch scratch;
  const auto refused = [&](const auto& spoil, std::initializer_list<std::string> parts) {
    Json json = good_file();
    spoil(json);
    const std::string path = written(scratch, json.dump());
    expect_input_error([&] { read_fabric_file(path); }, parts, "read_fabric_file", __FILE__,
                       __LINE__);
  };
  refused([](Json& j) { j.erase("density"); }, {"cloth.json", "density: missing"});
  refused([](Json& j) { j.erase("stretching"); }, {"stretching: missing"});
  refused([](Json& j) { j.erase("bending"); }, {"bending: missing"});
  refused([](Json& j) { j["density"] = 0; }, {"density = 0", "> 0"});
  refused([](Json& j) { j["density"] = "light"; }, {"density: is not a number"});
  refused([](Json& j) { j["density"] = {0.1, 0.2}; }, {"density: is not a number"});
  refused([](Json& j) { j["density"] = nullptr; }, {"density: is not a number"});
  refused([](Json& j) { j["stretching"] = 3; }, {"stretching", "6 lists of 4 numbers"});
  refused([](Json& j) { j["stretching"].erase(5); }, {"stretching", "6 lists of 4 numbers"});
  refused([](Json& j) { j["stretching"][2] = 3; }, {"stretching[2]", "6 lists of 4 numbers"});
  refused([](Json& j) { j["stretching"][2].push_back(1); }, {"stretching[2]"});
  refused([](Json& j) { j["stretching"][2][1] = "soft"; }, {"stretching[2][1]"});
  refused([](Json& j) { j["stretching"][2][0] = 0; }, {"stretching[2][0] = 0", "> 0"});
  refused([](Json& j) { j["stretching"][0][3] = -1; }, {"stretching[0][3] = -1", "> 0"});
  refused([](Json& j) { j["stretching"][4][2] = 1e300; }, {"stretching[4][2] = 1e+300"});
  refused([](Json& j) { j["bending"].push_back(j["bending"][0]); },
          {"bending", "3 lists of 5 numbers"});
  refused([](Json& j) { j["bending"][1][4] = -1e-6; }, {"bending[1][4] = -1e-06", ">= 0"});
  refused([](Json& j) { j["bending"][1][4] = true; }, {"bending[1][4]"});
  refused([](Json& j) { j["thicken"] = 0; }, {"thicken = 0", "> 0"});
  refused([](Json& j) { j["strething_mult"] = 2; }, {"strething_mult", "no known key"});
  refused([](Json& j) { j = Json::array({1, 2}); }, {"cloth.json", "not a map"});
  for (const std::string& text :
       {std::string("{\"density\": 1e999}"), std::string("{\"density\": nan}"), std::string(""),
        std::string("{\"density\": 0.1"), std::string(100000, '['), std::string("\xff\xfe\0{", 4)})
    EXPECT_INPUT_ERROR(read_fabric_file(written(scratch, text)), "cloth.json", "not valid JSON");
  EXPECT_INPUT_ERROR(read_fabric_file(written(scratch, std::string(2 << 20, ' '))), "cloth.json",
                     "larger");
  EXPECT_INPUT_ERROR(read_fabric_file(scratch.path("absent.json")), "absent.json",
                     "cannot be read");
  std::filesystem::create_directory(scratch.path("folder.json"));
  EXPECT_INPUT_ERROR(read_fabric_file(scratch.path("folder.json")), "folder.json",
                     "cannot be read");
  EXPECT_INPUT_ERROR(completed(measured(scratch.path("absent.json"))),
                     "fabric.file: ", "absent.json");
}

TEST(FabricFile, AMeasuredFabricTakesNoModulus) {
  const Scratch scratch;
  const std::string path = written(scratch, good_file().dump());
  for (auto key : {&FabricConfig::youngs_modulus_N_per_m, &FabricConfig::poisson_ratio,
                   &FabricConfig::bending_N_m}) {
    FabricConfig config = measured(path);
    config.*key = 0.1;
    EXPECT_INPUT_ERROR(complete(config), "fabric.file", "stretching_scale");
  }
  FabricConfig config = measured(path);
  config.membrane = "neo_hookean";
  EXPECT_INPUT_ERROR(complete(config), "fabric.file");
  config = measured(path);
  config.name = "gray_interlock";
  EXPECT_INPUT_ERROR(complete(config), "fabric.name", "not both");
}

TEST(ShippedFabrics, LoadByNameAndTellTheirSource) {
  int count = 0;
  for (const auto& file :
       std::filesystem::directory_iterator(PLEAT_SOURCE_DIR "/configs/fabrics")) {
    FabricConfig config;
    config.name = file.path().stem().string();
    SCOPED_TRACE(config.name);
    const Fabric fabric = middle_fabric(completed(config));
    ASSERT_TRUE(fabric.tables);
    EXPECT_GT(fabric.density_kg_per_m2, 0.05);  // kg/m^2, lawn to blanket
    EXPECT_LT(fabric.density_kg_per_m2, 0.5);
    const Json json = Json::parse(read_bytes(file.path().string()));
    EXPECT_GT(json["source"].get<std::string>().size(), 20u);
    ++count;
  }
  EXPECT_GE(count, 8);
  FabricConfig config;
  config.name = "grey_interlock";
  EXPECT_INPUT_ERROR(complete(config), "fabric.name", "'grey_interlock'", "gray_interlock");
  for (const std::string name : {"../quickstart", "gray_interlock.json", "/etc/passwd"}) {
    config.name = name;
    EXPECT_INPUT_ERROR(complete(config), "fabric.name", name);
  }
}

}  // namespace
}  // namespace pleat::garment
