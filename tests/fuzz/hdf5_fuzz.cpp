// Datasets, clips and garments in HDF5: whole files whose arrays and attributes are not what they
// should be. Bytes of the file itself are not changed: libhdf5 1.10 hangs or worse on some of
// those, whoever calls it (docs/files.md).
#include <hdf5.h>

#include <algorithm>
#include <cstring>
#include <fstream>
#include <iterator>
#include <vector>

#include "encode/dataset.h"
#include "garment/clip.h"
#include "garment/garment_file.h"
#include "tests/fuzz/input_file.h"

namespace {

// The input, read from the front; zeros behind its end.
struct Reader {
  const uint8_t* data;
  size_t size;
  uint8_t byte() {
    if (size == 0) return 0;
    --size;
    return *data++;
  }
  uint16_t word() { return static_cast<uint16_t>(byte() | byte() << 8); }
};

std::string seed(int which) {
  const char* names[] = {"dataset.h5", "clip.h5", "garment.h5"};
  std::ifstream stream(std::string(PLEAT_SOURCE_DIR "/tests/fuzz/hdf5_seeds/") + names[which],
                       std::ios::binary);
  const std::string bytes(std::istreambuf_iterator<char>(stream), {});
  if (bytes.empty()) std::abort();
  return bytes;
}

herr_t add_name(hid_t, const char* name, const H5O_info_t* info, void* names) {
  if (info->type == H5O_TYPE_DATASET)
    static_cast<std::vector<std::string>*>(names)->push_back(name);
  return 0;
}

// Numbers of the array where it stands.
void change_values(hid_t file, const std::string& name, Reader& input) {
  const hid_t array = H5Dopen2(file, name.c_str(), H5P_DEFAULT), type = H5Dget_type(array),
              space = H5Dget_space(array);
  const hssize_t count = H5Sget_simple_extent_npoints(space);
  if (count < (1 << 16) && H5Tget_class(type) != H5T_STRING && H5Tget_class(type) != H5T_VLEN) {
    std::vector<uint8_t> values(static_cast<size_t>(count) * H5Tget_size(type));
    if (!values.empty() &&
        H5Dread(array, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()) >= 0) {
      const size_t at = input.word() * size_t{7919} % values.size();
      for (size_t i = 0, changed = 1 + input.byte() % 16; i < changed; ++i)
        values[(at + i) % values.size()] = input.byte();
      H5Dwrite(array, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
    }
  }
  H5Sclose(space), H5Tclose(type), H5Dclose(array);
}

// Another type and shape; filled with the input.
void replace(hid_t file, const std::string& name, Reader& input) {
  H5Ldelete(file, name.c_str(), H5P_DEFAULT);
  const hid_t types[] = {H5T_STD_I8LE,  H5T_STD_U8LE,   H5T_STD_I16LE,  H5T_STD_I32LE,
                         H5T_STD_I64LE, H5T_IEEE_F32LE, H5T_IEEE_F64LE, H5T_STD_U64LE};
  const hid_t type = types[input.byte() % 8];
  hsize_t dims[4];
  const int rank = input.byte() % 5;
  hsize_t count = 1;
  for (int d = 0; d < rank; ++d) {
    dims[d] = input.byte() % 48;
    count *= dims[d];
  }
  if (count > 65536) return;
  // Or so large that it was never written.
  const bool is_huge = rank > 0 && input.byte() % 16 == 0;
  if (is_huge) dims[0] = hsize_t{1} << (input.byte() % 50);
  const hid_t space = rank == 0 ? H5Screate(H5S_SCALAR) : H5Screate_simple(rank, dims, nullptr);
  const hid_t creation = H5Pcreate(H5P_DATASET_CREATE);
  if (rank > 0) {
    hsize_t chunk[4] = {1, 1, 1, 1};
    H5Pset_chunk(creation, rank, chunk);
  }
  const hid_t array =
      H5Dcreate2(file, name.c_str(), type, space, H5P_DEFAULT, creation, H5P_DEFAULT);
  if (array >= 0 && count > 0 && count <= 64 && !is_huge) {
    std::vector<uint8_t> values(count * 8);
    for (uint8_t& value : values) value = input.byte();
    H5Dwrite(array, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
  }
  if (array >= 0) H5Dclose(array);
  H5Pclose(creation), H5Sclose(space);
}

// An attribute of the file or of the array, replaced or taken away.
void change_attribute(hid_t file, const std::string& object, Reader& input) {
  const hid_t owner = H5Oopen(file, object.c_str(), H5P_DEFAULT);
  H5O_info_t info;
  if (H5Oget_info(owner, &info) >= 0 && info.num_attrs > 0) {
    const hsize_t index = input.byte() % info.num_attrs;
    char name[128] = "";
    H5Aget_name_by_idx(owner, ".", H5_INDEX_NAME, H5_ITER_INC, index, name, sizeof name,
                       H5P_DEFAULT);
    H5Adelete(owner, name);
    const int what = input.byte() % 3;
    const hid_t space = H5Screate(H5S_SCALAR);
    if (what == 1) {
      double number;
      uint8_t bytes[sizeof number];
      for (uint8_t& byte : bytes) byte = input.byte();
      std::memcpy(&number, bytes, sizeof number);
      const hid_t attribute =
          H5Acreate2(owner, name, H5T_IEEE_F64LE, space, H5P_DEFAULT, H5P_DEFAULT);
      H5Awrite(attribute, H5T_NATIVE_DOUBLE, &number);
      H5Aclose(attribute);
    } else if (what == 2) {
      std::string text;
      for (size_t i = 0, count = input.byte() % 64; i < count; ++i)
        text += static_cast<char>(input.byte());
      const hid_t type = H5Tcopy(H5T_C_S1);
      H5Tset_size(type, H5T_VARIABLE);
      const hid_t attribute = H5Acreate2(owner, name, type, space, H5P_DEFAULT, H5P_DEFAULT);
      const char* pointer = text.c_str();
      H5Awrite(attribute, type, &pointer);
      H5Aclose(attribute), H5Tclose(type);
    }
    H5Sclose(space);
  }
  H5Oclose(owner);
}

}  // namespace

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static const std::string seeds[] = {seed(0), seed(1), seed(2)};
  Reader input{data, size};
  const int which = input.byte() % 3;
  const std::string path = pleat::fuzz::write_input(
      reinterpret_cast<const uint8_t*>(seeds[which].data()), seeds[which].size(), ".h5");
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
  std::vector<std::string> names;
  H5Ovisit(file, H5_INDEX_NAME, H5_ITER_INC, add_name, &names);
  for (int changes = 0; changes < 8 && input.size > 0; ++changes) {
    const int how = input.byte() % 4;
    const std::string& name = names[input.byte() % names.size()];
    if (H5Lexists(file, name.c_str(), H5P_DEFAULT) <= 0) continue;
    if (how == 0) change_values(file, name, input);
    if (how == 1) replace(file, name, input);
    if (how == 2) change_attribute(file, input.byte() % 2 ? "/" : name, input);
    if (how == 3 && changes == 0) H5Ldelete(file, name.c_str(), H5P_DEFAULT);
  }
  H5Fclose(file);
  if (which == 0) pleat::fuzz::load([&] { pleat::encode::Dataset(path).texture(0); });
  if (which == 1) pleat::fuzz::load([&] { pleat::garment::read_clip(path); });
  if (which == 2) pleat::fuzz::load([&] { pleat::garment::read_garment(path); });
  return 0;
}
