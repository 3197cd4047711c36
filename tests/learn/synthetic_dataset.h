// A small dataset.h5 (docs/dataset.md) whose textures are smooth, known functions of the condition.
#pragma once

#include <string>

namespace pleat::learn {

struct SyntheticDataset {
  int frames = 60;
  int resolution = 16;
  int designs = 6;  // the last one held out
  int joints = 2;   // textures depend on the second
  int shape_count = 2;
  int vertices = 30, uvs = 40;
  double held_out_share = 0.2;  // of the frames, beside those of the held-out design
  std::string left_out;         // name of an array that is not written
};
void write_synthetic_dataset(const std::string& path, const SyntheticDataset& options);

// A folder of its own that goes away with the test.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  std::string operator/(const std::string& name) const { return path_ + "/" + name; }
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

}  // namespace pleat::learn
