// Datasets, clips and garments in HDF5.
#include "encode/dataset.h"
#include "garment/clip.h"
#include "garment/garment_file.h"
#include "tests/fuzz/input_file.h"

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::string path = pleat::fuzz::write_input(data, size, ".h5");
  pleat::fuzz::load([&] { pleat::encode::Dataset(path).texture(0); });
  pleat::fuzz::load([&] { pleat::garment::read_clip(path); });
  pleat::fuzz::load([&] { pleat::garment::read_garment(path); });
  return 0;
}
