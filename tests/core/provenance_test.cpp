#include "core/provenance.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include "core/atomic_file.h"
#include "core/hdf5_file.h"
#include "tests/core/input_error.h"
#include "tests/core/scratch.h"

namespace pleat {
namespace {

// FIPS 180-4 examples.
TEST(Sha256, GivesTheStandardsValues) {
  EXPECT_EQ(sha256(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(sha256("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(sha256(std::string(1000000, 'a')),
            "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

TEST(Sha256, OfAFileIsThatOfItsBytes) {
  const Scratch scratch;
  const std::string bytes(200001, 'x');
  write_bytes(scratch.path("a"), bytes);
  EXPECT_EQ(sha256_of_file(scratch.path("a")), sha256(bytes));
  EXPECT_INPUT_ERROR(sha256_of_file(scratch.path("none")), scratch.path("none"), "No such file");
  EXPECT_INPUT_ERROR(sha256_of_file(scratch.path("")), scratch.path(""), "cannot be read");
}

TEST(Provenance, SurvivesTheFile) {
  const Scratch scratch;
  Provenance before{"simulate", "fabric:\n  thickness_m: 0.0005\n", UINT64_MAX - 1, {}};
  before.inputs["body \"x\""] = sha256("body");
  before.config += std::string(100000, '#');  // beyond the 64 KB that a plain attribute can hold
  Hdf5File file = Hdf5File::create(scratch.path("a.h5"));
  write_provenance(file, before);
  file.commit();
  const Provenance after = read_provenance(Hdf5File::open(scratch.path("a.h5")));
  EXPECT_EQ(after.stage, before.stage);
  EXPECT_EQ(after.config, before.config);
  EXPECT_EQ(after.seed, before.seed);
  EXPECT_EQ(after.inputs, before.inputs);
}

TEST(Provenance, NamesWhatIsMissingOrDamaged) {
  const Scratch scratch;
  Hdf5File file = Hdf5File::create(scratch.path("a.h5"));
  EXPECT_INPUT_ERROR(read_provenance(file), "a.h5", "'stage'");
  write_provenance(file, {"encode", "", 1, {}});
  file.write_attribute("/", "seed", "12 monkeys");
  EXPECT_INPUT_ERROR(read_provenance(file), "seed = '12 monkeys'", "whole number");
  file.write_attribute("/", "seed", "12");
  file.write_attribute("/", "inputs", "[1, 2]");
  EXPECT_INPUT_ERROR(read_provenance(file), "inputs");
}

TEST(Provenance, KnowsVersionCommitAndMachine) {
  EXPECT_EQ(version().find_first_not_of("0123456789."), std::string::npos);
  EXPECT_FALSE(commit().empty());
  EXPECT_NE(machine().find("cores"), std::string::npos);
  const std::string json = provenance_json({"encode", "a: \"b\"\n", 7, {{"body", "12ab"}}});
  EXPECT_NE(json.find("\"config\": \"a: \\\"b\\\"\\n\""), std::string::npos) << json;
  EXPECT_NE(json.find("\"seed\": 7"), std::string::npos) << json;
}

TEST(WriteFileAtomically, ReplacesAndLeavesNothingElse) {
  const Scratch scratch;
  write_file_atomically(scratch.path("a"), "one");
  write_file_atomically(scratch.path("a"), std::string("two\0three", 9));
  EXPECT_EQ(read_bytes(scratch.path("a")), std::string("two\0three", 9));
  EXPECT_EQ(scratch.files(), std::vector<std::string>{"a"});
}

TEST(WriteFileAtomically, NamesAPathThatCannotBeWritten) {
  const Scratch scratch;
  EXPECT_INPUT_ERROR(write_file_atomically(scratch.path("none/a"), "x"), scratch.path("none/a"),
                     "No such file or directory");
  std::filesystem::create_directory(scratch.path("folder"));
  EXPECT_INPUT_ERROR(write_file_atomically(scratch.path("folder"), "x"), "Is a directory");
  EXPECT_EQ(scratch.files(), std::vector<std::string>{"folder"});
}

TEST(WriteFileAtomically, ObeysTheUmask) {
  const Scratch scratch;
  const mode_t before = ::umask(0027);
  write_file_atomically(scratch.path("a"), "x");
  ::umask(before);
  struct stat status;
  ASSERT_EQ(::stat(scratch.path("a").c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777, 0640u);
}

}  // namespace
}  // namespace pleat
