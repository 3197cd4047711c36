#pragma once

#include <string>

#include "core/provenance.h"
#include "evaluate/evaluate.h"

namespace pleat::evaluate {

// report.json: one table a split, one entry a row, the provenance. Numbers that were not measured
// are null, never NaN.
std::string report_json(const Evaluation& evaluation, const Provenance& provenance);
void write_report(const std::string& path, const Evaluation& evaluation,
                  const Provenance& provenance);

// A table of a few lines to print: a line a split.
std::string summary(const Evaluation& evaluation);

}  // namespace pleat::evaluate
