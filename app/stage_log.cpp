#include "app/stage_log.h"

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/provenance.h"

namespace pleat::app {

StageLog::StageLog(std::string output_folder) : folder_(std::move(output_folder) + "/stages") {}

std::string StageLog::path(const std::string& stage) const {
  return folder_ + "/" + stage + ".json";
}

std::optional<StageRecord> StageLog::find(const std::string& stage, const std::string& key,
                                          const std::string& file) const {
  std::ifstream stream(path(stage));
  const nlohmann::json json = nlohmann::json::parse(stream, nullptr, false);
  StageRecord record;
  try {
    record = {json.at("key"), json.at("seconds"), json.at("summary")};
  } catch (const nlohmann::json::exception&) {  // damaged: the stage runs again
    return std::nullopt;
  }
  if (record.key != key || !std::filesystem::exists(file)) return std::nullopt;
  return record;
}

void StageLog::write(const std::string& stage, const StageRecord& record) const {
  std::filesystem::create_directories(folder_);
  const nlohmann::ordered_json json = {
      {"key", record.key}, {"seconds", record.seconds}, {"summary", record.summary}};
  write_file_atomically(path(stage), json.dump(2) + "\n");
}

}  // namespace pleat::app
