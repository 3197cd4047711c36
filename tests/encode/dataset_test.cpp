#include "encode/dataset.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <limits>

#include "core/error.h"
#include "tests/encode/synthetic_body.h"

namespace pleat::encode {
namespace {

struct Small {
  Tube tube = make_tube(6, 12);
  TextureEncoder encoder{tube.topology, make_uv_layout(tube.topology, 64), Fill::kFitted};
  DatasetContents contents;
  std::vector<Texture> textures;

  Small() {
    contents.texture_size = 64;
    contents.mask = encoder.layout().mask;
    contents.garments = {tube_garment(tube, {"tee", 0.3, 0.25, 0.2, false}),
                         tube_garment(tube, {"dress", 0.9, 0.5, 0.4, true})};
    contents.sequences = {{"walk", false, 30}, {"jump", true, 60}};
    contents.normalisation = {Vec<3>(0.001, 0.002, -0.003), Vec<3>(0.01, 0.02, 0.03)};
    contents.body_sha256 = std::string(64, 'a');
    for (int i = 0; i < 4; ++i) {
      DatasetRow row;
      row.pose = spine_pose(i);
      row.shape = Vec<2>(0.5, i);
      row.design = i / 2;
      row.sequence = i % 2;
      row.frame = 10 + i;
      row.previous = i == 1 ? 0 : -1;
      row.split = static_cast<Split>((i / 2) | 2 * (i % 2));
      row.certificate.residual = 0.01 * i;
      row.certificate.is_stable = i % 2 == 1;
      row.certificate.body_intersections = i;
      row.certificate.overlap_intersections = 2 * i;
      row.clip_key = "key" + std::to_string(i);
      contents.rows.push_back(row);
      textures.push_back(encoder.encode(clip_offsets(tube, i)));
    }
  }

