// The design of a garment: p = (length, sleeve, cleavage) in [0,1]^3 (paper, section 3).
#pragma once

#include <string>
#include <vector>

namespace pleat::garment {

struct Design {
  std::string name;
  double length = 0.3;       // 0 crop top .. 1 knee-length dress
  double sleeve = 0.25;      // 0 sleeveless .. 1 wrist
  double cleavage = 0.2;     // 0 high neck .. 1 deep
  bool is_held_out = false;  // not trained on
};
void validate(const Design& design);  // throws InputError naming the design and the number

// The paper's axes (section 5.1): 7 lengths x 6 sleeves x 4 cleavages, evenly spaced in [0,1].
std::vector<Design> paper_grid();

}  // namespace pleat::garment
