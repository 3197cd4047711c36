// Motions in BVH.
#include "body/motion.h"
#include "tests/body/synthetic_body.h"
#include "tests/fuzz/input_file.h"

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static const pleat::body::BodyModel box = pleat::body::box_body();
  const std::string path = pleat::fuzz::write_input(data, size, ".bvh");
  pleat::fuzz::load([&] { pleat::body::load_motion(path, box, {}); });
  return 0;
}
