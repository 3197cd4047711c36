// A dataset with clips of rigid motion, so that a shift of the texture is the same shift of the
// posed garment.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "body/body_file.h"
#include "encode/dataset.h"
#include "tests/encode/synthetic_body.h"

namespace pleat::evaluate {

struct SmallDataset {
  encode::TemporaryFolder folder;
  encode::Tube tube = encode::make_tube(8, 16);
  body::BodyModel model = encode::column_body();
  std::string body_file = folder / "body.npz", dataset_file = folder / "dataset.h5",
              samples_file = folder / "samples.h5";
  encode::TextureEncoder encoder{tube.topology, encode::make_uv_layout(tube.topology, 64),
                                 encode::Fill::kFitted};

  // Rows 0 .. 3: tee walking (train). 4 .. 7: tee in a sequence held out. 8, 9: a dress, held out,
  // walking.
  SmallDataset() {
    body::write_body(body_file, model);
    encode::DatasetContents contents;
    contents.texture_size = 64;
    contents.mask = encoder.layout().mask;
    contents.garments = {encode::tube_garment(tube, {"tee", 0.3, 0.25, 0.2, false}),
                         encode::tube_garment(tube, {"dress", 0.9, 0.5, 0.4, true})};
    contents.sequences = {{"walk", false, 30}, {"jump", true, 30}};
    contents.normalisation.std.setConstant(0.01);
    contents.body_sha256 = sha256_of_file(body_file);
    for (int i = 0; i < 10; ++i) {
      encode::DatasetRow row;
      row.pose.rotations.row(0) << 0.02 * i, 0.3 * i, 0;  // root alone
      row.pose.translation << 0, 1, 0.1 * i;
      row.shape = Vec<2>(0, 0);
      row.design = i >= 8;
      row.sequence = i >= 4 && i < 8;
      row.frame = i < 8 ? i % 4 : i - 8;
      row.previous = row.frame > 0 ? i - 1 : -1;
      row.split = i < 4   ? encode::kTrain
                  : i < 8 ? encode::kHeldOutSequence
                          : encode::kHeldOutDesign;
      row.clip_key = "clip" + std::to_string(row.design) + std::to_string(row.sequence);
      contents.rows.push_back(row);
    }
    encode::DatasetWriter writer(dataset_file, contents, 0, 0, {});
    for (int i = 0; i < 10; ++i) writer.append(encoder.encode(encode::clip_offsets(tube, i)));
    writer.commit();
  }

  // Each sample is the dataset's texture of the row, shifted in x, m.
  void write_samples(const std::vector<int32_t>& rows, const std::vector<float>& shift_m) const {
    const encode::Dataset dataset(dataset_file);
    std::vector<float> values;
    for (size_t k = 0; k < rows.size(); ++k) {
      encode::Texture texture = dataset.texture(rows[k]);
      for (size_t i = 0; i < 64 * 64; ++i) texture.values[i] += shift_m[k];
      values.insert(values.end(), texture.values.begin(), texture.values.end());
    }
    const int64_t count = static_cast<int64_t>(rows.size());
    Hdf5File file = Hdf5File::create(samples_file);
    file.write("textures", values, {count, 3, 64, 64});
    file.write("row", rows, {count});
    file.commit();
  }
};

}  // namespace pleat::evaluate
