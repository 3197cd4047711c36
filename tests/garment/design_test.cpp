#include "garment/design.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <regex>
#include <set>

#include "tests/core/input_error.h"

namespace pleat::garment {
namespace {

TEST(Design, GridHasThePapersAxes) {
  const std::vector<Design> grid = paper_grid();
  std::set<double> lengths, sleeves, cleavages;
  std::set<std::string> names;
  for (const Design& design : grid) {
    validate(design);
    lengths.insert(design.length);
    sleeves.insert(design.sleeve);
    cleavages.insert(design.cleavage);
    names.insert(design.name);
  }
  EXPECT_EQ(grid.size(), 168u);
  EXPECT_EQ(names.size(), 168u);
  EXPECT_EQ(lengths.size(), 7u);
  EXPECT_EQ(sleeves.size(), 6u);
  EXPECT_EQ(cleavages.size(), 4u);
  EXPECT_EQ(*lengths.begin(), 0);
  EXPECT_EQ(*lengths.rbegin(), 1);
}

TEST(Design, RefusesWhatIsOffItsAxes) {
  EXPECT_INPUT_ERROR(validate(Design{"tee", 1.2, 0, 0, false}), "tee", "length = 1.2", "0 .. 1");
  EXPECT_INPUT_ERROR(validate(Design{"tee", 0, -0.1, 0, false}), "tee", "sleeve");
  EXPECT_INPUT_ERROR(validate(Design{"tee", 0, 0, std::nan(""), false}), "tee", "cleavage");
}

TEST(Design, SeventeenOfTheGridAreInTheConfig) {
  std::ifstream file(PLEAT_SOURCE_DIR "/configs/designs_paper.yaml");
  const std::regex row(
      R"(\{name: (\w+),\s*length: ([\d.]+),\s*sleeve: ([\d.]+),\s*cleavage: ([\d.]+),\s*held_out: (true|false)\})");
  std::set<std::string> names;
  std::set<std::tuple<int, int, int>> places;
  std::set<int> trained_lengths, trained_sleeves, trained_cleavages;
  int held_out = 0;
  const auto step = [](const std::string& text, int steps) {
    const double place = std::stod(text) * steps;
    EXPECT_NEAR(place, std::round(place), 1e-5) << text;
    return static_cast<int>(std::lround(place));
  };
  for (std::string line; std::getline(file, line);) {
    std::smatch match;
    if (!std::regex_search(line, match, row)) continue;
    names.insert(match[1]);
    const int length = step(match[2], 6), sleeve = step(match[3], 5), cleavage = step(match[4], 3);
    places.insert({length, sleeve, cleavage});
    if (match[5] == "true") {
      ++held_out;
      continue;
    }
    trained_lengths.insert(length);
    trained_sleeves.insert(sleeve);
    trained_cleavages.insert(cleavage);
  }
  EXPECT_EQ(names.size(), 17u);
  EXPECT_EQ(places.size(), 17u);
  EXPECT_EQ(held_out, 6);
  EXPECT_EQ(trained_lengths.size(), 7u);
  EXPECT_EQ(trained_sleeves.size(), 6u);
  EXPECT_EQ(trained_cleavages.size(), 4u);
}

}  // namespace
}  // namespace pleat::garment
