#include "garment/design.h"

#include <sstream>

#include "core/error.h"

namespace pleat::garment {
namespace {

void check(const Design& design, const char* key, double value) {
  if (value >= 0 && value <= 1) return;
  std::ostringstream message;
  message << "design '" << design.name << "': " << key << " = " << value << "; expected 0 .. 1";
  throw InputError(message.str());
}

}  // namespace

void validate(const Design& design) {
  check(design, "length", design.length);
  check(design, "sleeve", design.sleeve);
  check(design, "cleavage", design.cleavage);
}

std::vector<Design> paper_grid() {
  constexpr int kLengths = 7, kSleeves = 6, kCleavages = 4;
  std::vector<Design> grid;
  for (int i = 0; i < kLengths; ++i)
    for (int j = 0; j < kSleeves; ++j)
      for (int k = 0; k < kCleavages; ++k) {
        Design design;
        design.name = "l" + std::to_string(i) + "s" + std::to_string(j) + "c" + std::to_string(k);
        design.length = i / (kLengths - 1.0);
        design.sleeve = j / (kSleeves - 1.0);
        design.cleavage = k / (kCleavages - 1.0);
        grid.push_back(design);
      }
  return grid;
}

}  // namespace pleat::garment
