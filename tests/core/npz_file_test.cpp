#include "core/npz_file.h"

#include <gtest/gtest.h>
#include <zip.h>

#include <cstdlib>
#include <limits>
#include <stdexcept>

#include "tests/core/input_error.h"
#include "tests/core/scratch.h"

namespace pleat {
namespace {

using Shape = std::vector<int64_t>;
using Values = std::vector<double>;

NpzEntry numbers(const std::string& key, const std::string& dtype, Shape shape, Values values) {
  return {key, dtype, {std::move(shape), std::move(values)}, ""};
}

NpzEntry text(const std::string& key, const std::string& value) { return {key, "text", {}, value}; }

// An .npy file of version 1 with any header text.
std::string npy(const std::string& header, const std::string& data) {
  std::string bytes("\x93NUMPY\x01\x00", 8);
  bytes += static_cast<char>(header.size() & 0xFF);
  bytes += static_cast<char>(header.size() >> 8);
  return bytes + header + data;
}

void write_zip(const std::string& path, const std::string& name, const std::string& bytes) {
  zip_t* archive = zip_open(path.c_str(), ZIP_CREATE | ZIP_TRUNCATE, nullptr);
  zip_file_add(archive, name.c_str(), zip_source_buffer(archive, bytes.data(), bytes.size(), 0), 0);
  ASSERT_EQ(zip_close(archive), 0);
}

TEST(NpzFile, GivesBackWhatWasWritten) {
  const Scratch scratch;
  const std::string path = scratch.path("a.npz");
  write_npz(path, {numbers("poses", "<f8", {2, 3}, {1, 1.0 / 3, -2, 0, 5e300, 6}),
                   numbers("trans", "<f4", {3, 1}, {0.1, 2, 3}),
                   numbers("parents", "<i4", {2}, {-1, 2147483647}),
                   numbers("kintree", "<u4", {2}, {4294967295, 0}),
                   numbers("rate", "<f8", {}, {29.97}), numbers("none", "<f4", {0, 3}, {}),
                   text("gender", "f\xc3\xa9minin \xf0\x9f\x91\x97"), text("empty", "")});
  const NpzFile file(path);
  EXPECT_EQ(file.keys(), (std::vector<std::string>{"empty", "gender", "kintree", "none", "parents",
                                                   "poses", "rate", "trans"}));
  EXPECT_EQ(file.shape("poses"), (Shape{2, 3}));
  EXPECT_EQ(file.read("poses").values, (Values{1, 1.0 / 3, -2, 0, 5e300, 6}));
  EXPECT_EQ(file.read("trans").shape, (Shape{3, 1}));
  EXPECT_EQ(file.read("trans").values, (Values{0.1f, 2, 3}));
  EXPECT_EQ(file.read("parents").values, (Values{-1, 2147483647}));
  EXPECT_EQ(file.read("kintree").values, (Values{4294967295, 0}));
  EXPECT_EQ(file.read("rate").shape, Shape{});
  EXPECT_EQ(file.read("rate").values, Values{29.97});
  EXPECT_EQ(file.read("none").shape, (Shape{0, 3}));
  EXPECT_TRUE(file.read("none").values.empty());
  EXPECT_EQ(file.read_text("gender"), "f\xc3\xa9minin \xf0\x9f\x91\x97");
  EXPECT_EQ(file.read_text("empty"), "");
  EXPECT_TRUE(file.is_text("gender"));
  EXPECT_FALSE(file.is_text("poses"));
  EXPECT_TRUE(file.has("poses"));
  EXPECT_FALSE(file.has("betas"));
  EXPECT_INPUT_ERROR(file.read("betas"), path, "'betas' is missing");
  EXPECT_INPUT_ERROR(file.read("gender"), path, "'gender'", "numbers");
  EXPECT_INPUT_ERROR(file.read_text("poses"), path, "'poses'", "single text");
}

TEST(NpzFile, GivesEqualBytesForEqualContent) {
  const Scratch scratch;
  const auto write = [&](const std::string& name) {
    write_npz(scratch.path(name), {numbers("x", "<f8", {1000}, Values(1000, 3)), text("t", "a")});
    return read_bytes(scratch.path(name));
  };
  const std::string first = write("a.npz");
  ::sleep(2);  // zip archives keep times to two seconds
  ::setenv("TZ", "Asia/Tokyo", 1);
  EXPECT_EQ(write("b.npz"), first);
  ::unsetenv("TZ");
  EXPECT_LT(first.size(), 2000u);  // deflated
}

TEST(NpzFile, RefusesToWriteWhatDoesNotFit) {
  const Scratch scratch;
  const std::string path = scratch.path("a.npz");
  EXPECT_INPUT_ERROR(write_npz(path, {numbers("x", "<i4", {1}, {0.5})}), "'x'", "0.5");
  EXPECT_INPUT_ERROR(write_npz(path, {numbers("x", "<u4", {1}, {-1})}), "'x'");
  EXPECT_INPUT_ERROR(
      write_npz(path, {numbers("x", "<i4", {1}, {std::numeric_limits<double>::quiet_NaN()})}),
      "'x'");
  EXPECT_THROW(write_npz(path, {numbers("x", "<f8", {2}, {1})}), std::invalid_argument);
  EXPECT_INPUT_ERROR(
      write_npz(path, {numbers("x", "<f8", {1}, {1}), numbers("x", "<f8", {1}, {1})}), path, "x");
  EXPECT_TRUE(scratch.files().empty());
}

TEST(NpzFile, ReadsOtherTypesAndOrders) {
  const Scratch scratch;
  const std::string path = scratch.path("a.npz");
  const auto read = [&](const std::string& header, const std::string& data) {
    write_zip(path, "x.npy", npy(header, data));
    return NpzFile(path).read("x");
  };
  // Columns one after the other, big-endian: [[1, 3, 5], [2, 4, 6]].
  const NpyArray array = read("{'descr': '>i2', 'fortran_order': True, 'shape': (2, 3), }\n",
                              std::string("\x00\x01\x00\x02\x00\x03\x00\x04\x00\x05\x00\x06", 12));
  EXPECT_EQ(array.shape, (Shape{2, 3}));
  EXPECT_EQ(array.values, (Values{1, 3, 5, 2, 4, 6}));
  EXPECT_EQ(
      read("{'shape': (2L,), 'fortran_order': False, 'descr': '|b1'}", std::string("\x01\x00", 2))
          .values,
      (Values{1, 0}));
  EXPECT_EQ(read("{\"descr\": \"<i8\", \"fortran_order\": False, \"shape\": ()}",
                 "\xfe\xff\xff\xff\xff\xff\xff\xff")
                .values,
            Values{-2});
  EXPECT_EQ(read("{'descr': '|u1', 'fortran_order': False, 'shape': (1, 2)}", "\xff\x80").values,
            (Values{255, 128}));
  EXPECT_EQ(read("{'descr': '|i1', 'fortran_order': False, 'shape': (2,)}", "\xff\x80").values,
            (Values{-1, -128}));
  write_zip(
      path, "x.npy",
      npy("{'descr': '|S6', 'fortran_order': False, 'shape': (1,)}", std::string("male\0\0", 6)));
  EXPECT_EQ(NpzFile(path).read_text("x"), "male");
}

TEST(NpzFile, ReadsWhatNumpyWrites) {
  const Scratch scratch;
  const std::string path = scratch.path("a.npz");
  write_bytes(scratch.path("make.py"),
              "import numpy as np\n"
              "a = np.arange(24, dtype=np.float32).reshape(2, 3, 4)\n"
              "np.savez_compressed('" +
                  path +
                  "', a=a, f=np.asfortranarray(a), t=a.transpose(2, 0, 1),\n"
                  "         n=np.int64(7), s='neutral', b=np.bytes_('male'), o=np.array([None, "
                  "1]), m=a > 5,\n"
                  "         c=a * 1j, u=np.array('h\\u00e9'), two=np.array(['a', 'b']))\n");
  const std::string command = "/usr/bin/python3 " + scratch.path("make.py") + " 2>/dev/null";
  if (std::system(command.c_str()) != 0) GTEST_SKIP() << "needs python3 with numpy";
  const NpzFile file(path);
  Values expected(24);
  for (int k = 0; k < 24; ++k) expected[k] = k;
  EXPECT_EQ(file.read("a").values, expected);
  EXPECT_EQ(file.read("f").values, expected);
  EXPECT_EQ(file.read("f").shape, (Shape{2, 3, 4}));
  const NpyArray t = file.read("t");
  EXPECT_EQ(t.shape, (Shape{4, 2, 3}));
  for (int k = 0; k < 24; ++k) EXPECT_EQ(t.values[k], k / 6 + 12 * (k / 3 % 2) + 4 * (k % 3));
  EXPECT_EQ(file.read("n").values, Values{7});
  EXPECT_EQ(file.read("m").values[6], 1);
  EXPECT_EQ(file.read("m").values[5], 0);
  EXPECT_EQ(file.read_text("s"), "neutral");
  EXPECT_EQ(file.read_text("b"), "male");
  EXPECT_EQ(file.read_text("u"), "h\xc3\xa9");
  EXPECT_INPUT_ERROR(file.read_text("two"), "'two'", "single text");
  EXPECT_INPUT_ERROR(file.read("c"), "'c'", "type");
  EXPECT_EQ(file.shape("o"), Shape{2});
  EXPECT_INPUT_ERROR(file.read("o"), path, "'o'", "pickled", "allow_pickle");
  EXPECT_INPUT_ERROR(file.read_text("o"), path, "'o'", "pickled");
  const std::string check =
      "/usr/bin/python3 -c \"import numpy as np; f = np.load('" + scratch.path("b.npz") +
      "'); assert f['x'].tolist() == [[1.5], [2.5]]; assert str(f['t']) == 'abc'\"";
  write_npz(scratch.path("b.npz"), {numbers("x", "<f4", {2, 1}, {1.5, 2.5}), text("t", "abc")});
  EXPECT_EQ(std::system(check.c_str()), 0);
}

TEST(NpzFile, NamesFilesThatItCannotOpen) {
  const Scratch scratch;
  EXPECT_INPUT_ERROR(NpzFile(scratch.path("none.npz")), "none.npz", "no such file");
  EXPECT_INPUT_ERROR(NpzFile(scratch.path("")), "is not a file");
  write_bytes(scratch.path("text.npz"), "not an archive");
  EXPECT_INPUT_ERROR(NpzFile(scratch.path("text.npz")), "text.npz", "not a NumPy .npz");
  write_bytes(scratch.path("empty.npz"), "");
  EXPECT_INPUT_ERROR(NpzFile(scratch.path("empty.npz")).read("x"), "empty.npz");
  write_bytes(scratch.path("smpl.pkl"), "\x80\x02}q\x01.");
  EXPECT_INPUT_ERROR(NpzFile(scratch.path("smpl.pkl")), "smpl.pkl", "pickle", "np.savez");
}

TEST(NpzFile, RefusesEveryTruncation) {
  const Scratch scratch;
  write_npz(scratch.path("a.npz"), {numbers("x", "<f8", {50}, Values(50, 1.5)), text("t", "abc")});
  const std::string bytes = read_bytes(scratch.path("a.npz"));
  for (size_t size = 0; size < bytes.size(); ++size) {
    write_bytes(scratch.path("short.npz"), bytes.substr(0, size));
    EXPECT_INPUT_ERROR(NpzFile(scratch.path("short.npz")).read("x"), "short.npz");
  }
}

// Any damage gives the same numbers or an InputError, never others: the archive has checksums.
TEST(NpzFile, NeverGivesDamagedNumbers) {
  const Scratch scratch;
  Values values(40);
  for (size_t k = 0; k < values.size(); ++k) values[k] = 1.0 / (k + 1);
  write_npz(scratch.path("a.npz"), {numbers("x", "<f8", {40}, values)});
  const std::string bytes = read_bytes(scratch.path("a.npz"));
  int refused = 0;
  for (size_t at = 0; at < bytes.size(); ++at) {
    std::string damaged = bytes;
    damaged[at] = static_cast<char>(damaged[at] ^ 0x15);
    write_bytes(scratch.path("b.npz"), damaged);
    try {
      EXPECT_EQ(NpzFile(scratch.path("b.npz")).read("x").values, values) << "byte " << at;
    } catch (const InputError&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, static_cast<int>(bytes.size()) / 2);
}

TEST(NpzFile, RefusesHostileHeaders) {
  const Scratch scratch;
  const std::string path = scratch.path("a.npz");
  const auto refuse = [&](const std::string& bytes) {
    SCOPED_TRACE(bytes.substr(0, 200));
    write_zip(path, "x.npy", bytes);
    EXPECT_INPUT_ERROR(NpzFile(path).read("x"), path, "'x'");
  };
  const auto with = [](const std::string& type, const std::string& shape) {
    return npy("{'descr': " + type + ", 'fortran_order': False, 'shape': " + shape + "}",
               "12345678");
  };
  write_zip(path, "x.npy", with("'<f8'", "(1,)"));
  EXPECT_EQ(NpzFile(path).read("x").shape, Shape{1});  // the pattern itself is good
  refuse("");
  refuse("short");
  refuse("plain text that is long enough");
  refuse(with("'<f8'", "(2,)"));
  refuse(with("'<f8'", "(0,)"));
  refuse(with("'<f8'", "(-1,)"));
  refuse(with("'<f8'", "(1"));
  refuse(with("'<f8'", "1"));
  refuse(with("'<f8'", "(99999999999999999999,)"));
  refuse(with("'<f8'", "(4294967296, 4294967296)"));
  refuse(with("'<f8'", "(2305843009213693952, 8)"));
  refuse(with("'<f8'", "(1,) * 2"));
  refuse(with("'<f8'", "(" + std::string(100, '1') + ",)"));
  refuse(with("'<f3'", "(1,)"));
  refuse(with("'<f0'", "(8,)"));
  refuse(with("'<f99999999999'", "(1,)"));
  refuse(with("'<M8[ns]'", "(1,)"));
  refuse(with("[('a', '<f4'), ('b', '<f4')]", "(1,)"));
  refuse(with("[('a'", "(1,)"));
  refuse(with("'|O'", "(1,)"));
  refuse(with("f8", "(1,)"));
  refuse(with("''", "(1,)"));
  refuse(with("'<f8", "(1,)"));
  refuse(npy("{'descr': '<f8', 'shape': (1,)}", "12345678"));
  refuse(npy("{'descr': '<f8', 'fortran_order': 1, 'shape': (1,)}", "12345678"));
  refuse(npy("{'descr': '<f8', 'fortran_order': False, 'shape': (1,), 'extra': 1}", "12345678"));
  refuse(npy("", "12345678"));
  refuse(std::string("\x93NUMPY\x01\x00\xff\xff{", 11));           // header longer than the member
  refuse(std::string("\x93NUMPY\x02\x00\xff\xff\xff\xff{}", 14));  // 4 GB of header
  refuse(std::string("\x93NUMPY\x09\x00\x02\x00{}aaaaaaaaaa", 22));  // unknown version
  std::string many = "(";
  for (int k = 0; k < 100; ++k) many += "1, ";
  refuse(with("'<f8'", many + ")"));
}

// 64 MB of zeros shrink to 64 KB, which is honest. A directory that claims far more is not.
TEST(NpzFile, RefusesASizeThatTheArchiveCannotHold) {
  const Scratch scratch;
  const std::string path = scratch.path("a.npz");
  write_npz(path, {numbers("x", "<f4", {1000}, Values(1000, 0))});
  std::string bytes = read_bytes(path);
  const size_t directory = bytes.rfind("PK\x01\x02");
  ASSERT_NE(directory, std::string::npos);
  bytes.replace(directory + 24, 4, "\xf0\xff\xff\x7f");  // uncompressed size: 2 GB
  write_bytes(path, bytes);
  EXPECT_INPUT_ERROR(NpzFile(path).read("x"), path, "x");
}

}  // namespace
}  // namespace pleat