  void write(const std::string& path, double scale_m, int gzip_level = 0) const {
    DatasetWriter writer(path, contents, scale_m, gzip_level, {"encode", "encode:\n", 7, {}});
    for (const Texture& texture : textures) writer.append(texture);
    writer.commit();
  }
};

TEST(Dataset, ReturnsWhatWasWritten) {
  const Small small;
  const TemporaryFolder folder;
  small.write(folder / "dataset.h5", 0);
  const Dataset dataset(folder / "dataset.h5");
  ASSERT_EQ(dataset.row_count(), 4);
  const DatasetContents& contents = dataset.contents();
  EXPECT_EQ(contents.mask, small.contents.mask);
  EXPECT_EQ(contents.body_sha256, small.contents.body_sha256);
  EXPECT_EQ(dataset.provenance().seed, 7u);
  EXPECT_LT((contents.normalisation.std - small.contents.normalisation.std).norm(), 1e-8);
  for (int i = 0; i < 4; ++i) {
    const DatasetRow &row = dataset.row(i), &expected = small.contents.rows[static_cast<size_t>(i)];
    EXPECT_EQ(dataset.texture(i).values, small.textures[static_cast<size_t>(i)].values);
    EXPECT_LT((row.pose.rotations - expected.pose.rotations).norm(), 1e-6);
    EXPECT_LT((row.pose.translation - expected.pose.translation).norm(), 1e-6);
    EXPECT_EQ(row.shape, expected.shape);
    EXPECT_EQ(row.design, expected.design);
    EXPECT_EQ(row.sequence, expected.sequence);
    EXPECT_EQ(row.frame, expected.frame);
    EXPECT_EQ(row.previous, expected.previous);
    EXPECT_EQ(row.split, expected.split);
    EXPECT_EQ(row.clip_key, expected.clip_key);
    EXPECT_NEAR(row.certificate.residual, expected.certificate.residual, 1e-8);
    EXPECT_EQ(row.certificate.is_stable, expected.certificate.is_stable);
    EXPECT_EQ(row.certificate.body_intersections, expected.certificate.body_intersections);
    EXPECT_EQ(row.certificate.overlap_intersections, expected.certificate.overlap_intersections);
  }
  const garment::Garment& dress = dataset.garment(2);
  EXPECT_EQ(dress.design.name, "dress");
  EXPECT_TRUE(dress.design.is_held_out);
  EXPECT_NEAR(dress.design.length, 0.9, 1e-7);
  EXPECT_EQ(dress.topology.panel_faces, small.tube.topology.panel_faces);
  EXPECT_EQ(dress.topology.panel_of_vertex, small.tube.topology.panel_of_vertex);
  EXPECT_LT((dress.t_pose - small.contents.garments[1].t_pose).cwiseAbs().maxCoeff(), 1e-7);
  EXPECT_LT((dress.weights - small.contents.garments[1].weights).norm(), 1e-6);
  EXPECT_EQ(contents.sequences[1].name, "jump");
  EXPECT_TRUE(contents.sequences[1].is_held_out);
  EXPECT_EQ(contents.sequences[1].frame_rate_hz, 60);
}

TEST(Dataset, FixedPointErrsByHalfAStep) {
  const Small small;
  const TemporaryFolder folder;
  const double scale = 0.05 / 32767;
  for (const int gzip_level : {0, 1}) {
    small.write(folder / "dataset.h5", scale, gzip_level);
    const Dataset dataset(folder / "dataset.h5");
    EXPECT_DOUBLE_EQ(dataset.scale_m(), scale);
    for (int i = 0; i < 4; ++i) {
      const Texture texture = dataset.texture(i),
                    &expected = small.textures[static_cast<size_t>(i)];
      double worst = 0;
      for (size_t k = 0; k < texture.values.size(); ++k) {
        worst = std::max(worst, std::abs(static_cast<double>(texture.values[k]) -
                                         static_cast<double>(expected.values[k])));
      }
      EXPECT_GT(worst, 0);
      EXPECT_LE(worst, 0.5 * scale + 4e-9);  // the second: the result is a float
    }
  }
}

TEST(Dataset, AppendReturnsWhatAReaderSees) {
  const Small small;
  const TemporaryFolder folder;
  DatasetWriter writer(folder / "dataset.h5", small.contents, 1e-6, 0, {});
  std::vector<Texture> stored;
  for (const Texture& texture : small.textures) stored.push_back(writer.append(texture));
  EXPECT_FALSE(std::filesystem::exists(folder / "dataset.h5"));  // nothing half-written
  writer.commit();
  const Dataset dataset(folder / "dataset.h5");
  for (int i = 0; i < 4; ++i)
    EXPECT_EQ(dataset.texture(i).values, stored[static_cast<size_t>(i)].values);
}

TEST(Dataset, DecodesToThePosedGarment) {
  const Small small;
  const TemporaryFolder folder;
  small.write(folder / "dataset.h5", 0);
  const Dataset dataset(folder / "dataset.h5");
  const body::BodyModel model = column_body();
  for (int i = 0; i < 4; ++i) {
    const DatasetRow& row = small.contents.rows[static_cast<size_t>(i)];
    const garment::Garment& garment = small.contents.garments[static_cast<size_t>(row.design)];
    const Points3 offsets = clip_offsets(small.tube, i);
    const Texture texture = dataset.texture(i);
    EXPECT_LT((decode_offsets(dataset, i, texture) - offsets).rowwise().norm().maxCoeff(), 1e-4);
    EXPECT_LT((decode_unposed(dataset, i, texture) - garment.t_pose - offsets)
                  .rowwise()
                  .norm()
                  .maxCoeff(),
              1e-4);
    const Points3 posed =
        pose(garment, offsets,
             body::joint_transforms(model, body::shape_body(model, row.shape), row.pose),
             Skinning::kLinear);
    EXPECT_LT((decode_posed(dataset, i, texture, model) - posed).rowwise().norm().maxCoeff(), 1e-4);
  }
}

TEST(Dataset, OpensWithH5pyAndExplainsItself) {
  if (std::system("/usr/bin/python3 -c 'import h5py' >/dev/null 2>&1") != 0)
    GTEST_SKIP() << "no h5py here";
  const Small small;
  const TemporaryFolder folder;
  small.write(folder / "dataset.h5", 1e-6);
  std::ofstream(folder / "read.py") << R"(
import sys, h5py, numpy as np
f = h5py.File(sys.argv[1], "r")
assert f.attrs["schema_version"] == 1 and f.attrs["skinning"] == "linear", dict(f.attrs)
t = f["textures"]
assert t.dtype == np.int16 and t.shape == (4, 3, 64, 64) and t.chunks == (1, 3, 64, 64), t
metres = t[2] * t.attrs["scale_m"]
assert 0.005 < np.abs(metres).max() < 0.05
assert (metres[:, f["mask"][:] == 0] == 0).all()
assert list(f["clip_key"].asstr()) == ["key0", "key1", "key2", "key3"]
assert list(f["designs/names"].asstr()) == ["tee", "dress"]
assert f["pose"].shape == (4, 24, 3) and f["pose"].dtype == np.float32
assert f["designs/weights"].shape == (2, f["designs/vertices"].shape[1], 24)
assert f["mask"].attrs["CLASS"] == b"IMAGE" and f["mask"].attrs["IMAGE_SUBCLASS"] == b"IMAGE_GRAYSCALE"
found = []
f.visititems(lambda name, item: found.append(name) if isinstance(item, h5py.Dataset) else None)
for name in found:
    assert f[name].attrs["unit"] and f[name].attrs["meaning"], name
documented = [part for line in open(sys.argv[2]) if line.startswith("| `") for part in line.split("|")[1].split("`")[1::2]]
assert sorted(found) == sorted(documented), set(found) ^ set(documented)
)";
  const std::string command = "/usr/bin/python3 " + (folder / "read.py") + " " +
                              (folder / "dataset.h5") + " " + std::string(PLEAT_SOURCE_DIR) +
                              "/docs/dataset.md";
  EXPECT_EQ(std::system(command.c_str()), 0);
}

// scripts/pleat_dataset.py reads what a Dataset reads, in both storages.
TEST(Dataset, ReaderInPythonAgrees) {
  if (std::system("/usr/bin/python3 -c 'import h5py' >/dev/null 2>&1") != 0)
    GTEST_SKIP() << "no h5py here";
  for (const double scale : {1e-6, 0.0}) {
    const Small small;
    const TemporaryFolder folder;
    small.write(folder / "dataset.h5", scale);
    const Dataset dataset(folder / "dataset.h5");
    std::ofstream(folder / "read.py") << R"(
import pickle, sys, numpy as np
sys.path.insert(0, sys.argv[2])
from pleat_dataset import PleatDataset, SPLITS
every = PleatDataset(sys.argv[1], split=None, with_previous=True)
assert len(every) == 4
assert sum(len(PleatDataset(sys.argv[1], split)) for split in SPLITS) == 4
out = open(sys.argv[3], "wb")
for k in range(len(every)):
    item = every[k]
    assert item["row"] == k and item["texture"].dtype == np.float32 and item["pose"].shape == (72,)
    assert item["design"].shape == (3,) and item["shape"].ndim == 1
    before = every.previous[k]
    assert np.isnan(item["previous_texture"]).all() if before < 0 else (item["previous_texture"] == every.texture(before)).all()
    out.write(item["texture"].tobytes())
try:
    every[4]
    raise SystemExit("no end")
except IndexError:
    pass
copy = pickle.loads(pickle.dumps(every))
assert (copy[1]["texture"] == every[1]["texture"]).all()
train = PleatDataset(sys.argv[1], "train", normalised=True)
for k in range(len(train)):
    raw = every.texture(train.rows[k])
    expected = np.where(every.mask, (raw - every.mean) / every.std, 0)
    assert np.allclose(train[k]["texture"], expected, atol=1e-6)
)";
    const std::string command = "/usr/bin/python3 " + (folder / "read.py") + " " +
                                (folder / "dataset.h5") + " " + std::string(PLEAT_SOURCE_DIR) +
                                "/scripts " + (folder / "textures");
    ASSERT_EQ(std::system(command.c_str()), 0);
    std::ifstream stream(folder / "textures", std::ios::binary);
    for (int64_t row = 0; row < dataset.row_count(); ++row) {
      const Texture expected = dataset.texture(row);
      std::vector<float> read(expected.values.size());
      stream.read(reinterpret_cast<char*>(read.data()),
                  static_cast<std::streamsize>(read.size() * sizeof(float)));
      ASSERT_TRUE(stream.good());
      for (size_t i = 0; i < read.size(); ++i) ASSERT_NEAR(read[i], expected.values[i], 1e-8);
    }
  }
}

