// The subcommands that look after a campaign: plan, simulate, status, check, verify, rerun, index.
#pragma once

#include <CLI/CLI.hpp>

namespace pleat::app {

// `result` receives the exit code. argv: of main.
void add_campaign_commands(CLI::App& program, int& result, char** argv);

}  // namespace pleat::app
