// The stages of a study, in order. READ THIS FIRST: pipeline.cpp is the plan of the whole program.
#pragma once

#include <string>

#include "app/study.h"

namespace pleat::app {

enum class Stage { kDress, kSimulate, kEncode, kTrain, kSample, kEvaluate, kReport };

// The drapes that a study asks for.
campaign::Campaign campaign_of(const StudyConfig& study);

// Runs the stages up to and including `last`. A stage whose inputs have not changed since it
// finished is skipped; one that was interrupted goes on (clips that were under way
// start over). False where the user
// interrupted (Ctrl-C).
bool run_stages(const StudyConfig& study, Stage last);

}  // namespace pleat::app
