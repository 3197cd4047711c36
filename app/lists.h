// Ways to give a study's lists other than item by item: grids, random draws, folders.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "app/study.h"

namespace pleat::app {

constexpr int64_t kMostItems = 100000;     // of one list
constexpr int64_t kMostNumbers = 1000000;  // betas of all shapes together

struct DesignGrid {  // `designs.grid`: every combination; an axis not given keeps its default
  std::vector<double> length = {garment::Design{}.length};
  std::vector<double> sleeve = {garment::Design{}.sleeve};
  std::vector<double> cleavage = {garment::Design{}.cleavage};
};

struct RandomDesigns {  // `designs.random`: uniform within the ranges
  int count = 0;
  garment::Range length{0, 1}, sleeve{0, 1}, cleavage{0, 1};
  int held_out = 0;  // so many from the first on: they stay the same when count grows
};

struct ShapeGrid {                         // `shapes.grid`: every combination
  std::vector<std::vector<double>> betas;  // the values of the first beta, of the second, ...
};

struct RandomShapes {  // `shapes.random`: normal, mean 0, drawn again beyond the limit
  int count = 0;
  int betas = 0;  // of each shape
  double sigma = 1;
  double limit = 2;  // of |beta|
};

struct MotionFolder {  // `motions` as a map
  std::string folder;
  std::vector<std::string> held_out;  // names
};

// The lists they stand for. InputError naming the key. Grids: the last axis changes fastest. Random
// items have one stream each, "design/k" or "shape/k": item k does not depend on the count.
std::vector<garment::Design> designs_of(const DesignGrid& grid);
std::vector<garment::Design> designs_of(const RandomDesigns& random, uint64_t seed);
std::vector<std::vector<double>> shapes_of(const ShapeGrid& grid);
std::vector<std::vector<double>> shapes_of(const RandomShapes& random, uint64_t seed);

// Every .bvh and .npz below the folder that can be a motion, sorted by name: its path from there
// without the ending, such as "CMU/01/01_01_poses". Linked folders are not entered.
std::vector<MotionEntry> motions_of(const MotionFolder& folder);

}  // namespace pleat::app
