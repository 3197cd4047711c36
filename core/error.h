#pragma once

#include <stdexcept>

namespace pleat {

// The user's input is at fault. The message says where, what, and what would do:
//   tee_walk.yaml:14: fabric.thickness_m = -1; expected > 0
// The program prints it and exits with code 2.
class InputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// A computation came to nothing for what it was given, such as forces that are not finite. Chains
// leave the cloth as it was and reject the frame.
class SolverError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// The machine is at fault, for now: the disk is full, memory is short. The same command, given again
// once there is room, goes on. The program prints the message and exits with code 75, which batch
// systems take as "try again".
class ResourceError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace pleat