// A dataset with one array changed by `spoil`.
template <typename Spoil>
std::string message_of(const Small& small, const Spoil& spoil) {
  const TemporaryFolder folder;
  small.write(folder / "dataset.h5", 0);
  spoil(folder / "dataset.h5");
  try {
    const Dataset dataset(folder / "dataset.h5");
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(Dataset, RefusesWhatIsNotOne) {
  const TemporaryFolder folder;
  EXPECT_THROW(Dataset(folder / "missing.h5"), InputError);
  std::ofstream(folder / "text.h5") << "not HDF5";
  EXPECT_THROW(Dataset(folder / "text.h5"), InputError);
  Hdf5File other = Hdf5File::create(folder / "other.h5");
  other.write("something", std::vector<float>{1}, {1});
  other.commit();
  EXPECT_THROW(Dataset(folder / "other.h5"), InputError);
}

TEST(Dataset, RefusesATruncatedFile) {
  EXPECT_NE(message_of(Small(),
                       [](const std::string& path) { std::filesystem::resize_file(path, 3000); }),
            "");
}

TEST(Dataset, NamesTheArrayThatIsWrong) {
  const auto with = [](const auto& change) {
    Small small;
    change(small.contents);
    return message_of(small, [](const std::string&) {});
  };
  EXPECT_EQ(with([](DatasetContents&) {}), "");
  EXPECT_THAT(with([](DatasetContents& c) { c.rows[1].previous = 3; }),
              testing::HasSubstr("previous"));
  EXPECT_THAT(with([](DatasetContents& c) { c.rows[1].design = 2; }),
              testing::HasSubstr("design_index"));
  EXPECT_THAT(with([](DatasetContents& c) { c.rows[1].sequence = -1; }),
              testing::HasSubstr("sequence_index"));
  EXPECT_THAT(with([](DatasetContents& c) { c.rows[1].pose.translation[0] = std::nan(""); }),
              testing::HasSubstr("translation"));
  EXPECT_THAT(with([](DatasetContents& c) { c.rows[1].certificate.self_intersections = -1; }),
              testing::HasSubstr("certificate"));
  EXPECT_THAT(with([](DatasetContents& c) { c.normalisation.std[1] = 0; }),
              testing::HasSubstr("normalisation/std"));
  EXPECT_THAT(with([](DatasetContents& c) { c.garments[0].topology.sewn_vertex[3] = 100000; }),
              testing::HasSubstr("garment/sewn_vertex"));
  EXPECT_THAT(with([](DatasetContents& c) { c.garments[0].topology.uv(0, 0) = 2; }),
              testing::HasSubstr("garment/uv"));
  EXPECT_THAT(with([](DatasetContents& c) { c.garments[1].weights *= 0.5; }),
              testing::HasSubstr("designs/weights"));
  EXPECT_THAT(with([](DatasetContents& c) { c.mask.assign(c.mask.size(), 0); }),
              testing::HasSubstr("garment/uv"));
}

TEST(Samples, AreCheckedAgainstTheDataset) {
  const Small small;
  const TemporaryFolder folder;
  small.write(folder / "dataset.h5", 0);
  const Dataset dataset(folder / "dataset.h5");
  const auto write = [&](const std::vector<int32_t>& rows, int64_t size) {
    Hdf5File file = Hdf5File::create(folder / "samples.h5");
    const Dims dims = {static_cast<int64_t>(rows.size()), 3, size, size};
    std::vector<float> values(rows.size() * 3 * static_cast<size_t>(size * size), 0.25f);
    file.write("textures", values, dims);
    file.write("row", rows, {dims[0]});
    file.commit();
  };
  write({3, 3}, 64);
  const Samples samples(folder / "samples.h5", dataset);
  EXPECT_EQ(samples.count(), 2);
  EXPECT_EQ(samples.row(1), 3);
  EXPECT_EQ(samples.texture(1).values[5], 0.25f);
  write({4}, 64);
  EXPECT_THROW(Samples(folder / "samples.h5", dataset), InputError);
  write({0}, 32);
  EXPECT_THROW(Samples(folder / "samples.h5", dataset), InputError);
}

}  // namespace
}  // namespace pleat::encode
