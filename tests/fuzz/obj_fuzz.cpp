// Users' meshes in OBJ.
#include "core/mesh_file.h"
#include "tests/fuzz/input_file.h"

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::string path = pleat::fuzz::write_input(data, size, ".obj");
  pleat::fuzz::load([&] { pleat::read_mesh(path); });
  return 0;
}
