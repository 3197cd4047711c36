#include "core/hdf5_file.h"

#include <gtest/gtest.h>
#include <hdf5.h>

#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "tests/core/input_error.h"
#include "tests/core/scratch.h"

namespace pleat {
namespace {

TEST(Hdf5File, GivesBackWhatWasWritten) {
  const Scratch scratch;
  const Points3 points = Points3::Random(5, 3);
  const std::vector<int16_t> numbers = {-32768, 0, 1, 32767, 5, 6};
  {
    Hdf5File file = Hdf5File::create(scratch.path("a.h5"));
    file.write("garment/vertices", points);
    file.write("garment/rounded", points, Hdf5Type::kFloat32);
    file.write("garment/deep/numbers", numbers, {3, 2});
    file.write("garment/few", points.topRows(2).leftCols(2));
    file.write("names", std::vector<std::string>{"tee", "", "robe \xc3\xa0 plis"});
    file.write("none", std::vector<float>{}, {0, 7});
    const double single = 2.5;
    file.write("single", &single, {});
    file.commit();
  }
  const Hdf5File file = Hdf5File::open(scratch.path("a.h5"));
  EXPECT_EQ(file.read_matrix("garment/vertices"), points);
  EXPECT_EQ(file.read_matrix("garment/rounded"), points.cast<float>().cast<double>());
  EXPECT_EQ(file.read_matrix("garment/few"), points.topLeftCorner(2, 2));
  EXPECT_EQ(file.dims("garment/deep/numbers"), (Dims{3, 2}));
  EXPECT_EQ(file.read<int16_t>("garment/deep/numbers"), numbers);
  EXPECT_EQ(file.read<double>("garment/deep/numbers"),
            std::vector<double>(numbers.begin(), numbers.end()));
  EXPECT_EQ(file.read_texts("names"), (std::vector<std::string>{"tee", "", "robe \xc3\xa0 plis"}));
  EXPECT_EQ(file.dims("none"), (Dims{0, 7}));
  EXPECT_TRUE(file.read<float>("none").empty());
  EXPECT_EQ(file.dims("single"), Dims{});
  EXPECT_EQ(file.read<double>("single"), std::vector<double>{2.5});
  EXPECT_EQ(file.list("/"), (std::vector<std::string>{"garment", "names", "none", "single"}));
  EXPECT_EQ(file.list("garment"), (std::vector<std::string>{"deep", "few", "rounded", "vertices"}));
  EXPECT_TRUE(file.has("garment/deep"));
  EXPECT_TRUE(file.has("/garment/deep/numbers"));
  EXPECT_FALSE(file.has("garment/absent"));
  EXPECT_FALSE(file.has("absent/numbers"));
}

TEST(Hdf5File, WritesAndReadsRows) {
  const Scratch scratch;
  std::vector<float> frames(4 * 6);
  for (size_t k = 0; k < frames.size(); ++k) frames[k] = 0.5f * k;
  {
    Hdf5File file = Hdf5File::create(scratch.path("a.h5"));
    file.create_dataset("frames", {4, 2, 3}, Hdf5Type::kFloat32, 1, 4);
    file.write_rows("frames", 2, 2, frames.data() + 12);
    file.write_rows("frames", 0, 1, frames.data());
    std::vector<float> row(6);
    file.read_rows("frames", 3, 1, row.data());  // a file being written can be read too
    EXPECT_EQ(row, std::vector<float>(frames.begin() + 18, frames.end()));
    EXPECT_INPUT_ERROR(file.write_rows("frames", 3, 2, frames.data()), "'frames'", "rows 3 to 4");
    file.commit();
  }
  const Hdf5File file = Hdf5File::open(scratch.path("a.h5"));
  std::vector<double> rows(12);
  file.read_rows("frames", 1, 2, rows.data());
  EXPECT_EQ(std::vector<double>(rows.begin(), rows.begin() + 6), std::vector<double>(6, 0.0));
  EXPECT_EQ(std::vector<double>(rows.begin() + 6, rows.end()),
            std::vector<double>(frames.begin() + 12, frames.begin() + 18));
  EXPECT_INPUT_ERROR(file.read_rows("frames", -1, 1, rows.data()), "'frames'");
  EXPECT_INPUT_ERROR(file.read_rows("frames", 4, 1, rows.data()), "'frames'", "[4, 2, 3]");
  file.read_rows("frames", 4, 0, rows.data());  // nothing is always there
}

TEST(Hdf5File, KeepsAttributes) {
  const Scratch scratch;
  {
    Hdf5File file = Hdf5File::create(scratch.path("a.h5"));
    file.write("group/array", std::vector<double>{1}, {1});
    file.write_attribute("/", "config", "");
    file.write_attribute("/", "config", std::string(100000, 'x'));
    file.write_attribute("group", "schema_version", 1);
    file.write_attribute("group/array", "big", int64_t{1} << 40);
    file.write_attribute("group/array", "scale_m", 1.0 / 3);
    file.commit();
  }
  const Hdf5File file = Hdf5File::open(scratch.path("a.h5"));
  EXPECT_EQ(file.text_attribute("/", "config"), std::string(100000, 'x'));
  EXPECT_EQ(file.number_attribute("group", "schema_version"), 1);
  EXPECT_EQ(file.number_attribute("group/array", "big"), 0x1p40);
  EXPECT_EQ(file.number_attribute("group/array", "scale_m"), 1.0 / 3);
  EXPECT_TRUE(file.has_attribute("group", "schema_version"));
  EXPECT_FALSE(file.has_attribute("group", "unit"));
  EXPECT_FALSE(file.has_attribute("absent", "unit"));
  EXPECT_INPUT_ERROR(file.text_attribute("group", "unit"), "a.h5", "'unit'", "'group'", "missing");
  EXPECT_INPUT_ERROR(file.text_attribute("absent", "unit"), "'absent' is missing");
  EXPECT_INPUT_ERROR(file.text_attribute("group/array", "scale_m"), "'scale_m'", "not a text");
  EXPECT_INPUT_ERROR(file.number_attribute("/", "config"), "'config'", "not a number");
}

TEST(Hdf5File, IsNotThereBeforeCommit) {
  const Scratch scratch;
  {
    Hdf5File first = Hdf5File::create(scratch.path("a.h5"));
    first.write("x", std::vector<double>{1}, {1});
    Hdf5File file(std::move(first));
    EXPECT_FALSE(std::filesystem::exists(scratch.path("a.h5")));
    EXPECT_EQ(scratch.files().size(), 1u);  // the temporary one
  }
  EXPECT_TRUE(scratch.files().empty());  // given up, so removed
  Hdf5File file = Hdf5File::create(scratch.path("a.h5"));
  file.commit();
  EXPECT_EQ(scratch.files(), std::vector<std::string>{"a.h5"});
}

TEST(Hdf5File, KeepsTheOldFileUntilCommit) {
  const Scratch scratch;
  write_bytes(scratch.path("a.h5"), "old");
  Hdf5File file = Hdf5File::create(scratch.path("a.h5"));
  file.write("x", std::vector<double>{1}, {1});
  EXPECT_EQ(read_bytes(scratch.path("a.h5")), "old");
  file.commit();
  EXPECT_EQ(Hdf5File::open(scratch.path("a.h5")).read<double>("x"), std::vector<double>{1});
}

TEST(Hdf5File, GivesEqualBytesForEqualContent) {
  const Scratch scratch;
  const auto write = [&](const std::string& name) {
    Hdf5File file = Hdf5File::create(scratch.path(name));
    file.write("group/x", std::vector<double>{1, 2, 3}, {3});
    file.write("names", std::vector<std::string>{"a", "bc"});
    file.create_dataset("frames", {8, 16}, Hdf5Type::kInt16, 1, 1);
    const std::vector<int16_t> row(16, 7);
    for (int k = 0; k < 8; ++k) file.write_rows("frames", k, 1, row.data());
    file.write_attribute("/", "config", "text");
    file.write_attribute("group/x", "unit", "m");
    file.write_attribute("group", "n", 3.5);
    file.commit();
  };
  write("a.h5");
  ::sleep(1);  // HDF5 would note times in seconds
  std::vector<std::string> clutter(1000, std::string(5000, 'z'));  // other memory for its buffers
  write("b.h5");
  EXPECT_EQ(read_bytes(scratch.path("a.h5")), read_bytes(scratch.path("b.h5")));
}

TEST(Hdf5File, NamesFilesThatItCannotOpen) {
  const Scratch scratch;
  EXPECT_INPUT_ERROR(Hdf5File::open(scratch.path("none.h5")), "none.h5", "no such file");
  EXPECT_INPUT_ERROR(Hdf5File::open(scratch.path("")), "is not a file");
  write_bytes(scratch.path("text.h5"), "not at all");
  EXPECT_INPUT_ERROR(Hdf5File::open(scratch.path("text.h5")), "text.h5", "not an HDF5 file");
  EXPECT_INPUT_ERROR(Hdf5File::create(scratch.path("none/a.h5")), "none/a.h5",
                     "No such file or directory");
}

TEST(Hdf5File, RefusesEveryTruncation) {
  const Scratch scratch;
  {
    Hdf5File file = Hdf5File::create(scratch.path("a.h5"));
    file.write("x", std::vector<double>(500, 1.0), {500});
    file.write("names", std::vector<std::string>{"a", "bc"});
    file.commit();
  }
  const std::string bytes = read_bytes(scratch.path("a.h5"));
  for (size_t size = 0; size < bytes.size(); size += 97) {
    write_bytes(scratch.path("short.h5"), bytes.substr(0, size));
    EXPECT_INPUT_ERROR(Hdf5File::open(scratch.path("short.h5")), "short.h5");
  }
}

// Any damage is either harmless or an InputError: no crash, no huge allocation.
TEST(Hdf5File, SurvivesDamagedBytes) {
  const Scratch scratch;
  {
    Hdf5File file = Hdf5File::create(scratch.path("a.h5"));
    file.write("group/x", std::vector<double>(20, 1.0), {4, 5});
    file.write_attribute("group/x", "scale", 2.0);
    file.commit();
  }
  const std::string bytes = read_bytes(scratch.path("a.h5"));
  int refused = 0;
  for (size_t at = 0; at < bytes.size(); at += 13) {
    std::string damaged = bytes;
    damaged[at] = static_cast<char>(damaged[at] ^ 0x7F);
    write_bytes(scratch.path("b.h5"), damaged);
    try {
      const Hdf5File file = Hdf5File::open(scratch.path("b.h5"));
      file.read_matrix("group/x");
      file.number_attribute("group/x", "scale");
      file.list("group");
    } catch (const InputError&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 10);
}

TEST(Hdf5File, KnowsItsOwnDamage) {
  const Scratch scratch;
  const std::string path = scratch.path("a.h5");
  EXPECT_EQ(Hdf5File::damage_of(path), "missing");
  {
    Hdf5File file = Hdf5File::create(path);
    file.write("group/x", std::vector<double>(20, 1.0), {4, 5});
    file.commit();
  }
  EXPECT_EQ(Hdf5File::damage_of(path), "");
  const std::string bytes = read_bytes(path);
  for (size_t at = 0; at < bytes.size(); at += 5) {
    std::string damaged = bytes;
    damaged[at] = static_cast<char>(damaged[at] ^ 1);
    write_bytes(path, damaged);
    EXPECT_NE(Hdf5File::damage_of(path), "") << at;
  }
  for (size_t size = 0; size < bytes.size(); size += 97) {
    write_bytes(path, bytes.substr(0, size));
    EXPECT_EQ(Hdf5File::damage_of(path), "truncated") << size;
  }
  write_bytes(path, bytes + "x");
  EXPECT_EQ(Hdf5File::damage_of(path), "altered");
  H5Fclose(H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT));
  EXPECT_EQ(Hdf5File::damage_of(path), "without a checksum");
}

TEST(Hdf5File, LinksShowWhatOtherFilesHold) {
  const Scratch scratch;
  {
    Hdf5File file = Hdf5File::create(scratch.path("a.h5"));
    file.write("x", std::vector<double>{1, 2}, {2});
    file.commit();
    Hdf5File face = Hdf5File::create(scratch.path("face.h5"));
    face.link("chains/a", "a.h5", "/");
    face.commit();
  }
  EXPECT_EQ(Hdf5File::open(scratch.path("face.h5")).read<double>("chains/a/x"),
            (std::vector<double>{1, 2}));
  std::filesystem::remove(scratch.path("a.h5"));
  EXPECT_INPUT_ERROR(Hdf5File::open(scratch.path("face.h5")).dims("chains/a/x"), "chains/a/x");
}

TEST(Hdf5File, NamesArraysOfTheWrongKind) {
  const Scratch scratch;
  Hdf5File file = Hdf5File::create(scratch.path("a.h5"));
  file.write("x", std::vector<double>{1, 2.5}, {2});
  file.write("names", std::vector<std::string>{"a"});
  file.write("group/large", std::vector<int64_t>{1, 1 << 20}, {2});
  EXPECT_INPUT_ERROR(file.read<double>("y"), "a.h5", "'y' is missing");
  EXPECT_INPUT_ERROR(file.read<double>("group"), "'group'");
  EXPECT_INPUT_ERROR(file.read<double>("names"), "'names'", "numbers");
  EXPECT_INPUT_ERROR(file.read_texts("x"), "'x'", "texts");
  EXPECT_INPUT_ERROR(file.read_matrix("x"), "'x'", "[2]", "2 dimensions");
  EXPECT_INPUT_ERROR(file.read<int32_t>("x"), "'x'", "whole number");
  EXPECT_INPUT_ERROR(file.read<int16_t>("group/large"), "'group/large'", "in range");
  EXPECT_INPUT_ERROR(file.write("x", std::vector<double>{1}, {1}), "'x'", "exist");
  EXPECT_THROW(file.write("z", std::vector<double>{1}, {2}), std::invalid_argument);
  EXPECT_INPUT_ERROR(file.list("none"), "'none'");
}

TEST(Hdf5File, StoresInfinityAndNanAsFloatsOnly) {
  const Scratch scratch;
  Hdf5File file = Hdf5File::create(scratch.path("a.h5"));
  const double infinity = std::numeric_limits<double>::infinity();
  const std::vector<double> odd = {infinity, -infinity, std::nan("")};
  file.write("x", odd.data(), {3}, Hdf5Type::kFloat32);
  const std::vector<double> back = file.read<double>("x");
  EXPECT_EQ(back[0], infinity);
  EXPECT_EQ(back[1], -infinity);
  EXPECT_TRUE(std::isnan(back[2]));
  EXPECT_INPUT_ERROR(file.write("y", odd.data(), {3}, Hdf5Type::kInt16), "'y'", "integer");
  const double large = 40000;
  EXPECT_INPUT_ERROR(file.write("z", &large, {1}, Hdf5Type::kInt16), "'z'", "integer");
}

// A chunked array needs no storage until it is written, so a small file can claim any shape.
TEST(Hdf5File, RefusesAShapeThatTheFileCannotHold) {
  const Scratch scratch;
  const std::string path = scratch.path("a.h5");
  {
    const hid_t file = H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
    const hsize_t dims[2] = {hsize_t{1} << 40, 1 << 10}, chunk[2] = {1, 1 << 10};
    const hid_t space = H5Screate_simple(2, dims, nullptr);
    const hid_t creation = H5Pcreate(H5P_DATASET_CREATE);
    H5Pset_chunk(creation, 2, chunk);
    const hid_t array =
        H5Dcreate2(file, "x", H5T_NATIVE_DOUBLE, space, H5P_DEFAULT, creation, H5P_DEFAULT);
    H5Dclose(array);
    H5Pclose(creation);
    H5Sclose(space);
    H5Fclose(file);
  }
  const Hdf5File file = Hdf5File::open(path);
  EXPECT_INPUT_ERROR(file.read<double>("x"), path, "'x'", "can hold");
  EXPECT_INPUT_ERROR(file.read_matrix("x"), path, "'x'", "can hold");
}

// As Python writes them: fixed-length texts and booleans as an enum.
TEST(Hdf5File, ReadsWhatH5pyWrites) {
  const Scratch scratch;
  const std::string path = scratch.path("a.h5");
  const std::string script =
      "import h5py, numpy as np\n"
      "f = h5py.File('" +
      path +
      "', 'w')\n"
      "f['names'] = np.array([b'tee', b'robe'])\n"
      "f['flags'] = np.array([True, False])\n"
      "f['faces'] = np.arange(6).reshape(2, 3)\n"
      "f['big'] = np.arange(3, dtype='>f4')\n"
      "f.attrs['fixed'] = np.bytes_('abc')\n"
      "f.attrs['text'] = 'def'\n"
      "f.attrs['n'] = np.int16(-3)\n"
      "f.attrs['list'] = [1.0, 2.0]\n";
  write_bytes(scratch.path("make.py"), script);
  const std::string command = "/usr/bin/python3 " + scratch.path("make.py") + " 2>/dev/null";
  if (std::system(command.c_str()) != 0) GTEST_SKIP() << "needs python3 with h5py";
  const Hdf5File file = Hdf5File::open(path);
  EXPECT_EQ(file.read_texts("names"), (std::vector<std::string>{"tee", "robe"}));
  EXPECT_EQ(file.read<uint8_t>("flags"), (std::vector<uint8_t>{1, 0}));
  EXPECT_EQ(file.read<int32_t>("faces"), (std::vector<int32_t>{0, 1, 2, 3, 4, 5}));
  EXPECT_EQ(file.read<double>("big"), (std::vector<double>{0, 1, 2}));
  EXPECT_EQ(file.text_attribute("/", "fixed"), "abc");
  EXPECT_EQ(file.text_attribute("/", "text"), "def");
  EXPECT_EQ(file.number_attribute("/", "n"), -3);
  EXPECT_INPUT_ERROR(file.number_attribute("/", "list"), "'list'", "single");
}

}  // namespace
}  // namespace pleat
