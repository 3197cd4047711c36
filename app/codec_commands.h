// What is done with drapes as textures: codec report, decode, regenerate.
#pragma once

#include <CLI/CLI.hpp>

namespace pleat::app {

// `result` receives the exit code. argv: of main.
void add_codec_commands(CLI::App& program, int& result, char** argv);

}  // namespace pleat::app
