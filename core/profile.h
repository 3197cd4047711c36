// Which arithmetic the process does. Libraries choose their code by the processor, and other code
// rounds otherwise:
//   native    the fastest that this processor has
//   portable  OpenBLAS and the C library's functions held to what every x86-64 processor has, so
//             that the bits of a drape are the same on all of them
// Our own code is compiled for any x86-64 processor, without contraction, in both.
#pragma once

#include <string>

namespace pleat {

bool is_profile(const std::string& name);
std::string current_profile();
// Starts the program anew in the other profile, where it is not in this one; in the native one too
// where OpenBLAS has to be told what this processor can do. argv: of main.
void enter_profile(const std::string& name, char** argv);

}  // namespace pleat
