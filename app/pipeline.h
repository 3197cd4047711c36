// The stages of a study, in order. READ THIS FIRST: pipeline.cpp is the plan of the whole program.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "app/study.h"
#include "campaign/run_tasks.h"
#include "core/provenance.h"
#include "encode/drape_files.h"

namespace pleat::app {

enum class Stage { kDress, kSimulate, kEncode, kTrain, kSample, kEvaluate, kReport };

struct TrainSummary {
  int64_t steps, parameters;
  double validation_loss, design_error_mm;
};
// What needs LibTorch (learn/), handed in by the program that has it.
struct LearnStages {
  // G_design and the diffusion model of a dataset, into the folder `models`; nothing where
  // interrupted.
  std::function<std::optional<TrainSummary>(
      const StudyConfig& study, const std::string& dataset, const std::string& models,
      const Provenance& design_provenance, const Provenance& provenance)>
      train;
  // As in learn/sample.h.
  std::function<std::vector<int64_t>(const std::string& dataset, int split, int64_t count)>
      rows_of_split;
  std::function<bool(const std::string& checkpoint, const std::string& dataset,
                     const std::vector<int64_t>& rows, const learn::SampleConfig& config,
                     const std::string& output, const Provenance& provenance)>
      sample_textures;
};

// The drapes that a study asks for.
campaign::Campaign campaign_of(const StudyConfig& study);

campaign::RunOptions run_options_of(const StudyConfig& study);

// The files that the dataset of a study is made from.
encode::DatasetInputs dataset_inputs(const StudyConfig& study, const campaign::Manifest& manifest);

// Makes the output folder, with config.yaml and manifest.jsonl. InputError where it cannot.
void write_plan(const StudyConfig& study, const campaign::Campaign& campaign,
                const campaign::Manifest& manifest);

// Runs the stages up to and including `last`. A stage whose inputs have not changed since it
// finished is skipped; one that was interrupted goes on. False where the user interrupted (Ctrl-C).
// `slice`: of the chains, and no further than kSimulate where it is not all. InputError where a
// stage is asked for that `learning` lacks.
bool run_stages(const StudyConfig& study, Stage last, const campaign::TaskSlice& slice = {},
                const LearnStages& learning = {});

}  // namespace pleat::app
