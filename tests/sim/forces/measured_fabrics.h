// The measured fabrics that ship.
#pragma once

#include <algorithm>
#include <filesystem>
#include <map>
#include <string>

#include "garment/fabric.h"

namespace pleat::sim {

inline garment::Fabric measured_fabric(const std::string& name) {
  garment::FabricConfig config;
  config.name = name;
  garment::complete(config);
  return garment::middle_fabric(config);
}

inline const std::map<std::string, garment::Fabric>& measured_fabrics() {
  static const std::map<std::string, garment::Fabric> fabrics = [] {
    std::map<std::string, garment::Fabric> all;
    for (const auto& file :
         std::filesystem::directory_iterator(PLEAT_SOURCE_DIR "/configs/fabrics")) {
      const std::string name = file.path().stem().string();
      all.emplace(name, measured_fabric(name));
    }
    return all;
  }();
  return fabrics;
}

}  // namespace pleat::sim
