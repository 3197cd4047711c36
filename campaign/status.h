// How far a campaign is, from its folder alone.
#pragma once

#include <map>
#include <string>
#include <vector>

namespace pleat::campaign {

struct Failure {  // a chain that came to nothing
  std::string key, motion, design, what;
};

struct Status {
  std::string folder;
  int chains = 0, done = 0, under_way = 0;
  std::vector<Failure> failures;
  int64_t frames = 0, accepted = 0, retried = 0;  // of chains that are done
  std::vector<std::string> unreadable;            // shards
  int64_t frames_under_way = 0;                   // in parts of the others
  std::map<std::string, int64_t> rejected;        // frames by reason
  double drape_seconds = 0;                       // processor time of the frames of both
};

// InputError where the folder holds no manifest.
Status status_of(const std::string& folder);
std::string to_text(const Status& status);  // for people, several lines
std::string to_json(const Status& status);

}  // namespace pleat::campaign
