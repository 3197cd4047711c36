// What report.html of a study shows; how a page looks is show/page's.
#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "app/stage_log.h"
#include "app/study.h"
#include "core/provenance.h"

namespace pleat::app {

struct ReportInputs {
  std::string output;
  std::string dataset, samples, loss_csv;  // files
  std::vector<std::string> shard_files;
  std::function<std::string(const std::string&)> shard_of_key;
  std::vector<std::pair<std::string, StageRecord>> stages;
};

// False where the user interrupted; nothing is written then.
bool write_report_page(const StudyConfig& study, const ReportInputs& inputs,
                       const evaluate::Evaluation& evaluation, const Provenance& provenance,
                       const std::string& path);

}  // namespace pleat::app
