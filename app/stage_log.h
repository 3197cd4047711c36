// Which stages of a study are done, for which inputs, and how long they took:
// <output>/stages/<name>.json.
#pragma once

#include <optional>
#include <string>

namespace pleat::app {

struct StageRecord {
  std::string key;      // hash of everything the stage depends on
  double seconds = 0;   // wall time
  std::string summary;  // a line for people
};

class StageLog {
 public:
  explicit StageLog(std::string output_folder);
  // The record of a stage that finished for these inputs and whose file is still there.
  std::optional<StageRecord> find(const std::string& stage, const std::string& key,
                                  const std::string& file) const;
  void write(const std::string& stage, const StageRecord& record) const;

 private:
  std::string path(const std::string& stage) const;
  std::string folder_;
};

}  // namespace pleat::app
