// The stages of a study, in order. READ THIS FIRST: pipeline.cpp is the plan of the whole program.
#pragma once

#include <string>

#include "app/study.h"
#include "campaign/run_tasks.h"

namespace pleat::app {

enum class Stage { kDress, kSimulate, kEncode, kTrain, kSample, kEvaluate, kReport };

// The drapes that a study asks for.
campaign::Campaign campaign_of(const StudyConfig& study);

campaign::RunOptions run_options_of(const StudyConfig& study);

// Makes the output folder, with config.yaml and manifest.jsonl. InputError where it cannot.
void write_plan(const StudyConfig& study, const campaign::Campaign& campaign,
                const campaign::Manifest& manifest);

// Runs the stages up to and including `last`. A stage whose inputs have not changed since it
// finished is skipped; one that was interrupted goes on. False where the user interrupted (Ctrl-C).
// `slice`: of the chains, and no further than kSimulate where it is not all.
bool run_stages(const StudyConfig& study, Stage last, const campaign::TaskSlice& slice = {});

}  // namespace pleat::app
