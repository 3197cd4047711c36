// The command line: one subcommand a stage.
#pragma once

#include "app/pipeline.h"

namespace pleat::app {

// The whole of `main`; returns the exit code. `learning`: empty where LibTorch is not there.
int run_program(int argc, char** argv, const LearnStages& learning);

}  // namespace pleat::app
